"""Preconditioned conjugate gradients on discs, in float32, with one product with the kernel for each iteration."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, RealArray, sum_of_products
from roughcontact._solve.solution import Status
from roughcontact._solve.solvers.conjugate.descent import (
    CAREFUL_LENGTH,
    FIRST_LENGTH,
    MAX_LENGTH,
    MIN_CONJUGATE_SLOPE,
    SHORTENED_STEP_PART,
    choose_part,
)
from roughcontact._solve.solvers.driver import Log, Method, iterate
from roughcontact._solve.solvers.shear.base import ShearSystem, Verified
from roughcontact._solve.solvers.shear.discs import MIN_SIZE, dot, magnitude
from roughcontact._solve.solvers.shear.preconditioner import (
    CoarseCorrection,
    EqualWeights,
    PunchWeights,
    Weights,
)

# Maximum curvature: its product with the shear of such a cell, below the limit, stays in the range of float32.
_MAX_CURVATURE = 1e30
# Maximum rejected steps of an iteration: 0.3^20 = 3e-11 of the first is below the rounding of float32.
_MAX_BACKTRACKS = 20
# Maximum part of a step, where the energy hardly bends.
_MAX_PART = 100.0
# Admissible error of the force in a step, over the sum of the limits, over the goal.
_FORCE_ERROR = 0.01
# Fraction of the cells that hit their circle above which the next direction is not conjugate: 0.003 and 0.03 change
# the iterations on nine rough contacts by 2 %.
_RESTART_FRACTION = 0.01
# Length of what lags behind, over that of the step, above which its displacement is computed at once: 0.1 and 0.5
# change the products of 54 rough contacts by at most 3 %; without it they are 14 % more, up to five times as many.
_MAX_LAG = 0.3
# Maximum iterations of a pass that do not halve the residual.
_MAX_IDLE_ITERATIONS = 12


@attrs.frozen(eq=False)
class Face:
    """The directions in which the shear may change, and the curvature of the circles.

    Attributes
    ----------
    system
        The task.
    punch
        The weights of the last face.
    slips
        Cells that slip along their circle, shape (n,).
    normal
        Outward direction where a cell slips, zero where it sticks, shape (2, n).
    curvature
        Outward slip over the limit, which the circle adds to the kernel, float32, shape (n,); zero where a cell sticks.
    """

    system: ShearSystem
    punch: PunchWeights
    slips: Mask
    normal: Array
    curvature: RealArray

    @classmethod
    def find(cls, system: ShearSystem, punch: PunchWeights, shear: Array, slip: Array) -> Face:
        """Return the face of a shear: a cell slips if it lies on its circle and its slip points outwards."""
        outward = dot(shear, slip) / system.limit**2
        slips = system.find_on_circle(shear) & (outward > 0.0)
        curvature = np.minimum(slips * outward, _MAX_CURVATURE).astype(np.float32)
        return cls(system=system, punch=punch, slips=slips, normal=shear * (slips / system.limit), curvature=curvature)

    @cached_property
    def normal_float32(self) -> RealArray:
        """The outward direction in float32."""
        return self.normal.astype(np.float32)

    @cached_property
    def is_stuck(self) -> bool:
        """Whether no cell slips."""
        return not self.slips.any()

    def restrict(self, vectors: RealArray) -> RealArray:
        """Return the part of vectors along the circle where a cell slips, and the vectors elsewhere."""
        if self.is_stuck:
            return vectors
        return _cut(vectors, self.normal_float32 if vectors.dtype == np.float32 else self.normal)

    def restrict_at(self, shear: Array, vectors: Array) -> Array:
        """Return `restrict` of vectors on the circles of another shear."""
        return vectors if self.is_stuck else _cut(vectors, shear * (self.slips / self.system.limit))

    @cached_property
    def ease(self) -> RealArray:
        """How easily a cell follows a displacement, 1 where it sticks: own over own plus curvature; float32."""
        own = np.float32(self.system.own)
        return np.asarray(own / (self.curvature + own))

    @cached_property
    def weights(self) -> Weights | EqualWeights:
        """The shear if all cells are displaced alike."""
        return self.punch.find(self.slips, self.normal_float32, self.ease)

    def _solve_for_mean(self, change: RealArray) -> RealArray:
        """Return the displacement of all cells that changes the force as a shear does, float32, shape (2, 1)."""
        x, y = np.add.reduce(change, axis=1).tolist()
        mean = self.system.control.solve_on_axes(self.weights.total, (x, y))
        return np.array(mean, dtype=np.float32)[:, np.newaxis]

    def find_residual(self, slip: Array) -> RealArray:
        """Return the slip in the face without its mean along axes with a given force, float32."""
        # Along the circle it is a small part of the slip.
        inside = self.restrict(slip).astype(np.float32)
        if not self.system.control.holds:
            return inside
        mean = self._solve_for_mean(self.weights.multiply(inside))
        return inside - (mean if self.is_stuck else _cut(mean, self.normal_float32))

    def balance(self, vectors: RealArray) -> RealArray:
        """Return vectors in the face that do not change the given force, float32."""
        inside = self.restrict(vectors)
        if not self.system.control.holds:
            return inside
        return inside - self.weights.multiply(self._solve_for_mean(inside))

    def precondition(self, residual: RealArray) -> RealArray:
        r"""Return the preconditioned residual, in the face.

        With the inverse kernel M, the curvature :math:`\lambda` and a cell's own coefficient k it is
        :math:`R M R + (1 - D) / (\lambda + k)`, :math:`D = k / (k + \lambda)`, :math:`R = \sqrt D`: near the edge of
        the contact, where the limit falls to zero, the curvature is far above the kernel.
        """
        preconditioned = self._multiply_inverse(residual)
        weights = self.weights
        if self.punch.are_equal or isinstance(weights, EqualWeights):
            return self.balance(preconditioned)
        corrected = preconditioned - CoarseCorrection(self.system, weights).apply(residual)
        # Where weights ring, the correction may turn the direction uphill.
        is_downhill = sum_of_products(residual, corrected) > 0.0
        return self.balance(corrected if is_downhill else preconditioned)

    def _multiply_inverse(self, residual: RealArray) -> RealArray:
        if self.is_stuck:
            return self.system.multiply_inverse(residual)
        root = np.sqrt(self.ease)
        preconditioned = self.system.multiply_inverse(root * residual)
        preconditioned *= root
        preconditioned += (self.ease - self.ease * self.ease) / np.float32(self.system.own) * residual
        return preconditioned


def _cut(vectors: RealArray, normal: RealArray) -> RealArray:
    """Return vectors without their part along a normal."""
    x, y = normal
    outward: RealArray = normal * (x * vectors[0] + y * vectors[1])
    return np.subtract(vectors, outward, out=outward)


@attrs.frozen(eq=False)
class _Taken:
    """The last step, its product with the kernel, and the product of both."""

    step: RealArray
    change: RealArray
    curvature: float


class ShearDescent(Method):
    """Lowers the energy by preconditioned conjugate gradients on the faces of the discs.

    The step length is guessed, the step projected on the discs with the force restored, its displacement computed, and
    its length then corrected. The correction follows the circles, the displacement the straight step: the difference is
    part of the next step, and until then only its effect on its own cell counts. So an iteration needs one product with
    the kernel and one with its inverse, and a further one only while many cells move around their circles.

    Attributes
    ----------
    displacement
        Displacement of the bodies, shape (2,).
    """

    patience = _MAX_IDLE_ITERATIONS

    def __init__(self, system: ShearSystem) -> None:
        self._system = system
        self._punch = PunchWeights(system)
        self._length = FIRST_LENGTH
        self.displacement = system.displacement

    def run(self, start: Verified, goal: float, log: Log) -> Array:
        """Return a shear whose residual is estimated to reach a goal, or is as low as float32 allows."""
        self._shear = start.shear
        self.displacement = start.displacement
        # The slip is that of the shear less what lags behind.
        self._slip = start.slip.copy()
        self._lag: RealArray = np.zeros(self._shear.shape, dtype=np.float32)
        self._last: _Taken | None = None
        self._error = _FORCE_ERROR * goal
        self._length = max(self._length, CAREFUL_LENGTH)
        iterate(self, log, goal, math.inf)
        on_circle = self._system.find_on_circle(self._shear)
        return self._system.control.project(self._shear, self._system.limit, circle=on_circle)[0]

    def measure(self) -> tuple[float, float]:
        """Return the estimated residual, and no rounding; the displacement of the bodies is chosen anew."""
        system = self._system
        trial = self._local_slip()
        trial /= system.own
        trial += self._shear
        nearest, shift = system.control.project(trial, system.limit, gain=1.0 / system.own, error=self._error)
        self._slip += shift[:, np.newaxis]
        self.displacement = self.displacement + shift
        # That is the natural residual, but for its unit.
        nearest -= self._shear
        return math.sqrt(float(dot(nearest, nearest).max())) / float(system.limit.max()), 0.0

    def _local_slip(self) -> Array:
        """Return the slip with the effect of what lags on its own cells."""
        return self._slip - np.float32(self._system.own) * self._lag

    def step(self) -> Status | None:
        """Make one step that lowers the energy, if there is one."""
        self._system.iterations += 1
        slip = self._local_slip()
        face = Face.find(self._system, self._punch, self._shear, slip)
        residual = face.find_residual(slip)
        preconditioned = face.precondition(residual)
        direction = self._conjugate(face, residual, preconditioned)
        for _ in range(_MAX_BACKTRACKS):
            if self._move(face, residual, direction):
                return None
            if direction is preconditioned:
                self._length *= CAREFUL_LENGTH
            direction = preconditioned
        return Status.STALLED

    def _conjugate(self, face: Face, residual: RealArray, preconditioned: RealArray) -> RealArray:
        """Return the direction that is conjugate to the last step, or the preconditioned residual."""
        if self._last is None:
            self._length = max(self._length, CAREFUL_LENGTH)
            return preconditioned
        last = face.balance(self._last.step)
        bent = face.curvature * last
        product = sum_of_products(preconditioned, self._last.change) + sum_of_products(preconditioned, bent)
        curvature = self._last.curvature + sum_of_products(last, bent)
        if not (curvature > 0.0 > product):
            return preconditioned
        direction = preconditioned + np.float32(-product / curvature) * last
        steep = sum_of_products(residual, direction) > MIN_CONJUGATE_SLOPE * sum_of_products(residual, preconditioned)
        return direction if steep else preconditioned

    def _move(self, face: Face, residual: RealArray, direction: RealArray) -> bool:
        """Take a step of the present length along a direction, with its length corrected, if it lowers the energy."""
        system = self._system
        ahead = self._shear + np.float32(self._length) * direction
        hits = (magnitude(ahead) > system.limit) & ~face.slips
        trial = system.control.project(ahead, system.limit, circle=face.slips, gain=face.ease, error=self._error)[0]
        move = (trial - self._shear).astype(np.float32)
        step = move + self._lag
        change = system.multiply(step)
        # The derivatives of the energy along the circles at both ends of the move.
        along = face.restrict(move)
        curvature = sum_of_products(along, change - np.float32(system.own) * self._lag)
        slope = sum_of_products(residual, along)
        after = sum_of_products(face.restrict_at(trial, self._slip - change).astype(np.float32), move)
        if not (math.isfinite(curvature) and slope > 0.0):
            return False
        # The mean shear of a periodic contact has no stiffness.
        wanted = slope / max(slope - after, slope / _MAX_PART)
        if wanted <= SHORTENED_STEP_PART:
            return False
        part = self._choose_part(face, move, wanted, meets=bool(hits.any()))
        along = np.float32(part) * along
        change *= np.float32(part)
        step *= np.float32(part)
        self._last = _Taken(along, change, part * part * curvature)
        self._slip -= change
        end = self._find_end(face, hits, np.float32(part) * move)
        self._lag += end - self._shear - step
        self._shear = end
        if sum_of_products(self._lag, self._lag) > _MAX_LAG**2 * sum_of_products(step, step):
            self._slip -= system.multiply(self._lag)
            self._lag[...] = 0.0
        if np.count_nonzero(hits) > _RESTART_FRACTION * hits.size:
            self._last = None
        return True

    def _find_end(self, face: Face, hits: Mask, move: RealArray) -> Array:
        """Return the shear after a move, on its circle where a cell slips or has hit it.

        A cell that has hit its circle, or whose slip has turned inwards, goes to the place on the circle that the
        natural residual asks for, if that is beyond the circle.
        """
        system = self._system
        end = self._shear + move
        size = magnitude(end)
        on_circle = face.slips | (size > system.limit)
        reach = np.maximum(size, system.limit)
        np.copyto(reach, np.maximum(size, MIN_SIZE), where=face.slips)
        inwards = on_circle & (dot(end, self._slip) < 0.0)
        end *= system.limit / reach
        turned = np.flatnonzero(hits | inwards)
        ahead = end.take(turned, axis=1) + self._slip.take(turned, axis=1) / system.own
        limit = system.limit[turned]
        distance = magnitude(ahead)
        beyond = distance > limit
        end[:, turned[beyond]] = ahead[:, beyond] * (limit[beyond] / distance[beyond])
        return end

    def _choose_part(self, face: Face, step: RealArray, wanted: float, *, meets: bool) -> float:
        """Return the part of the step to be taken, and set the next length.

        `wanted` is the position of the minimum of the energy along the step, `meets` whether it ends on new circles.
        """
        if not meets:
            part = wanted if wanted <= 1.0 else min(wanted, max(1.0, self._find_room(face, step)))
            self._length = min(MAX_LENGTH, self._length * max(part, 0.25))
            return part
        part, factor = choose_part(wanted)
        self._length = min(MAX_LENGTH, self._length * factor)
        return part

    def _find_room(self, face: Face, step: RealArray) -> float:
        """Return the part of a step up to which all cells that stick remain within their circles."""
        sticks = np.flatnonzero(~face.slips)
        move = step.take(sticks, axis=1)
        shear = self._shear.take(sticks, axis=1)
        square = dot(move, move)
        product = dot(shear, move)
        rest = np.maximum(self._system.limit[sticks] ** 2 - dot(shear, shear), 0.0)
        root = np.sqrt(product * product + square * rest) - product
        return float(
            np.divide(root, square, out=np.full_like(root, math.inf), where=square > 0.0).min(initial=math.inf)
        )
