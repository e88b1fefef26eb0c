"""Small functions of contacts with adhesion beside closed forms: conditions, borders, peaks, gaps and areas."""

from __future__ import annotations

import math
from types import SimpleNamespace

import attrs
import numpy as np
import pytest

import roughcontact as rc
from exact_contacts import MODULUS, with_fields
from roughcontact._solve.problem import cycle, pull_off
from roughcontact._solve.solution.attraction import (
    AdhesiveConditions,
    average_gap,
    count_patch_cells,
    describe_range,
    find_cut_tension,
    interpolate_peak,
    trapping_error,
    warn_of_border,
    widen_area,
)
from roughcontact._solve.solution.results import _undecided, estimate_attractive_area
from roughcontact.typing import BoundInteraction

LAW = BoundInteraction(rc.Exponential(2.0, 4.0))
GRID = rc.Grid((9, 12), (4.5, 24.0))


def sticky(tension, pressure=None, boundary="free", grid=GRID, **options):
    """Return a solution with a tension where the surfaces are open; the contact pressure is that without it."""
    contact = np.zeros(grid.shape) if pressure is None else pressure
    solution = with_fields(grid, contact - tension, np.where(contact > 0.0, 0.0, 1.0), boundary=boundary, **options)
    return attrs.evolve(solution, tension=np.asarray(tension, dtype=float))


class TestConditions:
    """A state that meets them, and each of them violated alone."""

    @pytest.fixture
    def state(self):
        rng = np.random.default_rng(1)
        gap = rng.uniform(0.5, 3.0, (6, 7))
        gap[2:4, 2:5] = 0.0
        displacement = rng.uniform(0.0, 2.0, gap.shape)
        tension = LAW.tension(gap)
        contact = np.where(gap == 0.0, rng.uniform(1.0, 2.0, gap.shape), 0.0)
        approach = 1.3
        return SimpleNamespace(
            initial_gap=gap - displacement + approach, displacement=displacement, tension=tension, contact=contact,
            gap=gap, approach=approach,
        )  # fmt: skip

    @staticmethod
    def measure(state, limit=math.inf, approach=None, **options):
        conditions = AdhesiveConditions(
            initial_gap=state.initial_gap, interaction=LAW, pressure_limit=np.array(limit), approach=approach, **options
        )
        return conditions.measure(state.contact - state.tension, state.tension, state.displacement)

    def test_met(self, state):
        for approach in (None, 1.3):
            found = self.measure(state, approach=approach)
            assert found.approach == pytest.approx(1.3)
            assert found.error < 1e-14
            assert (found.tension, found.bounds) == pytest.approx((0.0, 0.0), abs=1e-14)
            assert found.scale == pytest.approx(min(state.initial_gap.std(), np.ptp(state.displacement)))
        assert self.measure(state, rms=0.01).scale == 0.01

    def test_violated_one_by_one(self, state):
        scale = self.measure(state).scale
        higher = self.measure(state, approach=1.5)
        assert (higher.complementarity, higher.penetration) == pytest.approx((0.2 / scale, 0.2 / scale))
        lower = self.measure(state, approach=1.2)
        assert (lower.complementarity, lower.penetration) == pytest.approx((0.1 / scale, 0.0))
        off = state.tension.copy()
        off[0, 0] += 0.125
        wrong = self.measure(SimpleNamespace(**{**vars(state), "tension": off}))
        strength, steepest = 0.5, 0.125
        assert wrong.tension == pytest.approx(0.125 / strength)
        assert wrong.gap == pytest.approx(0.125 / (steepest * scale))
        assert wrong.error == pytest.approx(wrong.gap)

    def test_of_saturated_cells_only_what_opens_counts(self, state):
        limit = float((state.contact - state.tension)[3, 3])
        state.contact[state.contact - state.tension > limit] = 0.6
        saturated = (state.contact - state.tension) >= limit
        assert saturated.sum() == 1
        state.displacement[saturated] -= 0.4
        found = self.measure(state, limit)
        assert found.approach == pytest.approx(1.3)
        assert found.complementarity == found.penetration == pytest.approx(0.0, abs=1e-13)
        state.displacement[saturated] += 0.6
        found = self.measure(state, limit)
        carried = float(state.contact.sum())
        expected = 0.2 * float(state.contact[saturated].sum()) / carried / found.scale
        assert found.complementarity == pytest.approx(expected)
        above = self.measure(state, 0.75 * limit)
        assert above.bounds > 0.0

    def test_without_elastic_cells_the_highest_touches(self, state):
        apart = SimpleNamespace(**{**vars(state), "contact": np.zeros(state.gap.shape)})
        moved = state.displacement + state.initial_gap
        found = self.measure(apart)
        assert found.approach == pytest.approx(float(moved.min()))
        assert found.scale == pytest.approx(float(state.initial_gap.std()))
        flat = SimpleNamespace(**{**vars(apart), "initial_gap": np.ones(state.gap.shape)})
        assert self.measure(flat).scale == pytest.approx(np.ptp(state.displacement))
        still = SimpleNamespace(**{**vars(flat), "displacement": np.zeros(state.gap.shape)})
        assert self.measure(still).scale == 1.0


