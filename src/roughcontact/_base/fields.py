"""The fields of parts as faces ask for them: command line, study files and the page are made from these."""

from __future__ import annotations

import inspect
import re
from typing import Any

import attrs

from roughcontact._base.arrays import Pair
from roughcontact._base.registry import field_types


@attrs.frozen
class PartField:
    """A field of a part, as a form asks for it.

    Attributes
    ----------
    name
        The name.
    kind
        The type by which it is annotated.
    unit
        SI unit of its number; empty for a number without one, None if it is not a number.
    is_needed
        Whether it has no default.
    default
        Its default, if it has one that can be stated.
    plain_unit
        Unit of a number that a text may omit, such as ``"W/(m K) or S/m"``: the ``plain_unit`` in the metadata of
        the field; empty without one.
    """

    name: str
    kind: Any
    unit: str | None
    is_needed: bool
    default: Any = None
    plain_unit: str = ""

    @property
    def is_pair(self) -> bool:
        """Whether it is one number or two."""
        return bool(self.kind == Pair)

    @property
    def text_unit(self) -> str | None:
        """Unit of texts that stand for numbers; None if texts do not."""
        return self.plain_unit or self.unit


def list_fields(cls: type) -> dict[str, PartField]:
    """Return the arguments of a class by name; of one that is not of attrs their types are not known."""
    if not attrs.has(cls):
        parameters = inspect.signature(cls).parameters
        return {name: PartField(name, Any, None, one.default is one.empty) for name, one in parameters.items()}
    try:
        hints = field_types(cls)
    # A class of a script may be annotated with what is not known in its module.
    except NameError:
        hints = {}
    return {
        str(field.alias): PartField(
            str(field.alias),
            kind := hints.get(field.name, Any),
            field.metadata.get("unit", "" if kind in (float, Pair) else None),
            field.default is attrs.NOTHING,
            field.default,
            field.metadata.get("plain_unit", ""),
        )
        for field in attrs.fields(cls)
        if field.init
    }


def summarize(cls: type) -> str:
    """Return the first line of the docstring of a class, without marks and formulas."""
    return (inspect.getdoc(cls) or "").partition("\n")[0].partition(":math:")[0].replace("`", "").strip(" ,.")


def describe_fields(cls: type) -> dict[str, str]:
    """Return what the docstring of a class says of its parameters, by name."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n\S|\Z)", inspect.getdoc(cls) or "", re.DOTALL | re.MULTILINE)
    return {
        name: " ".join(text.split()).replace("`", "")
        for names, text in re.findall(r"^(\w[\w, ]*)\n((?:[ ]+.*\n?)+)", section[1] if section else "", re.MULTILINE)
        for name in names.split(", ")
    }
