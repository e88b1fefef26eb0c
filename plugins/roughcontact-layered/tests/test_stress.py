"""Stress below layers: waves, balls and sliding contacts beside independent solutions."""

import itertools

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.typing import StressConvolution

from independent import series_by_rings, stress_of_waves, von_mises_below_sphere
from roughcontact_layered import Layer, LayeredKernel

STEEL = rc.Elastic(1e9, 0.3)
C = STEEL.compliance
TWO_LAYERS = (Layer(3e9, 0.2, 1.0), Layer(0.5e9, 0.4, 0.7))
# Depths in both layers, at the interfaces and below, with the number of the layer.
PLACES = ((0.0, 0), (0.4, 0), (1.0, 0), (1.3, 1), (1.7, 1), (2.5, 2))


def ball(kernel, shape=(40, 40), size=(10 / 3, 10 / 3), boundary="free", counterbody=rc.RIGID_FLAT):
    body = rc.Body(rc.ParaboloidSurface(20.0), STEEL)
    return rc.ContactProblem(body, counterbody, grid=rc.Grid(shape, size), kernel=kernel, boundary=boundary)


@pytest.mark.parametrize(("axis", "shape"), [(0, (64, 6)), (1, (5, 64))])
def test_a_wave_of_pressure_has_the_stress_of_the_boundary_value_problem(axis, shape):
    size = (4.0, 3.0)
    kernel = LayeredKernel(TWO_LAYERS, substrate=STEEL)
    length = size[axis]
    amplitudes = [1e-4, 0.0] if axis == 0 else [0.0, 1e-4]
    body = rc.Body(rc.WavySurface(tuple(amplitudes), (length if axis == 0 else 1.5, length if axis else 2.0)), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid(shape, size), kernel=kernel, boundary="periodic")
    solution = problem.solve(pressure=1e6)
    assert solution.contact.all()
    depths = np.array([depth for depth, _ in PLACES])
    found = solution.stress(depths).components
    q = np.array([2 * np.pi / length])
    wave = np.exp(-2j * np.pi * np.arange(64) / 64)
    pressure = 2 * np.mean(np.moveaxis(solution.pressure, axis, 0)[:, 0] * wave)
    order = (0, 1, 2, 4) if axis == 0 else (1, 0, 2, 3)
    for place, (depth, number) in enumerate(PLACES):
        exact = [one.item() for one in stress_of_waves(kernel.layers, STEEL, q, depth, number)]
        for component, value in zip(order, exact, strict=True):
            amplitude = 2 * np.mean(np.moveaxis(found[place, component], axis, 0)[:, 0] * wave) / pressure
            # The shear is a quarter of a wave aside.
            part = -amplitude.imag if component == order[3] else amplitude.real
            assert part == pytest.approx(value, abs=2e-3)


@pytest.mark.parametrize(
    ("boundary", "friction"),
    [("free", None), ("free", 0.3), ("periodic", None), ("periodic", 0.3), (("periodic", "free"), 0.3)],
)
def test_layers_of_the_same_material_change_nothing(boundary, friction):
    size = (5.0, 15.0)
    same = LayeredKernel((Layer(1e9, 0.3, 0.4), Layer(1e9, 0.3, 0.9)), substrate=STEEL)
    fields = []
    for kernel in (same, "love"):
        solution = ball(kernel, (31, 34), size, boundary).solve(force=3e7)
        fields.append(solution.stress([0.0, 0.2, 0.4, 1.0, 3.0], friction=friction).components)
    assert np.abs(fields[0] - fields[1]).max() < 1e-5 * solution.pressure.max()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize(("shape", "size"), [((48, 16), (4.0, 4.0)), ((15, 45), (4.0, 4.2))])
def test_tractions_are_continuous_and_those_of_the_load(boundary, shape, size):
    kernel = LayeredKernel(TWO_LAYERS, substrate=STEEL)
    solution = ball(kernel, shape, size, boundary).solve(force=5e7)
    top = solution.pressure.max()
    sides = [(1.0 + sign * 1e-9) * depth for depth in (1.0, 1.7) for sign in (-1.0, 1.0)]
    found = solution.stress([0.0, *sides], friction=0.3, direction=90.0).components / top
    if boundary == "free":
        assert found[0, 2] == pytest.approx(-solution.pressure / top, abs=1e-6)
        assert found[0, 3] == pytest.approx(-0.3 * solution.pressure / top, abs=1e-6)
    for above, below in ((1, 2), (3, 4)):
        assert np.abs(found[above, 2:5] - found[below, 2:5]).max() < 1e-6
        assert np.abs(found[above, 0] - found[below, 0]).max() > 0.02