def test_patches_have_the_cells_of_a_disc_of_their_ratio_at_most():
    block = np.zeros((60, 60), dtype=bool)
    block[5:8, 3:6] = True
    assert count_patch_cells(block, rc.Boundary.FREE) == 9.0
    strip = np.zeros((60, 60), dtype=bool)
    strip[:, 10:16] = True
    # Two rows of sixty at the edges.
    assert count_patch_cells(strip, rc.Boundary.PERIODIC) == pytest.approx(4.0 * math.pi * 3.0**2)
    assert count_patch_cells(np.zeros((5, 5), dtype=bool), rc.Boundary.FREE) == 1.0
    assert count_patch_cells(np.ones((5, 6), dtype=bool), rc.Boundary.FREE) == 30.0


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [0, -1])
def test_a_tension_that_falls_by_a_factor_is_continued_by_its_geometric_series(axis, side):
    """Beyond the border 8, 4, 2, 1 goes on as 1/2, 1/4, ...: as much as the last; never more than the force."""
    tension = np.zeros(GRID.shape)
    lines = np.moveaxis(tension, axis, 0)[:: 1 if side == 0 else -1]
    lines[:4] = np.array([1.0, 2.0, 4.0, 8.0])[:, np.newaxis]
    lines[4:] = 8.0
    solution = sticky(tension)
    ratio, force = find_cut_tension(solution)
    # At the other border it does not fall: over as many cells as have half of it at least.
    count = GRID.shape[axis]
    other = 8.0 * (count - 2)
    across = GRID.shape[1 - axis]
    assert ratio == 1.0
    alone = (1.0 + other) * across * GRID.cell_area
    along = sum(float(line.sum()) for line in lines) / across
    sides = 2.0 * along * across * GRID.cell_area
    assert force == pytest.approx(min(alone + sides, abs(solution.force)))
    periodic = [("free", "periodic"), ("periodic", "free")][axis]
    one = attrs.evolve(solution, boundary=rc.Boundary("-".join(periodic)))
    assert find_cut_tension(one)[1] == pytest.approx(min(alone, abs(solution.force)))
    small = np.where(tension == 8.0, 0.0, tension)
    lines = np.moveaxis(small, axis, 0)[:: 1 if side == 0 else -1]
    lines[3] = 8.0
    one = attrs.evolve(sticky(small), boundary=one.boundary)
    assert find_cut_tension(one) == pytest.approx((0.125, across * GRID.cell_area))
    assert find_cut_tension(attrs.evolve(one, boundary=rc.Boundary.PERIODIC)) == (0.0, 0.0)
    assert find_cut_tension(with_fields(GRID, 0.0, 1.0)) == (0.0, 0.0)


