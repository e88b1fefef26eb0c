"""The judge by itself, and the operators beside what it finds: no code is common to both."""

import numpy as np
import pytest
import roughcontact as rc
from scipy.optimize import nnls

from judge import WEIGHTS, HalfSpace, State, displacement_of_cells, judge
from roughcontact_volume import VolumeOperators

YOUNG, POISSON, MODULUS = 200.0, 0.3, 200.0 / 0.91


def harden(accumulated):
    return 1.0 + 4.0 * accumulated


def measure(field, other):
    return np.abs(field - other).max() / np.abs(other).max()


def draw_strain(shape, layers, seed, smooth=False):
    """Return a random eigenstrain; a smooth one is without volume and small towards the border."""
    rng = np.random.default_rng(seed)
    if not smooth:
        return rng.normal(size=(6, layers, *shape))
    x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    bell = np.exp(-4 * (x**2 + y**2))
    parts = np.array([bell, -bell, x * bell, y * bell, x * y * bell])
    strain = np.tensordot(rng.normal(size=(6, layers, 5)), parts, axes=1)
    strain[2] = -strain[0] - strain[1]
    return strain


SCENES = [
    ((6, 7), (1.0, 1.0), (0.7, 0.8), 0.3),
    ((8, 5), (1.0, 3.0), (0.5, 1.0, 0.3), 0.1),
    ((5, 8), (3.0, 1.0), (1.0, 2.0), 0.45),
]
MORE_SCENES = [
    ((3, 4), (2e-6, 1e-6), (1e-6,), 0.0),
    ((9, 6), (1.0, 6.0), (0.2, 0.2, 4.0, 9.0), -0.3),
    ((1, 7), (1.0, 1.0), (1.0, 1.0), 0.3),
    ((12, 10), (1.0, 1.0), (0.5, 0.6, 0.7, 0.8), 0.49),
]


def make(scene, boundary):
    shape, spacing, thicknesses, poisson = scene
    grid = rc.Grid(shape, (shape[0] * spacing[0], shape[1] * spacing[1]))
    operators = VolumeOperators(grid, boundary, thicknesses, YOUNG, poisson)
    return operators, HalfSpace(shape, spacing, thicknesses, rc.Boundary(boundary).repeats, YOUNG, poisson)


def compare_periodic(scene):
    operators, body = make(scene, "periodic")
    strain = draw_strain(scene[0], len(scene[2]), 1)
    pressure = np.random.default_rng(2).random(scene[0])
    assert measure(operators.find_stress(strain), body.find_stress(strain)) < 1e-10
    assert measure(operators.displace(strain), body.displace(strain)) < 1e-10
    assert measure(operators.press(pressure), body.press(pressure)) < 1e-10


def compare_free(scene):
    operators, body = make(scene, "free")
    pressure = np.random.default_rng(2).random(scene[0])
    for smooth, allowed in ((True, 2e-3), (False, 1e-2)):
        strain = draw_strain(scene[0], len(scene[2]), 1, smooth)
        assert measure(operators.displace(strain), body.displace(strain)) < 1e-12
        assert measure(operators.find_stress(strain), body.find_stress(strain)) < allowed
    assert measure(operators.press(pressure), body.press(pressure)) < 1e-12


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_periodic_maps_are_those_of_finite_elements_in_depth(scene):
    compare_periodic(scene)


@pytest.mark.parametrize("scene", SCENES[1:2], ids=str)
def test_free_maps_are_those_of_love_and_of_long_periods(scene):
    compare_free(scene)


@pytest.mark.slow
@pytest.mark.parametrize("scene", MORE_SCENES, ids=str)
def test_more_periodic_maps(scene):
    compare_periodic(scene)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [SCENES[0], SCENES[2], *MORE_SCENES], ids=str)
