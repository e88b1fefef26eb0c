"""Viscoelastic bodies that slide steadily at a speed, as a law by which their displacement lags behind the pressure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Pair, Waves, unit_vector
from roughcontact._base.checks import number
from roughcontact._base.units import Estimate
from roughcontact._parts.kernels import InfluenceKernel, SupportsCoefficients, missing_form
from roughcontact._parts.materials import Material, Viscoelastic
from roughcontact._parts.surfaces import FlatSurface
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.flattening import find_softer
from roughcontact._solve.solution.laws import Law, Memory
from roughcontact._solve.solution.load_increment import LoadIncrement
from roughcontact.errors import InputError, argument


def _speed(value: object) -> float:
    return number(value, "The sliding speed", "m/s", above=0.0)


def _direction(value: object) -> float:
    return number(value, "The direction of sliding", "degrees")


@attrs.frozen
class SteadySliding(Law):
    r"""Steady sliding of viscoelastic bodies at a speed: `ContactProblem.slide` brings it.

    The counterbody slides over the body, and one of them is flat: its material passes below the heights of the other
    with the velocity :math:`V`, so that a wave :math:`q` of the pressure loads it with the angular frequency
    :math:`q \cdot V`. The displacement lags behind,

    .. math:: \hat u(q) = \hat K(q)\, \overline{J(q \cdot V)}\, \hat p(q), \quad J(\omega) = 1 / E^*(i\omega)

    with the kernel :math:`K` of a modulus of one. The body with the heights, whose pressure does not change, is
    relaxed; so is at any speed the flat one for waves that do not vary along the direction.

    The contact is that of bodies with the magnitude of the complex modulus of each wave, solved by turns with what is
    left of the displacement by the pressure before. The last pressure is certified as a contact of bodies on which the
    load acts at once, with the gap that the lag has left: its residual is the error of the turns too. They are tens,
    and up to two hundred where the loss modulus is ten times the storage modulus.

    Parameters
    ----------
    speed
        Speed of the counterbody over the body, m/s.
    direction
        Its direction, from x towards y, degrees. The boundary must be periodic along it.

    References
    ----------
    Hunter, J. Appl. Mech. 28 (1961) 611-617

    Examples
    --------
    >>> import roughcontact as rc
    >>> rubber = rc.Body(rc.FlatSurface(), rc.Viscoelastic(["1MPa", "9MPa"], ["1ms"], poisson=0.5))
    >>> road = rc.Body(rc.WavySurface(5e-6, 1e-3), rc.Rigid())
    >>> problem = rc.ContactProblem(rubber, road, grid=rc.Grid((32, 32), 1e-3), boundary="periodic")
    >>> for speed in ("1mm/s", "0.1m/s", "10m/s"):
    ...     print(f"{problem.slide(pressure=50e3, speed=speed).friction_coefficient.value:.4f}")
    0.0004
    0.0156
    0.0002
    """

    speed: float = attrs.field(converter=_speed, metadata={"unit": "m/s"})
    direction: float = attrs.field(default=0.0, converter=_direction, metadata={"unit": "degrees"})

    rates: ClassVar[tuple[str, ...]] = ()
    keeps_modulus: ClassVar[bool] = False
    default_area: ClassVar[str] = "level-set"

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return zeros: all that it changes follows from the pressure; see `Law.change_gap`."""
        return np.zeros(problem.plan.grid.shape)

    def soften(self, problem: Any) -> InfluenceKernel:
        """Return the kernel of bodies with the magnitude of the modulus of each wave; see `Law.soften`."""
        kernel: InfluenceKernel = problem.plan.kernel
        passage = self._find_passage(problem)
        return kernel if passage is None else _Dynamic(kernel, passage)

    def respond(self, problem: Any, displacement: Array) -> Array:
        """Return by how much the displacement exceeds that of a load that acts at once; see `Law.respond`."""
        passage = self._find_passage(problem)
        return np.zeros(displacement.shape) if passage is None else passage.lag(problem.plan, displacement)

    def list_numbers(self, state: ContactSolution, memory: Memory) -> Mapping[str, Estimate | tuple[float, str]]:
        """Return the friction coefficient by the energy that the bodies lose, and its power, W.

        The uncertainty is the difference to the coefficient by the slopes of the heights.
        """
        assert state.origin is not None
        problem = state.origin.scene
        passage = self._find_passage(problem)
        load = float(state.pressure.sum())
        if passage is None or load == 0.0:
            return {}
        if state.saturated.any():
            self._require_hard_flat(problem)
        added = passage.lag(problem.plan, state.displacement)
        lost, along_heights = (
            -float(np.sum(state.pressure * passage.find_slope(problem.plan, moved)))
            for moved in (state.displacement + added, added - state.initial_gap)
        )
        error = abs(along_heights - lost)
        rate = state.grid.cell_area * self.speed
        return {
            "friction_coefficient": Estimate(lost / load, error / load, ""),
            "dissipated_power": Estimate(lost * rate, error * rate, "W"),
        }

    def _require_hard_flat(self, problem: Any) -> None:
        """Refuse that the flat body is flattened, whose surface passes: it would be another one each time."""
        part = find_softer(problem)
        if np.any(part if isinstance(problem.body.surface, FlatSurface) else np.subtract(1.0, part)):
            raise InputError(
                "The pressure reaches the hardness of the flat body, which passes below the heights and is flattened "
                "all along: this is not steady. Choose a smaller load, or a harder flat body."
            )

    def _find_passage(self, problem: Any) -> _Passage | None:
        """Return how the bodies pass; None if none of them relaxes. `InputError` unless sliding can be steady."""
        sides = (problem.body, problem.counterbody)
        if not any(isinstance(side.material, Viscoelastic) for side in sides):
            return None
        flat = next((number for number, side in enumerate(sides) if isinstance(side.surface, FlatSurface)), None)
        if flat is None:
            raise InputError(
                "Sliding is steady where one of the bodies is flat, but both have heights, which pass over each other: "
                f"give one of them {argument('surface', 'rc.FlatSurface()')}, or follow a path over time."
            )
        other = next((law for law in problem.laws if not law.keeps_modulus and law != self), None)
        if other is not None:
            raise InputError(
                f"Bodies that slide steadily have relaxed as their speed allows: omit {other!r} beside {self!r}."
            )
        plan = problem.plan
        if plan.sampled_moduli is not None:
            raise InputError(
                f"Viscoelastic bodies slide at a speed as isotropic half-spaces, but the kernel is {plan.kernel!r}."
            )
        if plan.interaction is not None:
            raise InputError(f"Viscoelastic bodies slide without {argument('adhesion')}: omit it.")
        x, y = unit_vector(self.direction)
        for name, component, repeats in zip("xy", (x, y), plan.boundary.repeats, strict=True):
            if component != 0.0 and not repeats:
                raise InputError(
                    f"Steady sliding needs a boundary that is periodic along its direction, but along {name} it is "
                    f"{plan.boundary!s}: nothing tells what the material has met before it enters the domain. Give "
                    f"{argument('boundary', 'periodic')}, and a domain that is long beside the contact."
                )
        # The velocity of the heights over the flat body.
        speed = self.speed if flat == 0 else -self.speed
        return _Passage(sides[flat].material, sides[1 - flat].material, (speed * x, speed * y))


