"""Pictures of a solution, a surface or a sweep: the base class, the look, and what panels are drawn with.

Nothing of matplotlib is loaded until something is drawn.
"""

from roughcontact.panel.base import Panel, SampledSurface, panels
from roughcontact.panel.curves import add_key, draw_band, scale_axes
from roughcontact.panel.figures import make_figure
from roughcontact.panel.maps import draw_map, draw_mask, name_colors
from roughcontact.panel.theme import DARK, LIGHT, Theme, style, theme_of

__all__ = [
    "DARK",
    "LIGHT",
    "Panel",
    "SampledSurface",
    "Theme",
    "add_key",
    "draw_band",
    "draw_map",
    "draw_mask",
    "make_figure",
    "name_colors",
    "panels",
    "scale_axes",
    "style",
    "theme_of",
]
