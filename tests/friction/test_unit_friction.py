"""Small functions of paths with friction beside closed forms: loads of increments, limits, sums and balances."""

from __future__ import annotations

import math
from types import SimpleNamespace

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._parts.interactions import shear_limit
from roughcontact._solve.problem import coupled
from roughcontact._solve.problem import increments as module
from roughcontact._solve.problem.coupled_starts import find_ratio
from roughcontact._solve.problem.friction_certificate import (
    FoundTractions,
    FrictionalContact,
    FrictionalFields,
    _are_close,
    _find_imbalance,
    stack_along,
)
from roughcontact._solve.problem.increments import (
    PathStep,
    _compare,
    _join,
    is_single,
    list_steps,
    list_targets,
    refine_steps,
)
from roughcontact._solve.problem.run import run_solve
from roughcontact._solve.problem.step_numbers import CellErrors, _find_limit, extrapolate_numbers, numbers_of
from roughcontact._solve.problem.strengths import StrengthBound
from roughcontact.results import TangentialLoad
from roughcontact.typing import Load
from test_frictional_paths import CELL, FRICTION, ROUGH

PUSH = "tangential_force"


def push(x, y):
    return TangentialLoad(PUSH, (x, y))


class TestLoads:
    def test_of_increments_lie_evenly_between_the_ends(self):
        step = PathStep(2, Load("force", 4.0), Load("force", 10.0), (1.0, -2.0), push(4.0, 4.0))
        load, target = step.at(1, 3)
        assert (load.kind, load.value, target.kind, target.values) == ("force", 6.0, PUSH, (2.0, 0.0))
        assert step.at(2, 3)[0].value == 8.0
        assert step.at(3, 3) == (step.end, step.after)
        same = attrs.evolve(step, start=step.end)
        assert same.at(1, 3)[0] is step.end

    def test_one_load_holds_for_all_steps(self):
        assert is_single({"force": 1.0, "pressure": None})
        assert is_single({"force": "1N"})
        assert not is_single({"force": [1.0]})
        assert not is_single({"force": 1.0, "pressure": 2.0})
        assert not is_single({"force": None})

    def test_along_the_surface_are_pairs(self):
        assert list_targets({PUSH: (1.0, "2mN"), "displacement": None}) == [push(1.0, 2e-3)]
        moved = list_targets({"displacement": [(1.0, 2.0), ("3um", 4.0)]})
        assert [(one.kind, one.values) for one in moved] == [
            ("displacement", (1.0, 2.0)), ("displacement", (3e-6, 4.0))
        ]  # fmt: skip
        assert list_targets({PUSH: np.array([[1.0, 2.0]])}) == [push(1.0, 2.0)]
        for wrong, words in (
            ({}, "neither"),
            ({PUSH: (1.0, 2.0), "displacement": (1.0, 2.0)}, "tangential_force= and displacement="),
            ({PUSH: "1N"}, "pairs"),
            ({PUSH: 1.0}, "pairs"),
            ({PUSH: []}, "pairs"),
            ({PUSH: [(1.0, 2.0, 3.0)]}, "An item of"),
            ({PUSH: [1.0, 2.0, 3.0]}, "An item of"),
            ({PUSH: ["1N", (1.0, 2.0)]}, "An item of"),
            ({PUSH: [(1.0, "2m")]}, "A component of"),
        ):
            with pytest.raises(rc.InputError, match=words):
                list_targets(wrong)

    @staticmethod
    def list(normal, pushes, coupled=False):
        problem = rc.ContactProblem(
            rc.Body(rc.ParaboloidSurface(1e-3), rc.Elastic(1e9, 0.3)), grid=rc.Grid((8, 8), 1e-4), threads=1
        )
        run = SimpleNamespace(problem=problem, shear=SimpleNamespace(coupled=coupled))
        return list_steps(run, normal, {PUSH: pushes})

    def test_of_a_constant_normal_load_begin_with_pressing(self):
        steps = self.list({"force": 1e-3}, [(1e-5, 0.0), (3e-5, 0.0), (0.0, 0.0)])
        assert [step.number for step in steps] == [0, 1, 2, 3]
        assert [step.start.value for step in steps] == [0.0, 1e-3, 1e-3, 1e-3]
        assert [step.before for step in steps] == [(0.0, 0.0), (0.0, 0.0), (1e-5, 0.0), (3e-5, 0.0)]
        assert [step.after.values for step in steps] == [(0.0, 0.0), (1e-5, 0.0), (3e-5, 0.0), (0.0, 0.0)]
        assert steps[0].exact.startswith("no tangential load")
        assert all(step.exact == "the normal load is constant, slip is monotone" for step in steps[1:])
        # A turn ends it, and so does coupling.
        turned = self.list({"force": 1e-3}, [(1e-5, 0.0), (1e-5, 1e-5), (1e-5, 2e-5)])
        assert [bool(step.exact) for step in turned] == [True, True, False, False]
        assert not any(step.exact for step in self.list({"force": 1e-3}, [(1e-5, 0.0)], coupled=True))

    def test_of_several_normal_loads_grow_with_them(self):
        steps = self.list({"force": [1e-3, 2e-3]}, [(0.0, 1e-5), (0.0, 2e-5)])
        assert [(step.number, step.start.value, step.end.value) for step in steps] == [(1, 0.0, 1e-3), (2, 1e-3, 2e-3)]
        assert not any(step.exact for step in steps)
        one = self.list({"force": [1e-3, 2e-3]}, [(0.0, 1e-5)])
        assert [step.after.values for step in one] == [(0.0, 1e-5), (0.0, 1e-5)]
        with pytest.raises(rc.InputError, match="2 normal loads, but 3 tangential loads"):
            self.list({"force": [1e-3, 2e-3]}, [(0.0, 1e-5)] * 3)


