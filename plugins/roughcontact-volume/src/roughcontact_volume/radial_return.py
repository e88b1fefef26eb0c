"""The return of a stress to the yield surface of von Mises, in each cell of a volume.

Components are xx, yy, zz, yz, xz, xy, shears those of the tensor.
"""

from __future__ import annotations

import numpy as np
from roughcontact.typing import Array

from roughcontact_volume.yielding import Yielding

# Weights of the components, with which the sum of squares is the double product of a tensor with itself.
WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
# Rounds of Newton's method within bounds, which halves them where it fails: it ends after some six.
_MAX_ROUNDS = 200
_ROUNDING = 4.0 * float(np.finfo(np.float64).eps)


def find_norm(tensor: Array) -> Array:
    """Return the root of the double product of a tensor of shape (6, ...) with itself, shape (...)."""
    return np.sqrt(np.einsum("c,c...,c...->...", WEIGHTS, tensor, tensor))


def find_deviator(stress: Array) -> Array:
    """Return a stress of shape (6, ...) without its mean normal part."""
    deviator = np.array(stress)
    deviator[:3] -= stress[:3].mean(axis=0)
    return deviator


def find_equivalent(stress: Array) -> Array:
    """Return the von Mises stress of a stress of shape (6, ...), in its unit."""
    return np.sqrt(1.5) * find_norm(find_deviator(stress))


def find_multiplier(trial: Array, strain: Array, material: Yielding) -> Array:
    r"""Return the plastic strain that accumulates until a stress is at the yield surface.

    It is :math:`\Delta\kappa \ge 0` with :math:`\sigma - 3 \mu \Delta\kappa = Y(\kappa + \Delta\kappa)`, by Newton's
    method within bounds.

    Parameters
    ----------
    trial
        Von Mises stress of the elastic trial, Pa, shape (n,).
    strain
        Accumulated plastic strain before, shape (n,).
    material
        The material.
    """
    stiffness = 3.0 * material.shear_modulus
    low = np.zeros(trial.shape)
    # Hardening makes the multiplier smaller than perfect plasticity does.
    high = np.maximum(trial - material.find_yield_stress(strain), 0.0) / stiffness
    found = np.zeros(trial.shape)
    for _ in range(_MAX_ROUNDS):
        excess = trial - stiffness * found - material.find_yield_stress(strain + found)
        np.copyto(low, found, where=excess > 0.0)
        np.copyto(high, found, where=excess < 0.0)
        new = found + excess / (stiffness + material.find_slope(strain + found))
        inside = (new >= low) & (new <= high)
        new = np.where(inside, new, 0.5 * (low + high))
        is_last = np.abs(new - found) <= _ROUNDING * new
        found = new
        if is_last.all():
            break
    return np.where(trial > material.find_yield_stress(strain), found, 0.0)


def find_flow(stress: Array, flow: Array, strain: Array, material: Yielding) -> Array:
    r"""Return the increment of plastic strain that follows from a stress in which such an increment acts already.

    It is :math:`\Phi(x) = \tfrac{3}{2} \Delta\kappa\, s / \sigma` of the trial deviator
    :math:`s = \operatorname{dev} \sigma(x) + 2 \mu x`: the solution of a step is its fixed point.

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
    """
    trial = find_deviator(stress) + 2.0 * material.shear_modulus * flow
    equivalent = np.sqrt(1.5) * find_norm(trial)
    multiplier = find_multiplier(equivalent, strain, material)
    return np.asarray(1.5 * multiplier / np.where(equivalent > 0.0, equivalent, 1.0) * trial)


def find_accumulated(flow: Array) -> Array:
    """Return the accumulated strain of an increment of plastic strain of shape (6, ...), which has one direction."""
    return np.sqrt(2.0 / 3.0) * find_norm(flow)
