"""Laws by which the surfaces change on a path, such as wear: a tick box for each registered one that needs numbers."""

from __future__ import annotations

import contextlib

from roughcontact import laws
from roughcontact.errors import RoughContactError
from roughcontact.faces import list_fields, summarize

from roughcontact_app.responses import TickBox, make_fields
from roughcontact_app.words import explain

# What passes on a path of the page.
_PASSING = ("time", "sliding")
# The materials bring it.
_BROUGHT = ("relaxation",)


def _list_boxes() -> dict[str, TickBox]:
    found = {}
    for name in laws:
        # A broken plug-in must not keep the others from being chosen.
        with contextlib.suppress(RoughContactError):
            cls = laws[name]
            needed = [field for field in list_fields(cls).values() if field.is_needed]
            if name in _BROUGHT or not set(cls.rates) & set(_PASSING) or any(field.unit is None for field in needed):
                continue
            setting = f"law_{name.replace('-', '_')}"
            found[name] = TickBox(
                setting, name.replace("-", " "), explain("law", name, summarize(cls)), make_fields(setting, needed)
            )
    return found


LAW_BOXES = _list_boxes()