def test_the_border_is_warned_of_from_a_thousandth_on():
    for part, warned in ((0.9e-3, False), (1.1e-3, True)):
        tension = np.zeros(GRID.shape)
        tension[4, 5] = 1.0
        tension[0, 5] = part
        found = warn_of_border(sticky(tension))
        assert (found is not None) == warned
        if found is not None:
            assert f"is {100 * part:.3g} % of its maximum" in found
            assert (found.rule, found.value) == ("border tension", pytest.approx(part))


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_maximum_of_a_paraboloid_between_the_cells(boundary):
    place = (0.3, -0.9)
    x, y = GRID.x - place[0], GRID.y - place[1]
    pressure = 50.0 - 0.5 * x**2 - 0.25 * y**2
    found = interpolate_peak(with_fields(GRID, pressure, 0.0, boundary=boundary))
    assert found.value == pytest.approx(50.0, rel=1e-12)
    rise = 50.0 - pressure.max()
    drop = 0.5 * (0.5 * GRID.spacing[0] ** 2 + 0.25 * GRID.spacing[1] ** 2)
    assert found.uncertainty == pytest.approx(0.5 * rise + 0.25 * drop)
    assert found.unit == "Pa"


def test_the_mean_gap_is_as_unsure_as_the_bend_around_the_contact():
    gap = 0.2 * GRID.x**2 + 0.1 * GRID.y**2
    contact = np.zeros(GRID.shape)
    contact[4, 5:7] = 1.0
    far = gap + np.where(np.abs(GRID.y) > 8.0, 100.0, 0.0)
    solution = with_fields(GRID, contact, far, initial_gap=far)
    found = average_gap(solution)
    assert found.value == pytest.approx(far.mean())
    bend = 0.2 * 2.0 * GRID.spacing[0] ** 2 + 0.1 * 2.0 * GRID.spacing[1] ** 2
    assert found.uncertainty == pytest.approx(0.05 * bend)
    unsolved = attrs.evolve(solution, residuals=attrs.evolve(solution.residuals, penetration=0.3, scale=2.0))
    assert average_gap(unsolved).uncertainty == pytest.approx(math.hypot(0.05 * bend, 0.6))
    # Without contact around the lowest gap; what overlaps counts as closed.
    open_ = with_fields(GRID, 0.0, gap - 0.5, initial_gap=gap)
    assert average_gap(open_).value == pytest.approx(np.maximum(gap - 0.5, 0.0).mean())
    assert average_gap(open_).uncertainty == pytest.approx(0.05 * bend)


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        (2.0, ("starts to stick", "1.5 % off")),
        (1.2, ("sticks", "7.3 % off")),
        (0.21, ("sticks", "a factor of about 2")),
    ],
)
def test_a_range_that_the_cells_do_not_resolve_is_warned_of(cells, words):
    """The cohesive length E* r^2 / w of an exponential law; 2.5 cells resolve it."""
    spacing = GRID.resolved.spacing
    law = rc.Exponential(0.1, math.sqrt(0.1 * cells * max(spacing) / MODULUS))
    assert law.cohesive_cells(spacing, MODULUS) == pytest.approx(cells, rel=0.5)
    factor = math.sqrt(cells / law.cohesive_cells(spacing, MODULUS))
    law = rc.Exponential(0.1, factor * law.range)
    text = describe_range(law, GRID, MODULUS)
    assert all(word in text for word in words)
    assert f"has {cells:.2g} cells" in text
    assert f"a range {math.sqrt(2.5 / cells):.2g} times as long" in text
    assert f"cells of at most {max(spacing) * cells / 2.5:.2g} m" in text or "mm" in text
    resolved = rc.Exponential(0.1, law.range * math.sqrt(2.51 / cells))
    assert describe_range(resolved, GRID, MODULUS) is None
    assert trapping_error(1.0) == pytest.approx(0.8 / math.e**2)


def test_strong_tension_is_counted_with_half_a_cell_at_its_edge():
    tension = np.zeros(GRID.shape)
    tension[3:6, 4:8] = 1.0
    tension[4, 5:7] = 2.0
    tension[8, 11] = 2.0
    contact = np.zeros(GRID.shape)
    contact[8, 11] = 3.0
    solution = sticky(tension, contact)
    half = estimate_attractive_area(solution, 0.4)
    # Twelve cells, eight sides along y and six along x.
    assert (half.value, half.fraction) == (12 * GRID.cell_area, 12 / 108)
    assert half.uncertainty == pytest.approx(0.5 * math.sqrt(14) * GRID.cell_area)
    assert estimate_attractive_area(solution, 0.6).value == 2 * GRID.cell_area
    with pytest.raises(rc.InputError, match="below 1"):
        estimate_attractive_area(solution, 1.0)
    with pytest.raises(rc.InputError, match="do not attract"):
        estimate_attractive_area(with_fields(GRID, 1.0, 0.0), 0.5)


