"""The load of a wanted answer: closed forms turned round, what the uncertainty of the load holds, and sentences."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from scenes import make_problem

YOUNG = 210e9
MODULUS = YOUNG / (1.0 - 0.3**2)
RADIUS = 1e-3
STEEL = rc.Elastic(YOUNG, 0.3)
BALL = rc.ParaboloidSurface(RADIUS)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=64e-6, rolloff=32e-6, seed=3)
WAVE = reference.Westergaard(1e-6, 1e-4, MODULUS)
# Shape and sides: odd and composite, 8:1 and transposed, cells of 1:3.
DOMAINS = {
    "odd": ((45, 51), (90e-6, 102e-6)),
    "8:1": ((240, 30), (800e-6, 100e-6)),
    "1:8": ((30, 240), (100e-6, 800e-6)),
    "cells 1:3": ((96, 32), (96e-6, 96e-6)),
    "cells 3:1": ((32, 96), (96e-6, 96e-6)),
}
FLOW = {"viscosity": 1e-3, "pressure_drop": 1e5}


def problem(surface=BALL, material=STEEL, domain="odd", **parts):
    return make_problem(surface, material, grid=rc.Grid(*DOMAINS.get(domain, domain)), threads=1, **parts)


@pytest.fixture(scope="module")
def rough():
    return problem(ROUGH, domain=((64, 48), (64e-6, 48e-6)), boundary="periodic")


def hertz(force):
    """Return the answers of a ball by Hertz."""
    found = reference.hertz_sphere(force=force, radius=RADIUS, modulus=MODULUS)
    return {
        "area": found.area,
        "peak_pressure": 1.5 * force / found.area,
        "stiffness": 2.0 * MODULUS * math.sqrt(found.area / math.pi),
    }


class TestClosedForms:
    @pytest.mark.parametrize("name", ["area", "peak_pressure", "stiffness"])
    @pytest.mark.parametrize("domain", DOMAINS)
    def test_a_ball(self, name, domain):
        found = problem(domain=domain).solve_for(**{name: hertz(1.0)[name]})
        assert abs(found.force.value - 1.0) <= 3.0 * found.force.uncertainty + 1e-3
        assert found.force.uncertainty < 0.1
        assert found.answer.value == pytest.approx(found.wanted, rel=5e-3)
        assert abs(found.answer.value - found.wanted) <= max(0.2 * found.answer.uncertainty, 1e-5 * found.wanted)
        assert found.force.value == found.solution.force
        assert found.pressure.value == found.solution.mean_pressure
        area = found.solution.grid.area
        assert found.pressure.uncertainty * area == pytest.approx(found.force.uncertainty, rel=1e-12)

    @pytest.mark.parametrize("fraction", [0.1, 0.5, 0.9])
    def test_a_wave_on_a_periodic_boundary(self, fraction):
        surface = rc.WavySurface((1e-6, 0.0), (1e-4, 1e-4))
        wave = problem(surface, domain=((96, 8), (100e-6, 25e-6)), boundary="periodic")
        pressure = WAVE.full_contact_pressure * math.sin(0.5 * math.pi * fraction) ** 2
        assert WAVE.half_width(pressure) == pytest.approx(0.5 * fraction * 1e-4)
        found = wave.solve_for(area=fraction * wave.grid.area)
        assert abs(found.pressure.value - pressure) <= 3.0 * found.pressure.uncertainty
        assert found.pressure.uncertainty < 0.02 * pressure

    @pytest.mark.parametrize("turned", [False, True])
    def test_a_roller_on_a_mixed_boundary(self, turned):
        """Hertz's line: a force of pi E* a^2 / 4 R over the length."""
        shape, size, radii = (96, 6), (96e-6, 18e-6), (RADIUS, math.inf)
        boundary = ("free", "periodic")
        if turned:
            shape, size, radii, boundary = shape[::-1], size[::-1], radii[::-1], boundary[::-1]
        roller = problem(rc.ParaboloidSurface(radii), domain=(shape, size), boundary=boundary)
        found = roller.solve_for(area=40e-6 * 18e-6)
        force = math.pi * MODULUS * (20e-6) ** 2 / (4.0 * RADIUS) * 18e-6
        assert abs(found.force.value - force) <= 3.0 * found.force.uncertainty
        assert found.force.uncertainty < 0.02 * force

    def test_a_limited_pressure_is_that_of_the_sum_of_cells(self):
        """In full plastic contact the load is the hardness times the area that carries it."""
        soft = problem(BALL, rc.ElasticPerfectlyPlastic(YOUNG, 0.3, 1e8))
        found = soft.solve_for(area="50%")
        assert found.force.value == pytest.approx(1e8 * found.answer.value, rel=0.02)


