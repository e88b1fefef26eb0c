"""A contact whose fields stay on the device: numbers come to the host, fields when they are asked for."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

import attrs
import roughcontact as rc
from roughcontact.results import Origin
from roughcontact.solving import Whole, confirm, make_solution, make_task, require_certified

from roughcontact_torch.together import shared_parts

T = TypeVar("T")


@attrs.frozen(eq=False)
class OnDevice(Whole):
    """What holds a solution together whose fields, `TensorArray`, are on a device.

    Attributes
    ----------
    problem
        The problem.
    """

    is_whole: ClassVar[bool] = False

    problem: rc.ContactProblem

    def gather(self, solution: Any) -> Any:
        """Return the solution with numpy's arrays; its certificate is not computed again."""
        fields = {name: getattr(solution, name).tensor.numpy(force=True) for name in ("pressure", "displacement")}
        return attrs.evolve(solution, **fields, initial_gap=self.problem.initial_gap, parts=Whole())

    def ask(self, solution: Any, answer: Any, find: Callable[[Any], T]) -> T:
        """Return what a function finds of the solution with numpy's arrays, which are brought once."""
        return find(solution._keep("host", lambda: self.gather(solution)))


def solve_on_device(
    problem: rc.ContactProblem,
    *,
    pressure: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    throw: bool = True,
) -> rc.ContactSolution:
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
    >>> type(found.pressure.tensor).__name__, found.residuals.error < 1e-5
    ('Tensor', True)
    >>> found.area().value > 0.0
    True
    """
    started = time.perf_counter()
    solver, convolution = shared_parts([problem])
    plan = problem.plan
    if plan.non_measured is not None:
        raise rc.InputError("Some points were not measured: solve this contact by problem.solve.")
    if problem.laws:
        raise rc.InputError("Laws change the gap of this contact: solve it by problem.solve.")
    load = problem.require_load(pressure=pressure, force=force, approach=approach)
    with convolution.use_threads(plan.thread_choice[0]):
        task = make_task(plan, problem.initial_gap, load)
        task = attrs.evolve(task, initial_gap=convolution.from_numpy(task.initial_gap))
        (outcome,) = solver.solve_on_device(convolution, [task])
        certificate = confirm(plan, convolution, task, outcome)
    gap = task.initial_gap * plan.peak_to_valley
    found = make_solution(plan, gap, outcome, certificate, time.perf_counter() - started)
    origin = Origin(problem.parts, load.arguments, source=problem)
    solution = attrs.evolve(found, origin=origin, parts=OnDevice(problem))
    if throw:
        require_certified(solution)
    return solution
