"""Materials of plug-ins: each registered one whose needed fields the page can ask for."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping
from typing import Any

import attrs
from roughcontact import materials
from roughcontact.errors import RoughContactError
from roughcontact.faces import PartField, find_parts, list_fields, summarize
from roughcontact.typing import si

from roughcontact_app.responses import FormField, make_fields
from roughcontact_app.words import explain

# The page has fields of its own for those that ship.
_SHIPPED = ("elastic", "elastic-perfectly-plastic", "rigid", "viscoelastic")
# Settings of the page for fields that many materials have, by name and unit.
_SHARED = {"young": "Pa", "poisson": ""}
# The choice of no part.
NONE = "none"


@attrs.frozen
class PartForm:
    """A part with fields on the page.

    Attributes
    ----------
    name
        Its registered name.
    label, summary
        What it is called, and what it is.
    shared
        Those of its fields that the page has already.
    fields
        The others that the page asks for.
    """

    name: str
    label: str
    summary: str
    shared: tuple[str, ...]
    fields: tuple[MaterialField, ...]


@attrs.frozen
class MaterialField:
    """A field of a material, or of a part of one, on the page.

    Attributes
    ----------
    field
        Its setting and its label.
    is_needed
        Whether it must be given; others are omitted where they are empty, or ``"none"``.
    is_list
        Whether it is a list of numbers.
    parts
        The parts of which one is chosen; empty of a number.
    """

    field: FormField
    is_needed: bool
    is_list: bool = False
    parts: tuple[PartForm, ...] = ()

    @property
    def choices(self) -> tuple[str, ...]:
        """The allowed texts of a choice of parts."""
        return (*(() if self.is_needed else (NONE,)), *(part.name for part in self.parts))


def _list_forms() -> dict[str, PartForm]:
    found = {}
    for name in materials:
        # A broken plug-in must not keep the others from being chosen.
        with contextlib.suppress(RoughContactError):
            setting = f"material_{_in_setting(name)}"
            form = None if name in _SHIPPED else _describe(name, materials[name], setting, _SHARED, has_parts=True)
            if form is not None:
                found[name] = form
    return found


def _describe(name: str, cls: type, setting: str, page: Mapping[str, str], *, has_parts: bool) -> PartForm | None:
    """Return the form of a part; None if the page cannot ask for a field that it needs.

    Parameters
    ----------
    name, cls
        Its registered name, and its class.
    setting
        The beginning of its settings.
    page
        Fields that the page has already, by name and unit.
    has_parts
        Whether its fields may be parts.
    """
    # A class that is not of attrs does not say what its fields are.
    if not attrs.has(cls):
        return None
    known = list_fields(cls).values()
    shared = tuple(one.name for one in known if one.unit is not None and page.get(one.name) == one.unit)
    fields = []
    for one in known:
        asked = None if one.name in shared else _describe_field(one, setting, has_parts=has_parts)
        if asked is not None:
            fields.append(asked)
        elif one.is_needed and one.name not in shared:
            return None
    label = name.replace("-", " ") if has_parts else name.replace("-", " ").capitalize()
    return PartForm(name, label, explain("material", name, summarize(cls)), shared, tuple(fields))


def _describe_field(one: PartField, setting: str, *, has_parts: bool) -> MaterialField | None:
    """Return how the page asks for a field; None if it cannot."""
    (field,) = make_fields(setting, [one])
    if one.unit is not None and (one.is_list or _is_number(one.kind)):
        default = "" if one.is_needed else f" (empty: {_write_default(one)})"
        return MaterialField(attrs.evolve(field, label=f"{field.label}{default}"), one.is_needed, one.is_list)
    known = find_parts(one.kind) if has_parts else {}
    forms = (
        _describe(name, cls, f"{field.setting}_{_in_setting(name)}", {}, has_parts=False) for name, cls in known.items()
    )
    parts = tuple(form for form in forms if form is not None)
    return MaterialField(field, one.is_needed, parts=parts) if parts else None


def _is_number(kind: Any) -> bool:
    return kind in (float, float | None)


def _write_default(one: PartField) -> str:
    """Return the default of a number in words."""
    if isinstance(one.default, (int, float)):
        return si(float(one.default), one.unit) if one.unit else f"{one.default:g}"
    return NONE


def _in_setting(name: str) -> str:
    """Return a registered name as a part of the name of a setting."""
    return re.sub(r"\W", "_", name)


MATERIAL_FORMS = _list_forms()


def name_material(name: str) -> str:
    """Return the registered name of a material in words."""
    return MATERIAL_FORMS[name].label if name in MATERIAL_FORMS else name


def _list_fields(forms: Mapping[str, PartForm]) -> list[MaterialField]:
    """Return the fields of materials, and those of the parts that they may hold."""
    own = [field for form in forms.values() for field in form.fields]
    return own + [inner for field in own for part in field.parts for inner in part.fields]


def list_material_defaults(forms: Mapping[str, PartForm]) -> dict[str, str]:
    """Return the settings of materials with their first texts."""
    found = {}
    for one in _list_fields(forms):
        found[one.field.setting] = one.choices[0] if one.parts else ""
        if one.field.kind:
            found[f"{one.field.setting}_unit"] = one.field.unit
    return found


def list_material_choices(forms: Mapping[str, PartForm]) -> dict[str, tuple[str, ...]]:
    """Return the allowed texts of those settings that have a choice."""
    return {one.field.setting: one.choices for one in _list_fields(forms) if one.parts}
