"""Refinement around the contacts, and ladders of grids."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.refinement import on_grid

STEEL = rc.Elastic(200e9, 0.3)


@attrs.frozen
class Summits(rc.Surface):
    """Three summits of different height, far apart."""

    def heights(self, grid):
        z = np.full(grid.shape, -1.0)
        for x, y, h in ((-15.2, -12.1, 0.0), (14.3, 9.7, -4e-4), (-9.0, 18.4, -2e-4)):
            z = np.maximum(z, h - ((grid.x - x) ** 2 + (grid.y - y) ** 2) / 4e3)
        return z


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("load", [{"pressure": 3e-6}, {"approach": 4e-3}])
def test_patches_give_what_the_whole_fine_grid_gives(boundary, load):
    problem = rc.ContactProblem(
        rc.Body(Summits(), rc.Elastic(1.0, 0.0)), grid=rc.Grid((192, 192), 64.0), boundary=boundary
    )
    refined = rc.refine(problem, factor=6, **load)
    assert refined.local
    assert len(refined.solutions) == 3
    whole = on_grid(problem, (1152, 1152)).solve(**load)
    assert refined.force == pytest.approx(whole.force, rel=1e-4)
    assert refined.approach == pytest.approx(whole.approach, rel=1e-4)
    assert max(patch.pressure.max() for patch in refined.solutions) == pytest.approx(whole.pressure.max(), rel=1e-4)
    area, exact = refined.area(), whole.area()
    assert area.value == pytest.approx(exact.value, rel=1e-4)
    assert area.fraction == pytest.approx(exact.fraction, rel=1e-4)
    assert refined.area("cell-count").value == pytest.approx(whole.area("cell-count").value, rel=2e-2)


@pytest.mark.parametrize(("load", "true"), [(50e6, 0.71689e-2), (100e6, 1.14192e-2), (200e6, 1.82266e-2)])
def test_many_contacts_are_refined_all_together(load, true):
    """The paper's scene on 128 x 128 cells, where counting is off by up to 150 %."""
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=(1.0, 2.0)), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((128, 128), 250e-6), boundary="periodic")
    refined = rc.refine(problem, pressure=load)
    assert not refined.local
    assert refined.area().fraction == pytest.approx(true, rel=0.0015)


def test_a_map_that_is_not_known_between_its_points_is_refused_until_it_is_said():
    values = np.random.default_rng(0).standard_normal((16, 16))
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(values, size=16.0), rc.Elastic(1.0, 0.0)))
    with pytest.raises(rc.InputError, match="between='bilinear'"):
        rc.refine(problem, pressure=1e-3)
    assert rc.refine(problem, pressure=1e-3, between="bilinear").area().value > 0.0
    limits = rc.ElasticPerfectlyPlastic(1.0, 0.0, np.full((16, 16), 0.5))
    capped = rc.ContactProblem(rc.Body(rc.HeightMap(values, size=16.0, periodic=True), limits))
    with pytest.raises(rc.InputError, match="limit is an array"):
        rc.extrapolate(capped, pressure=1e-3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda p: rc.refine(3, pressure=1.0), "must be a ContactProblem"),
        (lambda p: rc.refine(p, pressure=1.0, factor=1.5), "factor"),
        (lambda p: rc.refine(p, pressure=1.0, factor=10**9), "more than memory bears"),
        (lambda p: rc.refine(p, pressure=1.0, between="nonsense"), "'bilinear'"),
        (lambda p: rc.extrapolate(p, pressure=1.0, levels=100), "more than memory bears"),
        (lambda p: rc.extrapolate(p, pressure=1.0, levels=1), "at least 2"),
        (lambda p: rc.extrapolate(p, pressure=1.0, estimator="blen"), "Did you mean 'blend'"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    problem = rc.ContactProblem(rc.Body(rc.WavySurface(1e-3, 8.0), STEEL), grid=rc.Grid((16, 16), 16.0))
    with pytest.raises(rc.InputError, match=words):
        call(problem)


def test_sums_of_surfaces_are_refined_part_by_part():
    values = 1e-3 * np.random.default_rng(0).standard_normal((32, 32))
    surface = rc.HeightMap(values, size=32.0, periodic=True) + rc.WavySurface(0.1, 32.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary="periodic")
    finer = on_grid(problem, (64, 64))
    assert finer.plan.grid.shape == (64, 64)
    coarse, fine = problem.solve(pressure=1e-4), finer.solve(pressure=1e-4)
    assert fine.approach == pytest.approx(coarse.approach, rel=0.1)


def test_a_ladder_beats_its_finest_grid_and_the_paper():
    body = rc.Body(rc.WavySurface(0.5e-6, 12.5e-6, phase=(1.0, 2.0)), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((128, 128), 250e-6), boundary="periodic")
    ladder = rc.extrapolate(problem, pressure=100e6, levels=3)
    true = 1.14192e-2
    assert ladder.area.fraction == pytest.approx(true, rel=1e-3)
    assert abs(ladder.area.fraction - true) <= 2 * ladder.area.uncertainty / problem.plan.grid.area
    assert ladder.eq_28.value / problem.plan.grid.area > 1.05 * true
    assert str(ladder).count("\n") == 4
    cold = sum(on_grid(problem, (128 << k, 128 << k)).solve(pressure=100e6).convolutions for k in range(3))
    assert ladder.convolutions < cold
