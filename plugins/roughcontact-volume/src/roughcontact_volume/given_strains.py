"""Regions that strain by themselves: swollen or heated."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, LoadIncrement

from roughcontact_volume.mixtures import fill
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.refusals import require_uniform
from roughcontact_volume.shapes import Shape, Triple, read_centre, read_shape, read_side

# Strains beyond it are not small.
_MAX_STRAIN = 0.1


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