def make_step(moved=(1.0, 0.0), lost=1.0, stick=1.0, energy=1.0, kind=PUSH, pushed=(1.0, 0.0), unsure=0.25, cells=100):
    """Return a step whose numbers are given: what sticks has an uncertainty of 2e-3."""
    grid = SimpleNamespace(cell_area=0.01)
    return SimpleNamespace(
        contact=np.arange(400) < cells, area=lambda **_: rc.Area(1.5, 0.1, 0.01, "blend"), saturated=np.zeros(3, bool),
        tangential_displacement=moved, tangential_force=pushed, dissipated=rc.Estimate(lost, unsure, "J"), grid=grid,
        stick_area=rc.Estimate(stick, 2e-3, "m2"), elastic_energy=energy, approach=2.0,
        tangential_load=TangentialLoad(kind, (0.0, 0.0)),
    )  # fmt: skip


class TestChanges:
    """What changes from half as many increments, over what is admissible: 2.5, 10 and 3 %."""

    def test_of_displacements(self):
        found = _compare([make_step((1.0, 0.5)), make_step()], [make_step((1.0, 0.54)), make_step((2.0, 0.0))])
        assert found == pytest.approx(1.0 / (2.5e-2 * 2.0))
        assert _compare([make_step((0.0, 0.5))], [make_step((0.0, 0.48))]) == pytest.approx(0.02 / (2.5e-2 * 0.48))
        # Of a displacement below a hundredth of the approach it is over that.
        small = _compare([make_step((0.0, 0.0))], [make_step((1e-3, 0.0))])
        assert small == pytest.approx(1e-3 / (2.5e-2 * 1e-2 * 2.0))

    def test_of_energies(self):
        found = _compare([make_step(lost=1.0), make_step(lost=2.0)], [make_step(lost=1.1), make_step(lost=1.8)])
        assert found == pytest.approx(0.3 / (0.1 * 2.9))
        little = _compare([make_step(lost=0.0)], [make_step(lost=1e-4)])
        assert little == pytest.approx(1e-4 / (0.1 * 1e-2))

    def test_of_areas(self):
        assert _compare([make_step(stick=1.0)], [make_step(stick=1.2)]) == pytest.approx(0.2 / (3e-2 * 1.0))
        # Over a cell at least.
        few = _compare([make_step(stick=0.05, cells=10)], [make_step(stick=0.06, cells=10)])
        assert few == pytest.approx(1.0)