@attrs.frozen
class _Passage:
    """The material of the flat body, that of the other, and the velocity of its heights over the flat one, m/s."""

    flat: Material
    rough: Material
    velocity: Pair

    def find_ratio(self, qx: Array, qy: Array) -> Waves:
        """Return the compliance for waves, shapes (m, 1) and (1, n), rad/m, over that of a load that acts at once.

        Its shape broadcasts to theirs.
        """
        rest = _find_compliance(self.rough, np.zeros(1))
        at_once = self.flat.compliance + self.rough.compliance
        frequency = self._find_frequency(qx, qy)
        return np.asarray((np.conj(_find_compliance(self.flat, frequency)) + rest.real) / at_once)

    def _find_frequency(self, qx: Array, qy: Array) -> Array:
        """Return the angular frequency of waves, rad/s, of a shape that broadcasts to theirs."""
        x, y = self.velocity
        return qx * x if y == 0.0 else qy * y if x == 0.0 else qx * x + qy * y

    def lag(self, plan: Any, displacement: Array) -> Array:
        """Return what the displacement by a pressure, m, exceeds that of a load that acts at once."""
        return _multiply(plan, displacement, lambda qx, qy: self.find_ratio(qx, qy) - 1.0)

    def find_slope(self, plan: Any, values: Array) -> Array:
        """Return the slope of a field along the velocity."""
        speed = math.hypot(*self.velocity)
        return _multiply(plan, values, lambda qx, qy: self._find_frequency(qx, qy) * (1j / speed))


def _multiply(plan: Any, values: Array, find_factors: Callable[[Array, Array], Waves]) -> Array:
    """Return a field with each of its waves along the periodic axes multiplied by a factor.

    A wave of half the sampling number has the mean of the factors for both of its directions.
    """
    axes = [axis for axis, repeats in enumerate(plan.boundary.repeats) if repeats]
    qx, qy = (
        2.0 * np.pi / step * scipy.fft.fftfreq(n) if axis in axes else np.zeros(1)
        for axis, (n, step) in enumerate(zip(values.shape, plan.grid.spacing, strict=True))
    )
    factors = find_factors(qx[:, np.newaxis], qy[np.newaxis, :])
    if qy.size % 2 == 0 and factors.shape[1] > 1:
        last = qy.size // 2
        factors[:, last] += find_factors(qx[:, np.newaxis], -qy[np.newaxis, last:])[:, 0]
        factors[:, last] *= 0.5
    waves = scipy.fft.fftn(values, axes=axes)
    waves *= factors
    # The real part is that mean along x.
    return np.asarray(scipy.fft.ifftn(waves, axes=axes).real)


def _find_compliance(material: Material, frequency: Array) -> Waves:
    """Return the plane-strain compliance at angular frequencies, rad/s, 1/Pa."""
    if not isinstance(material, Viscoelastic):
        return np.full(frequency.shape, complex(material.compliance))
    modulus = np.full(frequency.shape, complex(material.moduli[0]))
    for one, time in zip(material.moduli[1:], material.times, strict=True):
        phase = 1j * frequency * time
        modulus += one * (phase / (1.0 + phase))
    return np.asarray((1.0 - material.poisson**2) / modulus)


@attrs.frozen
class _Dynamic(InfluenceKernel):
    """The response of bodies with the magnitude of the modulus of each wave, for both directions of y the mean.

    What is left is as large for all waves: beside the storage modulus, turns hardly change those of a large loss.
    """

    kernel: InfluenceKernel
    passage: _Passage

    def effective_modulus(self, wavenumber: Array, compliance: float) -> None:
        """Return None: it serves to solve, and not to answer."""
        return

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Raise `InputError`: it is known for waves."""
        raise missing_form(self, SupportsCoefficients)

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        """Return the response, shape (m, n), m/Pa; see `SupportsSpectrum`."""
        kernel: Any = self.kernel
        one, other = (np.abs(self.passage.find_ratio(qx, side * qy)) for side in (1.0, -1.0))
        return np.asarray(kernel.spectrum(qx, qy, spacing, compliance) * (0.5 * (one + other)))
