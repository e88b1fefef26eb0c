"""The sampling error: how much other places of the same rough surface differ."""

import copy
import gc
import math
import pickle
import weakref

import attrs
import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import roughcontact as rc

STEEL = rc.Elastic(young=210e9, poisson=0.3)
SLOPE = 0.1


def draw(shape, size, seed, longest, shortest):
    """Return Gaussian heights of a self-affine surface, whose rms slope is that of its spectrum over many seeds."""
    grid = rc.Grid(shape, size)
    qx, qy = (np.fft.fftfreq(n, step) for n, step in zip(grid.shape, grid.spacing, strict=True))
    q = np.hypot(qx[:, None], qy)
    power = np.where((q > 0.0) & (q <= 1.0 / shortest), np.maximum(q, 1.0 / longest) ** -3.6, 0.0)
    power *= SLOPE**2 / np.sum((2.0 * np.pi * q) ** 2 * power)
    white = np.random.default_rng(seed).normal(size=shape)
    return np.fft.ifft2(np.fft.fft2(white) * np.sqrt(power)).real * math.sqrt(grid.cells)


def press(heights, size, ratio=0.03, boundary="periodic", material=STEEL):
    """Return the contact of a map at a load that is `ratio` times its rms slope times the modulus."""
    height_map = rc.HeightMap(heights, size=size, periodic=boundary == "periodic")
    problem = rc.ContactProblem(rc.Body(height_map, material), boundary=boundary)
    return problem.solve(pressure=ratio * SLOPE * STEEL.young / (1.0 - STEEL.poisson**2))


def relative(solution):
    answers = (solution.area(), solution.stiffness(), solution.peak_pressure())
    return np.array([one.sampling / one.value for one in answers])


@pytest.fixture(scope="module")
def rough():
    return press(draw((64, 64), 64e-6, 1, 16e-6, 4e-6), 64e-6)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_the_sampling_error_tells_the_scatter_of_places(boundary):
    places = [press(draw((48, 48), 48e-6, seed, 12e-6, 4e-6), 48e-6, boundary=boundary) for seed in range(10)]
    for ask in (rc.ContactSolution.area, rc.ContactSolution.stiffness, rc.ContactSolution.peak_pressure):
        answers = [ask(place) for place in places]
        values = np.array([one.value for one in answers])
        stated = np.array([one.sampling for one in answers])
        assert np.mean(np.abs(values - values.mean()) < 2.0 * stated) >= 0.8
        assert 0.5 < np.median(stated) / values.std(ddof=1) < 2.5


def modulate(heights, correlation, seed):
    """Return heights whose amplitude changes from place to place, over a length in cells."""
    qx, qy = (np.fft.fftfreq(n) for n in heights.shape)
    power = np.exp(-((np.pi * correlation * np.hypot(qx[:, None], qy)) ** 2))
    white = np.random.default_rng(seed).normal(size=heights.shape)
    field = np.fft.ifft2(np.fft.fft2(white) * np.sqrt(power / power.sum())).real * math.sqrt(heights.size)
    return heights * np.exp(0.4 * field)


def test_the_sampling_error_tells_the_scatter_of_a_roughness_that_changes():
    heights = [modulate(draw((64, 64), 64e-6, seed, 16e-6, 4e-6), 16.0, seed + 100) for seed in range(10)]
    places = [press(one, 64e-6) for one in heights]
    for ask in (rc.ContactSolution.area, rc.ContactSolution.stiffness, rc.ContactSolution.peak_pressure):
        answers = [ask(place) for place in places]
        values = np.array([one.value for one in answers])
        assert np.mean(np.abs(values - values.mean()) < 2.0 * np.array([one.sampling for one in answers])) >= 0.8


def test_halves_of_other_roughness_are_said_to_change(rough):
    heights = draw((64, 64), 64e-6, 1, 16e-6, 4e-6) * np.where(np.arange(64) < 32, 1.0, 2.5)[:, None]
    uneven = press(heights, 64e-6)
    assert (relative(uneven) > 1.5 * relative(rough)).all()
    assert "the roughness changes along the map" in str(uneven)
    assert "places far away" not in str(rough)


def test_two_summits_do_not_tell_how_others_differ():
    solution = press(draw((64, 64), 64e-6, 1, 64e-6, 16e-6), 64e-6, ratio=1e-4)
    assert solution.patches.count < 3
    assert "too few summits" in str(solution)


