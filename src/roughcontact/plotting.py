"""Figures of solutions, surfaces and sweeps: the base class of panels, their look, and the functions that draw them.

Nothing of matplotlib is loaded until something is drawn.
"""

from roughcontact._faces.panels.base import Panel as Panel
from roughcontact._faces.panels.base import panels as panels
from roughcontact._faces.panels.course import draw_course as draw_course
from roughcontact._faces.panels.curves import add_key as add_key
from roughcontact._faces.panels.curves import draw_band as draw_band
from roughcontact._faces.panels.curves import scale_axes as scale_axes
from roughcontact._faces.panels.figures import make_figure as make_figure
from roughcontact._faces.panels.maps import draw_map as draw_map
from roughcontact._faces.panels.maps import draw_mask as draw_mask
from roughcontact._faces.panels.maps import draw_section as draw_section
from roughcontact._faces.panels.maps import name_colors as name_colors
from roughcontact._faces.panels.theme import DARK as DARK
from roughcontact._faces.panels.theme import LIGHT as LIGHT
from roughcontact._faces.panels.theme import Theme as Theme
from roughcontact._faces.panels.theme import style as style
from roughcontact._faces.panels.theme import theme_of as theme_of
from roughcontact._parts.surfaces import SampledSurface as SampledSurface
