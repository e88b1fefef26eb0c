"""Viscoelastic bodies that slide steadily at a speed."""

import attrs
import numpy as np
import pytest

import roughcontact as rc

CAREFUL = rc.ProjectedConjugateGradient(tolerance=1e-9)
RUBBER = rc.Viscoelastic([1e6, 9e6], [1e-3], 0.5)
SIDE = 1e-3


def slide_over(surface, shape=(32, 32), size=SIDE, rubber=RUBBER, boundary="periodic", **others):
    """Return flat rubber over which a rigid surface slides."""
    others.setdefault("solver", CAREFUL)
    road = rc.Body(surface, rc.Rigid())
    body = rc.Body(rc.FlatSurface(), rubber)
    return rc.ContactProblem(body, road, grid=rc.Grid(shape, size), boundary=boundary, **others)


def make_rough(cells=32, seed=3):
    return rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8 * SIDE / cells, longest=SIDE, seed=seed)


def sum_lost_power(problem, state, speed, axis=0):
    """Return the power by the loss compliance of each wave of the pressure, W: of half of the waves, twice."""
    grid = problem.grid
    waves = [2 * np.pi / step * np.fft.fftfreq(n) for n, step in zip(grid.shape, grid.spacing, strict=True)]
    qx, qy = waves[0][:, None], waves[1][None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        kernel = problem.plan.kernel.spectrum(qx, qy, grid.spacing, 1.0)
    kernel[0, 0] = 0.0
    along = np.abs((qx, qy)[axis] + 0.0 * kernel)
    for number, n in enumerate(grid.shape):
        if n % 2 == 0:
            np.moveaxis(along, number, 0)[n // 2] *= number != axis
    loss = np.zeros(grid.shape)
    for index in zip(*np.nonzero(along), strict=True):
        modulus = RUBBER.complex_modulus(along[index] * speed) / (1.0 - RUBBER.poisson**2)
        loss[index] = -(1.0 / modulus).imag
    pressure = np.fft.fft2(state.pressure) / grid.cells
    return float(np.sum(np.abs(pressure) ** 2 * kernel * loss * along * speed)) * grid.area


@pytest.mark.parametrize("kernel", ["love", "fourier"])
@pytest.mark.parametrize(("shape", "size"), [((32, 32), 1e-3), ((33, 31), (1e-3, 2e-3)), ((16, 64), (2e-3, 1e-3))])
@pytest.mark.parametrize("speed", [0.01, 1.0, 100.0])
def test_a_wave_in_full_contact_loses_its_loss_modulus(kernel, shape, size, speed):
    """Friction is q^2 h^2 E''/4 over the mean pressure; cells of uniform pressure have another K than 2/q."""
    height, mean = 2e-6, 5e5
    wave = rc.WavySurface((height, 0.0), rc.Grid(shape, size).size[0])
    problem = slide_over(wave, shape, size, kernel=kernel)
    state = problem.slide(pressure=mean, speed=speed)
    q = 2.0 * np.pi / problem.grid.size[0]
    modulus = RUBBER.complex_modulus(q * speed) / 0.75
    response = problem.plan.kernel.spectrum(np.array([[q]]), np.array([[0.0]]), problem.grid.spacing, 1.0).item()
    right = q * height**2 * modulus.imag / (2.0 * response) / mean
    assert state.contact.all()
    assert state.friction_coefficient.value == pytest.approx(right, rel=1e-10)
    if kernel == "fourier":
        assert right == pytest.approx(q**2 * height**2 * modulus.imag / 4.0 / mean, rel=1e-12)


@pytest.mark.parametrize("shape", [(32, 32), (33, 45), (64, 16)])
def test_the_power_is_force_times_speed(shape):
    speed = 0.05
    problem = slide_over(make_rough(), shape, (SIDE, SIDE * shape[1] / shape[0]))
    state = problem.slide(pressure=2e4, speed=speed)
    numbers = state.added[0].numbers
    power = numbers["friction_coefficient"].value * state.force * speed
    assert numbers["dissipated_power"].value == pytest.approx(power, rel=1e-12)
    assert power == pytest.approx(sum_lost_power(problem, state, speed), rel=1e-12)
    assert state.friction_coefficient.value > 0.01


@pytest.mark.parametrize("boundary", ["periodic", ("periodic", "free")])
def test_slow_and_fast_bodies_are_elastic_ones(boundary):
    """A wave that does not vary along the direction is relaxed at any speed: the fast bodies have none."""
    for surface, speed, young in (
        (make_rough(), 1e-9, 1e6),
        (rc.WavySurface((20e-6, 0.0), SIDE), 1e-9, 1e6),
        (rc.WavySurface((20e-6, 0.0), SIDE), 1e9, 10e6),
    ):
        if boundary != "periodic" and speed > 1.0:
            continue
        state = slide_over(surface, boundary=boundary).slide(pressure=2e4, speed=speed)
        elastic = slide_over(surface, rubber=rc.Elastic(young, 0.5), boundary=boundary).solve(pressure=2e4)
        np.testing.assert_allclose(state.pressure, elastic.pressure, atol=1e-5 * elastic.pressure.max())
        np.testing.assert_allclose(state.gap, elastic.gap, atol=1e-5 * np.ptp(elastic.gap))
        assert state.approach == pytest.approx(elastic.approach, rel=1e-5)
        assert abs(state.friction_coefficient.value) < 1e-6


def test_the_turns_are_few():
    """22, 14, 7 and 4 of them over three decades of speed: 343, 237, 101 and 63 products on 128 x 128 cells."""
    problem = slide_over(make_rough(128), (128, 128), solver="auto")
    products = [problem.slide(pressure=14e3, speed=speed).convolutions for speed in (0.01, 0.1, 1.0)]
    assert products[0] <= 400
    assert products[1] <= 150
    assert products[2] <= 70


@pytest.mark.parametrize("speed", [0.02, 1.0])
def test_the_lag_is_that_of_the_compliance_of_each_wave(speed):
    """The whole displacement closes the gap in contact, and in no wave is there more than K conj(J)."""
    problem = slide_over(make_rough(seed=5), (32, 27))
    state = problem.slide(pressure=3e4, speed=speed)
    assert state.certificate.error < 1e-8
    total = state.displacement + state.added[0].offset
    grid = problem.grid
    qx = 2 * np.pi / grid.spacing[0] * np.fft.fftfreq(grid.shape[0])
    at_once, whole = (np.fft.fft(values, axis=0) for values in (state.displacement, total))
    moduli = np.array([1e6 if q == 0.0 else RUBBER.complex_modulus(abs(q) * speed) for q in qx])
    moduli[qx > 0.0] = np.conj(moduli[qx > 0.0])
    ratio = 10e6 / moduli
    ratio[grid.shape[0] // 2] = ratio[grid.shape[0] // 2].real
    np.testing.assert_allclose(whole, ratio[:, None] * at_once, atol=1e-9 * np.abs(whole).max())
    np.testing.assert_allclose(state.gap, problem.initial_gap + total - state.approach, atol=1e-9 * total.max())


def test_turned_and_mirrored_bodies_slide_alike():
    rough = make_rough(seed=6)
    grid = rc.Grid((36, 24), (SIDE, SIDE / 3))
    heights = rough.heights(grid)
    speed = 0.1

    def slide(values, direction, *, swapped=False):
        turned = grid if values.shape == grid.shape else rc.Grid(grid.shape[::-1], grid.size[::-1])
        road = rc.Body(rc.HeightMap(values, turned.size, periodic=True), rc.Rigid())
        flat = rc.Body(rc.FlatSurface(), RUBBER)
        pair = (road, flat) if swapped else (flat, road)
        problem = rc.ContactProblem(*pair, boundary="periodic", solver=CAREFUL)
        return problem.slide(pressure=3e4, speed=speed, direction=direction)

    first = slide(heights, 0.0)
    others = [
        (slide(heights.T.copy(), 90.0), lambda field: field.T),
        (slide(heights[::-1].copy(), 180.0), lambda field: field[::-1]),
        (slide(heights, 180.0, swapped=True), lambda field: field),
    ]
    for other, turn in others:
        np.testing.assert_allclose(turn(other.pressure), first.pressure, atol=1e-6 * first.pressure.max())
        assert other.friction_coefficient.value == pytest.approx(first.friction_coefficient.value, rel=1e-6)
    backwards = slide(heights, 180.0)
    assert np.abs(backwards.pressure - first.pressure).max() > 0.1 * first.pressure.max()
    oblique = slide(heights, 30.0), slide(heights[:, ::-1].copy(), -30.0)
    np.testing.assert_allclose(oblique[1].pressure[:, ::-1], oblique[0].pressure, atol=1e-6 * first.pressure.max())


def test_units_by_powers_of_two_change_no_bit():
    found = []
    for scale in (1.0, 2.0**30, 2.0**-20):
        rubber = rc.Viscoelastic([1e6 * scale, 9e6 * scale], [1e-3], 0.5)
        found.append(slide_over(make_rough(), rubber=rubber).slide(pressure=2e4 * scale, speed=0.1))
    for other, scale in zip(found[1:], (2.0**30, 2.0**-20), strict=True):
        np.testing.assert_array_equal(other.pressure, scale * found[0].pressure)
        assert other.friction_coefficient.value == found[0].friction_coefficient.value


def test_two_bodies_of_their_own_series():
    """The flat one lags; the one with the heights bears a pressure that does not change, and is relaxed."""
    surface = make_rough(seed=7)
    hard = rc.Viscoelastic([3e6, 5e6], [2e-3], 0.4)
    flat = rc.Body(rc.FlatSurface(), RUBBER)
    grid = rc.Grid((32, 32), SIDE)
    found = [
        rc.ContactProblem(flat, rc.Body(surface, other), grid=grid, boundary="periodic", solver=CAREFUL).slide(
            pressure=2e4, speed=0.3
        )
        for other in (hard, rc.Elastic(3e6, 0.4))
    ]
    np.testing.assert_allclose(found[0].pressure, found[1].pressure, atol=1e-6 * found[1].pressure.max())
    rigid = rc.Body(rc.FlatSurface(), rc.Rigid())
    sole = rc.ContactProblem(rigid, rc.Body(surface, RUBBER), grid=grid, boundary="periodic", solver=CAREFUL)
    relaxed = rc.ContactProblem(rigid, rc.Body(surface, rc.Elastic(1e6, 0.5)), grid=grid, boundary="periodic")
    state = sole.slide(pressure=2e4, speed=0.3)
    assert abs(state.friction_coefficient.value) < 1e-12
    np.testing.assert_allclose(state.pressure, relaxed.solve(pressure=2e4).pressure, atol=2e-3 * state.pressure.max())


@pytest.mark.parametrize("boundary", ["periodic", ("free", "periodic")])
def test_an_approach_gives_the_load_that_gives_it(boundary):
    problem = slide_over(make_rough(seed=8), boundary=boundary)
    direction = 0.0 if boundary == "periodic" else 90.0
    state = problem.slide(pressure=2e4, speed=0.1, direction=direction)
    again = problem.slide(approach=state.approach, speed=0.1, direction=direction)
    np.testing.assert_allclose(again.pressure, state.pressure, atol=1e-5 * state.pressure.max())


def test_a_state_comes_back_from_its_file(tmp_path):
    state = slide_over(make_rough()).slide(pressure=2e4, speed=0.1)
    state.verify()
    state.save(tmp_path / "state.npz")
    again = rc.load(tmp_path / "state.npz")
    assert again.friction_coefficient == state.friction_coefficient
    assert str(again) == str(state)
    assert "friction coefficient" in str(state)
    lagging = state.added[0]
    wrong = attrs.evolve(state, added=(attrs.evolve(lagging, offset=1.001 * lagging.offset),))
    with pytest.raises(rc.InputError, match="change of the gap"):
        state.origin.source.verify(wrong)


@pytest.mark.slow
def test_areas_at_a_speed_hold_on_finer_cells():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=SIDE / 4, longest=SIDE, seed=9)
    for speed in (0.02, 0.2, 2.0):
        coarse, fine = (slide_over(surface, (n, n)).slide(pressure=3e4, speed=speed) for n in (48, 144))
        assert coarse.area().estimator == "level-set"
        for one, other in (
            (coarse.area(), fine.area()),
            (coarse.friction_coefficient, fine.friction_coefficient),
        ):
            assert abs(one.value - other.value) <= 2.0 * np.hypot(one.uncertainty, other.uncertainty)


def test_a_sweep_of_loads_at_a_speed():
    problem = slide_over(make_rough(), laws=rc.SteadySliding("0.1m/s"))
    sweep = problem.sweep(pressure=[1e4, 2e4, 4e4])
    alone = problem.solve(pressure=2e4)
    np.testing.assert_allclose(sweep[1].pressure, alone.pressure, atol=1e-6 * alone.pressure.max())
    friction = sweep.table().columns["friction_coefficient"]
    assert len(friction) == 3
    assert problem.path(pressure=[1e4, 2e4])[1].friction_coefficient.value == pytest.approx(
        alone.friction_coefficient.value, rel=1e-6
    )


@pytest.mark.parametrize(
    ("made", "asked", "words"),
    [
        ({}, {"speed": -1.0}, "speed"),
        ({}, {"speed": 1.0, "friction": 0.3}, "give one of them"),
        ({"rubber": rc.Elastic(1e6, 0.5)}, {"speed": 1.0}, "viscoelastic"),
        ({"boundary": "free"}, {"speed": 1.0}, "periodic along its direction"),
        ({"boundary": ("periodic", "free")}, {"speed": 1.0, "direction": 90.0}, "along y"),
        ({"boundary": "wrapped"}, {"speed": 1.0}, "periodic along its direction"),
    ],
)
def test_what_does_not_slide_steadily_gets_a_sentence(made, asked, words):
    with pytest.raises(rc.InputError, match=words):
        slide_over(make_rough(), solver="auto", **made).slide(pressure=2e4, **asked)


def test_two_rough_bodies_do_not_slide_steadily():
    body = rc.Body(make_rough(seed=1), RUBBER)
    other = rc.Body(make_rough(seed=2), rc.Rigid())
    problem = rc.ContactProblem(body, other, grid=rc.Grid((32, 32), SIDE), boundary="periodic")
    with pytest.raises(rc.InputError, match="pass over each other"):
        problem.slide(pressure=2e4, speed=1.0)
    with pytest.raises(rc.InputError, match="adhesion"):
        slide_over(make_rough(), solver="auto", adhesion=rc.Exponential(0.05, 1e-6)).slide(pressure=2e4, speed=1.0)


def test_answers_by_one_modulus_are_refused():
    state = slide_over(make_rough()).slide(pressure=2e4, speed=0.1)
    with pytest.raises(rc.InputError, match="relax"):
        state.stiffness()
    with pytest.raises(rc.InputError, match="does not slide"):
        _ = slide_over(make_rough()).solve(pressure=2e4).friction_coefficient


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fall", "speed", "pressure", "ratio"),
    [(100.0, 5e-3, 2e4, 4.9), (1000.0, 1.6e-3, 2e4, 15.0), (1e3, 2e-4, 2e5, 8.0)],
)
def test_bodies_that_lose_more_than_they_store_slide_too(fall, speed, pressure, ratio):
    """With a loss modulus of up to 15 times the storage modulus, in small contacts and nearly full ones."""
    rubber = rc.Viscoelastic([1e6, (fall - 1.0) * 1e6], [1e-3], 0.5)
    moduli = map(rubber.complex_modulus, 2e3 * np.pi * speed * np.arange(1, 9))
    assert max(one.imag / one.real for one in moduli) > ratio
    state = slide_over(make_rough(), rubber=rubber, solver="auto").slide(pressure=pressure, speed=speed)
    state.verify()
    assert state.friction_coefficient.value > 0.01
