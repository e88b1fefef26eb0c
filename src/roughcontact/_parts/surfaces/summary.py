"""A height map as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from roughcontact._base.units import counted, si
from roughcontact._base.units.text import fit, printable
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._parts.surfaces.heightmap import HeightMap


def summarize(height_map: HeightMap) -> str:
    """Return what `list_facts` says of a map, and its warnings."""
    return fit("\n".join([*list_facts(height_map), *(f"warning       {text}" for text in height_map.warnings)]))


def check_history(value: Sequence[str]) -> tuple[str, ...]:
    """Return how a map was processed, texts that may be printed whatever file they come from, or raise `InputError`."""
    if not isinstance(value, (tuple, list)) or not all(isinstance(text, str) for text in value):
        raise InputError.about("The history of a height map", value, "a tuple of texts")
    return tuple(map(printable, value))


def list_facts(height_map: HeightMap) -> list[str]:
    """Return cells, size, heights, history and non-measured points of a map, line by line."""
    grid = height_map.grid
    heights = height_map.values
    missing = height_map.non_measured
    measured = heights if missing is None else heights[~missing]
    low, high, rms, dx, dy = (
        si(float(value), "m") for value in (measured.min(), measured.max(), measured.std(), *grid.spacing)
    )
    lines = [
        f"grid          {grid}{', periodic' if height_map.periodic else ''}, cells of {dx} x {dy}",
        f"heights       {low} to {high}",
        f"Sq            {rms} about the mean",
        *(f"history       {text}" for text in height_map.history),
    ]
    if missing is not None:
        count = int(missing.sum())
        lines.append(f"non-measured  {count} of {counted(missing.size, 'point')} ({100 * count / missing.size:.2g} %)")
    return lines
