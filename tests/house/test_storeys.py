"""The house: a module imports only from its own storey or from lower ones, and nothing imports in a circle.

Tests enter by the public names; only those of files named `unit` know what is inside.

The table of docs/extend/architecture.md is the one that is held: it is read here, not typed again.
"""

from __future__ import annotations

import ast
import functools
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import roughcontact

ROOT = Path(roughcontact.__file__).parent
PLUGINS = Path(__file__).parents[2] / "plugins"
PAGE = Path(__file__).parents[2] / "docs" / "extend" / "architecture.md"


def read_storeys(text):
    """Return the folder of each storey, its rooms and the public modules beside it, from the lowest storey on."""
    rows = re.findall(r"^\| (\d) \|(.*?)\|(.*?)\|(.*?)\|", text, flags=re.MULTILINE)
    assert [int(row[0]) for row in rows] == list(range(len(rows) - 1, -1, -1))
    return [tuple(re.findall(r"`(\w+)`", cell) for cell in row[1:]) for row in reversed(rows)]


STOREYS = read_storeys(PAGE.read_text(encoding="utf-8"))
LEVEL = {name: level for level, (folder, _, public) in enumerate(STOREYS) for name in (*folder, *public)}
ROOMS = {f"{folder}.{room}": place for (folder,), rooms, _ in STOREYS[1:] for place, room in enumerate(rooms)}


def name_of(path):
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path): path for path in sorted(ROOT.rglob("*.py")) if path.parent != ROOT or path.stem[0] != "_"}


def room_of(name):
    """Return storey and room of a module, or the public module that it belongs to."""
    first, *rest = name.split(".")[1:]
    return f"{first}.{rest[0]}" if first.startswith("_") and rest else first