def test_few_marks_of_a_lay_are_said(rough):
    marks = 8e-7 * np.cos(6.0 * np.pi * np.arange(64) / 64)[:, None]
    solution = press(draw((64, 64), 64e-6, 1, 16e-6, 4e-6) + marks, 64e-6)
    assert "only a few grooves wide" in " ".join(str(solution).split())
    assert "few marks" not in str(rough)


def test_pressures_that_spread_tell_of_steep_summits(rough):
    steep = (np.arange(64 * 64).reshape(64, 64) % 7 == 0) & rough.contact
    uneven = attrs.evolve(rough, pressure=np.where(steep, 6.0, 1.0) * rough.pressure)
    assert uneven._place.statistics.unevenness > 0.2
    assert rough._place.statistics.unevenness < 0.05


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_large_map_that_is_flat_in_the_middle_has_one(boundary):
    heights = draw((288, 288), 288e-6, 1, 48e-6, 16e-6)
    heights[40:248, 40:248] = 0.0
    assert np.isfinite(relative(press(heights, 288e-6, boundary=boundary))).all()


def test_a_larger_map_is_known_better():
    small = relative(press(draw((64, 64), 64e-6, 1, 16e-6, 4e-6), 64e-6))
    large = relative(press(draw((256, 256), 256e-6, 1, 16e-6, 4e-6), 256e-6))
    assert 0.15 < large[0] / small[0] < 0.4  # a quarter, by the number of independent waves
    assert 0.15 < large[1] / small[1] < 0.4


@pytest.mark.parametrize(
    ("shape", "size"), [((128, 16), (128e-6, 16e-6)), ((63, 45), (63e-6, 135e-6)), ((64, 66), (64e-6, 66e-6))]
)
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_transposed_map_has_the_same(shape, size, boundary):
    heights = draw(shape, size, 3, 24e-6, 8e-6)
    upright = relative(press(heights, size, boundary=boundary))
    lying = relative(press(heights.T, size[::-1], boundary=boundary))
    assert np.isfinite(upright).all()
    assert upright == pytest.approx(lying, rel=1e-4)


def test_a_scaled_map_has_the_same(rough):
    larger = press(1e3 * draw((64, 64), 64e-6, 1, 16e-6, 4e-6), 64e-3)
    assert relative(larger) == pytest.approx(relative(rough), rel=1e-6)


def test_a_turned_off_form_does_not_count():
    heights = draw((64, 64), 64e-6, 1, 16e-6, 4e-6)
    x = np.linspace(-1.0, 1.0, 64)
    tilted = rc.HeightMap(heights + 1e-6 * x[:, None], size=64e-6).detrend(1)
    level = rc.HeightMap(heights, size=64e-6).detrend(1)
    load = {"pressure": 0.3e9}
    pair = [rc.ContactProblem(rc.Body(one, STEEL)).solve(**load).area() for one in (tilted, level)]
    assert pair[0].sampling == pytest.approx(pair[1].sampling, rel=1e-3)


@pytest.mark.parametrize(
    "surface",
    [
        rc.WavySurface(1e-6, 32e-6),
        rc.SphereSurface(1e-3),
    ],
)
def test_without_a_rough_surface_there_is_none(surface):
    solution = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((32, 32), 64e-6), boundary="free").solve(
        force=1e-3
    )
    assert not (solution.area().sampling or 0.0) > solution.area().value
    assert solution.stiffness().sampling is None
    assert solution.peak_pressure().sampling is None
    assert "other places" not in str(solution)


def test_a_rough_surface_on_a_flat_or_a_rough_one_has_some():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6)
    grid = rc.Grid((32, 32), 64e-6)
    for one in (surface, rc.FlatSurface() + surface):
        problem = rc.ContactProblem(
            rc.Body(one, STEEL), rc.Body(surface.reseed(1), STEEL), grid=grid, boundary="periodic"
        )
        solution = problem.solve(pressure=100e6)
        assert 0.0 < solution.area().sampling < solution.area().value


def test_a_surface_of_ones_own_says_whether_it_is_random():
    class Made(rc.Surface):
        def heights(self, grid):
            return draw(grid.shape, grid.size, 1, 16e-6, 4e-6)

    class Random(Made):
        is_random = True

    def ask(surface):
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=rc.Grid((32, 32), 32e-6), boundary="periodic")
        return problem.solve(pressure=100e6).area().sampling

    assert ask(Made()) is None
    assert ask(Random()) > 0.0


