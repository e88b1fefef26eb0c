"""The search for the load at which an answer of a contact is the wanted one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from typing import Generic, TypeAlias, TypeVar, final

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Load
from roughcontact._solve.problem.sweep import predict_pressure
from roughcontact._solve.solution import ContactSolution

A = TypeVar("A")

# Maximum loads of a search: halvings, the worst case, narrow any bracket below the criterion for jumps.
_MAX_LOADS = 40
# Errors that were not halved in two steps, after which all brackets are halved.
_MAX_STALLS = 1
# Factor by which the load changes at most in a step without a bracket; each further one is its square. The first step
# is shorter where the answer may fall with the load.
_FIRST_FACTOR = 8.0
_PROBING_FACTOR = 2.0
# Steps from one load to the next, over that between the two before, up to which the pressure is extrapolated.
_MAX_EXTRAPOLATION = 3.0
# Smallest distance of two logarithmic loads through which the line from the last load is drawn.
_MIN_LINE_WIDTH = 1e-2
# Solutions that are kept beside those of the bracket: fields take memory.
_KEPT_SOLUTIONS = 3
# Factor by which the digits of the answer grow from load to load, about, by the secant rule; error from which on they
# do.
_ORDER = 1.6
_MAX_FORECAST_ERROR = 0.5

SolveFromPressure: TypeAlias = Callable[[Load, Array | None], ContactSolution]


@final
@attrs.frozen
class TriedLoad(Generic[A]):
    """A load and its answer.

    Attributes
    ----------
    x
        The logarithm of the load over the unit of the search.
    off
        The logarithm of the answer over the wanted one; infinite where only the side is known.
    tolerance
        Distance of `off` from zero at which the answer is the wanted one.
    answer
        The answer itself.
    """

    x: float
    off: float
    tolerance: float
    answer: A

    @property
    def is_wanted(self) -> bool:
        """Whether the answer is near enough to the wanted one."""
        return abs(self.off) <= self.tolerance


@final
@attrs.define(eq=False, kw_only=True)
class LoadSearch(Generic[A]):
    """The search for one load.

    The logarithm of most answers is nearly a straight line over that of the load: the line through the last two loads
    tells the next one, the parabola through three loads once they are on both sides. Where only the side is known, or
    the answer jumps or bends, brackets are halved. Of an answer with kinks only the line from the last load is
    followed.

    Attributes
    ----------
    solve
        Returns the solution at a load, from a pressure.
    read
        Returns a load with its answer, from the logarithm of the load and the solution.
    unit
        The load of which all others are counted as multiples, with its kind, pressure or force.
    ends
        The smallest and the largest load that may be tried, in the same unit; 0 and infinity without one.
    power
        Power of the load by which the second one is chosen.
    rises
        Whether the answer is known to rise with the load.
    factor
        Factor by which the load changes at most in the second step.
    has_kinks
        Whether the power of the load changes abruptly, as that of a stress does where a second cell touches.
    width
        Logarithm of the ratio of two loads between which an answer that is still not found jumps.
    on_answer
        Called after each load with the number of those still to come, about.
    tried
        The loads, ascending.
    solutions
        Those of the loads next to the last one and of the bracket, by the logarithm of the load.
    convolutions
        Of all solves.
    """

    solve: SolveFromPressure
    read: Callable[[float, ContactSolution], TriedLoad[A]]
    unit: Load
    ends: tuple[float, float]
    width: float
    power: float = 1.0
    rises: bool = False
    has_kinks: bool = False
    factor: float = _FIRST_FACTOR
    on_answer: Callable[[int], None] | None = None
    tried: list[TriedLoad[A]] = attrs.field(factory=list, init=False)
    solutions: dict[float, ContactSolution] = attrs.field(factory=dict, init=False)
    convolutions: int = attrs.field(default=0, init=False)
    _last: TriedLoad[A] = attrs.field(init=False)
    _errors: list[float] = attrs.field(factory=list, init=False)
    _stalls: int = attrs.field(default=0, init=False)

    def run(self, x: float) -> TriedLoad[A] | None:
        """Return the load of the wanted answer, searched from a first one; see `resume`."""
        self.try_load(x)
        return self.resume()

    def run_from(self, known: Iterable[ContactSolution]) -> TriedLoad[A] | None:
        """Return the load of the wanted answer, searched from contacts that are solved already; see `resume`."""
        for solution in known:
            load = solution.force if self.unit.kind == "force" else solution.mean_pressure
            self._take(math.log(load / self.unit.value), solution)
        return self.resume()

    def resume(self) -> TriedLoad[A] | None:
        """Return the load of the wanted answer; None without one.

        The answer then jumps in `bracket`, or is not reached between the ends, or was not found in so many loads.
        """
        while True:
            wanted = next((one for one in self.tried if one.is_wanted), None)
            if wanted is not None:
                return wanted
            if self.on_answer is not None:
                self.on_answer(self._forecast())
            bracket = self.bracket
            if len(self.tried) >= _MAX_LOADS or self.is_jump:
                return None
            x = self._extrapolate() if bracket is None else self._interpolate(*bracket)
            if x is None:
                return None
            self.try_load(x)

    def try_load(self, x: float) -> TriedLoad[A]:
        """Return the answer at a load, after solving from the nearest ones."""
        load = Load(self.unit.kind, self.load_at(x))
        near = sorted(self.solutions, key=lambda one: -abs(one - x))[-2:]
        if len(near) == 2 and abs(x - near[1]) > _MAX_EXTRAPOLATION * abs(near[1] - near[0]):
            near = near[1:]
        solution = self.solve(load, predict_pressure([self.solutions[one] for one in near], load))
        self.convolutions += solution.convolutions
        return self._take(x, solution)

    def _take(self, x: float, solution: ContactSolution) -> TriedLoad[A]:
        found = self._last = self.read(x, solution)
        self.tried = sorted([*self.tried, found], key=lambda one: one.x)
        self.solutions[x] = solution
        kept = sorted(self.solutions, key=lambda one: abs(one - x))[:_KEPT_SOLUTIONS]
        kept += [end.x for end in self.bracket or ()]
        self.solutions = {one: state for one, state in self.solutions.items() if one in kept}
        return found

    def load_at(self, x: float) -> float:
        """Return a load, of which `x` is the logarithm over the unit."""
        return min(self.unit.value * math.exp(x), self.ends[1])

    @property
    def bracket(self) -> tuple[TriedLoad[A], TriedLoad[A]] | None:
        """The closest neighbouring loads whose answers are on both sides of the wanted one."""
        found = [pair for pair in itertools.pairwise(self.tried) if (pair[0].off < 0.0) != (pair[1].off < 0.0)]
        return min(found, key=lambda pair: pair[1].x - pair[0].x, default=None)

    @property
    def is_jump(self) -> bool:
        """Whether the answer passes the wanted one between two loads so close that it jumps."""
        bracket = self.bracket
        return bracket is not None and bracket[1].x - bracket[0].x <= self.width

    def find_nearest(self, count: int) -> list[TriedLoad[A]]:
        """Return the loads whose finite answers are nearest to the wanted one."""
        return sorted((one for one in self.tried if math.isfinite(one.off)), key=lambda one: abs(one.off))[:count]

    def find_slope(self, at: TriedLoad[A], distance: float) -> float | None:
        """Return the slope of the logarithm of the answer over that of the load; None without a load at a distance."""
        apart = [one for one in self.tried if math.isfinite(one.off) and one is not at]
        apart = [one for one in apart if abs(one.x - at.x) >= distance]
        near = sorted(apart, key=lambda one: abs(one.x - at.x))[:2]
        slopes = [(at.off - one.off) / (at.x - one.x) for one in near]
        if len(near) < 2:
            return slopes[0] if near else None
        # The derivative of the parabola at the load.
        one, other = (near[index].x - at.x for index in (0, 1))
        slope = (slopes[0] * other - slopes[1] * one) / (other - one)
        return slope if slope * slopes[0] > 0.0 else slopes[0]

    def _forecast(self) -> int:
        """Return how many loads are still to come, about."""
        nearest = min(self.tried, key=lambda one: abs(one.off))
        digits = -math.log(min(abs(nearest.off), _MAX_FORECAST_ERROR)) / -math.log(nearest.tolerance)
        return max(1, math.ceil(-math.log(digits) / math.log(_ORDER)))

    def _interpolate(self, low: TriedLoad[A], high: TriedLoad[A]) -> float:
        """Return a load inside a bracket."""
        middle = 0.5 * (low.x + high.x)
        if not (math.isfinite(low.off) and math.isfinite(high.off)):
            return middle
        for points in self._choose_points(low, high):
            x = _at_zero(points)
            if low.x < x < high.x:
                return x
        return middle

    def _choose_points(self, low: TriedLoad[A], high: TriedLoad[A]) -> list[list[TriedLoad[A]]]:
        """Return the points of the polynomials to follow inside a bracket, the best ones first."""
        if self.has_kinks:
            last = self._last
            apart = [one for one in self.tried if abs(one.x - last.x) >= _MIN_LINE_WIDTH and math.isfinite(one.off)]
            return [[last, min(apart, key=lambda one: abs(one.x - last.x))]] if apart else []
        self._errors.append(min(abs(low.off), abs(high.off)))
        is_stalled = len(self._errors) > 2 and self._errors[-1] > 0.5 * self._errors[-3]
        self._stalls += is_stalled
        # The answer jumps or bends.
        if is_stalled or self._stalls > _MAX_STALLS:
            return []
        others = [one for one in self.find_nearest(3) if one not in (low, high)]
        return [[low, high, *others[:1]], [low, high]]

    def _extrapolate(self) -> float | None:
        """Return a load farther out, while all answers are on one side of the wanted one; None beyond the ends."""
        first = self.tried[0]
        last = self.tried[-1]
        change = last.off - first.off
        # Where all answers are zero, as a flow that is shut off, or without end: up, then down.
        rising = bool(len(self.tried) % 2) if math.isnan(change) else change >= 0.0
        upwards = (first.off < 0.0) == (rising or self.rises)
        edge = last if upwards else first
        if len(self.tried) == 1:
            reach = math.log(self.factor if self.rises else _PROBING_FACTOR)
            step = abs(edge.off) / self.power
        else:
            reach = math.log(self.factor) * 2.0 ** (len(self.tried) - 2)
            step = math.inf
            near = self.find_nearest(3)
            for count in (2,) if self.has_kinks else (2, 3):
                ahead = (_at_zero(near[:count]) if len(near) >= count else math.nan) - edge.x
                if math.isfinite(edge.off) and 0.0 < (ahead if upwards else -ahead) <= min(2.0 * step, reach):
                    step = abs(ahead)
        step = min(step, reach)
        lightest, heaviest = (math.log(end / self.unit.value) if end > 0.0 else -math.inf for end in self.ends)
        x = min(edge.x + step, heaviest) if upwards else max(edge.x - step, lightest)
        return x if (x > edge.x if upwards else x < edge.x) else None


def _at_zero(points: list[TriedLoad[A]]) -> float:
    """Return the load at which the polynomial through two or three points, load over answer, has the wanted answer."""
    offs = [one.off for one in points]
    if len(set(offs)) < len(offs):
        return math.nan
    total = 0.0
    for one in points:
        others = [off for off in offs if off != one.off]
        total += one.x * float(np.prod([off / (off - one.off) for off in others]))
    return total