class TestLimits:
    @pytest.mark.parametrize(("order", "ratio"), [(0.5, math.sqrt(2.0)), (1.0, 2.0), (2.0, 4.0)])
    def test_of_a_power_of_the_increments_are_exact(self, order, ratio):
        limit = np.array([3.0, -1.0])
        values = [limit + np.array([0.4, 0.3]) * n**-order for n in (4.0, 8.0, 16.0)]
        found, std = _find_limit(values)
        np.testing.assert_allclose(found, limit, atol=1e-12)
        changes = [0.5 * (4.0**-order - 8.0**-order), 0.5 * (8.0**-order - 16.0**-order), 0.5 * 16.0**-order]
        assert std == pytest.approx(0.5 * max(changes))
        assert changes[0] / changes[1] == pytest.approx(ratio)

    def test_beyond_these_orders_are_bounded(self):
        fast, std = _find_limit([np.array([0.0]), np.array([1.0]), np.array([1.1])])
        assert fast[0] == pytest.approx(1.1 + 0.1 / 3.0)
        assert std == pytest.approx(0.5)
        slow, std = _find_limit([np.array([0.0]), np.array([1.0]), np.array([2.5])])
        assert slow[0] == pytest.approx(2.5 + 1.5 / (math.sqrt(2.0) - 1.0))
        assert std == pytest.approx(2.5)
        still, std = _find_limit([np.array([0.0]), np.array([1.0]), np.array([1.0])])
        assert (still[0], std) == (1.0, 0.0)

    def test_of_steps_have_the_errors_of_the_cells_too(self):
        steps = [make_step((1.0 + part, 0.0), 2.0 + part, 1.0 + part) for part in (0.4, 0.2, 0.1)]
        error = CellErrors(displacement=0.03, force=0.07, dissipated=0.05)
        found = extrapolate_numbers(steps, error, ("said",))
        assert found.displacement[0].value == pytest.approx(1.0)
        assert found.displacement[0].uncertainty == pytest.approx(math.hypot(0.1, 0.03))
        assert found.displacement[1].value == 0.0
        assert (found.tangential_force[0].value, found.tangential_force[0].uncertainty) == (1.0, 0.0)
        assert found.dissipated.value == pytest.approx(2.0)
        assert found.dissipated.uncertainty == pytest.approx(math.hypot(0.1, 0.05))
        assert found.stick_area.value == pytest.approx(1.0)
        assert found.stick_area.uncertainty == pytest.approx(math.hypot(0.1, 2e-3))
        assert found.stick_area.warnings == found.dissipated.warnings == ("said",)
        units = [one.unit for one in (*found.displacement, *found.tangential_force, found.dissipated, found.stick_area)]
        assert units == ["m", "m", "N", "N", "J", "m2"]
        moved = [
            make_step((1.0, 0.0), kind="displacement", pushed=(2.0 + part, 0.0), lost=-1.0, stick=1.5 - part)
            for part in (0.4, 0.2, 0.1)
        ]
        found = extrapolate_numbers(moved, error, ())
        assert (found.displacement[0].value, found.displacement[0].uncertainty) == (1.0, 0.0)
        assert found.tangential_force[0].value == pytest.approx(2.0)
        assert found.tangential_force[0].uncertainty == pytest.approx(math.hypot(0.1, 0.07))
        # No less than nothing is lost, and no more than the contact sticks.
        assert found.dissipated.value == 0.0
        more = [make_step(stick=1.0 + part) for part in (0.0, 0.3, 0.45)]
        assert extrapolate_numbers(more, error, ()).stick_area.value == pytest.approx(1.5)

    def test_of_single_increments_are_their_numbers(self):
        found = numbers_of(make_step((1.0, 2.0)), CellErrors(displacement=0.1, force=0.2, dissipated=0.3), ("said",))
        assert [one.value for one in found.displacement] == [1.0, 2.0]
        assert {one.uncertainty for one in found.displacement} == {0.1}
        assert {one.uncertainty for one in found.tangential_force} == {0.2}
        assert (found.dissipated.value, found.dissipated.uncertainty) == (1.0, 0.25)
        assert found.stick_area.warnings == ("said",)


