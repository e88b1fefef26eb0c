"""The interface of an interaction, and the narrow waist through which a solver sees it."""

from __future__ import annotations

import abc
from collections.abc import Callable
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair, RealArray
from roughcontact._base.checks import Part, number, pair, returned_array
from roughcontact._base.registry import Registry, arguments_of
from roughcontact.errors import InputError

# Energy over the work of adhesion, below which a law acts no longer: that is its reach.
_ACTS = 1e-6
# Gaps at which the slope of a law is sampled to find its maximum, and at most so many doublings to find its reach.
_SAMPLES = 4097
_DOUBLINGS = 200


class Interaction(Part, abc.ABC):
    """The attraction of two surfaces: a tension, Pa, that depends on the gap, m, where they do not touch.

    Repulsion is not part of it: the surfaces cannot overlap. A class of your own gives the tension, its derivative and
    its integral; arrays in the fields of an attrs class, of the grid's shape (nx, ny), make it vary from cell to cell.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact._parts.interactions import Interaction
    >>> class Linear(Interaction):
    ...     def tension(self, gap):
    ...         return 5e6 * np.maximum(1.0 - gap / 1e-8, 0.0)
    ...
    ...     def slope(self, gap):
    ...         return np.where(gap < 1e-8, -5e14, 0.0)
    ...
    ...     def energy(self, gap):
    ...         return -0.025 * np.maximum(1.0 - gap / 1e-8, 0.0) ** 2
    >>> law = Linear()
    >>> print(f"{law.work:g} J/m2, {law.strength / 1e6:g} MPa")
    0.025 J/m2, 5 MPa
    """

    @abc.abstractmethod
    def tension(self, gap: RealArray) -> RealArray:
        """Return the tension at a gap of at least zero, m; Pa, not negative, of the shape and precision of the gap."""

    @abc.abstractmethod
    def slope(self, gap: RealArray) -> RealArray:
        """Return the derivative of the tension with respect to the gap, Pa/m, usually not positive."""

    @abc.abstractmethod
    def energy(self, gap: RealArray) -> RealArray:
        """Return the energy per area, J/m2, whose derivative is the tension: -`work` at zero, zero far away."""

    @property
    def work(self) -> float | Array:
        """Work of adhesion, J/m2: a number, or an array (nx, ny)."""
        return _number_or_array(-self.energy(np.zeros(())))

    @property
    def strength(self) -> float | Array:
        """Tension of surfaces that just touch, Pa: a number, or an array (nx, ny)."""
        return _number_or_array(self.tension(np.zeros(())))

    @property
    def reach(self) -> float:
        """Gap beyond which the energy is less than a millionth of the work of adhesion, m."""
        work = np.asarray(self.work)
        gap = float(np.max(work / np.asarray(self.strength)))
        for _ in range(_DOUBLINGS):
            if np.all(np.abs(self.energy(np.asarray(gap))) <= _ACTS * work):
                return gap
            gap *= 2.0
        raise InputError(f"The interaction {self!r} has no reach: its energy does not fall to zero with the gap.")

    @property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope, Pa/m, of all cells."""
        gaps = np.append(0.0, np.geomspace(1e-9, 1.0, _SAMPLES)) * self.reach
        return max(float(np.abs(self.slope(np.asarray(gap))).max()) for gap in gaps)

    def cohesive_cells(self, spacing: Pair, modulus: float) -> float:
        """Return the number of cells along the cohesive length E*/`steepest`, the longer side of a cell counting.

        Below 2.5 the edge of the contact starts to stick to the cells: use a longer range, or smaller cells.
        """
        longer = max(pair(spacing, "The cell", "m", above=0.0))
        return number(modulus, "The contact modulus", "Pa", above=0.0) / (self.steepest * longer)

    def resolve(self, spacing: Pair, modulus: float) -> Interaction:
        """Return the law for a grid and a contact modulus, Pa; by default itself."""
        return self

    def scaled(self, length: float, pressure: float) -> Interaction:
        """Return the law in units of a length, m, and a pressure, Pa."""
        return _Scaled(self, length, pressure)

    def convert(self, function: Callable[[Array], Array]) -> Interaction:
        """Return the law with each of its arrays (nx, ny) converted, as to a part of the grid; itself without any."""
        law: Any = self
        values = {name: getattr(law, field.name) for name, field in arguments_of(type(law)).items()}
        arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray) and value.ndim == 2}
        changes = {name: function(value) for name, value in arrays.items()}
        converted: Interaction = attrs.evolve(law, **changes) if changes else law
        return converted


interactions = Registry(Interaction, "interaction", "roughcontact.interactions")


def _number_or_array(value: Any) -> float | Array:
    values = np.asarray(value, dtype=np.float64)
    return float(values) if values.ndim == 0 else values


@attrs.frozen(eq=False)
class _Scaled(Interaction):
    """A law in other units, evaluated in float64: its SI values may be beyond the range of float32."""

    law: Interaction
    length: float
    pressure: float

    def tension(self, gap: RealArray) -> RealArray:
        return self._evaluate(self.law.tension, gap, self.pressure)

    def slope(self, gap: RealArray) -> RealArray:
        return self._evaluate(self.law.slope, gap, self.pressure / self.length)

    def energy(self, gap: RealArray) -> RealArray:
        return self._evaluate(self.law.energy, gap, self.pressure * self.length)

    @property
    def reach(self) -> float:
        """Gap beyond which the energy is less than a millionth of the work of adhesion."""
        return self.law.reach / self.length

    @property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope."""
        return self.law.steepest / (self.pressure / self.length)

    def convert(self, function: Callable[[Array], Array]) -> Interaction:
        """Return the law with each of its arrays converted."""
        return _Scaled(self.law.convert(function), self.length, self.pressure)

    def _evaluate(self, function: Callable[[RealArray], RealArray], gap: RealArray, unit: float) -> RealArray:
        gaps = np.asarray(gap)
        values = np.asarray(function(gaps.astype(np.float64) * self.length)) / unit
        # Of a single gap a law of arrays returns one value for each cell.
        shape = gaps.shape if gaps.ndim else values.shape
        return returned_array(values, shape, f"The interaction {self.law!r}").astype(gaps.dtype, copy=False)


