"""Two measured bodies: placed, matched, separated from their form, solved."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from strategies import measured_pairs, seeds

STEEL = rc.ElasticPerfectlyPlastic(210e9, 0.3, 6e9)
TIGHT = rc.ProjectedConjugateGradient(tolerance=1e-14)


def cut_map(shape, size, seed=0, rms=5e-8):
    """A smooth random map that is not periodic: a part of a larger self-affine one."""
    larger = rc.Grid((2 * shape[0], 2 * shape[1]), (2 * size[0], 2 * size[1]))
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_height=rms, longest=max(larger.size), shortest=8 * max(larger.spacing), seed=seed
    )
    return rc.HeightMap(surface.heights(larger)[: shape[0], : shape[1]], size)


class TestPlacedMap:
    """A map placed elsewhere has the same heights."""

    def test_a_map_in_its_own_place_is_itself(self):
        surface = cut_map((24, 32), (3e-5, 4e-5))
        for method in ("bilinear", "cubic"):
            placed = rc.PlacedMap(surface, interpolation=method)
            np.testing.assert_allclose(placed.heights(surface.grid), surface.values, rtol=1e-9, atol=1e-20)

    def test_a_quarter_turn_is_counter_clockwise(self):
        surface = cut_map((24, 32), (3e-5, 4e-5))
        turned = rc.PlacedMap(surface, rotation=math.pi / 2).heights(rc.Grid((32, 24), (4e-5, 3e-5)))
        # A summit on the +x axis goes to the +y axis.
        np.testing.assert_allclose(turned, surface.values.T[::-1], atol=1e-18)

    def test_turning_over_exchanges_left_and_right(self):
        surface = cut_map((24, 32), (3e-5, 4e-5))
        np.testing.assert_allclose(
            rc.PlacedMap(surface, mirrored=True).heights(surface.grid), surface.values[::-1], atol=1e-18
        )

    def test_the_offset_is_where_the_centre_lies(self):
        heights = np.zeros((31, 31))
        heights[15, 15] = 1.0
        grid = rc.Grid((21, 21), 21e-6)
        moved = rc.PlacedMap(rc.HeightMap(heights, 31e-6), offset=(4e-6, -2e-6)).heights(grid)
        assert np.unravel_index(moved.argmax(), moved.shape) == (14, 8)

    @pytest.mark.parametrize(("method", "order"), [("bilinear", 2), ("cubic", 4)])
    def test_interpolation_has_its_order(self, method, order):
        wave = rc.WavySurface(1e-7, (3e-5, 4e-5), phase=(0.3, 1.1))
        target = rc.Grid((40, 40), 2e-5)
        errors = []
        for cells in (64, 128, 256):
            source = rc.HeightMap(wave.heights(rc.Grid((cells, cells), 6e-5)), 6e-5)
            placed = rc.PlacedMap(source, offset=(3e-6, 1e-6), interpolation=method)
            grid = attrs.evolve(target)
            true = 1e-7 * (
                np.cos(2 * np.pi * (grid.x - 3e-6) / 3e-5 + 0.3) + np.cos(2 * np.pi * (grid.y - 1e-6) / 4e-5 + 1.1)
            )
            errors.append(np.abs(placed.heights(grid) - true).max())
        assert math.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.25)

    @settings(max_examples=20, deadline=None)
    @given(seeds, st.integers(8, 21), st.integers(8, 21), st.floats(-1, 1), st.floats(-1, 1))
    def test_fourier_is_exact_on_periodic_maps(self, seed, nx, ny, dx, dy):
        size = (nx * 1e-6, ny * 1.3e-6)
        grid = rc.Grid((nx, ny), size)
        surface = rc.SelfAffineSurface(hurst=0.5, rms_height=1e-7, longest=1e-3, shortest=3.2e-6, seed=seed)
        periodic = rc.HeightMap(surface.heights(grid), size, periodic=True)
        fine = rc.Grid((3 * nx, 3 * ny), size)
        offset = (3 * fine.spacing[0], -6 * fine.spacing[1])
        placed = rc.PlacedMap(periodic, offset=offset, interpolation="fourier").heights(fine)
        np.testing.assert_allclose(placed, np.roll(surface.heights(fine), (3, -6), axis=(0, 1)), atol=1e-18)

    def test_a_grid_that_the_map_does_not_cover_is_refused(self):
        surface = cut_map((24, 32), (3e-5, 4e-5))
        with pytest.raises(rc.InputError, match="does not cover"):
            rc.PlacedMap(surface, offset=(1e-6, 0)).heights(surface.grid)
        with pytest.raises(rc.InputError, match="does not cover"):
            rc.PlacedMap(surface).heights(rc.Grid((2, 2), (4e-5, 4e-5)))
        with pytest.raises(rc.InputError, match="Fourier interpolation needs a periodic map"):
            rc.PlacedMap(surface, interpolation="fourier")


class TestMatch:
    """The common grid of two maps."""

    def test_the_overlap_of_two_rectangles(self):
        one, other = rc.HeightMap(np.eye(10), (10e-6, 8e-6)), rc.HeightMap(np.eye(20), (10e-6, 4e-6))
        pair = rc.match(one, other, offset=(3e-6, 1e-6))
        np.testing.assert_allclose(pair.grid.size, (7e-6, 4e-6))
        assert pair.grid.shape == (14, 20)
        # The domain's centre lies at (1.5, 1) um of the first map.
        np.testing.assert_allclose(pair.body.offset, (-1.5e-6, -1e-6))
        np.testing.assert_allclose(pair.counterbody.offset, (1.5e-6, 0.0), atol=1e-20)

    def test_two_squares_at_45_degrees(self):
        """|x| + |y| <= side / sqrt 2 leaves a rectangle of half the square's area."""
        one = rc.HeightMap(np.eye(16), 1e-5)
        pair = rc.match(one, one, rotation=math.pi / 4)
        np.testing.assert_allclose(pair.grid.size, (1e-5 / math.sqrt(2),) * 2, rtol=1e-4)

    def test_a_large_map_covers_a_small_one_at_any_angle(self):
        large, small = rc.HeightMap(np.eye(64), 64e-6), rc.HeightMap(np.eye(20), (10e-6, 20e-6))
        for angle in (0.0, 0.2, 1.0, 3.0):
            pair = rc.match(small, large, rotation=angle)
            np.testing.assert_allclose(pair.grid.size, small.size, rtol=2e-6)
            assert pair.grid.shape[0] >= 20

    @pytest.mark.slow
    @settings(max_examples=60, deadline=None)
    @given(measured_pairs())
    def test_both_maps_cover_the_common_grid_and_no_larger_one(self, drawn):
        one, other, placing = drawn
        pair = rc.match(one, other, **placing)
        for surface in (pair.body, pair.counterbody):
            assert np.isfinite(surface.heights(pair.grid)).all()
        for larger in ((1.01, 1.0), (1.0, 1.01)):
            with pytest.raises(rc.InputError, match="overlap on"):
                rc.match(one, other, size=tuple(np.array(pair.grid.size) * larger), **placing)

    def test_a_huge_map_under_a_small_one(self):
        small = rc.HeightMap(np.eye(64), 10e-6)
        for size in (1e-3, 1.0, 10.0):
            pair = rc.match(small, rc.HeightMap(np.eye(64), size), rotation=0.3, shape=(64, 64))
            assert 10e-6 * (1 - 3e-6) < pair.grid.size[0] <= 10e-6 * (1 + 1e-12)

    def test_a_grid_beyond_memory_is_refused(self):
        one = rc.HeightMap(np.eye(16), 1.0)
        with pytest.raises(rc.InputError, match=r"2\^40 cells"):
            rc.match(one, rc.HeightMap(np.eye(16), 1e-6, periodic=True))
        with pytest.raises(rc.InputError, match="TiB of memory"):
            one.resample((10**6, 10**6))

    def test_degrees_are_not_radians(self):
        one = rc.HeightMap(np.eye(16), 1.0)
        with pytest.raises(rc.InputError, match=r"np\.deg2rad"):
            rc.match(one, one, rotation=20)

    def test_maps_apart_are_refused(self):
        one = rc.HeightMap(np.eye(16), 1e-5)
        for angle in (0.0, 0.3):
            with pytest.raises(rc.InputError, match="do not overlap"):
                rc.match(one, one, offset=(3e-5, 0), rotation=angle)

    def test_periodic_maps_cover_the_plane(self):
        periodic = rc.HeightMap(np.eye(16), 1e-5, periodic=True)
        single = rc.HeightMap(np.eye(16), 3e-5)
        assert rc.match(single, periodic, offset=(1e-3, 0.0)).grid.size == single.size
        assert rc.match(periodic, periodic, offset=(1e-3, 0.0)).grid.size == periodic.size
        assert rc.match(periodic, single, offset=(1e-3, 0.0)).grid.size == single.size

    def test_it_takes_maps(self):
        with pytest.raises(rc.InputError, match="Each side of a pair must be a HeightMap"):
            rc.match(rc.FlatSurface(), rc.HeightMap(np.eye(4), 1.0))


