"""A contact whose fields stay on the device: numbers come to the host, fields when they are asked for."""

from __future__ import annotations

import time
from typing import Any, cast

import attrs
import roughcontact as rc
import torch
from roughcontact.results import Origin
from roughcontact.solving import SolveRecord, confirm, make_task
from roughcontact.typing import Array

from roughcontact_torch.together import shared_parts


@attrs.frozen(eq=False, kw_only=True)
class TensorSolution(SolveRecord):
    """A solved contact: its numbers on the host, its fields on the device.

    Attributes
    ----------
    problem
        The problem.
    pressure, displacement, initial_gap
        Contact pressure, Pa, the displacement that it causes and the gap before deformation, m, shape (nx, ny), in
        float64 on the device.
    """

    problem: rc.ContactProblem = attrs.field(repr=False)
    pressure: torch.Tensor = attrs.field(repr=False)
    displacement: torch.Tensor = attrs.field(repr=False)
    initial_gap: torch.Tensor = attrs.field(repr=False)

    @property
    def gap(self) -> torch.Tensor:
        """Gap after deformation, shape (nx, ny), m, on the device."""
        return self.initial_gap + self.displacement - self.approach

    @property
    def force(self) -> float:
        """Normal force, N."""
        return float(self.pressure.sum()) * self.problem.plan.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa."""
        return self.force / self.problem.plan.grid.area

    def to_host(self) -> rc.ContactSolution:
        """Return the solution with numpy's arrays and every answer; its certificate is not computed again."""
        plan = self.problem.plan
        pressure, displacement = (field.numpy(force=True) for field in (self.pressure, self.displacement))
        found = self.to_solution(plan, self.problem.initial_gap, pressure, displacement)
        return attrs.evolve(found, origin=Origin(self.problem.parts, self.load.arguments, source=self.problem))


def solve_on_device(
    problem: rc.ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    throw: bool = True,
) -> TensorSolution:
    """Solve a contact by the masked solver and certify it, both on the device of its convolver.

    Parameters
    ----------
    problem
        A problem on the tensors of `TorchFFT`, with `MaskedConjugateGradient` as solver, of measured points alone.
    pressure, force, approach
        Exactly one load: nominal mean pressure, Pa; normal force, N; approach since first touch, m.
    throw
        Whether to raise when the contact is not certified, or to return the unfinished solution.

    Raises
    ------
    InputError
        If the problem is another one, or the bodies cannot carry the load.
    NotConverged
        If the solution is not certified and `throw` is true.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_on_device
    >>> surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=32e-6, seed=1)
    >>> body = rc.Body(surface, rc.Elastic("210GPa", 0.3))
    >>> tensors = {"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient()}
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64e-6), boundary="periodic", **tensors)
    >>> found = solve_on_device(problem, pressure=200e6)
    >>> type(found.pressure).__name__, found.residuals.error < 1e-5
    ('Tensor', True)
    >>> found.to_host().area().value > 0.0
    True
    """
    started = time.perf_counter()
    solver, convolution = shared_parts([problem])
    plan = problem.plan
    if plan.non_measured is not None:
        raise rc.InputError("Some points were not measured: solve this contact by problem.solve.")
    load = problem.require_load(pressure=pressure, force=force, approach=approach)
    with convolution.use_threads(plan.thread_choice[0]):
        task = make_task(plan, problem.initial_gap, load)
        task = attrs.evolve(task, initial_gap=convolution.from_numpy(task.initial_gap))
        (outcome,) = solver.solve_on_device(convolution, [task])
        certificate = confirm(plan, convolution, task, outcome)
    solution = TensorSolution(
        **SolveRecord.numbers_of(load, outcome, certificate, started),
        problem=problem,
        pressure=_tensor(certificate.pressure),
        displacement=_tensor(certificate.displacement),
        initial_gap=_tensor(task.initial_gap) * plan.peak_to_valley,
    )
    if throw:
        solution.require_certified()
    return solution


def _tensor(values: Array) -> torch.Tensor:
    return cast(torch.Tensor, cast(Any, values).tensor)
