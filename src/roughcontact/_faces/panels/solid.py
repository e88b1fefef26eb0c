"""Views in three dimensions, by pyvista."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import flag, number
from roughcontact._base.units import prefixed, si
from roughcontact._faces.panels.figures import title_of
from roughcontact._faces.panels.theme import DARK, LIGHT, Theme
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import SampledSurface
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import MissingPackage

# Peak to valley of the heights as drawn, over the longer side of the domain, where no exaggeration is given.
_DRAWN_HEIGHT_RATIO = 0.12
# Most points along a side that are drawn.
_MAX_POINTS_A_SIDE = 1024
# Position of the camera: to the right, to the front and above, in longer sides of the domain.
_CAMERA_POSITION = (1.05, -1.82, 1.43)
# Pixels of the window, and sizes of its title and numbers.
_WINDOW_PIXELS = (1200, 900)
_TITLE_SIZE = 12
_NUMBER_SIZE = 10


@attrs.frozen(eq=False)
class SurfaceColoring:
    """The colours of a view: a field, shape (nx, ny), NaN where it is not known, its label and the colour map.

    Attributes
    ----------
    field, label, colors
        The field, the label of its colour bar with the unit, and the name of a colour map of matplotlib.
    limits
        Values at the ends of the colours.
    nothing
        Name of the colour of `Theme` where the field is NaN.
    above
        Name of the values above the limits; None: they have the last colour.
    """

    field: Array
    label: str
    colors: str
    limits: tuple[float, float]
    nothing: str = "counterbody"
    above: str | None = None


def make_view(
    grid: Grid, heights: Array, coloring: SurfaceColoring, title: str, exaggeration: object, dark: object
) -> Any:
    """Return a `pyvista.Plotter` with the heights, shape `grid.shape`, m, in perspective."""
    try:
        import pyvista
    except ImportError:
        raise MissingPackage("Views in three dimensions need pyvista: pip install 'roughcontact[vtk]'.") from None
    theme = DARK if flag(dark, "dark=") else LIGHT
    raised = np.where(np.isfinite(heights), heights, np.nanmean(heights))
    raised = raised - raised.mean()
    side = max(grid.size)
    times = _choose(grid, raised) if exaggeration is None else number(exaggeration, "exaggeration=", above=0.0)
    # In longer sides, since lengths in metres are too small for clipping planes.
    steps = tuple(-(-count // _MAX_POINTS_A_SIDE) for count in grid.shape)
    chosen = np.s_[:: steps[0], :: steps[1]]
    across, along = np.broadcast_arrays(grid.x[:: steps[0]] / side, grid.y[:, :: steps[1]] / side)
    mesh = pyvista.StructuredGrid(across, along, times / side * raised[chosen])
    mesh.point_data[coloring.label] = coloring.field[chosen].ravel(order="F")
    view = pyvista.Plotter(window_size=_WINDOW_PIXELS)
    view.set_background(theme.paper)
    _add_heights(view, mesh, coloring, theme)
    sides = " x ".join(si(one, "m", 4) for one in grid.size)
    said = f"{title}\n{sides}; heights drawn {times:g} times as high"
    view.add_text(said, position="upper_left", font_size=_TITLE_SIZE, color=theme.ink)
    view.add_axes(xlabel="x", ylabel="y", zlabel="z", color=theme.ink)
    view.camera_position = [_CAMERA_POSITION, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    return view


def view_surface(sampled: SampledSurface, exaggeration: object, dark: object) -> Any:
    """Return a view of a surface coloured by its heights; see `Surface.plot_3d`."""
    heights = sampled.heights - np.nanmean(sampled.heights)
    factor, unit = prefixed(float(np.nanmax(np.abs(heights))), "m")
    end = factor * float(np.nanmax(np.abs(heights))) or 1.0
    coloring = SurfaceColoring(factor * heights, f"height, {unit}", "cividis", (-end, end), nothing="unknown")
    title = f"Rms height {si(sampled.rms_height, 'm', 3)}"
    return make_view(sampled.grid, heights, coloring, title, exaggeration, dark)


def view_solution(solution: ContactSolution, exaggeration: object, dark: object) -> Any:
    """Return a view of the combined heights coloured by the pressure; see `ContactSolution.plot_3d`."""
    highest = float(solution.pressure.max())
    factor, unit = prefixed(highest, "Pa")
    limit = factor * highest or 1.0
    pressure = np.where(solution.contact, factor * solution.pressure, np.nan)
    above = "saturated" if solution.saturated.any() else None
    # Colours end where the pressure does; saturated cells are above them.
    pressure[solution.saturated] = 2.0 * limit
    coloring = SurfaceColoring(pressure, f"pressure, {unit}", "viridis", (0.0, limit), above=above)
    heights = -solution.initial_gap
    if solution.non_measured is not None:
        heights = np.where(solution.non_measured, np.nan, heights)
    return make_view(solution.grid, heights, coloring, title_of("solution", solution), exaggeration, dark)


def _choose(grid: Grid, raised: Array) -> float:
    """Return the exaggeration of the heights: 1, 2 or 5 times a power of ten."""
    tallest = float(np.ptp(raised))
    if not tallest > 0.0:
        return 1.0
    wanted = _DRAWN_HEIGHT_RATIO * max(grid.size) / tallest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max((one for one in (1.0, 2.0, 5.0) if one * power <= wanted), default=1.0) * power)


def _add_heights(view: Any, mesh: Any, coloring: SurfaceColoring, theme: Theme) -> None:
    bar = {"title": coloring.label, "color": theme.ink, "n_labels": 3, "fmt": "%.3g", "vertical": True}
    bar |= {
        "title_font_size": 2 * _TITLE_SIZE,
        "label_font_size": 2 * _NUMBER_SIZE,
        "position_x": 0.88,
        "position_y": 0.25,
    }
    above = {} if coloring.above is None else {"above_color": theme.limit}
    if coloring.above is not None:
        bar["above_label"] = coloring.above
    view.add_mesh(
        mesh,
        scalars=coloring.label,
        cmap=coloring.colors,
        clim=coloring.limits,
        nan_color=getattr(theme, coloring.nothing),
        scalar_bar_args=bar,
        smooth_shading=True,
        interpolate_before_map=True,
        **above,
    )
