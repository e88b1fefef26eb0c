"""The rows that other programs read: the first at zero load, in their units, with what they mean in comments."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING

import attrs
import numpy as np

from roughcontact._base.checks import Array, choice
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._answers.laws.law import InterfaceLaw

THERMAL = "W/(m2 K)"
ELECTRICAL = "S/m2"
# Characters of a comment.
_WIDTH = 100


@attrs.frozen
class UnitSystem:
    """Units of a file, each by its name and by what an SI value is multiplied with.

    Attributes
    ----------
    length, pressure, conductance
        Of lengths, m; pressures, Pa; thermal conductances over area, W/(m2 K).
    """

    length: tuple[str, float]
    pressure: tuple[str, float]
    conductance: tuple[str, float]


_SYSTEMS = {
    "SI": UnitSystem(("m", 1.0), ("Pa", 1.0), (THERMAL, 1.0)),
    "mm": UnitSystem(("mm", 1e3), ("MPa", 1e-6), ("mW/(mm2 K)", 1e-3)),
}


def unit_system(name: str) -> UnitSystem:
    """Return a system of units by its name, ``"SI"`` or ``"mm"``."""
    return _SYSTEMS[choice(name, "The units of the file", tuple(_SYSTEMS))]


def keyword_name(name: object) -> str:
    """Return the name of a surface interaction, if it is a label that the programs take."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,79}", name):
        raise InputError.about("The name", name, "a letter, then up to 79 letters, digits, - or _")
    return name


def describe(law: InterfaceLaw, mark: str) -> list[str]:
    """Return what was solved and the warnings, as comments."""
    texts = [*law.description, *(f"Warning: {text}" for text in law.warnings)]
    return [f"{mark} {line}" for text in texts for line in textwrap.wrap(text, _WIDTH)]


def find_conductance(law: InterfaceLaw, column: str | None) -> str | None:
    """Return the column of the conductance; None without one, which is right for the default name alone."""
    if column is None or (column == "conductance" and column not in law.columns):
        return None
    # `InputError` for a name that the law does not have.
    _ = law[column]
    return column


def conductance_rows(law: InterfaceLaw, column: str) -> tuple[Array, Array, Array]:
    """Return pressures, conductances over nominal area and their uncertainties, SI, first of zero load."""
    found = law[column]
    if found.unit not in (THERMAL, ELECTRICAL):
        raise InputError(f"The column {column!r} is in {found.unit or 'no unit'}: a conductance is in {THERMAL}.")
    _require_finite(law, found.values, column)
    return tuple(np.append(0.0, values) for values in (law.pressures, found.values, found.uncertainties))  # type: ignore[return-value]


def closure_rows(law: InterfaceLaw) -> tuple[Array, Array, Array, float]:
    r"""Return pressures, overclosures, their uncertainties and the mean gap where the overclosure is zero, SI.

    The overclosure is a constant less the mean gap. The mean gap of a rough surface grows without end as the pressure
    goes to zero: the tangent at the lowest load meets zero pressure at the gap :math:`\bar u + p / k`, from which the
    overclosure counts.
    """
    gap = law["mean_gap"].values
    if gap.size < 2:
        raise InputError("A table of pressure over closure needs at least two loads.")
    _require_finite(law, gap, "mean_gap")
    if not (np.diff(gap) < 0.0).all():
        raise InputError(
            "The mean gap does not fall from load to load: solve with a smaller tolerance, or fewer loads."
        )
    pressures = law.pressures
    stiffness = law.columns.get("stiffness")
    slope = float((pressures[1] - pressures[0]) / (gap[0] - gap[1]))
    if stiffness is not None and stiffness.unit == "Pa/m" and 0.0 < stiffness.values[0] < np.inf:
        slope = float(stiffness.values[0])
    datum = float(gap[0] + pressures[0] / slope)
    spread = law["mean_gap"].uncertainties
    return np.append(0.0, pressures), np.append(0.0, datum - gap), np.append(0.0, spread), datum


def list_uncertainties(law: InterfaceLaw, mark: str, heading: str, columns: tuple[Array, ...]) -> list[str]:
    """Return numbers as comments: a heading, and a line for each load."""
    rows = [", ".join(f"{value:.6e}" for value in row) for row in zip(*columns, strict=True)]
    return [f"{mark} {heading}", *(f"{mark} {row}" for row in rows)]


def _require_finite(law: InterfaceLaw, values: Array, name: str) -> None:
    if not np.isfinite(values).all():
        pressure = float(law.pressures[np.flatnonzero(~np.isfinite(values))[0]])
        raise InputError(f"The column {name!r} is not finite at {pressure:g} Pa, in full contact: omit such loads.")
