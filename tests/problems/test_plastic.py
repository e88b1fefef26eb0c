"""Elastic-perfectly-plastic contact, from the first saturated point to a bearing area."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from strategies import height_maps, seeds

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "studies"))
from capped_ball import HARDNESS, MODULUS, RADIUS, STEEL, YIELD, ball, rings


def test_the_first_point_saturates_at_the_load_of_first_yield():
    """F = pi^3 R^2 H^3 / (6 E*^2): the load at which Hertz's maximum pressure is the limit."""
    assert not ball(255, 0.99 * YIELD).saturated.any()
    above = ball(255, 1.01 * YIELD)
    assert above.saturated.any()
    assert above.saturated_area().value < 0.05 * above.area().value


@pytest.mark.parametrize("times", [1.5, 3.0, 10.0])
def test_a_capped_ball_agrees_with_rings(times):
    force = times * YIELD
    solution = ball(256, force, (0.3, -0.2))
    approach, area, saturated = rings(force)
    assert solution.force == pytest.approx(force, rel=1e-12)
    assert solution.approach == pytest.approx(approach, rel=2e-3)
    # A ring more or less is 0.5 to 1 % of the areas.
    assert solution.area().value == pytest.approx(area, rel=8e-3)
    assert solution.saturated_area().value == pytest.approx(saturated, rel=2.5e-2)


def test_a_very_soft_ball_is_fully_plastic():
    """Far above first yield A = F/H, and the approach grows to that of the bearing area, A = 2 pi R d, Johnson 6.3."""
    solution = ball(256, 3000 * YIELD)
    area = solution.area().value
    assert area == pytest.approx(solution.force / HARDNESS, rel=5e-3)
    elastic = 4 * HARDNESS * np.sqrt(area / np.pi) / (np.pi * MODULUS)
    assert solution.approach - elastic == pytest.approx(area / (2 * np.pi * RADIUS), rel=0.03)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(height_maps(16), st.floats(0.05, 0.95), st.sampled_from(["free", "periodic"]))
def test_vanishing_hardness_is_the_bearing_area(surface, share, boundary):
    """Deflection is nothing beside the peak-to-valley height: the highest cells carry the hardness, the others none."""
    ties = np.unique(surface.values).size < surface.values.size
    slope = np.ptp(surface.values) / max(surface.size)
    soft = rc.ElasticPerfectlyPlastic(1.0, 0.3, 1e-9 * slope)
    problem = rc.ContactProblem(rc.Body(surface, soft), boundary=boundary)
    count = max(1, round(share * surface.values.size))
    mean = soft.hardness * count / surface.values.size
    solution = problem.solve(pressure=mean, throw=False)
    carried = np.sort(solution.pressure.ravel())[::-1]
    assert solution.area("cell-count").value >= count * surface.grid.cell_area * (1 - 1e-9)
    if not ties and solution.status.success:
        heights = surface.values.ravel()
        highest = np.argsort(heights)[::-1]
        gaps = -np.diff(heights[highest])
        # A deflection of 1e-9 of the peak-to-valley height moves neighbours in rank that are closer than that.
        if gaps[count - 1 : count].min(initial=np.inf) > 1e-6 * np.ptp(heights):
            assert set(np.flatnonzero(solution.pressure.ravel() > 0)) == set(highest[:count])
            np.testing.assert_allclose(carried[:count], soft.hardness, rtol=1e-9)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(seeds, st.floats(1e-3, 3.0), st.sampled_from(["free", "periodic"]), st.sampled_from(["force", "approach"]))
@example(110, 0.0625, "free", "force")
def test_a_limit_above_the_elastic_maximum_changes_no_bit(seed, above, boundary, control):
    grid = rc.Grid((64, 48), (1e-4, 0.75e-4))
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=5e-8, longest=1e-4, shortest=6e-6, seed=seed)
    load = {"force": 2.0} if control == "force" else {"approach": 8e-8}

    def solved(material):
        return rc.ContactProblem(rc.Body(rough, material), grid=grid, boundary=boundary).solve(**load)

    elastic = solved(rc.Elastic(210e9, 0.3))
    capped = solved(rc.ElasticPerfectlyPlastic(210e9, 0.3, elastic.pressure.max() * (1 + above)))
    np.testing.assert_array_equal(capped.pressure, elastic.pressure)
    assert capped.approach == elastic.approach
    assert capped.saturated_area().value == 0.0


