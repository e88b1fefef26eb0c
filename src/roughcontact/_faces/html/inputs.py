"""Problem, method and versions of a solution, in words and as a script that solves it again."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence, Set
from typing import Any

import attrs
import numpy as np

from roughcontact._base.archive import digest_of
from roughcontact._base.arrays import Array
from roughcontact._base.units import counted, si
from roughcontact._faces.html.words import typeset
from roughcontact._parts.grid import Load
from roughcontact._parts.materials import Material, Rigid
from roughcontact._parts.surfaces import FlatSurface, HeightMap, Surface, SurfaceSum, find_maps
from roughcontact._solve.problem import (
    Body,
    ContactProblem,
    ExpressionWriter,
    NotInAScript,
    describe_part,
)
from roughcontact._solve.problem import Path as StatePath
from roughcontact._solve.solution import (
    ContactSolution,
    describe_work,
    find_load,
    key_of_origin,
    versions,
)

_FROM_FILE = """\
# The file that {written} holds the heights and all else.
saved = {read}
problem = rc.ContactProblem(**saved.origin.problem)"""
# What a script calls that which a method of a problem returns, if not by the name of the method.
_NAMES = {"solve": "solution", "slide": "state"}
# Where the name of a file stands in the history of a map.
_FILE_IN_HISTORY = re.compile(r"read from (.+?)(?:, \d+ non-measured.*|: \d+ x .*|)", re.DOTALL)
_WORD_BORDER = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_LAWS = {"young": "Young's modulus", "poisson": "Poisson's ratio"}


def hash_pressure(solution: ContactSolution) -> str:
    """Return the SHA-256 of the bytes of the pressure, by which two solutions are compared to the last bit."""
    return hashlib.sha256(np.ascontiguousarray(solution.pressure).tobytes()).hexdigest()


def write_script(subject: ContactSolution | StatePath, problem: ContactProblem) -> str:
    """Return a Python script that solves a contact or a path again, made of the parts of its problem or from its file.

    It is empty for a state of a path, which its path solves again, and if no line makes what it needs.
    """
    verb, arguments = _find_call(subject)
    name = _NAMES.get(verb, verb)
    writer = ExpressionWriter(set() if verb != "solve" else {"hashlib"})
    try:
        given = ", ".join(f"{name}={writer.write(value)}" for name, value in arguments.items())
    except NotInAScript:
        given = ""
    if not given:
        return ""
    found = f"{name} = problem.{verb}({given})\nprint({name})\n"
    if isinstance(subject, ContactSolution) and verb == "solve":
        found += (
            f"print(hashlib.sha256({name}.pressure.tobytes()).hexdigest())  # of the report:\n"
            f"# {hash_pressure(subject)}\n"
        )
    return f"{_write_problem(problem, name, isinstance(subject, StatePath), writer.modules)}\n{found}"


def _find_call(subject: ContactSolution | StatePath) -> tuple[str, dict[str, Any]]:
    """Return the method of a problem that solves a contact or path again, and its arguments; none for other states."""
    if isinstance(subject, StatePath):
        return subject.verb, subject.list_arguments()
    if any(one.follows for one in subject.added):
        return "", {}
    load = find_load(subject)
    given: dict[str, Any] = {} if load is None else load.arguments
    if subject.shear is None:
        return "solve", given
    return "slide", {**given, "friction": subject.friction, "direction": subject.tangential_load.angle}


def _write_problem(problem: ContactProblem, name: str, of_path: bool, modules: Set[str]) -> str:
    """Return the lines that import modules and make a problem, of its parts or from the file of a contact or a path."""
    writer = ExpressionWriter()
    try:
        made = writer.write_problem(problem)
    except NotInAScript:
        page = ", or 'Fields (.npz)' on the page," if name == "solution" else ""
        read = f'rc.load("{name}.npz"){"[0]" * of_path}'
        made = _FROM_FILE.format(written=f'{name}.save("{name}.npz") writes{page}', read=read)
        writer = ExpressionWriter()
    imports = "".join(f"import {name}\n" for name in sorted({*modules, *writer.modules}))
    separator = "\n" if imports else ""
    return f"{imports}{separator}import roughcontact as rc\n\n{made}"


def describe_scene(solution: ContactSolution, problem: ContactProblem | None, loads: Sequence[Load]) -> str:
    """Return bodies, grid, boundary and loads in a line of text."""
    bodies = [] if problem is None else [problem.body, problem.counterbody]
    named = [str(load) for load in loads]
    if len(named) > 1:
        named = [f"{counted(len(named), 'load')}, {named[0]} to {named[-1].removeprefix(f'{loads[0].kind} ')}"]
    texts = [" on ".join(map(_name_body, bodies)), str(solution.grid), f"boundary {solution.boundary}", *named]
    return ", ".join(filter(None, texts))


def _describe_material(material: Material) -> dict[str, str]:
    """Return a material in words, if all its fields state units, or else as an expression of a script."""
    kind: type = type(material)
    fields = attrs.fields(kind) if attrs.has(kind) else ()
    if not all("unit" in field.metadata for field in fields):
        return {"expression": describe_part(material), "material": ""}
    texts = [_describe_quantity(field, getattr(material, field.name)) for field in fields]
    return {"expression": "", "material": ": ".join(filter(None, (_in_words(material), ", ".join(texts))))}


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
    history = surface.history if isinstance(surface, HeightMap) else ()
    read = _FILE_IN_HISTORY.fullmatch(history[0]) if history else None
    return read[1] if read else _in_words(surface)


def _in_words(part: object) -> str:
    return _WORD_BORDER.sub(" ", type(part).__name__).lower()


def describe_inputs(solution: ContactSolution, problem: ContactProblem | None) -> dict[str, Any]:
    """Return bodies, method, grid, load and digests, by the names that the template has for them."""
    cell = " x ".join(si(step, "m") for step in solution.grid.spacing)
    given = {"Grid": f"{solution.grid}, cells of {cell}, boundary {solution.boundary}"}
    if solution.non_measured is not None:
        given["Non-measured points"] = str(int(solution.non_measured.sum()))
    key = ""
    if solution.origin is not None:
        given["Load"] = str(find_load(solution))
        key = key_of_origin(solution.origin) or "none"
    bodies: dict[str, Any] = {}
    method = ""
    if problem is not None:
        bodies = {"Body": _describe_body(problem.body), "Counterbody": _describe_body(problem.counterbody)}
        method = f"{problem.plan.kernel}, {problem.plan.convolver}, {problem.plan.solver}"
    return {"bodies": bodies, "method": method, "given": given, "key": key, "hash": hash_pressure(solution)}


def list_certificate(solution: ContactSolution) -> dict[str, str]:
    """Return how the solve ended and its residuals with their meaning, by name."""
    rows = {"Status": str(solution.status)}
    for one in solution.certificate.conditions:
        rows[one.name.capitalize()] = f"{one.residual:.1e}: {one.meaning}"
    rows["Modulus E*"] = si(solution.modulus, "Pa", 6)
    if solution.moduli is not None:
        other = "wavelength" if solution.directional_moduli is None else "direction"
        rows["Modulus E*"] += f", that of the materials: the kernel has another for each {other}"
    rows["Work"] = describe_work(solution)
    if solution.accuracy is not None:
        rows["Accuracy"] = typeset(str(solution.accuracy).replace("\n", "; "))
    if solution.theory is not None:
        rows["Persson's theory"] = typeset(str(solution.theory))
    if solution.stickiness is not None:
        rows["Stickiness"] = typeset(str(solution.stickiness))
    return rows


def list_versions(solution: ContactSolution) -> dict[str, str]:
    """Return the versions of the programs that made a solution, by name."""
    numbers = versions() if solution.origin is None else solution.origin.versions
    rows = {"Packages": ", ".join(f"{name} {number}" for name, number in numbers.items())}
    programs = [] if solution.origin is None else solution.origin.programs
    return rows | ({"Plug-ins": ", ".join(programs)} if programs else {})


def _describe_body(body: Body) -> dict[str, Any]:
    """Return surface and material of a body, the origin of its heights, and the digests of measured ones."""
    maps = find_maps(body.surface)
    return {
        "surface": describe_part(body.surface),
        "history": "; ".join(body.surface.provenance) if maps else "",
        "maps": [{"shape": " x ".join(map(str, one.values.shape)), "digest": digest_of(one.values)} for one in maps],
        **_describe_material(body.material),
    }
