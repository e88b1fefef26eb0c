"""A law of an interface by solving at several loads, and its files for other programs."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.laws import formats
from roughcontact._answers.laws.columns import LawColumn, LawTable, interpolation_warning
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.checks import callback, flag
from roughcontact._base.machine.progress import count_done, show_progress, tell_both
from roughcontact._base.registry import find_view
from roughcontact._base.units import Pressure, counted, si
from roughcontact._parts.grid import FIRST_LOADING, Boundary, Load
from roughcontact._solve.problem import ContactProblem, run_solve, solve_from_largest
from roughcontact._solve.solution import ContactSolution, Estimate, Response, gather_warnings, read_number, responses
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Units of numbers in proportion to the nominal area, and their units per area.
_UNITS_PER_AREA = {"N/m": "Pa/m", "W/K": "W/(m2 K)", "S": "S/m2"}
_OWN_COLUMNS = ("pressure", "area", "mean_gap")
# Ratio of neighbouring loads up to which a straight line between them is within 1 % of powers of 1/3 to 1.
MAX_LOAD_RATIO = 1.6

Rows = dict[str, list[Estimate]]


@attrs.frozen(eq=False)
class InterfaceLaw(LawTable):
    """The properties of a nominally flat interface over the nominal mean pressure, and files of them.

    Attributes
    ----------
    pressures
        Nominal mean pressures, shape (loads,), Pa, ascending.
    columns
        The quantities by name: ``"area"``, the real over the nominal contact area; ``"mean_gap"``, m; and what was
        asked, over nominal area where it is in proportion to it.
    description
        What was solved, in sentences.
    warnings
        Why the law must not be trusted, in sentences with their loads; empty without a reason.
    """

    def __repr__(self) -> str:
        low, high = (si(float(pressure), "Pa") for pressure in self.pressures[[0, -1]])
        return f"<InterfaceLaw {counted(len(self.pressures), 'load')}, {low} to {high}: {', '.join(self.columns)}>"

    def to_abaqus(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str | None = "conductance",
        electrical: bool = False,
        units: str = "SI",
    ) -> None:
        """Write a surface interaction for Abaqus: pressure over closure and, if it is a column, the conductance.

        Include the file in the model data, ``*INCLUDE, INPUT=...``, and name the interaction in ``*CONTACT PAIR``.

        Parameters
        ----------
        path
            The file; it may replace one.
        name
            Name of the surface interaction.
        conductance
            Column of the conductance; None: none, as where the law does not have the column ``"conductance"``.
        electrical
            Whether it is an electrical one, of conductivities in S/m.
        units
            ``"SI"``, or ``"mm"``: mm, N, tonne, s, K, in which a pressure is in MPa.
        """
        write_lines(path, formats.write_abaqus(self, name, conductance, electrical, units))

    def to_ansys(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str = "conductance",
        units: str = "SI",
    ) -> None:
        """Write the thermal conductance over the contact pressure for Ansys, as commands of Mechanical APDL.

        They make a table and give it to the contact elements of the set of real constants ``cid``: read the file with
        ``/INPUT``, or paste it into a command object below a contact of Workbench.

        Parameters
        ----------
        path
            The file; it may replace one.
        name
            Name of the table.
        conductance
            Column of the conductance.
        units
            As of `to_abaqus`.
        """
        write_lines(path, formats.write_ansys(self, name, conductance, units))

    def to_calculix(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str | None = "conductance",
        units: str = "SI",
    ) -> None:
        """Write a surface interaction for CalculiX; include it before the first step. See `to_abaqus`.

        A row whose overclosure is less than 1e-10 above the one before is omitted: CalculiX would change it.
        """
        write_lines(path, formats.write_calculix(self, name, conductance, units))

    def to_comsol(
        self,
        path: str | os.PathLike[str],
        *,
        table: str = "conductance",
        conductance: str = "conductance",
        units: str = "SI",
    ) -> None:
        """Write a table for an interpolation function of COMSOL Multiphysics, in the spreadsheet format.

        Choose linear interpolation, and the units that the file states for argument and function.

        Parameters
        ----------
        path
            The file, such as ``.txt``; it may replace one.
        table
            ``"conductance"``: conductance over pressure; ``"closure"``: pressure over closure.
        conductance
            Column of the conductance.
        units
            As of `to_abaqus`.
        """
        write_lines(path, formats.write_comsol(self, table, conductance, units))

    def to_moose(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "rough",
        conductance: str = "conductance",
        min_gap: float = 1e-6,
        units: str = "SI",
    ) -> None:
        """Write the conductance for MOOSE: a table of a `PiecewiseLinear` function, and the blocks that read it.

        Parameters
        ----------
        path
            The table, ``.csv``; the blocks are written beside it with the ending ``.i``. Both may replace files.
        name
            Name of the function, and of the contact.
        conductance
            Column of the thermal conductance.
        min_gap
            Distance below which MOOSE counts the gap as closed, m.
        units
            As of `to_abaqus`.
        """
        target = checks.path(path, "The table")
        if target.suffix != ".csv":
            raise InputError.about("The table of MOOSE", str(target), "a file that ends in .csv")
        table, blocks = formats.write_moose(self, target.name, name, conductance, min_gap, units)
        write_lines(target, table)
        write_lines(target.with_suffix(".i"), blocks)

    def plot(self, column: str = "stiffness", axes: Any = None, *, dark: bool = False) -> Any:
        """Draw a column over the pressure with a band of two standard deviations, and its power law (extra ``plot``).

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
        return find_view("law")(self.pressures, self[column], self.fit(column), axes, checks.flag(dark, "dark="))


