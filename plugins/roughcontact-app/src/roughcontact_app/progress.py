"""How far a run has come, as a fraction and in words."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from roughcontact.typing import Step

# Seconds between two messages: an iteration of a small grid takes a millisecond.
_INTERVAL = 0.1


class Progress:
    """Messages about a run of several solves, each of many iterations."""

    def __init__(self, shape: tuple[int, int], loads: int, tolerance: float, send: Callable[[dict[str, Any]], None]):
        self._shape = shape
        self._loads = loads
        self._tolerance = tolerance
        self._send = send
        self._solve = 0
        self._fraction = 0.0
        self._load = ""
        self._last = 0.0

    def begin(self, load: str) -> None:
        """Begin the next solve."""
        self._solve += 1
        self._fraction = 0.0
        self._load = load
        self._last = 0.0

    def step(self, step: Step) -> None:
        """Count an iteration."""
        self._fraction = max(self._fraction, step.fraction(self._shape, self._tolerance))
        now = time.monotonic()
        if now - self._last < _INTERVAL:
            return
        self._last = now
        cells = " x ".join(map(str, step.shape))
        of_several = f"load {self._solve} of {self._loads}, " if self._loads > 1 else ""
        self._send(
            {
                "phase": "solving",
                "fraction": (self._solve - 1 + self._fraction) / self._loads,
                "text": f"{of_several}{self._load}: {cells} cells, iteration {step.iteration}, error {step.error:.1e} "
                f"(ends at {self._tolerance:.0e})",
            }
        )