def contact(one, other, grid=None, force=4.0):
    return rc.ContactProblem(rc.Body(one, STEEL), rc.Body(other, STEEL), grid=grid, solver=TIGHT).solve(force=force)


def assert_same(one, other, change=lambda field: field):
    """Pressure and gap agree to 1e-12 of their maxima, and so do areas and approaches."""
    top = one.pressure.max()
    np.testing.assert_allclose(change(other.pressure), one.pressure, rtol=0, atol=1e-12 * top)
    np.testing.assert_allclose(change(other.gap), one.gap, rtol=0, atol=1e-12 * np.abs(one.gap).max())
    assert other.approach == pytest.approx(one.approach, rel=1e-12)
    assert other.area().value == pytest.approx(one.area().value, rel=1e-9)
    assert other.saturated_area().value == pytest.approx(one.saturated_area().value, rel=1e-9)


def test_maps_of_different_pitch_and_unit_are_as_if_brought_to_one_grid_by_hand(tmp_path):
    """One map in micrometres on 0.5 um, the other in metres on 1 um, on larger ground, lying askew by whole cells."""
    fine, coarse = cut_map((64, 64), (32e-6, 32e-6), 1), cut_map((60, 50), (60e-6, 50e-6), 2)
    np.savetxt(tmp_path / "fine.txt", 1e6 * fine.values, fmt="%.18g")
    read = rc.read_surface(tmp_path / "fine.txt", size=32e-6, unit=1e-6)
    pair = rc.match(read, coarse, offset=(3e-6, 4e-6))
    assert pair.grid.shape == (64, 64)
    # By hand: the ground twice as fine, cut out where the small map lies.
    ground = coarse.resample((120, 100)).values
    first = (60 - 3 * 2 - 32, 50 - 4 * 2 - 32)
    cut = rc.HeightMap(ground[first[0] : first[0] + 64, first[1] : first[1] + 64], 32e-6)
    assert_same(contact(fine, cut), contact(pair.body, pair.counterbody, pair.grid))