def imported_modules(path):
    """Yield the modules of the package that a file imports, at its top, inside a function or for annotations."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "roughcontact":
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in NAMES else node.module


@functools.cache
def read_imports():
    return {name: {one for one in imported_modules(path) if one != "roughcontact"} for name, path in NAMES.items()}


def test_the_folders_are_the_storeys():
    assert [folder[0] for folder, _, _ in STOREYS[1:]] == ["_base", "_parts", "_solve", "_answers", "_work", "_faces"]
    assert {room_of(name) for name in NAMES} == {*ROOMS, *LEVEL}
    assert len(ROOMS) <= 30


def goes_up(name, other):
    """Tell whether a module imports from a storey above its own, or from its own in the wrong order of rooms."""
    here, there = room_of(name), room_of(other)
    if there == here:
        return False
    above, below = LEVEL[here.split(".")[0]], LEVEL[there.split(".")[0]]
    if here in ROOMS and there in ROOMS and above == below:
        return ROOMS[there] >= ROOMS[here]
    return below > above


def test_imports_go_down():
    pairs = {(name, one) for name, imports in read_imports().items() for one in imports}
    assert sorted(pair for pair in pairs if goes_up(*pair)) == []


def test_only_the_command_line_imports_the_whole_package():
    whole = {name for name, path in NAMES.items() if "roughcontact" in {*imported_modules(path)}}
    assert {room_of(name) for name in whole} <= {"_faces.cli"}


def find_circle(graph):
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return " -> ".join(error.args[1])
    return ""


def test_rooms_import_each_other_in_no_circle():
    graph = {}
    for name, imports in read_imports().items():
        others = {room_of(one) for one in imports}
        graph.setdefault(room_of(name), set()).update(others - {room_of(name)})
    assert find_circle(graph) == ""


def test_files_import_each_other_in_no_circle():
    # A package stands for the files that its __init__ imports, so a file that imports its own package is a circle.
    assert find_circle(read_imports()) == ""


@pytest.mark.parametrize("plugin", sorted(PLUGINS.glob("*/src/*/")), ids=lambda folder: folder.name)
def test_files_of_a_plug_in_import_each_other_in_no_circle(plugin):
    files = {".".join(path.relative_to(plugin.parent).with_suffix("").parts): path for path in plugin.rglob("*.py")}
    graph = {}
    for name, path in files.items():
        nodes = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)]
        named = {node.module for node in nodes} | {f"{node.module}.{one.name}" for node in nodes for one in node.names}
        graph[name.removesuffix(".__init__")] = named & {*files}
    assert len(graph) == len(files) > 0
    assert find_circle(graph) == ""


@pytest.mark.parametrize("plugin", ["roughcontact-mpi", "roughcontact-torch"])
def test_solutions_of_slabs_and_devices_have_no_text_table_or_file_of_their_own(plugin):
    owned = {"__str__", "describe", "table", "to_csv", "to_dict", "to_html", "to_xarray", "save", "load", "plot"}
    classes = [
        node
        for path in (PLUGINS / plugin / "src").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ClassDef) and node.name != "TorchFFT"
    ]
    assert len(classes) > 5
    assert [one.name for one in classes if owned & {node.name for node in one.body if hasattr(node, "name")}] == []


def test_most_imports_name_a_room_and_not_its_files():
    deep = [(name, one) for name, imports in read_imports().items() for one in imports if one.count(".") > 2]
    assert sum(room_of(name) != room_of(other) for name, other in deep) <= 100


def test_each_assignment_has_a_line_of_its_own():
    # Those left swap values, or need the old one for another.
    statements = [node for path in NAMES.values() for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    packed = [
        node
        for node in statements
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple) and isinstance(node.value, ast.Tuple)
    ]
    assert len(packed) <= 10


def test_a_module_holds_one_subject():
    assert [name for name, path in NAMES.items() if path.read_text(encoding="utf-8").count("\n") > 500] == []


TESTS = Path(__file__).parents[1]


def imports_private(path):
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [f"{node.module}.{one.name}" for node in nodes if isinstance(node, ast.ImportFrom) for one in node.names]
    return any(re.match(r"roughcontact\.(\w+\.)*_(?!_)", name) for name in names)


# What loops over something else than loads: grids of an accuracy, surfaces of a seed, records on disk; and the march.
SOLVING_LOOPS = {
    "_answers.refinement.beyond_resolution",
    "_solve.problem.accuracy.solve_within",
    "_solve.problem.path.march",
}


def list_loops_that_solve(path):
    """Return the functions of a file in which a loop or a comprehension calls a solve."""
    found = set()

    def visit(node, function, is_looping):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Lambda):
            is_looping = False
            function = getattr(node, "name", function)
        if isinstance(node, ast.For | ast.While | ast.ListComp | ast.GeneratorExp | ast.DictComp | ast.SetComp):
            is_looping = True
        if isinstance(node, ast.Call) and is_looping:
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            of_load = any(one.arg is None for one in node.keywords)
            if called in ("run_solve", "follow") or (called == "solve" and of_load):
                found.add(function)
        for child in ast.iter_child_nodes(node):
            visit(child, function, is_looping)

    visit(ast.parse(path.read_text(encoding="utf-8")), "", False)
    return found


def test_loads_are_followed_by_the_march():
    """A loop over loads elsewhere would have its own start, progress and memory."""
    found = {
        f"{name.removeprefix('roughcontact.')}.{function}"
        for name, path in NAMES.items()
        if not name.startswith("roughcontact.testing")
        for function in list_loops_that_solve(path)
    }
    assert found == SOLVING_LOOPS


def test_only_unit_tests_import_what_is_private():
    others = [path for path in TESTS.rglob("*.py") if "unit" not in path.stem.split("_")]
    assert {path.name for path in others if imports_private(path)} == set()


def list_classes():
    """Return the names of the bases of each class, and of the methods that it defines."""
    found = {}
    for path in NAMES.values():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                bases = {name.id for base in node.bases for name in ast.walk(base) if isinstance(name, ast.Name)}
                found[node.name] = bases, {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
    return found


def test_results_are_printed_saved_and_reported_by_their_base():
    """A class below a noun adds rows and numbers; its texts, tables, files and pages are those of the base."""
    classes = list_classes()
    results = {"Result"}
    while below := {name for name, (bases, _) in classes.items() if bases & results} - results:
        results |= below
    assert {"ContactSolution", "Sweep", "AdhesionCycle", "FrictionalPath", "RunIn", "StudyResult"} <= results
    allowed = {
        "Result": {"to_html", "_repr_html_"},
        "TableResult": {"__str__", "to_csv", "to_pandas", "_repr_html_"},
        "ContactSolution": {"__str__", "save", "load"},
        "Path": {"save", "load"},
    }
    written = {"__str__", "to_csv", "to_pandas", "to_html", "_repr_html_", "save", "load"}
    assert {name: classes[name][1] & written for name in results if classes[name][1] & written} == allowed
