"""Viscoelastic materials: moduli that relax, as a series of exponentials."""

from __future__ import annotations

import math
from typing import Any, Self

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import list_of, number
from roughcontact._base.units import Quantity
from roughcontact._parts.materials.isotropic import Material, poisson_ratio
from roughcontact.errors import InputError

# Terms of a series over a decade of time by `from_master_curve`: two give the moduli of fractional bodies within 0.4 %.
_TERMS_PER_DECADE = 2
# Decades by which the times reach beyond the data on both sides.
_MARGIN = 0.5


def _values(values: object, what: str, unit: str) -> tuple[float, ...]:
    return tuple(
        number(value, what, unit, above=0.0)
        for value in list_of(values, what, f"a list of numbers above zero ({unit})")
    )


def _moduli(values: object) -> tuple[float, ...]:
    return _values(values, "A modulus of the series", "Pa")


def _times(values: object) -> tuple[float, ...]:
    return _values(values, "A relaxation time", "s")


@attrs.frozen
class Viscoelastic(Material):
    r"""Isotropic material whose Young's modulus relaxes at a constant Poisson's ratio.

    .. math:: E(t) = E_\infty + \sum_i E_i\, e^{-t / \tau_i}

    A single load acts at once, and meets the unrelaxed modulus; `ContactProblem.path` follows loads or approaches over
    time.

    Parameters
    ----------
    moduli
        The moduli E_inf, which never relaxes, and E_i, Pa, shape (n + 1,).
    times
        The relaxation times tau_i, s, shape (n,).
    poisson
        Poisson's ratio, above -1 and at most 0.5.

    Examples
    --------
    >>> import roughcontact as rc
    >>> rubber = rc.Viscoelastic(moduli=["1MPa", "3MPa"], times=["10ms"], poisson=0.5)
    >>> body = rc.Body(rc.ParaboloidSurface(radius=10e-3), rubber)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 3e-3))
    >>> path = problem.path(force=0.05, time=["0s", "10ms", "1s"])
    >>> [f"{depth * 1e6:.1f} µm" for depth in path.approach]
    ['16.8 µm', '23.7 µm', '42.7 µm']
    """

    moduli: tuple[float, ...] = attrs.field(converter=_moduli, metadata={"unit": "Pa"})
    times: tuple[float, ...] = attrs.field(converter=_times, metadata={"unit": "s"})
    poisson: float = attrs.field(converter=poisson_ratio, metadata={"unit": ""})

    def __attrs_post_init__(self) -> None:
        if len(self.moduli) != len(self.times) + 1:
            raise InputError(
                f"A series has one modulus that never relaxes and one for each relaxation time, but there are "
                f"{len(self.moduli)} moduli and {len(self.times)} times."
            )

    @property
    def compliance(self) -> float:
        """Plane-strain compliance of a load that acts at once, 1/Pa."""
        return (1.0 - self.poisson**2) / math.fsum(self.moduli)

    @property
    def pressure_limit(self) -> float:
        """Infinite."""
        return math.inf

    def relaxed(self, time: Quantity) -> float:
        """Return the modulus E(t) at a time after a step of strain, Pa."""
        after = number(time, "The time", "s", at_least=0.0)
        parts = (modulus * math.exp(-after / tau) for modulus, tau in zip(self.moduli[1:], self.times, strict=True))
        return math.fsum((self.moduli[0], *parts))

    def complex_modulus(self, frequency: Quantity) -> complex:
        """Return storage and loss modulus at an angular frequency, rad/s, as real and imaginary part, Pa."""
        omega = number(frequency, "The angular frequency", "", above=0.0)
        return self.moduli[0] + sum(
            modulus * 1j * omega * tau / (1.0 + 1j * omega * tau)
            for modulus, tau in zip(self.moduli[1:], self.times, strict=True)
        )

    @classmethod
    def from_master_curve(cls, frequency: Array, storage: Array, loss: Array, *, poisson: float) -> Self:
        """Return the series that fits measured moduli, two terms a decade, with the smallest relative squares.

        Parameters
        ----------
        frequency
            Angular frequencies, rad/s, shape (n,), over a decade at least.
        storage, loss
            Storage and loss modulus at them, Pa, shape (n,).
        poisson
            Poisson's ratio.

        Raises
        ------
        InputError
            If the arrays are not of numbers above zero and of one length, or no modulus is left.

        Examples
        --------
        >>> import numpy as np
        >>> import roughcontact as rc
        >>> omega = np.logspace(-2, 4, 25)
        >>> zener = 1e6 * (1 + 9 * (1j * omega) ** 0.5 / (1 + (1j * omega) ** 0.5))
        >>> rubber = rc.Viscoelastic.from_master_curve(omega, zener.real, zener.imag, poisson=0.5)
        >>> print(len(rubber.times), f"{rubber.complex_modulus(1.0).real / 1e6:.2f} MPa")
        14 5.50 MPa
        """
        # Half a second to import, and nothing else needs it.
        from scipy.optimize import lsq_linear

        omega = np.array(_values(frequency, "An angular frequency", "rad/s"))
        real = np.array(_values(storage, "A storage modulus", "Pa"))
        imaginary = np.array(_values(loss, "A loss modulus", "Pa"))
        alike = 0 < omega.size == real.size == imaginary.size
        if not alike or not omega.max() >= 10.0 * omega.min():
            raise InputError(
                "A master curve has as many storage and loss moduli as frequencies, over a decade at least: "
                f"there are {omega.size} frequencies, {real.size} and {imaginary.size} moduli."
            )
        ends = (-math.log10(omega.max()) - _MARGIN, -math.log10(omega.min()) + _MARGIN)
        times = np.logspace(*ends, round(_TERMS_PER_DECADE * (ends[1] - ends[0])))
        phase = np.outer(omega, times)
        never = np.ones((omega.size, 1))
        columns = (np.hstack([never, phase**2 / (1.0 + phase**2)]), np.hstack([0.0 * never, phase / (1.0 + phase**2)]))
        # The relative errors of both moduli count.
        rows = np.vstack(
            [part / values[:, np.newaxis] for part, values in zip(columns, (real, imaginary), strict=True)]
        )
        fitted: Any = lsq_linear(rows, np.ones(rows.shape[0]), bounds=(0.0, np.inf))
        moduli = np.where(fitted.x > 1e-9 * fitted.x.max(), fitted.x, 0.0)
        if not moduli[0] > 0.0:
            moduli[0] = 1e-9 * moduli.max()
        kept = moduli[1:] > 0.0
        return cls((moduli[0], *moduli[1:][kept]), times[kept], poisson)
