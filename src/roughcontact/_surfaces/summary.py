"""A height map as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact.units import counted, si
from roughcontact.units.text import fit

if TYPE_CHECKING:
    from roughcontact._surfaces.heightmap import HeightMap


def summarize(height_map: HeightMap) -> str:
    """Return cells, size, heights, history and warnings of a map, line by line."""
    heights, missing = height_map.values, height_map.non_measured
    measured = heights if missing is None else heights[~missing]
    low, high, rms = (si(float(value), "m") for value in (measured.min(), measured.max(), measured.std()))
    lines = [
        f"grid          {height_map.grid}{', periodic' if height_map.periodic else ''}",
        f"heights       {low} to {high}, rms height Sq {rms}",
        *(f"history       {text}" for text in height_map.history),
    ]
    if missing is not None:
        lines.append(f"non-measured  {counted(int(missing.sum()), 'point')} of {missing.size}")
    return fit("\n".join([*lines, *(f"warning       {text}" for text in height_map.warnings)]))
