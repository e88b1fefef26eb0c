"""Maps from real instruments; skipped where neither the maps nor their reader are at hand."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def reader():
    # Its imports warn of optional parallel packages.
    import warnings

    with warnings.catch_warnings(action="ignore"):
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)


@pytest.mark.parametrize(
    ("name", "shape", "size"),
    [
        ("plu-1.plu", (768, 576), (1274.88e-6, 956.16e-6)),
        ("x3p-2.x3p", (650, 650), (82.977e-6, 204.478e-6)),
    ],
)
def test_maps_come_in_si_units(measured_maps, name, shape, size):
    surface = rc.read_surface(measured_maps / name)
    assert surface.values.shape == shape
    assert surface.size == pytest.approx(size, rel=1e-4)
    assert 1e-8 < surface.detrend(1).values.std() < 1e-6


def test_non_measured_points_of_a_measurement(measured_maps):
    with pytest.raises(rc.InputError, match="116 of 307200 points were not measured"):
        rc.read_surface(measured_maps / "opd-1.opd")
    surface = rc.read_surface(measured_maps / "opd-1.opd", non_measured="fill")
    assert surface.detrend(1).values.std() == pytest.approx(6.7e-9, rel=0.02)


def test_a_measured_map_goes_through_the_command_line(measured_maps, tmp_path, capsys):
    command = "--pressure 10MPa --young 210GPa --hardness 6GPa --detrend 2 --resample 192 192".split()
    # Two fifths of the load are at the free border.
    assert main(["solve", str(measured_maps / "x3p-2.x3p"), *command, "-o", str(tmp_path)]) == 3
    text = capsys.readouterr().out
    assert "converged" in text
    assert "of the load is on contacts that reach the free border" in text
    with np.load(tmp_path / "solution.npz") as data:
        assert data["pressure"].max() == 6e9
        assert data["pressure"].mean() == pytest.approx(1e7)


def test_a_broken_instrument_file_is_named(tmp_path):
    (tmp_path / "map.sur").write_bytes(b"DIGITAL SURF" + bytes(100))
    with pytest.raises(rc.InputError, match=r"map\.sur cannot be used: it begins as files of Digital Surf SUR do, but"):
        rc.read_surface(tmp_path / "map.sur")


def test_two_instruments_maps_make_a_pair(measured_maps, tmp_path, capsys):
    maps = [str(measured_maps / name) for name in ("x3p-2.x3p", "opd-1.opd")]
    options = "--match bilinear --mirror --rotation 20deg --detrend 2 --non-measured keep --resample 256 256".split()
    load = "--force 0.05N --young 210GPa --hardness 6GPa --counterbody-young 210GPa".split()
    assert main(["solve", *maps, *options, *load, "--explain", "-o", str(tmp_path)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "116 of 307200 points non-measured and kept so" in text
    assert "converged" in text


def test_the_walk_through_of_the_pages(measured_maps, monkeypatch, tmp_path, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "studies"))
    study = __import__("measured_pair")
    problem = study.make_problem(measured_maps, (162, 90))
    assert [len(row) for row in study.make_rows(problem)] == 5 * [6]
    study.main(problem, measured_maps, tmp_path)
    assert "shakedown after 2 cycles" in capsys.readouterr().out
    assert (tmp_path / "measured_pair.png").stat().st_size > 10_000


def test_the_script_of_the_pages(measured_maps):
    page = (ROOT / "docs" / "use" / "pairs.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python maps\n(.*?)```", page, re.S)
    assert len(script.strip().splitlines()) <= 20
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=measured_maps, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "saturated" in done.stdout


def test_the_unit_of_an_instrument_is_not_overruled(measured_maps):
    with pytest.raises(rc.InputError, match="states its own unit"):
        rc.read_surface(measured_maps / "plu-1.plu", unit=1e-6)