def test_cells_at_the_limit_whose_gap_is_zero_are_undecided():
    pressure = np.zeros(GRID.shape)
    pressure[2, 2:6] = 2.0
    gap = np.where(pressure > 0.0, 0.0, 1.0)
    gap[2, 4] = -0.1
    solution = with_fields(GRID, pressure, gap, limit=2.0)
    assert _undecided(solution) == 3 * GRID.cell_area
    pressure[2, 3] = 1.9
    assert _undecided(with_fields(GRID, pressure, gap, limit=2.0)) == 2 * GRID.cell_area


@pytest.mark.parametrize("cells", [0.5, 1.0, 4.0])
def test_areas_are_as_unsure_as_the_edge_over_the_cohesive_length(cells):
    """20 % over its cells and the root of the cells of the patch; 22 % more at half a cell, where it sticks."""
    i, j = np.indices((40, 40))
    grid = rc.Grid((40, 40), 40.0)
    contact = np.where(np.hypot(i - 20, j - 20) < 12.5, 1.0, 0.0)
    law = rc.Exponential(0.1, math.sqrt(0.1 * cells / MODULUS))
    law = rc.Exponential(0.1, law.range * math.sqrt(cells / law.cohesive_cells((1.0, 1.0), MODULUS)))
    solution = sticky(np.where(contact > 0.0, 0.0, 0.1), contact, grid=grid)
    origin = SimpleNamespace(missing=(), problem={"adhesion": law})
    area = rc.Area(100.0, 0.1, 3.0, "blend")
    found = widen_area(area, solution, origin)
    size = count_patch_cells(contact > 0.0, rc.Boundary.FREE)
    stuck = {0.5: 0.2165, 1.0: 0.0293, 4.0: 0.0}[cells]
    expected = math.hypot(3.0, 100.0 * math.hypot(0.2 / (cells * math.sqrt(size)), stuck))
    assert found.uncertainty == pytest.approx(expected, rel=1e-3)
    assert found.value == 100.0
    short = attrs.evolve(solution)
    limit = widen_area(area, short, SimpleNamespace(missing=(), problem={"adhesion": rc.ShortRange(0.1)}))
    # Balls of 7 to 40 cells are 8.5 to 2.9 % below the radius in the limit.
    assert 0.03 < limit.uncertainty / 100.0 < 0.2
    assert widen_area(area, with_fields(grid, contact, 1.0 - contact), origin) is area
    assert widen_area(area, solution, SimpleNamespace(missing=("adhesion",), problem={})) is area


class Path:
    """States of given approaches and forces; `energies` are those of the states."""

    def __init__(self, approach, force, energies=None, name=""):
        self.approach, self.force = (np.asarray(one, dtype=float) for one in (approach, force))
        self.energies, self.name = energies, name

    def __len__(self):
        return len(self.force)

    def __getitem__(self, index):
        return SimpleNamespace(force=self.force[index], approach=self.approach[index], warnings=())

    def __iter__(self):
        return iter(self[k] for k in range(len(self)))


