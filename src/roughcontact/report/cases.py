"""The cases of a report: every combination of what is to be compared."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from typing import Any, cast

import attrs

from roughcontact.checks import integer
from roughcontact.convolvers import Convolver
from roughcontact.errors import InputError
from roughcontact.kernels import InfluenceKernel
from roughcontact.problem import ContactProblem
from roughcontact.refinement import on_grid
from roughcontact.registry import Registry, areas, convolvers, kernels, solvers
from roughcontact.solution import EstimatesArea
from roughcontact.solvers import Solver
from roughcontact.solvers.base import positive_tolerance

# Fewer cells a side than this are not offered unasked.
_FEWEST = 16


@attrs.frozen(eq=False, kw_only=True)
class Case:
    """What is solved and timed.

    Attributes
    ----------
    shape
        Cells (nx, ny).
    kernel, convolver, solver
        The parts.
    convolver_name, solver_name
        Both in words.
    """

    shape: tuple[int, int]
    kernel: str | InfluenceKernel
    convolver: str | Convolver
    solver: Solver
    convolver_name: str
    solver_name: str

    def dressed(self, problem: ContactProblem) -> ContactProblem:
        """Return the problem with this case's parts, on its own grid."""
        return attrs.evolve(problem, kernel=self.kernel, convolver=self.convolver, solver=self.solver)

    def gridded(self, dressed: ContactProblem, between: str | None) -> ContactProblem:
        """Return a dressed problem on this case's grid, with nothing computed yet."""
        if self.shape == dressed.plan.grid.shape:
            return attrs.evolve(dressed)
        return on_grid(dressed, self.shape, between)

    def __str__(self) -> str:
        nx, ny = self.shape
        return f"{nx} x {ny}, {self.solver_name}"


def cases_of(
    problem: ContactProblem,
    cells: Sequence[int] | None,
    kernels_: Sequence[Any] | None,
    convolvers_: Sequence[Any] | None,
    solvers_: Sequence[Any] | None,
    tolerances: Sequence[float] | None,
) -> tuple[Case, ...]:
    """Return all combinations; what is left out stays as the problem has it.

    Raises
    ------
    InputError
        If a list is empty or holds what is not known.
    """
    chosen_kernels = listed(kernels_, "The kernels", kernels, InfluenceKernel, problem.kernel)
    chosen_convolvers = listed(convolvers_, "The convolvers", convolvers, Convolver, problem.convolver)
    chosen_solvers = listed(solvers_, "The solvers", solvers, Solver, problem.solver)
    chosen_by_auto = attrs.evolve(problem, convolver="auto").plan.convolver
    named_convolvers = [(choice, worded(choice, convolvers, chosen_by_auto)) for choice in chosen_convolvers]
    named_solvers = _toleranced(problem, chosen_solvers, tolerances)
    return tuple(
        Case(shape=shape, kernel=kernel, convolver=convolver, solver=solver, convolver_name=called, solver_name=name)
        for kernel, (convolver, called), (name, solver), shape in itertools.product(
            chosen_kernels, named_convolvers, named_solvers, _shapes(problem, cells)
        )
    )


def listed(values: Sequence[Any] | None, what: str, registry: Registry, base: type, own: object) -> tuple[Any, ...]:
    """Return what is to be compared, checked, or what the problem has.

    Raises
    ------
    InputError
        If it is no list, is empty, or holds what is not registered.
    """
    if values is None:
        return (own,)
    found = _sequence(values, what, f"a list of registered names or {registry.kind} objects, at least one")
    for value in found:
        if not (value == "auto" and registry is not kernels and registry is not areas):
            registry.resolve(value, base)
    return found


def estimators_of(values: Sequence[Any]) -> tuple[str | EstimatesArea, ...]:
    """Return the area estimators, checked; see `listed`."""
    return listed(values, "The area estimators", areas, EstimatesArea, None)


def worded(choice: object, registry: Registry | None = None, made: object = None) -> str:
    """Return a part in words: its registered name, or that of what was made for ``"auto"``."""
    if not isinstance(choice, str):
        return repr(choice)
    return choice if registry is None or choice != "auto" else _registered(registry, type(made))


def _registered(registry: Registry, cls: type) -> str:
    for name in registry.names():
        # A plug-in that cannot be loaded is none of our business here.
        with contextlib.suppress(InputError):
            if registry.get(name) is cls:
                return name
    return cls.__name__


def _sequence(values: Any, what: str, allowed: str) -> tuple[Any, ...]:
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise InputError.about(what, values, allowed)
    found = tuple(values)
    if not found:
        raise InputError.about(what, values, allowed)
    return found


def _shapes(problem: ContactProblem, cells: Sequence[int] | None) -> tuple[tuple[int, int], ...]:
    """Return the grids, from coarse to fine; cells keep their proportions as well as whole numbers let them."""
    nx, ny = problem.plan.grid.shape
    if cells is None:
        counts = [nx // factor for factor in (8, 4, 2) if min(nx, ny) // factor >= _FEWEST] + [nx]
    else:
        given = _sequence(cells, "The cells along x", "a list of whole numbers, at least one")
        counts = sorted({integer(count, "The number of cells along x", at_least=2) for count in given})
    return tuple((count, max(round(count * ny / nx), 2)) for count in counts)


def _toleranced(
    problem: ContactProblem, choices: tuple[Any, ...], tolerances: Sequence[float] | None
) -> list[tuple[str, Solver]]:
    made = [attrs.evolve(problem, solver=choice).plan.solver for choice in choices]
    named = [(worded(choice, solvers, solver), solver) for choice, solver in zip(choices, made, strict=True)]
    if tolerances is None:
        return named
    given = _sequence(tolerances, "The tolerances", "a list of numbers above 0, at least one")
    values = [positive_tolerance(value) for value in given]
    adjusted = [(name, solver, _at_tolerance(solver, value)) for name, solver in named for value in values]
    # The words of an object tell its tolerance.
    return [(repr(new) if name == repr(old) else name, new) for name, old, new in adjusted]


def _at_tolerance(solver: Solver, tolerance: float) -> Solver:
    fields: Any = getattr(type(solver), "__attrs_attrs__", ())
    if "tolerance" not in {field.name for field in fields}:
        raise InputError(f"The solver {solver!r} has no tolerance that can be set: leave tolerances= out.")
    adjusted: Any = solver
    return cast(Solver, attrs.evolve(adjusted, tolerance=tolerance))
