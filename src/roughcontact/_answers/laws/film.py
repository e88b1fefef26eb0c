"""The law of a lubricated interface over the separation: flow factors, asperity pressure and contact area."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.laws.columns import ColumnTable, LawColumn
from roughcontact._answers.laws.film_fits import FilmFit, fit_peklenik, fit_pressure
from roughcontact._answers.laws.film_formats import tabulate_column, write_comsol, write_json
from roughcontact._answers.laws.film_plan import list_quarters, read_separations, require_pair
from roughcontact._answers.laws.film_rows import FilmRow, count_waves, find_wall_shear, solve_rows
from roughcontact._answers.laws.law import describe_domain, write_lines
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.checks import callback, choice, flag
from roughcontact._base.machine.progress import count_done, show_progress
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table
from roughcontact._base.units import WarningText, counted, si
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solution import gather_warnings, measure_depth
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded

_MODELS = ("greenwood-tripp", "persson", "patir-cheng")
# Components of the tensors, by the names of their columns.
_COMPONENTS = {"xx": (0, 0), "xy": (0, 1), "yx": (1, 0), "yy": (1, 1)}
_SHEAR_NAMES = tuple(f"phi_s_{component}" for component in _COMPONENTS)
# Columns that a text shows.
_SHOWN = ("asperity_pressure", "area", "phi_xx", "phi_yy", "phi_s_xx", "phi_s_yy")
# Mean number of waves along a side below which the domain is too short: that of four longest ones without a lay.
_MIN_WAVES = 2.5
# A wall counts as smooth if its rms height is below this fraction of the other's.
_SMOOTH = 1e-6
# After Student's distribution: four quarters tell the scatter of a tensor to a third, and deviations are to be within
# two of it as often as of one that is known. That of pressure and area the joints of the quarters raise enough.
_STUDENT = 1.4
# Weight of the uncertainty of the pressure: its errors at small separations are systematic.
_PRESSURE_WEIGHT = 1.3
# Depth of the mean plane over Sq from which a tip is warned of; columns that fall nearly as exponentials, and the
# largest power of them that counts.
_MAX_DEPTH = 0.05
_OF_LOAD = frozenset({"asperity_pressure", "area"})
_MAX_FALL = 3.0
# Relative change of a flow factor over that of the separation where deeper grooves lie along the flow.
_ALONG_GROOVES = 1.0
_FLOW = frozenset({"phi_xx", "phi_yy", "phi_xy", "phi_fp_xy", "phi_fp_yx"})
_NO_SHEAR = (
    "The columns phi_s are omitted: at some of these separations two rough walls touch, or one alone would, and their "
    "shear flow factors then change while they slide: take larger separations, or one smooth wall."
)


@attrs.frozen(eq=False)
class FilmLaw(ColumnTable):
    r"""Flow factors and asperity pressure of a rough pair over the separation of its mean planes.

    For the averaged Reynolds' equation,

    .. math:: q = -\frac{h^3}{12 \eta} \phi \nabla p + \frac{U_1 + U_2}{2} h_T + \frac{U_1 - U_2}{2} S_q \phi_s

    with body 1 and counterbody 2, the separation h, and the film h_T.

    Attributes
    ----------
    separations
        Distance of the mean planes, the mean gap of elastic contact, over Sq, shape (rows,), ascending.
    rms_height
        Sq of the pair, m: of the sum of both heights.
    rms_heights
        Sq of the body and of the counterbody, m.
    columns
        ``asperity_pressure``, Pa; ``area``, real over nominal contact area; ``mean_gap``, h_T, m; ``contact_factor``,
        its change over that of h; ``phi_xx`` ...; ``phi_s_xx`` ..., of sliding along the first axis and flow along the
        second; ``phi_fp_xx`` ..., the film-averaged viscous factors of a pressure gradient along the first axis.
    modulus
        The contact modulus, Pa.
    description
        What was solved, in sentences.
    warnings
        Why the law must not be trusted, in sentences with their separations; empty without a reason.
    """

    separations: Array = attrs.field(converter=read_only)
    rms_height: float
    rms_heights: Pair
    columns: Mapping[str, LawColumn]
    modulus: float
    description: tuple[str, ...]
    warnings: tuple[str, ...]

    def _list_rows(self) -> Mapping[str, tuple[str, Array]]:
        return {"separation_over_sq": ("", self.separations), "separation": ("m", self.separations * self.rms_height)}

    def __getitem__(self, name: str) -> LawColumn:
        if name in _SHEAR_NAMES and name not in self.columns:
            raise InputError(_NO_SHEAR)
        return super().__getitem__(name)

    def __repr__(self) -> str:
        low, high = self.separations[[0, -1]]
        return f"<FilmLaw {counted(len(self.separations), 'separation')}, {low:g} to {high:g} Sq>"

    def fit(self, model: str) -> FilmFit:
        """Return the constants of a model that is nearest to the columns; they are drawn beside, never used.

        Parameters
        ----------
        model
            ``"greenwood-tripp"``: p = factor E* F_5/2((H - offset) / sigma); ``"persson"``: p = factor E*
            exp(-H / decay); ``"patir-cheng"``: the Peklenik number of their pressure flow factors, from H = 1.5 on.

        Raises
        ------
        InputError
            If there are too few separations.

        References
        ----------
        Greenwood and Tripp, Proc. Inst. Mech. Eng. 185 (1971) 625-633;
        Persson, Phys. Rev. Lett. 99 (2007) 125502, https://doi.org/10.1103/PhysRevLett.99.125502;
        Patir and Cheng, J. Lubr. Technol. 100 (1978) 12-17, https://doi.org/10.1115/1.3453103
        """
        model = choice(model, "The model", _MODELS)
        if model == "patir-cheng":
            return fit_peklenik(self.separations, self["phi_xx"].values, self["phi_yy"].values)
        return fit_pressure(model, self.separations, self["asperity_pressure"], self.modulus)

    def plot(self, column: str = "phi_xx", axes: Any = None, *, dark: bool = False) -> Any:
        """Draw a column over the separation (extra ``plot``).

        A band shows two standard deviations by the grid, bars those of other places.

        Parameters
        ----------
        column
            Name of the column.
        axes
            Matplotlib's axes to draw on; None: new ones.
        dark
            Whether new axes are for a dark page.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return find_view("film")(self.separations, self[column], axes, flag(dark, "dark="))

    def to_text(self, path: str | os.PathLike[str], column: str, *, units: str = "SI") -> None:
        """Write two plain columns below one line of names: the separation and a column.

        Parameters
        ----------
        path
            The file; it may replace one.
        column
            Name of the column.
        units
            ``"SI"``, or ``"mm"``: mm and MPa.
        """
        write_lines(path, tabulate_column(self, self._lengths, column, units))

    def to_comsol(
        self, path: str | os.PathLike[str], *, columns: Iterable[str] | None = None, units: str = "SI"
    ) -> None:
        """Write an interpolation function of several values for COMSOL Multiphysics, in the spreadsheet format.

        Parameters
        ----------
        path
            The file, such as ``.txt``; it may replace one.
        columns
            Names of the columns; None: all.
        units
            As of `to_text`.
        """
        write_lines(path, write_comsol(self, self._lengths, columns, units))

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write all columns with their uncertainties, and the description, as one JSON object in SI units."""
        write_lines(path, self.list_json())

    def list_json(self) -> list[str]:
        """Return the lines of `to_json`."""
        return write_json(self, self._lengths, self.rms_heights)

    @property
    def _lengths(self) -> Array:
        return np.asarray(self.separations * self.rms_height)

    def short_table(self) -> Table:
        """Return the columns that a reader looks at first, with the uncertainties by the grid."""
        whole = self.table()
        shown = ("separation_over_sq", *(name for name in _SHOWN if name in self.columns))
        return Table({name: whole.columns[name] for name in shown}, whole.units)

    def _list_results(self) -> Mapping[str, str]:
        texts = {}
        middle = len(self.separations) // 2
        for name in _SHOWN:
            column = self.columns.get(name)
            if column is not None and column.sampling is not None:
                texts[name] = si(float(column.sampling[middle]), column.unit, 2)
        if not texts:
            return {}
        found = ", ".join(f"{name} {text}" for name, text in texts.items())
        return {"other places": f"at {self.separations[middle]:g} Sq they differ by (one std) {found}"}

    def _list_notes(self) -> Sequence[str]:
        found = []
        for model in _MODELS:
            try:
                found.append(str(self.fit(model)))
            except InputError:
                continue
        return found


@guarded
def film_law(
    problem: ContactProblem,
    separation: Iterable[float],
    *,
    sampling: bool = True,
    progress: bool = False,
    on_row: Callable[[int, int], object] | None = None,
) -> FilmLaw:
    r"""Return flow factors, asperity pressure and contact area of a periodic pair over the separation.

    The cells of the deformed gap g carry :math:`\nabla \cdot g^3 (e_i + \nabla \chi_i) = 0`, of which
    :math:`h^3 \phi_{ij} = \langle g^3 (e_i + \nabla \chi_i)_j \rangle` and
    :math:`S_q \phi_{s,ij} = h \delta_{ij} - \langle g (e_j + \nabla \chi_j)_i \rangle`, for a rough body on a smooth
    counterbody; of a rough counterbody it is the opposite. Of two rough walls that do not touch it is that of the body
    alone less that of the counterbody alone. A shear stress factor h <1/g> is not given: it diverges once walls touch.

    Parameters
    ----------
    problem
        The contact, on a periodic boundary. A measured map repeats if it is mirrored at its borders, which turns no
        lay only where that is along an axis.
    separation
        Distances of the mean planes over Sq of the pair, two or more, such as 0.5, 0.75, ... 4.
    sampling
        Whether to find how much other places of a random surface differ, from its four quarters: it is larger than
        the uncertainty by the grid, and costs as much again.
    progress
        Whether to show on standard error how far it has come (extra ``progress``).
    on_row
        Called after each separation, of the map and of its quarters, with the number of those solved and of all.

    Raises
    ------
    InputError
        If the boundary is not periodic, surfaces attract each other or remember, points are not measured, or a
        separation is not a number above zero or given twice.
    NotConverged
        If a solution is not certified.

    References
    ----------
    Patir and Cheng, J. Lubr. Technol. 100 (1978) 12-17, https://doi.org/10.1115/1.3453103, and 101 (1979) 220-230

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 50e-6), boundary="periodic")
    >>> law = rc.film_law(problem, [1.5, 3.0])
    >>> [f"{value:.2f}" for value in law["phi_xx"].values]
    ['0.77', '0.88']
    """
    require_pair(problem)
    wanted = read_separations(separation)
    told = callback(on_row, "on_row=", "done", "total")
    grid = problem.plan.grid
    heights = [body.heights(grid) for body in (problem.body, problem.counterbody)]
    rms = (float(np.std(heights[0])), float(np.std(heights[1])))
    together = float(np.std(problem.initial_gap))
    lengths = [one * together for one in wanted]
    quarters = list_quarters(problem, sampling)
    total = len(wanted) * (1 + len(quarters))
    done = 0
    with show_progress("film", shown=flag(progress, "progress=")) as change:
        count = count_done(change, total, "separation")

        def tell() -> None:
            nonlocal done
            done += 1
            count(None)
            if told is not None:
                told(done, total)

        rows = solve_rows(problem, lengths, tell)
        parts = [solve_rows(quarter, lengths, tell) for quarter in quarters]
    signs = _find_signs(rms)
    columns = _make_columns(rows, np.array(lengths), together, parts)
    columns |= _make_shear(problem, heights, signs, rows, lengths, together, parts)
    depth = _find_depth(problem)
    columns = _widen_by_depth(columns, np.array(lengths), together, depth)
    names = [f"{one:g} Sq" for one in wanted]
    warnings = [
        *_judge_domain(problem),
        *([_NO_SHEAR] if "phi_s_xx" not in columns else []),
        *_judge_depth(depth, together),
        *gather_warnings([(name, row.texts) for name, row in zip(names, rows, strict=True)]),
    ]
    description = _describe(problem, together, rms)
    return FilmLaw(np.array(wanted), together, rms, columns, problem.plan.modulus, description, tuple(warnings))


def _find_signs(rms: Pair) -> tuple[float, float]:
    """Return the sign with which each wall drags: 1 for the body, -1 for the counterbody, 0 for a smooth wall."""
    limit = _SMOOTH * max(rms)
    return (1.0 if rms[0] > limit else 0.0, -1.0 if rms[1] > limit else 0.0)


def _make_columns(
    rows: Sequence[FilmRow], lengths: Array, rms: float, parts: Sequence[Sequence[FilmRow]]
) -> dict[str, LawColumn]:
    """Return all columns but those of the shear flow factors."""

    def gather(name: str, of: Sequence[FilmRow] = rows) -> Array:
        return np.array([getattr(row, name) for row in of])

    def sample(name: str) -> Array | None:
        return _find_scatter([gather(name, part) for part in parts])

    pressure, area, film = (gather(name) for name in ("pressure", "area", "film"))
    gap_std = gather("gap_std")
    area_std = gather("area_std")
    # An error of the edge is one of the load, too, nearly in proportion.
    edge = pressure * area_std / np.where(area > 0.0, area, 1.0)
    pressure_std = _PRESSURE_WEIGHT * np.hypot(_find_slope(pressure, lengths, rms) * gap_std, edge)
    area_std = np.hypot(area_std, _find_slope(area, lengths, rms) * gap_std)
    change = np.gradient(film, lengths)
    change_std = 2.0 * gather("film_std") / np.min(np.diff(lengths))
    columns = [
        LawColumn("asperity_pressure", "Pa", pressure, pressure_std, sample("pressure")),
        LawColumn("area", "", area, area_std, sample("area")),
        LawColumn("mean_gap", "m", film, gather("film_std")),
        LawColumn("contact_factor", "", change, change_std),
    ]
    for name, key, kept in (("phi", "pressure", ("xx", "yy", "xy")), ("phi_fp", "viscous", tuple(_COMPONENTS))):
        for component in kept:
            columns.append(_make_component(name, key, component, rows, parts))
    return {column.name: column for column in columns}


def _make_component(
    name: str,
    key: str,
    component: str,
    rows: Sequence[FilmRow],
    parts: Sequence[Sequence[FilmRow]],
    scale: float = 1.0,
) -> LawColumn:
    """Return the column of a component of a tensor of the rows, times a scale."""
    place = _COMPONENTS[component]

    def gather(of: Sequence[FilmRow], end: str = "") -> Array:
        return scale * np.array([getattr(row.factors, f"{key}{end}") for row in of])

    scatter = _find_scatter([gather(part) for part in parts])
    if scatter is not None:
        # Off the diagonal that of both axes stands beside its own: of isotropic roughness it is half as large.
        floor = 0.0 if place[0] == place[1] else 0.5 * np.sqrt(scatter[:, 0, 0] * scatter[:, 1, 1])
        scatter = _STUDENT * np.maximum(scatter[:, place[0], place[1]], floor)
    values, stds = (gather(rows, end)[:, place[0], place[1]] for end in ("", "_std"))
    return LawColumn(f"{name}_{component}", "", values, np.abs(stds), scatter)


def _make_shear(
    problem: ContactProblem,
    heights: Sequence[Array],
    signs: tuple[float, float],
    rows: Sequence[FilmRow],
    lengths: Sequence[float],
    rms: float,
    parts: Sequence[Sequence[FilmRow]],
) -> dict[str, LawColumn]:
    """Return the columns of the shear flow factors; none if they are not known."""
    if 0.0 in signs:
        columns = [
            _make_component("phi_s", "shear", component, rows, parts, sum(signs) / rms) for component in _COMPONENTS
        ]
        return {column.name: column for column in columns}
    if any(row.pressure > 0.0 for row in rows):
        return {}
    walls = [[find_wall_shear(one, length, problem) for length in lengths] for one in heights]
    pairs = [(one, other) for one, other in zip(*walls, strict=True) if one is not None and other is not None]
    if len(pairs) < len(lengths):
        return {}
    found = {}
    for component, place in _COMPONENTS.items():
        values = np.array([one.shear[place] - other.shear[place] for one, other in pairs]) / rms
        stds = np.array([math.hypot(one.shear_std[place], other.shear_std[place]) for one, other in pairs]) / rms
        found[f"phi_s_{component}"] = LawColumn(f"phi_s_{component}", "", values, stds)
    return found


def _find_depth(problem: ContactProblem) -> float:
    """Return the standard deviation of the depth of the mean plane below that of maps restored below a tip, m."""
    grid = problem.plan.grid
    masks = [mask for body in (problem.body, problem.counterbody) if (mask := body.uncertain(grid)) is not None]
    return measure_depth(-problem.initial_gap, np.logical_or.reduce(masks), grid) if masks else 0.0


def _widen_by_depth(columns: dict[str, LawColumn], lengths: Array, rms: float, depth: float) -> dict[str, LawColumn]:
    """Return the columns with an uncertainty of the separation in theirs.

    Deeper valleys move the mean plane, and the film with it, at the same load; the flow grows as much, or more where
    it is along grooves. What a wall drags is what the viscous factor lacks, phi_s = (1 - phi_fp) h / Sq.
    """
    if depth == 0.0:
        return columns

    def find_std(name: str) -> Array:
        if name.startswith("phi_s_"):
            return find_std(f"phi_fp_{name[:-3:-1]}") * lengths / rms
        values = columns[name].values
        if name in _OF_LOAD:
            # They fall nearly as exponentials, so that large changes are not in proportion.
            falls = _find_slope(values, lengths, rms) / np.where(values > 0.0, values, 1.0)
            return np.asarray(values * np.expm1(np.minimum(falls * depth, _MAX_FALL)))
        change = np.gradient(values - (lengths if name == "mean_gap" else 0.0), lengths)
        along = _ALONG_GROOVES * values / lengths if name in _FLOW else 0.0
        return np.asarray(np.hypot(change, along) * depth)

    return {
        name: attrs.evolve(column, uncertainties=np.hypot(column.uncertainties, find_std(name)))
        for name, column in columns.items()
    }


def _judge_depth(depth: float, rms: float) -> list[str]:
    """Return a warning if the tip of a stylus has not reached the valleys."""
    if depth <= _MAX_DEPTH * rms:
        return []
    text = (
        f"Below the tip of the stylus the mean plane may lie {si(depth, 'm', 2)} (one standard deviation) lower than "
        "that of the map. The uncertainties count that as one of the separation, for valleys as sharp as the summits: "
        "measure with a sharper tip."
    )
    return [WarningText(text, "stylus valleys", depth / rms)]


def _find_slope(values: Array, lengths: Array, rms: float) -> Array:
    """Return the size of the change of values over the separation: they fall nearly as exponentials."""
    carries = values > 0.0
    slope = np.zeros(values.shape)
    if np.count_nonzero(carries) > 1:
        slope[carries] = values[carries] * np.abs(np.gradient(np.log(values[carries]), lengths[carries]))
    else:
        slope[carries] = values[carries] / rms
    return slope


def _find_scatter(quarters: Sequence[Array]) -> Array | None:
    """Return the standard deviation of a place as large as four quarters; None without them."""
    return 0.5 * np.std(quarters, axis=0, ddof=1) if quarters else None


def _judge_domain(problem: ContactProblem) -> list[str]:
    """Return a warning if few waves fit into the domain along an axis."""
    if not any(body.surface.is_random for body in (problem.body, problem.counterbody)):
        return []
    waves = count_waves(problem.initial_gap)
    return [
        f"Along {name} only {count:.2g} waves fit into the domain on average: grooves that never end let too much flow "
        f"along it, too little across. Take {_MIN_WAVES:g} or more, by a domain longer along the lay."
        for name, count in zip("xy", waves, strict=True)
        if count < _MIN_WAVES
    ]


def _describe(problem: ContactProblem, together: float, rms: Pair) -> tuple[str, ...]:
    """Return what was solved, in ASCII and plain numbers, for the comments of files."""
    return (
        "Film law of a rough interface by roughcontact: the separation is the distance of the mean planes after "
        "deformation, phi counts on its cube; phi_s is above 0 for a rough body 1 that moves on a smooth one.",
        f"Sq {together:g} m, of the body {rms[0]:g} m, of the counterbody {rms[1]:g} m.",
        *describe_domain(problem),
    )
