"""Solutions and height maps in a notebook: a small picture and a few numbers."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

from roughcontact._base.tables import Result
from roughcontact._faces.html.words import escape, typeset
from roughcontact._faces.panels.figures import can_draw, draw_panel
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import HeightMap, SampledSurface, list_facts
from roughcontact._solve.solution import ContactSolution, list_all_warnings, list_answers
from roughcontact.errors.door import guarded

# Cells up to which a notebook shows a picture of a solution unasked.
_MAX_PICTURE_CELLS = 2**20
# Points along a side of the picture of a map: more would not show.
_MAX_PICTURE_POINTS = 512
# Notebooks set numbers on the right, which suits no words.
_LEFT = ' style="text-align: left; vertical-align: top"'


@functools.singledispatch
def show_in_notebook(result: Result) -> str:
    """Return a result as a notebook shows it."""
    return f"<pre>{escape(result)}</pre>"


@show_in_notebook.register
def _show_solution(solution: ContactSolution) -> str:
    """Return answer, verdict and warnings for a notebook, and a picture unless the grid is large."""
    rows = {name: escape(typeset(text)) for name, text in list_answers(solution).items()}
    status = {"status": escape(solution.status)}
    rows = rows | status if solution.status.success else status | rows
    warnings = list_all_warnings(solution)
    if warnings:
        rows["warnings"] = f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in warnings)}</ul>"
    shown = _make_table(rows, f"<caption>{escape(f'{solution.grid}, boundary {solution.boundary}')}</caption>")
    if can_draw() and solution.grid.cells <= _MAX_PICTURE_CELLS and solution.contact.any():
        shown += _make_picture(draw_panel("solution", solution, "pressure"), "The contact pressure")
    return shown


@guarded
def show_map(height_map: HeightMap) -> str:
    """Return a picture of a map (with matplotlib), its size, heights, history and warnings as HTML for a notebook."""
    facts = list_facts(height_map._sample(None), height_map.history, height_map.warnings)
    shown = _make_table({name: escape(text) for name, text in facts})
    if can_draw():
        shown += _make_picture(draw_panel("surface", _thin(height_map), "map"), f"The heights on {height_map.grid}")
    return shown


def _make_table(rows: Mapping[str, str], head: str = "") -> str:
    """Return a table of names, which are escaped, beside contents, which are HTML already."""
    body = "\n".join(
        f'<tr><th scope="row"{_LEFT}>{escape(name)}</th><td{_LEFT}>{content}</td></tr>'
        for name, content in rows.items()
    )
    return f"<table>{head}<tbody>{body}</tbody></table>"


def _make_picture(address: str, words: str) -> str:
    return f'<img src="{address}" alt="{escape(words)}" style="max-width: 24rem">'


def _thin(height_map: HeightMap) -> SampledSurface:
    """Return the heights, of a large map each n-th point along x and y, with NaN at non-measured points."""
    sampled = height_map._sample(None)
    step = math.ceil(max(sampled.heights.shape) / _MAX_PICTURE_POINTS)
    heights = sampled.heights[::step, ::step]
    sides = (step * n * length for n, length in zip(heights.shape, sampled.grid.spacing, strict=True))
    return SampledSurface(heights, Grid(heights.shape, tuple(sides)), sampled.periodic)
