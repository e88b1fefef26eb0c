"""The same problem on other grids, and ladders of grids."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(200e9, 0.3)


def test_a_map_that_is_not_periodic_needs_an_interpolation():
    values = np.random.default_rng(0).standard_normal((16, 16))
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(values, size=16.0), rc.Elastic(1.0, 0.0)))
    with pytest.raises(rc.InputError, match="interpolation='bilinear'"):
        rc.on_grid(problem, (64, 64))
    assert rc.on_grid(problem, (64, 64), "bilinear").solve(pressure=1e-3).area().value > 0.0
    limits = rc.ElasticPerfectlyPlastic(1.0, 0.0, np.full((16, 16), 0.5))
    capped = rc.ContactProblem(rc.Body(rc.HeightMap(values, size=16.0, periodic=True), limits))
    with pytest.raises(rc.InputError, match="limit is an array"):
        rc.extrapolate(capped, pressure=1e-3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: rc.on_grid(3, (8, 8)), "must be a ContactProblem"),
        (lambda p: rc.on_grid(p, (1.5, 8)), "whole number"),
        (lambda p: rc.on_grid(p, (10**9, 10**9)), r"at most 2\^40 cells"),
        (lambda p: rc.on_grid(p, (10**6, 10**6)), "TiB of memory"),
        (lambda p: rc.on_grid(p, (32, 32), "nonsense"), "'bilinear'"),
        (lambda p: rc.extrapolate(p, pressure=1.0, levels=100), r"at most 2\^40 cells"),
        (lambda p: rc.extrapolate(p, pressure=1.0, levels=1), "at least 2"),
        (lambda p: rc.extrapolate(p, pressure=1.0, estimator="blen"), "Did you mean 'blend'"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    problem = rc.ContactProblem(rc.Body(rc.WavySurface(1e-3, 8.0), STEEL), grid=rc.Grid((16, 16), 16.0))
    with pytest.raises(rc.InputError, match=words):
        call(problem)


def test_sums_of_surfaces_are_refined():
    values = 1e-3 * np.random.default_rng(0).standard_normal((32, 32))
    surface = rc.HeightMap(values, size=32.0, periodic=True) + rc.WavySurface(0.1, 32.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary="periodic")
    finer = rc.on_grid(problem, (64, 64))
    assert finer.plan.grid.shape == (64, 64)
    coarse, fine = problem.solve(pressure=1e-4), finer.solve(pressure=1e-4)
    assert fine.approach == pytest.approx(coarse.approach, rel=0.1)


@pytest.mark.parametrize("cells", [75, 128])
def test_a_ladder_gives_the_area_of_its_finest_grid(cells):
    """Extrapolation from the two finest grids makes it worse: docs/studies/ladders.py."""
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=(1.0, 2.0)), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((cells, cells), 250e-6), boundary="periodic")
    ladder = rc.extrapolate(problem, pressure=100e6, levels=3)
    true = 1.14192e-2
    assert ladder.area.value == ladder.states[-1].area().value
    assert abs(ladder.area.fraction - true) <= 2 * ladder.area.uncertainty / problem.plan.grid.area
    assert ladder.eq_28.value / problem.plan.grid.area > 1.05 * true
    assert str(ladder).count("\n") == 4
