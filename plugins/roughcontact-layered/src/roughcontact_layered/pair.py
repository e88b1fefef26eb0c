"""Two bodies that are both layered or graded."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import roughcontact as rc

from roughcontact_layered.bodies import require_sum
from roughcontact_layered.graded import GradedKernel
from roughcontact_layered.kernel import LayeredKernel
from roughcontact_layered.stack import Array

OneBody: TypeAlias = LayeredKernel | GradedKernel


def _one_body(value: object) -> OneBody:
    if isinstance(value, (LayeredKernel, GradedKernel)):
        return value
    allowed = "a LayeredKernel or a GradedKernel (two crystals: AnisotropicKernel((one, other)))"
    raise rc.InputError.about("The kernel of one of two bodies", value, allowed)


@attrs.frozen
class PairKernel(rc.InfluenceKernel):
    r"""Both bodies with a kernel of their own, frictionless: their displacements add.

    .. math:: \hat u(q) = [\hat u_\mathrm{body}(q) + \hat u_\mathrm{counterbody}(q)]\,\hat p(q)

    Each kernel describes one body of the contact problem, whose material is as for this kernel alone. Where only one
    of the bodies has layers, its kernel alone is enough.

    Parameters
    ----------
    body, counterbody
        The kernel of each body of the contact problem.

    Raises
    ------
    roughcontact.InputError
        If a kernel is of another kind; and, when the kernel is used, if the bodies are made of something else.

    Examples
    --------
    Two steel bodies with the same coating yield twice as far as one on a rigid flat:

    >>> import roughcontact as rc
    >>> from roughcontact_layered import Layer, LayeredKernel, PairKernel
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> coating = LayeredKernel(Layer(young=400e9, poisson=0.25, thickness=2e-6), substrate=steel)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> flat = rc.Body(rc.FlatSurface(), steel)
    >>> grid = rc.Grid((64, 64), 100e-6)
    >>> pair = PairKernel(body=coating, counterbody=coating)
    >>> both = rc.ContactProblem(ball, flat, grid=grid, kernel=pair).solve(force=1.0)
    >>> one = rc.ContactProblem(ball, grid=grid, kernel=coating).solve(force=2.0)
    >>> print(f"{both.approach / one.approach:.6f}")
    1.000000
    """

    body: OneBody = attrs.field(converter=_one_body)
    counterbody: OneBody = attrs.field(converter=_one_body)

    def __str__(self) -> str:
        return f"on the body {self.body}; on the counterbody {self.counterbody}"

    def part_of(self, body: str) -> OneBody:
        """Return the kernel of the ``"body"`` or of the ``"counterbody"``."""
        return self.body if body == "body" else self.counterbody

    def response(self, q: Array, compliance: float) -> Array:
        """Return the displacement amplitude by a pressure wave of amplitude one; see `LayeredKernel.response`."""
        return np.asarray(sum(part.response(q, own) for part, own in self._require(compliance)))

    def effective_modulus(self, wavenumber: Array, compliance: float) -> Array:
        """Return 2 / (q u(q)), the contact modulus at each wave number, shape (n,), Pa."""
        return np.asarray(2.0 / (wavenumber * self.response(wavenumber, compliance)))

    def coefficients(self, shape: tuple[int, int], spacing: tuple[float, float], compliance: float) -> Array:
        """Return the influence coefficients, shape (nx, ny), m/Pa."""
        return np.asarray(sum(part.coefficients(shape, spacing, own) for part, own in self._require(compliance)))

    def spectrum(self, qx: Array, qy: Array, spacing: tuple[float, float], compliance: float) -> Array:
        """Return the response at the cell centres to waves of cell pressures, shape (m, n), m/Pa."""
        return np.asarray(sum(part.spectrum(qx, qy, spacing, own) for part, own in self._require(compliance)))

    def _require(self, compliance: float) -> list[tuple[OneBody, float]]:
        """Return each kernel with 1/E* of its body alone, if these are those of the bodies."""
        parts = (self.body, self.counterbody)
        own = [part.own_material.compliance for part in parts]
        require_sum([repr(part.own_material) for part in parts], own, compliance)
        return list(zip(parts, own, strict=True))
