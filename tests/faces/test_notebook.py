"""An executed notebook shows each figure once, and results as they print or as tables."""

from __future__ import annotations

import base64
import sys
from collections.abc import Iterator

import html5lib
import numpy as np
import pytest

import roughcontact as rc

SETUP = """
import roughcontact as rc

grid = rc.Grid((24, 16), (3e-6, 2e-6))
surface = rc.WavySurface(1e-7, 1e-6)
problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(200e9, 0.3)), grid=grid, boundary="periodic")
solution = problem.solve(pressure=1e9)
sweep = problem.sweep(pressure=[1e8, 1e9])
"""
# Cells, and the number of pictures that each one shows; those behind ``%matplotlib inline``.
CELLS = {
    "solution.plot()": 1,
    "fig = solution.plot()": 1,
    "fig": 1,
    "surface.plot(grid)": 1,
    "sweep.plot()": 1,
    "solution.plot('pressure')": 1,
    "sweep.plot();": 1,
    "first = sweep.plot()\nsweep.plot()": 2,
    "display(solution.plot('gap').figure)": 1,
    "rc.plotting.make_figure('sweep', sweep);": 0,
    "solution.iterations": 0,
}
# Small results, which a cell shows as `print` does.
PRINTED = (
    "solution.area()",
    "solution.peak_pressure()",
    "solution.saturated_area()",
    "solution.residuals",
    "solution.stiffness()",
    "solution.conductance(45.0)",
    "solution.leakage(viscosity=1e-3, pressure_drop=1e5)",
    "solution.leakage(viscosity=1e-3, pressure_drop=1e5).throat",
    "solution.stress([1e-7])",
    "solution.stress([1e-7]).maximum",
    "solution.first_yield(yield_stress=1e9)",
    "solution.partial_slip(tangential_force=1e-6, friction=0.3)",
    "problem.solve_for(area='10%')",
    "rc.reference.roughness(surface.heights(grid), grid, periodic=True)",
    "rc.reference.texture(surface.heights(grid), grid, periodic=True)",
)
# A map with a hole, and a path with friction, whose print is a table.
MAP = "heights = surface.heights(grid).copy(); heights[3:6, 2:5] = float('nan'); rc.HeightMap(heights, grid.size)"
PATH = """
flat = rc.Body(rc.FlatSurface(), rc.Elastic(200e9, 0.3))
path = rc.ContactProblem(problem.body, flat, grid=grid, boundary="periodic").path(
    force=6e-3, tangential_force=[(6e-4, 0.0), (0.0, 0.0)], friction=0.3
)
path
"""
INLINE = {"solution.plot()": 1, "fig = sweep.plot()": 1, "fig": 1, "first = sweep.plot()\nsweep.plot()": 2}


def execute(tmp_path):
    """Return the cells of one notebook, executed."""
    # Imported here: they take longer than all other modules of tests, and each process collects all tests.
    import nbclient
    import nbformat

    printed = [cell for text in PRINTED for cell in (text, f"print({text})")]
    cells = [SETUP, *CELLS, "%matplotlib inline", *INLINE, *printed, f"[{PRINTED[0]}]", MAP, PATH]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    with pytest.MonkeyPatch.context() as patch:
        for name in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR"):
            patch.setenv(name, str(tmp_path / name))
        # The kernel chooses the backend.
        patch.delenv("MPLBACKEND", raising=False)
        nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    return notebook.cells


def pictures(cell) -> Iterator[bytes]:
    for output in cell.outputs:
        for kind, content in output.get("data", {}).items():
            if kind == "image/png":
                yield base64.b64decode(content)


def check_that_each_figure_is_shown_once(executed):
    shown = [(cell.source, len(list(pictures(cell)))) for cell in executed]
    wanted = [(SETUP, 0), *CELLS.items(), ("%matplotlib inline", 0), *INLINE.items()]
    assert shown == wanted + [(cell.source, 0) for cell in executed[len(wanted) :]]


def check_that_pictures_of_different_figures_differ(executed):
    images = [picture for cell in executed for picture in pictures(cell)]
    assert len(set(images)) >= 5
    assert all(image.startswith(b"\x89PNG") and len(image) > 2000 for image in images)


def check_that_small_results_are_shown_as_they_print(executed):
    # What an answer warns of goes to standard error.
    shown = {cell.source: [one for one in cell.outputs if one.get("name") != "stderr"] for cell in executed}
    for text in PRINTED:
        (value,) = shown[text]
        # A kernel may send what is printed in parts.
        printed = "".join(part["text"] for part in shown[f"print({text})"])
        assert value["data"]["text/plain"] == printed.rstrip("\n"), text
    (first,) = shown[PRINTED[0]]
    (listed,) = shown[f"[{PRINTED[0]}]"]
    assert listed["data"]["text/plain"] == f"[{first['data']['text/plain']}]"


def check_that_a_map_is_shown_with_its_numbers_and_one_picture(executed):
    (shown,) = (cell.outputs[0]["data"]["text/html"] for cell in executed if cell.source == MAP)
    fragment = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False).parseFragment(shown)
    texts = {row.find("th").text: row.find("td").text for row in fragment.iter("tr")}
    assert texts["grid"] == "24 x 16 cells on 3 µm x 2 µm, cells of 125 nm x 125 nm"
    assert texts["non-measured"] == "9 of 384 points (2.3 %)"
    (picture,) = fragment.iter("img")
    assert base64.b64decode(picture.get("src").partition(",")[2]).startswith(b"\x89PNG")


def check_that_a_path_is_shown_as_a_table(executed):
    (shown,) = (cell.outputs[0]["data"]["text/html"] for cell in executed if cell.source == PATH)
    assert shown.startswith("<div>energy lost: ")
    assert shown.count("<tr>") == 3


@pytest.mark.slow
def test_an_executed_notebook_shows_figures_once_and_results_as_they_print_or_as_tables(tmp_path):
    """One test, so that processes of pytest-xdist do not execute the notebook one each."""
    executed = execute(tmp_path)
    check_that_each_figure_is_shown_once(executed)
    check_that_pictures_of_different_figures_differ(executed)
    check_that_small_results_are_shown_as_they_print(executed)
    check_that_a_map_is_shown_with_its_numbers_and_one_picture(executed)
    check_that_a_path_is_shown_as_a_table(executed)


@pytest.mark.parametrize(
    "heights",
    [np.zeros((2, 1)), np.full((4, 4), 1e-6), np.where(np.eye(8), np.nan, 1e-6), np.zeros((1100, 3))],
    ids=["two points", "flat", "a line without heights", "long"],
)
def test_any_map_is_shown_also_without_matplotlib(heights, monkeypatch):
    surface = rc.HeightMap(heights, size=(1e-3, 1e-3))
    shown = surface._repr_html_()
    assert shown.count("<img") == 1
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert surface._repr_html_() == shown.partition("<img")[0]
