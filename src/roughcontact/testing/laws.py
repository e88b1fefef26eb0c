"""Claims about laws: what changes the gap of a contact, and what it remembers."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import roughcontact as rc
from roughcontact._solve.solution import ContactSolution, Governed, Law, Process, laws
from roughcontact.errors import InputError, NotConverged
from roughcontact.testing.claim import DoesNotApply, claim, require, require_equal

# Forces on a ball, N, that rise and fall.
_FORCES = (1.0, 2.0, 0.5)
# Tangential forces beside them, N, and a coefficient of friction, of a law that depends on slip alone.
_PUSHES = ((0.1, 0.0), (-0.1, 0.0), (0.05, 0.0))
_FRICTION = 0.3
# Time, s, and sliding distance, m, at each of them, of a law that depends on what passes; accuracy of its increments.
_PASSED = (0.0, 0.5, 1.0)
_ACCURACY = 0.05
# Largest residual of a condition: that of the contact is 2e-5.
_MAX_ERROR = 1e-4


def _problem(law: Law) -> rc.ContactProblem:
    if law.of_material:
        raise DoesNotApply("a material brings it")
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness=2e9))
    return rc.ContactProblem(ball, grid=rc.Grid((32, 24), (100e-6, 80e-6)), laws=law)


def _follow(law: Law) -> tuple[ContactSolution, ...]:
    problem = _problem(law)
    passed: Any = dict.fromkeys([rate for rate in law.rates if rate != "slip"], _PASSED)
    if not law.rates:
        return problem.sweep(force=_FORCES).states
    if not passed:
        return problem.path(force=_FORCES, tangential_force=_PUSHES, friction=_FRICTION).states
    path: rc.results.LoadPath = problem.path(force=_FORCES, **passed, accuracy=_ACCURACY)
    return path.states


def _memory_of(state: ContactSolution) -> Any:
    effect = state._find_added(Governed)
    assert effect is not None
    return effect.memory[0]


@claim("law", "certified states")
def _certified(law: Law) -> str:
    try:
        states = _follow(law)
    except NotConverged as error:
        raise AssertionError(f"a state with it is not certified: {error}") from error
    residual = max(state.certificate.error for state in states)
    require(residual <= _MAX_ERROR, f"a condition of the certificate is violated by {residual:.1e}")
    return f"largest residual {residual:.1e}"


@claim("law", "the same from a file")
def _saved(law: Law) -> None:
    if laws.name_of(type(law)) is None:
        raise DoesNotApply("only a registered law comes from a file")
    state = _follow(law)[-1]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "state.npz")
        state.save(file)
        try:
            # Loading verifies the change of the gap and what it remembers.
            loaded = ContactSolution.load(file)
        except InputError as error:
            raise AssertionError(f"a file of it is not verified: {error}") from error
    for name, values in _memory_of(state).items():
        require_equal(_memory_of(loaded)[name], values, f"{name} of a file is another one")


@claim("law", "the same twice")
def _repeatable(law: Law) -> None:
    one, other = (_follow(law)[-1] for _ in range(2))
    require_equal(one.pressure, other.pressure, "the same loads give another pressure the second time")


@claim("law", "arrays unchanged")
def _unchanged(law: Law) -> None:
    problem = _problem(law)
    before = problem.initial_gap.copy()
    state = problem.sweep(force=_FORCES[:2]).states[-1]
    kept = [values.copy() for values in _memory_of(state).values()]
    problem.sweep(force=_FORCES)
    require_equal(problem.initial_gap, before, "it writes into the gap of the problem")
    for values, old in zip(_memory_of(state).values(), kept, strict=True):
        require_equal(values, old, "it writes into what it remembered before")


@claim("law", "memory of the loads before")
def _remembers(law: Law) -> str:
    if not isinstance(law, Process):
        raise DoesNotApply("it does not remember")
    first, *_, last = _follow(law)
    names = [name for name in law.remembered if not np.array_equal(_memory_of(first)[name], _memory_of(last)[name])]
    require(names, "what it remembers does not change with the loads")
    return ", ".join(names)
