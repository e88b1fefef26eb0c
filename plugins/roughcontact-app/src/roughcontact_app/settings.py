"""The settings of the page: flat names and texts, as its form and its link hold them, and the checks of both."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from typing import Any, TypeAlias

from roughcontact import Boundary, Law, Response, laws, responses
from roughcontact.errors import InputError, short
from roughcontact.faces import build_part, space_separations
from roughcontact.typing import quantity as reader_of
from roughcontact.typing import si

from roughcontact_app.laws import LAW_BOXES
from roughcontact_app.materials import MATERIAL_FORMS, list_material_choices, list_material_defaults
from roughcontact_app.responses import TICK_BOXES, TickBox, list_choices, list_defaults
from roughcontact_app.words import end_sentence

Settings: TypeAlias = Mapping[str, str]

# Powers of ten of the units that the page offers, by the kind of quantity; SI first.
UNITS: dict[str, dict[str, int]] = {
    "length": {"m": 0, "mm": -3, "um": -6, "nm": -9},
    "modulus": {"Pa": 0, "MPa": 6, "GPa": 9},
    "pressure": {"Pa": 0, "kPa": 3, "MPa": 6, "GPa": 9},
    "force": {"N": 0, "mN": -3, "uN": -6, "nN": -9, "kN": 3},
    "approach": {"m": 0, "mm": -3, "um": -6, "nm": -9},
    "work": {"J/m2": 0, "mJ/m2": -3},
    "viscosity": {"Pa s": 0, "mPa s": -3},
    "time": {"s": 0, "ms": -3, "us": -6},
}
# The smallest and largest of each kind, in its SI unit: from below an atom to beyond all bodies and what they carry.
_RANGES = {
    "length": (1e-15, 1e3),
    "modulus": (1e-9, 1e18),
    "pressure": (1e-9, 1e18),
    "force": (1e-18, 1e15),
    "approach": (1e-15, 1e3),
    "work": (1e-9, 1e9),
    "viscosity": (1e-9, 1e12),
    "time": (1e-15, 1e15),
}
# Numbers between which units have a prefix that people know.
_SHOWN_SIZES = (1e-15, 1e15)
# Beginnings of the settings of the body and of the counterbody, and the most layers of each.
PREFIXES = ("", "counterbody_")
MOST_LAYERS = 3


def _split_units(fields: Mapping[str, str], prefix: str = "") -> dict[str, str]:
    """Return the settings of fields with their first texts: the number, and the unit behind it, if it has one."""
    found = {}
    for name, text in fields.items():
        number, blank, unit = text.partition(" ")
        found[f"{prefix}{name}"] = number
        if blank:
            found[f"{prefix}{name}_unit"] = unit
    return found


_OF_LAYER = {"young": "400 GPa", "poisson": "0.25", "thickness": "2 um", "yield_stress": " GPa"}
_OF_MATERIAL = {
    "material": "elastic",
    "young": "210 GPa",
    "poisson": "0.3",
    "hardness": " GPa",
    "moduli": " MPa",
    "relaxation": " s",
}
_OF_FILE = {
    **dict.fromkeys(("file", "file_name", "size_x", "size_y", "height_unit"), ""),
    "size_unit": "um",
    "rows": "auto",
    "non_measured": "refuse",
    **_split_units({"tip_radius": " um"}),
    "form": "none",
}


def list_layer_defaults(prefix: str) -> dict[str, str]:
    """Return the settings of the layers of a body with their first texts."""
    found = {f"{prefix}layers": "0"}
    for number in range(1, MOST_LAYERS + 1):
        found |= _split_units(_OF_LAYER, f"{prefix}layer{number}_")
    return found


# What a link or a request that does not say otherwise holds; each setting has its text here and no other is taken.
DEFAULTS: dict[str, str] = {
    "surface": "example",
    "example": "ground_ring",
    "counterbody_surface": "flat",
    "offset_x": "0",
    "offset_y": "0",
    "offset_unit": "um",
    "rotation": "0",
    "mirrored": "no",
    "interpolation": "bilinear",
    "hurst": "0.8",
    "shortest": "4",
    "longest": "50",
    "wave_unit": "um",
    "seed": "1",
    **_split_units({"rms_height": "0.1 um", "amplitude": "0.5 um", "wavelength": "25 um", "radius": "1 mm"}),
    **_split_units({"cells": "256", "side": "100 um", "added": "ball", "ball": " mm"}),
    "counterbody": "rigid",
    **_split_units({"adhesion": "none", "work": "50 mJ/m2", "range": "10 nm"}),
    "load": "pressure",
    "loads": "100",
    "load_unit": "MPa",
    "path": "no",
    **_split_units({"time": " s", "sliding": " m"}),
    "path_accuracy": "0.001",
    "cycle_from": "-0.1",
    "cycle_to": "0.5",
    "cycle_unit": "um",
    "states": "41",
    **_split_units({"normal_force": "1 N", "tangential_force": "0.2 N", "friction": "0.3"}),
    **{"separations": "0.5..4", "mirror_borders": "yes", "sampling": "yes", "film_units": "SI"},
    "boundary": "free",
    **{name: text for prefix in PREFIXES for name, text in _split_units(_OF_FILE | _OF_MATERIAL, prefix).items()},
    **{name: text for prefix in PREFIXES for name, text in list_layer_defaults(prefix).items()},
    **{f"{prefix}{name}": text for prefix in PREFIXES for name, text in list_material_defaults(MATERIAL_FORMS).items()},
    **list_defaults([*TICK_BOXES.values(), *LAW_BOXES.values()]),
    "scheme": "light",
}
# With what the page opens: a ball on a plane, both of bearing steel, at 0.8 GPa. Hertz's contact radius is 55 um, a
# quarter of the side.
FIRST: dict[str, str] = {
    "surface": "sphere",
    "radius": "5",
    "radius_unit": "mm",
    "side": "220",
    "side_unit": "um",
    "cells": "256",
    "boundary": "free",
    "counterbody": "deformable",
    "hardness": "7",
    "counterbody_hardness": "7",
    "load": "force",
    "loads": "5",
    "load_unit": "N",
}
# Kinds of loads that have values.
_LOADS = ("force", "pressure", "approach")
_CHOICES_OF_BODY = {
    "rows": ("auto", "x", "y"),
    "non_measured": ("refuse", "fill", "keep"),
    "form": ("none", "plane", "quadratic", "sphere"),
    "layers": tuple(map(str, range(MOST_LAYERS + 1))),
    "material": ("elastic", "viscoelastic", *MATERIAL_FORMS),
    **list_material_choices(MATERIAL_FORMS),
}
_CHOICES = {
    "surface": ("example", "file", "self-affine", "wavy", "sphere"),
    "counterbody_surface": ("flat", "file"),
    "mirrored": ("no", "yes"),
    "interpolation": ("bilinear", "cubic"),
    "counterbody": ("rigid", "deformable"),
    "adhesion": ("none", "exponential", "van-der-waals", "short-range"),
    "load": (*_LOADS, "cycle", "fretting", "film"),
    "mirror_borders": ("no", "yes"),
    "sampling": ("no", "yes"),
    "film_units": ("SI", "mm"),
    "path": ("no", "yes"),
    "added": ("ball", "cylinder-y", "cylinder-x"),
    "boundary": tuple(map(str, Boundary)),
    **{f"{prefix}{name}": allowed for prefix in PREFIXES for name, allowed in _CHOICES_OF_BODY.items()},
    **list_choices([*TICK_BOXES.values(), *LAW_BOXES.values()]),
    "scheme": ("light", "dark"),
}
# Characters of one setting; and the digits of a number and of its exponent, more than float64 can tell apart.
_LONGEST = 300
_NUMBER = re.compile(r"[-+]?(?:[0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})(?:[eE][-+]?[0-9]{1,4})?")
# The e of an exponent is not a unit.
_WITH_UNIT = re.compile(rf"(?!{_NUMBER.pattern}$){_NUMBER.pattern}\s*[^\W\d_].*")
_BETWEEN_NUMBERS = re.compile(r"[;\s]+(?=[-+.\d])")
_WHOLE = re.compile(r"[0-9]{1,9}")
# Loads of one run, and states of a path: a curve has no more points that can be told apart.
_MOST_LOADS = 40
# Beyond those of any surfaces.
_MOST_FRICTION = 10.0
# Numbers of a field that may be two.
_PAIR = 2
# States on each branch of a cycle.
_MOST_STATES = 201


class WrongSetting(InputError):
    """A setting is wrong: its name, beside the sentence."""

    def __init__(self, sentence: str, setting: str):
        super().__init__(sentence)
        self.setting = setting


@contextmanager
def reading(setting: str) -> Iterator[None]:
    """Say of an `InputError` which setting is wrong, unless it is known."""
    try:
        yield
    except WrongSetting:
        raise
    except InputError as error:
        raise WrongSetting(error.marked, setting) from error


def read_settings(data: object) -> Settings:
    """Return the settings that a page has sent, completed by those it has not, or raise `InputError`."""
    if not isinstance(data, dict):
        raise InputError("The settings must be an object of names and texts.")
    found = dict(DEFAULTS)
    for name, value in data.items():
        if name not in DEFAULTS:
            raise InputError.unknown("setting", name, DEFAULTS)
        if not isinstance(value, str) or len(value) > _LONGEST:
            raise InputError.about(f"The setting {name!r}", value, f"a text of at most {_LONGEST} characters")
        found[name] = value.strip()
    for name, allowed in _CHOICES.items():
        if found[name] not in allowed:
            raise InputError.about(f"The setting {name!r}", found[name], f"one of {', '.join(allowed)}")
    return found


def plain(settings: Settings, name: str, label: str) -> float:
    """Return a setting without a unit as a number."""
    with reading(name):
        return float(_decimal(settings[name], label))


def plain_or_text(text: str, label: str, *, has_unit: bool) -> float | str:
    """Return a number, or a text with a unit, which is read as on the command line."""
    return text if has_unit and _WITH_UNIT.fullmatch(text) else float(_decimal(text, label))


def quantity(
    settings: Settings,
    name: str,
    label: str,
    kind: str,
    unit: str | None = None,
    *,
    zero: bool = False,
    signed: bool = False,
) -> float:
    """Return a setting in SI units; its unit is another setting, ``NAME_unit`` by default."""
    with reading(name):
        return _quantity(
            settings[name], label, kind, _unit(settings, unit or f"{name}_unit", kind), zero, signed=signed
        )


def write_quantity(value: float, unit: str = "") -> str:
    """Return a number in SI units as the text of a setting, in one of the units that the page offers."""
    exponent = next((known[unit] for known in UNITS.values() if unit in known), 0)
    return f"{float(Decimal(repr(float(value))).scaleb(-exponent)):.12g}"


def whole(settings: Settings, name: str, label: str) -> int:
    """Return a setting that is a whole number."""
    if not _WHOLE.fullmatch(settings[name]):
        raise WrongSetting(str(InputError.about(label, settings[name], "a whole number such as 256")), name)
    return int(settings[name])


def load_values(settings: Settings) -> list[float]:
    """Return the loads in SI units."""
    with reading("loads"):
        return _load_values(settings)


def _load_values(settings: Settings) -> list[float]:
    kind = settings["load"]
    unit = _unit(settings, "load_unit", kind)
    texts = re.split(r"[;\s]+", settings["loads"].strip("; \t"))
    if len(texts) > _MOST_LOADS:
        raise InputError.about("The number of loads", len(texts), f"at most {_MOST_LOADS}")
    label = "The load" if len(texts) == 1 else "Each load"
    signed = settings["adhesion"] != "none"
    # A path unloads the surfaces, but begins with a load.
    first, *others = texts
    values = [_quantity(first, "The first load" if is_path(settings) else label, kind, unit, False, signed=signed)]
    values += [_quantity(text, label, kind, unit, is_path(settings), signed=signed) for text in others]
    if len(set(values)) < len(values) and not is_path(settings):
        raise InputError("A load is given twice: give each load once.")
    return values


def is_path(settings: Settings) -> bool:
    """Return whether the loads follow each other on a path on which the surfaces change."""
    return settings["path"] == "yes" and settings["load"] in _LOADS


def path_values(settings: Settings) -> tuple[dict[str, Any], dict[str, Any], float]:
    """Return the loads of a path by their kind, one or several, its times and sliding distances, and its accuracy."""
    loads = load_values(settings)
    passed = {
        name: list_values(settings, name, several, kind) if settings[name] else None
        for name, several, kind in (("time", "times", "time"), ("sliding", "sliding distances", "length"))
    }
    accuracy = plain(settings, "path_accuracy", "The accuracy of a path")
    return {settings["load"]: loads if len(loads) > 1 else loads[0]}, passed, accuracy


def list_values(settings: Settings, name: str, several: str, kind: str = "", *, signed: bool = False) -> list[float]:
    """Return the numbers of a setting in SI units; one that states its own unit is read as on the command line.

    Without a kind they are numbers without a unit.
    """
    with reading(name):
        texts = _BETWEEN_NUMBERS.split(settings[name].strip("; \t"))
        if len(texts) > _MOST_LOADS:
            raise InputError.about(f"The number of {several}", len(texts), f"at most {_MOST_LOADS}")
        label = f"Each of the {several}"
        if not kind:
            return [float(_decimal(text, label)) for text in texts]
        unit = _unit(settings, f"{name}_unit", kind)
        return [_read_value(text, label, kind, unit, signed=signed) for text in texts]


def _read_value(text: str, label: str, kind: str, unit: str, *, signed: bool) -> float:
    if not _WITH_UNIT.fullmatch(text):
        return _quantity(text, label, kind, unit, True, signed=signed)
    try:
        return reader_of(next(iter(UNITS[kind])))(text)
    except argparse.ArgumentTypeError as error:
        raise InputError(f"{label}: {error}.") from error


def cycle_values(settings: Settings) -> list[float]:
    """Return the approaches of a branch of a cycle, m."""
    if settings["adhesion"] == "none":
        sentence = "A cycle is for surfaces that attract each other: choose an adhesion, or give another load."
        raise WrongSetting(sentence, "adhesion")
    low, high = (
        quantity(settings, name, label, "approach", "cycle_unit", zero=True, signed=True)
        for name, label in (("cycle_from", "The first approach"), ("cycle_to", "The last approach"))
    )
    if not low < high:
        sentence = "The first approach of a cycle must be below the last one, from which the surfaces return."
        raise WrongSetting(sentence, "cycle_from")
    count = whole(settings, "states", "The number of states")
    if not 2 <= count <= _MOST_STATES:
        with reading("states"):
            raise InputError.about("The number of states", count, f"from 2 to {_MOST_STATES}")
    return [low + (high - low) * step / (count - 1) for step in range(count)]


def fretting_values(settings: Settings) -> tuple[float, float, float]:
    """Return the normal force and the largest tangential force of a fretting cycle, N, and the friction."""
    if settings["adhesion"] != "none":
        sentence = "Friction between surfaces that attract each other is not known: choose no adhesion."
        raise WrongSetting(sentence, "adhesion")
    for prefix in PREFIXES:
        if settings[f"{prefix}layers"] != "0":
            sentence = "Friction on layers is not known: choose no layers, or another load."
            raise WrongSetting(sentence, f"{prefix}layers")
    if settings["boundary"] == "wrapped":
        sentence = "A wrapped boundary has no response to forces along the surface: choose another boundary."
        raise WrongSetting(sentence, "boundary")
    normal = quantity(settings, "normal_force", "The normal force", "force")
    tangential = quantity(settings, "tangential_force", "The tangential force", "force")
    friction = plain(settings, "friction", "The coefficient of friction")
    if not 0.0 < friction <= _MOST_FRICTION:
        with reading("friction"):
            raise InputError.about("The coefficient of friction", friction, f"above 0, and at most {_MOST_FRICTION:g}")
    if tangential >= friction * normal:
        raise WrongSetting(
            "The tangential force of a fretting cycle must be below the coefficient of friction times the normal "
            "force, from which on the bodies slide.",
            "tangential_force",
        )
    return normal, tangential, friction


def separation_values(settings: Settings) -> list[float]:
    """Return the separations of a film over Sq; a range such as 0.5..4 has steps of its own."""
    if settings["adhesion"] != "none":
        sentence = "A film law of surfaces that attract each other is not known: choose no adhesion."
        raise WrongSetting(sentence, "adhesion")
    if settings["boundary"] != "periodic":
        sentence = "A film law needs a domain that repeats, since a cut-out leaks at its borders: choose 'periodic'."
        raise WrongSetting(sentence, "boundary")
    ticked = next((box for box in TICK_BOXES.values() if settings[box.setting] == "yes"), None)
    if ticked is not None:
        sentence = f"{ticked.label.capitalize()} is asked of a contact under a load: untick it, or give another load."
        raise WrongSetting(sentence, ticked.setting)
    label = "Each separation"
    with reading("separations"):
        found = []
        for text in re.split(r"[;\s]+", re.sub(r"\s*\.\.\s*", "..", settings["separations"].strip("; \t"))):
            first, dots, last = text.partition("..")
            low = float(_decimal(first, label))
            found += space_separations(low, float(_decimal(last, label))) if dots else [low]
        if len(found) > _MOST_LOADS:
            raise InputError.about("The number of separations", len(found), f"at most {_MOST_LOADS}")
        if len(found) < _PAIR:
            raise InputError("A film law has two or more separations: give several, or a range such as 0.5..4.")
    return found


def asked_responses(settings: Settings) -> dict[str, Response[Any]]:
    """Return the responses that are ticked, by name."""
    return _build_ticked(settings, responses, TICK_BOXES)


def chosen_laws(settings: Settings) -> list[Law]:
    """Return the laws that are ticked, by which the surfaces change on a path."""
    return [*_build_ticked(settings, laws, LAW_BOXES).values()] if is_path(settings) else []


def _build_ticked(settings: Settings, registry: Any, boxes: Mapping[str, TickBox]) -> dict[str, Any]:
    ticked = {name: box for name, box in boxes.items() if settings[box.setting] == "yes"}
    found = {}
    for name, box in ticked.items():
        fields = _fields_of(settings, box)
        try:
            found[name] = build_part(registry, name, fields, box.label.capitalize())
        except InputError as error:
            wrong = box.fields[0].setting if box.fields else box.setting
            raise WrongSetting(end_sentence(error.marked), wrong) from error
    return found


def _fields_of(settings: Settings, box: TickBox) -> dict[str, Any]:
    found: dict[str, Any] = {"axis": int(settings[box.axis] == "y")} if box.axis else {}
    for field in box.fields:
        label = f"{field.label.partition(',')[0]} ({box.label})"
        if field.kind:
            found[field.name] = quantity(settings, field.setting, label, field.kind)
            continue
        # Of a pair one number is for both; a blank before a letter belongs to a unit.
        texts = _BETWEEN_NUMBERS.split(settings[field.setting]) if field.is_pair else [settings[field.setting]]
        with reading(field.setting):
            if len(texts) > _PAIR:
                raise InputError(f"{label} has {len(texts)} numbers: give one, or one for each of both bodies.")
            numbers = [plain_or_text(text, label, has_unit=field.has_unit) for text in texts]
        found[field.name] = numbers if len(numbers) > 1 else numbers[0]
    return found


def _unit(settings: Settings, name: str, kind: str) -> str:
    if settings[name] not in UNITS[kind]:
        raise InputError.about(f"The unit of the {kind}", settings[name], f"one of {', '.join(UNITS[kind])}")
    return settings[name]


def _quantity(text: str, label: str, kind: str, unit: str, zero: bool, *, signed: bool = False) -> float:
    # In decimals, so that 12.5 um is the number 12.5e-6 of a script to the last bit.
    value = float(_decimal(text, label).scaleb(UNITS[kind][unit]))
    given = f"{text} {unit.replace('u', 'µ')}"
    if not signed and (value < 0.0 or (value == 0.0 and not zero)):
        raise InputError(f"{label} must be {'at least' if zero else 'above'} 0, but got {given}.")
    low, high = _RANGES[kind]
    if value and not low <= abs(value) <= high:
        base = next(iter(UNITS[kind]))
        ends = (si(end, base) if _SHOWN_SIZES[0] <= end < _SHOWN_SIZES[1] else f"{end:g} {base}" for end in (low, high))
        raise InputError(f"{label} must be between {' and '.join(ends)}, but got {given}: check its unit.")
    return value


def _decimal(text: str, label: str) -> Decimal:
    if not text:
        raise InputError(f"{label} is missing: fill it in.")
    if not _NUMBER.fullmatch(text):
        decimal = " Write decimals with a point, and several loads with blanks between them." if "," in text else ""
        raise InputError(f"{label} must be a number such as 2.5, but got {short(text)}.{decimal}")
    return Decimal(text)
