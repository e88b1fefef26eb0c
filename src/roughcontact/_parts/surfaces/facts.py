"""Cells, size, heights, history and non-measured points of a height map in words."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from roughcontact._base.units import counted, percent, si
from roughcontact._parts.surfaces.base import SampledSurface

# Characters of the names beside the facts.
_LABEL_WIDTH = 14


def list_facts(sampled: SampledSurface, history: Iterable[str], warnings: Iterable[str] = ()) -> list[tuple[str, str]]:
    """Return cells, size, heights, history, non-measured points and warnings of a map, each with its name."""
    grid = sampled.grid
    heights = sampled.heights
    missing = int(np.count_nonzero(np.isnan(heights)))
    low, high, rms, dx, dy = (
        si(float(value), "m") for value in (np.nanmin(heights), np.nanmax(heights), sampled.rms_height, *grid.spacing)
    )
    facts = [
        ("grid", f"{grid}{', periodic' if sampled.periodic else ''}, cells of {dx} x {dy}"),
        ("heights", f"{low} to {high}"),
        ("Sq", f"{rms} about the mean"),
        *(("history", text) for text in history),
    ]
    if missing:
        text = f"{missing} of {counted(heights.size, 'point')} ({percent(missing / heights.size)})"
        facts.append(("non-measured", text))
    return [*facts, *(("warning", text) for text in warnings)]


def write_facts(facts: Iterable[tuple[str, str]]) -> list[str]:
    """Return facts line by line."""
    return [f"{name:<{_LABEL_WIDTH}}{text}" for name, text in facts]
