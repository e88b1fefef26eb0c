"""What the contact does, such as its stiffness: a tick box for each registered response, and what each has answered."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
from roughcontact import ContactSolution, Response, faces, responses
from roughcontact.errors import RoughContactError
from roughcontact.faces import PartField, describe_response

from roughcontact_app.words import end_sentence, explain, in_words_of_page

# Those that are among the numbers of each answer; and one whose film, by default 10 nm, is not asked for.
_OMITTED = ("approach", "mean-gap", "patches", "peak-pressure", "capacitance")
# Kind of quantity and first unit of the page, by the SI unit.
_KINDS = {
    "Pa": ("pressure", "MPa"),
    "N": ("force", "N"),
    "m": ("length", "um"),
    "s": ("time", "s"),
    "Pa s": ("viscosity", "mPa s"),
}
_LABELS = {
    "conductivity": "Conductivity of body and counterbody",
    "friction": "Coefficient of friction",
}


@attrs.frozen
class FormField:
    """A field of a part on the page: its setting, its label, the kind of its quantity, and its first unit.

    ``has_unit``: its text may state a unit.
    """

    name: str
    setting: str
    label: str
    kind: str = ""
    unit: str = ""
    is_pair: bool = False
    has_unit: bool = False


@attrs.frozen
class TickBox:
    """A response on the page: its setting, its label, what it says, its fields, and the setting of its axis, if any."""

    setting: str
    label: str
    summary: str
    fields: tuple[FormField, ...]
    axis: str = ""


def _list_tick_boxes() -> dict[str, TickBox]:
    found = {}
    for name in responses:
        # A broken plug-in must not keep the others from being asked for.
        with contextlib.suppress(RoughContactError):
            form = describe_response(name)
            needed = [field for field in form.fields if field.is_needed]
            if form.is_array or name in _OMITTED or any(field.unit not in ("", *_KINDS) for field in needed):
                continue
            setting = f"ask_{name.replace('-', '_')}"
            fields = make_fields(setting, needed)
            axis = f"{setting}_axis" if any(field.name == "axis" for field in form.fields) else ""
            found[name] = TickBox(
                setting, name.replace("-", " "), explain("response", name, form.summary), fields, axis
            )
    return found


def make_fields(setting: str, needed: Sequence[PartField]) -> tuple[FormField, ...]:
    """Return the fields of a part below its tick box; a unit that the page does not offer may stand in their texts."""
    found = []
    for field in needed:
        units = _KINDS.get(field.unit or "", ("", ""))
        stated = field.plain_unit or ("" if units[0] else field.unit or "")
        label = _LABELS.get(field.name, field.name.replace("_", " ").capitalize())
        label += f", {stated}" if stated else ""
        found.append(FormField(field.name, f"{setting}_{field.name}", label, *units, field.is_pair, bool(stated)))
    return tuple(found)


TICK_BOXES = _list_tick_boxes()


def list_defaults(boxes: Sequence[TickBox]) -> dict[str, str]:
    """Return the settings of tick boxes with their first texts."""
    found: dict[str, str] = {}
    for box in boxes:
        found |= {box.setting: "no"} | {field.setting: "" for field in box.fields}
        found |= {f"{field.setting}_unit": field.unit for field in box.fields if field.kind}
        found |= {box.axis: "x"} if box.axis else {}
    return found


def list_choices(boxes: Sequence[TickBox]) -> dict[str, tuple[str, ...]]:
    """Return the allowed texts of those settings that have a choice."""
    found: dict[str, tuple[str, ...]] = {box.setting: ("no", "yes") for box in boxes}
    return found | {box.axis: ("x", "y") for box in boxes if box.axis}


def ask(
    asked: Mapping[str, Response[Any]], solutions: Sequence[ContactSolution]
) -> tuple[dict[str, list[Any]], list[str]]:
    """Return what each response says of each solution, and in sentences why one has no answer."""
    found = {}
    problems = []
    for name, response in asked.items():
        try:
            found[name] = [solution.response(response) for solution in solutions]
        except RoughContactError as error:
            problems.append(end_sentence(f"{TICK_BOXES[name].label}: {in_words_of_page(error)}"))
    return found, problems


def ask_states(
    asked: Mapping[str, Response[Any]], states: Sequence[ContactSolution]
) -> tuple[dict[str, list[Any]], list[str]]:
    """Return what each response says of each state of a cycle, None where it has no answer, and in sentences why."""
    found, reasons = faces.ask_states(asked, states)
    return found, [
        end_sentence(f"{TICK_BOXES[name].label}: {in_words_of_page(reason)}") for name, reason in reasons.items()
    ]


def finite(value: float) -> float | None:
    """Return a number that JSON has; None for one that it has not."""
    return float(value) if math.isfinite(value) else None
