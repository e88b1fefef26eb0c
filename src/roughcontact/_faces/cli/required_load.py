"""``roughcontact solve --solve-for``: the load at which a contact has a wanted area, stiffness or other answer."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import roughcontact as rc
from roughcontact._base.arrays import Array
from roughcontact._base.machine.progress import ChangeProgress
from roughcontact._faces.cli.options import refuse
from roughcontact._faces.cli.problem import make_part
from roughcontact._faces.cli.progress import count_solves, describe_steps
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import RequiredLoad, find_required_load
from roughcontact._solve.solution import DEFAULT_AREA

# Name of the load among the answers.
ANSWER = "required-load"
_OPTION = "--solve-for"
# Options that are for another kind of load.
_OF_OTHER_LOADS = ("adhesion", "friction", "refine", "area_within", "peak_within", "uncertainty")


def refuse_for_wanted(options: argparse.Namespace) -> None:
    """Refuse what does not fit a load that is asked for, before anything is read."""
    if options.solve_for is not None:
        refuse(options, _OF_OTHER_LOADS, f"needs a load that is given: omit it with {_OPTION}, or give the load.")


def wanted_of(texts: Sequence[str]) -> tuple[rc.Response[Any], str]:
    """Return the response, and the text of what is wanted of it, of ``leakage=1mm3/s viscosity=1mPa.s ...``."""
    name, equals, value = texts[0].partition("=")
    if not equals:
        allowed = "NAME=VALUE, such as stiffness=1GN/m"
        raise rc.InputError.about(f"What {_OPTION} asks for", texts[0], allowed)
    if name == "area":
        chosen = dict(text.partition("=")[::2] for text in texts[1:])
        if set(chosen) - {"estimator"}:
            raise rc.InputError.about(f"A field of {_OPTION} area", texts[1], "estimator=NAME")
        return rc.areas.resolve(chosen.get("estimator", DEFAULT_AREA)), value
    known = name if name in rc.responses else name.replace("_", "-")
    if known not in rc.responses:
        raise rc.InputError.unknown("answer", name, ["area", *rc.responses])
    response: rc.Response[Any] = make_part(rc.responses, _OPTION, known, texts[1:])
    return response, value


def solve_wanted(
    problem: rc.ContactProblem, wanted: tuple[rc.Response[Any], str], change: ChangeProgress
) -> RequiredLoad:
    """Return the load at which the contact has what is wanted; `InputError`, with the option, where there is none."""
    response, value = wanted
    plan = problem.plan
    tried = 0
    expected: int | None = None

    def solve(load: Load, start: Array | None) -> rc.ContactSolution:
        nonlocal tried
        what = f"load {tried + 1}{f' of about {expected}' if expected else ''}, {load}"
        part = (tried, max(expected or 0, tried + 1))
        # The first answer tells how many solves there will be.
        fraction = count_solves(plan.grid.shape, plan.solver.tolerance, part) if expected else lambda step: None
        tried += 1
        return problem.solve(**load.arguments, start=start, on_step=describe_steps(change, what, fraction))

    def foresee(left: int) -> None:
        nonlocal expected
        expected = tried + left

    try:
        return find_required_load(problem, solve, response, value, {}, foresee)
    except rc.InputError as error:
        raise rc.InputError(f"{_OPTION}: {error.marked}") from error