def test_the_axes_can_be_exchanged():
    kernel = LayeredKernel(TWO_LAYERS, substrate=STEEL)
    fields = []
    for order in (1, -1):
        solution = ball(kernel, (24, 12)[::order], (4.0, 5.0)[::order]).solve(force=5e7)
        stress = solution.stress([0.0, 0.5, 1.5], friction=0.3, direction=0.0 if order == 1 else 90.0)
        fields.append(stress.components / solution.pressure.max())
    exchanged = fields[1][:, [1, 0, 2, 4, 3, 5]].transpose(0, 1, 3, 2)
    assert np.abs(fields[0] - exchanged).max() < 1e-4


def test_images_far_away_do_not_matter():
    """Hankel's transform over a free domain and waves with their aliases agree as the images go."""
    kernel = LayeredKernel((Layer(3e9, 0.2, 0.5),), substrate=STEEL)
    depths = [0.0, 0.3, 0.5, 0.8]
    free = ball(kernel, (32, 24), (4.0, 3.0)).solve(force=3e7)
    own = free.stress(depths, friction=0.2).components
    errors = []
    for times in (2, 4):
        grid = (32 * times, 24 * times), (4.0 * times, 3.0 * times)
        periodic = ball(kernel, *grid, boundary="periodic").solve(force=3e7)
        found = periodic.stress(depths, friction=0.2).components
        corner = [(n - m) // 2 for n, m in zip(grid[0], (32, 24), strict=True)]
        inside = found[:, :, corner[0] : corner[0] + 32, corner[1] : corner[1] + 24]
        errors.append(np.abs(inside - own).max() / free.pressure.max())
    assert errors[1] < 0.4 * errors[0] < 0.02


def convolve(kernel, loads, depth, boundary, sides, of):
    grid = rc.Grid(loads.shape, (loads.shape[0] * sides[0], loads.shape[1] * sides[1]))
    convolution = StressConvolution(kernel, grid, rc.Boundary(boundary))
    return convolution.apply(convolution.transform(loads[np.newaxis], of), depth, of)


@pytest.mark.parametrize(
    ("layers", "substrate", "of", "exchanged"),
    [
        (TWO_LAYERS, STEEL, "z", "z"),
        (TWO_LAYERS[1], STEEL, "x", "y"),
        (TWO_LAYERS, rc.Rigid(), "x", "y"),
        (TWO_LAYERS, rc.Rigid(), "y", "x"),
    ],
)
def test_along_a_line_the_stress_is_that_of_images_ever_further_away(layers, substrate, of, exchanged):
    kernel = LayeredKernel(layers, substrate=substrate)
    sides = (0.4, 0.25)
    loads = np.random.default_rng(3).random((15, 6))
    for depth in (0.0, 0.7, 1.6):
        periodic = [
            convolve(kernel, np.pad(loads, ((0, 15 * times), (0, 0))), depth, "periodic", sides, of)[:, :15]
            for times in (15, 31, 63)
        ]
        # The mean pressure falls as the inverse of the period, the images as that of its square.
        near, far = (2.0 * more - less for less, more in itertools.pairwise(periodic))
        found = convolve(kernel, loads, depth, "free-periodic", sides, of)
        assert np.abs(found - (4.0 * far - near) / 3.0).max() < 1e-5
        turned = convolve(kernel, loads.T, depth, "periodic-free", sides[::-1], exchanged)
        assert np.abs(turned[[1, 0, 2, 4, 3, 5]].transpose(0, 2, 1) - found).max() < 1e-6


@pytest.mark.parametrize("ratio", [3.0, 1.0 / 3.0])
@pytest.mark.parametrize("thickness", [0.2, 0.5, 1.0])
def test_the_maximum_in_coating_and_substrate_is_the_integral_of_hankel(ratio, thickness):
    kernel = LayeredKernel(Layer(ratio * STEEL.young, 0.3, thickness), substrate=STEEL)
    series, _ = series_by_rings(lambda q: kernel.response(q, C), 1 / kernel.layers[0].compliance, 20.0, 1.0)
    force = 2 * np.pi * sum(c / (2 * k + 1) for k, c in enumerate(series, 1))
    r = np.linspace(0.0, 1.3, 53)
    inside = np.linspace(0.1, 1.0 - 1e-9, 10) * thickness
    below = thickness + np.linspace(1e-9, 1.0, 9)
    exact = [
        max(von_mises_below_sphere(kernel, series, 1.0, depth, number, r).max() for depth in depths)
        for number, depths in enumerate((inside, below))
    ]
    solution = ball(kernel, (40, 37), (10 / 3, 37 / 12)).solve(force=force)
    profile = solution.stress(np.concatenate((inside, below))).profile
    assert profile[:10].max() == pytest.approx(exact[0], rel=2e-3)
    assert profile[10:].max() == pytest.approx(exact[1], rel=2e-3)


def test_first_yield_is_that_of_the_maximum_at_an_interface():
    kernel = LayeredKernel(Layer(3e9, 0.3, 0.5), substrate=STEEL)
    problem = ball(kernel, (24, 24))
    point = problem.solve(force=3e7).first_yield(yield_stress=45e6)
    assert point.maximum.depth == pytest.approx(0.5, rel=1e-6)
    assert not any("largest of the depths" in text for text in point.warnings)
    again = problem.solve(force=point.force.value).stress().maximum
    assert again.value == pytest.approx(45e6, rel=5e-3)


def test_the_other_body_is_a_half_space():
    steel = rc.Body(rc.FlatSurface(), rc.Elastic(2e9, 0.25))
    kernel = LayeredKernel(Layer(3e9, 0.2, 0.5), substrate=STEEL)
    problem = ball(kernel, (24, 24), counterbody=steel)
    solution = problem.solve(force=3e7)
    found = solution.stress([0.3], body="counterbody").components
    uncoated = attrs.evolve(problem, kernel="love").solve(force=3e7, start=solution.pressure)
    # The stress of the same pressure below a homogeneous body.
    expected = uncoated.stress([0.3], body="counterbody").components
    ratio = np.abs(uncoated.pressure - solution.pressure).max() / solution.pressure.max()
    assert np.abs(found - expected).max() < 2.0 * ratio * solution.pressure.max()
    assert np.abs(solution.stress([0.3]).components - found).max() > 0.1 * solution.pressure.max()


def test_what_is_not_known_is_refused_in_words():
    kernel = LayeredKernel(Layer(3e9, 0.2, 0.01), substrate=STEEL)
    thin = ball(kernel, (16, 16), boundary="periodic").solve(force=3e7)
    with pytest.raises(rc.InputError, match="do not resolve: take a finer grid, or thicker layers"):
        thin.stress([0.005]).components  # noqa: B018


@pytest.mark.parametrize(("young", "weaker"), [(400e9, 1e9), (60e9, 1e9), (400e9, 6e9), (60e9, 6e9)])
def test_each_layer_yields_by_its_own_strength(young, weaker):
    """At first yield the maximum in one layer is its strength, and those in the others are below theirs."""
    steel = rc.Elastic(210e9, 0.3)
    layers = Layer(young, 0.25, 4e-6, yield_stress=weaker), Layer(100e9, 0.3, 3e-6)
    kernel = LayeredKernel(layers, substrate=steel)
    ball = rc.Body(rc.ParaboloidSurface(1e-3), steel)
    # Cells 3:2, odd numbers of them.
    grid = rc.Grid((27, 41), (81e-6, 82e-6))
    problem = rc.ContactProblem(ball, grid=grid, kernel=kernel, boundary="periodic")
    point = problem.solve(force=1.0).first_yield(yield_stress=2e9)
    maxima = problem.solve(force=point.force.value).stress().maxima
    ratios = {number: one.value / (weaker, 2e9, 2e9)[number] for number, one in maxima.items()}
    assert set(ratios) == {0, 1, 2}
    yielding = max(ratios, key=ratios.get)
    assert ratios[yielding] == pytest.approx(1.0, abs=1e-3)
    assert point.layer == (yielding + 1) % 3
    # A strength that is the body's changes nothing.
    alike = attrs.evolve(kernel, layers=(attrs.evolve(layers[0], yield_stress=2e9), layers[1]))
    bare = attrs.evolve(kernel, layers=(attrs.evolve(layers[0], yield_stress=None), layers[1]))
    one, other = (
        attrs.evolve(problem, kernel=chosen).solve(force=1.0).first_yield(yield_stress=2e9) for chosen in (alike, bare)
    )
    assert (one.force, one.layer) == (other.force, other.layer)