@pytest.mark.parametrize("load", [1e-4, 3e-3])
def test_the_load_of_flat_lands_is_known_as_far_as_their_area_changes(load):
    """Of four pillars, which have the same area at all loads that do not press the next one."""
    grid = rc.Grid((48, 48), (1.0, 1.0))
    heights = np.full(grid.shape, -0.1)
    for top, x, y in ((0.0, -0.25, -0.25), (-1e-3, 0.25, 0.25), (-2e-3, -0.25, 0.25), (-9e-3, 0.25, -0.25)):
        heights[np.hypot(grid.x - x, grid.y - y) < 0.15] = top
    lands = rc.ContactProblem(
        rc.Body(rc.HeightMap(heights, size=1.0, periodic=True), rc.Elastic(1.0, 0.0)), boundary="periodic"
    )
    found = lands.solve_for(area=lands.solve(pressure=load).area().value)
    assert abs(found.pressure.value - load) <= 2.0 * found.pressure.uncertainty
    assert "level" in {text.rule for text in found.warnings}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fraction"), [("area", 0.9), ("peak_pressure", 0.9), ("stiffness", 0.9)])
def test_two_standard_deviations_hold_the_load(name, fraction):
    """Balls beside the centre of a cell, of all sizes: 95 % are meant, of 30 at least 90 %."""
    rng = np.random.default_rng(7)
    held = []
    for _ in range(30):
        grid = rc.Grid((28, 28), 84e-6)
        shift = rng.uniform(-1.5e-6, 1.5e-6, 2)
        heights = -((grid.x - shift[0]) ** 2 + (grid.y - shift[1]) ** 2) / (2.0 * RADIUS)
        force = math.exp(rng.uniform(math.log(0.2), math.log(3.0)))
        contact = rc.ContactProblem(rc.Body(rc.HeightMap(heights, grid.size), STEEL), threads=1)
        found = contact.solve_for(**{name: hertz(force)[name]})
        held.append(abs(found.force.value - force) <= 2.0 * found.force.uncertainty)
    assert np.mean(held) >= fraction


class TestSearch:
    @pytest.mark.parametrize(
        ("name", "fields"),
        [
            ("area", {}),
            ("stiffness", {}),
            ("peak_pressure", {}),
            ("mean_gap", {}),
            ("leakage", FLOW),
            ("conductance", {"conductivity": 50.0}),
        ],
    )
    @pytest.mark.parametrize("pressure", [5e7, 2e9])
    def test_an_answer_leads_back_to_its_load(self, rough, name, fields, pressure):
        solution = rough.solve(pressure=pressure)
        given = solution.area() if name == "area" else solution.response(as_response(name, fields))
        found = rough.solve_for(**{name: given.value}, **fields)
        # The same grid errs alike at both: only the end of the search differs.
        off = abs(found.pressure.value - pressure)
        assert off <= max(0.5 * found.pressure.uncertainty, 1e-4 * pressure)
        assert found.solves <= 12
        if pressure < 1e9:
            by_object = rough.solve_for(as_response(name, fields), value=given.value)
            assert by_object.force == found.force
            assert str(by_object) == str(found)

    def test_the_uncertainty_is_that_of_the_answer_over_its_slope(self, rough):
        found = rough.solve_for(stiffness=2e6)
        pressure = found.pressure.value
        above, below = (rough.solve(pressure=factor * pressure).stiffness().value for factor in (1.03, 0.97))
        slope = (above - below) / (0.06 * pressure)
        spread = math.hypot(found.answer.uncertainty, found.answer.value - found.wanted)
        # The slope is that of the last steps of the search; the answer is not smooth at single cells.
        assert found.pressure.uncertainty == pytest.approx(spread / slope, rel=0.15)

    @pytest.mark.parametrize("power", [-40, 24])
    def test_units_change_no_digit(self, power):
        factor = 2.0**power
        grid = rc.Grid((48, 48), 96e-6)
        scaled = rc.ContactProblem(rc.Body(BALL, rc.Elastic(factor * YOUNG, 0.3)), grid=grid, threads=1)
        plain = rc.ContactProblem(rc.Body(BALL, STEEL), grid=grid, threads=1)
        found = [one.solve_for(area=1e-9) for one in (plain, scaled)]
        assert found[1].force.value == factor * found[0].force.value
        assert found[1].force.uncertainty == factor * found[0].force.uncertainty

    def test_a_turned_contact_needs_the_same_load(self):
        heights = ROUGH.heights(rc.Grid((64, 64), 64e-6))[:, :24]
        turned = rc.HeightMap(heights.T, (24e-6, 64e-6)), rc.HeightMap(heights, (64e-6, 24e-6))
        found = [rc.ContactProblem(rc.Body(one, STEEL), threads=1).solve_for(area="5%") for one in turned]
        assert found[0].force.value == pytest.approx(found[1].force.value, rel=1e-3)

    def test_texts_have_units(self, rough):
        nominal = 64e-6 * 48e-6
        assert rough.solve_for(area="307.2um2").force == rough.solve_for(area=307.2e-12).force
        assert rough.solve_for(area="10%").wanted == pytest.approx(0.1 * nominal)
        assert rough.solve_for(stiffness="2MN/m").force == rough.solve_for(stiffness=2e6).force
        assert rough.solve_for(conductance="5e-4", conductivity=50.0).wanted == 5e-4
        assert rough.solve_for(peak_pressure="30GPa").wanted == 30e9
        assert rough.solve_for(mean_gap="0.4um").wanted == pytest.approx(4e-7)

    def test_an_estimator_may_be_chosen(self, rough):
        found = rough.solve_for(area="10%", estimator="cell-count")
        assert found.answer.value == found.solution.area("cell-count").value
        solution = rough.solve_area(0.1, "cell-count")
        assert solution.force == pytest.approx(found.force.value, rel=1e-12)

    def test_a_level_answer_gets_a_warning(self):
        soft = problem(BALL, rc.ElasticPerfectlyPlastic(YOUNG, 0.3, 1e9))
        found = soft.solve_for(peak_pressure=1e9)
        assert math.isinf(found.force.uncertainty)
        assert "does not change" in str(found)


