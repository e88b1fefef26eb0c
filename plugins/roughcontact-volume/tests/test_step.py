"""The return of a stress and the step of flow, against closed forms and other ways."""

import numpy as np
import pytest

from roughcontact_volume import LinearHardening, Plastic, SwiftHardening, TabulatedHardening, VoceHardening
from roughcontact_volume.anderson import AndersonMixing
from roughcontact_volume.radial_return import (
    WEIGHTS,
    find_accumulated,
    find_deviator,
    find_equivalent,
    find_flow,
    find_multiplier,
)
from roughcontact_volume.step import NO_FLOW, FlowingCells, solve_step

EACH = [
    LinearHardening(0.0),
    LinearHardening("4GPa"),
    SwiftHardening(strain=1e-4, power=0.1),
    VoceHardening("3GPa", strain=0.001),
    TabulatedHardening(strain=[0.0001, 0.001, 0.0011, 0.1], stress=["1GPa", "1.0001GPa", "2GPa", "2.1GPa"]),
]


def make_material(hardening):
    return Plastic("200GPa", 0.25, "1GPa", hardening)


def solve_one(find_stress, strain, material, tolerance, start=NO_FLOW):
    """Return the step of a single body."""
    cells = FlowingCells(material, strain, start)
    return solve_step(lambda flows, error: [find_stress(flows[0], error)], [cells], tolerance)


def find_step(body_stress, strain, material, tolerance, *start):
    """Return the flow of a step as a field, and its evaluations."""
    step = solve_one(body_stress, strain, material, tolerance, *start)
    assert step.error <= tolerance
    return step.flows[0].fill(strain.shape), step.evaluations


def draw_stress(count, seed=0):
    return 2e9 * np.random.default_rng(seed).standard_normal((6, count))


@pytest.mark.parametrize("hardening", EACH)
def test_multiplier_ends_at_the_yield_surface(hardening):
    material = make_material(hardening)
    rng = np.random.default_rng(1)
    trial = 1e9 * rng.uniform(0.0, 20.0, 2000)
    strain = np.where(rng.random(2000) < 0.3, 0.0, 0.02 * rng.random(2000))
    found = find_multiplier(trial, strain, material)
    elastic = trial <= material.find_yield_stress(strain)
    assert np.all(found[elastic] == 0.0)
    assert np.all(found[~elastic] > 0.0)
    rest = trial - 3.0 * material.shear_modulus * found - material.find_yield_stress(strain + found)
    assert np.abs(rest[~elastic]).max() < 1e-13 * trial.max()


def test_uniaxial_stress_with_linear_hardening():
    # Stretched to a strain e without lateral stress: s = Y + H (e - Y/E) E / (E + H), by the tangent modulus.
    material = make_material("4GPa")
    young, hardening, limit = 200e9, 4e9, 1e9
    strain = 0.02
    slip = (strain - limit / young) * young / (young + hardening)

    def find_stress(flow, error):
        stress = np.zeros((6, 1, 1, 1))
        # Laterally free: only the axial strain that does not flow is stress.
        stress[0] = young * (strain - flow[0])
        return stress

    flow, _ = find_step(find_stress, np.zeros((1, 1, 1)), material, 1e-10)
    assert find_accumulated(flow).item() == pytest.approx(slip, rel=1e-9)
    assert flow.ravel() == pytest.approx(slip * np.array([1.0, -0.5, -0.5, 0.0, 0.0, 0.0]), rel=1e-9)


def test_simple_shear_of_perfect_plasticity():
    material = make_material(None)
    shear = 0.01

    def find_stress(flow, error):
        stress = np.zeros((6, 1, 1, 1))
        stress[5] = 2.0 * material.shear_modulus * (shear - flow[5])
        return stress

    flow, _ = find_step(find_stress, np.zeros((1, 1, 1)), material, 1e-10)
    left = 2.0 * material.shear_modulus * (shear - flow[5].item())
    assert left == pytest.approx(1e9 / np.sqrt(3.0), rel=1e-9)


def test_flow_has_the_direction_of_the_stress_and_no_volume():
    material = make_material("4GPa")
    stress = draw_stress(100)
    flow = find_flow(stress, np.zeros_like(stress), np.zeros(100), material)
    deviator = find_deviator(stress)
    flows = flow.any(axis=0)
    assert 0 < flows.sum() < 101
    assert np.abs(flow[:3].sum(axis=0)).max() < 1e-15 * np.abs(flow).max() * 10
    ratio = flow[:, flows] / deviator[:, flows]
    assert np.ptp(ratio, axis=0).max() < 1e-12 * ratio.max()
    after = stress - 2.0 * material.shear_modulus * flow
    assert find_equivalent(after)[flows] == pytest.approx(
        material.find_yield_stress(find_accumulated(flow))[flows], rel=1e-12
    )


