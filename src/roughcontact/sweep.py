"""Several loads in a row."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import attrs
import numpy as np

from roughcontact.checks import Array, number
from roughcontact.errors import InputError
from roughcontact.solution import ContactSolution, EstimatesArea
from roughcontact.units import si

# A load that gives an area is found to this, relative to the area; where the area jumps from cell to
# cell, to its uncertainty.
_FOUND = 1e-3
_TRIES = 40


@attrs.frozen(eq=False)
class Sweep:
    """Solutions at several loads, and what came out as columns of a table.

    Attributes
    ----------
    solutions
        In the order of the loads.
    """

    solutions: tuple[ContactSolution, ...]

    @property
    def force(self) -> Array:
        """Normal forces, N."""
        return np.array([solution.force for solution in self.solutions])

    @property
    def mean_pressure(self) -> Array:
        """Nominal mean pressures, Pa."""
        return np.array([solution.mean_pressure for solution in self.solutions])

    @property
    def approach(self) -> Array:
        """Approaches since first touch, m."""
        return np.array([solution.approach for solution in self.solutions])

    @property
    def area(self) -> Array:
        """Real contact areas by the default estimator, m2."""
        return np.array([solution.area().value for solution in self.solutions])

    @property
    def stiffness(self) -> Array:
        """Slopes dF/d(approach) through neighbouring loads, N/m; nan where there is no neighbour."""
        if len(self.solutions) < 2 or np.unique(self.approach).size < len(self.solutions):
            return np.full(len(self.solutions), np.nan)
        return np.gradient(self.force, self.approach)

    @property
    def convolutions(self) -> int:
        """Convolutions of all solves together."""
        return sum(solution.convolutions for solution in self.solutions)

    def __str__(self) -> str:
        rows = zip(self.mean_pressure, self.force, self.approach, self.area, self.stiffness, strict=True)
        nominal = self.solutions[0].grid.area
        lines = [f"{'mean pressure':>14} {'force':>12} {'approach':>12} {'area, %':>10} {'stiffness':>14}"]
        lines += [
            f"{si(p, 'Pa'):>14} {si(f, 'N'):>12} {si(d, 'm'):>12} {100 * a / nominal:>10.4g} {si(k, 'N/m'):>14}"
            for p, f, d, a, k in rows
        ]
        return "\n".join(lines)


def swept(
    solve: Callable[..., ContactSolution], check: Callable[..., object], **lists: Sequence[float] | None
) -> Sweep:
    """Solve for each load of the one list that is given, once `check` has let all of them pass."""
    given = {name: values for name, values in lists.items() if values is not None}
    if len(given) != 1 or not isinstance(next(iter(given.values())), Iterable):
        raise InputError("Give exactly one list of loads: pressure=, force= or approach=.")
    name, values = next(iter(given.items()))
    loads = [number(value, f"A load of the sweep, {name},", above=0.0) for value in values]
    if not loads:
        raise InputError("Give exactly one list of loads that is not empty: pressure=, force= or approach=.")
    for load in loads:
        check(**{name: load})
    solutions: list[ContactSolution] = []
    for load in loads:
        solutions.append(solve(**{name: load}, start=predicted(solutions, name, load)))
    return Sweep(tuple(solutions))


def area_load(
    solve: Callable[..., ContactSolution],
    fraction: float,
    estimator: str | EstimatesArea,
    guess: float,
    largest: float,
) -> ContactSolution:
    """Find the mean pressure that gives an area; see `ContactProblem.solve_area`.

    Parameters
    ----------
    solve
        Solves for ``pressure=``, Pa, and ``start=``.
    fraction, estimator
        The area over nominal area, and who is to give it.
    guess, largest
        A pressure that gives a large part of the area, and the greatest that can be carried, Pa.
    """
    fraction = number(fraction, "The fraction of the area", above=0.0)
    if fraction >= 1.0:
        raise InputError.about("The fraction of the area", fraction, "below 1", "Full contact is given by many loads.")
    low, high = 0.0, largest
    pressure = min(0.5 * fraction * guess, 0.5 * largest)
    solution = None
    for _ in range(_TRIES):
        start = None if solution is None else solution.pressure * (pressure / solution.mean_pressure)
        solution = solve(pressure=pressure, start=None if start is None else np.minimum(start, solution.limit))
        found = solution.area(estimator).fraction
        if abs(found / fraction - 1.0) <= _FOUND:
            return solution
        narrow = high - low <= 1e-6 * low
        if narrow and abs(found - fraction) * solution.grid.area <= solution.area(estimator).uncertainty:
            return solution
        if narrow:
            break
        low, high = (pressure, high) if found < fraction else (low, pressure)
        # At light load the area is nearly in proportion to the load.
        pressure = pressure * fraction / found if found > 0.0 else 2.0 * pressure
        if not low < pressure < high:
            pressure = 0.5 * (low + high) if math.isfinite(high) else 2.0 * low
    raise InputError(
        f"No load gives an area of {fraction:g} of nominal: near {si(pressure, 'Pa')} it jumps past it. "
        "Refine the grid or choose another estimator."
    )


def predicted(solutions: list[ContactSolution], name: str, load: float) -> Array | None:
    """Return the pressure in line with the last two, within the bounds; None for the first load."""
    if not solutions:
        return None
    last = solutions[-1]
    values = {"pressure": "mean_pressure", "force": "force", "approach": "approach"}[name]
    now = getattr(last, values)
    if len(solutions) == 1:
        start = last.pressure * (load / now)
    else:
        before = getattr(solutions[-2], values)
        share = (load - now) / (now - before) if now != before else 0.0
        start = last.pressure + share * (last.pressure - solutions[-2].pressure)
        if not start.max() > 0.0:
            return None
    return np.asarray(np.clip(start, 0.0, last.limit))
