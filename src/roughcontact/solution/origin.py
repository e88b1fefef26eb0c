"""Where a solution comes from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs


@attrs.frozen(eq=False)
class Origin:
    """What was solved: ``ContactProblem(**origin.problem).solve(**origin.load)`` does it again.

    Attributes
    ----------
    problem
        The arguments of the `ContactProblem`.
    load
        The load, by the name it was given under.
    """

    problem: Mapping[str, Any]
    load: Mapping[str, float]