class TestCycles:
    """Springs: their work is their energy, but where a part of it is lost at once."""

    STIFFNESS = 3.0

    @pytest.fixture(autouse=True)
    def cells(self, monkeypatch):
        monkeypatch.setattr(cycle, "_find_energies", lambda path: path.energies)
        monkeypatch.setattr(cycle, "cells_of", lambda state: 2.0)

    def make(self, lost_loading=0.0, lost_unloading=0.0, shift=0.0):
        """Return a cycle of six states on a spring; between the third and fourth a part of the energy is lost."""
        approach = np.array([-2.0, -1.0, 0.0, 1.0, 2.0, 4.0])
        force = self.STIFFNESS * (approach + shift)
        energy = 0.5 * self.STIFFNESS * (approach + shift) ** 2
        step = np.array([0, 0, 0, 1, 1, 1])
        loading = Path(approach, force, energy - lost_loading * step)
        unloading = Path(approach[::-1], force[::-1], energy[::-1] - lost_unloading * step)
        return cycle.AdhesionCycle(loading, unloading)

    def test_nothing_is_lost_on_a_spring(self):
        found = self.make()
        for lost in found.losses:
            np.testing.assert_allclose(lost, 0.0, atol=1e-12)
        assert found.dissipated.value == pytest.approx(0.0, abs=1e-12)
        assert found.dissipated.uncertainty < 1.0
        assert found.jumps == ()

    def test_the_energy_lost_in_a_step_is_a_jump(self):
        found = self.make(4.0, 5.0)
        np.testing.assert_allclose(found.losses[0], [0, 0, 4, 0, 0], atol=1e-12)
        np.testing.assert_allclose(found.losses[1], [0, 0, 5, 0, 0], atol=1e-12)
        assert found.jumps == ((0.0, 1.0), (1.0, 0.0))
        lost = found.dissipated
        assert lost.value == pytest.approx(9.0)
        assert lost.unit == "J"
        # Anywhere in a step of 1 over which the force changes by 3: a uniform distribution.
        jumps = math.hypot(3.0, 3.0) / math.sqrt(12.0)
        smooth = 2.0 * float(np.median(np.maximum([0, 0, 0, 0, 3.0], [0, 0, 0, 3.0, 3.0]) / 12.0)) * math.sqrt(6.0)
        assert lost.uncertainty == pytest.approx(math.hypot(smooth, jumps) + 9.0 * 0.8 * math.exp(-4.0))

    def test_small_losses_are_no_jumps(self):
        """A tenth of the work of the step and a twentieth of the lowest force over it are allowed."""
        # Work of the step from 0 to 1: 1.5; lowest force 6.
        allowed = 0.1 * 1.5 + 0.05 * 6.0
        assert self.make(1.01 * allowed).jumps == ((0.0, 1.0),)
        assert self.make(0.99 * allowed).jumps == ()
        # What one branch loses by the rule the other one gives back.
        assert self.make(2.0, -1.2).jumps == ()
        assert self.make(2.0, -0.8).jumps == ((0.0, 1.0),)

    def test_the_error_of_the_rule_is_the_second_difference_over_twelve(self):
        """Of a parabola over equal steps: exactly the error of the trapezoidal rule in each."""
        approach = 0.5 * np.arange(9.0)
        path = Path(approach, 1.5 * approach**2)
        rule = 0.25 * (path.force[1:] + path.force[:-1])
        exact = 0.5 * np.diff(approach**3)
        np.testing.assert_allclose(cycle._second_differences(path), rule - exact)
        assert cycle._find_rule_error(path) == pytest.approx(3.0 * (rule - exact)[0])
        assert np.isinf(cycle._second_differences(Path([0.0, 1.0], [0.0, 1.0]))).all()


