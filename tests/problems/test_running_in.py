"""Plastic flattening and running in."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from strategies import seeds

HARDNESS = 3e9
SOFT, HARD = (rc.ElasticPerfectlyPlastic(210e9, 0.3, h) for h in (HARDNESS, 2 * HARDNESS))
SIZE = 64e-6


def pair(one=SOFT, other=SOFT, seed=1, boundary="periodic", **parts):
    grid = rc.Grid((64, 64), SIZE)
    rough = [
        rc.SelfAffineSurface(hurst=0.8, rms_height=5e-8, longest=SIZE, shortest=5e-6, seed=seed + k) for k in (0, 1)
    ]
    return rc.ContactProblem(rc.Body(rough[0], one), rc.Body(rough[1], other), grid=grid, boundary=boundary, **parts)


def heights(problem):
    return [body.surface.heights(problem.plan.grid) for body in (problem.body, problem.counterbody)]


class TestOverlap:
    """The overlap remains as flattening."""

    @pytest.mark.slow
    @settings(max_examples=10, deadline=None)
    @given(seeds, st.floats(1e7, 1e9), st.sampled_from(["free", "periodic"]))
    def test_loaded_again_in_the_same_place_the_contact_is_the_same_and_elastic(self, seed, load, boundary):
        fresh = pair(seed=seed, boundary=boundary)
        first = fresh.solve(pressure=load)
        worn = rc.run_in(fresh, pressure=load, rounds=1).problem
        elastic = attrs.evolve(
            worn,
            body=attrs.evolve(worn.body, material=rc.Elastic(210e9, 0.3)),
            counterbody=attrs.evolve(worn.counterbody, material=rc.Elastic(210e9, 0.3)),
        )
        again = elastic.solve(pressure=load)
        assert again.pressure.max() <= HARDNESS * (1 + 1e-3)
        np.testing.assert_allclose(again.pressure, first.pressure, atol=2e-4 * HARDNESS)
        # First touch is deeper now by what the highest summit lost.
        lost = fresh.summit - worn.summit
        assert again.approach + lost == pytest.approx(first.approach, rel=1e-5)

    def test_one_cycle_is_shakedown(self):
        result = rc.run_in(pair(), pressure=2e8)
        assert result.shakedown
        assert len(result.cycles) == 2
        assert result.cycles[0].volume > 0
        assert result.cycles[1].volume < 1e-6 * result.cycles[0].volume
        assert "shakedown after 2 cycles" in str(result)
        # What the second cycle loses is rounding.
        assert result.cycles[1].deepest < 1e-12 * result.cycles[1].approach
        assert " 0 m " in str(result).splitlines()[-1]

    def test_what_is_flattened_bears_the_same_pressure(self):
        """The second cycle starts from the solution of the first, which is its own: two verifications remain."""
        last = rc.run_in(pair(), pressure=2e8).solution
        assert last.iterations == 0
        assert last.convolutions == 2

    def test_the_volume_is_that_of_the_overlap(self):
        problem = pair()
        solution = problem.solve(pressure=2e8)
        expected = -solution.gap[solution.saturated & (solution.gap < 0)].sum() * problem.plan.grid.cell_area
        result = rc.run_in(problem, pressure=2e8, rounds=1)
        assert result.volume == pytest.approx(expected)
        lost = sum((a - b).sum() for a, b in zip(heights(problem), heights(result.problem), strict=True))
        assert lost * problem.plan.grid.cell_area == pytest.approx(expected, rel=1e-9)

    def test_a_larger_load_flattens_more_and_a_smaller_one_after_it_nothing(self):
        light = rc.run_in(pair(), pressure=1e8, rounds=1)
        heavy = rc.run_in(pair(), pressure=3e8, rounds=1)
        assert heavy.volume > light.volume
        after = rc.run_in(heavy.problem, pressure=1e8, rounds=1)
        assert after.volume < 1e-3 * heavy.volume


class TestUniformRise:
    """The volume rises elsewhere."""

    def test_the_volume_of_each_body_is_kept_through_all_cycles(self):
        fresh = pair()
        result = rc.run_in(fresh, pressure=2e8, model="uniform-rise")
        for before, after in zip(heights(fresh), heights(result.problem), strict=True):
            assert abs((before - after).mean()) < 1e-12 * np.abs(before - after).max()
            assert not np.array_equal(before, after)

    @pytest.mark.parametrize("load", [2e8, 6e8])
    def test_the_raised_surface_takes_over_some_of_the_load(self, load):
        first, second = rc.run_in(pair(), pressure=load, model="uniform-rise").cycles
        assert second.area.value > first.area.value
        assert second.saturated.value <= first.saturated.value
        assert second.volume < 1e-4 * first.volume

    def test_a_volume_larger_than_the_gap_is_refused(self):
        ball = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), SOFT), grid=rc.Grid((64, 64), 1e-4))
        with pytest.raises(rc.InputError, match="cannot take the displaced volume"):
            rc.run_in(ball, pressure=0.9975 * HARDNESS, model="uniform-rise")

    def test_in_full_contact_the_mean_height_is_kept(self):
        problem = pair(boundary="periodic")
        solution = problem.solve(pressure=0.99 * HARDNESS)
        height_loss = rc.UniformRise().height_loss(solution)
        assert abs(height_loss.mean()) < 1e-9 * np.abs(height_loss).max()


class TestFraction:
    """Which body is flattened."""

    def test_the_softer_body_is(self):
        for one, other, lost in ((SOFT, HARD, 0), (HARD, SOFT, 1)):
            result = rc.run_in(pair(one, other), pressure=2e8, rounds=1)
            assert result.height_loss[lost].max() > 0
            assert not result.height_loss[1 - lost].any()

    def test_bodies_of_equal_hardness_share_equally(self):
        one, other = rc.run_in(pair(), pressure=2e8, rounds=1).height_loss
        np.testing.assert_allclose(one, other, atol=1e-20)

    def test_hardness_may_differ_from_place_to_place(self):
        hardness = np.full((64, 64), HARDNESS)
        hardness[:32] *= 0.5
        patchy = rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness)
        flattened = rc.run_in(pair(patchy, SOFT), pressure=2e8, rounds=1).height_loss
        assert flattened[0][:32].max() > 0
        assert not flattened[1][:32].any()
        np.testing.assert_allclose(flattened[0][32:], flattened[1][32:], atol=1e-20)

    def test_without_a_pressure_limit_nothing_is_flattened(self):
        with pytest.raises(rc.InputError, match="nothing is flattened"):
            rc.run_in(pair(rc.Elastic(1e9, 0.3), rc.Rigid()), pressure=1e6)


class TestMoving:
    """The counterbody is shifted between cycles."""

    def test_each_cycle_is_the_contact_of_the_moved_body(self):
        fresh = pair()
        shift = (5, -3)
        result = rc.run_in(fresh, pressure=2e8, shifts=[shift], rounds=1)
        one, other = heights(fresh)
        moved = rc.HeightMap(np.roll(other, shift, axis=(0, 1)), SIZE, periodic=True)
        by_hand = attrs.evolve(fresh, counterbody=rc.Body(moved, SOFT)).solve(pressure=2e8)
        np.testing.assert_array_equal(by_hand.pressure, result.solution.pressure)
        np.testing.assert_allclose(
            np.roll(result.height_loss[1], shift, axis=(0, 1)), result.height_loss[0], atol=1e-20
        )
        np.testing.assert_allclose(heights(result.problem)[0], one - result.height_loss[0], atol=1e-20)

    def test_rounds_flatten_less_and_less(self):
        result = rc.run_in(pair(), pressure=1e8, shifts=[(0, 0), (16, 0), (32, 8)], tolerance=1e-2)
        assert result.shakedown
        assert len(result.cycles) % 3 == 0
        rounds = np.array([cycle.volume for cycle in result.cycles]).reshape(-1, 3).sum(axis=1)
        assert (np.diff(rounds) < 0).all()

    def test_a_body_that_does_not_repeat_cannot_be_shifted(self):
        grid = rc.Grid((32, 32), SIZE)
        tilted = rc.HeightMap(1e-3 * (grid.x + 0.0 * grid.y), SIZE)
        problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(1e-3), SOFT), rc.Body(tilted, SOFT))
        with pytest.raises(rc.InputError, match="do not repeat along x"):
            rc.run_in(problem, force=1.0, shifts=[(1, 0)])
        assert rc.run_in(problem, force=1.0, shifts=[(0, 4)], rounds=1).cycles[0].shift == (0, 4)


class TestInterface:
    """Options, plug-ins and stopping."""

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"shifts": []}, "shifts of the counterbody"),
            ({"shifts": [(1, 2, 3)]}, "shifts of the counterbody"),
            ({"shifts": [(0.5, 1)]}, "shifts of the counterbody"),
            ({"shifts": "ab"}, "shifts of the counterbody"),
            ({"rounds": 0}, "number of rounds"),
            ({"tolerance": -1.0}, "tolerance of shakedown"),
            ({"model": "overlab"}, "Did you mean 'overlap'"),
            ({"force": 1.0}, "exactly one"),
            ({"on_cycle": 5}, "on_cycle"),
            ({"tolerance": 2.0}, "at most 1"),
        ],
    )
    def test_bad_input_is_refused_before_anything_is_solved(self, options, words, monkeypatch):
        monkeypatch.setattr(rc.ContactProblem, "solve", lambda *_, **__: pytest.fail("solved"))
        with pytest.raises(rc.InputError, match=words):
            rc.run_in(pair(), **{"pressure": 1e8, **options})

    def test_it_takes_a_problem(self):
        with pytest.raises(rc.InputError, match="must be a ContactProblem"):
            rc.run_in(rc.RIGID_FLAT, force=1.0)

    def test_an_inadmissible_load_is_refused(self):
        with pytest.raises(rc.InputError, match="more than the bodies can carry"):
            rc.run_in(pair(), pressure=1.01 * HARDNESS)

    def test_a_model_of_somebody_else(self):
        class Half(rc.FlatteningModel):
            """Half of the overlap springs back."""

            def height_loss(self, solution):
                return 0.5 * rc.Overlap().height_loss(solution)

        whole = rc.run_in(pair(), pressure=2e8, rounds=1)
        half = rc.run_in(pair(), pressure=2e8, rounds=1, model=Half())
        assert half.volume == pytest.approx(0.5 * whole.volume)
        assert len(rc.run_in(pair(), pressure=2e8, model=Half()).cycles) > 2

    def test_running_in_is_continued_from_any_cycle(self):
        shifts = [(0, 0), (16, 0), (32, 0)]
        states = []
        fresh = pair(solver=rc.solvers.resolve("projected-cg").with_tolerance(1e-8))
        whole = rc.run_in(fresh, pressure=2e8, shifts=shifts, rounds=2, tolerance=0.0, on_cycle=states.append)
        assert [len(state.cycles) for state in states] == [1, 2, 3, 4, 5, 6]
        rest = rc.run_in(states[2].problem, pressure=2e8, shifts=shifts, rounds=1, tolerance=0.0)
        # What is continued starts without the pressures of the first round: the same to the tolerance of the solver.
        deepest = max(cycle.deepest for cycle in whole.cycles)
        for one, other in zip(heights(whole.problem), heights(rest.problem), strict=True):
            np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-6 * deepest)

    @pytest.mark.parametrize(
        "height_loss",
        [None, 0.0, "a", np.zeros((3, 3)), np.zeros((1, 64)), np.full((64, 64), np.nan), np.ones((64, 64), int)],
    )
    def test_a_model_that_does_not_give_heights_is_named(self, height_loss):
        class Broken(rc.FlatteningModel):
            def height_loss(self, solution):
                return height_loss

        with pytest.raises(rc.InputError, match=r"Broken.* must give finite real heights of shape \(64, 64\)"):
            rc.run_in(pair(), pressure=2e8, model=Broken())

    def test_a_load_that_flattens_everything_is_said(self):
        ball = rc.ContactProblem(
            rc.Body(rc.SphereSurface(1e-3), SOFT), grid=rc.Grid((16, 16), 1e-4), boundary="periodic"
        )
        with pytest.raises(rc.InputError, match="flattened everything"):
            rc.run_in(ball, pressure=HARDNESS)

    def test_wear_is_refused_as_nothing_slides(self):
        worn = attrs.evolve(pair(), laws=rc.Archard("1e-16m2/N"))
        with pytest.raises(rc.InputError, match=r"remembers flattening alone, not Archard: omit it from laws="):
            rc.run_in(worn, pressure=2e8)

    def test_non_measured_points_remain_so(self):
        non_measured = np.zeros((64, 64), dtype=bool)
        non_measured[10:20, 40:50] = True
        fresh = pair()
        _one, other = heights(fresh)
        incomplete = rc.HeightMap(other, SIZE, periodic=True, non_measured=non_measured)
        result = rc.run_in(
            attrs.evolve(fresh, counterbody=rc.Body(incomplete, SOFT)), pressure=2e8, shifts=[(0, 0), (7, 0)]
        )
        np.testing.assert_array_equal(result.problem.counterbody.surface.non_measured, non_measured)
        assert not result.solution.contact[np.roll(non_measured, (7, 0), axis=(0, 1))].any()
        assert not result.height_loss[1][non_measured].any()
        refined = rc.on_grid(result.problem, tuple(2 * n for n in result.problem.plan.grid.shape)).solve(pressure=2e8)
        assert refined.force == pytest.approx(2e8 * SIZE**2)

    def test_the_plan_of_the_result_has_the_history(self):
        result = rc.run_in(pair(), pressure=2e8, rounds=1)
        assert result.problem.explain().count("run in by 1 cycles") == 2