@attrs.frozen
class Friction:
    slip: float
    dissipated: rc.Estimate
    passes: int
    iterations: int
    increments: int


@attrs.frozen
class Part:
    sheared: Friction
    seconds: float
    iterations: int
    convolutions: int

    @property
    def dissipated(self):
        return self.sheared.dissipated

    def _add(self, sheared, **cost):
        return Part(sheared, **cost)


@pytest.mark.parametrize("exact", [False, True])
def test_a_step_is_the_sum_of_its_increments(exact):
    parts = [Part(Friction(0.0, rc.Estimate(n, 0.1 * n, "J"), n, 10 * n, 1), 0.5, n, 2 * n) for n in (3, 5, 2)]
    run = SimpleNamespace(length=2.0)
    step = _join(run, parts, SimpleNamespace(relative=1.0), SimpleNamespace(relative=4.0), is_exact=exact)
    found = step.sheared
    assert (found.slip, found.passes, found.iterations, found.increments, step.seconds) == (6.0, 5, 100, 3, 1.5)
    assert (step.iterations, step.convolutions) == (10, 20)
    assert (found.dissipated.value, found.dissipated.unit) == (10.0, "J")
    assert found.dissipated.uncertainty == pytest.approx(0.0 if exact else 1.0)


@pytest.mark.parametrize(
    ("loads", "ratio"),
    [
        ([(0, 0, 0), (2, 1, 0), (4, 2, 0)], 1.0),
        ([(0, 0, 0), (2, 1, 0), (3, 1.5, 0)], 0.5),
        ([(5, 0, 0), (5, 1, 1), (5, 3, 3)], 2.0),
        # Units do not matter.
        ([(1e9, 0, 0), (2e9, 1e-9, 1e-9), (3e9, 2e-9, 2e-9)], 1.0),
        ([(0, 0, 0), (2, 1, 0), (4, 3, 0)], 0.0),
        ([(0, 0, 0), (2, 1, 0), (4, 2, 0.5)], 0.0),
        ([(5, 0, 0), (5, 1, 0), (5, 0, 0)], 0.0),
        ([(5, 0, 0), (5, 1, 0), (5, 4, 0)], 0.0),
        ([(5, 1, 0), (5, 1, 0), (5, 2, 0)], 0.0),
        ([(5, 0, 0), (5, 1, 0), (5, 1, 0)], 0.0),
    ],
)
def test_an_increment_continues_the_one_before_in_its_direction(loads, ratio):
    """Not after a turn, after a stop, or much farther."""
    first, last, end = (np.array(one, dtype=float) for one in loads)
    assert find_ratio((first, last), end) == pytest.approx(ratio)


def test_a_contact_of_like_bodies_is_found_once_for_each_load(monkeypatch):
    """The increments are doubled, and pass the same loads again."""
    asked = []

    def solve(problem, load, **others):
        asked.append(load.value)
        return run_solve(problem, load, **others)

    monkeypatch.setattr(coupled, "run_solve", solve)
    bodies = rc.Body(ROUGH, rc.Elastic(200e9, 0.3)), rc.Body(rc.FlatSurface(), rc.Elastic(200e9, 0.3))
    problem = rc.ContactProblem(*bodies, grid=rc.Grid((16, 16), (16 * CELL, 16 * CELL)), boundary="periodic", threads=1)
    path = problem.path(force=[0.02, 0.03], tangential_force=[(0.002, 0.0), (-0.002, 0.0)], friction=FRICTION)
    assert path.increments[0] >= 4
    assert len(asked) == len(set(asked))