def test_more_free_maps(scene):
    compare_free(scene)


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "boundary"), [(SCENES[0], "free-periodic"), (SCENES[1], "periodic-free")], ids=str)
def test_mixed_maps_are_those_of_images(scene, boundary):
    operators, body = make(scene, boundary)
    pressure = np.random.default_rng(2).random(scene[0])
    assert measure(operators.press(pressure), body.press(pressure)) < 5e-4
    for smooth, allowed in ((True, 2e-3), (False, 1e-2)):
        strain = draw_strain(scene[0], len(scene[2]), 1, smooth)
        assert measure(operators.displace(strain), body.displace(strain)) < 5e-4
        assert measure(operators.find_stress(strain), body.find_stress(strain)) < allowed


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.0, 3.0)])
def test_displacements_by_pressure_are_those_of_the_core(boundary, spacing):
    shape = (6, 7)
    grid = rc.Grid(shape, (shape[0] * spacing[0], shape[1] * spacing[1]))
    ball = rc.Body(rc.ParaboloidSurface(40.0), rc.Elastic(YOUNG, POISSON))
    solution = rc.ContactProblem(ball, grid=grid, boundary=boundary).solve(pressure=0.5)
    body = HalfSpace(shape, spacing, (1.0,), rc.Boundary(boundary).repeats, YOUNG, POISSON)
    found = body.sink(solution.pressure, MODULUS)
    expected = solution.displacement
    assert np.abs((found - expected) - (found - expected).mean()).max() < 1e-5 * np.ptp(expected)


def solve_step(body, heights, approach, before, accumulated_before):
    """Return the state of a step by plain iteration, with the contact found anew in each turn."""
    nx, ny = body.shape
    table = displacement_of_cells(body.shape, body.spacing) / MODULUS
    i, j = np.divmod(np.arange(nx * ny), ny)
    matrix = table[i[:, None] - i + nx - 1, j[:, None] - j + ny - 1]
    factor = np.linalg.cholesky(matrix)
    flow = np.zeros_like(before)
    grown = np.zeros_like(accumulated_before)
    stiff = body.young / (1 + body.poisson)
    for _ in range(40):
        deep = (approach - heights - body.displace(before + flow)).ravel()
        pressure = nnls(factor.T, np.linalg.solve(factor, deep))[0].reshape(body.shape)
        stress = body.press(pressure) + body.find_stress(before + flow)
        trial = stress + stiff * flow
        trial[:3] -= trial[:3].mean(axis=0)
        mises = np.sqrt(1.5 * np.einsum("c,cijk->ijk", WEIGHTS, trial**2))
        grown = np.maximum(mises - harden(accumulated_before), 0.0) / (1.5 * stiff + 4.0)
        flow = 1.5 * grown * trial / mises
    return State(
        pressure, heights, MODULUS, before, before + flow, accumulated_before, accumulated_before + grown, harden
    )


@pytest.fixture(scope="module")
def judged():
    """A body of its own operators, and two states of it: a first step, and one from it."""
    body = HalfSpace((7, 6), (1.0, 1.2), (0.7, 0.9, 1.2), (False, False), YOUNG, POISSON)
    x, y = (np.arange(n)[:, None] - n / 2 for n in body.shape)
    heights = ((x + 0.3) ** 2 + (1.2 * y.T - 0.2) ** 2) / 2 / 100.0
    nothing = np.zeros((6, 3, *body.shape))
    first = solve_step(body, heights, 0.09, nothing, nothing[0])
    return body, [first, solve_step(body, heights, 0.12, first.strain, first.accumulated)]


def test_true_states_are_found_true(judged):
    body, states = judged
    for state in states:
        assert state.accumulated.max() > 1e-3
        assert judge(body, state).find_faults(1e-4, 1e-6) == []


def scale(name, factor):
    return lambda state: state._replace(**{name: getattr(state, name) * factor})


def press_apart(state):
    pressure = state.pressure.copy()
    pressure[0, 0] = 0.01 * pressure.max()
    return state._replace(pressure=pressure)


def turn_strain(state):
    flow = state.strain - state.strain_before
    return state._replace(strain=state.strain + 0.05 * (flow[[1, 0, 2, 4, 3, 5]] - flow))


@pytest.mark.parametrize(
    ("damage", "fault"),
    [
        (scale("strain", 1.02), "accumulation"),
        (scale("accumulated", 1.02), "below_yield"),
        (scale("accumulated", 0.9), "recovery"),
        (scale("pressure", 1.01), "beyond_yield"),
        (scale("pressure", 0.99), "opening"),
        (scale("heights", 1.01), "penetration"),
        (lambda state: state._replace(strain=state.strain + 1e-5 * WEIGHTS[:, None, None, None]), "volume"),
        (lambda state: state._replace(pressure=state.pressure - 0.01), "tension"),
        (press_apart, "opening"),
        (turn_strain, "direction"),
    ],
)
def test_false_states_are_found_false(judged, damage, fault):
    body, states = judged
    faults = judge(body, damage(states[1])).find_faults(1e-3, 1e-4)
    assert any(one.startswith(fault) for one in faults), faults
