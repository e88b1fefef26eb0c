"""The cases of a report: every combination of grids and parts."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import attrs

from roughcontact._answers.refinement import on_grid
from roughcontact._base.checks import integer
from roughcontact._base.registry import Registry
from roughcontact._parts.kernels import InfluenceKernel, kernels
from roughcontact._solve.convolvers import Convolver, convolvers
from roughcontact._solve.problem import ContactProblem
from roughcontact._solve.solvers import Solver, positive_tolerance, solvers
from roughcontact.errors import InputError

# Cells a side below which a coarser grid is solved only if it is listed.
_MIN_SIDE = 16


@attrs.frozen(eq=False, kw_only=True)
class Case:
    """One combination: cells (nx, ny), parts, and the name of the solver."""

    shape: tuple[int, int]
    kernel: str | InfluenceKernel
    convolver: str | Convolver
    solver: Solver
    solver_name: str

    def with_parts(self, problem: ContactProblem) -> ContactProblem:
        """Return the problem with this case's parts, on its own grid."""
        return attrs.evolve(problem, kernel=self.kernel, convolver=self.convolver, solver=self.solver)

    def put_on_grid(self, problem: ContactProblem, interpolation: str | None) -> ContactProblem:
        """Return a problem on this case's grid, with nothing computed yet."""
        if self.shape == problem.plan.grid.shape:
            return attrs.evolve(problem)
        return on_grid(problem, self.shape, interpolation)

    def __str__(self) -> str:
        return f"{self.shape[0]} x {self.shape[1]}, {self.solver_name}"


def make_cases(
    problem: ContactProblem,
    cells: Sequence[int] | None,
    kernels_: Sequence[Any] | None,
    convolvers_: Sequence[Any] | None,
    solvers_: Sequence[Any] | None,
    tolerances: Sequence[float] | None,
) -> tuple[Case, ...]:
    """Return all combinations; parts that are not listed stay as the problem has them.

    Raises
    ------
    InputError
        If a list is empty or holds an unknown part.
    """
    auto = attrs.evolve(problem, convolver="auto", solver="auto").plan
    chosen_kernels = check_choices(kernels_, "The kernels", kernels, problem.kernel)
    chosen_convolvers = check_choices(convolvers_, "The convolvers", convolvers, problem.convolver, auto.convolver)
    chosen_solvers = check_choices(solvers_, "The solvers", solvers, problem.solver, auto.solver)
    return tuple(
        Case(shape=shape, kernel=kernel, convolver=convolver, solver=solver, solver_name=name)
        for kernel, convolver, (name, solver), shape in itertools.product(
            chosen_kernels,
            chosen_convolvers,
            _set_tolerances(chosen_solvers, tolerances),
            _make_shapes(problem, cells),
        )
    )


def check_choices(
    values: Sequence[Any] | None, what: str, registry: Registry[Any], own: object, auto: object = None
) -> tuple[Any, ...]:
    """Return the listed parts, or the problem's own without a list; the name of `auto` replaces ``"auto"``.

    Raises
    ------
    InputError
        If the list is empty, or holds a part that is neither registered nor an object of the kind.
    """
    allowed = f"a list of registered names or {registry.kind} objects, at least one"
    parts = (own,) if values is None else _check_list(values, what, allowed)
    if auto is not None:
        parts = tuple(registry.name_of(type(auto)) or auto if part == "auto" else part for part in parts)
    for part in parts if values is not None else ():
        registry.resolve(part)
    return parts


def name_part(choice: object) -> str:
    """Return the registered name of a part, or the object in words."""
    return choice if isinstance(choice, str) else repr(choice)


def _check_list(values: Any, what: str, allowed: str) -> tuple[Any, ...]:
    items = tuple(values) if isinstance(values, (list, tuple, range)) else ()
    if not items:
        raise InputError.about(what, values, allowed)
    return items


def _make_shapes(problem: ContactProblem, cells: Sequence[int] | None) -> tuple[tuple[int, int], ...]:
    """Return the grids, from coarse to fine, with the problem's proportions as nearly as whole numbers allow."""
    nx, ny = problem.plan.grid.shape
    if cells is None:
        counts = [nx // factor for factor in (8, 4, 2) if min(nx, ny) // factor >= _MIN_SIDE] + [nx]
    else:
        given = _check_list(cells, "The cells along x", "a list of whole numbers, at least one")
        counts = sorted({integer(count, "The number of cells along x", at_least=2) for count in given})
    return tuple((count, max(round(count * ny / nx), 2)) for count in counts)


def _set_tolerances(choices: tuple[Any, ...], tolerances: Sequence[float] | None) -> list[tuple[str, Solver]]:
    """Return each solver at each tolerance, with its name."""
    named = [(name_part(choice), solvers.resolve(choice)) for choice in choices]
    if tolerances is None:
        return named
    given = _check_list(tolerances, "The tolerances", "a list of numbers above 0, at least one")
    values = [positive_tolerance(value) for value in given]
    changed = [(name, solver, solver.with_tolerance(value)) for name, solver in named for value in values]
    # The name of an object has its tolerance in it.
    return [(repr(new) if name == repr(old) else name, new) for name, old, new in changed]
