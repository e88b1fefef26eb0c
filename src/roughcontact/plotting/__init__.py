"""Figures of solutions, surfaces and sweeps: the base class of panels, their look, and the functions that draw them.

Nothing of matplotlib is loaded until something is drawn.
"""

from roughcontact._surfaces.sampled import SampledSurface
from roughcontact.plotting.base import Panel, panels
from roughcontact.plotting.curves import add_key, draw_band, scale_axes
from roughcontact.plotting.error_report import draw_report
from roughcontact.plotting.figures import make_figure, plot, save_figure
from roughcontact.plotting.law import draw_column
from roughcontact.plotting.maps import draw_map, draw_mask, name_colors
from roughcontact.plotting.solid import view_solution, view_surface
from roughcontact.plotting.theme import DARK, LIGHT, Theme, style, theme_of

__all__ = [
    "DARK",
    "LIGHT",
    "Panel",
    "SampledSurface",
    "Theme",
    "add_key",
    "draw_band",
    "draw_column",
    "draw_map",
    "draw_mask",
    "draw_report",
    "make_figure",
    "name_colors",
    "panels",
    "plot",
    "save_figure",
    "scale_axes",
    "style",
    "theme_of",
    "view_solution",
    "view_surface",
]
