"""The search for a load on answers of closed form: Hertz's ball, first yield, a plateau, a jump, out of reach."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from roughcontact._parts.grid import Load
from roughcontact._solve.problem import LoadSearch, TriedLoad
from roughcontact.reference import hertz_sphere

RADIUS, MODULUS = 1e-3, 230e9


class Contact:
    """A search over an answer that is known at each force, and the forces at which it was asked."""

    def __init__(self, answer, wanted, *, ends=(1e-9, 1e9), width=1e-5, tolerance=1e-6, **options):
        self.forces = []
        self.left = []

        def solve(load, start):
            assert load.kind == "force"
            self.forces.append(load.value)
            # A tension: no pressure is predicted from it.
            return SimpleNamespace(force=load.value, tension=0.0, convolutions=3)

        def read(x, state):
            value = answer(state.force)
            off = math.log(value / wanted) if 0.0 < value < math.inf else math.copysign(math.inf, value - wanted)
            return TriedLoad(x, off, tolerance, value)

        parts = {"unit": Load("force", 1.0), "ends": ends, "width": width, "on_answer": self.left.append}
        self.search = LoadSearch(solve=solve, read=read, **parts, **options)

    def load(self, start=1.0):
        found = self.search.run(math.log(start))
        return None if found is None else self.search.load_at(found.x)


def area_of_ball(force):
    return hertz_sphere(force=force, radius=RADIUS, modulus=MODULUS).area


def stress_of_ball(force):
    """The maximum von Mises stress, 0.62 of the maximum pressure for a ratio of Poisson of 0.3, Pa."""
    return 0.62 * 1.5 * force / area_of_ball(force)


@pytest.mark.parametrize("has_kinks", [False, True])
@pytest.mark.parametrize("rises", [False, True])
@pytest.mark.parametrize("start", [1e-4, 0.7, 3e4])
def test_the_load_of_an_area_of_hertz(start, rises, has_kinks):
    wanted = math.pi * (50e-6) ** 2
    contact = Contact(area_of_ball, wanted, rises=rises, has_kinks=has_kinks)
    force = 4.0 / 3.0 * MODULUS * (50e-6) ** 3 / RADIUS
    assert contact.load(start) == pytest.approx(force, rel=2e-6)
    # A power law is a straight line: two loads tell it.
    assert len(contact.forces) <= 7
    assert contact.search.convolutions == 3 * len(contact.forces)
    assert all(left >= 1 for left in contact.left)


@pytest.mark.parametrize("start", [1e-6, 1.0, 1e5])
def test_the_load_of_first_yield_of_a_ball_is_found_in_one_step_by_its_power(start):
    wanted = 1e9
    contact = Contact(stress_of_ball, wanted, rises=True, has_kinks=True, power=1.0 / 3.0, factor=1e12)
    force = math.pi**3 * RADIUS**2 * (wanted / 0.62) ** 3 / (6.0 * MODULUS**2)
    assert contact.load(start) == pytest.approx(force, rel=1e-5)
    assert len(contact.forces) == 2
    found = contact.search.tried[0]
    assert contact.search.find_slope(found, 0.01) == pytest.approx(1.0 / 3.0)
    assert contact.search.find_slope(found, 100.0) is None


def test_an_answer_that_falls_with_the_load_is_found_without_knowing_it():
    contact = Contact(lambda force: 1.0 / area_of_ball(force), 1.0 / area_of_ball(20.0))
    assert contact.load() == pytest.approx(20.0, rel=2e-6)


@pytest.mark.parametrize("has_kinks", [False, True])
def test_a_kink_of_the_power_costs_few_loads(has_kinks):
    """One cell in contact: the stress is in proportion to the load; many: to its third root."""
    contact = Contact(lambda force: min(force, force ** (1.0 / 3.0)), 0.5, rises=True, has_kinks=has_kinks)
    assert contact.load(1e3) == pytest.approx(0.5, rel=2e-6)
    assert len(contact.forces) <= 10


@pytest.mark.parametrize("has_kinks", [False, True])
def test_a_jump_is_enclosed_by_loads_on_both_sides(has_kinks):
    contact = Contact(lambda force: 1.0 if force < 12.0 else 3.0, 2.0, rises=True, has_kinks=has_kinks)
    assert contact.load() is None
    assert contact.search.is_jump
    low, high = contact.search.bracket
    assert contact.search.load_at(low.x) < 12.0 <= contact.search.load_at(high.x)
    assert high.x - low.x <= 1e-5
    assert {low.x, high.x} <= set(contact.search.solutions)


@pytest.mark.parametrize("within", [0.3, 1e-3])
def test_where_only_the_side_is_known_the_bracket_is_halved(within):
    contact = Contact(lambda force: 0.0 if force < 7.0 else math.inf, 1.0, rises=True, width=within, factor=1.5)
    assert contact.load() is None
    low, high = contact.search.bracket
    assert low.x < math.log(7.0) <= high.x
    assert high.x - low.x <= within
    # Steps by 1.5 and its powers up to the bracket, then halves.
    assert len(contact.forces) <= 5 + math.ceil(math.log2(4.0 * math.log(1.5) / within))


@pytest.mark.parametrize(("wanted", "end"), [(5.0, 1e4), (0.5, 1e-4)])
def test_a_plateau_leaves_the_wanted_answer_out_of_reach_of_the_last_load(wanted, end):
    contact = Contact(lambda force: 2.0, wanted, ends=(1e-4, 1e4), rises=True)
    assert contact.load() is None
    assert contact.search.bracket is None
    assert contact.forces[-1] == pytest.approx(end)
    assert len(contact.forces) < 12


def test_no_load_beyond_the_ends_is_asked():
    wanted = area_of_ball(1e3)
    contact = Contact(area_of_ball, wanted, ends=(1e-2, 10.0), rises=True)
    assert contact.load() is None
    assert max(contact.forces) == pytest.approx(10.0)
    assert max(contact.forces) <= 10.0


def test_known_contacts_are_not_solved_again():
    contact = Contact(area_of_ball, area_of_ball(5.0), rises=True)
    known = [SimpleNamespace(force=force, tension=0.0, convolutions=3) for force in (1.0, 9.0)]
    found = contact.search.run_from(known)
    assert contact.search.load_at(found.x) == pytest.approx(5.0, rel=2e-6)
    assert len(contact.forces) == 1
    assert all(1.0 < force < 9.0 for force in contact.forces)
