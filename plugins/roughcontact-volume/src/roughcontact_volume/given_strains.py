"""Given strains: residual stress by depth, and regions that swell or are heated."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Array, LoadIncrement, Part

from roughcontact_volume.mixtures import fill
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.refusals import require_uniform
from roughcontact_volume.shapes import Shape, Triple, read_centre, read_shape, read_side

# Strains beyond it are not small.
_MAX_STRAIN = 0.1


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


@attrs.frozen(eq=False)
class ResidualStress(Part):
    r"""A residual stress below a surface that is peened, ground or hardened: equal along x and y, varying with depth.

    It changes neither gap nor pressure, :math:`\sigma_{xx} = \sigma_{yy} = s(z)`, but where the body first yields:
    ``FirstYield(residual=...)``. Between the depths it is linear, beyond them constant.

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

    depth: Array = attrs.field(converter=_depth, metadata={"unit": "m"})
    stress: Array = attrs.field(converter=_stress, metadata={"unit": "Pa"})

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


def _strain(values: object) -> tuple[float, ...]:
    allowed = f"a number, or the components xx, yy, zz, yz, xz, xy, of at most {_MAX_STRAIN:g}"
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if isinstance(values, bool) or found.shape not in ((), (1,), (6,)) or not (np.abs(found) <= _MAX_STRAIN).all():
        raise rc.InputError.about("The strain of a region", values, allowed)
    return tuple(found.tolist()) if found.size == 6 else (float(found.item()),) * 3 + (0.0,) * 3


@attrs.frozen
class StrainedRegion(rc.Law):
    r"""A region of a body that would strain if it were free: heated, swollen or transformed. A law of a problem.

    It lifts the surface by the displacement :math:`-U e` and leaves the stress :math:`T e`, `find_stress`, whatever
    the load. Cells that its boundary cuts have a part of the strain.

    Parameters
    ----------
    shape
        A `Sphere`, an `Ellipsoid` or a `Cuboid`.
    strain
        Its strain if it were free: a number, equal in all directions, such as the thermal expansion times the rise of
        the temperature, or six components xx, yy, zz, yz, xz, xy, shears as those of the tensor.
    centre
        Its centre (x, y, depth), m; x and y from the middle of the domain.
    side
        The body in which it lies, ``"body"`` or ``"counterbody"``.

    References
    ----------
    Eshelby, Proc. R. Soc. Lond. A 241 (1957) 376-396, https://doi.org/10.1098/rspa.1957.0133

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Sphere, StrainedRegion
    >>> hot = StrainedRegion(Sphere("20um"), 1.2e-3, centre=(0.0, 0.0, "35um"))
    >>> ball = rc.Body(rc.SphereSurface("5mm"), rc.Elastic("210GPa", 0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), "200um"), laws=hot)
    >>> problem.solve(force="10N").certificate.error < 1e-5
    True
    """

    shape: Shape = attrs.field(converter=read_shape)
    strain: tuple[float, ...] = attrs.field(converter=_strain, metadata={"unit": ""})
    centre: Triple = attrs.field(converter=read_centre, metadata={"unit": "m"})
    side: str = attrs.field(default="body", converter=read_side, kw_only=True)

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Mapping[str, Array]) -> Array:
        """Return the displacement of the surface, m; see `Law.change_gap`."""
        return self._find_field(problem).displacement

    def find_stress(self, problem: Any) -> tuple[Array, Array]:
        """Return depths between layers, shape (nz + 1,), m, and the stress in them, shape (6, nz, nx, ny), Pa."""
        field = self._find_field(problem)
        return field.interfaces, field.stress

    def explain_limits(self, memory: Mapping[str, Array]) -> Mapping[str, str]:
        """Return that it leaves a stress; see `Law.explain_limits`."""
        return {"inner stress": "a strained region leaves a stress of its own, StrainedRegion.find_stress"}

    def list_numbers(self, state: Any, memory: Mapping[str, Array]) -> Mapping[str, tuple[float, str]]:
        """Return how far the surface rises, m."""
        return {"rise_by_strain": (float(-self._find_field(state.origin.scene).displacement.min()), "m")}

    def _find_field(self, problem: Any) -> _StrainField:
        material = getattr(problem, self.side).material
        require_uniform(problem, material, "A strained region")
        return _find_field(
            self.shape, self.strain, self.centre, problem.plan.grid, problem.boundary, material.young, material.poisson
        )


@attrs.frozen(eq=False)
class _StrainField:
    """The displacement of a surface, m, and the stress, Pa, by a strain in layers between `interfaces`, m."""

    interfaces: Array
    displacement: Array
    stress: Array


@lru_cache(maxsize=4)
def _find_field(
    shape: Shape,
    strain: tuple[float, ...],
    centre: Triple,
    grid: rc.Grid,
    boundary: rc.Boundary,
    young: float,
    poisson: float,
) -> _StrainField:
    interfaces, (fractions,) = fill([(shape, centre)], grid, boundary)
    if not fractions.any():
        raise rc.InputError("The strained region is smaller than a cell: refine the grid.")
    operators = VolumeOperators(grid, boundary, np.diff(interfaces), young, poisson)
    field = np.array(strain)[:, np.newaxis, np.newaxis, np.newaxis] * fractions
    return _StrainField(interfaces, operators.displace(field), operators.find_stress(field))
