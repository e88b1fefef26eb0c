"""Study files in TOML."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path

from roughcontact._base import checks
from roughcontact._solve.problem import ContactProblem
from roughcontact._work.studies.form import Form, guess
from roughcontact._work.studies.study import Study
from roughcontact.errors import InputError

_TABLES = ("problems", "study")
# Errors that are listed, and characters of each.
_SHOWN = 10
_TEXT = 500
# A key of more than 64 parts, of words and of texts.
_LONG_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){64}""")


def read_study(path: str | Path) -> Study:
    """Read a study from a TOML file.

    The tables ``[problems.NAME]`` hold the arguments of a `ContactProblem`, the table ``[study]`` those of
    a `Study`. Surfaces, materials, kernels, laws of adhesion, convolvers and solvers are registered names, or tables
    with the name as ``type`` and the fields of the class. A field whose attrs metadata name its SI ``unit`` may be a
    text with another one, such as ``"210GPa"``. A surface may also be a ``file``, with the arguments of
    `read_surface`, ``tip_radius``, ``detrend``, ``shortest``, ``longest`` and ``robust`` of a filter, and ``resample``;
    its path leads to the folder of the study file or below it.

    Raises
    ------
    InputError
        If there is no such file, it is not TOML, or an entry is wrong; the sentence gives its place.
    """
    file = checks.path(path, "The study file")
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.")
    try:
        text = file.read_text(encoding="utf-8")
        # The parser takes the square of its length for a key of many parts.
        if _LONG_KEY.search(text):
            raise ValueError("a key has too many parts")
        raw = tomllib.loads(text)
    # Beside its own, the parser raises those of numbers with thousands of digits and of deep nesting.
    except (ValueError, RecursionError) as error:
        raise InputError(f"The file {file.name} is not TOML: {error}.") from error
    for name in raw:
        if name not in _TABLES:
            raise InputError(f"In {file.name}: unknown table{guess(name, _TABLES)} @ {_short(name)}")
    for name in _TABLES:
        if not isinstance(raw.get(name), dict):
            raise InputError(f"In {file.name}: required table missing @ {name}")
    form = Form(file.parent)
    problems = form.read(Mapping[str, ContactProblem], raw["problems"], "problems")
    _require_no_faults(form, file)
    study: Study = form.read(Study, {**raw["study"], "problems": problems}, "study")
    _require_no_faults(form, file)
    return study


def _require_no_faults(form: Form, file: Path) -> None:
    if form.faults:
        shown = [_short(f"{error} @ {place}") for place, error in form.faults]
        more = [f"and {len(shown) - _SHOWN} more"] if len(shown) > _SHOWN else []
        raise InputError(f"In {file.name}: " + "; ".join(shown[:_SHOWN] + more)) from form.faults[0][1]


def _short(text: str) -> str:
    return (text if text.isprintable() else ascii(text))[:_TEXT]