@attrs.frozen(eq=False)
class BoundInteraction:
    """A law in the dimensionless variables of a `Task`: all that a solver sees of an interaction.

    Parameters
    ----------
    law
        The law, in SI units.
    length
        Unit of the gap, m.
    pressure
        Unit of the pressure, Pa.
    """

    law: Interaction
    length: float = 1.0
    pressure: float = 1.0

    @cached_property
    def _scaled(self) -> Interaction:
        return self.law.scaled(self.length, self.pressure)

    def tension(self, gap: RealArray) -> RealArray:
        """Return the tension at a gap of at least zero, of its shape and precision."""
        return self._scaled.tension(gap)

    def slope(self, gap: RealArray) -> RealArray:
        """Return the derivative of the tension with respect to the gap."""
        return self._scaled.slope(gap)

    def energy(self, gap: RealArray) -> RealArray:
        """Return the energy per area, whose derivative is the tension."""
        return self._scaled.energy(gap)

    @cached_property
    def strength(self) -> float | Array:
        """Tension of surfaces that just touch: a number, or an array (nx, ny)."""
        return self._scaled.strength

    @cached_property
    def steepest(self) -> float:
        """Maximum of the magnitude of the slope; with lengths in cells and E* = 1, one over the cohesive length."""
        return self._scaled.steepest

    @cached_property
    def reach(self) -> float:
        """Gap beyond which the law acts no longer."""
        return self._scaled.reach

    def convert(self, function: Callable[[Array], Array]) -> BoundInteraction:
        """Return the interaction with each array (nx, ny) of its law converted; itself if it has none."""
        law = self.law.convert(function)
        return self if law is self.law else attrs.evolve(self, law=law)

    def stretched(self, factor: float) -> BoundInteraction:
        """Return the interaction with its range times a factor and its strength over it: the same work of adhesion."""
        return attrs.evolve(self, length=self.length / factor, pressure=self.pressure * factor)

    def weakened(self, fraction: float) -> BoundInteraction:
        """Return the interaction with its work of adhesion and its strength times a fraction: the same range."""
        return attrs.evolve(self, pressure=self.pressure / fraction)
