"""Surfaces, materials and scenes in words."""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._base.units import counted, si
from roughcontact._faces.html.elements import element, escape
from roughcontact._faces.html.rerun import describe_part
from roughcontact._parts.load import Load
from roughcontact._parts.materials import Material, Rigid
from roughcontact._parts.surfaces import FlatSurface, HeightMap, Surface, SurfaceSum
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import ContactSolution

# Where the name of a file stands in the history of a map.
_FILE = re.compile(r"read from (.+?)(?:, \d+ non-measured.*|: \d+ x .*|)", re.DOTALL)
_WORD = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_LAWS = {"young": "Young's modulus", "poisson": "Poisson's ratio"}


def describe_scene(solution: ContactSolution, problem: ContactProblem | None, loads: Sequence[Load]) -> str:
    """Return what was solved in a line of text: bodies, grid, boundary, loads."""
    bodies = [] if problem is None else [problem.body, problem.counterbody]
    named = [str(load) for load in loads]
    if len(named) > 1:
        named = [f"{counted(len(named), 'load')}, {named[0]} to {named[-1].removeprefix(f'{loads[0].kind} ')}"]
    texts = [" on ".join(map(_name_body, bodies)), str(solution.grid), f"boundary {solution.boundary}", *named]
    return ", ".join(filter(None, texts))


def describe_material(material: Material) -> str:
    """Return a material as HTML: the quantities of those whose fields say their units, others as in a script."""
    kind: type = type(material)
    fields = attrs.fields(kind) if attrs.has(kind) else ()
    if not all("unit" in field.metadata for field in fields):
        return element("code", escape(describe_part(material)))
    texts = [_describe_quantity(field, getattr(material, field.name)) for field in fields]
    return escape(": ".join(filter(None, (_in_words(material), ", ".join(texts)))))


def _describe_quantity(field: attrs.Attribute[object], value: Array) -> str:
    low = float(np.min(value))
    high = float(np.max(value))
    unit = field.metadata["unit"]
    texts = dict.fromkeys(si(one, unit) if unit else f"{one:.6g}" for one in (low, high))
    return f"{_LAWS.get(field.name, field.name.replace('_', ' '))} {' to '.join(texts)}"


def _name_body(body: Body) -> str:
    if isinstance(body.surface, FlatSurface) and isinstance(body.material, Rigid):
        return "a rigid flat"
    return _name_surface(body.surface)


def _name_surface(surface: Surface) -> str:
    """Return the name of the file that a surface was read from, or its kind."""
    if isinstance(surface, SurfaceSum):
        return " + ".join(map(_name_surface, surface.parts))
    read = _FILE.fullmatch(surface.history[0]) if isinstance(surface, HeightMap) and surface.history else None
    return read[1] if read else _in_words(surface)


def _in_words(part: object) -> str:
    return _WORD.sub(" ", type(part).__name__).lower()