class _Coupled:
    """Cells whose stress is coupled by a random symmetric map with a spectrum within 0 to 2 mu, as of a half-space."""

    def __init__(self, material, cells, seed=0):
        rng = np.random.default_rng(seed)
        size = 6 * cells
        basis, _ = np.linalg.qr(rng.standard_normal((size, size)))
        spectrum = rng.uniform(0.05, 1.0, size)
        self.roots = np.sqrt(np.repeat(WEIGHTS, cells))
        self.matrix = 2.0 * material.shear_modulus * (basis * spectrum) @ basis.T
        self.load = 2e9 * rng.standard_normal(size)
        self.shape = (6, cells, 1, 1)

    def find_stress(self, flow, error=0.0):
        weighed = self.roots * flow.reshape(-1)
        return ((self.load - self.matrix @ weighed) / self.roots).reshape(self.shape)


@pytest.mark.parametrize("hardening", EACH)
def test_step_is_a_fixed_point_that_plain_iteration_finds_too(hardening):
    material = make_material(hardening)
    body = _Coupled(material, 12)
    strain = np.full((12, 1, 1), 1e-4)
    mixed, evaluations = find_step(body.find_stress, strain, material, 1e-9)
    plain = np.zeros(body.shape)
    for rounds in range(1, 10_000):  # noqa: B007
        new = find_flow(
            body.find_stress(plain).reshape(6, -1), plain.reshape(6, -1), strain.reshape(-1), material
        ).reshape(body.shape)
        change = np.abs(new - plain).max()
        plain = new
        if change < 1e-13:
            break
    assert mixed == pytest.approx(plain, abs=2e-8 * np.abs(plain).max() + 1e-9)
    assert evaluations < rounds / 3


def test_step_from_a_guess_finds_the_same():
    material = make_material("4GPa")
    body = _Coupled(material, 12)
    strain = np.zeros((12, 1, 1))
    (first,) = solve_one(body.find_stress, strain, material, 1e-9).flows
    again, _ = find_step(body.find_stress, strain, material, 1e-9, first.halve())
    assert again == pytest.approx(first.fill(strain.shape), abs=1e-8 * np.abs(first.values).max())


def test_bodies_in_one_step_are_one_body_of_all_their_cells():
    material = make_material("4GPa")
    body = _Coupled(material, 12)
    together, _ = find_step(body.find_stress, np.zeros((12, 1, 1)), material, 1e-10)

    def find_stresses(flows, error):
        stress = body.find_stress(np.concatenate(flows, axis=1))
        return stress[:, :5], stress[:, 5:]

    step = solve_step(find_stresses, [FlowingCells(material, np.zeros((count, 1, 1))) for count in (5, 7)], 1e-10)
    apart = [flow.fill((count, 1, 1)) for flow, count in zip(step.flows, (5, 7), strict=True)]
    assert np.concatenate(apart, axis=1) == pytest.approx(together, abs=1e-9 * np.abs(together).max())


def test_elastic_step_needs_one_stress():
    material = make_material("4GPa")
    step = solve_one(lambda flow, error: np.full((6, 3, 2, 2), 1e7), np.zeros((3, 2, 2)), material, 1e-4)
    assert step.evaluations == 1
    assert not step.flows[0].is_any


def test_a_step_that_is_given_up_states_its_error():
    material = make_material(None)
    rng = np.random.default_rng(5)
    step = solve_one(lambda flow, error: 5e9 * rng.standard_normal((6, 1, 1, 1)), np.zeros((1, 1, 1)), material, 1e-4)
    assert step.error > 1e-4


def test_mixing_solves_a_linear_problem_in_as_many_steps_as_it_has_dimensions():
    rng = np.random.default_rng(3)
    basis, _ = np.linalg.qr(rng.standard_normal((6, 6)))
    # Five directions contract slowly.
    matrix = basis @ np.diag([0.9, 0.8, 0.5, 0.3, 0.0, 0.0]) @ basis.T
    load = rng.standard_normal(6)
    mixing = AndersonMixing()
    mixing.add_cells(np.arange(1))
    values = np.zeros((6, 1))
    for _ in range(7):
        values = mixing.find_next(values, (matrix @ values[:, 0] + load)[:, np.newaxis] - values)
    assert values[:, 0] == pytest.approx(np.linalg.solve(np.eye(6) - matrix, load), rel=1e-5)


def test_mixing_takes_cells_that_come_later_as_zero():
    one, all_at_once = AndersonMixing(), AndersonMixing()
    all_at_once.add_cells(np.arange(3))
    rng = np.random.default_rng(4)
    first, second = rng.standard_normal((6, 2)), rng.standard_normal((6, 3))
    one.add_cells(np.array([0, 2]))
    one.find_next(0.0 * first, first)
    one.add_cells(np.array([1, 2]))
    spread = np.zeros((6, 3))
    spread[:, [0, 2]] = first
    all_at_once.find_next(0.0 * spread, spread)
    assert one.cells.tolist() == [0, 1, 2]
    assert np.array_equal(one.find_next(spread, second), all_at_once.find_next(spread, second))


def test_same_bits_in_units_of_a_power_of_two():
    material = make_material("4GPa")
    body = _Coupled(material, 12)
    strain = np.zeros((12, 1, 1))
    flow, _ = find_step(body.find_stress, strain, material, 1e-6)
    scale = 2.0**10
    scaled = Plastic(200e9 * scale, 0.25, 1e9 * scale, 4e9 * scale)
    again, _ = find_step(lambda flow, error: scale * body.find_stress(flow), strain, scaled, 1e-6)
    assert np.array_equal(flow, again)
