"""Measured maps: signs of defects, what their area is, and the waves that they do not resolve."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

import roughcontact as rc

ROOT = Path(__file__).parents[2]
STEEL = rc.Elastic(210e9, 0.3)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2e-6, longest=100e-6, rolloff=50e-6, seed=3)
GRID = rc.Grid((128, 128), 128e-6)


def study(name, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "studies"))
    return importlib.import_module(name)


def crop(cells=96):
    """Return a map that does not repeat."""
    return rc.HeightMap(ROUGH.heights(GRID)[:cells, :cells], size=cells * 1e-6)


def add_waves(rng, count, shape):
    """Return a sum of waves of 4 to 40 cells, each of them plane or of a chequered pattern."""
    heights = np.zeros(shape)
    x, y = np.ogrid[: shape[0], : shape[1]]
    for _ in range(count):
        (qx, qy), phases = 2.0 * np.pi / rng.uniform(4.0, 40.0, 2), rng.uniform(0.0, 2.0 * np.pi, 2)
        along_x, along_y = qx * x + phases[0], qy * y + phases[1]
        heights += np.cos(along_x + along_y) if rng.random() < 0.5 else np.cos(along_x) * np.cos(along_y)
    return heights


def read_table(head):
    page = (ROOT / "docs" / "use" / "maps.md").read_text(encoding="utf-8")
    rows = page[page.index(head) :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("| ").split("|")] for row in rows]


class TestWarnings:
    @pytest.mark.slow
    def test_of_a_few_held_out_maps(self, monkeypatch):
        maps = study("map_warnings", monkeypatch)
        found = maps.measure(maps.HELD_OUT, 3)
        for name, (expected, rate) in found.items():
            if expected in ("", "interpolation", "blur", "filling"):
                assert rate == (1.0 if expected else 0.0), name
        assert found["steps of 0.1 Sq"][1] == 1.0
        assert found["8 cells on the shortest wave, noise of 2 % of Sq"][1] == 1.0

    @pytest.mark.slow
    @pytest.mark.parametrize("column", [2, 3])
    def test_rates_are_those_of_the_page(self, monkeypatch, column):
        maps = study("map_warnings", monkeypatch)
        found = maps.measure((maps.TUNED, maps.HELD_OUT)[column - 2], 50)
        table = {row[0]: float(row[column]) for row in read_table("| map | warning |")}
        assert set(table) < set(found)
        # The page has those that are not as they should be: a warning for each defect, and none without one.
        for name, (expected, rate) in found.items():
            # Another rounding may change the warnings of one map in fifty.
            assert table.get(name, 100.0 if expected else 0.0) == pytest.approx(100 * rate, abs=2.01), name

    @pytest.mark.parametrize(
        "surface",
        [
            rc.FlatSurface(),
            rc.SphereSurface(1e-3),
            rc.ParaboloidSurface(1e-3),
            rc.WavySurface(1e-6, (11e-6, 13e-6)),
            rc.SphereSurface(1e-3) + rc.WavySurface(1e-7, 9e-6),
        ],
        ids=str,
    )
    def test_none_for_computed_shapes(self, surface):
        assert rc.HeightMap(surface.heights(GRID), size=GRID.size).warnings == ()

    def test_none_for_a_punch(self):
        heights = 1e-6 * (np.hypot(GRID.x, GRID.y) < 3e-5)
        assert rc.HeightMap(heights, size=GRID.size).warnings == ()

    @pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e30])
    def test_do_not_depend_on_the_unit(self, scale):
        heights = ndimage.gaussian_filter(crop().values, 1.0)
        (text,) = rc.HeightMap(heights * scale, size=96e-6).warnings
        assert "faint in the map, as after optical blur" in text
        assert rc.HeightMap(crop().values * scale, size=96e-6).warnings == ()

    def test_none_for_periodic_and_for_small_maps(self):
        blurred = ndimage.gaussian_filter(crop().values, 1.0)
        assert rc.HeightMap(blurred, size=96e-6, periodic=True).warnings == ()
        assert rc.HeightMap(blurred[:20], size=(20e-6, 96e-6)).warnings == ()

    @pytest.mark.parametrize("shape", [(96, 96), (40, 120)])
    @pytest.mark.parametrize("fraction", [0.01, 0.05, 0.2])
    def test_none_for_marked_points(self, shape, fraction):
        """Whatever stands at them, and whether they are single or not: they are no heights, filled or noisy."""
        rng = np.random.default_rng(4)
        heights = crop().values[: shape[0]] if shape[0] == 96 else ROUGH.heights(GRID)[: shape[0], : shape[1]]
        size = (heights.shape[0] * 1e-6, heights.shape[1] * 1e-6)
        single, blobs = rng.random(heights.shape), ndimage.gaussian_filter(rng.standard_normal(heights.shape), 2.0)
        for field in (single, blobs):
            lost = field < np.quantile(field, fraction)
            assert rc.HeightMap(np.where(lost, np.nan, heights), size=size).warnings == ()
            assert rc.HeightMap(np.where(lost, 1e-3, heights), size=size, non_measured=lost).warnings == ()

    @pytest.mark.parametrize("fraction", [0.01, 0.03])
    def test_noise_is_told_from_holes(self, fraction):
        """Waves of eight cells and more, which holes that are filled in look noisy on."""
        smooth = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=128e-6, rolloff=50e-6, seed=3)
        heights = smooth.heights(GRID)[:110, :90]
        rng = np.random.default_rng(1)
        lost, noise = rng.random(heights.shape) < fraction, 0.02 * heights.std() * rng.standard_normal(heights.shape)
        calm, noisy = (
            rc.HeightMap(np.where(lost, np.nan, values), size=(110e-6, 90e-6)).warnings
            for values in (heights, heights + noise)
        )
        assert not any("noise" in text for text in calm)
        assert any("noise" in text for text in noisy)

    @pytest.mark.parametrize(("shape", "size"), [((97, 131), (97e-6, 131e-6)), ((192, 64), (192e-6, 192e-6))])
    @pytest.mark.parametrize("shortest", [3, 4])
    def test_noise_on_smooth_heights_is_not_taken_for_blur(self, shape, size, shortest):
        """Whatever the sides of the cells: the spectrum falls to the level of the noise, and stays there."""
        grid = rc.Grid(shape, size)
        surface = rc.SelfAffineSurface(
            hurst=0.8,
            rms_height=80e-9,
            longest=80e-6,
            rolloff=40e-6,
            shortest=shortest * max(grid.spacing),
            seed=shortest,
        )
        noise = 0.7e-9 * np.random.default_rng(4).standard_normal(shape)
        (warning,) = rc.HeightMap(surface.heights(grid) + noise, size=size).warnings
        assert warning.startswith("the shortest waves of the map are mostly noise, of about ")
        assert warning.rule == "noise"
        assert warning.value == pytest.approx(0.7e-9, rel=0.15)
        assert rc.HeightMap(surface.heights(grid), size=size).warnings == ()

    def test_points_that_were_filled_on_reading_may_touch(self, tmp_path, run):
        lost = np.random.default_rng(2).random((96, 96)) < 0.05
        np.savez(tmp_path / "map.npz", heights=np.where(lost, np.nan, crop().values), size=(96e-6, 96e-6))
        (text,) = rc.read_surface(tmp_path / "map.npz", non_measured="fill").warnings
        assert "map are filled from their neighbours: where they touch, the contact is a guess" in text
        assert rc.read_surface(tmp_path / "map.npz", non_measured="keep").warnings == ()
        _, out, _ = run("info", tmp_path / "map.npz", "--non-measured", "fill")
        assert "where they touch, the contact is a guess" in " ".join(out.split())
        status, out, _ = run("info", tmp_path / "map.npz", "--non-measured", "keep")
        assert status == 0
        assert "warning" not in out

    @pytest.mark.parametrize("cells", [(96, 96), (64, 160), (200, 128)])
    def test_a_few_waves_are_not_interpolated(self, cells):
        for seed in range(5):
            heights = add_waves(np.random.default_rng(seed), 1 + seed, cells)
            surface = rc.HeightMap(heights, size=(cells[0] * 1e-6, cells[1] * 1e-6))
            assert surface.period == 0.0
            assert not any("interpolated" in text for text in surface.warnings)

    def test_reach_the_area_through_sums_and_places_and_files(self, tmp_path):
        blurred = rc.HeightMap(ndimage.gaussian_filter(crop().values, 1.0), size=96e-6)
        grid = rc.Grid((64, 64), 60e-6)
        for surface, chosen in (
            (blurred, None),
            (blurred + rc.SphereSurface(1e-3), None),
            (rc.PlacedMap(blurred, rotation=0.3, interpolation="cubic"), grid),
        ):
            solution = rc.ContactProblem(rc.Body(surface, STEEL), grid=chosen).solve(pressure=1e7)
            assert set(blurred.warnings) <= set(solution.area().warnings)
            assert set(blurred.warnings) <= set(solution.area("cell-count").warnings)
            assert "roughness shorter than 2 µm is not included" in str(solution)
        solution.save(tmp_path / "x.npz")
        assert rc.ContactSolution.load(tmp_path / "x.npz").area().warnings == solution.area().warnings

    def test_known_surfaces_have_no_such_line(self):
        solution = rc.ContactProblem(rc.Body(ROUGH, STEEL), grid=GRID, boundary="periodic").solve(pressure=1e7)
        assert "as interpolated" not in str(solution)

    def test_of_real_maps(self, measured_maps):
        pytest.importorskip("SurfaceTopography", exc_type=ImportError)
        said = [
            rc.read_surface(measured_maps / name, non_measured="fill").warnings
            for name in ("x3p-2.x3p", "plu-1.plu", "opd-1.opd")
        ]
        assert "looks interpolated (its differences repeat every 2.9 cells)" in said[0][0]
        assert "rise in steps" in said[1][0]


class TestBeyondResolution:
    def test_the_table(self):
        mask = np.zeros((48, 48), dtype=bool)
        mask[:5, :5] = True
        rough = rc.HeightMap(crop(48).values, size=48e-6, non_measured=mask)
        problem = rc.ContactProblem(rc.Body(rough + rc.SphereSurface(1e-3), STEEL), rc.Body(crop(48), STEEL))
        found = rc.beyond_resolution(problem, force=0.5, cutoffs=[2, 1], realizations=3)
        assert found.wavelengths == (2e-6, 1e-6)
        assert [len(areas) for areas in found.areas] == [3, 3]
        assert found.measured.value == problem.solve(force=0.5).area().value
        assert found.rms_slopes[1] > found.rms_slopes[0]
        assert found.means[1] < found.means[0]
        low, high = found.range
        assert low < found.means.min() < found.means.max() < high
        lines = str(found).splitlines()
        assert len(lines) == 5
        assert len({len(line) for line in lines[:4]}) == 1
        again = rc.beyond_resolution(problem, force=0.5, cutoffs=[2, 1], realizations=3)
        np.testing.assert_array_equal(again.means, found.means)

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", ["points", "means"])
    def test_the_range_holds(self, monkeypatch, kind):
        """Of the first held-out surfaces; docs/use/maps.md has the rate over more of them."""
        held = study("beyond_resolution", monkeypatch)
        assert sum(held.measure(held.FIRST + index, kind)[1] for index in range(4)) >= 3

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"cutoffs": []}, "cut-offs is empty"),
            ({"cutoffs": 1.0}, r"such as \[1, 0\.5\]"),
            ({"cutoffs": [3.0]}, "at most 2"),
            ({"cutoffs": [1e-9]}, "of at most 2\\^40 cells"),
            ({"realizations": 1}, "at least 2"),
            ({"realizations": 10**9}, "at most 1000"),
            ({"resolved": 1e-6}, "at least 2e-06"),
            ({"resolved": 1e-4}, "too small to extrapolate its spectrum"),
            ({"force": 1.0}, "exactly one"),
        ],
    )
    def test_refusals(self, options, message):
        problem = rc.ContactProblem(rc.Body(crop(), STEEL))
        with pytest.raises(rc.InputError, match=message):
            rc.beyond_resolution(problem, pressure=1e7, **options)

    def test_what_is_not_a_rough_map_is_refused(self):
        with pytest.raises(rc.InputError, match="no height map"):
            rc.beyond_resolution(rc.ContactProblem(rc.Body(ROUGH, STEEL), grid=GRID), pressure=1e7)
        noise = rc.HeightMap(1e-8 * np.random.default_rng(0).standard_normal((64, 64)), size=1e-4)
        with pytest.raises(rc.InputError, match=r"does not fall .* they are noise"):
            rc.beyond_resolution(rc.ContactProblem(rc.Body(noise, STEEL)), pressure=1e7)
        flat = rc.HeightMap(np.zeros((64, 64)), size=1e-4) + rc.SphereSurface(1e-2)
        with pytest.raises(rc.InputError, match="has no waves"):
            rc.beyond_resolution(rc.ContactProblem(rc.Body(flat, STEEL)), pressure=1e7)


class TestNonMeasuredInMemory:
    SHAPE, SIZE = (30, 17), (60e-6, 17e-6)

    @pytest.fixture
    def heights(self):
        return rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=6e-6, longest=17e-6, seed=2).heights(
            rc.Grid(self.SHAPE, self.SIZE)
        )

    @pytest.fixture
    def lost(self):
        lost = np.random.default_rng(4).random(self.SHAPE) < 0.1
        lost[:3, 5:9] = lost[12:18, 8:12] = True
        return lost

    def test_heights_that_are_nan_or_masked_are_those_of_a_file(self, heights, lost, tmp_path):
        holed = np.where(lost, np.nan, heights)
        np.savez(tmp_path / "map.npz", heights=holed, size=self.SIZE)
        read = rc.read_surface(tmp_path / "map.npz", non_measured="keep")
        masked = np.ma.masked_array(heights, lost)
        for surface in (rc.HeightMap(holed, self.SIZE), rc.HeightMap(masked, self.SIZE)):
            np.testing.assert_array_equal(surface.values, read.values)
            np.testing.assert_array_equal(surface.non_measured, lost)
            assert not surface.values.flags.writeable
            assert not surface.non_measured.flags.writeable
        np.testing.assert_array_equal(np.isnan(holed), lost)

    def test_they_join_the_mask_that_is_given(self, heights, lost):
        half = lost & (np.arange(17) < 9)
        surface = rc.HeightMap(np.where(half, np.nan, heights), self.SIZE, non_measured=lost)
        np.testing.assert_array_equal(surface.non_measured, lost)
        np.testing.assert_array_equal(surface.values[~half], heights[~half])

    def test_filled_heights_count_as_measured_if_asked_for(self, heights, lost, tmp_path):
        holed = np.where(lost, np.nan, heights)
        found = rc.HeightMap(holed, self.SIZE, non_measured="fill", history=("measured",))
        expected = rc.HeightMap(holed, self.SIZE, history=("measured",)).fill()
        np.testing.assert_array_equal(found.values, expected.values)
        assert found.non_measured is None
        assert found.history == expected.history
        assert found.history[1].endswith("of 510 points non-measured and filled from their neighbours")
        np.savez(tmp_path / "map.npz", heights=holed, size=self.SIZE)
        read = rc.read_surface(tmp_path / "map.npz", non_measured="fill")
        np.testing.assert_array_equal(found.values, read.values)
        assert [text for text in found.warnings if "filled" in text] == list(expected.warnings[-1:])
        # Nothing to fill.
        whole = rc.HeightMap(heights, self.SIZE, non_measured="fill")
        np.testing.assert_array_equal(whole.values, heights)
        assert whole.history == ()
        with pytest.raises(rc.InputError, match="No point of the height map was measured"):
            rc.HeightMap(np.full((4, 4), np.nan), 1e-6, non_measured="fill")
        np.testing.assert_array_equal(rc.HeightMap(holed, self.SIZE, non_measured="keep").non_measured, lost)
        with pytest.raises(rc.InputError, match="but got 'drop'"):
            rc.HeightMap(holed, self.SIZE, non_measured="drop")

    def test_they_never_touch(self, heights, lost):
        steel = rc.Elastic(210e9, 0.3)
        surface = rc.HeightMap(np.where(lost, np.nan, heights), self.SIZE)
        solution = rc.ContactProblem(rc.Body(surface, steel)).solve(pressure=3e8)
        assert solution.contact.any()
        assert not solution.pressure[lost].any()
        expected = rc.HeightMap(surface.values, self.SIZE, non_measured=lost)
        found = rc.ContactProblem(rc.Body(expected, steel)).solve(pressure=3e8)
        np.testing.assert_array_equal(solution.pressure, found.pressure)


def test_the_page_gives_the_rates_of_its_ranges():
    rows = read_table("| map | surfaces |")
    assert [row[0] for row in rows] == ["heights at points", "means over cells"]
    assert all(re.fullmatch(r"\d+ %", row[3]) for row in rows)
