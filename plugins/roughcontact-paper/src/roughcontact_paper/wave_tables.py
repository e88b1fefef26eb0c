"""Tables 1 to 3, beside the printed and the converged values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from roughcontact.extrapolation import Extrapolation, exponential, power_law
from roughcontact.reference import WavyContact
from roughcontact.typing import Table

from roughcontact_paper import published
from roughcontact_paper.output import PaperTable
from roughcontact_paper.wave import AMPLITUDE, MATERIAL, WAVELENGTH, WaveCase

_ERRORS = "error: magnitude against the analytic value, as printed and ours; true error: against the converged values"
_TIMES = "CPU s: of the solve with its kernel, to contact conditions of 1e-5"


def tabulate_waves(cases: Sequence[WaveCase]) -> tuple[PaperTable, ...]:
    """Return Tables 1 to 3 of the cases that were solved."""
    return _sam_table(cases, 1), _sam_table(cases, 2), _extrapolation_table(cases)


def fit_areas(cases: Sequence[WaveCase], load: int) -> tuple[Extrapolation, Extrapolation]:
    """Return eq. 28 through all counted areas, and a power law through those of the three finest grids."""
    cells, areas = zip(*((case.cells, case.area) for case in cases if case.load == load), strict=True)
    return exponential(cells, areas), power_law(cells[-3:], areas[-3:])


def remarks() -> tuple[str, ...]:
    """Return sentences on what is wrong in the print."""
    errors = [_percent(_closed_form(load)[1], published.TRUE_AREA[load]) for load in published.LOADS]
    fitted = [exponential(published.GRIDS, published.SAM_AREA[p]).value for p in published.LOADS]
    join = ", ".join
    return (
        "The printed values follow from E* = 219.78 GPa = 200 GPa / (1 - 0.3^2), not from the printed 210 GPa.",
        "The 'analytical solution' (eq. 26, 27) is that of Hertz for one summit, the limit of light load; its areas "
        f"differ from the converged ones by {join(f'{value:+.2f} %' for value in errors)}.",
        "Equation 6 lacks the l of one 'ln' and is else Love's solution; eq. 9 has the wrong sign, eq. 22 lacks a "
        "factor of four, eq. 23 is inverted.",
        "Heights are sampled from border to border, so the wave that is solved is shorter by a factor of (N-1)/N.",
        "The convolution includes the nearest image only. All images change the maximum pressure by less than "
        "0.1 %; on a free boundary, which the DC-FFT implies, the outer waves carry 9 to 20 % more.",
        f"Table 3 cannot be reproduced: eq. 28 through the printed Table 2 gives {join(f'{v:.3f}' for v in fitted)} %, "
        f"not {join(f'{published.EXTRAPOLATED_AREA[p]:.3f}' for p in published.LOADS)} %. "
        "The excess of the counted area falls like a power of the cell size, not exponentially.",
        "Two errors in Table 2 are misprints: 0.787 against 0.713 is 10.4 %, not 8.5; 1.228 against 1.131 is 8.6 %, "
        "not 7.9. Some printed digits are truncated, not rounded.",
    )


def _sam_table(cases: Sequence[WaveCase], number: int) -> PaperTable:
    """Return Table 1 or 2: the columns that the paper prints, then ours."""
    pressure = number == 1
    analytic = published.ANALYTIC_P_MAX if pressure else published.ANALYTIC_AREA
    printed, errors = (
        (published.SAM_P_MAX, published.SAM_P_MAX_ERROR) if pressure else (published.SAM_AREA, published.SAM_AREA_ERROR)
    )
    true = published.TRUE_P_MAX if pressure else published.TRUE_AREA
    rows = []
    for case in cases:
        load = case.load
        value = case.p_max if pressure else case.area
        ours = [f"{value:.5g}", f"{abs(_percent(value, _closed_form(load)[number - 1])):.3g}"]
        row = [f"{load}", f"{case.cells}", f"{analytic[load]:g}", f"{_printed_value(printed, case):g}"]
        row += [f"{_printed_value(errors, case):g}", *ours, f"{_percent(value, true[load]):+.2f}"]
        if not pressure:
            row += [f"{_percent(case.default_area, true[load]):+.2f}", f"{case.contact_cells}"]
        rows.append((*row, f"{case.iterations}", f"{case.cpu:.3f}"))
    unit = "GPa" if pressure else "%"
    columns = ["load MPa", "N", f"analytic {unit}", f"SAM {unit}", "SAM error %", f"ours {unit}", "our error %"]
    columns += ["true error %"]
    columns += [] if pressure else ["sub-grid error %", "cells"]
    what = "maximum contact pressure" if pressure else "real contact area, % of nominal"
    notes = (_ERRORS, _TIMES, _analytic(number, unit, analytic))
    cells = Table.from_rows([*columns, "iter.", "CPU s"], rows)
    return PaperTable(f"table{number}", f"Table {number}: {what}", cells, notes)


def _extrapolation_table(cases: Sequence[WaveCase]) -> PaperTable:
    rows = []
    notes = [_ERRORS]
    for load in published.LOADS:
        true = published.TRUE_AREA[load]
        analytic = _closed_form(load)[1]
        decay, power = fit_areas(cases, load)
        row = [f"{load}", f"{published.ANALYTIC_AREA[load]:g}", f"{published.EXTRAPOLATED_AREA[load]:g}"]
        row += [f"{published.EXTRAPOLATED_ERROR[load]:g}", f"{decay.value:.3f}"]
        row += [f"{abs(_percent(decay.value, analytic)):.2f}", f"{_percent(decay.value, true):+.2f}"]
        rows.append((*row, f"{power.value:.3f}", f"{_percent(power.value, true):+.2f}"))
        notes += [f"eq. 28 at {load} MPa is not reliable: {warning}" for warning in decay.warnings]
    printed = ("load MPa", "analytic", "extrapolated", "printed error %")
    ours = ("eq. 28, ours", "our error %", "eq. 28 true error %")
    columns = (*printed, *ours, "power law, finest 3", "power law true error %")
    cells = Table.from_rows(columns, rows)
    return PaperTable("table3", "Table 3: extrapolated area, % of nominal", cells, tuple(notes), keys=1)


def _wave() -> WavyContact:
    return WavyContact(AMPLITUDE, WAVELENGTH, 1.0 / MATERIAL.compliance)


def _closed_form(load: int) -> tuple[float, float]:
    """Return eq. 26, GPa, and eq. 27, %."""
    wave = _wave()
    return wave.light_p_max(1e6 * load) / 1e9, 100 * wave.light_area_fraction(1e6 * load)


def _analytic(number: int, unit: str, printed: Mapping[int, float]) -> str:
    """Return a note with the closed form beside its printed values."""
    values = (f"{_closed_form(load)[number - 1]:.4g} (printed {printed[load]:g}) {unit}" for load in published.LOADS)
    return f"analytic: eq. {25 + number}, the limit of light load: {', '.join(values)}"


def _printed_value(table: Mapping[int, tuple[float, ...]], case: WaveCase) -> float:
    return table[case.load][published.GRIDS.index(case.cells)]


def _percent(value: float, reference: float) -> float:
    return 100.0 * (value / reference - 1.0)
