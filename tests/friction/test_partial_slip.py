"""Partial slip: Cattaneo and Mindlin's ball, a wave, rough surfaces, the loop, and what is refused."""

from __future__ import annotations

import itertools
import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.reference import Westergaard

RADIUS, CELL, FRICTION = 1e-2, 1e-6, 0.3
ALIKE = rc.Elastic(young=200e9, poisson=0.3)
MODULUS = 200e9 / (2 * 0.91)
RATIO = 1.7 / 1.4
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=64e-6, rolloff=32e-6, seed=3)


def press_ball(cells, place, material=ALIKE, other=ALIKE, modulus=MODULUS):
    """Return the contact of a ball of a radius in cells, at a place in cells from the centre."""
    radius = cells * CELL
    count = 4 * cells + 8
    ball = rc.ParaboloidSurface(RADIUS, (place[0] * CELL, place[1] * CELL))
    problem = rc.ContactProblem(
        rc.Body(ball, material), rc.Body(rc.FlatSurface(), other), grid=rc.Grid((count, count), count * CELL), threads=1
    )
    return problem.solve(force=4 * modulus * radius**3 / (3 * RADIUS))


def press_rough(pressure=0.05, boundary="periodic", cells=64, material=ALIKE, **surface):
    problem = rc.ContactProblem(
        rc.Body(ROUGH, material),
        rc.Body(rc.FlatSurface(), ALIKE),
        grid=rc.Grid((cells, cells), 64e-6),
        boundary=boundary,
        threads=1,
    )
    return problem.solve(pressure=pressure * 0.05 * MODULUS)


def slide(solution, fraction, friction=FRICTION, axis=0):
    return solution.partial_slip(tangential_force=fraction * friction * solution.force, friction=friction, axis=axis)


def mindlin(cells, fraction):
    """Return stick radius, m, displacement, m, and energy in a cycle, J, of Cattaneo and Mindlin's ball.

    Johnson (1985) eq. 7.39 to 7.43; Mindlin and Deresiewicz, J. Appl. Mech. 20 (1953) 327-344.
    """
    a, shear, poisson = cells * CELL, 200e9 / 2.6, 0.3
    force = FRICTION * 4 * MODULUS * a**3 / (3 * RADIUS)
    stuck = 1 - fraction
    moved = 3 * force / (16 * a) * 2 * (2 - poisson) / shear * (1 - stuck ** (2 / 3))
    energy = 9 * force**2 / (10 * a) * 2 * (2 - poisson) / shear
    energy *= 1 - stuck ** (5 / 3) - 5 * fraction / 6 * (1 + stuck ** (2 / 3))
    return a * stuck ** (1 / 3), moved, energy


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cells", "moved", "energy"), [(3, 0.015, 0.3), (6, 0.005, 0.05), (12, 0.0005, 0.01)], ids="of {} cells".format
)
def test_cattaneo_and_mindlin(cells, moved, energy):
    places = np.random.default_rng(cells).uniform(-0.5, 0.5, (6, 2))
    errors = []
    for place in places:
        solution = press_ball(cells, place)
        for fraction in (0.3, 0.6, 0.9):
            found, exact = slide(solution, fraction), mindlin(cells, fraction)
            radius = math.sqrt(found.stick_area.value / math.pi)
            assert abs(found.displacement.value - exact[1]) < 3 * found.displacement.uncertainty
            assert abs(found.energy.value - exact[2]) < 3 * found.energy.uncertainty
            assert abs(found.stick_area.value - math.pi * exact[0] ** 2) < 2 * found.stick_area.uncertainty
            errors.append(np.divide((radius, found.displacement.value, found.energy.value), exact) - 1)
    errors = np.sqrt(np.mean(np.square(errors).reshape(6, 3, 3), axis=0))
    assert errors[:, 0].max() < 2e-4
    assert errors[:, 1].max() < moved
    assert errors[1:, 2].max() < energy


