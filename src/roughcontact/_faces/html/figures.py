"""The panels of a solution or a sweep as pictures inside a page."""

from __future__ import annotations

import base64
import importlib.util
import inspect
import io
from collections.abc import Iterator
from typing import Any

import attrs

from roughcontact._faces.panels.figures import make_figure
from roughcontact._solve.problem import Sweep
from roughcontact._solve.solution import ContactSolution
from roughcontact.plotting import panels

# Panels that ship, in the order of the page; those of plug-ins come last.
_FIRST = {
    "solution": ("heights", "pressure", "gap", "patches", "profile", "pressure-histogram", "patch-sizes"),
    "sweep": ("area-load", "load-approach", "stiffness-load"),
}
# Dots to an inch: sharp on paper where three pictures stand side by side.
_DPI = 130


@attrs.frozen
class Picture:
    """One panel, drawn.

    Attributes
    ----------
    name
        The name that the panel is registered under.
    caption
        What it shows, in a sentence.
    address
        The picture as a data: address; empty if it cannot be drawn.
    refusal
        Why it cannot be drawn; empty if it is.
    """

    name: str
    caption: str
    address: str = ""
    refusal: str = ""


def can_draw() -> bool:
    """Return whether the package that draws is installed; it is not imported."""
    return importlib.util.find_spec("matplotlib") is not None


def draw_panels(kind: str, subject: ContactSolution | Sweep) -> Iterator[Picture]:
    """Yield each registered panel of a kind of subject; what refuses, or fails, says why."""
    names = (name for name in panels if _draws(name, kind))
    first = _FIRST[kind]
    for name in sorted(names, key=lambda name: (first.index(name) if name in first else len(first), name)):
        caption = (inspect.getdoc(panels[name]) or name).partition("\n\n")[0].replace("\n", " ")
        try:
            yield Picture(name, caption, draw_panel(kind, subject, name))
        # Panels are plug-ins: a report is not lost because of one picture.
        except Exception as error:
            yield Picture(name, caption, refusal=" ".join(str(error).split()) or type(error).__name__)


def draw_panel(kind: str, subject: ContactSolution | Sweep, name: str) -> str:
    """Return a panel as a PNG file in a data: address, dark on light as on paper."""
    content = io.BytesIO()
    figure: Any = make_figure(kind, subject, name)
    figure.savefig(content, format="png", dpi=_DPI)
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"


def _draws(name: str, kind: str) -> bool:
    try:
        return panels[name].subject == kind
    # A plug-in that cannot be imported.
    except Exception:
        return False