class TestPullOff:
    @pytest.fixture(autouse=True)
    def certain(self, monkeypatch):
        monkeypatch.setattr(pull_off, "_find_grid_error", lambda state: 0.01)
        monkeypatch.setattr(pull_off, "find_cut_tension", lambda state: (0.0, 0.02))
        monkeypatch.setattr(pull_off, "warn_of_border", lambda state: None)

    def test_the_lowest_force_is_that_of_the_parabola(self):
        approach = np.array([0.0, -1.0, -1.5, -2.5, -3.0])
        force = 2.0 * (approach + 1.7) ** 2 - 5.0
        found = pull_off.find_minimum(Path(approach, force), ("known",))
        assert found.value == pytest.approx(-5.0)
        below = force[2] + 5.0
        assert found.uncertainty == pytest.approx(math.hypot(0.5 * below, 0.01 * abs(force[2]), 0.02))
        assert (found.unit, found.warnings) == ("N", ("known",))

    def test_at_the_end_of_a_path_it_may_go_on(self):
        found = pull_off.find_minimum(Path([0.0, -1.0, -2.0], [0.0, -3.0, -4.0]), ())
        assert (found.value, found.uncertainty) == (-4.0, 4.0)
        assert found.warnings == ("the lowest force is at the end of the path: continue it",)

    def test_before_a_jump_it_is_the_last_state(self):
        approach = [0.0, -1.0, -2.0, -3.0]
        found = pull_off.find_minimum(Path(approach, [0.0, -3.0, -4.0, 0.0]), ())
        assert found.value == -4.0
        assert found.uncertainty == pytest.approx(math.hypot(1.0 + 0.5 * pull_off_below(-3.0, -4.0, 0.0), 0.04, 0.02))

    def test_steps_that_may_hold_a_lower_force_are_those_beside_it_and_those_that_promise_one(self):
        approach = np.array([0.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0])
        # Falls of 1 for each step up to the lowest one; later one of 2, that would reach -6, and jumps.
        path = list(Path(approach, [0.0, -2.0, -5.0, -3.0, -4.0, -2.0, -2.5]))
        assert pull_off._may_be_lowest(path).tolist() == [False, True, True, False, False, False, False][:6]
        steep = list(Path(approach, [0.0, -2.0, -5.0, -3.0, -4.5, -2.0, -2.5]))
        # From -4.5 at the rate of 1.5 to -6.
        assert pull_off._may_be_lowest(steep).tolist() == [False, True, True, False, True, False]

    def test_the_change_with_the_range_goes_on_to_none(self):
        """Ranges in the ratio of the root of two, by the power 1.2; where lines are straight the change is unsure."""
        bowl = GRID.x**2 + GRID.y**2
        start = sticky(np.full(GRID.shape, 0.5), initial_gap=bowl, boundary="periodic")
        shorter, longer = rc.Estimate(-10.0, 0.1, "N"), rc.Estimate(-9.0, 0.2, "N")
        change = -1.0 / (2.0**0.6 - 1.0)
        too_strong, unlike = pull_off._find_unlike_summits(start)
        found = pull_off._extrapolate_range(shorter, longer, start)
        assert found.value == pytest.approx((1.0 - too_strong) * (-10.0 + change))
        error = math.hypot(0.1, 0.2, 0.25 * change, unlike * (-10.0 + change))
        assert found.uncertainty == pytest.approx(error)
        line = attrs.evolve(start, initial_gap=np.broadcast_to(GRID.x**2, GRID.shape).copy())
        found = pull_off._extrapolate_range(shorter, longer, line)
        assert found.value == -10.0
        unlike = pull_off._find_unlike_summits(line)[1]
        assert found.uncertainty == pytest.approx(math.hypot(0.1, change, unlike * 10.0))
        far = pull_off._extrapolate_range(shorter, rc.Estimate(-8.0, 0.2, "N"), start)
        assert far.value == pytest.approx(-10.0 * (1.0 - too_strong))

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_summits_of_a_paraboloid_are_alike(self, boundary):
        grid = rc.Grid((14, 16), (14.0, 32.0))
        bowl = 0.3 * grid.x**2 + 0.2 * grid.y**2
        tension = np.where(np.hypot(grid.x, grid.y) < 4.0, 1.0, 0.0)
        found = pull_off._find_unlike_summits(sticky(tension, initial_gap=bowl, grid=grid, boundary=boundary))
        if boundary == "free":
            assert found == pytest.approx((0.0, 0.0), abs=1e-9)
        else:
            # Beyond the border it bends back.
            assert 0.0 < found[0] < found[1] < 0.5
        rng = np.random.default_rng(2)
        wild = bowl + rng.normal(size=grid.shape) * 30.0
        few = np.zeros(grid.shape)
        few[6:8, 7] = 1.0
        strong, unsure = pull_off._find_unlike_summits(sticky(few, initial_gap=wild, grid=grid, boundary=boundary))
        # As unlike as can be, and a contact of two cells: a third.
        assert strong == pytest.approx(0.7 * 0.33)
        assert unsure == pytest.approx(math.hypot(0.25, 0.33))

    def test_where_only_border_cells_are_attracted_summits_are_not_known(self):
        tension = np.zeros(GRID.shape)
        tension[0, 3] = 1.0
        found = pull_off._find_unlike_summits(sticky(tension, initial_gap=GRID.x**2 + GRID.y**2))
        assert found == (0.0, 0.25)


def pull_off_below(before, lowest, after):
    """Return how far the parabola through three equal steps lies below the middle one."""
    slope, bend = 0.5 * (after - before), before - 2.0 * lowest + after
    return slope**2 / (2.0 * bend)