@pytest.fixture(scope="module")
def bodies():
    """Two maps and a sphere that saturates some cells."""
    one, other = cut_map((96, 80), (96e-6, 80e-6), 3, rms=3e-7), cut_map((96, 80), (96e-6, 80e-6), 4, rms=2e-7)
    return rc.SphereSurface(5e-3), one, other


def test_swapping_the_bodies_changes_nothing(bodies):
    ball, one, other = bodies
    first, second = contact(ball + one, other), contact(other, ball + one)
    assert first.saturated.any()
    assert_same(first, second)


def test_mirroring_both_bodies_mirrors_the_solution(bodies):
    ball, one, other = bodies
    mirrored = [rc.HeightMap(part.values[::-1], part.size) for part in (one, other)]
    assert_same(contact(ball + one, other), contact(ball + mirrored[0], mirrored[1]), lambda field: field[::-1])


def test_exchanging_the_roughness_of_bodies_of_equal_material_changes_nothing(bodies):
    ball, one, other = bodies
    assert_same(contact(ball + one, other), contact(ball + other, one))


class TestForm:
    """Form separated from roughness."""

    @pytest.mark.parametrize("radius", [3e-3, 2e-4, -1e-3])
    def test_a_sphere_is_found_wherever_its_summit_lies(self, radius):
        grid = rc.Grid((40, 30), (8e-5, 6e-5))
        sphere = np.sign(radius) * rc.SphereSurface(abs(radius), center=(3e-5, -1e-5)).heights(grid)
        found = rc.HeightMap(sphere + 1e-6, grid.size).separate("sphere")
        assert found.radius == pytest.approx(radius, rel=1e-9)
        assert np.abs(found.roughness.values).max() < 1e-9 * np.ptp(sphere)

    @pytest.mark.parametrize("share", [0.8, 0.95])
    def test_steep_caps_are_spheres_too(self, share):
        grid = rc.Grid((40, 40), 1e-4)
        cap = rc.SphereSurface(0.5e-4 * math.sqrt(2) / share).heights(grid)
        assert rc.HeightMap(cap, 1e-4).separate("sphere").radius == pytest.approx(0.5e-4 * math.sqrt(2) / share)

    def test_a_flat_map_has_an_infinite_radius(self):
        assert rc.HeightMap(np.full((64, 64), 3.3e-6), 1e-4).separate("sphere").radius == math.inf

    def test_roughness_of_a_ball_is_what_was_put_on_it(self):
        bumps = cut_map((64, 64), (1e-4, 1e-4), 5).detrend(2)
        parts = rc.HeightMap(bumps.values + rc.SphereSurface(5e-3).heights(bumps.grid), 1e-4).separate("sphere")
        assert parts.radius == pytest.approx(5e-3, rel=2e-3)
        assert np.std(parts.roughness.values - bumps.values) < 0.02 * bumps.values.std()

    @pytest.mark.parametrize("form", ["mean", "plane", "sphere", 0, 1, 3])
    def test_both_parts_make_the_map(self, form):
        surface = cut_map((24, 32), (3e-5, 4e-5))
        parts = surface.separate(form)
        np.testing.assert_allclose(parts.form.values + parts.roughness.values, surface.values, atol=1e-20)
        np.testing.assert_array_equal(surface.detrend(form).values, parts.roughness.values)
        assert parts.radius == math.inf or form == "sphere"

    @pytest.mark.parametrize("form", ["plane", "sphere", 2])
    def test_non_measured_points_do_not_count(self, form):
        grid = rc.Grid((40, 30), (8e-5, 6e-5))
        true = rc.SphereSurface(3e-3).heights(grid) if form != "plane" else 1e-3 * grid.x + 0.0 * grid.y
        non_measured = np.zeros(grid.shape, dtype=bool)
        non_measured[:12, :9] = True
        broken = rc.HeightMap(np.where(non_measured, 7e-6, true), grid.size, non_measured=non_measured)
        left = broken.detrend(form).values[~non_measured]
        assert np.abs(left).max() < (1e-4 if form == 2 else 1e-10) * np.ptp(true)

    def test_an_unknown_or_undetermined_form_is_refused(self):
        surface = rc.HeightMap(np.eye(4), 1.0)
        for form in ("ball", 1.5, -1, None):
            with pytest.raises(rc.InputError):
                surface.separate(form)
        with pytest.raises(rc.InputError, match="three cells"):
            rc.HeightMap(np.eye(2), 1.0).separate("sphere")
        with pytest.raises(rc.InputError, match="at most 30"):
            rc.HeightMap(np.ones((64, 64)), 1.0).separate(31)
        few = np.ones((64, 64), dtype=bool)
        few[3, 3:6] = False
        for form in ("sphere", 6):
            with pytest.raises(rc.InputError, match="Too few points"):
                rc.HeightMap(np.random.default_rng(0).random((64, 64)), 1.0, non_measured=few).separate(form)
        steep = rc.HeightMap(10.0 * np.abs(rc.Grid((9, 9), 1.0).x + np.zeros((1, 9))), 1.0)
        with pytest.raises(rc.InputError, match="No sphere fits"):
            steep.separate("sphere")


