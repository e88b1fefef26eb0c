"""Every file is written through one function, which completes it or leaves what was there."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted([*ROOT.glob("src/**/*.py"), *ROOT.glob("plugins/*/src/**/*.py")])

# Calls that write a file, in numpy, pathlib, matplotlib, pandas, shutil and os.
WRITERS = {"savefig", "imsave", "write_text", "write_bytes", "to_netcdf", "to_excel", "to_parquet", "savez", "savetxt"}
WRITERS |= {"savez_compressed", "np.save", "copyfile", "copy2", "tofile", "touch", "os.replace", "os.rename"}
OPENERS = {"open", "File", "ZipFile", "memmap"}
# Functions that write elsewhere, and why.
ELSEWHERE = {
    ("__init__.py", "replacing"): "the door itself",
    ("__init__.py", "seal"): "is given the unfinished file",
    ("__init__.py", "append_line"): "appends lines that have a checksum each, and takes back one that does not fit",
    ("storage.py", "write_netcdf"): "writes to memory first",
    ("figures.py", "write_picture"): "draws in memory first",
    ("figures.py", "draw_png"): "draws in memory",
    ("figure_view.py", "savefig"): "chooses the pixels for the caller's file",
    ("folder.py", "_write_lock"): "a lock, renamed when it is held",
    ("folder.py", "_remove_abandoned"): "opens a lock to try it",
    ("command.py", "_shown"): "a private file for the browser alone",
    (
        "files.py",
        "write_field",
    ): "an unfinished file of which each process writes its rows, renamed when it is complete",
    ("files.py", "_replace"): "a complete store, which is renamed",
    ("uploads.py", "begin"): "an unfinished file, renamed when it is complete",
    ("output.py", "write_results"): "draws in memory first",
    ("ready.py", "_draw_nothing"): "draws in memory",
    ("inputs.py", "_damaged"): "writes to a temporary folder",
    ("__main__.py", "_prepare_streams"): "throws away what a closed stream would print",
}


def writes(call):
    text = ast.unparse(call.func)
    name = text.rpartition(".")[2]
    if name in OPENERS:
        texts = [*call.args, *(keyword.value for keyword in call.keywords if keyword.arg == "mode")]
        modes = [node.value for node in texts if isinstance(node, ast.Constant) and isinstance(node.value, str)]
        return any(set(mode) <= set("rwaxbt+") and set(mode) & set("wax+") for mode in modes)
    return name in WRITERS or text in WRITERS


def is_door(node):
    return isinstance(node, ast.With) and any(
        isinstance(item.context_expr, ast.Call) and ast.unparse(item.context_expr.func) == "replacing"
        for item in node.items
    )


def writers_outside(tree, function="", inside=False):
    """Yield the function and the call of whatever writes outside of a `with replacing(...)`."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Call) and writes(node) and not inside:
            yield function, ast.unparse(node)
        name = node.name if isinstance(node, ast.FunctionDef) else function
        yield from writers_outside(node, name, inside or is_door(node))


def test_every_file_is_written_through_the_one_door():
    assert SOURCES
    for path in SOURCES:
        found = writers_outside(ast.parse(path.read_text(encoding="utf-8")))
        assert [(path, name, call) for name, call in found if (path.name, name) not in ELSEWHERE] == []


@pytest.mark.parametrize(
    "line",
    [
        'open("x", "w")',
        'Path("x").open(mode="ab")',
        "figure.savefig(path)",
        'with opened(path) as file: path.write_text("")',
        "np.savez(path, x=x)",
        "numpy.save(path, x)\nnp.save(path, x)",
        'def draw():\n    zipfile.ZipFile(path, "a")',
    ],
)
def test_a_writer_outside_of_the_door_is_seen(line):
    assert list(writers_outside(ast.parse(line)))
    inside = "with replacing(path) as partial:\n" + "\n".join(f"    {part}" for part in line.split("\n"))
    assert not list(writers_outside(ast.parse(inside)))
