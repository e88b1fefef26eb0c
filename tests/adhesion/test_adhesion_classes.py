"""Pull-off and areas of balls with adhesion beside those of the same law on rings; two solvers on random contacts."""

from __future__ import annotations

import itertools
import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import adhesion_classes
from adhesion_reference import RADIUS, WORK, find_answer, load_answers, make_laws
from adhesion_solvers import compare_solvers, find_seeds

import roughcontact as rc
from roughcontact.reference import JKR, MaugisDugdale
from scenes import rather_slow

BALL = JKR(RADIUS, 1.0, WORK)


def judge(name, split, number):
    """Return errors over what is stated, of the first cases of a class."""
    found = []
    for case in itertools.islice(adhesion_classes.CLASSES[name](split), number):
        estimate = case.ask(case.problem)
        found.append((estimate.value - case.true) / math.hypot(estimate.uncertainty, case.std * case.true))
    return np.abs(found)


def test_errors_of_balls_in_random_places():
    errors = judge("area-wrapped", "held-out", 10)
    assert np.mean(errors <= 2.0) >= 0.9
    assert 0.1 < np.median(errors) < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("name", list(adhesion_classes.CLASSES))
def test_coverage_of_a_class(name):
    errors = judge(name, "held-out", adhesion_classes.CASES)
    assert np.mean(errors <= 2.0) >= 0.93
    assert 0.15 < np.median(errors) < 1.0


def test_rings_know_the_ball_of_maugis():
    for name, smoothing in (("Dugdale 0.35 0.2", 0.2), ("Dugdale 1 0.2", 0.2), ("Dugdale 1.9 0.2", 0.2)):
        law = make_laws()[name][0]
        exact = MaugisDugdale(RADIUS, 1.0, WORK, law.strength)
        found = load_answers()[name]
        assert law.smoothing == smoothing
        assert found.pull_off == pytest.approx(exact.pull_off, rel=2e-3)
        assert found.area == pytest.approx(math.pi * exact.radius_at_zero_load**2, rel=2e-3)


@pytest.mark.slow
def test_the_answers_in_the_file_are_those_of_rings():
    name = "Dugdale 1 0.5"
    found = find_answer(*make_laws()[name])
    assert found.pull_off == pytest.approx(load_answers()[name].pull_off, rel=1e-6)
    assert found.area == pytest.approx(load_answers()[name].area, rel=1e-5)


def make_short_range(cells, boundary="free"):
    body = rc.Body(rc.ParaboloidSurface(RADIUS, (0.3 / cells, -0.2 / cells)), rc.Elastic(1.0, 0.0))
    shape = (math.ceil(3.2 * cells), math.ceil(3.2 * cells) + 1)
    grid = rc.Grid(shape, (shape[0] / cells, shape[1] / cells))
    return rc.ContactProblem(body, grid=grid, boundary=boundary, adhesion=rc.ShortRange(WORK))


@pytest.mark.slow
def test_pull_off_without_a_range_is_that_of_johnson():
    problem = make_short_range(20.0)
    found = problem.pull_off()
    assert abs(found.value - BALL.pull_off) < 2.0 * found.uncertainty
    assert found.value == pytest.approx(BALL.pull_off, rel=0.015)
    assert found.uncertainty < 0.03 * abs(found.value)
    # The law itself, of the range that the cells resolve, pulls more, and its uncertainty says by how much.
    approach = np.linspace(-1.1, 0.3, 15) / RADIUS
    pulled = problem.cycle(approach=approach + problem.summit).pull_off
    assert pulled.value < 1.03 * BALL.pull_off
    assert 0.9 < pulled.uncertainty / abs(pulled.value - BALL.pull_off) < 1.5


def test_straight_edges_along_the_cells_are_not_extrapolated():
    x = rc.Grid((64, 4), (64.0, 4.0)).x
    heights = np.broadcast_to(np.cos(2.0 * np.pi * x / 64.0), (64, 4))
    problems = [
        rc.ContactProblem(
            rc.Body(rc.HeightMap(map_, size), rc.Elastic(1.0, 0.0)), boundary="periodic", adhesion=rc.ShortRange(0.01)
        )
        for map_, size in ((heights, (64.0, 4.0)), (heights.T.copy(), (4.0, 64.0)))
    ]
    first, second = (problem.pull_off() for problem in problems)
    law = problems[0].plan.interaction
    shortest = rc.ContactProblem(problems[0].body, boundary="periodic", adhesion=law).pull_off()
    assert first.value == pytest.approx(shortest.value, rel=1e-12)
    assert first.uncertainty > shortest.uncertainty
    assert second.value == pytest.approx(first.value, rel=1e-5)
    assert second.uncertainty == pytest.approx(first.uncertainty, rel=1e-3)


def test_the_error_of_areas_falls_with_the_cells():
    law = make_laws()["Exponential 1"][0]
    stated = []
    for cells in (6.0, 12.0, 24.0):
        body = rc.Body(rc.ParaboloidSurface(RADIUS, (0.3 / cells, 0.1 / cells)), rc.Elastic(1.0, 0.0))
        shape = (math.ceil(4.0 * cells),) * 2
        problem = rc.ContactProblem(body, grid=rc.Grid(shape, shape[0] / cells), adhesion=law)
        area = problem.solve(force=0.0).area()
        assert abs(area.value - load_answers()["Exponential 1"].area) < 2.5 * area.uncertainty
        stated.append(area.uncertainty / area.value)
    assert stated[0] > 2.0 * stated[1] > 4.0 * stated[2]


SEEDS = find_seeds(20, 1000)


@pytest.mark.parametrize("seed", rather_slow(SEEDS, SEEDS[::4]))
def test_two_solvers_find_the_same_contact(seed):
    found = compare_solvers(seed)
    assert found.statuses in {("CONVERGED", "CONVERGED"), ("SEPARATED", "SEPARATED")}
    if found.statuses[0] == "CONVERGED":
        assert found.different == 0
        assert all(found.certified)
        assert abs(found.energy) < 1e-4
