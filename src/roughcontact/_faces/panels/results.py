"""Panels of a sweep, and the figures of a study, a law, a cycle, a path and an error report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import attrs
import numpy as np

from roughcontact._answers.laws import LawColumn, PowerFit
from roughcontact._base.arrays import Array
from roughcontact._base.tables import Table
from roughcontact._base.units import has_power, prefixed, si
from roughcontact._faces.panels.base import Panel
from roughcontact._faces.panels.curves import add_key, draw_band, scale_axes
from roughcontact._faces.panels.figures import loads_of, write_picture
from roughcontact._faces.panels.theme import apply_theme, require_matplotlib, style, theme_of
from roughcontact._solve.problem import AdhesionCycle, FrictionalPath, LoadPath, Sweep
from roughcontact._solve.solution import Estimate
from roughcontact._work.reports import ErrorReport, ReportRow, find_varying_parts, group_by_setup
from roughcontact._work.studies import StudyNames
from roughcontact.errors import InputError

# Minimum load over the maximum one, of the loads for which a unit is chosen.
_MIN_LOAD_RATIO = 1e-4
# Ratio of the ends of an axis of a study from which it is logarithmic.
_MIN_LOGARITHMIC_RATIO = 10.0
# Longest over shortest time or sliding distance of a path from which its axis is logarithmic.
_MIN_WIDE_RATIO = 100.0
# A component of the tangential force is drawn if it varies by more than this fraction of both.
_SHOWN_FRACTION = 1e-3
Box = tuple[float, float, float, float]  # left, lower, right and upper end, points
_MARKERS = "oDs^vP*X<>hp"
_DASHES = ("-", "--", "-.", ":")
_TITLES = {"area": "real contact area", "p_max": "maximum pressure", "approach": "approach"}
# An error is drawn no lower than the error bound of the reference, below which it tells nothing, or than 1e-7 %.
_MIN_DRAWN_ERROR = 1e-9
# Axes whose ends have a smaller ratio get ticks between the powers of ten.
_MAX_FINE_TICK_RATIO = 300.0
# Those whose ends have a smaller ratio get ticks at equal distances.
_MAX_EVEN_TICK_RATIO = 5.0
# Numbers with a smaller ratio are one and the same.
_MIN_AXIS_RATIO = 1.001
# Size of the numbers beside the points, points, and where they may stand: from the point, in points.
_NUMBER_POINTS = 7
_NUMBER_OFFSETS = ((5, 4), (5, -10), (-20, 4), (-20, -10))


def _scale_loads(sweep: Sweep) -> tuple[Array, str]:
    """Return the loads in the unit that suits them and a label."""
    loads, name, unit = loads_of(sweep)
    # The unit suits the middle of the range.
    factor, prefixed_unit = prefixed(
        float(np.sqrt(loads.max() * max(loads.min(), _MIN_LOAD_RATIO * loads.max()))), unit
    )
    return factor * loads, f"{name}, {prefixed_unit}"


def _draw(axes: Any, sweep: Sweep, estimates: list[tuple[float, float]], unit: str, name: str) -> None:
    """Draw values and standard deviations over the load, with logarithmic axes where both are positive."""
    loads, label = _scale_loads(sweep)
    values, deviations = np.array(estimates).T
    drawn = np.isfinite(values) & np.isfinite(loads)
    if not drawn.any():
        raise InputError(f"The {name} is not finite at any load, so that there is nothing to draw.")
    order = np.argsort(loads[drawn], kind="stable")
    x, y, spread = (column[drawn][order] for column in (loads, values, deviations))
    factor, prefixed_unit = prefixed(float(np.abs(y).max()), unit) if unit != "%" else (100.0, "% of nominal")
    positive = bool((x > 0.0).all() and (y > 0.0).all())
    scale_axes(axes, x=label, y=f"{name}, {prefixed_unit}", logarithmic="xy" if positive else "")
    draw_band(axes, x, factor * y, factor * spread)


@final
@attrs.frozen
class AreaLoadPanel(Panel):
    """The real contact area over the load."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        found = [solution.area() for solution in subject.states]
        nominal = subject.states[0].grid.area
        _draw(axes, subject, [(one.fraction, one.uncertainty / nominal) for one in found], "%", "contact area")


