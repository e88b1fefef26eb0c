"""Many contacts on one grid that are solved at once: loads of one problem, or problems with surfaces of their own."""

from __future__ import annotations

from collections.abc import Sequence

import roughcontact as rc
import torch
from roughcontact.solving import make_task

from roughcontact_torch.convolver import TensorConvolution
from roughcontact_torch.masked import MaskedConjugateGradient, known_outcomes

# Relative difference of two convolutions by rounding: that of two moduli drops out.
_SAME_SYMBOL = 1e-12


def solve_at_once(
    problems: rc.ContactProblem | Sequence[rc.ContactProblem], pressures: Sequence[float]
) -> list[rc.ContactSolution]:
    """Return the certified solutions of contacts that are solved at once, one for each mean pressure.

    Small grids then fill a GPU. Each solution is the one of `ContactProblem.solve` up to the tolerance; its `seconds`
    are those of its certificate alone.

    Parameters
    ----------
    problems
        One problem for all pressures or one for each, on the tensors of `TorchFFT` and with `MaskedConjugateGradient`
        as solver. Grid, boundary, kernel and solver are the same in all; surfaces and materials may differ.
    pressures
        Nominal mean pressures, Pa.

    Raises
    ------
    InputError
        If the problems do not fit together, or bodies cannot carry their load.
    NotConverged
        If one of them does not converge.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_at_once
    >>> surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=32e-6, seed=1)
    >>> body = rc.Body(surface, rc.Elastic("210GPa", 0.3))
    >>> tensors = {"convolver": TorchFFT("cpu"), "solver": MaskedConjugateGradient()}
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 64e-6), boundary="periodic", **tensors)
    >>> low, high = solve_at_once(problem, [100e6, 200e6])
    >>> low.area().value < high.area().value
    True
    """
    loads = list(pressures)
    contacts = [problems] * len(loads) if isinstance(problems, rc.ContactProblem) else list(problems)
    if len(contacts) != len(loads) or not loads:
        raise rc.InputError(
            f"Contacts that are solved at once need a pressure each, but got {len(contacts)} problems "
            f"and {len(loads)} pressures."
        )
    solver, convolution = shared_parts(contacts)
    tasks = [
        make_task(one.plan, one.initial_gap, one.require_load(pressure=load))
        for one, load in zip(contacts, loads, strict=True)
    ]
    with convolution.use_threads(contacts[0].plan.thread_choice[0]):
        outcomes = solver.solve_all(convolution, tasks)
    with known_outcomes(list(zip(tasks, outcomes, strict=True))):
        return [one.solve(pressure=load) for one, load in zip(contacts, loads, strict=True)]


def shared_parts(contacts: Sequence[rc.ContactProblem]) -> tuple[MaskedConjugateGradient, TensorConvolution]:
    """Return the solver and the convolution of problems; `InputError` if they differ."""
    first = contacts[0]
    solver = first.plan.solver
    convolution = first.convolution
    if not (isinstance(solver, MaskedConjugateGradient) and isinstance(convolution, TensorConvolution)):
        raise rc.InputError(
            "Contacts on a device are solved by the masked solver on tensors: give the problem convolver='torch' and "
            f"solver='masked', not {first.plan.convolver!r} and {solver!r}."
        )
    for one in contacts[1:]:
        other = one.convolution
        same = one is first or (
            one.plan.solver == solver
            and isinstance(other, TensorConvolution)
            and one.plan.boundary is first.plan.boundary
            and other.symbol.shape == convolution.symbol.shape
            and one.plan.grid.shape == first.plan.grid.shape
            and torch.allclose(other.symbol, convolution.symbol, rtol=0.0, atol=_SAME_SYMBOL * _maximum(convolution))
        )
        if not same:
            raise rc.InputError(
                "Contacts that are solved at once need the same cells, boundary, kernel, convolver and solver."
            )
    return solver, convolution


def _maximum(convolution: TensorConvolution) -> float:
    return float(convolution.symbol.abs().max())
