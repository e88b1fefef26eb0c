"""The finite elements of `ball_by_elements.py` by themselves: Hertz's contact, closed forms, published fits."""

import math

import numpy as np
import pytest

from ball_by_elements import (
    DEPTHS,
    ELASTIC,
    ELASTIC_LOAD,
    FIRST,
    HARDENINGS,
    POISSON,
    SHEAR,
    UNIT_APPROACH,
    YOUNG,
    Body,
    Memory,
    hertz_radius,
    load_answers,
    press,
    return_stress,
)


@pytest.fixture(scope="module")
def pressed():
    """Elastic bodies under the unit of load, with 8 and with 16 elements along the contact radius."""
    bodies = [Body(count, 1.0, ELASTIC) for count in (8, 16)]
    for body in bodies:
        body.load(1.0)
    return bodies


def mises(radial, down):
    return np.abs(radial - down)


def test_hertz_in_second_order(pressed):
    for found in ([body.approach / UNIT_APPROACH for body in pressed], [b.maximum_pressure() / FIRST for b in pressed]):
        coarse, fine = (abs(value - 1) for value in found)
        assert fine < coarse / 3
        assert fine < 0.008
    assert abs(pressed[1].contact_radius() - 1) < 0.6 / 16


def test_stress_on_the_axis_is_that_of_huber(pressed):
    z = np.array(DEPTHS[1:])
    down = -FIRST / (1 + z**2)
    radial = -FIRST * ((1 + POISSON) * (1 - z * np.arctan(1 / z)) - 0.5 / (1 + z**2))
    for body, error in zip(pressed, (0.012, 0.003), strict=True):
        assert np.abs(body.on_axis(z) - (radial, down)).max() < error * FIRST


def test_first_yield_at_1_60(pressed):
    z = np.linspace(0.3, 0.7, 401)
    stress = mises(*pressed[1].on_axis(z))
    assert abs(z[stress.argmax()] - 0.48) < 0.01
    # The unit of load is 1.60 Y rounded; the load that the steps start from is below it.
    assert abs(FIRST / stress.max() - 1.612) < 0.006
    assert stress.max() * hertz_radius(ELASTIC_LOAD) < 1


def test_confined_compression_in_one_step_or_many():
    """A strain along one axis, sides held: s_zz - s_rr = -Y(k) and k = 2/3 of what is not elastic, in closed form."""
    hardening, strain, slope = HARDENINGS["linear"], -0.02, 0.02 * YOUNG
    accumulated = (2 * SHEAR * abs(strain) - 1) / (3 * SHEAR + slope)
    for steps in (1, 7):
        memory = Memory(np.zeros((1, 1, 4)), np.zeros((1, 1)))
        for step in range(1, steps + 1):
            total = np.array([[[0.0, strain * step / steps, 0.0, 0.0]]])
            stress, _, memory = return_stress(total, memory, hardening)
        assert abs(stress[0, 0, 0] - stress[0, 0, 1] - (1 + slope * accumulated)) < 1e-12
        assert abs(memory.accumulated[0, 0] - accumulated) < 1e-14
        assert np.allclose(memory.strain[0, 0], accumulated * np.array([0.5, -1, 0.5, 0]), atol=1e-14)


@pytest.mark.parametrize("name", HARDENINGS)
def test_tangent_by_differences(name):
    rng = np.random.default_rng(0)
    strain = rng.normal(size=(1, 20, 4)) * 0.01
    memory = Memory(rng.normal(size=strain.shape) * 1e-3, np.abs(rng.normal(size=(1, 20))) * 1e-2)
    change = rng.normal(size=strain.shape)
    tangent = return_stress(strain, memory, HARDENINGS[name])[1]
    forth, back = (return_stress(strain + sign * 1e-7 * change, memory, HARDENINGS[name])[0] for sign in (1, -1))
    expected = np.einsum("epij,epj->epi", tangent, change)
    assert np.abs((forth - back) / 2e-7 - expected).max() < 1e-5 * np.abs(expected).max()


@pytest.mark.parametrize("load", [10, 100])
def test_answers_lie_on_the_fit_of_kogut_and_etsion(load):
    """Kogut, Etsion, J. Appl. Mech. 69 (2002) 657-662, https://doi.org/10.1115/1.1490373: a perfectly plastic ball."""
    # Their unit is where the maximum pressure is (0.454 + 0.41 nu) 2.8 Y.
    factor = (0.454 + 0.41 * POISSON) * 2.8 / FIRST
    answers = load_answers()[f"perfectly plastic {load}"]
    approach, radius = answers["approach"][0] / factor**2, answers["contact radius"][0] / factor
    force, area = (1.03, 1.425), (0.93, 1.136)
    if approach > 6:
        force, area = (1.40, 1.263), (0.94, 1.146)
    assert abs(force[0] * approach ** force[1] / (load / factor**3) - 1) < 0.03
    # The radius is known to half an element, 2 %, and where the two fits meet their areas differ by 3 %.
    assert abs(area[0] * approach ** area[1] / radius**2 - 1) < 0.08


def test_what_is_extrapolated_is_small():
    for name, answers in load_answers().items():
        for quantity, error in (("approach", 0.01), ("maximum pressure", 0.02), ("largest strain", 0.06)):
            assert answers[quantity][1] < error * answers[quantity][0], (name, quantity)


def test_mean_pressure_grows_to_the_limit_of_indentation():
    """From 1.1 Y at first yield towards 2.8 Y, which E* a / Y R of 30 to 40 needs (Johnson, 1985, section 6.3)."""
    answers = load_answers()
    for name in HARDENINGS:
        means = [load * 2 / 3 * FIRST / answers[f"{name} {load}"]["contact radius"][0] ** 2 for load in (10, 100)]
        assert 2 / 3 * FIRST < means[0] < means[1] < 2.9


@pytest.mark.slow
def test_few_elements_come_near_the_answers():
    found, answers = press(10.0, HARDENINGS["linear"], 16, 16), load_answers()["linear 10"]
    for quantity in ("approach", "maximum pressure", "largest strain", "unloaded approach"):
        assert math.isclose(found[quantity], answers[quantity][0], rel_tol=0.03)
    assert np.abs(found["residual radial stress"] - answers["residual radial stress"][0])[1:].max() < 0.03
    assert found["strain by reloading"] < 0.01 * found["largest strain"]