@pytest.mark.parametrize(("part", "falls", "counts"), [(0.1, 4.0, [1, 2, 4]), (0.3, 1.3, [1, 2, 4, 8, 16])])
def test_increments_are_doubled_until_the_numbers_hardly_change(part, falls, counts, monkeypatch):
    """Four at least, which show their order, and sixteen at most; then it is said."""
    asked = []

    def follow(run, segments, count, tell, last):
        asked.append(count)
        return [make_step((1.0 + part * falls ** -math.log2(count), 0.0))]

    monkeypatch.setattr(module, "follow_steps", follow)
    error = CellErrors(displacement=0.0, force=0.0, dissipated=0.0)
    monkeypatch.setattr(module, "list_cell_errors", lambda steps, last: [error for _ in steps])
    step = PathStep(1, Load("force", 1.0), Load("force", 1.0), (0.0, 0.0), push(1.0, 0.0))
    steps, numbers, reasons = refine_steps(SimpleNamespace(), [step], lambda one: None)
    assert asked == counts
    assert len(steps) == len(numbers) == len(reasons) == 1
    slow = counts[-1] == 16
    assert bool(numbers[0].stick_area.warnings) == slow
    assert reasons[0].startswith("doubled until the numbers change by")
    if not slow:
        assert numbers[0].displacement[0].value == pytest.approx(1.0)
    else:
        assert numbers[0].stick_area.warnings[0].startswith("16 increments of a step are not enough")
    exact = attrs.evolve(step, exact="slip is monotone")
    _, numbers, reasons = refine_steps(SimpleNamespace(), [exact], lambda one: None)
    assert reasons == ["slip is monotone"]
    assert numbers[0].displacement[0].uncertainty == 0.0


def test_the_strength_that_counts_is_four_times_what_the_load_causes():
    strength = np.array([[1e4, 2.0], [0.5, 0.0]])
    bound = StrengthBound(strength, own=0.5, peak=3.0)
    shear = np.zeros((2, 2, 2))
    shear[:, 0, 0] = 3.0, 4.0
    slip = np.zeros((2, 2, 2))
    np.testing.assert_array_equal(bound.find(shear, slip), np.minimum(strength, 20.0))
    slip[:, 0, 1] = 0.0, 6.0
    np.testing.assert_array_equal(bound.find(shear, slip), np.minimum(strength, 48.0))
    # Slip where nothing touches causes nothing.
    slip[:] = 0.0
    slip[:, 1, 1] = 100.0
    np.testing.assert_array_equal(bound.find(shear, slip), np.minimum(strength, 20.0))
    assert bound.find(np.zeros((2, 2, 2)), np.zeros((2, 2, 2))).max() == pytest.approx(4.0 * 3e-12)


def test_energy_and_work_of_a_linear_system_are_in_balance():
    """Elastic energies of symmetric compliances: what the loads do less what slip loses is what is stored."""
    rng = np.random.default_rng(1)
    matrix = rng.normal(size=(12, 12))
    compliance = matrix @ matrix.T

    def state(scale, slip):
        tractions = scale * rng.normal(size=12)
        moved = compliance @ tractions
        pressure, shear = tractions[:4].reshape(2, 2), tractions[4:].reshape(2, 2, 2)
        tangential = moved[4:].reshape(2, 2, 2)
        displacement = rng.normal(size=2)
        relative = displacement[:, np.newaxis, np.newaxis] - tangential
        normal, lifted = moved[:4].reshape(2, 2), np.zeros((2, 2))
        return FrictionalFields(pressure, shear, tangential, normal, relative, displacement, 0.0, lifted)

    begin, end = state(1.0, 0.0), state(2.0, 0.3)
    assert end.energy == pytest.approx(0.5 * (np.sum(end.pressure * end.normal) + np.sum(end.shear * end.tangential)))
    assert _find_imbalance(begin, end) < 1e-14
    wrong = attrs.evolve(end, normal=end.normal + 0.1)
    gained = 0.5 * 0.1 * float(end.pressure.sum())
    pressing = 0.5 * 0.1 * float((begin.pressure + end.pressure).sum())
    terms = [wrong.energy, begin.energy]
    assert _find_imbalance(begin, wrong) == pytest.approx(
        abs(gained - pressing)
        / max(
            *terms,
            abs(0.5 * np.sum((begin.pressure + end.pressure) * (wrong.normal - begin.normal))),
            abs(np.sum(0.5 * (begin.shear + end.shear).sum(axis=(1, 2)) * (end.displacement - begin.displacement))),
            abs(np.sum(0.5 * (begin.shear + end.shear) * (end.relative - begin.relative))),
        )
    )


