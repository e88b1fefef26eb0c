"""Errors and uncertainties of maximum pressure, perimeter, patches, approach and mean gap on the classes of contacts.

    python benchmarks/quantity_classes.py peak-pressure [options of area_classes.py]

The table is that of `benchmarks/area_classes.py`, `--classes unkind` those of unkind geometry together; classes without
true values of the quantity are omitted.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import area_classes
import contact_classes as contacts
import numpy as np
from area_classes import CLASSES, HEADER, SPLITS, UNKIND, known, print_rows, reference_key
from contact_classes import Case

import roughcontact as rc

NAMES = {
    "peak-pressure": "p_max",
    "perimeter": "perimeter",
    "patches": "patches",
    "approach": "approach",
    "mean-gap": "mean_gap",
}
# Here the pressure is unbounded at sharp edges or a sharp tip, or each grid has a surface of its own.
UNBOUNDED = ("run-in", "cone", "border", "holes", "map", "lost", "capped-punch")
WAVE = 12.5e-6


def true_value(name: str, case: Case, solution: rc.ContactSolution, quantity: str) -> tuple[float, float]:
    """Return the true value and its standard deviation; nan where there is none."""
    if case.true is not None:
        return case.true.get(quantity, 1.0 if quantity == "patches" and "force" in case.load else math.nan), 0.0
    found = known()[reference_key(name, case)]
    fine, half = found[quantity]
    side = solution.grid.size[0]
    if quantity == "perimeter" and name == "capped-ball":
        # The contact is a disc.
        area = 25.0 * found["area"][0]
        return 2.0 * math.sqrt(math.pi * area), 0.0
    if quantity == "perimeter":
        return fine * side**2 / (WAVE if name.startswith("wave") else side), abs(fine - half) / 3 * side
    if quantity == "patches":
        # The summits of a wave are connected at 42 % contact, and alone at 26 %.
        alone = name.startswith("wave") and found["area"][0] < 0.4
        return fine * (round(side / WAVE) ** 2 if alone else 1), 0.0
    if quantity in ("mean_gap", "approach"):
        if name in ("capped-ball", "border"):
            return (math.nan, math.nan) if quantity == "mean_gap" else (fine, abs(fine - half) / 3)
        gap, half_gap = found["mean_gap"]
        gap, std = (4 * gap - half_gap) / 3, abs(gap - half_gap) / 15
        if quantity == "mean_gap":
            if name == "capped-rough":
                # Saturated cells overlap, which counts in the approach alone.
                gap, half_gap = found["open_gap"]
                std = abs(gap - half_gap) / 3
            if name == "holes-filled":
                gap += _lower_by_filling(case, solution)
            return gap, std
        # On a periodic boundary the gap of the highest summit above the mean plane is shared out between both.
        return _height(name, case, solution) - gap, std
    return fine, abs(fine - half) / 3


_HEIGHTS: dict[str, float] = {}


def _height(name: str, case: Case, solution: rc.ContactSolution) -> float:
    """Return the height of the highest summit of a periodic surface above its mean plane, m."""
    from roughcontact._answers.areas.approach import find_rise

    if name == "holes-filled":
        # The highest summit of all may be among the points that were filled.
        whole, higher = _find_whole(case, solution)
        filled = np.abs(whole[1::3, 1::3] - solution.initial_gap - higher) > 1e-6 * np.ptp(whole)
        missing = np.kron(filled, np.ones((3, 3), dtype=bool))
        rise = find_rise(whole, rc.Boundary.PERIODIC, missing)[0]
        return float(np.mean(whole) - whole[~missing].min()) + rise
    if case.key not in _HEIGHTS:
        # A map that is linear between its points is highest at one of them.
        linear = name == "map-upsampled"
        gap = case.fine(1 if linear else contacts.FINE).initial_gap
        rise = 0.0 if linear else find_rise(gap, rc.Boundary.PERIODIC)[0]
        _HEIGHTS[case.key] = float(np.mean(gap)) + rise
    return _HEIGHTS[case.key]


def _find_whole(case: Case, solution: rc.ContactSolution) -> tuple[np.ndarray, float]:
    """Return the gap of a surface before filling, on cells a third as wide, and by how much it is more, m."""
    # Every third of these cells has the place of one of the map.
    whole = case.fine(3 * solution.grid.shape[0]).initial_gap
    return whole, float(np.median(whole[1::3, 1::3] - solution.initial_gap))


def _lower_by_filling(case: Case, solution: rc.ContactSolution) -> float:
    """Return by how much a map's mean plane is lower where its points were filled, m."""
    whole, higher = _find_whole(case, solution)
    return float(np.mean(solution.initial_gap)) + higher - float(np.mean(whole))


def report(
    names: Sequence[str], split: str, quantity: str, folder: Path | None, groups: bool = False, worst: int = 0
) -> dict[str, dict[str, float]]:
    """Print the table and return its rows by class."""
    print(f"{split}, {quantity}\n{HEADER}")
    table = {}
    for name in names:
        rows = []
        for solution, _, _, case in area_classes.cases(name, split, folder):
            true, std = true_value(name, case, solution, NAMES[quantity])
            if math.isfinite(true) and true > 0.0:
                found = solution.response(quantity)
                rows.append((found.value / true - 1.0, found.uncertainty / true, std / true, case))
        if not rows:
            continue
        table[name] = print_rows(name, rows, groups=groups, worst=worst)
    return table


def list_classes(quantity: str) -> list[str]:
    """Return the classes whose true values of a quantity are known."""
    skipped = UNBOUNDED if quantity == "peak-pressure" else ("lost", "holes-kept")
    return [name for name in CLASSES if not name.startswith(skipped)]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("quantity", choices=NAMES)
    parser.add_argument("--classes", default="all", help="all, unkind, or names or beginnings of classes")
    parser.add_argument("--split", default="tuned", choices=SPLITS)
    parser.add_argument("--cache", type=Path)
    parser.add_argument("--groups", action="store_true")
    parser.add_argument("--worst", type=int, default=0)
    options = parser.parse_args(arguments)
    usual = list_classes(options.quantity)
    wanted = tuple(options.classes.split(","))
    groups = {"all": usual, "unkind": list(UNKIND)}
    names = groups.get(options.classes) or [name for name in (*usual, *UNKIND) if name.startswith(wanted)]
    report(names, options.split, options.quantity, options.cache, options.groups, options.worst)


if __name__ == "__main__":
    main()
