"""The plan of a contact with friction, in words: that of its normal contact, the pair of bodies, and its memory."""

from __future__ import annotations

import attrs

from roughcontact._base.units import PlainText, binary
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._parts.materials import PairConstants, pair_constants
from roughcontact._solve.problem.memory import require_arrays
from roughcontact._solve.problem.plan import OMITTED_FRICTION, SolvePlan
from roughcontact._solve.solution import ContactSolution, Process

# Memory of steady sliding at light contact, in float64 arrays of the grid, without and with a free boundary, for like
# and unlike bodies, and of each further state of a path; measured by tests/problems/test_memory.py. Most are symbols
# of shear.
_FRICTION_ARRAYS = {False: (32.0, 39.9), True: (36.0, 50.5)}
_STATE_ARRAYS = (5.2, 10.8)
# Arrays of what is known of the state before, of one that is not kept: pressure and traction.
_EARLIER_ARRAYS = 3


def include_friction(plan: SolvePlan) -> SolvePlan:
    """Return the plan of the normal contact, of which friction is not omitted."""
    return attrs.evolve(plan, omitted=tuple(text for text in plan.omitted if not text.startswith(OMITTED_FRICTION)))


def explain_with_friction(plan: SolvePlan, law: FrictionLaw, states: int = 1) -> str:
    """Return the plan of a contact with friction, or of a path of so many states, in words.

    `InputError` if Poisson's ratio of a material is not known.
    """
    pair = pair_constants(*plan.materials)
    memory = f"{binary(memory_of_friction(plan, states))} with friction, at light contact"
    rows = [("friction", repr(law)), *list_pair(pair), ("memory", memory), *list_omitted_shear(pair)]
    return PlainText("\n".join([str(include_friction(plan)), *write_rows(rows)]))


def explain_state(plan: SolvePlan, state: ContactSolution) -> str:
    """Return the plan of a solved contact, with friction or without, in words."""
    return str(plan) if state.shear is None else explain_with_friction(plan, state.friction)


def require_memory_of_friction(plan: SolvePlan, states: int = 1, apart: int = 0) -> None:
    """Refuse a problem of which a contact with friction, or a path of so many states, does not fit into memory.

    Light contact is assumed; `InputError` if Poisson's ratio of a material is not known.
    """
    what = "A contact with friction" if states == 1 else f"A path of {states} states"
    require_arrays(memory_of_friction(plan, states, apart), what, plan.grid, plan.boundary, plan.memory_limit)


def memory_of_friction(plan: SolvePlan, states: int = 1, apart: int = 0) -> int:
    """Return the peak memory of a contact with friction, or of a path of so many states, at light contact, bytes.

    Some of them, `apart`, do not begin with one that is kept. Each has what laws add to the gap and remember.
    """
    coupled = pair_constants(*plan.materials).beta != 0.0
    remembered = sum(len(law.remembered) for law in plan.laws if isinstance(law, Process))
    # Where nothing changes the gap, states under one load share its contact.
    of_state = _STATE_ARRAYS[coupled or bool(plan.laws)]
    arrays = _FRICTION_ARRAYS[plan.boundary.has_free_axis][coupled] + (states - 1) * of_state
    arrays += states * (remembered + bool(plan.laws)) + apart * (remembered + _EARLIER_ARRAYS)
    return int(8 * plan.grid.cells * arrays)


def list_pair(pair: PairConstants, passes: int | None = None) -> list[tuple[str, str]]:
    """Return how the solves of a pair of bodies depend on each other, with the largest number of passes if known."""
    coupled = pair.beta != 0.0
    at_most = "" if passes is None else f", at most {passes} of each in an increment"
    return [
        ("pair", f"beta {pair.beta:.4g}, gamma {pair.gamma:.4g}"),
        ("coupling", f"normal and tangential solves in turn{at_most}" if coupled else "none: one solve of each"),
        ("components", "xx, yy, xy" + (", zx, zy" if coupled else "")),
    ]


def list_omitted_shear(pair: PairConstants) -> list[tuple[str, str]]:
    """Return what a pair of bodies does not need, with the reasons."""
    texts = []
    if pair.beta == 0.0:
        texts.append("displacement across the surface by the traction, and along it by pressure: beta = 0")
    if pair.gamma == 0.0:
        texts.append("displacement along x by traction along y: gamma = 0")
    return [("omitted", text) for text in texts]


def write_rows(rows: list[tuple[str, str]]) -> list[str]:
    """Return lines with a label in front of each text."""
    return [f"{label:<10} {text}" for label, text in rows]
