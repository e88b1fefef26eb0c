"""Figures of solutions, surfaces and sweeps: the base class of panels, their look, and the functions that draw them.

Nothing of matplotlib is loaded until something is drawn.
"""

from roughcontact._faces.panels.base import Panel, panels
from roughcontact._faces.panels.curves import add_key, draw_band, scale_axes
from roughcontact._faces.panels.figures import make_figure, plot, save_figure
from roughcontact._faces.panels.maps import draw_map, draw_mask, name_colors
from roughcontact._faces.panels.notebook import show_map
from roughcontact._faces.panels.results import (
    StudyNames,
    draw_column,
    draw_cycle,
    draw_loop,
    draw_report,
    draw_study,
)
from roughcontact._faces.panels.solid import view_solution, view_surface
from roughcontact._faces.panels.theme import DARK, LIGHT, Theme, style, theme_of
from roughcontact._parts.surfaces import SampledSurface

__all__ = [
    "DARK",
    "LIGHT",
    "Panel",
    "SampledSurface",
    "StudyNames",
    "Theme",
    "add_key",
    "draw_band",
    "draw_column",
    "draw_cycle",
    "draw_loop",
    "draw_map",
    "draw_mask",
    "draw_report",
    "draw_study",
    "make_figure",
    "name_colors",
    "panels",
    "plot",
    "save_figure",
    "scale_axes",
    "show_map",
    "style",
    "theme_of",
    "view_solution",
    "view_surface",
]
