"""One implicit step of plastic flow: the increment of plastic strain that the stress with it asks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import attrs
import numpy as np
from roughcontact.typing import Array, IntArray

from roughcontact_volume.anderson import AndersonMixing
from roughcontact_volume.radial_return import find_equivalent, find_flow, find_norm
from roughcontact_volume.yielding import Yielding

# Evaluations after which a step is given up: a huge one takes some thirty.
_MAX_EVALUATIONS = 200
# Factor of the shear modulus in the return: above a half the iteration converges by itself too, and it takes a tenth
# fewer evaluations than with 1.
_STIFFNESS = 0.65


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
    flows
        The increment of plastic strain of each body.
    evaluations
        How often the stress was computed for it.
    error
        Its error in the last of them, which is above the tolerance where the step is given up.
    """

    flows: tuple[Flow, ...]
    evaluations: int
    error: float


@attrs.frozen(eq=False)
class FlowingCells:
    """The cells of a body in a step.

    Attributes
    ----------
    material
        The material.
    strain
        Accumulated plastic strain before, shape (nz, nx, ny).
    start
        An increment to start from.
    """

    material: Yielding
    strain: Array
    start: Flow = NO_FLOW

    def find_yielding(self, stress: Array, field: Array) -> IntArray:
        """Return the cells whose elastic trial is beyond the yield stress, with an increment that acts already."""
        limit = self.material.find_yield_stress(self.strain)
        stiffness = 2.0 * _STIFFNESS * self.material.shear_modulus
        # Layer by layer, which takes the memory of one.
        trials = (find_equivalent(stress[:, layer] + stiffness * field[:, layer]) for layer in range(len(limit)))
        yielding = [(trial > most).ravel() for trial, most in zip(trials, limit, strict=True)]
        return np.flatnonzero(np.concatenate(yielding))

    def find_flow(self, stress: Array, iterate: Flow) -> Array:
        """Return the increment of some cells that follows from their stress, shape (6, cells); see `find_flow`."""
        cells = iterate.cells
        strain = self.strain.reshape(-1)[cells]
        return find_flow(stress.reshape(6, -1)[:, cells], iterate.values, strain, self.material, _STIFFNESS)

    def measure(self, residual: Array) -> float:
        """Return the largest change of an increment as a stress over the yield stress."""
        largest = float(np.max(find_norm(residual), initial=0.0))
        return largest * (2.0 * _STIFFNESS * self.material.shear_modulus) / self.material.yield_stress


def solve_step(
    find_stresses: Callable[[list[Array], float], Sequence[Array]], bodies: Sequence[FlowingCells], tolerance: float
) -> FlowStep:
    r"""Return the increment of plastic strain x of each body with :math:`x = \Phi(x)`; see `find_flow`.

    As an iteration :math:`x \leftarrow \Phi(x)` is a proximal-gradient step of length :math:`1/(2 c \mu)` on a convex
    energy, where the contact is solved for each stress, so that it converges for any load, any hardening and any factor
    c above a half. Anderson's mixing accelerates it, of all bodies together; the last iterate is one of :math:`\Phi`,
    so that in each cell it has the direction of a stress.

    Parameters
    ----------
    find_stresses
        The stress of each body, Pa, shape (6, nz, nx, ny), with increments of plastic strain of these shapes; and the
        error of the increments before, which says how well the contact need be solved (zero at first: whether anything
        flows).
    bodies
        The bodies that may flow.
    tolerance
        Admissible :math:`|\Phi(x) - x|\, 2 c \mu / Y` in any cell.

    References
    ----------
    Simo, Hughes, Computational Inelasticity (1998), chapter 3, https://doi.org/10.1007/b98904
    """
    # The cells of each body follow those of the one before.
    ends = np.cumsum([body.strain.size for body in bodies])
    starts = [0, *ends[:-1].tolist()]
    mixing = AndersonMixing()
    mixing.add_cells(_join_cells([body.start.cells for body in bodies], starts))
    flows = [body.start for body in bodies]
    error = 0.0
    count = 0
    while True:
        fields = [flow.fill(body.strain.shape) for flow, body in zip(flows, bodies, strict=True)]
        stresses = find_stresses(fields, error)
        count += 1
        triples = list(zip(bodies, stresses, fields, strict=True))
        mixing.add_cells(_join_cells([body.find_yielding(stress, field) for body, stress, field in triples], starts))
        cells = _divide_cells(mixing.cells, starts)
        iterates = [Flow(some, field.reshape(6, -1)[:, some]) for some, field in zip(cells, fields, strict=True)]
        found = [body.find_flow(stress, one) for (body, stress, _), one in zip(triples, iterates, strict=True)]
        residuals = [new - one.values for new, one in zip(found, iterates, strict=True)]
        error = max(body.measure(residual) for body, residual in zip(bodies, residuals, strict=True))
        if error <= tolerance and not any(one.is_any for one in iterates):
            # Rounding and tolerances of the steps before are not a flow.
            return FlowStep((NO_FLOW,) * len(bodies), count, error)
        if error <= tolerance or count == _MAX_EVALUATIONS:
            return FlowStep(tuple(map(Flow, cells, found)), count, error)
        following = mixing.find_next(np.hstack([one.values for one in iterates]), np.hstack(residuals))
        widths = np.cumsum([some.size for some in cells])[:-1]
        flows = list(map(Flow, cells, np.split(following, widths, axis=1)))


def _join_cells(cells: Sequence[IntArray], starts: Sequence[int]) -> IntArray:
    """Return positions of the cells of all bodies behind each other."""
    return np.concatenate([some + start for some, start in zip(cells, starts, strict=True)])


def _divide_cells(cells: IntArray, starts: Sequence[int]) -> list[IntArray]:
    """Return the positions of the cells of each body among its own."""
    pieces = np.split(cells, np.searchsorted(cells, starts[1:]))
    return [piece - start for piece, start in zip(pieces, starts, strict=True)]
