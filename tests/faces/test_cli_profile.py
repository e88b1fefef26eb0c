"""``roughcontact profile``: the numbers of the API, what is not known, and what is refused."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import roughcontact as rc


@pytest.fixture(autouse=True)
def heights(tmp_path, monkeypatch):
    """Lines along both axes of a rough surface in the working folder; those along x in um with positions in mm."""
    monkeypatch.chdir(tmp_path)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=64e-6, seed=3)
    values = rough.heights(rc.Grid((256, 256), 256e-6))
    names = ["x (mm)", *(f"z{k} (um)" for k in range(5))]
    rows = np.column_stack((1e-3 * np.arange(256), 1e6 * values[:, ::60]))
    np.savetxt("lines.csv", rows, delimiter=",", header=",".join(names), comments="")
    np.save("across.npy", values[::60])
    return values


def test_json_has_the_numbers_of_the_api_and_what_is_not_known(run, heights):
    call = ("profile", "lines.csv", "--across", "across.npy", "--spacing", "1um", "--json")
    status, output, _ = run(*call, "--pressure", "50MPa", "--modulus", "230GPa")
    found = rc.reference.profile(heights[:, ::60].T, 1e-6, across=heights[::60])
    content = json.loads(output)
    for name in ("Rq", "Rdq", "Rdq_across", "Sq", "Sdq", "m0", "m2"):
        expected = getattr(found, name)
        assert content["answers"][name]["value"] == pytest.approx(expected.value, rel=1e-9), name
        assert content["answers"][name]["uncertainty"] == pytest.approx(expected.uncertainty, rel=1e-9), name
    area = found.persson_area(50e6, 230e9)
    assert content["answers"]["area"]["value"] == pytest.approx(area.value, rel=1e-9)
    assert (content["lines"], content["lines_across"], content["points"]) == (5, 5, 256)
    assert "summits" in content["unknown"]
    assert "Sdq" not in content["unknown"]
    assert status == (3 if found.Sq.warnings else 0)


def test_one_direction_tells_no_gradient(run):
    _, text, _ = run("profile", "lines.csv")
    assert "Sdq is not known: state --isotropic" in text
    _, table, _ = run("profile", "lines.csv", "--csv")
    assert [row["quantity"] for row in csv.DictReader(table.splitlines())] == ["Rq", "Rdq", "Sq", "m0"]


def test_files_of_one_direction_are_joined_and_a_spectrum_is_fitted(run, heights):
    np.save("one.npy", heights[:, :120:60].T)
    np.save("two.npy", heights[:, 120::60].T)
    call = ("--spacing", "1um", "--isotropic", "--shortest", "8um", "--json")
    joined, whole = (json.loads(run("profile", *names, *call)[1]) for names in (("one.npy", "two.npy"), ("lines.csv",)))
    for name, one in whole["answers"].items():
        assert joined["answers"][name]["value"] == pytest.approx(one["value"], rel=1e-6), name
    assert {"hurst", "rolloff"} <= whole["answers"].keys()


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (["lines.csv", "--isotropic", "--across", "across.npy", "--spacing", "1um"], "omit --isotropic or --across"),
        (["lines.csv", "--spacing", "2um"], "omit --spacing"),
        (["lines.csv", "--shortest", "8um"], "state --isotropic"),
        (["lines.csv", "--pressure", "1MPa", "--modulus", "1GPa"], "needs Sdq"),
        (["lines.csv", "--isotropic", "--pressure", "1MPa"], "give both"),
        (["across.npy"], "give --spacing"),
        (["lines.csv", "--across", "half.npy", "--spacing", "1um"], "give --spacing|at least 32 points"),
        (["lines.csv", "long.npy", "--spacing", "1um"], "differ in points"),
        (["none.csv"], "no file"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(run, heights, change, part):
    np.save("half.npy", heights[::60, :20])
    np.save("long.npy", np.tile(heights[::60], 2))
    status, output, error = run("profile", *change)
    assert status == 2
    assert not output
    assert any(one in error for one in part.split("|")), error
    assert "Traceback" not in error


def test_the_command_runs_by_itself():
    call = [sys.executable, "-m", "roughcontact", "profile", "lines.csv", "--isotropic"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=60, env=os.environ, check=False)
    assert done.returncode in (0, 3), done.stderr
    assert done.stdout.startswith("5 lines of 256 points")
    assert "Sdq" in done.stdout
    assert all(len(line) <= 80 for line in done.stdout.splitlines())
