"""The types of public names, as mypy reads them for a script of a user."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import numpy as np

import roughcontact as rc

steel = rc.Elastic("210GPa", 0.3)
hard = rc.ElasticPerfectlyPlastic("210GPa", "0.3", hardness="6 GPa")
grid = rc.Grid((32, 32), "200um")
slender = rc.Grid(shape=(32, 16), size=("200um", 1e-4))
ball = rc.SphereSurface("10mm", center=("1um", 0.0))
barrel = rc.ParaboloidSurface(("10mm", "inf"))
wave = rc.WavySurface("0.1um", "20um")
rough = rc.SelfAffineSurface(hurst=0.8, rms_height="20nm", shortest="4um", longest="100um", seed=1)
height_map = rc.HeightMap(np.zeros((8, 8)), size="200um")
law = rc.Exponential("50mJ/m2", "20um")
laws = [rc.Dugdale("50mJ/m2", "1MPa"), rc.VanDerWaals("50mJ/m2", "1nm"), rc.ShortRange("50mJ/m2")]
bodies = rc.Body(ball + wave, hard), rc.Body(rc.FlatSurface(), "glass")
problem = rc.ContactProblem(*bodies, grid=grid, memory_limit="8 GiB")
solutions = [problem.solve(force="5N"), problem.solve(pressure="10MPa"), problem.solve(approach="50nm")]
sweep = problem.sweep(force=["1N", 2.0])
load = problem.require_load(force="1N")
smooth = rc.ContactProblem(rc.Body(ball, steel), rc.Body(rc.FlatSurface(), steel), grid=grid)
path = smooth.path(force="5N", tangential_force=[("1N", 0.0)], friction=rc.LimitedCoulomb(0.3, "100GPa"))
solution = smooth.solve(force="5N")
numbers: list[float] = [solution.response(rc.responses.create("stiffness")).value]
gap: rc.Estimate = solution.response("mean-gap")
numbers.append(solution.response("stiffness").value)
area: rc.Area = solution.area("cell-count")
stress = solution.stress(depths=["10um", 2e-5])
numbers.append(stress.maximum.value)
point = solution.first_yield(yield_stress="1GPa")
flow = solution.leakage(viscosity="1mPa.s", pressure_drop="1bar")
conductance = solution.conductance("45 W/m/K")
slip = solution.partial_slip(tangential_force="1N", friction=0.3)
needed = smooth.solve_for(stiffness="20MN/m")
length: rc.typing.Length = "3um"
"""


@pytest.fixture
def script(tmp_path):
    path = tmp_path / "script.py"
    path.write_text(SCRIPT)
    return path


def test_the_script_runs(script):
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_mypy_accepts_texts_with_units(script):
    pytest.importorskip("mypy")
    check = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(script.parent / "cache"), script]
    done = subprocess.run(check, capture_output=True, text=True, check=False, cwd=script.parent)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_mypy_refuses_what_is_wrong(script):
    pytest.importorskip("mypy")
    wrong = '\nbad: str = solution.response("mean-gap")\nrc.Elastic([1.0], 0.3)\nproblem.solve(force=b"5N")\n'
    script.write_text(SCRIPT + wrong)
    check = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(script.parent / "cache"), script]
    done = subprocess.run(check, capture_output=True, text=True, check=False, cwd=script.parent)
    assert done.stdout.count("error:") == 3, done.stdout
