"""What a descent on whole fields does beside its products: the passes that a convolver may bring compiled."""

from __future__ import annotations

import abc

import attrs

from roughcontact._base.arrays import Array, Mask, RealArray


@attrs.frozen(eq=False)
class LastStep:
    """The last step of a descent, flat and in float32, the displacement by it, and their product."""

    step: RealArray
    change: RealArray
    curvature: float


class FieldPasses(abc.ABC):
    """The passes of a descent over all cells of a small grid, for one task.

    Fields are flat, shape (n,): the pressure in float64 between zero and its limit, masks, and all others in float32.

    Attributes
    ----------
    limit
        Pressure limit, of one entry or one for each cell; None without one.
    load
        The sum of the pressure; None if the approach is given, which is the datum of the gap then.
    """

    def __init__(self, limit: Array | None, load: float | None) -> None:
        self.limit = limit
        self.load = load

    @abc.abstractmethod
    def measure(self, pressure: Array, gap: RealArray) -> tuple[float, float]:
        """Return the level of the gap and the error from it, as in `Violation` but not divided by the scale.

        The level is the mean of the gap over the elastic cells, weighted by their pressure; zero at a given approach.
        """

    @abc.abstractmethod
    def release(self, pressure: Array, gap: RealArray) -> tuple[RealArray, Mask, int]:
        """Return the residual, the cells that are active, and their number.

        Active are cells inside the bounds, open ones below the mean gap of these, and saturated ones above it. The
        residual is the mean gap of the active cells less the gap, zero on others.
        """

    @abc.abstractmethod
    def conjugate(
        self, image: RealArray, residual: RealArray, active: Mask, last: LastStep | None
    ) -> tuple[RealArray, float]:
        """Return the direction conjugate to the last step, if any, and the slope along the image of the residual.

        The image, the preconditioned residual, is masked in place.
        """

    @abc.abstractmethod
    def admit(
        self, direction: RealArray, residual: RealArray, active: Mask, pressure: Array
    ) -> tuple[RealArray, float]:
        """Return the nearest direction in which no released cell crosses its bound, and the slope along it.

        Its sum is zero if the load is given.
        """

    @abc.abstractmethod
    def advance(
        self, pressure: Array, direction: RealArray, length: float, active: Mask
    ) -> tuple[Array, RealArray, bool]:
        """Return the pressure after a step within the bounds and with the load, the step, and whether it met bounds."""

    @abc.abstractmethod
    def slopes(self, residual: RealArray, step: RealArray, change: RealArray) -> tuple[float, float]:
        """Return the products of the step with the residual and with the displacement by it."""

    @abc.abstractmethod
    def move(self, pressure: Array, trial: Array, part: float) -> tuple[Array, bool]:
        """Return the pressure after a part of a step to a trial pressure, and whether it is within the bounds."""

    @abc.abstractmethod
    def add(self, gap: RealArray, change: RealArray, part: float) -> None:
        """Scale a change to a part, and add it to the gap, both in place."""
