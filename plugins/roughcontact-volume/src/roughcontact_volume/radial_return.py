"""The return of a stress to the yield surface of von Mises, in each cell of a volume.

Components are xx, yy, zz, yz, xz, xy, shears those of the tensor.
"""

from __future__ import annotations

import numpy as np
from roughcontact.typing import Array

from roughcontact_volume.yielding import Yielding

# Weights of the components, with which the sum of squares is the double product of a tensor with itself.
WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
# Rounds of Newton's method within bounds: it ends after some six where the stress bends smoothly. Between points of a
# table it may go back and forth, so that from then on every other round halves the bounds.
_MAX_ROUNDS = 200
_SMOOTH_ROUNDS = 12
_ROUNDING = 4.0 * float(np.finfo(np.float64).eps)


def find_norm(tensor: Array) -> Array:
    """Return the root of the double product of a tensor of shape (6, ...) with itself, shape (...)."""
    return np.asarray(np.sqrt(np.einsum("c,c...,c...->...", WEIGHTS, tensor, tensor)))


def find_deviator(stress: Array) -> Array:
    """Return a stress of shape (6, ...) without its mean normal part."""
    deviator = np.array(stress)
    deviator[:3] -= stress[:3].mean(axis=0)
    return deviator


def find_equivalent(stress: Array) -> Array:
    """Return the von Mises stress of a stress of shape (6, ...), in its unit."""
    return np.asarray(np.sqrt(1.5) * find_norm(find_deviator(stress)))


def find_multiplier(trial: Array, strain: Array, material: Yielding, stiffness: float = 1.0) -> Array:
    r"""Return the plastic strain that accumulates until a stress is at the yield surface.

    It is :math:`\Delta\kappa \ge 0` with :math:`\sigma - 3 c \mu \Delta\kappa = Y(\kappa + \Delta\kappa)`, by Newton's
    method within bounds.

    Parameters
    ----------
    trial
        Von Mises stress of the elastic trial, Pa, shape (n,).
    strain
        Accumulated plastic strain before, shape (n,).
    material
        The material.
    stiffness
        The factor c of the shear modulus; 1: the elastic trial.
    """
    found = np.zeros(trial.shape)
    yields = trial > material.find_yield_stress(strain)
    found[yields] = _find_root(trial[yields], strain[yields], material, 3.0 * stiffness * material.shear_modulus)
    return found


def _find_root(trial: Array, strain: Array, material: Yielding, stiffness: float) -> Array:
    low = np.zeros(trial.shape)
    # Hardening makes the multiplier smaller than perfect plasticity does.
    high = (trial - material.find_yield_stress(strain)) / stiffness
    found = low
    for count in range(_MAX_ROUNDS):
        excess = trial - stiffness * found - material.find_yield_stress(strain + found)
        low = np.where(excess > 0.0, found, low)
        high = np.where(excess < 0.0, found, high)
        new = found + excess / (stiffness + material.find_slope(strain + found))
        inside = (new >= low) & (new <= high) & (count < _SMOOTH_ROUNDS or count % 2 == 0)
        new = np.where(inside, new, 0.5 * (low + high))
        change, found = np.abs(new - found), new
        if np.all(stiffness * change <= _ROUNDING * trial):
            break
    return found


def find_flow(stress: Array, flow: Array, strain: Array, material: Yielding, stiffness: float = 1.0) -> Array:
    r"""Return the increment of plastic strain that follows from a stress in which such an increment acts already.

    It is :math:`\Phi(x) = \tfrac{3}{2} \Delta\kappa\, s / \sigma` of the trial deviator
    :math:`s = \operatorname{dev} \sigma(x) + 2 c \mu x`: the solution of a step is its fixed point, with any factor c.

    Parameters
    ----------
    stress
        The stress with the increment, Pa, shape (6, n).
    flow
        The increment x, shape (6, n).
    strain
        Accumulated plastic strain before, shape (n,).
    material
        The material.
    stiffness
        The factor c of the shear modulus; 1: the elastic trial.
    """
    trial = find_deviator(stress) + 2.0 * stiffness * material.shear_modulus * flow
    equivalent = np.sqrt(1.5) * find_norm(trial)
    multiplier = find_multiplier(equivalent, strain, material, stiffness)
    return np.asarray(1.5 * multiplier / np.where(equivalent > 0.0, equivalent, 1.0) * trial)


def find_accumulated(flow: Array) -> Array:
    """Return the accumulated strain of an increment of plastic strain of shape (6, ...), which has one direction."""
    return np.asarray(np.sqrt(2.0 / 3.0) * find_norm(flow))
