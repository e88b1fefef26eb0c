"""Filters that grooves and spikes do not move."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import read_study

GRID = rc.Grid((72, 90), (144e-6, 90e-6))
TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def fit_by_hand(surface, cutoff):
    """Return the robust mean surface from sums over all points, and over the images of a map that repeats."""
    (nx, ny), (dx, dy) = surface.grid.shape, surface.grid.spacing
    images = range(-2, 3) if surface.periodic else (0,)
    known = np.ones((nx, ny)) if surface.non_measured is None else 1.0 * ~surface.non_measured
    heights, weights, cut = surface.values, known, np.inf
    for _ in range(50):
        means = np.empty((nx, ny))
        for i, j in np.ndindex(nx, ny):
            matrix, right = np.zeros((6, 6)), np.zeros(6)
            for a in images:
                for b in images:
                    x = ((np.arange(nx) - i + a * nx) * dx)[:, None] / cutoff + np.zeros((nx, ny))
                    y = ((np.arange(ny) - j + b * ny) * dy)[None, :] / cutoff + np.zeros((nx, ny))
                    near = np.exp(-np.pi * (x**2 + y**2) / 0.7309134**2) * weights
                    basis = np.array([x**p * y**q for p, q in TERMS]).reshape(6, -1)
                    matrix += (basis * near.ravel()) @ basis.T
                    right += basis @ (near * heights).ravel()
            means[i, j] = np.linalg.solve(matrix, right)[0]
        found = 3.0 / 0.6744898 * np.median(np.abs(heights - means)[known > 0])
        if abs(found - cut) <= 1e-3 * found:
            return means
        cut = found
        weights = known * np.maximum(1.0 - ((heights - means) / cut) ** 2, 0.0) ** 2
    return means


@pytest.mark.parametrize(("periodic", "hole"), [(False, False), (False, True), (True, False)])
def test_it_is_the_regression_of_the_standard(periodic, hole):
    rng = np.random.default_rng(1)
    heights = 1e-7 * rng.standard_normal((8, 5))
    heights[3, 2] = -4e-6
    lost = np.zeros((8, 5), dtype=bool)
    lost[6:, 3] = hole
    surface = rc.HeightMap(heights, (8e-6, 15e-6), periodic=periodic, non_measured=lost)
    expected = fit_by_hand(surface, 8e-6)
    found = surface.filtered("8um", robust=True)
    np.testing.assert_allclose(found.values, expected, rtol=0, atol=1e-12)
    rough = surface.filtered(longest="8um", robust=True)
    np.testing.assert_allclose(rough.values + found.values, heights, rtol=0, atol=1e-20)
    assert rough.history == ("waves above 8 µm removed by a robust Gaussian filter",)


def test_grooves_do_not_move_the_plateaus_and_forms_of_second_degree_go():
    rough = rc.SelfAffineSurface(hurst=0.5, rms_height=1e-7, shortest=8e-6, longest=30e-6, seed=1).heights(GRID)
    x, y = GRID.x / GRID.size[0], GRID.y / GRID.size[1]
    form = 4e-6 * (x - 2.0 * x * y + 0.5 * x**2 - y**2)
    grooves = np.abs((GRID.x + 0.6 * GRID.y + 1e-3) % 40e-6 - 20e-6) < 3e-6
    surface = rc.HeightMap(form + rough - 5e-6 * grooves, GRID.size)
    moved, kept = (surface.filtered(longest=50e-6, robust=robust).values for robust in (False, True))
    plateau = ~grooves
    assert np.abs(moved[plateau] - rough[plateau]).mean() > 5e-7
    assert np.abs(kept[plateau] - rough[plateau]).mean() < 5e-8
    smooth = rc.HeightMap(form, GRID.size)
    np.testing.assert_allclose(smooth.filtered(50e-6, robust=True).values, form, rtol=0, atol=1e-14)
    flat = rc.HeightMap(np.full((8, 9), 2.0), (8e-6, 9e-6))
    np.testing.assert_array_equal(flat.filtered(4e-6, robust=True).values, flat.values)


def test_on_the_command_line_and_in_a_study_file(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heights = 1e-7 * np.random.default_rng(0).standard_normal((20, 30))
    np.savez("map.npz", heights=heights, size=(20e-6, 30e-6))
    assert main(["info", "map.npz", "--longest", "10um", "--robust"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "waves above 10 µm removed by a robust Gaussian filter" in printed
    assert main(["info", "map.npz", "--robust"]) == 2
    assert "--robust is for filters: give --longest or --shortest too" in capsys.readouterr().err
    (tmp_path / "study.toml").write_text(
        """[problems.one.body]
surface = {type = "file", path = "map.npz", longest = "10um", robust = true}
material = {young = 1e9, poisson = 0.3}
[study]
force = [1e-3]
"""
    )
    (problem,) = read_study(tmp_path / "study.toml").problems.values()
    expected = rc.HeightMap(heights, (20e-6, 30e-6)).filtered(longest=10e-6, robust=True)
    np.testing.assert_array_equal(problem.body.surface.values, expected.values)
    with pytest.raises(rc.InputError, match="robust= must be True or False"):
        rc.HeightMap(heights, (20e-6, 30e-6)).filtered(5e-6, robust="yes")