def test_tractions_of_one_direction_and_numbers_that_are_the_same():
    np.testing.assert_array_equal(stack_along(np.array([[1.0, 2.0]]), (3.0, -1.0)), [[[3.0, 6.0]], [[-1.0, -2.0]]])
    assert _are_close(1.0, 1.0 + 0.9e-10, 1.0)
    assert not _are_close(1.0, 1.0 + 1.1e-10, 1.0)
    assert _are_close(np.array([1.0, 2.0]), np.array([1.0, 2.0 + 1e-9]), 20.0)


PRESSURE = np.array([[0.0, 1e6], [2e9, 5e7]])


def test_a_coefficient_that_varies_is_for_the_cells_that_it_has():
    law = rc.Coulomb(np.array([[0.1, 0.2], [0.3, 0.0]]))
    with pytest.raises(rc.InputError, match=r"varies over cells of shape \(2, 2\)"):
        shear_limit(law, np.ones((3, 3)))


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (lambda p: 0.3 * p.ravel(), "limits of shape"),
        (lambda p: -p, "negative or not finite"),
        (lambda p: p * np.nan, "negative or not finite"),
        (lambda p: p + 1e5, "above zero where there is no pressure"),
    ],
)
def test_limits_of_ones_own_are_checked(limit, words):
    class Own(rc.FrictionLaw):
        def limit(self, pressure):
            return limit(pressure)

    with pytest.raises(rc.InputError, match=words):
        shear_limit(Own(), PRESSURE)


def test_energy_that_slip_would_gain_has_no_unit():
    """Reversed, the traction of sliding cells would gain what it loses."""
    residuals = []
    for scale in (1.0, 1e3):
        problem = rc.ContactProblem(
            rc.Body(ROUGH, rc.Elastic(200e9 * scale, 0.3)),
            rc.Body(rc.FlatSurface(), rc.Elastic(200e9 * scale, 0.3)),
            grid=rc.Grid((24, 16), (24 * CELL, 16 * CELL)),
            boundary="periodic",
            threads=1,
        )
        loads = {"force": 0.02 * scale, "tangential_force": [(0.004 * scale, 0.0)], "friction": FRICTION}
        run = FrictionalContact(problem, rc.Coulomb(FRICTION))
        state = problem.path(**loads)[0]
        wrong = attrs.evolve(state.end, shear=-state.shear)
        found = FoundTractions(state, wrong.shear, np.zeros(2), state.status, 1, 0)
        start = run.fields_of(state.sheared.before)
        again, _ = run.judge(state, wrong, state.tangential_load, state.sheared.before, start, found, 0.0)
        assert not again.status.success
        residuals.append(again.sheared.residuals.dissipation)
        limit = state.shear_strength
        gained = -float((wrong.shear * again.slip).sum())
        cell = 0.5 * sum(problem.shear_convolution.own) * problem.plan.peak_to_valley / run.unit
        assert residuals[-1] == pytest.approx(gained / (cell * limit.max() * limit.sum()))
    assert residuals[0] == pytest.approx(residuals[1], rel=1e-6)
    assert 0.0 < residuals[0] < 10.0
