"""The partition of heat between two bodies of equal temperature where they touch."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from roughcontact._answers.flow.conduction import Conduction
from roughcontact._base.arrays import Array, Mask, Waves, sum_of_products

# Norm of the residual of the temperatures over that of the temperature if all heat went into one body.
_TOLERANCE = 1e-6
# Vectors after which the search for the partition starts anew, and how often it does.
_MAX_VECTORS = 16
_MAX_STARTS = 12


def split_heat(
    conduction: Conduction, waves: Waves, inverse: Waves, temperature: Array, cells: Mask
) -> tuple[Array, bool]:
    r"""Return the flow into the first body, such that both have one temperature in each cell in contact.

    .. math:: (H_1 + H_2)\, q_1 = H_2\, q

    on the cells in contact, by GMRES.

    Parameters
    ----------
    conduction
        The convolution.
    waves
        The waves of the temperatures of both bodies, added.
    inverse
        About their inverse, which preconditions.
    temperature
        That of the second body if all heat q flowed into it, shape (nx, ny), K.
    cells
        The cells in contact.

    Returns
    -------
    tuple
        The flow, shape (nx, ny), W/m2, and whether it converged.
    """
    flow = np.zeros(cells.shape)

    def multiply(factor: Waves, values: Array) -> Array:
        flow[cells] = values
        return conduction.apply(factor, flow)[cells]

    found, converged = _solve(partial(multiply, waves), partial(multiply, inverse), temperature[cells])
    flow[cells] = found
    return flow, converged


def _solve(
    multiply: Callable[[Array], Array], precondition: Callable[[Array], Array], right: Array
) -> tuple[Array, bool]:
    """Return the solution of a linear equation by GMRES, preconditioned from the right, and whether it converged."""
    found = np.zeros(right.size)
    goal = _TOLERANCE * _norm(right)
    residual = right
    for _ in range(_MAX_STARTS):
        size = _norm(residual)
        if size <= goal:
            return found, True
        basis = [residual / size]
        columns = np.zeros((_MAX_VECTORS + 1, _MAX_VECTORS))
        for k in range(_MAX_VECTORS):
            vector = multiply(precondition(basis[k]))
            for j, one in enumerate(basis):
                columns[j, k] = sum_of_products(one, vector)
                vector -= columns[j, k] * one
            columns[k + 1, k] = _norm(vector)
            target = np.zeros(k + 2)
            target[0] = size
            weights = np.linalg.lstsq(columns[: k + 2, : k + 1], target, rcond=None)[0]
            if columns[k + 1, k] == 0.0 or np.linalg.norm(target - columns[: k + 2, : k + 1] @ weights) <= 0.5 * goal:
                break
            basis.append(vector / columns[k + 1, k])
        # No image is kept: the last one is that of them all.
        found += precondition(sum(weight * one for weight, one in zip(weights, basis, strict=False)))
        residual = right - multiply(found)
    return found, _norm(residual) <= goal


def _norm(values: Array) -> float:
    return math.sqrt(sum_of_products(values, values))
