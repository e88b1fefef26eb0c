"""The force of pull-off as an answer of a contact, beside its others."""

from __future__ import annotations

import attrs

from roughcontact._base.archive.plain import key_of
from roughcontact._solve.problem import ContactProblem, OnStateToPullOff, find_pull_off, problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses

# Forces that are kept, by the key of their problem: solutions at several loads, also those from files, share one.
_FOUND: dict[str, Estimate] = {}
_MOST_KEPT = 32


@responses.register("pull-off")
@attrs.frozen
class PullOff(Response[Estimate]):
    """Force at which surfaces that attract each other come apart, negative: the minimum on unloading from zero load.

    It is that of the problem, whatever the load of the solution; see `ContactProblem.pull_off`.
    """

    with_adhesion = "total pressure"

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the force, N; see `Response.respond`."""
        return find_pull_off_once(problem_of(solution))


def find_pull_off_once(problem: ContactProblem, on_state: OnStateToPullOff | None = None) -> Estimate:
    """Return the force of pull-off of a problem, N, which is followed once; see `find_pull_off`."""
    key = key_of(problem.parts)
    if key not in _FOUND:
        found = find_pull_off(problem, on_state)
        while len(_FOUND) >= _MOST_KEPT:
            del _FOUND[next(iter(_FOUND))]
        _FOUND[key] = found
    return _FOUND[key]
