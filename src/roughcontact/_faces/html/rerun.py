"""The script that solves a contact again."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from enum import Enum
from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.archive.plain import public_class
from roughcontact._parts.surfaces import SurfaceSum
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solution import ContactSolution

_FROM_FILE = """\
# The file that solution.save("solution.npz") writes, or 'Fields (.npz)' on the page, holds the heights and all else.
saved = rc.ContactSolution.load("solution.npz")
problem = rc.ContactProblem(**saved.origin.problem)"""


def hash_pressure(solution: ContactSolution) -> str:
    """Return the SHA-256 of the bytes of the pressure, by which two solutions are compared to the last bit."""
    return hashlib.sha256(np.ascontiguousarray(solution.pressure).tobytes()).hexdigest()


def write_script(solution: ContactSolution, problem: ContactProblem, load: Mapping[str, float]) -> str:
    """Return a Python script that solves a contact again, made of the parts of its problem or from its npz file."""
    writer = _Writer()
    try:
        made = writer.write_problem(problem)
        modules = sorted({"hashlib", *writer.modules})
    except _NotInAScript:
        made = _FROM_FILE
        modules = ["hashlib"]
    imports = "".join(f"import {name}\n" for name in modules)
    given = ", ".join(f"{kind}={_write_number(value)}" for kind, value in load.items())
    return (
        f"{imports}\nimport roughcontact as rc\n\n{made}\nsolution = problem.solve({given})\nprint(solution)\n"
        "print(hashlib.sha256(solution.pressure.tobytes()).hexdigest())  # of the report:\n"
        f"# {hash_pressure(solution)}\n"
    )


def describe_part(part: object) -> str:
    """Return a part of a problem as it stands in a script, or what it says of itself."""
    try:
        return _Writer().write(part)
    except _NotInAScript:
        return repr(part)


class _NotInAScript(Exception):
    """A value that no line of a script makes: measured heights, or a part whose class a notebook defines."""


@final
@attrs.frozen
class _Writer:
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
            return _write_number(value)
        if isinstance(value, (bool, int, str, type(None))):
            return repr(value)
        if isinstance(value, tuple):
            return f"({', '.join(map(self.write, value))}{',' if len(value) == 1 else ''})"
        if isinstance(value, SurfaceSum):
            return " + ".join(
                f"({self.write(part)})" if isinstance(part, SurfaceSum) else self.write(part) for part in value.parts
            )
        return self._write_call(value)

    def _write_call(self, value: Any) -> str:
        if not attrs.has(type(value)):
            raise _NotInAScript
        fields = ((field, getattr(value, field.name)) for field in attrs.fields(type(value)) if field.init)
        given = (f"{field.alias}={self.write(item)}" for field, item in fields if not _is_default(field, item))
        return f"{self._write_class(type(value))}({', '.join(given)})"

    def _write_class(self, cls: type) -> str:
        if public_class(cls.__name__) is cls:
            return f"rc.{cls.__name__}"
        module = cls.__module__
        if module == "__main__" or getattr(sys.modules.get(module), cls.__name__, None) is not cls:
            raise _NotInAScript
        self.modules.add(module)
        return f"{module}.{cls.__name__}"


def _write_number(value: float) -> str:
    """Return a text of a number that is exactly it, its exponent, if it needs one, a multiple of three."""
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
    """Return whether a field has its default; never of arrays, which do not compare."""
    return type(field.default) is type(value) and not isinstance(value, np.ndarray) and bool(field.default == value)
