"""A height map in words, and what is doubtful about it."""

from __future__ import annotations

import numpy as np

import roughcontact as rc
from roughcontact._base.checks import Array
from roughcontact._base.units.text import fit
from roughcontact._faces.cli.wording import name_options
from roughcontact._parts.surfaces import list_facts
from roughcontact._solve.solution import find_scene
from roughcontact.reference import roughness

# Fraction of the variance of the heights that is form, above which the spectrum is that of the form.
_FORM = 0.5
# Degree of the polynomial that is taken for form: tilt, curvature and twist; and the fewest cells along an axis for it.
_DEGREE = 2
_FEWEST = 8


def describe_map(surface: rc.HeightMap) -> str:
    """Return size, cells and roughness of a height map, and its warnings, in lines of at most 80 columns."""
    lines = list_facts(surface)
    if not surface.periodic:
        lines.append("spectrum      of the heights times a Hann window:")
    lines.append(str(roughness(surface.values, surface.grid, periodic=surface.periodic)))
    return "\n".join([fit("\n".join(lines)), *list_warnings(surface)])


def list_warnings(surface: rc.HeightMap) -> list[str]:
    """Return what is doubtful about a height map, in lines of at most 80 columns: its units, its form, its quality."""
    gap = surface.values.max() - surface.values
    units = find_scene(gap, surface.grid, rc.Boundary.FREE, ())[0].warning
    texts = (units, _judge_form(surface), *surface.warnings)
    return [fit(f"warning       {name_options(text, ('unit',))}") for text in texts if text]


def _judge_form(surface: rc.HeightMap) -> str:
    heights = _measured(surface)
    if surface.periodic or min(surface.grid.shape) < _FEWEST or heights.max() == heights.min():
        return ""
    form = 1.0 - float(_measured(surface.detrend(_DEGREE)).var() / heights.var())
    if form < _FORM:
        return ""
    return (
        f"{100.0 * form:.3g} % of the variance of the heights is tilt and curvature: "
        "'roughcontact info --detrend 2' describes the roughness without them"
    )


def _measured(surface: rc.HeightMap) -> Array:
    return surface.values if surface.non_measured is None else np.asarray(surface.values[~surface.non_measured])