@pytest.mark.parametrize(("cells", "sides"), [((40, 120), (1, 1)), ((120, 40), (1, 1)), ((51, 47), (1, 3))])
def test_slender_ellipses_move_less_along_their_length(cells, sides):
    # The tangential compliance of an ellipse is that of the same contact before slip, but fewer cells stick.
    size = cells[0] * sides[0] * CELL, cells[1] * sides[1] * CELL
    body = rc.Body(rc.ParaboloidSurface((RADIUS / 9, RADIUS), (0.3 * CELL, 0.2 * CELL)), ALIKE)
    problem = rc.ContactProblem(body, rc.Body(rc.FlatSurface(), ALIKE), grid=rc.Grid(cells, size), threads=1)
    solution = problem.solve(force=4 / 3 * MODULUS * (4 * CELL) ** 3 / (RADIUS / 9))
    across, along = (slide(solution, 0.5, axis=axis) for axis in (0, 1))
    stiffness = [solution.response(rc.responses.create("tangential-stiffness", axis=axis)) for axis in (0, 1)]
    ratio = stiffness[1].value / stiffness[0].value
    assert across.compliance_ratio / along.compliance_ratio == pytest.approx(ratio, rel=2e-2)
    assert ratio < 0.95
    assert across.displacement.value < along.displacement.value
    assert re.search(r"direction +y", str(along))


def test_displacement_of_a_wave_in_plane_strain():
    wave = Westergaard(amplitude=1e-6, wavelength=64e-6, modulus=MODULUS)
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface((1e-6, 0.0), 64e-6, phase=(1.3, 0.0)), ALIKE),
        rc.Body(rc.FlatSurface(), ALIKE),
        grid=rc.Grid((256, 4), (64e-6, 1e-6)),
        boundary="periodic",
        threads=1,
    )
    pressures = 0.4 * wave.full_contact_pressure * np.array((1.0, 0.3))
    solution = problem.solve(pressure=pressures[0])
    # The approach is the integral of the compliance, lambda / (pi E*) ln(p_full / p).
    approaches = pressures * (np.log(wave.full_contact_pressure / pressures) + 1) * 64e-6 / (math.pi * MODULUS)
    exact = FRICTION * (approaches[0] - approaches[1])
    # Across the strips the tangential compliance is the normal one, along them that of antiplane shear.
    for axis, ratio in ((0, 1.0), (1, 1.0 / 0.7)):
        found = slide(solution, 0.7, axis=axis)
        assert found.displacement.value == pytest.approx(ratio * exact, rel=2e-3)
        assert found.stick_area.value == pytest.approx(2e-6 * wave.half_width(pressures[1]), rel=5e-3)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_friction_holds_everywhere(boundary):
    solution = press_rough(boundary=boundary)
    found = slide(solution, 0.5)
    bound = FRICTION * solution.pressure
    rounding = 1e-4 * bound.max()
    assert found.traction.sum() * solution.grid.cell_area == pytest.approx(found.tangential_force, rel=1e-9)
    assert (found.traction > -rounding).all()
    assert (found.traction < bound + rounding).all()
    assert np.array_equal(found.traction[found.slip], bound[found.slip])
    assert not (found.slip & found.stick).any()
    assert np.array_equal(found.slip | found.stick, solution.contact)
    # The bodies move as one where they stick, and the traction opposes the slip elsewhere in the contact.
    moved = found.compliance_ratio * FRICTION * (solution.displacement - found.stick_contact.displacement)
    behind = found.displacement.value - moved
    assert np.abs(behind[found.stick]).max() < 1e-3 * found.displacement.value
    assert behind[found.slip].min() > -1e-3 * found.displacement.value


def test_energy_is_the_area_of_the_loop():
    found = slide(press_rough(), 0.8)
    coarse, fine = found.loop(8).energy, found.loop(16).energy
    # The trapezoidal rule is of second order.
    assert fine + (fine - coarse) / 3 == pytest.approx(found.energy.value, rel=2e-3)


