"""Residual stress by depth, of a body that is peened, ground or hardened."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Array, Part


def _profile(values: object, what: str, unit: str) -> Array:
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim != 1 or found.size == 0 or not (np.abs(found) <= 1e60).all():
        raise rc.InputError.about(what, values, f"a list of finite numbers ({unit})")
    found.flags.writeable = False
    return found


def _depth(values: object) -> Array:
    what = "The depths of a residual stress"
    found = _profile(values, what, "m")
    if found[0] < 0.0 or not (np.diff(found) > 0.0).all():
        raise rc.InputError.about(what, values, "a list of finite numbers from 0 at the surface, ascending (m)")
    return found


def _stress(values: object) -> Array:
    return _profile(values, "The residual stress", "Pa")


@attrs.frozen
class ResidualStress(Part):
    r"""A residual stress below a surface that is peened, ground or hardened: equal along x and y, varying with depth.

    :math:`\sigma_{xx} = \sigma_{yy} = s(z)` is in equilibrium, so that it changes neither gap nor pressure, but where
    the body first yields, ``FirstYield(residual=...)``, and how it flows, ``Plastic(residual=...)``. Between the depths
    it is linear, beyond them constant.

    Parameters
    ----------
    depth
        Depths below the surface, ascending, m.
    stress
        The stress at each of them, Pa; tension is positive.

    Examples
    --------
    >>> from roughcontact_volume import ResidualStress
    >>> peened = ResidualStress(depth=["0um", "50um", "200um"], stress=["-400MPa", "-600MPa", "0MPa"])
    >>> peened.find_stress([25e-6, 1e-3])[0] / 1e6
    array([-500.,    0.])
    """

    depth: Array = attrs.field(converter=_depth, eq=tuple, metadata={"unit": "m"})
    stress: Array = attrs.field(converter=_stress, eq=tuple, metadata={"unit": "Pa"})

    def __attrs_post_init__(self) -> None:
        if self.depth.size != self.stress.size:
            raise rc.InputError(
                f"A residual stress needs a stress at each depth, but it has {self.depth.size} depths and "
                f"{self.stress.size} stresses."
            )

    def find_stress(self, depth: npt.ArrayLike) -> Array:
        """Return the components xx, yy, zz, yz, xz, xy at depths, m; shape (6, depths), Pa."""
        depth = np.atleast_1d(np.asarray(depth, dtype=np.float64))
        stress = np.zeros((6, depth.size))
        stress[:2] = np.interp(depth, self.depth, self.stress)
        return stress

    def find_largest(self, depth: float = 0.0) -> float:
        """Return the largest von Mises stress at a depth, m, and below it, Pa."""
        deeper = np.concatenate(([depth], self.depth[self.depth > depth]))
        return float(np.abs(self.find_stress(deeper)[0]).max())

    def find_mean_stress(self, thicknesses: npt.ArrayLike) -> Array:
        """Return the components, means over layers from the surface down, shape (6, layers), Pa.

        Parameters
        ----------
        thicknesses
            Thicknesses of the layers, m.
        """
        ends = np.concatenate(([0.0], np.cumsum(np.asarray(thicknesses, dtype=np.float64))))
        # The integral of a linear piece is exact by its ends.
        points = np.union1d(ends, self.depth[self.depth < ends[-1]])
        values = self.find_stress(points)[0]
        pieces = 0.5 * (values[1:] + values[:-1]) * np.diff(points)
        integral = np.concatenate(([0.0], np.cumsum(pieces)))[np.searchsorted(points, ends)]
        stress = np.zeros((6, ends.size - 1))
        stress[:2] = np.diff(integral) / np.diff(ends)
        return stress
