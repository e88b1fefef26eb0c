"""The maps of `rc.examples`: what their docstrings say of them, and their files."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main

MAPS = {"ball": rc.examples.ball, "ring": rc.examples.ground_ring, "map": rc.examples.lapped_plate}
MAPS["liner"] = rc.examples.honed_liner


def measured(surface):
    return surface.values if surface.non_measured is None else surface.values[~surface.non_measured]


@pytest.mark.parametrize("name", MAPS)
def test_a_map_is_the_same_each_time_and_has_no_warnings(name):
    surface = MAPS[name]()
    np.testing.assert_array_equal(surface.values, MAPS[name]().values)
    assert surface.warnings == ()
    assert not surface.periodic
    assert 128 <= min(surface.grid.shape) <= max(surface.grid.shape) <= 256
    assert abs(measured(surface).mean()) < 1e-9


# One height of each, m: on every machine the same to a picometre.
@pytest.mark.parametrize(
    ("name", "height", "rms", "skewness"),
    [
        ("ball", 2.4331e-8, 12e-9, 0.0),
        ("ring", 9.6748e-8, 150e-9, -0.06),
        ("map", 1.7668e-8, 50e-9, -0.9),
        ("liner", -1.80579e-7, 240e-9, -0.4),
    ],
)
def test_a_map_has_the_roughness_that_is_stated(name, height, rms, skewness):
    surface = MAPS[name]()
    rough = measured(surface.detrend(2))
    assert surface.values[40, 77] == pytest.approx(height, abs=1.5e-12)
    assert rough.std() == pytest.approx(rms, rel=0.03)
    assert np.mean((rough / rough.std()) ** 3) == pytest.approx(skewness, abs=0.05)


def test_the_maps_have_the_form_that_is_stated():
    """Second derivatives of the best quadratic form, 1/m."""
    forms = {"ball": (-1 / 5e-3, -1 / 5e-3), "ring": (0.0, -1 / 15e-3), "liner": (0.0, 1 / 41e-3)}
    for name, curvatures in forms.items():
        form = MAPS[name]().separate(2).form
        for axis, right in enumerate(curvatures):
            found = np.diff(form.values, 2, axis=axis).mean() / form.grid.spacing[axis] ** 2
            assert found == pytest.approx(right, abs=6)


def test_the_files_hold_the_maps(tmp_path, capsys):
    assert main(["examples", str(tmp_path / "new")]) == 0
    paths = [tmp_path / "new" / name for name in ("ball.npz", "ring.npz", "map.npz", "liner.npz", "map.csv")]
    assert capsys.readouterr().out.splitlines() == [str(path) for path in paths]
    for path in paths[:4]:
        surface = MAPS[path.stem]()
        found = rc.read_surface(path, non_measured="refuse" if surface.non_measured is None else "keep")
        assert found.grid == surface.grid
        np.testing.assert_array_equal(found.values, surface.values)
        np.testing.assert_array_equal(found.non_measured_on(found.grid), surface.non_measured_on(surface.grid))
    table = np.loadtxt(paths[4], delimiter=",")
    np.testing.assert_allclose(1e-6 * table, MAPS["map"]().values, rtol=0, atol=1e-15)
    assert rc.examples.write(tmp_path) == tuple(tmp_path / path.name for path in paths)


@pytest.mark.parametrize("name", ["map.npz", "map.csv", "liner.npz"])
def test_no_file_of_the_user_is_replaced(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    mine = Path(name)
    if mine.suffix == ".npz":
        np.savez(mine, heights=np.ones((8, 8)), size=1e-3)
    else:
        mine.write_text("1,2\n3,4\n")
    before = mine.read_bytes()
    assert main(["examples"]) == 2
    err = capsys.readouterr().err
    assert f"'{name}' holds something else" in err
    assert "examples maps" in err
    assert mine.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_the_files_are_written_once(tmp_path, capsys):
    rc.examples.write(tmp_path)
    (tmp_path / "ring.npz").unlink()
    times = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert main(["examples", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count("(already there)") == 4
    assert (tmp_path / "ring.npz").exists()
    assert all(path.stat().st_mtime_ns == time for path, time in times.items())


def test_the_first_command_gives_a_contact_whose_area_is_known(tmp_path, monkeypatch, capsys):
    text = (Path(__file__).parents[2] / "docs" / "start" / "getting_started.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"^roughcontact (solve ball.npz ring.npz .*)$", text, re.M)
    monkeypatch.chdir(tmp_path)
    rc.examples.write()
    assert main([*line.split(), "-o", "contact.npz"]) == 0
    # A dozen saturated cells are not an area: that one is doubtful, and nothing else.
    said = " ".join(capsys.readouterr().out.split()).split("warning ")[1:]
    assert all(text.startswith("The saturated area is uncertain") for text in said)
    solution = rc.ContactSolution.load("contact.npz")
    assert solution.warnings == ()
    area = solution.area()
    assert area.uncertainty < 0.01 * area.value
    assert area.warnings == ()
    # Two bodies with curvatures of 1/5 mm, and 1/15 mm more along y: the contact lies inside, and the hardness is met.
    assert 0.02 < area.fraction < 0.1
    assert solution.saturated.any()