class TestNonMeasured:
    """Points that were not measured, and do not touch."""

    def test_they_never_touch(self):
        surface = cut_map((48, 48), (48e-6, 48e-6), 6)
        top = surface.values > np.quantile(surface.values, 0.98)
        complete, incomplete = (
            rc.ContactProblem(rc.Body(rc.HeightMap(surface.values, 48e-6, non_measured=non_measured), STEEL)).solve(
                force=0.05
            )
            for non_measured in (None, top)
        )
        assert complete.contact[top].any()
        assert not incomplete.contact[top].any()
        assert incomplete.force == pytest.approx(0.05)

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    @pytest.mark.parametrize("load", [{"force": 0.1}, {"force": 40.0}, {"approach": 1e-7}])
    def test_they_do_not_touch_under_any_load(self, boundary, load):
        """A region without data under the middle of a ball, in a map that is nearly flat."""
        non_measured = np.zeros((64, 64), dtype=bool)
        non_measured[24:40, 24:40] = True
        flat = rc.HeightMap(cut_map((64, 64), (64e-6, 64e-6), rms=1e-9).values, 64e-6, non_measured=non_measured)
        problem = rc.ContactProblem(rc.Body(flat + rc.SphereSurface(1e-3), rc.Elastic(1e11, 0.3)), boundary=boundary)
        solution = problem.solve(**load)
        assert solution.contact.any()
        assert not solution.contact[non_measured].any()
        assert (solution.gap[non_measured] > 0).all()

    def test_those_of_either_body_count(self):
        non_measured = np.zeros((32, 32), dtype=bool)
        non_measured[3, 4] = True
        one = cut_map((32, 32), (32e-6, 32e-6), 1)
        for first, second in ((non_measured, None), (None, non_measured), (non_measured, non_measured.T)):
            bodies = [rc.Body(rc.HeightMap(one.values, 32e-6, non_measured=mask), STEEL) for mask in (first, second)]
            plan = rc.ContactProblem(*bodies).plan
            expected = np.logical_or.reduce([mask for mask in (first, second) if mask is not None])
            np.testing.assert_array_equal(plan.non_measured, expected)
        half = np.arange(32)[:, None] + np.zeros((1, 32)) < 16
        halves = [rc.Body(rc.HeightMap(one.values, 32e-6, non_measured=mask), STEEL) for mask in (half, ~half)]
        with pytest.raises(rc.InputError, match="Nowhere do measured points"):
            rc.ContactProblem(*halves)

    def test_they_stay_where_they_are(self):
        non_measured = np.zeros((40, 40), dtype=bool)
        non_measured[8:16, 20:28] = True
        surface = rc.HeightMap(cut_map((40, 40), (4e-5, 4e-5)).values, 4e-5, non_measured=non_measured)
        for method in ("bilinear", "cubic", "mean"):
            half = surface.resample((20, 20), method).non_measured
            np.testing.assert_array_equal(half, non_measured[::2, ::2])
        np.testing.assert_array_equal(
            rc.PlacedMap(surface, mirrored=True).non_measured_on(surface.grid), non_measured[::-1]
        )
        np.testing.assert_array_equal(surface.detrend().non_measured, non_measured)

    def test_a_bad_mask_is_refused(self):
        for non_measured, words in (
            (np.ones((4, 4), dtype=bool), "at least one is needed"),
            (np.zeros((3, 4), dtype=bool) | np.eye(3, 4, dtype=bool), "shape"),
            (np.eye(4), "booleans"),
        ):
            with pytest.raises(rc.InputError, match=words):
                rc.HeightMap(np.eye(4), 1.0, non_measured=non_measured)

    def test_a_file_with_non_measured_points(self, tmp_path):
        values = cut_map((12, 12), (1e-5, 1e-5)).values.copy()
        values[3, 4] = np.nan
        np.savez(tmp_path / "map.npz", heights=values, size=1e-5)
        surface = rc.read_surface(tmp_path / "map.npz", non_measured="keep")
        assert surface.non_measured.sum() == 1
        assert surface.non_measured[3, 4]
        assert "1 of 144 points non-measured and kept so" in surface.history[0]


