"""The material of a plug-in that is chosen: its fields from the settings, each wrong one by its setting."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Collection, Iterable
from typing import Any

import attrs
from roughcontact import Elastic, ElasticPerfectlyPlastic, Material, materials
from roughcontact.errors import InputError, RoughContactError
from roughcontact.faces import TYPICAL, build_part, find_parts, list_fields

from roughcontact_app.materials import MATERIAL_FORMS, NONE, MaterialField
from roughcontact_app.settings import (
    Settings,
    list_values,
    plain,
    plain_or_text,
    quantity,
    reading,
    write_quantity,
)
from roughcontact_app.words import end_sentence


def read_material(settings: Settings, prefix: str, whose: str) -> dict[str, Any]:
    """Return the table of the material of a body, or raise `InputError`.

    Parameters
    ----------
    settings
        The settings.
    prefix
        The beginning of those of the body.
    whose
        What sentences call the body.
    """
    form = MATERIAL_FORMS[settings[f"{prefix}material"]]
    table: dict[str, Any] = {"type": form.name}
    if "young" in form.shared:
        table["young"] = quantity(settings, f"{prefix}young", f"Young's modulus of {whose}", "modulus")
    if "poisson" in form.shared:
        table["poisson"] = plain(settings, f"{prefix}poisson", f"Poisson's ratio of {whose}")
    cls = materials[form.name]
    for name, value in table.items():
        if name in form.shared:
            with reading(f"{prefix}{name}"):
                _judge(cls, name, value)
    asked = form.fields
    table |= _read_fields(settings, prefix, cls, asked, f" of {whose}")
    # Fields that contradict each other: said at the last part, which fits the others or not, or at the material.
    inner = [
        f"{prefix}{part.fields[0].field.setting}"
        for one in asked
        for part in one.parts
        if part.fields and part.name == settings[f"{prefix}{one.field.setting}"]
    ]
    with reading(inner[-1] if inner else f"{prefix}material"):
        try:
            build_part(materials, form.name, table, f"The material of {whose}")
        except InputError as error:
            raise InputError(end_sentence(error.marked)) from error
    return table


def _read_fields(settings: Settings, prefix: str, cls: type, asked: Iterable[MaterialField], of: str) -> dict[str, Any]:
    """Return the fields of a part that are given; `of` ends what a sentence calls one."""
    found: dict[str, Any] = {}
    for one in asked:
        name = one.field.name
        setting = f"{prefix}{one.field.setting}"
        words = name.replace("_", " ")
        if one.parts:
            chosen = {part.name: part for part in one.parts}.get(settings[setting])
            if chosen is not None:
                kind = find_parts(list_fields(cls)[name].kind)[chosen.name]
                inner = _read_fields(settings, prefix, kind, chosen.fields, f" of the {words}{of}")
                with reading(f"{prefix}{chosen.fields[0].field.setting}" if chosen.fields else setting):
                    kind(**inner)
                found[name] = {"type": chosen.name, **inner}
        elif one.is_needed or settings[setting]:
            found[name] = _read_number(settings, setting, cls, one, f"{words}{of}")
    return found


def _read_number(settings: Settings, setting: str, cls: type, one: MaterialField, words: str) -> Any:
    """Return a number, or a list of them, that its class takes."""
    field = one.field
    value: Any
    if one.is_list:
        value = list_values(settings, setting, f"values of the {words}", field.kind, signed=True)
    elif field.kind:
        value = quantity(settings, setting, f"The {words}", field.kind, zero=True, signed=True)
    else:
        with reading(setting):
            value = plain_or_text(settings[setting], f"The {words}", has_unit=field.has_unit)
    with reading(setting):
        try:
            _judge(cls, field.name, value)
        except InputError:
            if field.kind and not one.is_list:
                # It has the number and the unit of the page.
                quantity(settings, setting, f"The {words}", field.kind, zero=_accepts(cls, field.name, 0.0))
            raise
    return value


def _judge(cls: type, name: str, value: Any) -> None:
    """Raise the `InputError` of a field for a wrong value, if its class judges it alone."""
    (field,) = (one for one in attrs.fields(cls) if one.alias == name)
    if callable(field.converter) and not isinstance(field.converter, attrs.Converter):
        field.converter(value)


def _accepts(cls: type, name: str, value: float) -> bool:
    try:
        _judge(cls, name, value)
    except InputError:
        return False
    return True


def list_typical() -> dict[str, dict[str, str]]:
    """Return the settings of typical materials by name, as texts for the form of the body."""
    found = {}
    for name in TYPICAL:
        # A broken plug-in must not keep the others from being chosen.
        with contextlib.suppress(RoughContactError):
            texts = _write_material(TYPICAL[name])
            if texts is not None:
                found[name] = texts
    return found


def _write_material(one: Material) -> dict[str, str] | None:
    """Return the settings of a material; None if the page cannot ask for it."""
    if isinstance(one, (Elastic, ElasticPerfectlyPlastic)):
        limit = one.pressure_limit
        hardness = write_quantity(limit, "GPa") if isinstance(limit, float) and math.isfinite(limit) else ""
        found = {"material": "elastic", "hardness": hardness, "hardness_unit": "GPa"}
        return found | _write_shared(one, ("young", "poisson"))
    form = MATERIAL_FORMS.get(materials.name_of(type(one)) or "")
    if form is None:
        return None
    return {"material": form.name} | _write_shared(one, form.shared) | _write_fields(one, form.fields)


def _write_shared(one: Any, names: Collection[str]) -> dict[str, str]:
    young = {"young": write_quantity(one.young, "GPa"), "young_unit": "GPa"} if "young" in names else {}
    return young | ({"poisson": write_quantity(one.poisson)} if "poisson" in names else {})


def _write_fields(one: Any, asked: Iterable[MaterialField]) -> dict[str, str]:
    """Return the settings of the fields of a part that differ from their defaults."""
    found = {}
    known = list_fields(type(one))
    for field in asked:
        name, setting = field.field.name, field.field.setting
        value = getattr(one, name)
        if field.parts:
            classes = find_parts(known[name].kind)
            part = next((part for part in field.parts if type(value) is classes[part.name]), None)
            found[setting] = NONE if part is None else part.name
            found |= {} if part is None else _write_fields(value, part.fields)
            continue
        unit = field.field.unit
        values = [] if value is None else value if field.is_list else [value]
        is_default = not field.is_needed and not field.is_list and value == known[name].default
        found[setting] = "" if is_default else " ".join(write_quantity(float(number), unit) for number in values)
        found |= {f"{setting}_unit": unit} if field.field.kind else {}
    return found
