"""The dimensionless task of a solver: pressures in E* times the peak-to-valley height over the cell."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.units import si
from roughcontact._parts.grid import Boundary, Load
from roughcontact._parts.interactions import BoundInteraction, Interaction
from roughcontact._parts.kernels import BoundKernel
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.convolvers import PreparedConvolution, ShearConvolution, prepare_once
from roughcontact._solve.problem.friction_plan import require_memory_of_friction
from roughcontact._solve.problem.plan import SolvePlan
from roughcontact._solve.solvers import Task
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Relative error of the load by rounding.
LOAD_TOLERANCE = 1e-12
# Range of dimensionless loads and approaches: beyond 1e15 the displacement hides the heights from float64, and
# float32, in which solvers iterate, holds 1e-38 to 1e38. Third, the maximum pressure limit that can be reached.
_MIN_LOAD = 1e-30
_MAX_LOAD = 1e15
_MAX_PRESSURE_LIMIT = 1e30


def pressure_unit(plan: SolvePlan) -> float:
    """Return the pressure that counts as one in a `Task`, Pa."""
    return plan.modulus * (plan.peak_to_valley / plan.grid.spacing[0])


@guarded
def bind_kernel(plan: SolvePlan) -> BoundKernel:
    """Return the kernel of a plan in dimensionless variables: lengths in cells, E* = 1."""
    unit = plan.grid.spacing[0] / plan.modulus
    datum = plan.grid.size[plan.boundary.free_axis] if plan.boundary.mixed else None
    return BoundKernel(plan.kernel, compliance=1.0 / plan.modulus, unit=unit, datum=datum)


def prepare_convolution(plan: SolvePlan) -> PreparedConvolution:
    """Return the prepared convolution of a plan, with the kernel of `bind_kernel`."""
    # The memory is checked again: the first solve may come long after the problem was made.
    plan.require_memory()
    return prepare_once(plan.convolver, bind_kernel(plan), plan.grid, plan.boundary)


def prepare_shear(plan: SolvePlan, convolution: PreparedConvolution) -> ShearConvolution:
    """Return the map from tractions to displacements in the variables of a prepared convolution."""
    require_memory_of_friction(plan)
    bound = attrs.evolve(convolution.setup.kernel, pair=pair_constants(*plan.materials))
    return plan.convolver.prepare(bound, plan.grid, plan.boundary).shear()


@guarded
def make_task(
    plan: SolvePlan, initial_gap: Array, load: Load, start: Array | None = None, start_gap: Array | None = None
) -> Task:
    """Return the task for a load; `InputError` if the bodies cannot carry it.

    The initial gap, m, the pressure, Pa, and with adhesion the gap, m, to start from have shape (nx, ny).
    """
    load = limit_load(plan, initial_gap, load)
    unit = pressure_unit(plan)
    start = None if start is None else _limit_start(start, plan) / unit
    interaction = None
    if plan.interaction is not None:
        interaction = bind_interaction(plan, plan.interaction)
    elif start is not None and load.kind == "pressure" and not start.max() > _MIN_LOAD:
        # A pressure of zero cannot be scaled to a load.
        start = None
    gap = initial_gap / plan.peak_to_valley
    measured = None if plan.non_measured is None else ~plan.non_measured
    return Task(
        initial_gap=gap,
        mean_pressure=load.value / unit if load.kind == "pressure" else None,
        approach=load.value / plan.peak_to_valley if load.kind == "approach" else None,
        pressure_limit=_dimensionless_limit(plan),
        # The depth of non-measured points is arbitrary: errors must not be compared with it.
        rms_gap=None if measured is None else float(gap[measured].std()),
        start=start,
        interaction=interaction,
        start_gap=None if start_gap is None else np.maximum(start_gap, 0.0) / plan.peak_to_valley,
    )


def bind_interaction(plan: SolvePlan, law: Interaction) -> BoundInteraction:
    """Return a law in the dimensionless variables of a `Task`."""
    return BoundInteraction(law, length=plan.peak_to_valley, pressure=pressure_unit(plan))


def limit_load(plan: SolvePlan, initial_gap: Array, load: Load) -> Load:
    """Return the load as the mean pressure or the approach that the bodies can carry; see `make_task`.

    A load of zero, of bodies that do not attract each other, is an approach of zero: they just touch.
    """
    if load.value == 0.0 and plan.interaction is None:
        return Load("approach", 0.0)
    if load.kind == "approach":
        plan.solver.require(approach=True)
        return _limit_approach(plan, initial_gap, load)
    area = plan.grid.area if load.kind == "force" else 1.0
    mean = load.value / area if area > 0.0 else float("inf")
    unit = pressure_unit(plan)
    smallest = _MIN_LOAD if plan.interaction is None else -_MAX_LOAD
    if not smallest * unit < mean < _MAX_LOAD * unit:
        raise InputError(
            f"The mean pressure of {mean:g} Pa is out of all proportion to {unit:g} Pa, contact modulus times "
            "peak-to-valley height over cell: check the units."
        )
    maximum = maximum_pressure(plan)
    if mean > maximum * (1.0 + LOAD_TOLERANCE):
        unloaded = "" if plan.non_measured is None else "; non-measured points carry nothing"
        raise InputError(
            f"The mean pressure of {si(mean, 'Pa')} is more than the bodies can carry: at most {si(maximum, 'Pa')}, "
            f"that is {si(maximum * plan.grid.area, 'N')} on this domain{unloaded}."
        )
    return Load("pressure", min(mean, maximum))


def _dimensionless_limit(plan: SolvePlan) -> Array:
    unit = pressure_unit(plan)
    return np.where(plan.pressure_limit < _MAX_PRESSURE_LIMIT * unit, plan.pressure_limit, np.inf) / unit


def maximum_pressure(plan: SolvePlan) -> float:
    """Return the maximum mean pressure that the bodies can carry, Pa: with all measured points at the limit."""
    measured = True if plan.non_measured is None else ~plan.non_measured
    return float(np.mean(np.where(measured, plan.pressure_limit, 0.0)))


def _limit_approach(plan: SolvePlan, initial_gap: Array, load: Load) -> Load:
    height = plan.peak_to_valley
    full = float(initial_gap.mean())
    smallest = _MIN_LOAD if plan.interaction is None else -_MAX_LOAD
    if not smallest * height < load.value < _MAX_LOAD * height:
        raise InputError(
            f"The approach of {load.value:g} m is out of all proportion to the peak-to-valley height of "
            f"{height:g} m: check the units."
        )
    unbounded = plan.boundary is Boundary.PERIODIC and bool(np.isinf(_dimensionless_limit(plan)).any())
    if unbounded and load.value >= full:
        raise InputError(
            f"On a periodic boundary the approach must be below that of full contact, {si(full, 'm')}, but got "
            f"{si(load.value, 'm')}: from there on it does not determine the pressure. Give {argument('pressure')} "
            "instead."
        )
    return load


def _limit_start(start: Array, plan: SolvePlan) -> Array:
    """Return the pressure to start from, between zero, or minus the strength, and the pressure limit."""
    try:
        values = np.asarray(start)
    except ValueError:
        values = np.empty(0, dtype=object)
    if values.dtype.kind not in "fiu" or values.shape != plan.grid.shape or not np.isfinite(values).all():
        raise InputError(
            f"The pressure to start from must be an array of {plan.grid.shape} finite numbers in Pa, "
            f"but got {type(start).__name__} of shape {values.shape} and type {values.dtype}."
        )
    highest = np.minimum(plan.pressure_limit, _MAX_LOAD * pressure_unit(plan))
    lowest = 0.0 if plan.interaction is None else -np.asarray(plan.interaction.strength)
    return np.clip(np.asarray(values, dtype=np.float64), lowest, highest)
