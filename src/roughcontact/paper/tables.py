"""Tables 1 to 3 beside the print and beside the converged answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs

from roughcontact.extrapolation import Extrapolation, exponential, power_law
from roughcontact.paper import printed
from roughcontact.paper.scene import AMPLITUDE, MATERIAL, WAVELENGTH, Case
from roughcontact.reference import WavyContact


@attrs.frozen
class Table:
    """A table of text cells.

    Attributes
    ----------
    name
        File name without ending.
    title
        What it shows.
    columns
        Headings.
    rows
        One text for each heading.
    notes
        What to know about it.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


def all_tables(cases: Sequence[Case]) -> tuple[Table, ...]:
    """Return the three tables for the cases that were run."""
    return _pressure_table(cases), _area_table(cases), _extrapolation_table(cases)


def fits(cases: Sequence[Case], load: int) -> tuple[Extrapolation, Extrapolation]:
    """Return eq. 28 through all our areas, and the power law through those of the three finest grids."""
    cells, areas = zip(*((case.cells, case.area) for case in cases if case.load == load), strict=True)
    return exponential(cells, areas), power_law(cells[-3:], areas[-3:])


def remarks() -> tuple[str, ...]:
    """Say in words where the print is wrong."""
    wave = _wave()
    off = [100 * (100 * wave.light_area_fraction(1e6 * p) / printed.TRUE_AREA[p] - 1) for p in printed.LOADS]
    refit = [exponential(printed.GRIDS, printed.SAM_AREA[p]).value for p in printed.LOADS]
    words = ", ".join
    return (
        "The printed figures need E* = 219.78 GPa, that is 200 GPa / (1 - 0.3^2), not the printed 210 GPa.",
        "The 'analytical solution' (eq. 26, 27) is Hertz on one summit, the limit of light load; its areas are "
        f"off the converged ones by {words(f'{value:+.2f} %' for value in off)}.",
        "Equation 9 has its sign reversed, eq. 6 lacks a letter and mixes signs, eq. 22 lacks a factor of four, "
        "eq. 23 is upside down.",
        "Heights are sampled from border to border, so the wave that is solved is (N-1)/N too short.",
        "The convolution counts the nearest image only. With every image the maximum pressure changes by less "
        "than 0.1 %, but on a free boundary, as DC-FFT means it, the outer waves carry 9 to 20 % more.",
        f"Table 3 cannot be reproduced: eq. 28 through the printed Table 2 gives {words(f'{v:.3f}' for v in refit)} %, "
        f"not {words(f'{printed.EXTRAPOLATED_AREA[p]:.3f}' for p in printed.LOADS)} %. The excess of the count falls "
        "like a power of the cell size, not exponentially.",
        "Two errors in Table 2 are misprints: 0.787 against 0.713 is 10.4 %, not 8.5; 1.228 against 1.131 is 8.6, "
        "not 7.9. Some printed digits are cut off, not rounded.",
    )


def _pressure_table(cases: Sequence[Case]) -> Table:
    rows = tuple(
        (
            f"{case.load}",
            f"{case.cells}",
            f"{_printed(printed.SAM_P_MAX, case):g}",
            f"{case.p_max:.5g}",
            f"{_percent(case.p_max, _printed(printed.SAM_P_MAX, case)):+.3f}",
            f"{_percent(case.p_max, printed.TRUE_P_MAX[case.load]):+.2f}",
            f"{case.iterations}",
        )
        for case in cases
    )
    columns = ("load MPa", "N", "printed GPa", "ours GPa", "off print %", "off true %", "iter.")
    wave = _wave()
    note = _analytic("26", "GPa", printed.ANALYTIC_P_MAX, [wave.light_p_max(1e6 * p) / 1e9 for p in printed.LOADS])
    return Table("table1", "Table 1: maximum contact pressure", columns, rows, (note,))


def _area_table(cases: Sequence[Case]) -> Table:
    rows = tuple(
        (
            f"{case.load}",
            f"{case.cells}",
            f"{case.contact_cells}",
            f"{_printed(printed.SAM_AREA, case):.3f}",
            f"{case.area:.4f}",
            f"{printed.TRUE_AREA[case.load]:.4f}",
            f"{_percent(case.area, printed.TRUE_AREA[case.load]):+.1f}",
            f"{_percent(case.perimeter_area, printed.TRUE_AREA[case.load]):+.1f}",
        )
        for case in cases
    )
    columns = ("load MPa", "N", "cells", "printed %", "ours %", "true %", "off true %", "perim. off %")
    wave = _wave()
    note = _analytic("27", "%", printed.ANALYTIC_AREA, [100 * wave.light_area_fraction(1e6 * p) for p in printed.LOADS])
    return Table("table2", "Table 2: real contact area, % of nominal", columns, rows, (note,))


def _extrapolation_table(cases: Sequence[Case]) -> Table:
    rows, notes = [], []
    for load in printed.LOADS:
        true = printed.TRUE_AREA[load]
        decay, power = fits(cases, load)
        values = (printed.EXTRAPOLATED_AREA[load], decay.value, power.value)
        rows.append((f"{load}", *(f"{value:.3f} ({_percent(value, true):+.1f} %)" for value in values), f"{true:.4f}"))
        notes += [f"eq. 28 at {load} MPa is not to be trusted: {warning}" for warning in decay.warnings]
    columns = ("load MPa", "printed", "eq. 28, all grids", "power law, 3 finest", "true")
    title = "Table 3: extrapolated area, % of nominal (off true)"
    return Table("table3", title, columns, tuple(rows), tuple(notes))


def _wave() -> WavyContact:
    return WavyContact(AMPLITUDE, WAVELENGTH, 1.0 / MATERIAL.compliance)


def _analytic(equation: str, unit: str, print_: dict[int, float], ours: Sequence[float]) -> str:
    """Put the closed form beside its print."""
    pairs = (f"{value:.4g} (printed {print_[load]:g}) {unit}" for load, value in zip(printed.LOADS, ours, strict=True))
    return f"eq. {equation}, the limit of light load: {', '.join(pairs)}"


def _printed(table: Mapping[int, tuple[float, ...]], case: Case) -> float:
    return table[case.load][printed.GRIDS.index(case.cells)]


def _percent(value: float, reference: float) -> float:
    return 100.0 * (value / reference - 1.0)
