"""First-day mistakes get their sentences and exit statuses, and ordinary contacts get none."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS / "studies"))
import first_day_mistakes as study  # noqa: E402

ROWS = [line for line in study.PAGE.read_text(encoding="utf-8").partition(study.HEAD)[2].splitlines() if line]
STEEL = rc.Elastic(210e9, 0.3)


def test_the_page_has_no_other_row():
    table = study.PAGE.read_text(encoding="utf-8").partition(study.HEAD)[2].partition("\n\n")[0]
    assert len(table.splitlines()) == sum(mistake.on_page for mistake in study.MISTAKES)


def contact(surface, cells=64, size=64e-6, material=STEEL, counterbody=rc.RIGID_FLAT, boundary="free", **load):
    grid = None if isinstance(surface, rc.HeightMap) else rc.Grid((cells, cells), size)
    return rc.ContactProblem(rc.Body(surface, material), counterbody, grid=grid, boundary=boundary).solve(**load)


def draw_rough(slope=0.05, seed=1, **options):
    return rc.SelfAffineSurface(hurst=0.8, rms_slope=slope, shortest=8e-6, longest=32e-6, seed=seed, **options)


def punch():
    grid = rc.Grid((64, 64), 64e-6)
    return rc.HeightMap(np.where(np.hypot(grid.x, grid.y) < 20e-6, 5e-6, 0.0), 64e-6)


def with_non_measured_points():
    heights = draw_rough().heights(rc.Grid((64, 64), 64e-6))
    return rc.HeightMap(heights, 64e-6, non_measured=np.random.default_rng(0).random(heights.shape) < 0.1)


README = {"cells": 256, "size": 250e-6, "material": rc.Elastic(200e9, 0.3), "boundary": "periodic"}
ORDINARY = {
    "the wave of the README": lambda: contact(rc.WavySurface(0.5e-6, 12.5e-6), pressure=100e6, **README),
    "the wave on 512 cells": lambda: contact(rc.WavySurface(0.5e-6, 12.5e-6), pressure=50e6, **README | {"cells": 512}),
    "the ball of docs/trust/stability.md": lambda: contact(rc.ParaboloidSurface(10e-3), 128, 1e-3, force=20.0),
    "a ball in a domain of its diameter": lambda: contact(rc.ParaboloidSurface(1e-3), 128, 2e-3, force=20.0),
    "a ball away from the centre": lambda: contact(rc.ParaboloidSurface(1e-2, center=(2e-4, 0)), size=1e-3, force=20.0),
    "a ball near the border": lambda: contact(rc.ParaboloidSurface(1e-2, center=(3.9e-4, 0.0)), size=1e-3, force=20.0),
    "a rubber ball": lambda: contact(rc.SphereSurface(5e-3), size=2e-3, material=rc.Elastic(2e6, 0.49), force=5e-3),
    "a gel": lambda: contact(rc.SphereSurface(5e-3), size=2e-3, material=rc.Elastic(20e3, 0.49), force=5e-5),
    "a polymer": lambda: contact(draw_rough(), material=rc.Elastic(3e9, 0.4), boundary="periodic", pressure=1e6),
    "diamond": lambda: contact(draw_rough(0.02), material=rc.Elastic(1.14e12, 0.07), boundary="periodic", pressure=1e9),
    "rough, 1 %": lambda: contact(draw_rough(), boundary="periodic", pressure=60e6),
    "rough, 20 %": lambda: contact(draw_rough(), boundary="periodic", pressure=1e9),
    "rough, full contact": lambda: contact(draw_rough(0.02), boundary="periodic", pressure=20e9),
    "rough, steep": lambda: contact(draw_rough(0.1), boundary="periodic", pressure=500e6),
    "a lay": lambda: contact(draw_rough(lay=5.0), boundary="periodic", pressure=300e6),
    "wrapped": lambda: contact(draw_rough(), boundary="wrapped", pressure=300e6),
    "rough on a free border": lambda: contact(draw_rough(), cells=256, size=256e-6, pressure=115e6),
    "a rough ball": lambda: contact(draw_rough() + rc.SphereSurface(5e-3), force=0.05),
    "a capped rough ball": lambda: contact(
        draw_rough() + rc.SphereSurface(2e-3), material=rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9), force=0.5
    ),
    "two elastic bodies": lambda: contact(
        draw_rough(), counterbody=rc.Body(draw_rough(seed=2), STEEL), boundary="periodic", pressure=1e8
    ),
    "a flat punch": lambda: contact(punch(), pressure=100e6),
    "non-measured points": lambda: contact(with_non_measured_points(), boundary="periodic", pressure=100e6),
    "silicon under an atomic force microscope": lambda: contact(
        rc.SelfAffineSurface(hurst=0.8, rms_height=0.3e-9, shortest=60e-9, longest=250e-9, seed=0),
        size=500e-9, material=rc.Elastic(160e9, 0.22), boundary="periodic", pressure=100e6,
    ),
    "a wheel on a rail": lambda: contact(rc.ParaboloidSurface((0.46, 0.3)), size=20e-3, force=50e3),
}  # fmt: skip


@pytest.mark.parametrize("name", ORDINARY)
def test_ordinary_contacts_have_no_warnings(name):
    solution = ORDINARY[name]()
    assert solution.warnings == ()
    warned = [line for line in str(solution).splitlines() if line.startswith("warning")]
    assert all(
        "The contact area is uncertain" in line or "The maximum pressure is uncertain" in line for line in warned
    )


def in_millimetres(**load):
    heights = draw_rough(seed=0).heights(rc.Grid((64, 64), 64e-6))
    return contact(rc.HeightMap(1e3 * heights, 64e-3), **load)


@pytest.mark.parametrize(
    "solve",
    [
        lambda: in_millimetres(force=0.04),
        lambda: contact(rc.SphereSurface(5.0), 63, 0.9, force=5.0),
        lambda: contact(draw_rough(), boundary="periodic", pressure=100.0),
        lambda: contact(draw_rough(), boundary="periodic", pressure=0.1, material=rc.Elastic(10e6, 0.49)),
    ],
    ids=["lengths in mm", "a ball in mm", "MPa", "rubber in MPa"],
)
def test_loads_and_lengths_in_another_unit_are_named_where_all_is_on_single_cells(solve):
    (warning,) = solve().warnings
    assert re.match(
        r"The mean pressure is .* of E\* \(loads are in Pa and N, lengths in m: 100 MPa is 100e6, 1 mm", warning
    )
    assert "single cell. The grid does not resolve" in warning


def test_a_light_load_that_the_grid_resolves_is_no_mistake():
    assert contact(rc.ParaboloidSurface(10e-3), 128, 2e-4, force=1e-6).mean_pressure < 1e-7 * STEEL.young
    assert contact(rc.ParaboloidSurface(10e-3), 128, 5e-5, force=1e-6).warnings == ()


@pytest.mark.parametrize(("radius", "cut"), [(0.95, False), (1.0, False), (1.06, True), (1.1, True), (1.5, True)])
def test_a_ball_is_cut_where_its_area_is_wrong(radius, cut):
    """The radius is that of Hertz over half the side: at 1 the contact touches the border, at 1.06 2 % are missing."""
    force = 4 * (radius * 32e-6) ** 3 / (3 * 5e-3 * STEEL.compliance)
    solution = contact(rc.ParaboloidSurface(5e-3), force=force)
    assert any("reach the free border" in warning for warning in solution.warnings) == cut
    assert (abs(solution.area().value / (np.pi * (radius * 32e-6) ** 2) - 1) > 0.02) == cut


@pytest.mark.parametrize("file", ["c.npz", "c.nc"])
def test_a_loaded_solution_says_the_same(file, tmp_path):
    pytest.importorskip("h5netcdf")
    solution = contact(draw_rough(), material=rc.Elastic(210, 0.3), boundary="periodic", pressure=1e-2)
    solution.save(tmp_path / file)
    loaded = rc.ContactSolution.load(tmp_path / file)
    assert loaded.warnings == solution.warnings != ()
    assert "the counterbody is rigid" in str(loaded)
    both = contact(draw_rough(), counterbody=rc.Body(rc.FlatSurface(), STEEL), boundary="periodic", pressure=1e8)
    assert "is rigid" not in str(both)


def test_a_solve_that_fails_names_the_likely_cause():
    with pytest.raises(rc.NotConverged, match="Young's modulus of 210 Pa is that of a foam or a gel"):
        contact(draw_rough(), material=rc.Elastic(210, 0.3), pressure=1e12)


def test_one_side_in_a_file_does_for_square_maps_only(tmp_path):
    np.savez(tmp_path / "square.npz", heights=np.eye(8), size=1e-3)
    assert rc.read_surface(tmp_path / "square.npz").size == (1e-3, 1e-3)
    np.savez(tmp_path / "oblong.npz", heights=np.eye(8)[:6], size=1e-3)
    with pytest.raises(rc.InputError, match=r"must hold both sides, m, of a map of shape \(6, 8\)"):
        rc.read_surface(tmp_path / "oblong.npz")
    assert rc.HeightMap(np.eye(8)[:6], size=(1e-3, 1e-3)).size == (1e-3, 1e-3)
