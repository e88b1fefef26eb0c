"""The tip of a stylus: what it traces, what is restored below it, and which of that is certain."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import read_study

STEEL = rc.Elastic(young=210e9, poisson=0.3)


def make_map(shape=(24, 17), cells=(1e-6, 3e-6), periodic=False, seed=0, height=4e-7):
    rng = np.random.default_rng(seed)
    size = (shape[0] * cells[0], shape[1] * cells[1])
    return rc.HeightMap(height * rng.standard_normal(shape), size, periodic=periodic)


def trace_by_hand(surface, radius):
    """Return the highest place of a ball at each point, from all pairs of points of the map and its images."""
    (nx, ny), (dx, dy) = surface.grid.shape, surface.grid.spacing
    known = (
        np.where(surface.non_measured, -np.inf, surface.values) if surface.non_measured is not None else surface.values
    )
    found = np.full((nx, ny), -np.inf)
    for i in range(-nx, nx + 1):
        for j in range(-ny, ny + 1):
            if (square := (i * dx) ** 2 + (j * dy) ** 2) > radius**2:
                continue
            moved = np.roll(known, (i, j), axis=(0, 1))
            if not surface.periodic:
                moved = np.full((nx, ny), -np.inf)
                part = known[max(-i, 0) : nx - max(i, 0), max(-j, 0) : ny - max(j, 0)]
                moved[max(i, 0) : nx + min(i, 0), max(j, 0) : ny + min(j, 0)] = part
            found = np.maximum(found, moved - (radius - np.sqrt(radius**2 - square)))
    return found


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize(("radius", "height"), [(2e-5, 4e-7), (4e-6, 4e-7), (3e-5, 1e-8), (2.5e-6, 5e-6)])
def test_a_tip_rests_on_the_highest_point_below_it(periodic, radius, height):
    for shape, cells in (((24, 17), (1e-6, 3e-6)), ((9, 40), (3e-6, 1e-6))):
        surface = make_map(shape, cells, periodic, height=height)
        traced = surface.traced(radius)
        np.testing.assert_allclose(traced.values, trace_by_hand(surface, radius), rtol=0, atol=1e-9 * height)
        # The restored surface is what a tip traces of the map turned over.
        turned = rc.HeightMap(-traced.values, surface.size, periodic=periodic)
        expected = -trace_by_hand(turned, radius)
        restored = traced.restored(radius)
        np.testing.assert_allclose(restored.values, expected, rtol=0, atol=1e-9 * height)
        assert (restored.values >= surface.values - 1e-9 * height).all()
        np.testing.assert_allclose(restored.traced(radius).values, traced.values, rtol=0, atol=1e-9 * height)


@pytest.mark.parametrize("periodic", [False, True])
def test_a_wide_tip_rests_on_the_highest_point_too(periodic):
    surface = make_map((41, 52), (1e-6, 1e-6), periodic, height=4e-7)
    radius = 2e-3
    traced = surface.traced(radius)
    np.testing.assert_allclose(traced.values, trace_by_hand(surface, radius), rtol=0, atol=1e-15)
    restored = traced.restored(radius)
    turned = rc.HeightMap(-traced.values, surface.size, periodic=periodic)
    np.testing.assert_allclose(restored.values, -trace_by_hand(turned, radius), rtol=0, atol=1e-15)


def test_points_that_were_not_measured_do_not_push_the_tip():
    lost = np.zeros((24, 17), dtype=bool)
    lost[5:9, 6] = True
    true = make_map(height=1e-7)
    surface = rc.HeightMap(np.where(lost, 3e-6, true.values), true.size, non_measured=lost)
    traced = surface.traced("20um")
    np.testing.assert_allclose(traced.values, trace_by_hand(surface, 2e-5), rtol=0, atol=1e-16)
    restored = traced.restored("20um")
    assert (restored.values >= true.values - 1e-16)[~lost].all()
    assert restored.uncertain[lost].all()


@pytest.mark.parametrize("periodic", [False, True])
def test_certain_points_are_those_that_are_right(periodic):
    grid = rc.Grid((96, 128), (96e-6, 64e-6))
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=6e-6, longest=32e-6, seed=2)
    true = rc.HeightMap(rough.heights(grid), grid.size, periodic=periodic)
    flat = true.traced(1e-9).restored(1e-9)
    assert flat.certain_fraction == 1.0
    np.testing.assert_allclose(flat.values, true.values, atol=1e-16)
    fractions = []
    for radius in (1e-5, 3e-5, 1e-4):
        found = true.traced(radius).restored(radius)
        error = found.values - true.values
        certain = error[~found.uncertain]
        assert np.mean(certain**2) < 0.3 * np.mean(error[found.uncertain] ** 2)
        assert np.mean(certain < 1e-6 * np.ptp(true.values)) > 0.75
        fractions.append(found.certain_fraction)
        # Beyond a free border the tip may have touched anything.
        assert found.uncertain[[0, -1]].all() != periodic
    assert fractions[0] > 0.8 > fractions[1] > 0.5 > fractions[2] > 0.1


def test_the_area_is_that_of_the_surface_and_says_how_much_of_it_is_certain():
    grid = rc.Grid((96, 96), 96e-6)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6, seed=1)
    true = rc.HeightMap(rough.heights(grid), grid.size, periodic=True)

    def press(surface):
        return rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic").solve(pressure=2e8)

    area = press(true).area()
    assert area.certain_fraction is None
    traced = true.traced("18um")
    assert press(traced).area().value > 1.3 * area.value
    restored = traced.restored("18um")
    solution = press(restored)
    found = solution.area()
    assert found.value == pytest.approx(area.value, rel=0.02)
    exact = np.abs(restored.values - true.values) < 1e-6 * np.ptp(true.values)
    assert found.certain_fraction == pytest.approx(exact[solution.contact].mean(), abs=0.02)
    assert found.certain_fraction == 1.0 - restored.uncertain[solution.contact].mean() > 0.9
    assert not any(text.rule == "stylus tip" for text in found.warnings)
    blunt = press(true.traced("200um").restored("200um")).area()
    assert blunt.certain_fraction < 0.9
    (warning,) = (text for text in blunt.warnings if text.rule == "stylus tip")
    assert warning.value == blunt.certain_fraction
    assert area.value < blunt.value < area.value + 2.0 * blunt.uncertainty
    # Of a sum, and of a map on the counterbody, displaced on the path.
    ball = rc.ContactProblem(rc.Body(restored + rc.ParaboloidSurface(1e-3), STEEL)).solve(force=0.1)
    assert ball.area().certain_fraction == 1.0 - restored.uncertain[ball.contact].mean()
    flat = rc.Body(rc.FlatSurface(), STEEL)
    pair = rc.ContactProblem(flat, rc.Body(restored, STEEL), boundary="periodic", laws=[rc.Archard(1e-22)])
    state = pair.path(pressure=[2e8, 2e8], shift=[(0, 0), (5, 7)]).states[-1]
    moved = np.roll(restored.uncertain, (5, 7), axis=(0, 1))
    assert state.area().certain_fraction == 1.0 - moved[state.contact].mean()


def make_pair_of_maps(blunt, shape=(64, 64), size=(64e-6, 64e-6), seed=3):
    """Return a rough surface, and what is restored of it below a tip by its radius over the inverse rms bend."""
    grid = rc.Grid(shape, size)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6, seed=seed)
    true = rc.HeightMap(rough.heights(grid), size, periodic=True)
    bend = sum(
        (np.roll(true.values, way, axis) - true.values) / side**2
        for axis, side in enumerate(grid.spacing)
        for way in (1, -1)
    )
    radius = blunt / float(np.std(bend))
    return true, true.traced(radius).restored(radius)


def solve(surface, pressure=3e8):
    return rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic").solve(pressure=pressure)


ANSWERS = {
    "maximum pressure": lambda one: one.peak_pressure(),
    "approach": lambda one: one.response("approach"),
    "mean gap": lambda one: one.response("mean-gap"),
    "patches": lambda one: one.response("patches"),
    "stiffness": lambda one: one.stiffness(),
    "leakage": lambda one: one.leakage(viscosity=1e-3, pressure_drop=1e5),
}


class Volume(rc.Response):
    """A response that nothing is measured of."""

    def respond(self, solution):
        return rc.Estimate(float(solution.gap.sum()) * solution.grid.cell_area, 0.0, "m3")


@pytest.mark.parametrize("blunt", [0.5, 2.0, 4.0])
def test_each_answer_counts_what_the_tip_has_not_touched_or_says_that_it_does_not(blunt):
    true, restored = (solve(one) for one in make_pair_of_maps(blunt))
    for name, ask in ANSWERS.items():
        exact, found = ask(true), ask(restored)
        assert abs(found.value - exact.value) < 2.0 * found.uncertainty, name
        assert not any("stylus" in text.rule for text in exact.warnings), name
        rules = {text.rule for text in found.warnings}
        assert ("stylus tip" in rules) == (restored.area().certain_fraction < 0.9), name
        assert ("stylus valleys" in rules) == (blunt > 1.0 and name in ("mean gap", "leakage")), name
    factor = 10.0 if blunt > 1.0 else 1.5
    assert factor * true.response("mean-gap").uncertainty < restored.response("mean-gap").uncertainty
    rules = [text.rule for text in restored.response(Volume()).warnings]
    assert rules == ["stylus tip, not counted"] * (blunt > 1.0)
    # The stress has no uncertainty for it: the solution says so, in its text too.
    said = [text for text in restored.warnings if text.rule == "stylus"]
    assert len(said) == (blunt > 1.0)
    assert all(" ".join(text.split()) in " ".join(str(restored).split()) for text in said)


def test_the_depth_of_valleys_is_that_of_the_surface_turned_stretched_and_framed():
    _, restored = make_pair_of_maps(2.0, (24, 64), (64e-6, 64e-6))

    def ask(surface, boundary="periodic"):
        one = rc.ContactProblem(rc.Body(surface, STEEL), boundary=boundary).solve(approach=1e-9)
        return one.response("mean-gap", uncertainty="model").uncertainty

    std = ask(restored)
    assert ask(restored.transposed()) == pytest.approx(std, rel=1e-6)
    larger = rc.HeightMap(8.0 * restored.values, (512e-6, 512e-6), periodic=True, uncertain=restored.uncertain)
    assert ask(larger) == pytest.approx(8.0 * std, rel=0.01)
    # Valleys at a border where nothing is certain are taken for as deep as others.
    framed = restored.uncertain.copy()
    framed[:, :6] = framed[:, -6:] = framed[:2] = framed[-2:] = True
    cut = rc.HeightMap(restored.values, restored.size, uncertain=framed)
    assert ask(cut, "free") == pytest.approx(std, rel=0.3)
    assert ask(cut.mirror_borders()) == pytest.approx(std, rel=0.6)
    lost = rc.HeightMap(restored.values, restored.size, periodic=True, uncertain=np.ones(framed.shape, dtype=bool))
    assert ask(lost) == pytest.approx(np.ptp(restored.values), rel=0.01)


def test_a_film_law_on_a_restored_map_counts_its_valleys():
    true, restored = make_pair_of_maps(2.0)
    lengths = np.array([1.0, 1.5, 2.0]) * np.std(restored.values)
    laws = [
        rc.film_law(
            rc.ContactProblem(rc.Body(one, STEEL), boundary="periodic"), lengths / np.std(one.values), sampling=False
        )
        for one in (true, restored)
    ]
    exact, found = laws
    for name, column in found.columns.items():
        scale = exact.rms_height / found.rms_height if name.startswith("phi_s") else 1.0
        assert (np.abs(column.values - scale * exact[name].values) < 2.0 * column.uncertainties + 1e-9).all(), name
    said = [sum("Below the tip of the stylus" in text for text in law.warnings) for law in laws]
    assert said == [0, 1]


@pytest.mark.filterwarnings("ignore::roughcontact.ContactWarning")
def test_details_that_the_tip_cannot_have_traced_are_warned_of():
    grid = rc.Grid((96, 96), 96e-6)
    rough = rc.SelfAffineSurface(hurst=0.5, rms_height=2e-7, shortest=8e-6, longest=32e-6, seed=1)
    traced = rc.HeightMap(rough.heights(grid), grid.size, periodic=True).traced("20um")
    assert traced.restored("20um").warnings == traced.restored("15um").warnings == ()
    noise = np.random.default_rng(0).standard_normal(grid.shape)
    for level, expected in ((0.002, 0), (0.05, 1)):
        noisy = rc.HeightMap(traced.values + 2e-7 * level * noise, grid.size, periodic=True)
        found = noisy.restored("20um", noise=2e-7 * level)
        assert [text.rule for text in found.warnings] == expected * ["sharper than the tip"]
    assert [text.rule for text in traced.restored("40um").warnings] == ["sharper than the tip"]


def test_uncertain_points_go_with_the_map(tmp_path):
    found = make_map((20, 30), (1e-6, 1e-6)).traced("3um").restored("3um")
    mask = found.uncertain
    assert found.certain_fraction == 1.0 - mask.mean()
    np.testing.assert_array_equal(found.mirrored().uncertain, mask[::-1])
    np.testing.assert_array_equal(found.transposed().uncertain, mask.T)
    np.testing.assert_array_equal(found.crop((4e-6, 6e-6)).uncertain, mask[8:12, 12:18])
    np.testing.assert_array_equal(found.resample((40, 60)).resample((20, 30), "mean").uncertain, mask)
    np.testing.assert_array_equal(rc.PlacedMap(found, mirrored=True).uncertain_on(found.grid), mask[::-1])
    np.testing.assert_array_equal(found.detrend().filtered("4um").uncertain, mask)
    assert found.separate().form.uncertain is None
    solution = rc.ContactProblem(rc.Body(found, STEEL)).solve(force=1e-3)
    solution.save(tmp_path / "x.npz")
    assert rc.load(tmp_path / "x.npz").area(uncertainty="model") == solution.area(uncertainty="model")


def test_a_tip_on_the_command_line_and_in_a_study_file(tmp_path, capsys, monkeypatch):
    traced = make_map((20, 30), (1e-6, 1e-6), height=1e-7).traced("30um")
    expected = traced.restored("30um").detrend(1)
    np.savez(tmp_path / "map.npz", heights=traced.values, size=traced.size)
    monkeypatch.chdir(tmp_path)
    assert main(["info", "map.npz", "--tip-radius", "30um", "--detrend", "plane"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert f"restored below a tip of radius 30 µm, certain at {100 * expected.certain_fraction:.2g} %" in printed
    body = '{type = "file", path = "map.npz", tip_radius = "30um", detrend = "plane"}'
    (tmp_path / "study.toml").write_text(
        f"[problems.one.body]\nsurface = {body}\nmaterial = {{young = 1e9, poisson = 0.3}}\n[study]\nforce = [1e-3]\n"
    )
    surface = next(iter(read_study(tmp_path / "study.toml").problems.values())).body.surface
    np.testing.assert_array_equal(surface.values, expected.values)
    np.testing.assert_array_equal(surface.uncertain, expected.uncertain)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda one: one.restored(0.0), "The radius of the tip must be a finite number, above 0"),
        (lambda one: one.traced("2 Pa"), "The radius of the tip must be a finite number"),
        (lambda one: one.restored(1e-6, noise=-1e-9), "The noise of the heights must be a finite number, at least 0"),
        (lambda one: rc.HeightMap(np.zeros((3, 3)), 1e-6, uncertain=np.ones((2, 3), bool)), "mask of uncertain points"),
        (lambda one: rc.HeightMap(np.zeros((3, 3)), 1e-6, uncertain=[1.0]), "uncertain points of a height map must"),
    ],
)
def test_wrong_tips_are_refused(call, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        call(make_map())


def test_a_tip_over_too_many_points_is_refused():
    heights = np.zeros((1024, 1024))
    heights[::2] = 1e-3
    with pytest.raises(rc.InputError, match="The tip reaches over 2047 x 2047 cells"):
        rc.HeightMap(heights, 1024e-9).restored(1.0)
