"""The contact near full contact, found by its few openings instead of its pressure."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.checks import Array, RealArray
from roughcontact._solve.convolvers import InverseConvolution
from roughcontact._solve.solvers.base import Monitor
from roughcontact._solve.solvers.conjugate.active import ActiveCells
from roughcontact._solve.solvers.conjugate.descent import Descent
from roughcontact._solve.solvers.conjugate.preconditioner import multiply_active
from roughcontact._solve.solvers.conjugate.weights import PunchWeights
from roughcontact._solve.solvers.projection import ApproachControl, total

# Stiffness that supports waves longer than the openings, over the mean one of a punch of their shape.
_SUPPORT = 0.25
# Error to which float32 tells a pressure, and the factor by which a pass in float32 may lower the error.
_SINGLE = 1e-6
_GAIN = 2e-5
# A pass that cannot reach the goal ends at this multiple of what float32 tells: the next one starts anew.
_EARLY = 10.0


@attrs.frozen(eq=False)
class NearlyFull:
    """A start near full contact on a periodic boundary.

    Attributes
    ----------
    inverse
        Inverse of the convolution.
    closing
        Pressure of full contact, shape (nx, ny); negative where cells must open.
    gap
        A gap that is not negative, shape (nx, ny).
    """

    inverse: InverseConvolution
    closing: Array
    gap: RealArray

    def is_closed(self, limit: Array) -> bool:
        """Return whether the pressure of full contact is within its bounds."""
        return bool(self.closing.min() >= 0.0 and not (self.closing > limit).any())


class Openings:
    r"""Finds the gap g of the cells that open, and from it the pressure.

    With the pressure :math:`p_0` of full contact and the inverse kernel M, the pressure is
    :math:`p_0 + M g`, so that the gap minimises :math:`\tfrac12\,g \cdot M g + p_0 \cdot g` over :math:`g \ge 0`:
    the contact problem with both fields exchanged. M annihilates the mean, so that the load is that of
    :math:`p_0` and the approach is free. Vectors hold the few open cells.

    Attributes
    ----------
    gap
        The gap, shape (nx, ny).
    error
        Error of the pressure that was found last, over its maximum.
    """

    def __init__(self, start: NearlyFull, monitor: Monitor) -> None:
        self._inverse = start.inverse
        self._closing = start.closing
        self._monitor = monitor
        self.gap = start.gap.astype(np.float64)
        shape = start.closing.shape
        inverse = start.inverse
        single = attrs.evolve(inverse, stiffness=inverse.stiffness.astype(np.float32))
        self._single = single
        self._preconditioner = OpeningPreconditioner(single, shape)
        self._descent = Descent(single, shape, self._preconditioner, ApproachControl(), np.array([np.inf]))
        self.error = np.inf
        self._products = 0

    @property
    def products(self) -> int:
        """Products with the inverse kernel so far."""
        return self._products + self._descent.products + self._preconditioner.products

    def approximate(self, goal: float) -> Array:
        """Return the pressure after one pass in float32."""
        pressure = self._closing
        if self.gap.any():
            self._products += 1
            pressure = pressure + self._single.apply(self.gap.astype(np.float32))
        self._monitor.record(self._measure(pressure))
        return self._bound(self._descend(pressure, goal if goal > _SINGLE else _EARLY * _SINGLE).astype(np.float64))

    def solve(self, goal: float) -> Array:
        """Return the pressure, with an error below the goal if it can be reached."""
        previous = np.inf
        while True:
            self._products += 1
            pressure = self._closing + self._inverse.apply(self.gap)
            self.error = self._measure(pressure)
            if self.error <= goal or self.error > 0.5 * previous or not self._monitor.has_iterations_left:
                return self._bound(pressure)
            previous = self.error
            self._descend(pressure, max(goal, _GAIN * self.error))

    def _descend(self, pressure: Array, goal: float) -> RealArray:
        """Lower the error of the gap to a goal, as far as float32 can; return the pressure."""
        peak = float(pressure.max())
        self._descent.start(self.gap.reshape(-1), pressure.astype(np.float32).ravel())
        while self._monitor.has_iterations_left and self._descent.iterate():
            error = self._descent.error() / peak
            self._monitor.record(error)
            if error <= goal:
                break
        return self._descent.stop().reshape(pressure.shape)

    def _measure(self, pressure: Array) -> float:
        """Return the error of a pressure, over its maximum: negative, or on an open cell."""
        opened = float(self.gap.sum())
        mean = float(np.einsum("ij,ij->", self.gap, np.abs(pressure))) / opened if opened > 0.0 else 0.0
        return max(mean, -float(pressure.min())) / float(pressure.max())

    def _bound(self, pressure: Array) -> Array:
        """Return the pressure, changed in place, without what pulls or acts on open cells."""
        np.maximum(pressure, 0.0, out=pressure)
        pressure[self.gap > 0.0] = 0.0
        return pressure


class OpeningPreconditioner:
    """The inverse of the stiffness between masks, with a support against waves longer than the openings."""

    def __init__(self, inverse: InverseConvolution, shape: tuple[int, int]) -> None:
        self._inverse = inverse
        self._shape = shape
        self._punch = PunchWeights(inverse, shape)
        self._symbol: RealArray = np.zeros(0, dtype=np.float32)
        self._products = 0

    @property
    def products(self) -> int:
        """Products so far."""
        return self._products + self._punch.products

    def weights(self, active: ActiveCells) -> RealArray:
        """Return the vector of ones."""
        weights = self._punch.update(active)
        support = 1.0 if weights is None else _SUPPORT * total(weights) / active.count
        self._symbol = 1.0 / (self._inverse.stiffness + np.float32(support))
        return active.ones

    def apply(self, active: ActiveCells, weights: RealArray, residual: RealArray) -> RealArray:
        """Return the vector of the preconditioned residual."""
        self._products += 1
        return multiply_active(active, residual, self._inverse, self._symbol, self._shape)
