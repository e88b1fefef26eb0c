"""What the command line says of wrong input and of doubtful maps: in its own words, before anything is solved."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from systems import posix

GRID = rc.Grid((48, 48), 48e-6)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=50e-9, shortest=8e-6, longest=24e-6, seed=3)
LOADED = ["--force", "20mN", "--young", "210GPa"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A rough map, another one on other cells, and a table in µm, in the working folder."""
    monkeypatch.chdir(tmp_path)
    np.savez("rough.npz", heights=ROUGH.heights(GRID), size=GRID.size)
    np.savez("other.npz", heights=ROUGH.heights(rc.Grid((32, 32), 48e-6)), size=GRID.size)
    np.savetxt("table.csv", 1e6 * ROUGH.heights(GRID), delimiter=",")
    return tmp_path


@pytest.fixture
def run(run):
    """The same, each text on one line."""

    def call(*arguments):
        status, *texts = run(*arguments)
        return status, *(" ".join(text.split()) for text in texts)

    return call


class TestOptionsInSentences:
    def test_of_a_table_without_a_size(self, run):
        status, _, err = run("solve", "table.csv", *LOADED)
        assert status == 2
        assert err.endswith(SIZE_AND_UNIT)

    def test_of_two_maps_on_different_grids(self, run):
        status, _, err = run("solve", "rough.npz", "other.npz", *LOADED)
        assert status == 2
        assert "give --match bilinear, " in err
        assert "match()" not in err
        assert ".resample(" not in err

    def test_of_one_side_of_a_map_that_is_not_square(self, run):
        np.savetxt("table.csv", np.random.default_rng(0).random((20, 30)))
        _, _, err = run("info", "table.csv", "--size", "1mm", "--separator", "blank")
        assert "needs both sides, --size X Y, but got one" in err


# A call, an argument, a name of a module, or a class.
SIZE_AND_UNIT = (
    "give --size X Y, or --cell, the distance of its points. "
    "Its heights are taken as m: give --unit um too if they are µm."
)
PYTHON = re.compile(r"\w\(|\w=|\brc\.|\w\.\w+\(|\b[A-Z][a-z]+[A-Z]\w+|on the command line")


class TestAdvice:
    """What a rule advises is in words that suit all who read it: in Python, on the command line and on a page."""

    @pytest.fixture
    def tilted(self):
        """A map that is tilted, and filled in."""
        lost = np.random.default_rng(0).random(GRID.shape) < 0.06
        heights = ROUGH.heights(GRID) + 0.02 * GRID.x
        np.savez("tilted.npz", heights=np.where(lost, np.nan, heights), size=GRID.size)
        return ["solve", "tilted.npz", "--non-measured", "fill", *LOADED]

    @pytest.mark.usefixtures("no_pictures")
    def test_of_a_solve_and_its_report(self, run, tilted):
        status, out, _ = run(*tilted, "--explain", "--report", "report.html")
        assert status == 3
        assert "Subtract the plane (detrend)." in " ".join(out.split())
        assert "where they touch, the contact is a guess" in " ".join(out.split())
        warned = [text for text in out.split("warning ")[1:] if "modulus E*" not in text]
        assert not any(PYTHON.search(text) for text in warned)
        page = Path("report.html").read_text(encoding="utf-8")
        section = page[page.index("<h2>Warnings</h2>") :].partition("</div>")[0]
        assert "Subtract the plane (detrend)." in section
        assert "where they touch, the contact is a guess" in section
        assert not PYTHON.search(re.sub(r"<[^>]*>", " ", section))

    def test_of_several_loads_and_a_jump_at_the_border(self, run, tilted):
        *_, young = tilted
        loads = ["--loads", "1MPa", "2MPa", "--young", young, "--boundary", "periodic"]
        _, out, _ = run(*tilted[:4], *loads)
        assert "use a surface that repeats, or a free boundary" in " ".join(out.split())


class OneStep(rc.ProjectedConjugateGradient):
    """A solver that stops after one iteration."""

    def solve(self, convolution, task):
        return rc.ProjectedConjugateGradient(max_iterations=1).solve(convolution, task)


UNFINISHED = """
[problems.rough]
solver = {type = "projected-cg", max_iterations = 1}
[problems.rough.body]
surface = {type = "file", path = "rough.npz"}
material = {type = "elastic", young = 210e9, poisson = 0.3}
[study]
force = [0.02]
"""


class TestOfWhatDoesNotConverge:
    """That Python finds the solution in the error means nothing in a shell."""

    def test_a_solve(self, run, monkeypatch):
        monkeypatch.setitem(rc.solvers._classes, "one-step", OneStep)
        np.savez("rough.npz", heights=ROUGH.heights(GRID), size=GRID.size, periodic=True)
        loaded = [*LOADED, "--boundary", "periodic"]
        status, _, err = run("solve", "rough.npz", *loaded, "--refine", "2", "--solver", "one-step")
        assert status == 1
        assert err.startswith("roughcontact: The contact is not converged: the maximum number of iterations")
        assert not re.search(r"\.solution|throw=", err)

    def test_a_study(self, run):
        Path("study.toml").write_text(UNFINISHED, encoding="utf-8")
        status, out, err = run("run", "study.toml")
        assert status == 1
        table = Path("study/records.csv").read_text(encoding="utf-8")
        for text in (out, table):
            assert "The contact is not converged: the maximum number of iterations was reached" in text
            assert not re.search(r"\.solution|throw=", text + err)

    def test_python_says_where_the_solution_is(self):
        body = rc.Body(ROUGH, rc.Elastic(210e9, 0.3))
        problem = rc.ContactProblem(body, grid=GRID, solver=rc.ProjectedConjugateGradient(max_iterations=1))
        with pytest.raises(rc.NotConverged, match=r"The solution reached is in \.solution of this error") as caught:
            problem.solve(force=0.02)
        assert caught.value.solution.iterations == 1


