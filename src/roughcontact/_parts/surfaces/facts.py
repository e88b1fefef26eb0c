"""Cells, size, heights, history and non-measured points of a height map in words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from roughcontact._base.units import counted, percent, si

if TYPE_CHECKING:
    from roughcontact._parts.surfaces.heightmap import HeightMap

# Characters of the names beside the facts.
_LABEL_WIDTH = 14


def list_facts(height_map: HeightMap) -> list[tuple[str, str]]:
    """Return cells, size, heights, history and non-measured points of a map, each with its name."""
    grid = height_map.grid
    heights = height_map.values
    missing = height_map.non_measured
    measured = heights if missing is None else heights[~missing]
    low, high, rms, dx, dy = (
        si(float(value), "m") for value in (measured.min(), measured.max(), measured.std(), *grid.spacing)
    )
    facts = [
        ("grid", f"{grid}{', periodic' if height_map.periodic else ''}, cells of {dx} x {dy}"),
        ("heights", f"{low} to {high}"),
        ("Sq", f"{rms} about the mean"),
        *(("history", text) for text in height_map.history),
    ]
    if missing is not None:
        count = int(missing.sum())
        text = f"{count} of {counted(missing.size, 'point')} ({percent(count / missing.size)})"
        facts.append(("non-measured", text))
    return facts


def write_facts(facts: Iterable[tuple[str, str]]) -> list[str]:
    """Return facts line by line."""
    return [f"{name:<{_LABEL_WIDTH}}{text}" for name, text in facts]
