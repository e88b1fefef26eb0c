"""The house: a module imports only from lower floors, no circle of files anywhere, and rooms stay small.

The table of docs/architecture.md is the one that is held: it is read here, not typed again.
"""

from __future__ import annotations

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import roughcontact

ROOT = Path(roughcontact.__file__).parent
PAGE = Path(__file__).parent.parent / "docs" / "architecture.md"
MODULES = sorted(path for path in ROOT.rglob("*.py") if path != ROOT / "__init__.py")


def read_floors(text):
    rows = re.findall(r"^\| (\d+) \|(.*?)\|", text, flags=re.MULTILINE)
    return {int(number): re.findall(r"`(\w+)`", rooms) for number, rooms in rows}


FLOORS = read_floors(PAGE.read_text(encoding="utf-8"))
# The door `python -m roughcontact` is part of the command line.
FLOOR_OF = {room: floor for floor, rooms in FLOORS.items() for room in rooms}
ROOM_OF = {"__main__": "cli"}


def name_of(path):
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path): path for path in MODULES}


def room_of(name):
    room = name.split(".")[1]
    return ROOM_OF.get(room, room)


def is_for_types_only(node):
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def imported_modules(path):
    """Return the modules of the package that a file imports, whether at its top or inside a function."""
    tree, skipped = ast.parse(path.read_text(encoding="utf-8")), set()
    for node in ast.walk(tree):
        if is_for_types_only(node):
            skipped.update(id(inner) for inner in ast.walk(node))
    for node in ast.walk(tree):
        if id(node) in skipped or not isinstance(node, ast.ImportFrom) or not node.module:
            continue
        if node.module.split(".")[0] == "roughcontact":
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in NAMES else node.module


IMPORTS = {name: set(imported_modules(path)) for name, path in NAMES.items()}


def test_every_room_stands_on_one_floor():
    rooms = {room_of(name) for name in NAMES}
    assert rooms == set(FLOOR_OF)
    assert len(rooms) <= 36
    assert sorted(FLOORS, reverse=True) == list(range(len(FLOORS) - 1, -1, -1))
    assert len(FLOORS) <= 10


@pytest.mark.parametrize("name", NAMES)
def test_imports_go_down(name):
    here = room_of(name)
    for other in IMPORTS[name] - {"roughcontact"}:
        assert room_of(other) == here or FLOOR_OF[room_of(other)] < FLOOR_OF[here], f"{name} imports {other}"


def test_only_the_command_line_imports_the_whole_package():
    assert {room_of(name) for name in NAMES if "roughcontact" in IMPORTS[name]} <= {"cli"}


def test_files_import_each_other_in_no_circle():
    # A package stands for the files that its __init__ imports, so a file that imports its own package is a circle.
    try:
        TopologicalSorter(IMPORTS).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def lines_of(node):
    body = node.body[1:] if ast.get_docstring(node) and len(node.body) > 1 else node.body
    return node.end_lineno - body[0].lineno + 1


@pytest.mark.parametrize("name", NAMES)
def test_rooms_are_small(name):
    text = NAMES[name].read_text(encoding="utf-8")
    assert text.count("\n") <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert lines_of(node) <= 42, node.name
