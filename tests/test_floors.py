"""The house: a module imports only from lower floors, and stays small."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import roughcontact

ROOT = Path(roughcontact.__file__).parent
FLOORS = [
    {"errors", "units"},
    {"checks", "registry"},
    {"grid", "reference", "extrapolation", "optimality", "archive", "description"},
    {"clusters"},
    {"surfaces", "materials", "kernels", "solution"},
    {"body", "convolvers", "areas", "relief", "flattening"},
    {"solvers", "files", "gap"},
    {"plan"},
    {"loads", "sweep"},
    {"certificate"},
    {"problem"},
    {"load", "refinement", "running_in", "studies"},
    {"paper", "report", "stability", "testing"},
    {"cli"},
    {"__main__"},
]
FLOOR_OF = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
MODULES = sorted(path for path in ROOT.rglob("*.py") if path != ROOT / "__init__.py")


def room_of(path):
    return path.relative_to(ROOT).with_suffix("").parts[0]


def imported_rooms(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "roughcontact":
            parts = node.module.split(".")
            if len(parts) > 1:
                yield parts[1]
            else:
                yield from (alias.name for alias in node.names if alias.name in FLOOR_OF)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_go_down(path):
    here = room_of(path)
    for other in imported_rooms(path):
        assert other == here or FLOOR_OF[other] < FLOOR_OF[here], f"{here} imports {other}"


def lines_of(node):
    body = node.body[1:] if ast.get_docstring(node) and len(node.body) > 1 else node.body
    return node.end_lineno - body[0].lineno + 1


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_rooms_are_small(path):
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert lines_of(node) <= 42, node.name
