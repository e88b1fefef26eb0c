"""The gallery in the browser: its scripts need neither threads nor processes nor what else Pyodide lacks."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "gallery"
SCRIPTS = sorted(GALLERY.glob("*.py"))
# Packages of Pyodide's distribution, and wheels beside the notebooks.
PLUGINS = ("layered", "volume")
OWN = {"roughcontact", *(f"roughcontact_{name}" for name in PLUGINS)}
THERE = {"attrs", "matplotlib", "numpy", "pandas", "scipy", *OWN}
# What Pyodide 314 (Python 3.14) answers to each of these; integers of 32 bits cannot be had here.
LIKE_PYODIDE = """
import os, subprocess, sys, threading
MISSING = {
    "_multiprocessing", "_posixshmem", "curses", "dbm", "ensurepip", "grp",
    "pwd", "readline", "resource", "syslog", "tkinter", "venv",
}
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name in MISSING:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
def refuse_thread(self):
    raise RuntimeError("can't start new thread")
def refuse_process(*given, **more):
    raise OSError(138, "emscripten does not support processes.")
for name in MISSING:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Refuse())
threading.Thread.start = refuse_thread
subprocess.Popen.__init__ = refuse_process
for name in ("fork", "link", "sched_getaffinity"):
    if hasattr(os, name):
        delattr(os, name)
"""
LACKING = ("import resource", "import threading; threading.Thread().start()", "import os; os.fork()")
NOT_ON_WINDOWS = pytest.mark.skipif(sys.platform == "win32", reason="Python itself needs _multiprocessing there")
RUN = """
import runpy, sys
for script in sys.argv[1:]:
    runpy.run_path(script, run_name="__main__")
"""


def run(*scripts):
    sources = os.pathsep.join(str(ROOT / "plugins" / f"roughcontact-{name}" / "src") for name in PLUGINS)
    environment = {**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": sources}
    command = [sys.executable, "-W", "ignore", "-c", LIKE_PYODIDE + RUN, *map(str, scripts)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False)


def needs(script):
    """The packages that a script imports, and pandas for a table."""
    text = script.read_text(encoding="utf-8")
    found = {"pandas"} if "to_pandas" in text else set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module.partition(".")[0])
    return found - set(sys.stdlib_module_names)


@pytest.mark.parametrize("script", SCRIPTS, ids=[script.stem for script in SCRIPTS])
def test_a_script_needs_nothing_that_pyodide_lacks(script):
    assert "roughcontact" in needs(script)
    assert needs(script) <= THERE


@pytest.mark.parametrize("line", LACKING)
def test_what_pyodide_lacks_is_refused(tmp_path, line):
    script = tmp_path / "script.py"
    script.write_text(line, encoding="utf-8")
    assert run(script).returncode != 0


@NOT_ON_WINDOWS
@pytest.mark.slow
def test_every_script_runs_without_threads_and_processes():
    pytest.importorskip("pandas")
    done = run(*SCRIPTS)
    assert done.returncode == 0, done.stderr
    assert "Hertz" in done.stdout
