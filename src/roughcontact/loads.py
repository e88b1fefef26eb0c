"""Loads, checked and put into dimensionless variables."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.checks import Array, number
from roughcontact.errors import InputError
from roughcontact.grid import Boundary
from roughcontact.plan import Plan
from roughcontact.solvers import Task
from roughcontact.units import si

# Relative error of the load that is rounding.
LOAD_TOLERANCE = 1e-12
# Pressures have room for their squares within float64.
_SMALLEST, _LARGEST = 1e-150, 1e150


def pressure_unit(plan: Plan) -> float:
    """Return the pressure that counts as one in a `Task`, Pa.

    Raises
    ------
    InputError
        If it leaves the range of float64.
    """
    unit = plan.modulus * (plan.relief / plan.grid.spacing[0])
    if not _SMALLEST < unit < _LARGEST:
        raise InputError(
            f"With a contact modulus of {plan.modulus:g} Pa, a relief of {plan.relief:g} m and cells of "
            f"{plan.grid.spacing[0]:g} m the pressures leave the range of float64: use units nearer to one."
        )
    return unit


def task_of(
    plan: Plan,
    undeformed: Array,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    start: Array | None = None,
) -> Task:
    """Return the task of carrying the one load that is given.

    Parameters
    ----------
    plan
        The plan of the problem.
    undeformed
        Undeformed gap, shape (nx, ny), m.
    pressure, force, approach
        Exactly one: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    start
        A pressure to start from, shape (nx, ny), Pa.

    Raises
    ------
    InputError
        If not exactly one load is given, or it cannot be carried.
    """
    mean, level = require_load(plan, undeformed, pressure=pressure, force=force, approach=approach)
    unit = pressure_unit(plan)
    return Task(
        undeformed=undeformed / plan.relief,
        mean_pressure=None if mean is None else mean / unit,
        approach=None if level is None else level / plan.relief,
        limit=plan.limit / unit,
        start=None if start is None else _start(start, plan) / unit,
    )


def require_load(
    plan: Plan,
    undeformed: Array,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
) -> tuple[float | None, float | None]:
    """Return the mean pressure, Pa, or the approach, m, that the one load given asks for; see `task_of`."""
    given = {"pressure": pressure, "force": force, "approach": approach}
    named = [name for name, value in given.items() if value is not None]
    if len(named) != 1:
        got = " and ".join(f"{name}=" for name in named) or "none of them"
        raise InputError(f"Give exactly one of pressure= (Pa), force= (N) and approach= (m), but got {got}.")
    if approach is not None:
        return None, _reachable(approach, undeformed, plan)
    if pressure is not None:
        return _bearable(number(pressure, "The mean pressure", "Pa", above=0.0), plan), None
    area = plan.grid.area
    return _bearable(number(force, "The force", "N", above=0.0) / area if area > 0.0 else math.inf, plan), None


def _start(start: Array, plan: Plan) -> Array:
    """Return a pressure to start from, within the bounds."""
    try:
        values = np.asarray(start)
    except ValueError:
        values = np.empty(0, dtype=object)
    if values.dtype.kind not in "fiu" or values.shape != plan.grid.shape or not np.isfinite(values).all():
        raise InputError(
            f"The pressure to start from must be an array of {plan.grid.shape} finite numbers in Pa, "
            f"but got {type(start).__name__} of shape {values.shape} and type {values.dtype}."
        )
    return np.clip(np.asarray(values, dtype=np.float64), 0.0, plan.limit)


def _bearable(mean: float, plan: Plan) -> float:
    unit = pressure_unit(plan)
    if not _SMALLEST * unit < mean < _LARGEST * unit:
        raise InputError(f"The mean pressure of {mean:g} Pa leaves the range of float64 beside {unit:g} Pa.")
    largest = float(np.mean(plan.limit))
    if mean > largest * (1.0 + LOAD_TOLERANCE):
        raise InputError(
            f"The mean pressure of {si(mean, 'Pa')} is more than the bodies bear: at most {si(largest, 'Pa')}, "
            f"that is {si(largest * plan.grid.area, 'N')} on this domain."
        )
    return min(mean, largest)


def _reachable(approach: float, undeformed: Array, plan: Plan) -> float:
    approach = number(approach, "The approach", "m", above=0.0)
    full = float(undeformed.mean())
    unbounded = plan.boundary is Boundary.PERIODIC and bool(np.isinf(plan.limit).any())
    if unbounded and approach >= full:
        raise InputError(
            f"On a periodic boundary the approach must be below that of full contact, {si(full, 'm')}, but got "
            f"{si(approach, 'm')}: beyond it any pressure will do. Give pressure= instead."
        )
    return approach
