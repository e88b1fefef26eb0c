"""Answers of surfaces that loads before have changed: what is stated holds, or is warned of."""

from typing import ClassVar

import attrs
import numpy as np
import pytest

import roughcontact as rc

SOFT = rc.Elastic(young=1.0, poisson=0.0)
# Rules of warnings by the heights of fresh surfaces.
OF_HEIGHTS = {"resolution", "theory"}


def make_rough(shape=(64, 64), size=(1.0, 1.0), boundary="periodic", seed=1, **others):
    """Return rough heights of 8 cells in the shortest wave against a rigid flat."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, longest=1.0, shortest=1.0 / 8.0, seed=seed)
    return rc.ContactProblem(rc.Body(surface, SOFT), grid=rc.Grid(shape, size), boundary=boundary, **others)


def wear(problem, load, depth):
    """Return the last state of a path over which a height of so many approaches is lost under the contact."""
    fresh = problem.solve(pressure=load)
    distance = depth * fresh.approach * float(fresh.contact.mean()) / load
    return attrs.evolve(problem, laws=rc.Archard(1.0)).path(pressure=load, sliding=[0.0, distance])[-1]


def list_rules(warnings):
    return {getattr(text, "rule", "") for text in warnings}


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "size"), [((64, 64), (1.0, 1.0)), ((128, 64), (2.0, 1.0)), ((63, 65), (1.0, 1.0))])
def test_rims_of_worn_spots_are_not_waves_of_the_surface(shape, size):
    state = wear(make_rough(shape, size), 0.01, 1.0)
    assert not list_rules((*state.area().warnings, *state.area("level-set").warnings, *state.warnings)) & OF_HEIGHTS
    assert state.theory is None


def test_waves_that_no_grid_shows_are_still_warned_of():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, longest=1.0, shortest=1.0 / 32.0, seed=1)
    problem = rc.ContactProblem(rc.Body(surface, SOFT), grid=rc.Grid((80, 80), 1.0), boundary="periodic")
    assert "resolution" in list_rules(wear(problem, 0.01, 0.05).area().warnings)


def make_cut(cells=48, **others):
    """Return a paraboloid that a free border cuts."""
    body = rc.Body(rc.ParaboloidSurface(radius=2.0, center=(0.45, 0.1)), SOFT)
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), 1.0), **others)


@pytest.mark.slow
def test_a_worn_border_bounds_the_pressure():
    load = 0.02
    fresh = make_cut().solve(pressure=load).peak_pressure()
    assert "sharp edge" in list_rules(fresh.warnings)
    coarse, fine = (wear(make_cut(cells), load, 0.5).peak_pressure() for cells in (48, 144))
    assert "sharp edge" not in list_rules(coarse.warnings)
    assert coarse.uncertainty < 0.2 * coarse.value
    assert abs(coarse.value - fine.value) <= 2.0 * coarse.uncertainty


def test_a_border_hardly_worn_is_warned_of():
    assert "sharp edge" in list_rules(wear(make_cut(), 0.02, 1e-4).peak_pressure().warnings)


def test_a_body_that_creeps_keeps_its_border():
    body = rc.Body(rc.ParaboloidSurface(radius=2.0, center=(0.45, 0.1)), rc.Viscoelastic([0.3, 0.7], [1.0], 0.0))
    problem = rc.ContactProblem(body, grid=rc.Grid((48, 48), 1.0))
    state = problem.path(pressure=0.01, time=[0.0, 1.0])[-1]
    assert "sharp edge" in list_rules(state.peak_pressure().warnings)


def test_a_border_that_was_flattened_has_no_singular_pressure():
    """Its approach is that of cells of a third; the correction for a cut border errs by five uncertainties."""
    soft = rc.ElasticPerfectlyPlastic(young=1.0, poisson=0.0, hardness=0.03)
    states = []
    for cells in (48, 144):
        problem = make_cut(cells)
        problem = attrs.evolve(problem, body=attrs.evolve(problem.body, material=soft))
        states.append(problem.path(pressure=[0.02, 0.012])[-1])
    for name in ("approach", "mean-gap"):
        coarse, fine = (state.response(name) for state in states)
        assert abs(coarse.value - fine.value) <= 2.0 * coarse.uncertainty
    assert "sharp edge" not in list_rules(states[0].peak_pressure().warnings)


def test_an_estimator_that_expects_more_is_warned_of():
    state = wear(make_rough(), 0.01, 0.5)
    for name in ("level-set", "level-set-richardson", "hertz"):
        assert "changed surfaces" in list_rules(state.area(name).warnings)
        gap = state.response(rc.responses.create("mean-gap", estimator=name))
        assert "changed surfaces" in list_rules(gap.warnings)
    for name in ("cell-count", "perimeter"):
        assert "changed surfaces" not in list_rules(state.area(name).warnings)
    for name in rc.areas:
        assert "changed surfaces" not in list_rules(make_rough().solve(pressure=0.01).area(name).warnings)
    assert state.area("blend").estimator == "cell-count"


@pytest.mark.parametrize("first", [0, 1])
def test_the_order_of_laws_does_not_choose_the_area(first):
    laws = (rc.Flattening(), rc.Archard(0.1))
    soft = rc.ElasticPerfectlyPlastic(young=1.0, poisson=0.0, hardness=0.05)
    body = rc.Body(rc.ParaboloidSurface(radius=2.0), soft)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1.0), laws=(laws[first], laws[1 - first]))
    state = problem.path(force=0.01, sliding=[0.0, 0.1, 0.2])[-1]
    assert state.area().estimator == "cell-count"


@attrs.frozen
class Swelling(rc.Process):
    """Heights that grow where the surfaces do not touch."""

    remembered: ClassVar = {"swollen": ("height gained", "m")}
    rates: ClassVar = ("time",)

    def change_gap(self, problem, increment, memory):
        return -memory["swollen"]

    def remember(self, state, increment, memory):
        return {"swollen": memory["swollen"] + 1e-4 * increment.time * ~state.contact}


def test_a_process_of_ones_own_is_not_judged_by_summits():
    body = rc.Body(rc.ParaboloidSurface(radius=2.0), SOFT)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1.0), laws=Swelling())
    fresh, *_, changed = problem.path(force=0.01, time=[0.0, 1.0, 2.0])
    assert [state.area().estimator for state in (fresh, changed)] == ["blend", "level-set"]


def test_points_that_were_not_measured_do_not_hide_the_change():
    grid = rc.Grid((48, 48), 1.0)
    heights = -(grid.x**2 + grid.y**2) / 4.0
    lost = np.zeros(grid.shape, dtype=bool)
    lost[2, 3] = True
    peaks = []
    for missing in (None, lost):
        body = rc.Body(rc.HeightMap(heights, grid.size, non_measured=missing), SOFT)
        peaks.append(wear(rc.ContactProblem(body), 0.01, 0.5).peak_pressure())
    assert peaks[1].value == pytest.approx(peaks[0].value, rel=1e-4)
    assert peaks[1].uncertainty == pytest.approx(peaks[0].uncertainty, rel=1e-2)