@final
@attrs.frozen
class StiffnessLoadPanel(Panel):
    """The normal stiffness over the load; infinite ones, of full contact, are not drawn."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        found = [solution.stiffness() for solution in subject.states]
        _draw(axes, subject, [(one.value, one.uncertainty) for one in found], "N/m", "stiffness")


@final
@attrs.frozen
class LoadApproachPanel(Panel):
    """The load over the approach, since the first touch of the summits between the cells."""

    subject = "sweep"

    def draw(self, subject: Any, axes: Any) -> None:
        found: list[Estimate] = [solution.response("approach") for solution in subject.states]
        loads, label = _scale_loads(subject)
        approach, deviation = (np.array([getattr(one, name) for one in found]) for name in ("value", "uncertainty"))
        factor, unit = prefixed(float(np.abs(approach).max()), "m")
        order = np.argsort(approach, kind="stable")
        x = factor * approach[order]
        y = loads[order]
        spread = factor * deviation[order]
        scale_axes(axes, x=f"approach since first touch, {unit}", y=label)
        line = draw_band(axes, x, y, np.zeros(y.size))
        axes.fill_betweenx(y, x - 2.0 * spread, x + 2.0 * spread, color=line.get_color(), alpha=0.25, linewidth=0.0)


def draw_cycle(cycle: AdhesionCycle, axes: Any, dark: bool = False) -> Any:
    """Draw the force of both branches over the approach, and the jumps; see `AdhesionCycle.plot`."""
    axes = _own_axes(axes, dark)
    branches = {"loading": cycle.loading, "unloading": cycle.unloading}
    force_factor, force_unit = prefixed(max(float(np.abs(one.force).max()) for one in branches.values()), "N")
    length_factor, length_unit = prefixed(float(np.abs(cycle.loading.approach).max()), "m")
    theme = theme_of(axes)
    with style(theme.is_dark):
        for name, sweep in branches.items():
            spread = np.zeros(len(sweep))
            draw_band(axes, length_factor * sweep.approach, force_factor * sweep.force, spread, label=name)
        label: str | None = "jump"
        for sweep, jumps in zip(branches.values(), cycle.jump_steps, strict=True):
            for step in np.flatnonzero(jumps):
                ends = slice(step, step + 2)
                x, y = length_factor * sweep.approach[ends], force_factor * sweep.force[ends]
                axes.plot(x, y, ":", color=theme.ink, linewidth=2.5, label=label)
                label = None
        axes.axhline(0.0, color=theme.ink, linewidth=0.5)
        scale_axes(axes, x=f"approach since first touch, {length_unit}", y=f"force, {force_unit}", logarithmic="")
        add_key(axes)
    return axes


def draw_loop(path: FrictionalPath, axes: Any, dark: bool = False) -> Any:
    """Draw the tangential force over the displacement; see `FrictionalPath.plot`."""
    axes = _own_axes(axes, dark)
    loop = path.drawn_loop
    force_factor, force_unit = prefixed(float(np.abs(loop.force).max()), "N")
    length_factor, length_unit = prefixed(float(np.abs(loop.displacement).max()), "m")
    theme = theme_of(axes)
    shown = [place for place in (0, 1) if np.ptp(loop.force[:, place]) > _SHOWN_FRACTION * np.ptp(loop.force)]
    with style(theme.is_dark):
        for place in shown:
            x = length_factor * loop.displacement[:, place]
            y = force_factor * loop.force[:, place]
            spread = 2.0 * length_factor * loop.uncertainty[:, place]
            line = draw_band(axes, x, y, np.zeros(y.size), label=f"along {'xy'[place]}")
            axes.fill_betweenx(y, x - spread, x + spread, color=line.get_color(), alpha=0.25, linewidth=0.0)
        axes.axhline(0.0, color=theme.ink, linewidth=0.5)
        scale_axes(axes, x=f"displacement, {length_unit}", y=f"tangential force, {force_unit}")
        if len(shown) > 1:
            add_key(axes)
    return axes


def draw_load_path(path: LoadPath, axes: Any, dark: bool = False) -> Any:
    """Draw the force over the approach, or the contact area over the sliding distance or time; see `LoadPath.plot`."""
    axes = _own_axes(axes, dark)
    passed = next(((name, values) for name in ("sliding", "time") if (values := getattr(path, name)).any()), None)
    with style(theme_of(axes).is_dark):
        if passed is None:
            _draw_loads(path, axes)
        else:
            _draw_areas(path, *passed, axes)
    return axes


def _draw_loads(path: LoadPath, axes: Any) -> None:
    """Draw the force over the approach, rising and falling loads apart."""
    states = [(state.approach, state.force) for state in path]
    # Surfaces that do not attract each other touch first without a force.
    points = np.array(states if path[0].tension is not None else [(0.0, 0.0), *states])
    factors, units = zip(
        *(prefixed(float(np.abs(points[:, place]).max()), "mN"[place]) for place in (0, 1)), strict=True
    )
    points = points * factors
    falls = np.diff(points[:, 1]) < 0.0
    colors = theme_of(axes).lines
    for name, chosen, line in (("loading", ~falls, "-"), ("unloading", falls, "--")):
        label = name
        for begin, end in _list_runs(chosen):
            x, y = points[begin : end + 1].T
            axes.plot(x, y, line, marker="o", color=colors[line == "--"], label=label)
            label = f"_{name} again"
    scale_axes(axes, x=f"approach since first touch, {units[0]}", y=f"force, {units[1]}")
    if falls.any():
        add_key(axes)


def _list_runs(chosen: Array) -> list[tuple[int, int]]:
    """Return begin and end of each run of true values, shape (n,)."""
    turns = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(int(begin), int(end)) for begin, end in turns.reshape(-1, 2)]


def _draw_areas(path: LoadPath, name: str, values: Array, axes: Any) -> None:
    """Draw the contact area over what passes."""
    percent = 100.0 / path[0].grid.area
    areas = [state.area() for state in path]
    shown, spread = (np.array([percent * getattr(area, of) for area in areas]) for of in ("value", "uncertainty"))
    draw_over_course(axes, name, values, shown, spread, "contact area, % of nominal")


def draw_over_course(axes: Any, name: str, values: Array, shown: Array, spread: Array, label: str) -> None:
    """Draw a number over what passes: where that spans decades, on a logarithmic axis beside its start."""
    words, base = {"sliding": ("sliding distance", "m"), "time": ("time", "s"), "state": ("state", "")}[name]
    factor, unit = prefixed(float(values.max()), base) if base else (1.0, "")
    later = values > 0.0
    is_wide = np.count_nonzero(later) > 2 and values.max() > _MIN_WIDE_RATIO * values[later].min()
    drawn = later if is_wide else np.full(values.shape, True)
    draw_band(axes, factor * values[drawn], shown[drawn], spread[drawn])
    if not drawn.all():
        axes.axhline(shown[~drawn][-1], linestyle="--", color=theme_of(axes).lines[0], label="at the start")
        add_key(axes)
    scale_axes(axes, x=label_axis(words, unit), y=label, logarithmic="x" if is_wide else "")


def draw_study(table: Table, names: StudyNames, axes: Any, dark: bool = False) -> Any:
    """Draw one column of a study over another one; see `StudyResult.plot`."""
    axes = _own_axes(axes, dark)
    x, y, spread = (numbers_of(table, name) for name in (names.x, names.y, names.spread))
    drawn = np.isfinite(x) & np.isfinite(y)
    if not drawn.any():
        raise InputError(f"No solve has both {names.x!r} and {names.y!r}, so that there is nothing to draw.")
    groups = table.columns[names.color] if names.color else [""] * x.size
    x_factor, x_unit = choose_unit(x[drawn], table.units.get(names.x, ""))
    y_factor, y_unit = choose_unit(y[drawn], table.units.get(names.y, ""))
    with style(theme_of(axes).is_dark):
        for group in dict.fromkeys(groups):
            of_group = drawn & np.array([one == group for one in groups])
            if not of_group.any():
                continue
            curve = _gather(x[of_group], y[of_group], spread[of_group], names)
            label = f"{names.color} {_name_value(group, table.units.get(names.color, ''))}" if names.color else ""
            draw_band(axes, x_factor * curve[0], y_factor * curve[1], y_factor * curve[2], label=label)
        ends = {"x": (x[drawn].min(), x[drawn].max()), "y": (y[drawn].min(), y[drawn].max())}
        wide = "".join(axis for axis, (low, high) in ends.items() if 0.0 < low <= high / _MIN_LOGARITHMIC_RATIO)
        scale_axes(axes, x=label_axis(names.x, x_unit), y=label_axis(names.y, y_unit), logarithmic=wide)
        if names.color:
            add_key(axes)
    return axes


def numbers_of(table: Table, name: str) -> Array:
    """Return a column as numbers, shape (n,), zero without a name; what is missing is NaN."""
    count = len(next(iter(table.columns.values())))
    if not name:
        return np.zeros(count)
    try:
        return np.array([np.nan if value is None else value for value in table.columns[name]], dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"The column {name!r} has no numbers: give it to color=, or another one.") from None


def choose_unit(values: Array, unit: str) -> tuple[float, str]:
    base, power = ("m", int(unit[1])) if unit in ("m2", "m3") else (unit, 1)
    if not base or has_power(base) or not values.size:
        return 1.0, unit
    factor, named = prefixed(float(np.sqrt(np.abs(values).max() * np.abs(values).min())), base, power)
    return factor, named.replace("m2", "m²").replace("m3", "m³")


def _name_value(value: object, unit: str) -> str:
    return si(float(value), unit) if isinstance(value, (int, float)) and unit else str(value)


def label_axis(name: str, unit: str) -> str:
    words = name.replace("_", " ")
    return f"{words}, {unit}" if unit else words


def _gather(x: Array, y: Array, spread: Array, names: StudyNames) -> tuple[Array, Array, Array]:
    """Return x, y and standard deviation of a curve, by x: the mean and the scatter over another axis."""
    places, where = np.unique(x, return_inverse=True)
    if not names.over:
        if places.size < x.size:
            raise InputError(
                f"Several solves have the same {names.x}: tell them apart by color=, or give over= the axis of which "
                "the mean is drawn."
            )
        order = np.argsort(x)
        return x[order], y[order], spread[order]
    count = np.bincount(where)
    mean = np.bincount(where, y) / count
    variance = np.bincount(where, (y - mean[where]) ** 2) / np.maximum(count - 1, 1)
    return places, mean, np.sqrt(variance)


def _own_axes(axes: Any, dark: bool) -> Any:
    """Return the given axes, or new ones."""
    require_matplotlib()
    from matplotlib import pyplot
    from matplotlib.axes import Axes

    if axes is None:
        with style(dark):
            axes = pyplot.subplots(layout="constrained")[1]
    if not isinstance(axes, Axes):
        raise InputError.about("The axes", axes, "an Axes of matplotlib, or None")
    return axes


def draw_column(pressures: Array, column: LawColumn, fit: PowerFit | None, axes: Any, dark: bool) -> Any:
    """Draw a column over the pressure; see `InterfaceLaw.plot`."""
    axes = _own_axes(axes, dark)
    values = column.values
    theme = theme_of(axes)
    shown = np.isfinite(values) & (values > 0.0)
    factor, unit = prefixed(float(np.sqrt(pressures.min() * pressures.max())), "Pa")
    name = column.name.replace("_", " ")
    with style(theme.is_dark):
        scale, named = _unit_of(column)
        spread = scale * column.uncertainties[shown]
        draw_band(axes, factor * pressures[shown], scale * values[shown], spread, label=name)
        if fit is not None:
            ends = np.array(fit.pressures)
            label = f"exponent {fit.exponent:.3f} ± {fit.exponent_std:.1g}"
            power = scale * fit.factor * (ends / fit.pivot) ** fit.exponent
            axes.plot(factor * ends, power, "--", color=theme.ink, zorder=3, label=label)
        # The mean gap falls with the logarithm of the pressure, the others rise with powers of it.
        scales = "x" if column.name == "mean_gap" else "xy"
        scale_axes(
            axes, x=f"nominal mean pressure, {unit}", y=f"{name}, {named}" if named else name, logarithmic=scales
        )
        add_key(axes)
    return axes


def draw_film_column(separations: Array, column: LawColumn, axes: Any, dark: bool) -> Any:
    """Draw a column over the separation; see `FilmLaw.plot`."""
    axes = _own_axes(axes, dark)
    with style(theme_of(axes).is_dark):
        # A pressure falls by powers of ten; its zeros are not shown.
        falls = column.name in ("asperity_pressure", "area")
        shown = column.values > 0.0 if falls and (column.values > 0.0).any() else np.ones(separations.shape, dtype=bool)
        x = separations[shown]
        values = column.values[shown]
        factor, unit = prefixed(float(np.abs(values).max()), column.unit) if column.unit else (1.0, "")
        line = draw_band(
            axes, x, factor * values, factor * column.uncertainties[shown], label=column.name.replace("_", " ")
        )
        if column.sampling is not None:
            spread = 2.0 * factor * column.sampling[shown]
            # On a logarithmic axis no bar may end below zero.
            low = np.minimum(spread, 0.95 * factor * values) if falls else spread
            axes.errorbar(
                x, factor * values, (low, spread), fmt="none", ecolor=line.get_color(), alpha=0.6, capsize=2.0
            )
        name = column.name.replace("_", " ")
        named = f"{name}, {unit}" if unit else f"{name}, fraction of nominal" if column.name == "area" else name
        scale_axes(axes, x="separation over Sq", y=named, logarithmic="y" if falls else "")
        add_key(axes)
    return axes


def _unit_of(column: LawColumn) -> tuple[float, str]:
    """Return the factor of the values of a column as drawn, and their unit."""
    if column.unit == "m":
        return prefixed(float(np.nanmax(column.values)), "m")
    if column.name == "area":
        return 1.0, "fraction of nominal"
    return 1.0, column.unit.replace("m2", "m²").replace("m3", "m³")


def draw_report(report: ErrorReport, path: Path) -> None:
    """Draw a panel for each quantity of the reference into a file; see `ErrorReport.draw`."""
    require_matplotlib()
    from matplotlib.figure import Figure

    names = report.reference.quantities
    with apply_theme():
        figure = Figure(figsize=(5.6 * len(names), 5.6), layout="constrained")
        known = figure.canvas.get_supported_filetypes()
        if path.suffix.removeprefix(".") not in known:
            raise InputError.about("The ending of a picture", path.suffix, f"one of {', '.join(sorted(known))}")
        for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
            draw_errors(axes, report, name)
        write_picture(figure, path, dpi=150)


def draw_errors(axes: Any, report: ErrorReport, quantity: str) -> None:
    """Draw the errors of ``"area"``, ``"p_max"`` or ``"approach"`` against CPU time."""
    axes.set_title(_TITLES[quantity])
    lines = _select_lines(report.rows, quantity)
    if not lines:
        axes.text(0.5, 0.5, "nothing to compare", ha="center", transform=axes.transAxes)
        return
    bound = report.reference.relative_uncertainty(quantity)
    parts = find_varying_parts(report.rows)
    estimators = list(dict.fromkeys(rows[0].estimator for rows in lines))
    setups = list(dict.fromkeys(rows[0].setup[:-1] for rows in lines))
    for rows in lines:
        setup = setups.index(rows[0].setup[:-1])
        # A colour for each estimator and a marker for each setup; a colour for each setup where one estimator is shown.
        single = quantity != "area" or len(estimators) == 1
        color = f"C{(setup if single else estimators.index(rows[0].estimator)) % 10}"
        label = rows[0].describe(parts)
        if quantity != "area":
            label = label.removeprefix(rows[0].estimator).removeprefix(", ") or rows[0].solver
        _draw_line(axes, rows, quantity, bound, color, setup, label)
    front = report.front(quantity)
    x = [row.cost(quantity) for row in front]
    y = [_height(row, quantity, bound) for row in front]
    axes.plot(x, y, color="0.8", linewidth=7, solid_capstyle="round", zorder=0, label="Pareto front")
    if bound > 0.0:
        label = "error bound of the reference"
        axes.axhline(100 * bound, color="0.4", linestyle="--", linewidth=1, label=label)
    _set_axes(axes)
    drawn = [row for line in lines for row in line]
    _write_numbers(axes, [(row.cost(quantity), _height(row, quantity, bound), row.shape[0]) for row in drawn])


def _write_numbers(axes: Any, points: Sequence[tuple[float, float, int]]) -> None:
    """Write the cells along x beside each point where there is room, so that no number covers another or a point."""
    pixel = axes.figure.dpi / 72
    places = axes.transData.transform([point[:2] for point in points]) / pixel
    taken = [(x - 3, y - 3, x + 3, y + 3) for x, y in places]
    for (x, y), (across, up, cells) in zip(places, points, strict=True):
        width = 0.65 * _NUMBER_POINTS * len(str(cells))
        for right, above in _NUMBER_OFFSETS:
            box = (x + right, y + above, x + right + width, y + above + _NUMBER_POINTS)
            if not any(_overlap(box, other) for other in taken):
                taken.append(box)
                axes.annotate(
                    str(cells),
                    (across, up),
                    (right, above),
                    textcoords="offset points",
                    fontsize=_NUMBER_POINTS,
                    color="0.3",
                )
                break


def _overlap(box: Box, other: Box) -> bool:
    return box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]


def _set_axes(axes: Any) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

    low, high = axes.dataLim.intervaly
    if not high > _MIN_AXIS_RATIO * low:
        # A single number, also one with its rounding, spans no axis.
        axes.set_ylim(0.5 * low, 2.0 * high)
    axes.set(xscale="log", yscale="log", xlabel="CPU time, s (beside the points: cells along x)", ylabel="error, %")
    axes.grid(True)
    axes.margins(x=0.12)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        logarithmic = LogLocator(subs=(1.0, 2.0, 5.0) if high < _MAX_FINE_TICK_RATIO * low else (1.0,), numticks=12)
        axis.set_major_locator(logarithmic if high > _MAX_EVEN_TICK_RATIO * low else MaxNLocator(5))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.legend(
        fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, handlelength=4, frameon=False
    )


def _select_lines(rows: Sequence[ReportRow], quantity: str) -> list[list[ReportRow]]:
    """Return the rows of each line; pressure and approach need no estimator, so its rows are taken once."""
    lines = group_by_setup([row for row in rows if quantity not in row.of_reference])
    if quantity == "area":
        return lines
    return list({line[0].setup[:-1]: line for line in reversed(lines)}.values())[::-1]


def _draw_line(
    axes: Any, rows: Sequence[ReportRow], quantity: str, bound: float, color: str, setup: int, label: str
) -> None:
    marker = _MARKERS[setup % len(_MARKERS)]
    dashes = _DASHES[setup % len(_DASHES)]
    x = [row.cost(quantity) for row in rows]
    y = [_height(row, quantity, bound) for row in rows]
    times = [row.timing(quantity) for row in rows]
    spread = [[time.median - time.minimum for time in times], [time.maximum - time.median for time in times]]
    axes.errorbar(x, y, xerr=spread, linewidth=1.2, linestyle=dashes, elinewidth=0.8, color=color)
    for across, up, row in zip(x, y, rows, strict=True):
        face = "white" if quantity in row.unresolved else color
        axes.plot(across, up, marker, markerfacecolor=face, color=color)
    axes.plot([], [], marker, linestyle=dashes, color=color, label=label)


def _height(row: ReportRow, quantity: str, bound: float) -> float:
    return 100 * max(row.error(quantity), bound, _MIN_DRAWN_ERROR)