def test_loading_softens_and_the_stick_zone_shrinks():
    solution = press_rough(boundary="free")
    loop = slide(solution, 0.95).loop(10)
    assert loop.force[0] == loop.displacement[0] == 0.0
    steps = np.diff(loop.displacement)
    assert (np.diff(steps) > -0.01 * steps[1:]).all()
    assert steps[-1] > 1.5 * steps[0]
    zones = [slide(solution, fraction).stick for fraction in (0.0, 0.2, 0.6, 0.95)]
    assert all((large & small).sum() == small.sum() for large, small in itertools.pairwise(zones))
    force, moved = loop.cycle
    assert force[0] == force[-1] == loop.force[-1] == -force[10]
    assert moved[0] == moved[-1] == loop.displacement[-1] == -moved[10]


def test_without_a_tangential_force_all_sticks():
    solution = press_rough()
    found = slide(solution, 0.0)
    assert found.stick_contact is solution
    assert found.displacement.value == found.energy.value == found.slip_area.value == found.traction.any() == 0.0
    assert found.loop(3).energy == 0.0
    assert found.warnings == ()


def test_small_forces_meet_mindlins_stiffness():
    found = slide(press_ball(12, (0.2, -0.3)), 0.01)
    shear = 200e9 / 2.6
    stiffness = 4 * shear * 12 * CELL / 1.7
    assert found.tangential_force / found.displacement.value == pytest.approx(stiffness, rel=5e-3)


def test_near_sliding_all_slips():
    found = slide(press_rough(), 1 - 1e-9)
    assert found.slip_area.value == pytest.approx(found.contact.area().value, rel=1e-3)
    assert np.allclose(found.traction, FRICTION * found.contact.pressure, atol=1e-4 * found.contact.pressure.max())


def test_full_contact_moves_as_one():
    found = slide(press_rough(pressure=20.0), 0.5)
    assert found.stick.all()
    assert found.displacement.value < 1e-3 * FRICTION * found.contact.approach
    assert np.ptp(found.traction) < 1e-6 * found.traction.mean()


def test_a_rigid_counterbody_stands_for_a_like_one():
    one = slide(press_ball(6, (0.1, 0.3)), 0.5)
    rigid = slide(press_ball(6, (0.1, 0.3), material=rc.Elastic(MODULUS * 0.91, 0.3), other=rc.Rigid()), 0.5)
    assert rigid.displacement.value == pytest.approx(one.displacement.value, rel=1e-6)
    assert rigid.energy.value == pytest.approx(one.energy.value, rel=1e-4)
    assert not one.warnings
    assert "Dundurs' beta = 0.29" in rigid.warnings[0]
    assert not slide(
        press_ball(6, (0.0, 0.0), material=rc.Elastic(1e9, 0.5), other=rc.Rigid(), modulus=4e9 / 3), 0.5
    ).warnings


def test_uncoupled_bodies_of_different_materials():
    # (1 - 2 nu) / G is the same.
    shear = 100e9
    soft, stiff = rc.Elastic(2 * 1.2 * shear, 0.2), rc.Elastic(2 * 1.35 * shear * 0.5, 0.35)
    modulus = 1 / (0.8 / (2 * shear) + 0.65 / shear)
    found = slide(press_ball(8, (0.3, 0.1), soft, stiff, modulus), 0.6)
    across = slide(found.contact, 0.6, axis=1)
    ratio = modulus * (1.8 / (4 * shear) + 1.65 / (2 * shear))
    for one in (found, across):
        assert one.compliance_ratio == pytest.approx(ratio, rel=3e-3)
    assert found.warnings == ()
    assert slide(press_ball(8, (0.3, 0.1), stiff, soft, modulus), 0.6).displacement == found.displacement


