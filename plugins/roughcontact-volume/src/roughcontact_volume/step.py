"""One implicit step of plastic flow: the increment of plastic strain that the stress with it asks for."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np
from roughcontact.typing import Array, IntArray

from roughcontact_volume.anderson import AndersonMixing
from roughcontact_volume.radial_return import find_equivalent, find_flow, find_norm
from roughcontact_volume.yielding import Yielding

# Evaluations after which a step is given up: a huge one takes some thirty.
_MAX_EVALUATIONS = 200


@attrs.frozen(eq=False)
class Flow:
    """An increment of plastic strain in the cells that take part; elsewhere it is zero.

    Attributes
    ----------
    cells
        Their positions in an array of shape (nz, nx, ny), which more layers below do not change.
    values
        The increment there, shape (6, cells).
    """

    cells: IntArray
    values: Array

    @property
    def is_any(self) -> bool:
        """Whether anything flows."""
        return bool(self.values.any())

    def halve(self) -> Flow:
        """Return half of it."""
        return Flow(self.cells, 0.5 * self.values)

    def fill(self, shape: tuple[int, ...]) -> Array:
        """Return it as a field in layers of a shape (nz, nx, ny)."""
        field = np.zeros((6, math.prod(shape)))
        field[:, self.cells] = self.values
        return field.reshape(6, *shape)


NO_FLOW = Flow(np.empty(0, dtype=np.intp), np.empty((6, 0)))


@attrs.frozen(eq=False)
class FlowStep:
    """The solution of a step.

    Attributes
    ----------
    flow
        The increment of plastic strain.
    evaluations
        How often the stress was computed for it.
    error
        Its error in the last of them, which is above the tolerance where the step is given up.
    """

    flow: Flow
    evaluations: int
    error: float


def solve_step(
    find_stress: Callable[[Array, float], Array],
    strain: Array,
    material: Yielding,
    tolerance: float,
    start: Flow = NO_FLOW,
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
        An increment to start from; by default nothing flows.

    References
    ----------
    Simo, Hughes, Computational Inelasticity (1998), chapter 3, https://doi.org/10.1007/b98904
    """
    stiffness = 2.0 * material.shear_modulus
    known = strain.reshape(-1)
    limit = material.find_yield_stress(strain)
    mixing = AndersonMixing()
    mixing.add_cells(start.cells)
    flow = start
    error = 0.0
    count = 0
    while True:
        field = flow.fill(strain.shape)
        stress = find_stress(field, error)
        count += 1
        # Layer by layer, which takes the memory of one.
        trials = (find_equivalent(stress[:, layer] + stiffness * field[:, layer]) for layer in range(len(strain)))
        yielding = [(trial > most).ravel() for trial, most in zip(trials, limit, strict=True)]
        mixing.add_cells(np.flatnonzero(np.concatenate(yielding)))
        cells = mixing.cells
        iterate = field.reshape(6, -1)[:, cells]
        found = find_flow(stress.reshape(6, -1)[:, cells], iterate, known[cells], material)
        residual = found - iterate
        error = float(np.max(find_norm(residual), initial=0.0)) * stiffness / material.yield_stress
        if error <= tolerance and not iterate.any():
            # Rounding and tolerances of the steps before are not a flow.
            return FlowStep(NO_FLOW, count, error)
        if error <= tolerance or count == _MAX_EVALUATIONS:
            return FlowStep(Flow(cells, found), count, error)
        flow = Flow(cells, mixing.find_next(iterate, residual))
