"""The contact problem: two bodies, a grid and the parts that solve it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact.body import RIGID_FLAT, Body
from roughcontact.certificate import certified
from roughcontact.checks import Array, choice, instance_of
from roughcontact.convolvers import Convolver, PlannedConvolution
from roughcontact.convolvers.base import require_boundary
from roughcontact.errors import InputError, NotConverged
from roughcontact.gap import Gap, gap_between
from roughcontact.grid import Boundary, Grid
from roughcontact.kernels import BoundKernel, InfluenceKernel
from roughcontact.loads import require_load, task_of
from roughcontact.materials import Rigid, contact_modulus, pressure_limit
from roughcontact.plan import Plan
from roughcontact.registry import convolvers, kernels, solvers
from roughcontact.relief import rms_slope
from roughcontact.solution import DEFAULT_AREA, ContactSolution, EstimatesArea, Origin
from roughcontact.solvers import Solver, Step
from roughcontact.surfaces import FlatSurface
from roughcontact.surfaces.base import history_of, own_grid
from roughcontact.sweep import Sweep, area_load, swept

_AUTO_CONVOLVER = {
    Boundary.FREE: "dc-fft",
    Boundary.PERIODIC: "circular-fft",
    Boundary.WRAPPED: "circular-fft",
}
_AUTO_SOLVER = "projected-cg"


def _boundary(value: str) -> Boundary:
    return Boundary(choice(value, "The boundary", [str(name) for name in Boundary]))


_is_body = instance_of(Body, "Each side of a contact", "a Body(surface, material)")
_is_grid = attrs.validators.optional(instance_of(Grid, "The grid", "a Grid(shape, size)"))


@attrs.frozen(eq=False)
class ContactProblem:
    """Normal, frictionless contact of two rough bodies on half-spaces.

    Parameters
    ----------
    body, counter
        The two bodies; heights of both are positive towards the other.
    grid
        The grid; may be left out when a surface carries its own.
    boundary
        ``"free"``: the domain stands alone; ``"periodic"``: it repeats for ever; ``"wrapped"``: the
        nearest image only.
    kernel, convolver, solver
        Registered names or instances; ``"auto"`` chooses the convolver and the solver.

    Raises
    ------
    InputError
        If the parts do not fit together.
    """

    body: Body = attrs.field(validator=_is_body)
    counter: Body = attrs.field(default=RIGID_FLAT, validator=_is_body)
    grid: Grid | None = attrs.field(default=None, kw_only=True, validator=_is_grid)
    boundary: Boundary = attrs.field(default=Boundary.FREE, converter=_boundary, kw_only=True)
    kernel: str | InfluenceKernel = attrs.field(default="love", kw_only=True)
    convolver: str | Convolver = attrs.field(default="auto", kw_only=True)
    solver: str | Solver = attrs.field(default="auto", kw_only=True)

    def __attrs_post_init__(self) -> None:
        # The plan checks that the parts fit together.
        _ = self.plan

    @cached_property
    def plan(self) -> Plan:
        """What will run, and what is left out."""
        grid = self._grid()
        convolver: Convolver = convolvers.resolve(
            _AUTO_CONVOLVER[self.boundary] if self.convolver == "auto" else self.convolver, Convolver
        )
        require_boundary(convolver, self.boundary)
        solver: Solver = solvers.resolve(_AUTO_SOLVER if self.solver == "auto" else self.solver, Solver)
        one, other = self.body.material, self.counter.material
        return Plan(
            grid=grid,
            boundary=self.boundary,
            kernel=kernels.resolve(self.kernel, InfluenceKernel),
            convolver=convolver,
            solver=solver,
            modulus=contact_modulus(one, other),
            undeformed=self.undeformed,
            relief=self._relief(),
            limit=self._limit(),
            left_out=(*self._left_out(), *solver.leaves_out),
            holes=self._gap.holes,
            histories=(history_of(self.body.surface), history_of(self.counter.surface)),
        )

    @cached_property
    def convolution(self) -> PlannedConvolution:
        """The planned convolution in dimensionless variables: lengths in cells, E* = 1."""
        plan = self.plan
        unit = plan.grid.spacing[0] / plan.modulus
        bound = BoundKernel(plan.kernel, compliance=1.0 / plan.modulus, unit=unit)
        return plan.convolver.plan(bound, plan.grid, plan.boundary)

    @property
    def undeformed(self) -> Array:
        """Gap before deformation when the summits just touch, shape (nx, ny), m, at least zero."""
        return self._gap.undeformed

    @property
    def summit(self) -> float:
        """Greatest sum of both heights, m, where the bodies touch first."""
        return self._gap.summit

    @cached_property
    def _gap(self) -> Gap:
        return gap_between(self.body, self.counter, self._grid())

    @property
    def parts(self) -> dict[str, Any]:
        """What the problem was made from, by the names of its arguments."""
        return {field.name: getattr(self, field.name) for field in attrs.fields(type(self))}

    def explain(self) -> str:
        """Return in words what a solve will do, and what is left out and why."""
        return str(self.plan)

    def solve(
        self,
        *,
        pressure: float | None = None,
        force: float | None = None,
        approach: float | None = None,
        start: Array | None = None,
        throw: bool = True,
        on_step: Callable[[Step], None] | None = None,
    ) -> ContactSolution:
        """Solve the contact at a given load.

        Parameters
        ----------
        pressure
            Nominal mean pressure, Pa.
        force
            Normal force, N.
        approach
            Approach of the bodies since first touch, m.
        start
            A contact pressure to start from, shape (nx, ny), Pa: that of a similar load.
        on_step
            Called with a `Step` after each iteration.
        throw
            Whether to raise when the solver does not converge, or to return what it has.

        Returns
        -------
        ContactSolution
            The fields with their certificate.

        Raises
        ------
        InputError
            If not exactly one load is given, or it cannot be carried.
        NotConverged
            If the solution is not certified and `throw` is true; the error carries it.
        """
        started = time.perf_counter()
        gap = self._gap
        while True:
            task = task_of(self.plan, gap.undeformed, pressure=pressure, force=force, approach=approach, start=start)
            outcome = self.plan.solver.solve(self.convolution, attrs.evolve(task, on_step=on_step))
            seconds = time.perf_counter() - started
            solution = certified(self.plan, self.convolution, gap.undeformed, task, outcome, seconds=seconds)
            if gap.holes is None or not solution.contact[gap.holes].any():
                break
            # A hole is as deep as it takes: it does not touch.
            gap = gap.deeper(4.0 * (float(gap.undeformed.max()) + abs(solution.approach)))
        given = {"pressure": pressure, "force": force, "approach": approach}
        load = {name: float(value) for name, value in given.items() if value is not None}
        solution = attrs.evolve(solution, origin=Origin(self.parts, load))
        if throw and not solution.status.success:
            raise NotConverged(
                f"The contact is {solution.status} ({solution.iterations} iterations; {solution.residuals}). "
                "The unfinished solution is in .solution of this error; solve(..., throw=False) returns it.",
                solution,
            )
        return solution

    def require_load(
        self, *, pressure: float | None = None, force: float | None = None, approach: float | None = None
    ) -> None:
        """Raise `InputError` if a load cannot be carried; nothing is solved."""
        require_load(self.plan, self.undeformed, pressure=pressure, force=force, approach=approach)

    def sweep(
        self,
        *,
        pressure: Sequence[float] | None = None,
        force: Sequence[float] | None = None,
        approach: Sequence[float] | None = None,
    ) -> Sweep:
        """Solve for several loads, each starting from the ones before.

        Parameters
        ----------
        pressure, force, approach
            Exactly one list: nominal mean pressures, Pa; normal forces, N; approaches, m.

        Returns
        -------
        Sweep
            The solutions in the order of the loads, and a table of what came out.

        Raises
        ------
        InputError
            If not exactly one list is given, or it is empty, or a load cannot be carried; nothing is
            solved then.
        NotConverged
            If a solution is not certified.
        """
        return swept(self.solve, self.require_load, pressure=pressure, force=force, approach=approach)

    def solve_area(self, fraction: float, estimator: str | EstimatesArea = DEFAULT_AREA) -> ContactSolution:
        """Find the load at which the real contact area is a given share of the nominal area.

        Parameters
        ----------
        fraction
            Real contact area over nominal area, above 0 and below 1.
        estimator
            Registered name or instance of the area estimator that is to give it.

        Raises
        ------
        InputError
            If the fraction is out of bounds or no load gives it, on this grid and with this limit.
        """
        scale = self.plan.modulus * rms_slope(self.undeformed, self.plan.grid)
        largest = float(np.mean(self.plan.limit))
        return area_load(self.solve, fraction, estimator, min(scale, largest), largest)

    def _grid(self) -> Grid:
        found = (own_grid(body.surface) for body in (self.body, self.counter))
        grid = self.grid or next((grid for grid in found if grid is not None), None)
        if grid is None:
            raise InputError("The surfaces carry no grid of their own: give grid=Grid(shape, size).")
        return grid

    def _limit(self) -> float | Array:
        limit = pressure_limit(self.body.material, self.counter.material)
        if not isinstance(limit, float) and limit.shape != self._grid().shape:
            raise InputError(
                f"The pressure limit is an array of shape {limit.shape}, but the grid has {self._grid().shape} cells."
            )
        return limit

    def _relief(self) -> float:
        relief = float(self.undeformed.max())
        if relief == 0.0:
            raise InputError(
                "Both surfaces are flat, so the pressure is uniform and there is nothing to solve: "
                "give at least one of them a relief."
            )
        return relief

    def _left_out(self) -> list[str]:
        """Say what this scene does not need."""
        padding = {
            Boundary.FREE: "images of the domain: the boundary is free",
            Boundary.PERIODIC: "padding: the domain repeats, every image counts",
            Boundary.WRAPPED: "padding and all but the nearest images: the boundary is wrapped",
        }
        texts = [padding[self.boundary]]
        if np.isinf(self._limit()).all():
            texts.append("pressure cap: neither material has a limit")
        if self.boundary is Boundary.PERIODIC:
            texts.append("kernel in real space: its spectrum is used")
        for body in (self.body, self.counter):
            if isinstance(body.material, Rigid):
                texts.append("deformation of one body: it is rigid")
            if isinstance(body.surface, FlatSurface):
                texts.append("heights of one body: it is flat")
        return texts
