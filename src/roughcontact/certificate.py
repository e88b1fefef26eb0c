"""The certificate: a solver's pressure, judged by nothing but itself."""

from __future__ import annotations

import numpy as np

from roughcontact.checks import Array, frozen_array
from roughcontact.convolvers import PlannedConvolution
from roughcontact.errors import InputError
from roughcontact.kernels import OffersModulus
from roughcontact.loads import LOAD_TOLERANCE, pressure_unit
from roughcontact.optimality import Conditions
from roughcontact.plan import Plan
from roughcontact.solution import ContactSolution, Residuals, Status
from roughcontact.solvers import Outcome, Task

# Lengths at which a kernel's modulus is kept.
_LENGTHS = 96


def certified(
    plan: Plan,
    convolution: PlannedConvolution,
    undeformed: Array,
    task: Task,
    outcome: Outcome,
    *,
    seconds: float,
) -> ContactSolution:
    """Return the solution in SI units, with residuals recomputed in float64 from the pressure alone.

    A solver's claim of success is passed on only if the residuals confirm it, the load is carried
    to rounding and the bounds hold bit for bit.

    Parameters
    ----------
    plan, convolution, task
        What was to be solved.
    undeformed
        Undeformed gap, shape (nx, ny), m.
    outcome
        What the solver returned.
    seconds
        Wall time that it took.

    Raises
    ------
    InputError
        If the solver returned anything but an outcome with a pressure of the grid's shape.
    """
    if not isinstance(outcome, Outcome) or outcome.pressure.shape != task.undeformed.shape:
        raise InputError(f"The solver {plan.solver!r} must return an Outcome with a pressure of the grid's shape.")
    displacement = convolution.apply(outcome.pressure)
    state = Conditions(task.undeformed, task.limit, task.approach).measure(outcome.pressure, displacement)
    carried = convolution.sum(outcome.pressure) / outcome.pressure.size
    load = 0.0 if task.mean_pressure is None else abs(carried / task.mean_pressure - 1.0)
    bound = 2.0 * max(plan.solver.tolerance, state.floor if state.resolved else 0.0)
    bounded = bool(outcome.pressure.min() >= 0.0 and (outcome.pressure <= task.limit).all())
    confirmed = state.error <= bound and load <= LOAD_TOLERANCE and bounded
    pressure = np.minimum(outcome.pressure * pressure_unit(plan), plan.limit)
    # Saturated cells carry the limit to the last bit.
    pressure = np.where(outcome.pressure >= task.limit, plan.limit, pressure)
    return ContactSolution(
        grid=plan.grid,
        boundary=plan.boundary,
        modulus=plan.modulus,
        limit=plan.limit,
        pressure=frozen_array(pressure),
        displacement=frozen_array(displacement * plan.relief),
        undeformed=undeformed,
        approach=state.approach * plan.relief,
        status=Status.UNCONFIRMED if outcome.status.success and not confirmed else outcome.status,
        iterations=outcome.iterations,
        convolutions=outcome.convolutions + 1,
        seconds=seconds,
        residuals=Residuals(state.complementarity, state.penetration, load, state.scale * plan.relief),
        history=outcome.history,
        levels=outcome.levels,
        edge_shift=plan.kernel.edge_shift,
        moduli=_moduli(plan),
    )


def _moduli(plan: Plan) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return the contact modulus by the length of waves, from less than a cell to more than the domain."""
    if not isinstance(plan.kernel, OffersModulus):
        return None
    lengths = np.geomspace(0.1 * min(plan.grid.spacing), max(plan.grid.size), _LENGTHS)
    moduli = np.asarray(plan.kernel.modulus_at(lengths, 1.0 / plan.modulus))
    if moduli.shape != lengths.shape or not (np.isfinite(moduli).all() and moduli.min() > 0.0):
        raise InputError(f"The kernel {plan.kernel!r} must return moduli above zero, of shape {lengths.shape}.")
    return tuple(lengths.tolist()), tuple(moduli.tolist())