@pytest.mark.slow
@settings(max_examples=12)
@given(st.integers(-30, 30), st.integers(-20, 20))
def test_scales_change_nothing_else(length, stress):
    longer, stiffer = 2.0**length, 2.0**stress

    def solve(longer, stiffer):
        problem = rc.ContactProblem(
            rc.Body(rc.ParaboloidSurface(RADIUS * longer, (0.3 * CELL * longer, 0.0)), rc.Elastic(1e9 * stiffer, 0.3)),
            grid=rc.Grid((16, 12), (16 * CELL * longer, 15 * CELL * longer)),
            threads=1,
        )
        return slide(problem.solve(pressure=1e4 * stiffer), 0.5)

    one, other = solve(1.0, 1.0), solve(longer, stiffer)
    assert np.array_equal(other.traction, one.traction * stiffer)
    assert other.displacement.value == one.displacement.value * longer
    assert other.energy.value == one.energy.value * stiffer * longer**3
    assert other.displacement.uncertainty == pytest.approx(one.displacement.uncertainty * longer)


def test_it_survives_pickling_and_speaks():
    found = slide(press_ball(6, (0.0, 0.0)), 0.5)
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.traction, found.traction)
    assert again.loop(2).energy == pytest.approx(found.loop(2).energy)
    text = str(found)
    assert "50 % of the force of sliding" in text
    assert "energy in a cycle" in text
    assert len(str(found.loop(4)).splitlines()) == 6


def test_what_is_refused():
    solution = press_rough()
    for force in (FRICTION * solution.force, 2 * solution.force):
        with pytest.raises(rc.InputError, match="The bodies slide"):
            solution.partial_slip(tangential_force=force, friction=FRICTION)
    with pytest.raises(rc.InputError, match="The tangential force"):
        solution.partial_slip(tangential_force=-1.0, friction=FRICTION)
    for friction in (0.0, -0.1, math.nan):
        with pytest.raises(rc.InputError, match="friction"):
            solution.partial_slip(tangential_force=1e-6, friction=friction)
    with pytest.raises(rc.InputError, match="The number of points"):
        slide(solution, 0.5).loop(0)
    with pytest.raises(rc.InputError, match="wrapped"):
        slide(press_rough(boundary="wrapped"), 0.5)
    with pytest.raises(rc.InputError, match="pressure reaches its limit"):
        slide(press_rough(material=rc.ElasticPerfectlyPlastic(200e9, 0.3, 1e9)), 0.5)
    assert slide(press_rough(material=rc.ElasticPerfectlyPlastic(200e9, 0.3, 1e14)), 0.5).displacement.value > 0.0
    with pytest.raises(rc.InputError, match=r"Dundurs' beta is -?0\.1.*problem\.path.*uncoupled=True"):
        slide(press_rough(material=rc.Elastic(70e9, 0.33)), 0.5)


@pytest.mark.slow
def test_coupling_may_be_neglected_with_a_warning():
    solution = press_rough(material=rc.Elastic(70e9, 0.33))
    arguments = {"tangential_force": 0.5 * FRICTION * solution.force, "friction": FRICTION}
    found = solution.partial_slip(**arguments, uncoupled=True)
    (warning,) = found.warnings
    assert warning.rule == "coupling"
    assert warning.value == pytest.approx(0.11, abs=0.01)
    assert "displacement too small by 4.3 %" in warning
    problem = solution.origin.scene
    path = problem.path(
        force=solution.force, tangential_force=[(arguments["tangential_force"], 0.0)], friction=FRICTION
    )
    pressed, moved = path.loop.displacement[:, 0]
    assert abs(found.displacement.value - (moved - pressed)) < 2 * found.displacement.uncertainty
    # It goes with the displacement of each point of the loop too.
    assert found.loop(2).uncertainty[-1] == found.displacement.uncertainty
    like = press_rough()
    arguments["tangential_force"] = 0.5 * FRICTION * like.force
    assert like.partial_slip(**arguments, uncoupled=True).displacement == like.partial_slip(**arguments).displacement


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("poisson", [0.0, 0.5])
def test_it_meets_friction_in_every_cell(boundary, poisson):
    """A solve for stick and slip in both directions: the same without Poisson's ratio, else within the uncertainty."""
    material = rc.Elastic(200e9, poisson)
    body, flat = rc.Body(ROUGH, material), rc.Body(rc.FlatSurface(), material)
    problem = rc.ContactProblem(body, flat, grid=rc.Grid((64, 64), 64e-6), boundary=boundary, threads=1)
    solution = problem.solve(pressure=0.05 * 0.05 * MODULUS)
    for axis, fraction in ((0, 0.3), (1, 0.8)):
        found = slide(solution, fraction, axis=axis)
        force = [0.0, 0.0]
        force[axis] = found.tangential_force
        path = problem.path(force=solution.force, tangential_force=[tuple(force)], friction=FRICTION)
        moved, energy = path.loop.displacement[-1, axis], 4.0 * path.dissipated.value
        if poisson == 0.0:
            assert found.displacement.value == pytest.approx(moved, rel=1e-4)
            assert found.energy.value == pytest.approx(energy, rel=2e-3)
        assert abs(found.displacement.value - moved) < 2 * found.displacement.uncertainty
        assert abs(found.energy.value - energy) < 2 * found.energy.uncertainty


