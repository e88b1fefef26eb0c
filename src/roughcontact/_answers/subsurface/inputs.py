"""What is given for the stress below a surface: depths, a traction or a friction, a body, a residual stress."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np

from roughcontact._base.arrays import Array, frozen_array, unit_vector
from roughcontact._base.checks import choice, number, numbers
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError

# Largest coefficient of friction for which the stress is computed.
MAX_LOAD_RATIO = 1e6
_ALLOWED_TRACTION = "numbers of shape (2, nx, ny), along x and y (Pa)"
_ALLOWED_FRICTION = "a number from 0 to 1e6, or such numbers of the shape of the grid"
_ALLOWED_DEPTHS = "a number or a list of numbers (m), from 0 at the surface to 1e60"


@runtime_checkable
class SupportsResidualStress(Protocol):
    """A stress that a body has without a load, by depth."""

    @property
    def depth(self) -> Array:
        """Depths between which it changes, m."""

    def find_stress(self, depth: Array) -> Array:
        """Return the components xx, yy, zz, yz, xz, xy at depths, m; shape (6, depths), Pa; tension is positive."""


def read_residual(value: Any) -> SupportsResidualStress | None:
    """Return a residual stress, or raise `InputError`."""
    if value is None or isinstance(value, SupportsResidualStress):
        return value
    allowed = "None or an object with depth and find_stress, such as roughcontact_volume.ResidualStress"
    raise InputError.about("The residual stress", value, allowed)


def read_depths(value: Any) -> Array | None:
    """Return depths, shape (depths,), m, or raise `InputError`."""
    if value is None:
        return None
    depths = np.atleast_1d(numbers(value, "The depths", _ALLOWED_DEPTHS, "m"))
    if depths.ndim != 1 or depths.size == 0 or not np.all((depths >= 0.0) & (depths <= 1e60)):
        raise InputError.about("The depths", value, _ALLOWED_DEPTHS)
    return frozen_array(depths)


def read_traction(value: Any) -> Array | None:
    """Return a traction, whose shape is not checked, or raise `InputError`."""
    return None if value is None else frozen_array(numbers(value, "The traction", _ALLOWED_TRACTION, "Pa"))


def coefficient(value: Any) -> Array | None:
    """Return a coefficient of friction, shape () or (nx, ny), or raise `InputError`."""
    if value is None:
        return None
    found = numbers(value, "The coefficient of friction", _ALLOWED_FRICTION)
    if isinstance(value, bool) or found.ndim not in (0, 2) or not np.all((found >= 0.0) & (found <= MAX_LOAD_RATIO)):
        raise InputError.about("The coefficient of friction", value, _ALLOWED_FRICTION)
    return frozen_array(found).reshape(found.shape)


def degrees(value: Any) -> float:
    """Return a direction in degrees, or raise `InputError`."""
    return number(value, "The direction", "degrees from the x axis")


def sliding_traction(solution: ContactSolution, friction: Array, direction: float) -> Array:
    """Return the traction on the body in full sliding, shape (2, nx, ny), Pa, along a direction in degrees."""
    shape = solution.grid.shape
    if friction.ndim and friction.shape != shape:
        raise InputError.about("The shape of the coefficient of friction", friction.shape, f"() or {shape}")
    limit = friction * solution.contact_pressure
    return np.array(unit_vector(direction))[:, np.newaxis, np.newaxis] * limit


def body_name(value: str) -> str:
    """Return the name of one of the bodies, or raise `InputError`."""
    return choice(value, "The body", ("body", "counterbody"))