def test_an_area_does_not_keep_its_solution():
    solution = press(draw((32, 32), 32e-6, 1, 16e-6, 4e-6), 32e-6)
    area = solution.area()
    reference = weakref.ref(solution)
    del solution
    gc.collect()
    assert reference() is None
    assert area.sampling > 0.0


def test_an_area_holds_the_heights_until_its_sampling_error_is_read():
    solution = press(draw((32, 32), 32e-6, 1, 16e-6, 4e-6), 32e-6)
    area = solution.area()
    held = weakref.ref(solution._place)
    expected = pickle.loads(pickle.dumps(solution)).area().sampling
    del solution
    gc.collect()
    assert held() is not None
    assert area.sampling == expected
    gc.collect()
    assert held() is None


def test_pickles_and_copies_hold_the_number(rough):
    area = rough.area()
    for one in (pickle.loads(pickle.dumps(area)), copy.deepcopy(area)):
        assert one.sampling == area.sampling
        assert one == area
    assert len(pickle.dumps(area)) < 20_000
    assert pickle.loads(pickle.dumps(rough)).area().sampling == area.sampling


def test_a_solution_from_a_file_has_the_same(rough, tmp_path):
    rough.save(tmp_path / "rough.npz")
    assert rc.ContactSolution.load(tmp_path / "rough.npz").area().sampling == pytest.approx(rough.area().sampling)


def test_all_estimators_state_the_same_part(rough):
    parts = {name: rough.area(name) for name in ("blend", "cell-count", "level-set")}
    ratios = [one.sampling / one.value for one in parts.values()]
    assert ratios == pytest.approx([ratios[0]] * 3)
    assert rc.Estimate(1.0, 0.1, "m").sampling is None


def test_full_contact_has_the_same_area_everywhere():
    solution = press(draw((32, 32), 32e-6, 1, 16e-6, 8e-6), 32e-6, ratio=10.0)
    assert solution.contact.all()
    assert solution.area().sampling == 0.0
    assert solution.stiffness().sampling is None


def test_where_the_hardness_is_reached_the_maximum_is_known():
    soft = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    solution = press(draw((64, 64), 64e-6, 1, 16e-6, 4e-6), 64e-6, material=soft)
    assert solution.saturated.any()
    assert solution.peak_pressure().sampling == 0.0
    assert solution.area().sampling > 0.0
    assert solution.saturated_area().sampling is None


def test_on_a_mixed_boundary_the_stiffness_has_none():
    solution = press(draw((32, 32), 32e-6, 1, 16e-6, 4e-6), 32e-6, boundary=("free", "periodic"))
    assert solution.stiffness().sampling is None
    assert solution.area().sampling > 0.0


@pytest.mark.parametrize(
    ("shape", "boundary", "known"),
    [
        ((64, 1), "periodic", True),
        ((64, 1), ("free", "periodic"), False),
        ((3, 3), "free", False),
        ((2, 50), "free", False),
        ((130, 7), "free", True),
        ((32, 32), "wrapped", True),
    ],
)
def test_narrow_and_tiny_domains(shape, boundary, known):
    heights = 1e-8 * np.random.default_rng(0).normal(size=shape)
    surface = rc.HeightMap(heights, size=(shape[0] * 1e-6, shape[1] * 1e-6), periodic=True)
    area = rc.ContactProblem(rc.Body(surface, STEEL), boundary=boundary).solve(pressure=50e6).area()
    assert (area.sampling is not None) is known
    assert not known or 0.0 < area.sampling < area.value


def test_surfaces_that_attract_each_other_have_none():
    heights = draw((32, 32), 32e-6, 1, 16e-6, 8e-6)
    law = rc.Exponential(work=0.05, range=50e-9)
    surface = rc.HeightMap(heights, size=32e-6, periodic=True)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3)), boundary="periodic", adhesion=law)
    assert problem.solve(pressure=10e6).area().sampling is None


@pytest.mark.parametrize(
    ("name", "side", "step", "pressure"), [("plu-1.plu", 96, 192, 16e6), ("opd-1.opd", 80, 160, 67e6)]
)
def test_parts_of_a_measured_map_agree_within_their_sampling_errors(measured_maps, name, side, step, pressure):
    pytest.importorskip("SurfaceTopography")
    whole = rc.read_surface(measured_maps / name, non_measured="fill")
    nx, ny = whole.grid.shape
    size = tuple(side * spacing for spacing in whole.grid.spacing)
    areas = []
    for i in range(0, nx - step + 1, step):
        for j in range(0, ny - step + 1, step):
            part = rc.HeightMap(whole.values[i : i + side, j : j + side], size=size).detrend(2)
            areas.append(rc.ContactProblem(rc.Body(part, STEEL)).solve(pressure=pressure).area())
    mean = np.mean([one.value for one in areas])
    assert np.mean([abs(one.value - mean) < 2.0 * one.sampling for one in areas]) >= 0.8