def test_a_material_of_ones_own_tells_its_poisson_ratio():
    class Own(rc.Material):
        compliance = 0.91 / 200e9
        pressure_limit = math.inf

    with pytest.raises(rc.InputError, match="give the class Own an attribute `poisson`"):
        slide(press_rough(material=Own()), 0.5)
    Own.poisson = 0.3
    solution = press_rough(material=Own())
    ratios = [slide(solution, 0.5, axis=axis).compliance_ratio for axis in (0, 1)]
    assert sum(ratios) / 2 == pytest.approx(RATIO, rel=0.01)
    assert abs(ratios[0] - ratios[1]) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_neglected_coupling_errs_as_the_uncertainty_says(friction):
    """The more of the rim slips in pressing, the more of the tangential force does it no longer carry."""
    body, other = rc.Body(rc.ParaboloidSurface(RADIUS), ALIKE), rc.Body(rc.FlatSurface(), rc.Rigid())
    problem = rc.ContactProblem(body, other, grid=rc.Grid((32, 32), 32 * CELL), threads=1)
    solution = problem.solve(approach=(12 * CELL) ** 2 / RADIUS)
    force = 0.5 * friction * solution.force
    found = solution.partial_slip(tangential_force=force, friction=friction)
    path = problem.path(
        force=solution.force, tangential_force=[(0.0, 0.0), (force, 0.0)], friction=friction, substeps=4
    )
    error = found.displacement.value / (path[-1].tangential_displacement[0] - path[-2].tangential_displacement[0]) - 1.0
    stated = found.displacement.uncertainty / found.displacement.value
    assert -2.0 * stated < error < -0.25 * stated


@pytest.mark.parametrize(("seed", "narrow"), [(1, True), (3, False)])
def test_what_the_stick_zone_is_warned_of_the_answer_is_too(seed, narrow):
    """Nearly sliding, the last cells that stick are few; the normal contact itself has many."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3.0, longest=16.0, seed=seed)
    like = rc.Elastic(1.0, 0.3)
    problem = rc.ContactProblem(
        rc.Body(surface, like), rc.Body(rc.FlatSurface(), like), grid=rc.Grid((24, 24), 24.0), boundary="periodic",
        threads=1,
    )  # fmt: skip
    solution = problem.solve(pressure=3e-3)
    found = solution.partial_slip(tangential_force=0.18 * solution.force, friction=0.2)
    few = "of the counted area is in patches of fewer than four cells"
    assert not any(few in text for text in solution.area().warnings)
    assert any(few in text for text in found.stick_area.warnings)
    assert set(found.stick_area.warnings) <= set(found.warnings)
    assert any("too narrow" in text for text in found.warnings) == narrow
    assert len(set(found.warnings)) == len(found.warnings)
    assert str(found).count("warning: ") == len(found.warnings)
