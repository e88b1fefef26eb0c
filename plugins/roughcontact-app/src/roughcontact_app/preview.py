"""What the page shows of a surface before the solve, beside its picture."""

from __future__ import annotations

import numpy as np
from roughcontact import HeightMap
from roughcontact.errors import InputError
from roughcontact.typing import si

from roughcontact_app.scene import Scene, ShownSurface
from roughcontact_app.words import end_sentence

# Fraction of the variance of the heights that may be a tilt, as of the rule of solutions.
_ADMISSIBLE_TILT = 0.5


def describe(scene: Scene, shown: ShownSurface) -> dict[str, object]:
    """Return the numbers, the history and the warnings of one of the surfaces."""
    heights = shown.surface.heights(scene.grid)
    missing = shown.surface.non_measured_on(scene.grid)
    measured = heights if missing is None else heights[~missing]
    nx, ny = scene.grid.shape
    lx, ly = scene.grid.size
    dx, dy = scene.grid.spacing
    warnings = []
    if isinstance(shown.source, HeightMap):
        warnings = [*shown.source.warnings, *_warn_of_tilt(scene, shown.source)]
    return {
        "rows": [
            ["Cells", f"{nx} x {ny}"],
            ["Size", f"{si(lx, 'm')} x {si(ly, 'm')}"],
            ["Size of a cell", f"{si(dx, 'm')} x {si(dy, 'm')}"],
            ["Sq (rms height)", si(float(np.std(measured)), "m")],
            ["Sz (peak to valley)", si(float(np.ptp(measured)), "m")],
            ["Non-measured points", _count_non_measured(scene, shown)],
            *_tell_certain(shown.source),
        ],
        "history": list(shown.surface.provenance),
        "warnings": [end_sentence(text) for text in warnings],
    }


def _tell_certain(source: object) -> list[list[str]]:
    """Return the row that says which part of a map the tip of the stylus has surely touched, if one is stated."""
    fraction = source.certain_fraction if isinstance(source, HeightMap) else None
    return [] if fraction is None else [["Certain below the tip", f"{100.0 * fraction:.3g} % of the points"]]


def _count_non_measured(scene: Scene, shown: ShownSurface) -> str:
    missing = shown.surface.non_measured_on(scene.grid)
    if missing is not None:
        return f"{int(missing.sum())} of {missing.size}"
    if shown.filled and isinstance(shown.source, HeightMap):
        return f"{shown.filled} of {shown.source.grid.cells}, filled"
    return "none"


def _warn_of_tilt(scene: Scene, source: HeightMap) -> list[str]:
    """Return the warning of a solution, in words of the page; below a ball a tilt only moves the contact."""
    if scene.surface is not scene.body.surface:
        return []
    try:
        separated = source.separate("plane")
    except InputError:
        return []
    measured = ... if source.non_measured is None else ~source.non_measured
    tilt, all_of_it = (float(np.var(values[measured])) for values in (separated.form.values, source.values))
    if not tilt > _ADMISSIBLE_TILT * all_of_it:
        return []
    return [
        f"{100.0 * tilt / all_of_it:.0f} % of the variance of the heights is a tilt: unless it is meant, choose 'plane "
        "(tilt)' under 'Form that is removed'"
    ]
