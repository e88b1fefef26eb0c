"""Height maps in a notebook: a small picture and a few numbers."""

from __future__ import annotations

import html
import math

from roughcontact._faces.panels.figures import can_draw, draw_panel
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import HeightMap, SampledSurface, list_facts
from roughcontact.errors.door import guarded

# Points along a side of the picture: more would not show.
_MAX_PICTURE_POINTS = 512
# Notebooks set the texts of tables on the right.
_LEFT = ' style="text-align: left; vertical-align: top"'


@guarded
def show_map(height_map: HeightMap) -> str:
    """Return a picture of a map (with matplotlib), its size, heights, history and warnings as HTML for a notebook."""
    facts = list_facts(height_map._sample(None), height_map.history, height_map.warnings)
    rows = "".join(
        f"<tr><th{_LEFT}>{html.escape(name)}</th><td{_LEFT}>{html.escape(text)}</td></tr>" for name, text in facts
    )
    table = f"<table>{rows}</table>"
    if not can_draw():
        return table
    words = html.escape(f"The heights on {height_map.grid}")
    address = draw_panel("surface", _thin(height_map), "map")
    return f'{table}<img src="{address}" alt="{words}" style="max-width: 24rem">'


def _thin(height_map: HeightMap) -> SampledSurface:
    """Return the heights, of a large map each n-th point along x and y, with NaN at non-measured points."""
    sampled = height_map._sample(None)
    step = math.ceil(max(sampled.heights.shape) / _MAX_PICTURE_POINTS)
    heights = sampled.heights[::step, ::step]
    sides = (step * n * length for n, length in zip(heights.shape, sampled.grid.spacing, strict=True))
    return SampledSurface(heights, Grid(heights.shape, tuple(sides)), sampled.periodic)
