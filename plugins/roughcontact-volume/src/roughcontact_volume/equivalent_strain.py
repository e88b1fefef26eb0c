"""The eigenstrain by which cells of other moduli act on a body: a contraction, mixed for speed."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from roughcontact.typing import Array

from roughcontact_volume.anderson import AndersonMixing
from roughcontact_volume.radial_return import find_norm

_MAX_ROUNDS = 120


@attrs.frozen(eq=False)
class Contrast:
    """The cells of other moduli in a body.

    Attributes
    ----------
    bulk, shear
        Their moduli over those of the body, shape (cells,).
    bulk_modulus, shear_modulus
        Moduli of the body, Pa.
    """

    bulk: Array
    shear: Array
    bulk_modulus: float
    shear_modulus: float

    def find_step(self, stress: Array, eigenstrain: Array) -> Array:
        """Return the change of an eigenstrain by its stress, shape (6, cells), Pa; zero where s = C_i eps.

        With the strain eps = C^-1 s + e it is 2 (C + C_i)^-1 [(C - C_i) eps - C e] = 2 (C + C_i)^-1 (s - C_i eps).
        """
        mean, deviator = split(eigenstrain)
        mean_stress, shear_stress = split(stress)
        volume = mean_stress / (3.0 * self.bulk_modulus) + mean
        shear = shear_stress / (2.0 * self.shear_modulus) + deviator
        return join(
            2.0 / (1.0 + self.bulk) * ((1.0 - self.bulk) * volume - mean),
            2.0 / (1.0 + self.shear) * ((1.0 - self.shear) * shear - deviator),
        )

    def measure(self, step: Array) -> float:
        """Return the largest stress in a cell by a step of the eigenstrain, Pa.

        It is the stress less the cell's moduli times its strain, over half the sum of these and the body's moduli.
        """
        mean, deviator = split(step)
        return measure(join(3.0 * self.bulk_modulus * mean, 2.0 * self.shear_modulus * deviator))


def split(tensor: Array) -> tuple[Array, Array]:
    """Return a third of the trace, shape (...), and the deviator, shape (6, ...), of a tensor."""
    mean = tensor[:3].sum(axis=0) / 3.0
    deviator = tensor.copy()
    deviator[:3] -= mean
    return mean, deviator


def join(mean: Array, deviator: Array) -> Array:
    """Return the tensor of a third of its trace and its deviator."""
    tensor = deviator.copy()
    tensor[:3] += mean
    return tensor


def measure(tensor: Array) -> float:
    """Return the largest size of a tensor, shape (6, ...), anywhere."""
    return float(find_norm(tensor).max())


def find_eigenstrain(
    contrast: Contrast, stress_of: Callable[[Array, float], Array], start: Array, tolerance: float
) -> Array:
    r"""Return the eigenstrain, shape (6, cells), whose stress is that of the moduli of each cell.

    The strain of the body is the nearest admissible one to an eigenstrain, in the norm of its energy, also where it is
    in contact: :math:`e \mapsto \varepsilon` is firmly nonexpansive. So the steps

    .. math:: e \leftarrow e + 2 (C + C_i)^{-1} [(C - C_i) \varepsilon - C e]

    contract by the largest :math:`|C - C_i| / (C + C_i)`, .82 for a contrast of ten, whatever softer and stiffer
    cells lie beside each other (Eyre and Milton for composites). Anderson's mixing of the last iterates makes it fast.

    Parameters
    ----------
    stress_of
        Gives the stress of an eigenstrain in the cells, Pa, with the contact inside, to a relative error.
    tolerance
        Largest violation over the largest stress at which it ends.

    References
    ----------
    Eyre, Milton, Eur. Phys. J. Appl. Phys. 6 (1999) 41-47, https://doi.org/10.1051/epjap:1999150
    """
    mixing = AndersonMixing()
    strain = start
    error = 1.0
    for _ in range(_MAX_ROUNDS):
        stress = stress_of(strain, error)
        step = contrast.find_step(stress, strain)
        error = contrast.measure(step) / max(measure(stress), np.finfo(float).tiny)
        if error <= tolerance:
            break
        strain = mixing.find_next(strain, step)
    return strain
