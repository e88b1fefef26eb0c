"""One implicit step of plastic flow: the increment of plastic strain that the stress with it asks for."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from roughcontact.typing import Array

from roughcontact_volume.anderson import AndersonMixing
from roughcontact_volume.radial_return import find_equivalent, find_flow, find_norm
from roughcontact_volume.yielding import Yielding

# Evaluations after which a step is given up: a huge one takes some thirty.
_MAX_EVALUATIONS = 200


@attrs.frozen(eq=False)
class FlowStep:
    """The solution of a step.

    Attributes
    ----------
    flow
        The increment of plastic strain, shape (6, nz, nx, ny).
    evaluations
        How often the stress was computed for it.
    error
        Its error in the last of them, which is above the tolerance where the step is given up.
    """

    flow: Array
    evaluations: int
    error: float


def solve_step(
    find_stress: Callable[[Array, float], Array],
    strain: Array,
    material: Yielding,
    tolerance: float,
    start: Array | None = None,
) -> FlowStep:
    r"""Return the increment of plastic strain x with :math:`x = \Phi(x)`; see `find_flow`.

    As an iteration :math:`x \leftarrow \Phi(x)` is a proximal-gradient step of length :math:`1/(2 \mu)` on a convex
    energy, where the contact is solved for each stress, so that it converges for any load and any hardening. Anderson's
    mixing accelerates it; the last iterate is one of :math:`\Phi`, so that in each cell it has the direction of a
    stress.

    Parameters
    ----------
    find_stress
        The stress, Pa, shape (6, nz, nx, ny), with an increment of plastic strain of this shape; and the error of the
        increment before, which says how well the contact need be solved (zero at first: whether anything flows).
    strain
        Accumulated plastic strain before, shape (nz, nx, ny).
    material
        The material.
    tolerance
        Admissible :math:`|\Phi(x) - x|\, 2 \mu / Y` in any cell.
    start
        An increment to start from; None: nothing flows.

    References
    ----------
    Simo, Hughes, Computational Inelasticity (1998), chapter 3, https://doi.org/10.1007/b98904
    """
    stiffness = 2.0 * material.shear_modulus
    known = strain.reshape(-1)
    limit = material.find_yield_stress(known)
    flow = np.zeros((6, *strain.shape)) if start is None else np.array(start)
    values = flow.reshape(6, -1)
    mixing = AndersonMixing()
    error = 0.0
    count = 0
    while True:
        stress = find_stress(flow, error).reshape(6, -1)
        count += 1
        yielding = find_equivalent(stress + stiffness * values) > limit
        mixing.add_cells(np.flatnonzero(yielding | values.any(axis=0)))
        cells = mixing.cells
        iterate = values[:, cells]
        found = find_flow(stress[:, cells], iterate, known[cells], material)
        residual = found - iterate
        error = float(np.max(find_norm(residual), initial=0.0)) * stiffness / material.yield_stress
        if error <= tolerance and not iterate.any():
            # Rounding and tolerances of the steps before are not a flow.
            return FlowStep(np.zeros(flow.shape), count, error)
        is_last = error <= tolerance or count == _MAX_EVALUATIONS
        values = np.zeros((6, strain.size))
        values[:, cells] = found if is_last else mixing.find_next(iterate, residual)
        flow = values.reshape(6, *strain.shape)
        if is_last:
            return FlowStep(flow, count, error)
