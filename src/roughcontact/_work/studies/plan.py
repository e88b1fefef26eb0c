"""What a study will do, in words: plans, axes, number of solves, memory and time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from roughcontact._base.units import PlainText, binary
from roughcontact._parts.load import Load
from roughcontact._solve.problem import ContactProblem

# Convolutions of a solve, measured on rough surfaces over two decades of load with warm starts.
_CONVOLUTIONS = 25
# Values of an axis that are listed; of more, the first ones and the last.
_LISTED = 8
# Units of a time, s, from twice which on they are used.
_TIMES = {"hours": 3600.0, "minutes": 60.0, "s": 1.0}


def describe_study(
    known: Sequence[tuple[str, ContactProblem]],
    axes: Mapping[str, Sequence[Any]],
    loads: Sequence[Load],
    *,
    sampled: bool,
) -> str:
    """Return the plans of the known problems, the values on each axis, and the work of all solves.

    Parameters
    ----------
    known
        Names and problems: all, or the first where a function builds them.
    axes
        The values that are combined, by the name of their axis: problems, parameters of a function, seeds.
    loads
        The loads of each combination.
    sampled
        Whether the known problem is the first of several.
    """
    plans = [problem.plan for _, problem in known]
    kind = loads[0].kind
    count = math.prod(map(len, axes.values())) * len(loads)
    cells = sum(plan.grid.cells for plan in plans) / len(plans) * count
    seconds = sum(plan.seconds for plan in plans) / len(plans) * count
    lists = {**axes, kind: [str(load).removeprefix(f"{kind} ") for load in loads]}
    rows = [(name, _list_values(values)) for name, values in lists.items()]
    rows += [
        ("solves", f"{count}: {' x '.join(f'{len(values)} of {name}' for name, values in lists.items())}"),
        ("work", f"{cells / 1e6:.3g} million cells in all, about {_CONVOLUTIONS} convolutions for each"),
        ("memory", f"at most {binary(max(plan.memory for plan in plans))} for one solve"),
        ("time", f"about {_format_time(seconds)} in one process on this machine, within a factor of three"),
    ]
    if sampled:
        rows.append(("", "if all problems are like the first"))
    texts = [f"{name}:\n{problem.explain()}" for name, problem in known]
    return PlainText("\n\n".join([*texts, "\n".join(f"{label:<10} {text}" for label, text in rows)]))


def _list_values(values: Sequence[Any]) -> str:
    texts = [str(value) for value in values]
    return ", ".join(texts if len(texts) <= _LISTED else [*texts[: _LISTED - 1], "...", texts[-1]])


def _format_time(seconds: float) -> str:
    unit = next((unit for unit, length in _TIMES.items() if seconds >= 2.0 * length), "s")
    return f"{seconds / _TIMES[unit]:.2g} {unit}"