def test_the_plan_has_the_history_of_each_map(tmp_path):
    np.savez(tmp_path / "ball.npz", heights=cut_map((32, 32), (32e-6, 32e-6)).values, size=32e-6)
    ball = rc.read_surface(tmp_path / "ball.npz").detrend("sphere")
    ring = cut_map((40, 40), (60e-6, 60e-6), 1).detrend("plane")
    pair = rc.match(ball, ring, rotation=0.1, offset=(1e-6, 0), mirrored=True, interpolation="cubic", shape=(50, 50))
    problem = rc.ContactProblem(
        rc.Body(rc.SphereSurface(5e-3) + pair.body, STEEL), rc.Body(pair.counterbody, STEEL), grid=pair.grid
    )
    first, second = (line for line in problem.explain().splitlines() if line.startswith("heights "))
    for words in ("a sphere of radius 5 mm", "read from ball.npz: 32 x 32", "best sphere", "cubic"):
        assert words in first
    for words in ("best plane", "turned over", "rotated by 5.72958 degrees", "its centre at (1 µm", "1.5 µm x 1.5 µm"):
        assert words in second


def test_a_place_is_stated_to_a_thousandth_of_a_cell():
    one = cut_map((32, 48), (32e-6, 24e-6))
    placed = rc.match(one, one, offset=(675.8e-15, 3.00004e-6)).counterbody
    assert "its centre at (0 m, 1.5 µm)" in placed.provenance


def test_a_matched_pair_is_refined_between_its_points():
    one, other = cut_map((32, 32), (32e-6, 32e-6), 7), cut_map((40, 40), (40e-6, 40e-6), 8)
    pair = rc.match(one, other, interpolation="cubic")
    problem = rc.ContactProblem(rc.Body(pair.body, STEEL), rc.Body(pair.counterbody, STEEL), grid=pair.grid)
    refined = rc.on_grid(problem, tuple(4 * n for n in pair.grid.shape)).solve(force=0.05)
    coarse = problem.solve(force=0.05).area()
    assert refined.area().uncertainty < coarse.uncertainty
    assert abs(refined.area().value - coarse.value) < 2 * coarse.uncertainty