def as_response(name, fields):
    if name == "area":
        return rc.areas.create("blend")
    return rc.responses.create(name.replace("_", "-"), **fields)


@attrs.frozen
class Turning(rc.Response):
    """A response with a maximum of one at a pressure, Pa."""

    top: float = 1.5e9

    def respond(self, solution):
        return rc.Estimate(math.exp(-((3.0 * math.log(solution.mean_pressure / self.top)) ** 2)), 1e-6, "")


@attrs.frozen
class Stepping(rc.Response):
    """A response that jumps at 1 GPa."""

    def respond(self, solution):
        return rc.Estimate(1.0 if solution.mean_pressure < 1e9 else 3.0, 0.1, "")


BAD = {
    "nothing": (lambda p: p.solve_for(), "exactly one wanted answer"),
    "two": (lambda p: p.solve_for(area=1e-10, stiffness=1e6), "area= and stiffness="),
    "an unknown name": (lambda p: p.solve_for(stifness=1e6), "Did you mean 'stiffness'"),
    "a name alone": (lambda p: p.solve_for("area", value=1e-10), r"solve_for\(area="),
    "a number alone": (lambda p: p.solve_for(3.0, value=1e-10), "a response or an area estimator"),
    "no value": (lambda p: p.solve_for(rc.areas.create("blend")), "give value="),
    "a value alone": (lambda p: p.solve_for(value=3.0), "for a response object"),
    "fields of an object": (lambda p: p.solve_for(Turning(), value=1.0, axis=1), "omit axis="),
    "a field too many": (lambda p: p.solve_for(stiffness=1e6, axis=1), "cannot be made"),
    "a field too few": (lambda p: p.solve_for(leakage=1e-15), "viscosity"),
    "a field beside the area": (lambda p: p.solve_for(area=1e-10, axis=1), "only estimator="),
    "no number": (lambda p: p.solve_for(first_yield=1.0, yield_stress=1e9), "not a number with an uncertainty"),
    "zero": (lambda p: p.solve_for(stiffness=0.0), "above 0"),
    "not finite": (lambda p: p.solve_for(stiffness=math.nan), "finite"),
    "nominal area": (lambda p: p.solve_for(area=p.grid.area), "below the nominal area"),
    "all of it": (lambda p: p.solve_for(area="100%"), "below the nominal area"),
    "a wrong unit": (lambda p: p.solve_for(stiffness="5nm"), "not a quantity in units of N/m"),
    "a wrong unit of an area": (lambda p: p.solve_for(area="5nm"), "The wanted area"),
    "a wrong unit of two": (lambda p: p.solve_for(conductance="5W/m", conductivity=50.0), "in units of W/K or S"),
    "more flow than the open gap has": (lambda p: p.solve_for(leakage=1.0, **FLOW), "No load gives a leakage"),
    "a wider gap than at first touch": (lambda p: p.solve_for(mean_gap="1mm"), "No load gives a mean-gap"),
    "more than the maximum": (lambda p: p.solve_for(Turning(), value=1.5), "the nearest is"),
    "the way past a maximum": (lambda p: p.solve_for(Turning(), value=0.9), "rises and falls, and was asked at"),
    "a jump": (lambda p: p.solve_for(Stepping(), value=2.0), "jumps from 1 to 3"),
    "an area of no cell": (lambda p: p.solve_for(area="0.0001%", estimator="cell-count"), "No load gives an area"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_a_sentence(rough, case):
    call, words = BAD[case]
    with pytest.raises(rc.InputError, match=words):
        call(rough)


def test_with_adhesion_the_loads_are_swept():
    sticky = problem(BALL, domain=((32, 32), 96e-6), adhesion=rc.Exponential(work=0.05, range=5e-7))
    with pytest.raises(rc.InputError, match="sweep the loads instead"):
        sticky.solve_for(area=1e-10)


def test_a_pressure_limit_is_named():
    soft = problem(BALL, rc.ElasticPerfectlyPlastic(YOUNG, 0.3, 1e9))
    with pytest.raises(rc.InputError, match="maximum that the bodies can carry"):
        soft.solve_for(peak_pressure="2GPa")
