"""Relaxation of viscoelastic bodies, as a process that remembers their displacements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.materials import Viscoelastic
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.laws import Memory, Process
from roughcontact._solve.solution.load_increment import LoadIncrement


@attrs.frozen
class _Steps:
    """A body in an increment: its plane-strain moduli, what is left of each, and its mean in the increment."""

    moduli: Array
    left: Array
    part: Array

    @property
    def effective(self) -> float:
        """The plane-strain modulus against a displacement that grows evenly in the increment, Pa."""
        return float(self.moduli[0] + math.fsum(self.moduli[1:] * self.part))


@attrs.frozen
class Relaxation(Process):
    r"""The relaxation of viscoelastic bodies under loads or approaches over time: `ContactProblem.path` brings it.

    With v the displacement by the pressure for a plane-strain modulus of one, that of a body is

    .. math:: u = \frac{v - C}{E_{\text{eff}}}, \quad E_{\text{eff}} = E_\infty + \sum_i E_i \varphi_i, \quad
       C = \sum_i e_i r_i - u_0 \sum_i E_i \varphi_i

    with :math:`e_i = e^{-\Delta t/\tau_i}` and :math:`\varphi_i = (1 - e_i) \tau_i / \Delta t`, exact for displacements
    that change evenly in an increment. It remembers u and the part of the pressure of each term as a displacement,
    :math:`r_i \leftarrow e_i r_i + E_i \varphi_i (u - u_0)`. No inverse is needed, on any boundary; the contact of an
    increment is one of a stiffer body on a changed gap.

    Parameters
    ----------
    body, counterbody
        The materials that relax; None: this body does not.

    References
    ----------
    Simo, Hughes, Computational Inelasticity (1998), chapter 10, https://doi.org/10.1007/b98904

    Examples
    --------
    >>> import roughcontact as rc
    >>> rubber = rc.Viscoelastic(moduli=["1MPa", "3MPa"], times=["10ms"], poisson=0.5)
    >>> body = rc.Body(rc.ParaboloidSurface(radius=10e-3), rubber)
    >>> path = rc.ContactProblem(body, grid=rc.Grid((32, 32), 3e-3)).path(approach="20um", time=["0s", "1s"])
    >>> print(path[0].origin.scene.laws[0].body.times, f"{path.force[1] / path.force[0]:.3f}")
    (0.01,) 0.250
    """

    body: Viscoelastic | None = None
    counterbody: Viscoelastic | None = None

    rates: ClassVar[tuple[str, ...]] = ("time",)
    follows_bodies: ClassVar[bool] = True

    # The offset of an increment is not smooth at the last edge of the contact, which estimators by Hertz would read.
    default_area: ClassVar[str] = "level-set"
    keeps_modulus: ClassVar[bool] = False

    @property
    def remembered(self) -> Mapping[str, tuple[str, str]]:  # type: ignore[override]
        """Displacement of each body, and the stress of each term over its wave, as displacement times modulus."""
        found = {}
        for side, material in self._list_sides():
            found[f"displacement_of_{side}"] = (f"displacement of the {side}", "m")
            for number in range(1, len(material.times) + 1):
                found[f"term_{number}_of_{side}"] = (f"term {number} of the relaxing {side}", "N/m")
        return found

    def _list_sides(self) -> Sequence[tuple[str, Viscoelastic]]:
        pairs = (("body", self.body), ("counterbody", self.counterbody))
        return [(side, material) for side, material in pairs if material is not None]

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return what is left of the displacements before, m; see `Law.change_gap`."""
        total = np.zeros(problem.plan.grid.shape)
        for side, material in self._list_sides():
            steps = _divide_time(material, increment.time)
            rest = _find_rest(side, steps, memory) / steps.effective
            total -= increment.place(rest) if side == "counterbody" else rest
        return total

    def find_stiffening(self, problem: Any, increment: LoadIncrement, memory: Memory) -> float:
        """Return the contact modulus in the increment over that of a load that acts at once; see `Law`."""
        compliance = sum(side.material.compliance for side in (problem.body, problem.counterbody))
        slow = compliance
        for _, material in self._list_sides():
            slow += 1.0 / _divide_time(material, increment.time).effective - material.compliance
        return float(compliance / slow)

    def remember(self, state: ContactSolution, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the displacements and terms after an increment."""
        # The displacement of the state is that by its pressure on bodies of its modulus.
        unit = state.displacement * state.modulus
        found = {}
        for side, material in self._list_sides():
            steps = _divide_time(material, increment.time)
            before = memory[f"displacement_of_{side}"]
            moved = unit if side == "body" else increment.place_back(unit)
            after = (moved - _find_rest(side, steps, memory)) / steps.effective
            found[f"displacement_of_{side}"] = after
            for number, (modulus, left, part) in enumerate(
                zip(steps.moduli[1:], steps.left, steps.part, strict=True), 1
            ):
                term = memory[f"term_{number}_of_{side}"]
                found[f"term_{number}_of_{side}"] = left * term + modulus * part * (after - before)
        return found


def _divide_time(material: Viscoelastic, time: float) -> _Steps:
    ratio = time / np.array(material.times)
    # A step of load has no length.
    part = np.where(ratio > 0.0, -np.expm1(-ratio) / np.where(ratio > 0.0, ratio, 1.0), 1.0)
    moduli = np.array(material.moduli) / (1.0 - material.poisson**2)
    return _Steps(moduli=moduli, left=np.exp(-ratio), part=part)


def _find_rest(side: str, steps: _Steps, memory: Memory) -> Array:
    """Return the pressure that is left without a further displacement, less what holds the old one, N/m."""
    rest = -float(np.sum(steps.moduli[1:] * steps.part)) * memory[f"displacement_of_{side}"]
    for number, left in enumerate(steps.left, 1):
        rest = rest + left * memory[f"term_{number}_of_{side}"]
    return np.asarray(rest)