def test_a_negative_value_is_not_taken_for_an_option(run):
    status, _, err = run("solve", "rough.npz", "--force", "-1N", "--young", "210GPa")
    assert status == 2
    assert "The force must be a finite number, above 0 (N), but got -1.0." in err
    assert "expected one argument" not in err
    status, out, _ = run("solve", "rough.npz", "other.npz", *LOADED, "--match", "bilinear", "--offset", "-2um,0um")
    assert status in (0, 3)
    assert "contact area" in out


class TestMissingPackages:
    @pytest.mark.parametrize(
        ("output", "package", "extra"),
        [
            ("c.nc", "xarray", "store"),
            ("c.nc", "h5netcdf", "store"),
            ("c.html", "matplotlib", "plot"),
            ("c.html", "jinja2", "report"),
            ("folder", "matplotlib", "plot"),
        ],
    )
    def test_are_named_before_a_solve(self, run, monkeypatch, output, package, extra):
        monkeypatch.setitem(sys.modules, package, None)
        monkeypatch.setattr(rc.ContactProblem, "solve", None)
        status, _, err = run("solve", "rough.npz", *LOADED, "-o", output)
        assert status == 2
        assert package in err
        assert f"roughcontact[{extra}]" in err

    def test_are_named_before_a_report(self, run, monkeypatch):
        monkeypatch.setitem(sys.modules, "matplotlib", None)
        monkeypatch.setattr(rc.ContactProblem, "solve", None)
        status, _, err = run("report", "rough.npz", *LOADED)
        assert status == 2
        assert "roughcontact[plot]" in err


def test_a_numbered_output_does_not_replace_a_map_that_is_read(run):
    os.rename("rough.npz", "map-2.npz")
    status, _, err = run("solve", "map-2.npz", "--loads", "10mN", "20mN", "--young", "210GPa", "-o", "map.npz")
    assert status == 2
    assert "The output 'map-2.npz' is a height map that is read" in err


@pytest.mark.parametrize("shape", ["--json", "--csv"])
def test_a_plan_is_text(run, shape):
    status, out, err = run("solve", "rough.npz", *LOADED, "--dry-run", shape)
    assert (status, out) == (2, "")
    assert "--dry-run prints the plan, which is text: omit --json or --csv." in err


class TestMapsInWords:
    @pytest.mark.parametrize("command", [["info"], ["plot", "-o", "table.png"]])
    def test_heights_in_an_unknown_unit_are_doubtful(self, run, command):
        name, *rest = command
        _, out, _ = run(name, "table.csv", "--size", "48um", *rest)
        assert "warning The heights differ by" in out
        assert "the unit of heights from a file" in " ".join(out.split())
        _, out, _ = run(name, "table.csv", "--size", "48um", "--unit", "1um", *rest)
        assert "heights differ" not in out

    def test_a_table_without_a_size_is_asked_for_its_unit_too(self, run):
        _, _, err = run("info", "table.csv")
        text = " ".join(err.split())
        assert SIZE_AND_UNIT in text
        _, _, err = run("info", "table.csv", "--unit", "um")
        assert err.rstrip().endswith("give --size X Y, or --cell, the distance of its points.")

    def test_sq_is_that_about_the_mean(self, run):
        rough = rc.HeightMap(ROUGH.heights(GRID), GRID.size).detrend(2)
        np.savez("rough.npz", heights=rough.values, size=GRID.size)
        _, out, _ = run("info", "rough.npz")
        assert f"Sq {1e9 * rough.values.std():.4g} nm about the mean" in out
        assert "rms height" not in out
        assert "is tilt and curvature" not in out

    def test_form_is_not_taken_for_roughness(self, run):
        heights = ROUGH.heights(GRID) - (GRID.x**2 + GRID.y**2) / (2 * 1e-4)
        np.savez("ball.npz", heights=heights, size=GRID.size)
        _, out, _ = run("info", "ball.npz")
        assert re.search(r"warning 9\d.*% of the variance of the heights is tilt and curvature", out)
        _, out, _ = run("info", "ball.npz", "--detrend", "2")
        assert "is tilt and curvature" not in out


class TestClosedOutput:
    def start(self, arguments, stdout, **others):
        return subprocess.run(
            [sys.executable, "-m", "roughcontact", *arguments],
            stdout=stdout,
            stderr=subprocess.PIPE,
            text=True,
            **others,
        )

    # argparse of CPython 3.11.2 passes on the error of its help, later ones keep it to themselves.
    @pytest.mark.parametrize(
        ("arguments", "statuses"),
        [(["info", "rough.npz"], {141}), (["solve", "--help"], {0, 141}), (["info", "none.npz"], {2})],
    )
    @posix
    def test_of_a_pipe_is_not_an_answer_that_failed(self, arguments, statuses):
        reading, writing = os.pipe()
        os.close(reading)
        done = self.start(arguments, writing)
        os.close(writing)
        assert done.returncode in statuses
        assert "Error" not in done.stderr

    @posix
    def test_of_a_shell_is_no_fault(self):
        command = f"{sys.executable} -m roughcontact solve rough.npz {' '.join(LOADED)} -o c.npz >&-"
        done = subprocess.run(["sh", "-c", command], stderr=subprocess.PIPE, text=True)
        assert done.returncode in (0, 3)
        assert "report this" not in done.stderr
        assert rc.ContactSolution.load("c.npz").force == pytest.approx(0.02)
