"""What a film law takes before anything is solved: its pair, its separations, its time and its memory."""

from __future__ import annotations

from collections.abc import Iterable

import attrs

from roughcontact._answers.laws.film_rows import make_quarters
from roughcontact._base.checks import flag, list_of, number
from roughcontact._base.machine import require_memory
from roughcontact._base.units import ShownAsPrinted, binary, counted, si
from roughcontact._parts.grid import Boundary
from roughcontact._solve.problem import ContactProblem
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Steps of a range of separations, below a limit each, and above all of them: straight lines between rows then hold.
_STEPS = ((2.5, 0.25), (4.0, 0.5))
_LAST_STEP = 1.0
_MAX_SEPARATION = 100.0
# Seconds of a row at least, seconds on 256 x 256 cells, and the power of the cells of what is more; bytes a cell of its
# elimination. Measured on 64 to 1024 cells along a side at H = 0.5 and 2.
_MINIMUM_SECONDS = 0.03
_SECONDS = 0.5
_EXPONENT = 1.16
_BYTES = 1250


@attrs.frozen
class FilmPlan(ShownAsPrinted):
    """What a film law will take.

    Attributes
    ----------
    separations
        Over Sq, ascending.
    states
        Number of contacts and flows, those of the quarters included.
    seconds
        Time, s; it may be a third or three times that.
    memory
        Peak memory, bytes.
    """

    separations: tuple[float, ...]
    states: int
    seconds: float
    memory: int

    def __str__(self) -> str:
        low, *_, high = self.separations
        quarters = "" if self.states == len(self.separations) else f", {self.states} states with those of the quarters"
        rows = f"{counted(len(self.separations), 'separation')}, {low:g} to {high:g} Sq"
        return f"{rows}{quarters}: about {si(self.seconds, 's', 1)}, {binary(self.memory)}"


@guarded
def plan_film(problem: ContactProblem, separation: Iterable[float], *, sampling: bool = True) -> FilmPlan:
    """Return what `film_law` will take with these arguments.

    Raises
    ------
    InputError
        If `film_law` would.
    NotEnoughMemory
        If it needs more memory than there is.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.faces import plan_film
    >>> body = rc.Body(rc.WavySurface(1e-6, 50e-6), rc.Elastic(210e9, 0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 50e-6), boundary="periodic")
    >>> print(plan_film(problem, [1.5, 3.0]))
    2 separations, 1.5 to 3 Sq: about 70 ms, 1.307 MiB
    """
    require_pair(problem)
    wanted = read_separations(separation)
    pairs = [problem, *list_quarters(problem, sampling)]
    seconds = len(wanted) * sum(_estimate_seconds(one) for one in pairs)
    memory = problem.plan.memory + _BYTES * problem.plan.grid.cells
    require_memory(memory, "A film law", "choose fewer cells, by map.resample or a smaller piece")
    return FilmPlan(tuple(wanted), len(wanted) * len(pairs), seconds, memory)


def _estimate_seconds(problem: ContactProblem) -> float:
    share: float = problem.plan.grid.cells / 256**2
    return float(_MINIMUM_SECONDS + _SECONDS * share**_EXPONENT)


@guarded
def space_separations(first: float, last: float) -> list[float]:
    """Return separations over Sq from one to another, in steps that grow from 0.25 to 1.

    Straight lines between the rows of a film law then hold.

    Raises
    ------
    InputError
        If they are not above 0, ascending and at most 100.

    Examples
    --------
    >>> from roughcontact.faces import space_separations
    >>> space_separations(2.0, 5.0)
    [2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0]
    """
    at = number(first, "The first separation of a range", above=0.0)
    end = number(last, "The last separation of a range", above=at, at_most=_MAX_SEPARATION)
    found = []
    while at < end * (1.0 - 1e-9):
        found.append(at)
        at += next((step for limit, step in _STEPS if at < limit), _LAST_STEP)
    return [*found, end]


def require_pair(problem: object) -> None:
    """Raise `InputError` unless a film law of the problem means something."""
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem of a law", problem, "a ContactProblem")
    if problem.plan.interaction is not None or problem.remembers:
        raise InputError(
            "A film law has one state for each separation, but surfaces that attract each other, or laws that "
            f"remember, have several: omit {argument('adhesion')} and {argument('laws')}."
        )
    if problem.boundary is not Boundary.PERIODIC:
        raise InputError(
            f"Flow factors need {argument('boundary', 'periodic')}, but got '{problem.boundary}': a cut-out leaks at "
            "its borders. A map that does not repeat can be mirrored at its borders."
        )
    for body in (problem.body, problem.counterbody):
        mask = body.non_measured(problem.plan.grid)
        if mask is not None and mask.any():
            raise InputError("Some points of a map are not measured, and would count as closed: fill() the map first.")


def read_separations(separation: object) -> list[float]:
    """Return ascending separations over Sq."""
    what = "The separations"
    allowed = "a list of two or more numbers above 0, each over Sq"
    found = sorted(number(one, what, above=0.0) for one in list_of(separation, what, allowed))
    if len(found) < 2:
        raise InputError.about(what, found, allowed)
    if len(set(found)) < len(found):
        raise InputError("A separation is given twice: give each once.")
    return found


def list_quarters(problem: ContactProblem, sampling: object) -> list[ContactProblem]:
    """Return the quarters whose scatter is that of other places; none of surfaces that are not random."""
    is_random = any(body.surface.is_random for body in (problem.body, problem.counterbody))
    return make_quarters(problem) if flag(sampling, "sampling=") and is_random else []