@pytest.mark.parametrize(
    ("shape", "size", "boundary"),
    [((96, 64), (96e-6, 64e-6), "periodic"), ((121, 40), (40e-6, 40e-6), "free"), ((32, 128), (16e-6, 128e-6), "free")],
)
def test_points_that_are_kept_as_non_measured_hardly_change_it(shape, size, boundary):
    heights = draw(shape, size, 3, 16e-6, 6e-6)
    lost = np.zeros(shape, dtype=bool)
    lost.flat[np.random.default_rng(0).choice(lost.size, 20, replace=False)] = True
    steel = rc.Body(rc.HeightMap(heights, size, periodic=boundary == "periodic"), STEEL)
    kept = rc.Body(rc.HeightMap(heights, size, periodic=boundary == "periodic", non_measured=lost), STEEL)
    whole, holed = (relative(rc.ContactProblem(body, boundary=boundary).solve(pressure=1e8)) for body in (steel, kept))
    np.testing.assert_allclose(holed, whole, rtol=0.15)


@pytest.mark.parametrize(
    ("shape", "size", "boundary"),
    [
        ((124, 107), (124e-6, 107e-6), "periodic"),
        ((96, 32), (96e-6, 96e-6), "free"),
        ((160, 40), (160e-6, 40e-6), "free"),
    ],
)
@pytest.mark.parametrize("how", ["blob", "margin"])
def test_what_stands_at_lost_points_does_not_count(how, shape, size, boundary):
    """Large holes are filled smoothly: taken for a smooth place, they doubled to quintupled the sampling error."""
    heights = draw(shape, size, 4, 0.4 * min(size), 7.0 * max(n / k for n, k in zip(size, shape, strict=True)))
    i, j = np.ogrid[: shape[0], : shape[1]]
    lost = np.hypot(i - 0.4 * shape[0], j - 0.6 * shape[1]) < 0.2 * min(shape) + 2
    if how == "margin":
        lost = (i < shape[0] // 8) | (j >= shape[1] - shape[1] // 8)
    periodic = boundary == "periodic"
    whole, holed = (
        relative(
            rc.ContactProblem(
                rc.Body(rc.HeightMap(heights, size, periodic=periodic, non_measured=one), STEEL), boundary=boundary
            ).solve(pressure=2e8)
        )
        for one in (None, lost)
    )
    assert holed == pytest.approx(whole, rel=0.5)


@hypothesis.settings(max_examples=15)
@hypothesis.given(
    shape=st.sampled_from([(5, 29), (4, 9), (12, 40), (210, 12), (16, 16), (40, 5)]),
    boundary=st.sampled_from(["free", "periodic", "wrapped"]),
    step=st.floats(0.3, 0.8),
    along=st.booleans(),
)
def test_a_map_of_one_step_gives_numbers_and_no_noise(shape, boundary, step, along):
    heights = np.zeros(shape)
    if along:
        heights[int(step * shape[0]) :] = 12e-9
    else:
        heights[:, int(step * shape[1]) :] = 12e-9
    body = rc.Body(rc.HeightMap(heights, size=(2e-6 * shape[0], 1e-6 * shape[1])), STEEL)
    solution = rc.ContactProblem(body, boundary=boundary).solve(pressure=1e7)
    answers = [solution.area(), solution.peak_pressure()]
    if boundary != "wrapped":
        answers.append(solution.stiffness())
    for answer in answers:
        assert answer.sampling is None or 0.0 <= answer.sampling <= abs(answer.value)
    assert solution.to_dict()


@pytest.mark.parametrize("shape", [(200, 200), (400, 50), (50, 400)])
def test_a_large_map_of_steps_has_an_area(shape):
    """Of every so many cells that are compared none has a slope."""
    heights = np.zeros(shape)
    heights[shape[0] // 4 : 3 * shape[0] // 4, shape[1] // 4 : 3 * shape[1] // 4] = 2e-5
    solution = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=(1e-3, 1e-3)), STEEL)).solve(force=5.0)
    assert solution.area().fraction == pytest.approx(0.25, rel=0.1)
    assert str(solution.peak_pressure())
    assert not (solution.area().sampling or 0.0) > solution.area().value
