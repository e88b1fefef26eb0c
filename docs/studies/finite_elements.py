"""The elastic, perfectly plastic ball against finite elements: the fits of Kogut and Etsion, and of Jackson and Green.

python docs/studies/finite_elements.py

Kogut, Etsion, J. Appl. Mech. 69 (2002) 657-662, https://doi.org/10.1115/1.1490373; Jackson, Green, J. Tribol. 127
(2005) 343-354, https://doi.org/10.1115/1.1866166. Both are at a given interference, the approach since first touch.
"""

from __future__ import annotations

import functools
import math

from doc_tables import DocTable, pick, some_of, write_tables

import roughcontact as rc

CELLS = 256
POISSON, RADIUS = 0.3, 1e-3
MODULUS = 200e9
# Hardness over yield strength, as in both studies at small interference.
RATIO = 2.8
# Yield strength over E*: that of the paper's steel, hardness 6 GPa over 2.8 and 230.8 GPa, and of a soft steel.
STRAINS = (0.0093, 0.001)
# Interference in units of that at first yield. Kogut and Etsion end at 110.
INTERFERENCES = (2.0, 4.0, 6.0, 10.0, 20.0, 40.0, 70.0, 110.0)

# First yield. Kogut, Etsion: maximum pressure K H. Jackson, Green: C Y. Both for Poisson's ratio 0.3.
MAXIMUM = (0.454 + 0.41 * POISSON) * RATIO
STRENGTH = 1.295 * math.exp(0.736 * POISSON)


def first_yield(strain: float, factor: float) -> tuple[float, float, float]:
    """Return interference, force and area of Hertz's contact of maximum pressure factor times Y."""
    interference = (math.pi * factor * strain / 2) ** 2 * RADIUS
    area = math.pi * RADIUS * interference
    return interference, 2 / 3 * factor * strain * MODULUS * area, area


def kogut_etsion(interference: float) -> tuple[float, float]:
    """Return force and area over those at first yield."""
    if interference <= 6:
        return 1.03 * interference**1.425, 0.93 * interference**1.136
    return 1.40 * interference**1.263, 0.94 * interference**1.146


def jackson_green(interference: float, strain: float) -> tuple[float, float, float]:
    """Return force and area over those at first yield, and the hardness over Y at the contact radius."""
    # Up to an interference of 1.9 the contact is taken as elastic.
    area = interference * (interference / 1.9) ** (0.14 * math.exp(23 * strain))
    width = math.pi * STRENGTH * strain / 2 * math.sqrt(area)
    hardness = 2.84 * (1 - math.exp(-0.82 * width**-0.7))
    force = math.exp(-0.25 * interference ** (5 / 12)) * interference**1.5
    force += 4 * hardness / STRENGTH * (1 - math.exp(-0.04 * interference ** (5 / 9))) * interference
    return force, area, hardness


@functools.cache
def press(approach: float, hardness: float) -> tuple[float, float]:
    """Return force and area of a ball of a hardness; approach over the radius, hardness over E*."""
    # Twice the radius of the bearing area, 2 R times the approach.
    size = 2.2 * math.sqrt(2 * RADIUS * approach * RADIUS)
    center = (0.3 * size / CELLS, -0.2 * size / CELLS)
    steel = rc.ElasticPerfectlyPlastic(MODULUS * (1 - POISSON**2), POISSON, hardness * MODULUS)
    body = rc.Body(rc.ParaboloidSurface(RADIUS, center=center), steel)
    solution = rc.ContactProblem(body, grid=rc.Grid((CELLS, CELLS), size)).solve(approach=approach * RADIUS)
    return solution.force, solution.area().value


def compare(interference: float, strain: float, factor: float, fit: tuple[float, ...], hardness: float) -> list[str]:
    """Return force and area against a fit, in texts."""
    start, force, area = first_yield(strain, factor)
    found = press(interference * start / RADIUS, hardness * strain)
    errors = found[0] / (fit[0] * force) - 1, found[1] / (fit[1] * area) - 1
    return [f"{100 * error:+.1f} %" for error in errors]


def make_rows() -> list[list[str]]:
    hard = STRAINS[0]
    lines = [["w / w_y", "KE: force", "KE: area"]]
    lines[0] += [f"JG, {name}: {what}" for name in ("hard", "soft") for what in ("force", "area")]
    lines[0] += ["JG, hard: H / Y", "with that H: force", "with that H: area"]
    for interference in some_of(INTERFERENCES, 0, 3, 7):
        line = [f"{interference:g}", *compare(interference, hard, MAXIMUM, kogut_etsion(interference), RATIO)]
        for strain in STRAINS:
            line += compare(interference, strain, STRENGTH, jackson_green(interference, strain), RATIO)
        own = jackson_green(interference, hard)
        lines.append([*line, f"{own[2]:.2f}", *compare(interference, hard, STRENGTH, own, own[2])])
    return lines


# The columns of the page.
SHOWN = (
    "w / w_y",
    "KE: force",
    "KE: area",
    "JG, hard: force",
    "JG, hard: area",
)
TABLES = {"finite-elements": DocTable(make_rows, seconds=15, units=2, shown=pick(SHOWN, ("2", "20", "110")))}

if __name__ == "__main__":
    write_tables(TABLES)
