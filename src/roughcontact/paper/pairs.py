"""Section 3.2 of the paper on the stand-in: areas of the pair on every grid, before and after running in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from roughcontact.areas.contour import outline
from roughcontact.checks import Array
from roughcontact.extrapolation import Extrapolation, exponential
from roughcontact.paper.stand_in import scaled
from roughcontact.paper.tables import Table
from roughcontact.problem import ContactProblem
from roughcontact.solution import Area, Residuals

FORCES = (2.5, 5.0, 10.0)
STATES = ("before running in", "after running in")
# Table 5: area in um2, (counted on 2048 x 2048 cells, extrapolated).
PRINTED: Mapping[tuple[str, float], tuple[float, float]] = {
    ("before running in", 2.5): (540.1, 509.9),
    ("before running in", 5.0): (1126.2, 1063.1),
    ("after running in", 2.5): (613.9, 538.3),
    ("after running in", 5.0): (1262.4, 1086.9),
    ("after running in", 10.0): (2597.1, 2149.2),
}
# Area of the contact that Figure 13 shows, and its window, m2 and m.
_LOCAL_AREA = 1.5e-12
LOCAL_WINDOW = 6e-6
_UM2 = 1e12


@attrs.frozen(eq=False, kw_only=True)
class PairCase:
    """One solve of a pair.

    Attributes
    ----------
    state, force, cells
        Which pair, its load, N, and its cells along a side.
    counted
        Area of the cells in contact, m2.
    area, saturated
        Sub-grid area and saturated area.
    p_max
        Greatest pressure, Pa.
    contacts
        Number of contacts.
    seconds, residuals
        What the solve took (wall time), and its certificate.
    pressure, edge
        The pressure, shape (cells, cells), Pa, and the pieces of the edge, shape (n, 2, 2), m.
    """

    state: str
    force: float
    cells: int
    counted: float
    area: Area
    saturated: Area
    p_max: float
    contacts: int
    seconds: float
    residuals: Residuals
    pressure: Array
    edge: Array


def run_pair(state: str, pair: ContactProblem, force: float, cells: int) -> PairCase:
    """Solve a pair, scaled to `cells` x `cells` cells, at a force, N."""
    solution = scaled(pair, cells).solve(force=force)
    return PairCase(
        state=state,
        force=force,
        cells=cells,
        counted=solution.area("cell-count").value,
        area=solution.area(),
        saturated=solution.saturated_area(),
        p_max=float(solution.pressure.max()),
        contacts=solution.clusters.count,
        seconds=solution.seconds,
        residuals=solution.residuals,
        pressure=solution.pressure,
        edge=outline(solution),
    )


def fit(cases: Sequence[PairCase]) -> Extrapolation:
    """Return eq. 28 through the counted areas of one pair and load, um2."""
    return exponential([case.cells for case in cases], [_UM2 * case.counted for case in cases])


def chosen(cases: Sequence[PairCase], state: str, force: float) -> list[PairCase]:
    """Return the cases of one pair and load, from coarse to fine."""
    return [case for case in cases if (case.state, case.force) == (state, force)]


def local_contact(case: PairCase, size: float) -> tuple[float, float]:
    """Return where a small contact lies, (x, y) from the centre of the domain, m.

    It is the contact whose own counted area comes next to 1.5 um2, among those in the middle half.
    """
    from scipy import ndimage

    labels, count = ndimage.label(case.pressure > 0.0, structure=np.ones((3, 3)))
    spacing = size / case.cells
    index = np.arange(1, count + 1)
    areas = ndimage.sum_labels(np.ones(labels.shape), labels, index) * spacing**2
    centres = (np.array(ndimage.center_of_mass(labels > 0, labels, index)) + 0.5) * spacing - 0.5 * size
    outside = np.abs(centres).max(axis=1) > 0.25 * size
    best = int(np.argmin(np.abs(np.log(areas / _LOCAL_AREA)) + 1e3 * outside))
    return float(centres[best, 0]), float(centres[best, 1])


def pair_tables(cases: Sequence[PairCase]) -> tuple[Table, Table]:
    """Return the areas on every grid, and Table 5 with the sub-grid areas beside it."""
    return _grids_table(cases), _extrapolation_table(cases)


def _pair(state: str, force: float) -> str:
    return f"{state.split()[0]} {force:g}"


def _bar(area: Area, digits: int) -> str:
    share = 100 * area.uncertainty / area.value
    return f"{_UM2 * area.value:.{digits}f} ±{share:.{0 if share >= 10 else 1}f}%"


def _grids_table(cases: Sequence[PairCase]) -> Table:
    rows = tuple(
        (
            _pair(case.state, case.force),
            f"{case.cells}",
            f"{_UM2 * case.counted:.1f}",
            _bar(case.area, 1),
            f"{100 * (case.counted / case.area.value - 1):+.1f}",
            f"{_UM2 * case.saturated.value:.1f}",
            f"{case.p_max / 1e9:.2f}",
            f"{case.contacts}",
        )
        for case in cases
    )
    last = cases[-1]
    columns = ("pair, N", "cells", "counted", "sub-grid", "off %", "limit", "p_max", "spots")
    title = "Figure 10 in numbers: areas of the stand-in pair, um2"
    notes = (
        "counted: cells in contact; off: the count against the sub-grid area of the same grid; limit: area at the "
        "hardness; p_max in GPa.",
        "Coarse grids are scaled from the finest one bilinearly: they lack the roughness that scaling lost.",
        f"The last of these solves took {last.seconds:.2g} s; its residuals: {last.residuals}.",
    )
    return Table("pairs", title, columns, rows, notes)


def _extrapolation_table(cases: Sequence[PairCase]) -> Table:
    rows, misfits = [], []
    finest = max(case.cells for case in cases)
    for state in STATES:
        for force in FORCES:
            of_load = chosen(cases, state, force)
            extrapolated, last = fit(of_load), of_load[-1]
            counted, area = _UM2 * last.counted, _UM2 * last.area.value
            print_ = PRINTED.get((state, force))
            rows.append(
                (
                    _pair(state, force),
                    "-" if print_ is None else f"{print_[0]:.0f}/{print_[1]:.0f}",
                    f"{counted:.0f}",
                    f"{100 * (counted / area - 1):+.1f}",
                    f"{extrapolated.value:.0f}",
                    f"{100 * (extrapolated.value / area - 1):+.1f}",
                    f"{100 * (counted / extrapolated.value - 1):+.1f}",
                    _bar(last.area, 0),
                )
            )
            misfits.append(extrapolated.warnings)
    columns = ("pair, N", "print", "count", "off %", "eq.28", "off %", "diff.%", "sub-grid")
    title = f"Table 5: areas on {finest} x {finest} cells, extrapolated and sub-grid, um2"
    notes = [
        "print: count/eq. 28 on the paper's own maps, which are not published. off: count, and eq. 28, "
        "against the sub-grid area. diff.: count against eq. 28, the paper's error."
    ]
    doubted = sum(1 for warnings in misfits if warnings)
    if doubted:
        notes.append(
            f"{doubted} of {len(rows)} fits of eq. 28 say themselves that they must not be trusted, such as: "
            f"{next(warnings[0] for warnings in misfits if warnings)}."
        )
    return Table("table5", title, columns, tuple(rows), tuple(notes))
