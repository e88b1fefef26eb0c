"""Viscoelastic bodies: creep and relaxation along paths over time."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import roughcontact as rc

CAREFUL = rc.ProjectedConjugateGradient(tolerance=1e-10)


def make_ball(moduli, times, cells, radius, reach, **others):
    """Return a paraboloid of radius 1 m of so many cells in a contact radius, on an odd grid of a reach of radii."""
    n = 2 * int(reach * cells) + 1
    body = rc.Body(rc.ParaboloidSurface(radius=1.0), rc.Viscoelastic(moduli, times, 0.0))
    return rc.ContactProblem(body, grid=rc.Grid((n, n), n * radius / cells), **others)


@pytest.mark.parametrize("times", [[1.0], [0.01, 1.0, 50.0]])
def test_a_wave_in_full_contact_relaxes_as_its_modulus(times):
    """Whatever the increments: the displacement of a closed gap is given."""
    rubber = rc.Viscoelastic([1e6, *(3e6 / len(times) for _ in times)], times, 0.0)
    body = rc.Body(rc.WavySurface(1e-6, 1e-3), rubber)
    problem = rc.ContactProblem(body, grid=rc.Grid((16, 16), 1e-3), boundary="periodic", solver=CAREFUL)
    after = [0.0, 0.5, 1.0, 100.0]
    for accuracy in (1.0, 1e-2):
        path = problem.path(pressure=1e5, time=after, accuracy=accuracy)
        swings = np.array([np.ptp(state.pressure) for state in path])
        right = [rubber.relaxed(time) / rubber.relaxed(0.0) for time in after]
        np.testing.assert_allclose(swings / swings[0], right, rtol=1e-9)


def test_a_ball_creeps_as_lee_and_radok_say():
    """A step of load: the cube of the radius grows as the compliance (1 + 3 (1 - exp(-t/4))) / 4 of 1 + 3 exp(-t)."""
    first = 0.05
    problem = make_ball([1e6, 3e6], [1.0], 16, first, 1.75)
    after = [0.0, 0.3, 1.0, 3.0, 30.0]
    path = problem.path(force=4.0 / 3.0 * 4e6 * first**3, time=after)
    radius = first * (4.0 - 3.0 * np.exp(-np.array(after) / 4.0)) ** (1.0 / 3.0)
    np.testing.assert_allclose(path.approach, radius**2, rtol=1e-3)
    for state, right in zip(path, radius, strict=True):
        area = state.area()
        # Until a load has acted before, the bodies are elastic ones.
        assert area.estimator == ("blend" if state is path[0] else "level-set")
        assert abs(area.value - np.pi * right**2) <= 2.0 * area.uncertainty


def test_a_ball_is_pulled_back_as_ting_says():
    """It shrinks while it is pulled back, its force from the time at which the contact had its size, and separates."""
    rate, turn = 1e-3, 2.0
    problem = make_ball([1e6, 3e6], [1.0], 12, np.sqrt(rate * turn), 1.2)
    time = np.array([0.5, 1.0, turn, 2.2, 2.6, 2.9, 3.5, 4.0])
    path = problem.path(approach=np.minimum(rate * time, rate * (2.0 * turn - time)), time=time)

    def relaxed(after):
        return 1e6 + 3e6 * np.exp(-after)

    def force(now):
        end = now
        if now > turn:

            def moved(past):
                down = quad(lambda s: relaxed(now - s), turn, now)[0]
                return quad(lambda s: relaxed(now - s), past, turn)[0] - down

            if moved(0.0) <= 0.0:
                return 0.0
            end = brentq(moved, 0.0, turn)
        return quad(lambda s: relaxed(now - s) * 2.0 * np.sqrt(rate * s) * rate, 0.0, end)[0]

    right = np.array([force(now) for now in time])
    np.testing.assert_allclose(path.force, right, atol=1e-3 * right.max())
    # From rest, where the displacement is small beside that at the end of the rise.
    assert path.increments[0] < 40
    assert not path[-1].pressure.any()
    assert path[-1].gap.min() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
def test_two_bodies_relax_as_one_of_their_compliance(boundary):
    """Two alike bodies are one of half the modulus; the order of the bodies changes nothing."""
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.25e-3, longest=1e-3, seed=3)
    soft, hard = rc.Viscoelastic([1e6, 2e6], [0.1], 0.4), rc.Viscoelastic([2e6, 4e6], [0.1], 0.4)
    grid = rc.Grid((32, 24), (1e-3, 0.75e-3))
    pairs = [(hard, hard), (soft, rc.Rigid()), (rc.Rigid(), soft)]
    found = [
        rc.ContactProblem(
            rc.Body(rough, one), rc.Body(rc.FlatSurface(), other), grid=grid, boundary=boundary, solver=CAREFUL
        ).path(pressure=3e4, time=[0.0, 0.05, 1.0])
        for one, other in pairs
    ]
    for path in found[1:]:
        for state, other in zip(found[0], path, strict=True):
            np.testing.assert_allclose(state.pressure, other.pressure, atol=1e-6 * state.pressure.max())


def test_in_the_end_the_body_is_that_of_its_relaxed_modulus():
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.25e-3, longest=1e-3, seed=4)
    grid = rc.Grid((32, 32), 1e-3)
    materials = (rc.Viscoelastic([1e6, 9e6], [1e-3], 0.5), rc.Elastic(1e6, 0.5), rc.Elastic(10e6, 0.5))
    creeping, soft, hard = (
        rc.ContactProblem(rc.Body(rough, one), grid=grid, boundary="periodic", solver=CAREFUL) for one in materials
    )
    path = creeping.path(pressure=2e4, time=[0.0, 1.0])
    for state, other in zip(path, (hard, soft), strict=True):
        right = other.solve(pressure=2e4)
        np.testing.assert_allclose(state.pressure, right.pressure, atol=2e-3 * right.pressure.max())
        assert state.approach == pytest.approx(right.approach, rel=1e-3)
    np.testing.assert_array_equal(creeping.solve(pressure=2e4).pressure, path[0].pressure)


def test_units_by_powers_of_two_change_no_bit():
    found = []
    for scale in (1.0, 2.0**30, 2.0**-20):
        problem = make_ball([1e6 * scale, 3e6 * scale], [1.0], 8, 0.05, 1.5)
        found.append(problem.path(pressure=1e3 * scale, time=[0.0, 2.0])[-1])
    for other, scale in zip(found[1:], (2.0**30, 2.0**-20), strict=True):
        np.testing.assert_array_equal(other.pressure, scale * found[0].pressure)
        np.testing.assert_array_equal(other.gap, found[0].gap)


@pytest.mark.parametrize("alpha", [0.3, 0.6, 0.8])
def test_a_series_fits_a_fractional_body(alpha):
    omega = np.logspace(-4, 4, 40)
    power = (1j * omega) ** alpha
    whole = 1e6 * (1.0 + 99.0 * power / (1.0 + power))
    rubber = rc.Viscoelastic.from_master_curve(omega, whole.real, whole.imag, poisson=0.5)
    found = np.array([rubber.complex_modulus(one) for one in omega])
    np.testing.assert_allclose(found.real, whole.real, rtol=0.02)
    np.testing.assert_allclose(found.imag, whole.imag, rtol=0.02)


def test_answers_by_one_modulus_are_refused():
    path = make_ball([1e6, 3e6], [1.0], 8, 0.05, 1.5).path(force=1.0, time=[0.0, 1.0])
    for name in ("stiffness", "hertz"):
        with pytest.raises(rc.InputError, match="relax"):
            path[-1].area("hertz") if name == "hertz" else path[-1].response(name)
    assert path[-1].response("mean-gap").value > 0.0


def test_a_creeping_path_comes_back_from_its_file(tmp_path):
    path = make_ball([1e6, 3e6], [1.0], 6, 0.05, 1.5).path(force=1.0, time=["0s", "1s", "2s"])
    path.save(tmp_path / "path.npz")
    again = rc.load(tmp_path / "path.npz")
    assert str(again) == str(path)
    np.testing.assert_array_equal(again.time, [0.0, 1.0, 2.0])


def make_sticky_ball(rubber, cells=40, law_range=8e-3):
    """Return a paraboloid of radius 1 m that sticks to a rigid flat, with a contact radius of .3 at zero load."""
    ball = rc.Body(rc.ParaboloidSurface(radius=1.0), rubber)
    law = rc.Exponential(2e-3, law_range)
    return rc.ContactProblem(ball, grid=rc.Grid((cells, cells), 1.1), adhesion=law)


def test_a_ball_is_pulled_off_the_harder_the_faster():
    """From w to w E0 / Einf, 5 here, over 1.5 pi w R."""
    soft = rc.Viscoelastic([1.0, 4.0], [1.0], 0.0)
    depth = np.linspace(0.046, -0.14, 25)
    relaxed = make_sticky_ball(soft).path(approach=[depth[0], depth[0]], time=[0.0, 100.0])
    forces = []
    for speed in (1e-5, 1e-3, 10.0):
        time = 100.0 + (depth[0] - depth[1:]) / speed
        pulled = relaxed.extend(approach=depth[1:], time=time, accuracy=1e-2)
        assert pulled.force[-1] == pytest.approx(0.0, abs=1e-6)
        forces.append(pulled.force.min() / (1.5 * np.pi * 2e-3))
    elastic = make_sticky_ball(rc.Elastic(1.0, 0.0)).path(approach=depth)
    assert forces[0] == pytest.approx(elastic.force.min() / (1.5 * np.pi * 2e-3), rel=0.1)
    assert -2.2 < forces[1] < -1.4
    assert -5.0 < forces[2] < -3.6


def test_bodies_that_stick_come_from_far_away():
    """A list of loads over time begins at time zero: at a load of zero they would be in contact."""
    problem = make_sticky_ball(rc.Viscoelastic([1.0, 4.0], [1.0], 0.0), cells=24, law_range=2e-2)
    with pytest.raises(rc.InputError, match="far away"):
        problem.path(approach=[0.01, 0.02], time=[1.0, 2.0])
    path = problem.path(approach=[-0.1, 0.01], time=[0.0, 1.0])
    assert path[0].contact.sum() == 0
    assert path[1].contact.any()


@pytest.mark.parametrize(
    "given",
    [
        {"moduli": [1e6], "times": [1.0]},
        {"moduli": [1e6, -1.0], "times": [1.0]},
        {"moduli": [1e6, 1e6], "times": [0.0]},
        {"moduli": 1e6, "times": []},
        {"moduli": ["1mm"], "times": []},
    ],
)
def test_a_wrong_series_gets_a_sentence(given):
    with pytest.raises(rc.InputError):
        rc.Viscoelastic(**given, poisson=0.3)
