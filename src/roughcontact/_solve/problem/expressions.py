"""Parts of a problem as expressions of a Python script."""

from __future__ import annotations

import sys
from enum import Enum
from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.archive.plain import public_class
from roughcontact._base.registry import registries
from roughcontact._parts.surfaces import SurfaceSum
from roughcontact._solve.problem.body import Body
from roughcontact._solve.problem.problem import ContactProblem


def describe_part(part: object) -> str:
    """Return a part of a problem as an expression of a script, or else its repr."""
    try:
        return ExpressionWriter().write(part)
    except NotInAScript:
        return repr(part)


class NotInAScript(Exception):
    """A value that no line of a script makes: measured heights, or a part whose class a notebook defines."""


@final
@attrs.frozen
class ExpressionWriter:
    """Values as Python that makes equal ones, and the modules that it needs beside ``roughcontact as rc``."""

    modules: set[str] = attrs.field(factory=set)

    def write_problem(self, problem: ContactProblem) -> str:
        """Return the lines that make a problem."""
        defaults = {field.name: field for field in attrs.fields(ContactProblem)}
        given = {name: part for name, part in problem.parts.items() if not _is_default(defaults[name], part)}
        lines = "".join(f"    {name}={self._write_lines(part)},\n" for name, part in given.items())
        return f"problem = rc.ContactProblem(\n{lines})"

    def _write_lines(self, part: Any) -> str:
        if not isinstance(part, Body):
            return self.write(part)
        return f"rc.Body(\n        {self.write(part.surface)},\n        {self.write(part.material)},\n    )"

    def write(self, value: Any) -> str:
        """Return a value as an expression."""
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, Enum):
            return self.write(value.value)
        if isinstance(value, float):
            return write_number(value)
        if isinstance(value, (bool, int, str, type(None))):
            return repr(value)
        if isinstance(value, tuple):
            return f"({', '.join(map(self.write, value))}{',' if len(value) == 1 else ''})"
        if isinstance(value, list):
            return f"[{', '.join(map(self.write, value))}]"
        if isinstance(value, SurfaceSum):
            return " + ".join(
                f"({self.write(part)})" if isinstance(part, SurfaceSum) else self.write(part) for part in value.parts
            )
        return self._write_call(value)

    def _write_call(self, value: Any) -> str:
        if not attrs.has(type(value)):
            raise NotInAScript
        fields = ((field, getattr(value, field.name)) for field in attrs.fields(type(value)) if field.init)
        given = [f"{field.alias}={self.write(item)}" for field, item in fields if not _is_default(field, item)]
        made = _write_by_name(type(value))
        if made:
            return f"{made[0]}({', '.join([made[1], *given])})"
        return f"{self._write_class(type(value))}({', '.join(given)})"

    def _write_class(self, cls: type) -> str:
        if public_class(cls.__name__) is cls:
            return f"rc.{cls.__name__}"
        module = cls.__module__
        package = module.partition(".")[0]
        if getattr(sys.modules.get(package), cls.__name__, None) is cls:
            module = package
        if module == "__main__" or getattr(sys.modules.get(module), cls.__name__, None) is not cls:
            raise NotInAScript
        self.modules.add(module)
        return f"{module}.{cls.__name__}"


def _write_by_name(cls: type) -> tuple[str, str] | None:
    """Return the function that makes a shipped part that is public by its registered name alone, and that name."""
    if public_class(cls.__name__) is cls or cls.__module__.partition(".")[0] != "roughcontact":
        return None
    for registry in registries().values():
        name = registry.name_of(cls) if issubclass(cls, registry.base) else None
        if name is not None:
            return f"{registry.group.replace('roughcontact', 'rc')}.create", repr(name)
    return None


def write_number(value: float) -> str:
    """Return a text from which Python reads exactly the number; exponents are multiples of three."""
    if not np.isfinite(value):
        return f'float("{float(value)}")'
    plain = repr(float(value))
    if value == 0.0:
        return plain
    power = 3 * int(np.floor(np.log10(abs(value)) / 3.0))
    short = f"{value / 10.0**power:.15g}e{power}"
    needed = "e" in plain or len(short) < len(plain)
    return short if needed and float(short) == value else plain


def _is_default(field: Any, value: object) -> bool:
    """Return whether a field has its default; False for arrays, which do not compare."""
    return type(field.default) is type(value) and not isinstance(value, np.ndarray) and bool(field.default == value)