def write_lines(path: str | os.PathLike[str], lines: list[str]) -> None:
    """Write lines of ASCII to a file, completely or not at all."""
    with replacing(checks.path(path, "The file")) as partial:
        partial.write_text("\n".join([*lines, ""]), encoding="ascii", errors="replace", newline="\n")


@guarded
def interface_law(
    problem: ContactProblem,
    pressure: Iterable[Pressure],
    responses: Sequence[str | Response[Any]] | Mapping[str, str | Response[Any]] = ("stiffness",),
    *,
    on_load: Callable[[ContactSolution], None] | None = None,
    progress: bool = False,
) -> InterfaceLaw:
    """Return area, mean gap and responses of a periodic interface over the load, each with its uncertainty.

    Solved from the largest load down; no solution is kept. With a hardness each load is a first loading: for the law
    of surfaces that have been loaded before, give the problem that `run_in` returns.

    Parameters
    ----------
    problem
        The contact, on a periodic boundary: only there are mean gap, stiffness and conductance properties of the
        interface, per nominal area. A measured map repeats if it is mirrored at its borders.
    pressure
        Nominal mean pressures, Pa; best a geometric row with ratios of at most 1.6.
    responses
        Registered names or instances of responses, or a mapping from names of columns to these. Stiffness and
        conductance are divided by the nominal area. A conductance has the units of a thermal one; for conductivities in
        S/m the numbers are in S/m2.
    on_load
        Called with the solution at each load when its responses are found.
    progress
        Whether to show on standard error how far it has come (extra ``progress``).

    Raises
    ------
    InputError
        If the boundary is not periodic, a load is given twice or cannot be carried, or a response means nothing here.
    NotConverged
        If a solution is not certified.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> law = rc.interface_law(problem, pressure=[10e6, 20e6, 40e6])
    >>> [f"{pressure / 1e6:g} MPa" for pressure in law.pressures]
    ['10 MPa', '20 MPa', '40 MPa']
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem of a law", problem, "a ContactProblem")
    if problem.plan.interaction is not None:
        raise InputError(
            f"A law of an interface knows no tension: omit {argument('adhesion')}, or ask each state of problem.sweep."
        )
    if problem.remembers:
        raise InputError(
            "A law of an interface has one state for each load, but a law of the problem remembers: omit "
            f"{argument('laws')} or ask each state of problem.sweep."
        )
    if problem.boundary is not Boundary.PERIODIC:
        raise InputError(
            f"A law per area needs {argument('boundary', 'periodic')}, but got '{problem.boundary}': mean gap and "
            "stiffness of a cut-out depend on where it is cut. A map that does not repeat can be mirrored at its "
            "borders."
        )
    told = callback(on_load, "on_load=", "solution")
    asked = _name_columns(responses)
    loads = Load.sequence(pressure=pressure)
    values = sorted(load.value for load in loads)
    if len(set(values)) < len(values):
        raise InputError("A pressure is given twice: give each load of a law once.")
    problem.require_load(pressure=values[-1])
    with show_progress("law", shown=flag(progress, "progress=")) as change:
        tell = tell_both(told, count_done(change, len(values), "load"))
        rows, texts = _solve(problem, [Load("pressure", value) for value in values], asked, tell)
    columns = {name: _make_column(name, row, problem.plan.grid.area) for name, row in rows.items()}
    warnings = (
        *interpolation_warning(np.array(values), MAX_LOAD_RATIO),
        *gather_warnings([(si(load, "Pa"), found) for load, found in texts]),
    )
    return InterfaceLaw(np.array(values), columns, _describe(problem), warnings)


def _name_columns(chosen: object) -> dict[str, Response[Any]]:
    """Return the responses by the names of their columns."""
    what = "The responses"
    allowed = "a list of registered names or responses, or a mapping from names to them"
    try:
        items = tuple(chosen.items()) if isinstance(chosen, Mapping) else tuple((None, one) for one in chosen)  # type: ignore[attr-defined]
    # A class of the caller's may fail in any way.
    except Exception:
        items = None
    if items is None or isinstance(chosen, (str, bytes)):
        raise InputError.about(what, chosen, allowed)
    found: dict[str, Response[Any]] = {}
    for given, one in items:
        response = responses.resolve(one)
        name = given or (one if isinstance(one, str) else responses.name_of(type(one)) or type(one).__name__)
        if not isinstance(name, str) or name in found or name in _OWN_COLUMNS:
            hint = "Give a mapping from names of columns to responses."
            raise InputError.about("The name of a column", name, "a str that no other column has", hint)
        found[name] = response
    return found


def _solve(
    problem: ContactProblem,
    loads: list[Load],
    asked: dict[str, Response[Any]],
    tell: Callable[[ContactSolution], object],
) -> tuple[Rows, list[tuple[float, tuple[str, ...]]]]:
    """Return the estimates of each column and the warnings, in the order of the loads."""
    names = ("area", "mean_gap", *asked)
    found: dict[int, tuple[dict[str, Estimate], tuple[str, ...]]] = {}
    for index, solution in solve_from_largest(partial(run_solve, problem), loads):
        area = solution.area()
        nominal = solution.grid.area
        row = {
            "area": Estimate(area.fraction, area.uncertainty / nominal, "", area.warnings),
            "mean_gap": solution.response("mean-gap"),
        }
        row |= {name: read_number(solution.response(response), name) for name, response in asked.items()}
        named = (f"{name}: {text}" for name in asked for text in row[name].warnings if text not in area.warnings)
        # Warnings of the solution and of its area may share a rule: the words tell them apart.
        found[index] = row, tuple(dict.fromkeys(map(str, (*solution.warnings, *area.warnings, *named))))
        tell(solution)
    rows = {name: [found[index][0][name] for index in range(len(loads))] for name in names}
    return rows, [(load.value, found[index][1]) for index, load in enumerate(loads)]


def _make_column(name: str, row: list[Estimate], nominal: float) -> LawColumn:
    unit = row[0].unit
    scale = 1.0 / nominal if unit in _UNITS_PER_AREA else 1.0
    values, spread = (np.array([getattr(one, part) * scale for one in row]) for part in ("value", "uncertainty"))
    return LawColumn(name, _UNITS_PER_AREA.get(unit, unit), values, spread)


def _describe(problem: ContactProblem) -> tuple[str, ...]:
    """Return what was solved, in ASCII and plain numbers, for the comments of files."""
    return (
        "Law of a rough interface by roughcontact: all pressures are nominal, force over nominal area.",
        *describe_domain(problem),
    )


def describe_domain(problem: ContactProblem) -> tuple[str, ...]:
    """Return modulus, limit and domain of a periodic contact, in ASCII and plain numbers."""
    plan = problem.plan
    grid = plan.grid
    limit = float(np.min(plan.pressure_limit))
    capped = f"pressure limit {limit:g} Pa" if math.isfinite(limit) else "no pressure limit"
    size = " x ".join(f"{side:g}" for side in grid.size)
    cells = " x ".join(map(str, grid.shape))
    return (
        f"Contact modulus E* {plan.modulus:g} Pa, {capped}, periodic domain of {size} m with {cells} cells.",
        *([FIRST_LOADING] if math.isfinite(limit) else []),
    )