def rough_pair(cells, force):
    size = 264.2e-6
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=0.2e-6, longest=size, rolloff=40e-6, shortest=size / 32, seed=3)
    bodies = rc.Body(rc.SphereSurface(RADIUS), STEEL), rc.Body(rough, STEEL)
    return rc.ContactProblem(*bodies, grid=rc.Grid((cells, cells), size)).solve(force=force)


@pytest.mark.slow
def test_saturated_area_of_a_rough_pair_converges_within_its_bar():
    fine = rough_pair(1024, 20.0).saturated_area()
    for cells in (256, 512):
        coarse = rough_pair(cells, 20.0).saturated_area()
        assert abs(coarse.value - fine.value) < 2 * coarse.uncertainty
        assert coarse.value == pytest.approx(fine.value, rel=0.04 if cells == 256 else 0.02)


def test_contact_and_saturated_area_meet_when_everything_flows():
    solution = ball(128, 3000 * YIELD)
    assert solution.saturated_area().value <= solution.area().value * (1.0 + 1e-12)
    assert solution.saturated_area().value == pytest.approx(solution.area().value, rel=0.05)


def test_the_summary_tells_the_saturated_area():
    assert "saturated" in str(ball(64, 2 * YIELD))
    elastic = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(RADIUS), rc.Elastic(210e9, 0.3)), grid=rc.Grid((8, 8), 1e-4)
    )
    assert "saturated" not in str(elastic.solve(force=1.0))


def test_a_load_of_a_sweep_that_cannot_be_carried_is_refused_before_anything_is_solved(monkeypatch):
    grid = rc.Grid((16, 16), 1e-4)
    problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(RADIUS), STEEL), grid=grid)
    solved = []
    monkeypatch.setattr(rc.ProjectedConjugateGradient, "solve", lambda *_: solved.append(1))
    with pytest.raises(rc.InputError, match=r"at most 6 GPa, that is 60 N"):
        problem.sweep(force=[1.0, 2.0, 61.0])
    assert not solved


class TestFirstLoadings:
    """Several loads with a hardness are first loadings each, and everything that prints them says so."""

    def problem(self, hardness):
        material = rc.Elastic(210e9, 0.3) if hardness is None else rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness)
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=4e-7, shortest=1e-5, longest=1e-4, seed=1)
        return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid((32, 48), 1e-4), boundary="periodic")

    def test_a_smaller_load_does_not_know_the_larger_one(self):
        problem = self.problem(2e9)
        small, _ = problem.sweep(pressure=[5e7, 3e8])
        alone = problem.solve(pressure=5e7).area()
        assert small.area().value == pytest.approx(alone.value, rel=1e-3)
        (after,) = rc.run_in(problem, pressure=3e8).problem.sweep(pressure=[5e7])
        assert after.area().value > 1.5 * alone.value

    @pytest.mark.slow
    @pytest.mark.parametrize(("hardness", "count"), [(2e9, 1), (None, 0)])
    def test_it_is_said_where_there_is_a_hardness(self, hardness, count, tmp_path):
        problem, loads = self.problem(hardness), [5e7, 7.5e7]
        sweep = problem.sweep(pressure=loads)
        study = rc.Study(problem, pressure=loads)
        texts = [problem.explain(), sweep, sweep._repr_html_(), rc.interface_law(problem, loads), study.explain()]
        for text in (*texts, study.run(tmp_path)):
            assert str(text).count("is a first loading") == count
        # The table, and the plan.
        assert sweep.to_html().count("is a first loading") == 2 * count
        assert "first loading" not in str(problem.sweep(pressure=[5e7]))
