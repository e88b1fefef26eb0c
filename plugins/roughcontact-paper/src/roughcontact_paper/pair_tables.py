"""Section 3.2 of the paper: areas of the synthetic pair on every grid, before and after running in."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.extrapolation import Extrapolation, exponential
from roughcontact.results import Residuals
from roughcontact.typing import Table

from roughcontact_paper import published
from roughcontact_paper.output import PaperTable
from roughcontact_paper.synthetic_pair import STEEL, coarsen

# The paper's loads, N, and its two pairs.
FORCES = (2.5, 5.0, 10.0)
STATES = ("before running in", "after running in")
# Counted area of the contact that Figure 13 shows, m2: about that of the paper's.
_LOCAL_AREA = 1.5e-12
# um2 in a m2.
_UM2 = 1e12


@attrs.frozen(eq=False, kw_only=True)
class PairCase:
    """One solve of a pair.

    Attributes
    ----------
    state, force, cells
        One of `STATES`, the load, N, and the cells along a side.
    counted
        Area of the cells in contact, m2.
    area, saturated
        Sub-grid area of the contact and of its saturated part.
    p_max
        Maximum pressure, Pa.
    patches
        Number of contact patches.
    seconds, residuals
        Wall time of the solve, and its residuals.
    pressure, edge
        The pressure, shape (cells, cells), Pa, and the edge as lines, each of shape (n, 2), m.
    """

    state: str
    force: float
    cells: int
    counted: float
    area: rc.Area
    saturated: rc.Area
    p_max: float
    patches: int
    seconds: float
    residuals: Residuals
    pressure: npt.NDArray[np.float64]
    edge: tuple[npt.NDArray[np.float64], ...]


def solve_pair(state: str, pair: rc.ContactProblem, force: float, cells: int) -> PairCase:
    """Solve a pair, scaled to `cells` x `cells` cells, at a force, N."""
    solution = coarsen(pair, cells).solve(force=force)
    return PairCase(
        state=state,
        force=force,
        cells=cells,
        counted=solution.area("cell-count").value,
        area=solution.area(),
        saturated=solution.saturated_area(),
        p_max=float(solution.pressure.max()),
        patches=solution.patches.count,
        seconds=solution.seconds,
        residuals=solution.residuals,
        pressure=solution.pressure,
        edge=tuple(rc.LevelSet().contours(solution)),
    )


def fit_counts(cases: Sequence[PairCase]) -> Extrapolation:
    """Return eq. 28 through the counted areas of one pair and load, um2."""
    return exponential([case.cells for case in cases], [_UM2 * case.counted for case in cases])


def select(cases: Sequence[PairCase], state: str, force: float) -> list[PairCase]:
    """Return the cases of one pair and load, from coarse to fine."""
    return [case for case in cases if (case.state, case.force) == (state, force)]


def local_contact(case: PairCase, size: float) -> tuple[float, float]:
    """Return where a small contact lies, (x, y) from the centre of the domain, m.

    It is the one of counted area closest to 1.5 um2 within the middle half of the domain.
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


def tabulate_pairs(cases: Sequence[PairCase]) -> tuple[PaperTable, ...]:
    """Return Table 4, the areas on every grid, and Table 5 beside the sub-grid areas."""
    return _material_table(), _grids_table(cases), _extrapolation_table(cases)


def _material_table() -> PaperTable:
    """Table 4: the printed properties of the steel, and those that are used."""
    used = (STEEL.young / 1e9, STEEL.poisson, STEEL.hardness / 1e9)
    rows = [
        (name, f"{printed:g}", f"{value:g}")
        for (name, printed), value in zip(published.STEEL.items(), used, strict=True)
    ]
    modulus = STEEL.young / (2 * (1 - STEEL.poisson**2)) / 1e9
    note = f"Both bodies: E* = {modulus:.2f} GPa; the hardness is the largest pressure."
    return PaperTable("table4", "Table 4: 52100 steel", Table.from_rows(("property", "printed", "used"), rows), (note,))


def _pair(state: str, force: float) -> str:
    return f"{state.split()[0]} {force:g}"


def _with_uncertainty(area: rc.Area, digits: int) -> str:
    percent = 100 * area.uncertainty / area.value
    return f"{_UM2 * area.value:.{digits}f} +-{percent:.{0 if percent >= 10 else 1}f}%"


def _grids_table(cases: Sequence[PairCase]) -> PaperTable:
    rows = [
        (
            _pair(case.state, case.force),
            f"{case.cells}",
            f"{_UM2 * case.counted:.1f}",
            _with_uncertainty(case.area, 1),
            f"{100 * (case.counted / case.area.value - 1):+.1f}",
            f"{_UM2 * case.saturated.value:.1f}",
            f"{case.p_max / 1e9:.2f}",
            f"{case.patches}",
        )
        for case in cases
    ]
    last = cases[-1]
    columns = ("pair, N", "cells", "counted", "sub-grid", "error %", "satur.", "p_max", "patches")
    title = "Figure 10 in numbers: areas of the synthetic pair, um2"
    notes = (
        "counted: cells in contact; error: of the counted area, against the sub-grid area of the same grid; satur.: "
        "saturated area; p_max in GPa; patches: connected parts of the contact.",
        "Coarse maps are scaled bilinearly from the finest one, which removes roughness.",
        f"The last of these solves took {last.seconds:.2g} s; its residuals: {last.residuals}.",
    )
    return PaperTable("pairs", title, Table.from_rows(columns, rows), notes)


def _extrapolation_table(cases: Sequence[PairCase]) -> PaperTable:
    rows = []
    warnings = []
    finest = max(case.cells for case in cases)
    for state in STATES:
        for force in FORCES:
            of_load = select(cases, state, force)
            extrapolated = fit_counts(of_load)
            last = of_load[-1]
            counted = _UM2 * last.counted
            area = _UM2 * last.area.value
            printed = published.PAIR_AREA.get((state, force))
            rows.append(
                (
                    _pair(state, force),
                    "-" if printed is None else f"{printed[0]:.0f}/{printed[1]:.0f}",
                    f"{counted:.0f}",
                    f"{100 * (counted / area - 1):+.1f}",
                    f"{extrapolated.value:.0f}",
                    f"{100 * (extrapolated.value / area - 1):+.1f}",
                    f"{100 * (counted / extrapolated.value - 1):+.1f}",
                    _with_uncertainty(last.area, 0),
                )
            )
            warnings.append(extrapolated.warnings)
    columns = ("pair, N", "printed", "count", "count err.%", "eq.28", "eq.28 err.%", "diff.%", "sub-grid")
    title = f"Table 5: areas on {finest} x {finest} cells, extrapolated and sub-grid, um2"
    notes = [
        "printed: count/eq. 28 on the paper's maps, which are not published. err.: error against the sub-grid area. "
        "diff.: count against eq. 28, the error that the paper states."
    ]
    unreliable = [found[0] for found in warnings if found]
    if unreliable:
        notes.append(f"{len(unreliable)} of {len(rows)} fits of eq. 28 are not reliable; the first: {unreliable[0]}.")
    return PaperTable("table5", title, Table.from_rows(columns, rows), tuple(notes), keys=1)
