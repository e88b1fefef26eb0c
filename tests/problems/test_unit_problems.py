"""Small functions of accuracies, plans, certificates and archives beside closed forms."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._base.archive import _has_ended, _machine, _remove_stale_once
from roughcontact._solve.problem.accuracy import Target, _coarsest, _is_confirmed, _mean_square_curvature, _refine
from roughcontact._solve.problem.certificate import _are_close
from roughcontact._solve.problem.memory import _round_down, memory_of_solve
from roughcontact._solve.problem.sweep import order_of_solving
from roughcontact._solve.problem.task import maximum_pressure, pressure_unit
from roughcontact.results import Trial
from roughcontact.solving import ContactConditions, make_task
from roughcontact.typing import Load, replacing
from scenes import make_problem

WAVE = rc.WavySurface(1e-6, 100e-6)


def problem(shape=(96, 64), size=(300e-6, 200e-6), boundary="periodic", surface=WAVE, material=None):
    material = rc.Elastic(2e9, 0.25) if material is None else material
    return make_problem(surface, material, grid=rc.Grid(shape, size), boundary=boundary, threads=1)


def trial(shape=(96, 64), area=(1.0, 0.01), peak=(math.nan, math.nan)):
    return Trial(shape, *area, *peak, 10, 0.1)


def test_the_tolerance_is_a_twentieth_of_the_standard_deviation():
    """A tenth of half of what is asked, which moves area and pressure by twice itself; within its bounds."""
    assert Target(0.01, None).tolerance(1e-9) == pytest.approx(2.5e-4)
    assert Target(0.02, 0.004).tolerance(1e-9) == pytest.approx(1e-4)
    assert Target(None, 0.5).tolerance(1e-9) == 1e-3
    assert Target(1e-6, None).tolerance(1e-6) == 1e-6


def test_the_excess_of_a_trial_is_its_larger_one():
    found = trial(area=(2.0, 0.02), peak=(5.0, 0.3))
    assert found.spreads == pytest.approx((0.02, 0.12))
    assert Target(0.01, None).excess(found) == pytest.approx(2.0)
    assert Target(None, 0.04).excess(found) == pytest.approx(3.0)
    assert Target(0.01, 0.04).excess(found) == pytest.approx(3.0)
    assert Target(0.01, 0.1).excess(found) == pytest.approx(2.0)


@pytest.mark.parametrize("size", [(9.0, 12.0), (18.0, 12.0)])
def test_the_mean_square_curvature_of_a_paraboloid_is_that_of_both_axes(size):
    grid = rc.Grid((18, 24), size)
    gap = 0.5 * 3.0 * grid.x**2 + 0.5 * 4.0 * grid.y**2
    assert _mean_square_curvature(gap, grid) == pytest.approx(25.0)
    # Only where the gap is below its mean: a wall beyond does not count.
    wall = np.where(np.abs(grid.x) > 0.45 * size[0], 1e6, gap)
    assert _mean_square_curvature(wall, grid) > 1e6
    far = gap.copy()
    far[0] = 1e3 * gap.max()
    inner = _mean_square_curvature(far, grid)
    assert inner > 25.0


def test_the_coarsest_grid_shows_the_curvature_of_its_waves():
    """Second differences of a wave of n cells show (sin(pi/n) / (pi/n))^4 of its mean square curvature."""
    for waves, expected in ((4, (256, 64)), (64, (512, 128))):
        surface = rc.WavySurface(1e-6, 400e-6 / waves)
        given = problem((1024, 256), (400e-6, 100e-6), surface=surface)
        found = _coarsest(given).plan.grid.shape
        cells = found[0] / waves
        assert (math.sin(math.pi / cells) / (math.pi / cells)) ** 4 > 0.75 * 0.99
        assert found == expected
        assert _coarsest(given).plan.grid.size == given.plan.grid.size
    assert _coarsest(problem((100, 128), (1e-4, 1e-4))).plan.grid.shape == (100, 128)


def test_the_next_grid_follows_from_the_order_at_which_the_uncertainty_falls():
    """Third order until two grids have shown another, of at least one and at most four, with 5 % more cells."""
    given, target = problem(), Target(0.01, None)

    def cells(*trials):
        grid = _refine(given, list(trials), target).plan.grid
        assert grid.size == given.plan.grid.size
        assert all(n % 8 == 0 for n in grid.shape)
        return grid.shape

    def asked(shape, factor):
        return tuple(8 * math.ceil(factor * n / 8) for n in shape)

    eight = trial(area=(1.0, 0.04))
    found = cells(eight)
    assert all(n <= m <= 1.1 * n for m, n in zip(found, asked((96, 64), 2.1), strict=True))
    # From twice the cells along each axis an eighth, a quarter, or no less.
    for before, order in ((0.32, 3.0), (0.16, 2.0), (0.041, 1.0), (4.0, 4.0)):
        one = trial((48, 32), (1.0, before))
        factor = min(1.05 * 8.0 ** (1.0 / order), 4.0)
        found = cells(one, trial((96, 64), (1.0, 0.04)))
        assert all(n <= m <= 1.1 * n for m, n in zip(found, asked((96, 64), factor), strict=True))
    # What is met on one grid and not confirmed by the one before is asked of half as many more.
    found = cells(trial(area=(1.0, 0.001)))
    assert all(n <= m <= 1.1 * n for m, n in zip(found, asked((96, 64), 1.5), strict=True))
    found = cells(trial(area=(1.0, 0.0051)))
    assert all(n <= m <= 1.1 * n for m, n in zip(found, asked((96, 64), 1.15), strict=True))


def test_two_grids_agree_within_two_standard_deviations_of_both():
    given = problem()
    one = trial(area=(1.0, 0.03), peak=(10.0, 0.3))
    cases = [((1.09, 0.04), (10.0, 0.4), True), ((1.11, 0.04), (10.0, 0.4), False), ((0.89, 0.04), (10.0, 0.4), False)]
    cases += [((1.0, 0.04), (10.9, 0.4), True), ((1.0, 0.04), (11.1, 0.4), False), ((1.0, 0.04), (8.9, 0.4), False)]
    for area, peak, agree in cases:
        assert _is_confirmed(given, given, [one, trial(area=area, peak=peak)]) == agree
    assert _is_confirmed(given, given, [trial(), trial(area=(1.01, 0.01))])
    # A single grid is confirmed where a finer one shows no sharper heights.
    assert _is_confirmed(given, given, [trial()])
    coarse = problem((7, 7), (300e-6, 300e-6))
    assert not _is_confirmed(coarse, coarse, [trial()])
    assert _is_confirmed(coarse, given, [trial()])


def test_more_contact_takes_no_less_memory_between_the_measured_fractions():
    """Arrays of the grid in float64, by the plan's table: at its fractions, and between them along straight lines."""
    grid = rc.Grid((64, 48), 1.0)
    one = 8 * grid.cells
    for boundary in rc.Boundary:
        found = [memory_of_solve(grid, boundary, part) / one for part in np.linspace(0.0, 1.0, 21)]
        assert all(np.diff(found) >= 0.0)
        assert 8.0 <= found[0] < found[-1] < 20.0
    assert memory_of_solve(grid, rc.Boundary.FREE, 0.05) > memory_of_solve(grid, rc.Boundary.PERIODIC, 0.05)
    plan = problem((64, 48)).plan
    assert plan.memory == memory_of_solve(plan.grid, plan.boundary, 1.0)
    other = rc.ContactProblem(
        rc.Body(WAVE, rc.Elastic(1e9, 0.3)), grid=plan.grid, boundary="periodic", solver="polonsky-keer"
    ).plan
    assert other.memory_at(0.0) == int(14.5 * 8 * plan.grid.cells)
    assert other.memory == other.memory_at(0.0) > plan.memory


def test_the_share_of_contact_that_fits_into_memory_is_told():
    given = problem((64, 48))
    for percent in (0, 17, 39):
        limit = given.plan.memory_at(percent / 100)
        text = str(attrs.evolve(given.plan, memory_limit=limit))
        assert f"suffice for up to {percent} % of the cells" in text
    assert "suffice" not in str(attrs.evolve(given.plan, memory_limit=given.plan.memory))


def test_proposed_sides_can_be_halved():
    assert [_round_down(side) for side in (1.0, 31.9, 32.0, 95.9, 1000.0, 0.3)] == [1, 31, 32, 64, 992, 1]


@pytest.mark.parametrize("kind", ["force", "pressure", "approach"])
def test_a_task_has_the_load_in_units_of_the_modulus_and_the_height_over_the_cell(kind):
    given = problem((48, 64), (300e-6, 200e-6), material=rc.ElasticPerfectlyPlastic(2e9, 0.25, 3e6))
    plan = given.plan
    unit = (2e9 / (1.0 - 0.25**2)) * given.initial_gap.max() / (300e-6 / 48)
    assert pressure_unit(plan) == pytest.approx(unit)
    value = {"force": 1e5 * 6e-8, "pressure": 1e5, "approach": 0.3e-6}[kind]
    task = make_task(plan, given.initial_gap, Load(kind, value), start=np.full((48, 64), 1e7))
    assert float(task.pressure_limit) == pytest.approx(3e6 / unit)
    np.testing.assert_allclose(task.initial_gap, given.initial_gap / given.initial_gap.max())
    np.testing.assert_allclose(task.start, 3e6 / unit)
    if kind == "approach":
        assert (task.mean_pressure, task.approach) == (None, pytest.approx(0.3e-6 / given.initial_gap.max()))
    else:
        assert (task.mean_pressure, task.approach) == (pytest.approx(1e5 / unit), None)
    assert maximum_pressure(plan) == pytest.approx(3e6)
    unmeasured = np.zeros((48, 64), dtype=bool)
    unmeasured[:12] = True
    assert maximum_pressure(attrs.evolve(plan, non_measured=unmeasured)) == pytest.approx(0.75 * 3e6)


def test_violations_of_a_pressure_on_several_tiles():
    """One open cell under pressure and one that overlaps, in different tiles; saturated cells may overlap."""
    shape = (3, 2**16)
    rng = np.random.default_rng(1)
    gap, pressure = rng.uniform(0.5, 1.0, shape), np.zeros(shape)
    displacement = np.zeros(shape)
    pressure[:, ::97] = 1.0
    gap[:, ::97] = 0.0
    displacement[0, 5], displacement[2, 7] = 4.0, -1.5
    gap[2, 7] = 1.2
    found = ContactConditions(gap).measure(pressure, displacement)
    scale = gap.std()
    assert found.approach == pytest.approx(0.0, abs=1e-12)
    assert found.scale == pytest.approx(scale)
    assert found.penetration == pytest.approx(0.3 / scale)
    assert found.complementarity == pytest.approx(0.0, abs=1e-9)
    opened = gap.copy()
    opened[1, 97] = 0.4
    count = np.count_nonzero(pressure)
    found = ContactConditions(opened, approach=0.0).measure(pressure, displacement)
    assert found.complementarity == pytest.approx(0.4 / count / opened.std())
    saturated = pressure.copy()
    saturated[2, 7] = saturated[1, 97] = 2.0
    limit = np.full(shape, 2.0)
    for bound in (2.0, np.array(2.0), limit):
        found = ContactConditions(opened, bound, approach=0.0).measure(saturated, displacement)
        assert found.penetration == 0.0
        assert found.complementarity == pytest.approx(2.0 * 0.4 / (count + 3) / opened.std())


def test_figures_are_compared_by_shape_and_distance():
    assert problem().plan.sampled_moduli is None
    assert _are_close(np.array([1.0, np.inf]), np.array([1.0, np.inf]), 0.0)
    assert _are_close(np.array(1.0), np.array(1.0 + 1e-9), 1e-8)
    assert not _are_close(np.array(1.0), np.array(1.0 + 1e-7), 1e-8)
    assert not _are_close(np.array([1.0]), np.array(1.0), 1.0)
    assert not _are_close(np.array(np.inf), np.array(1.0), 1.0)


def test_a_new_file_removes_what_a_killed_process_has_left_beside_it(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    stale = tmp_path / f".map.npz.{_machine()}-{ended.pid}.0123456789ab.partial"
    own = tmp_path / f".map.npz.{_machine()}-{os.getpid()}.0123456789ab.partial"
    for path in (stale, own):
        path.write_text("")
    _remove_stale_once.cache_clear()
    with replacing(tmp_path / "new") as partial:
        assert not stale.exists()
        partial.write_text("content")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([own.name, "new"])
    assert (tmp_path / "new").read_text() == "content"


@pytest.mark.skipif(os.name != "posix", reason="processes are looked at on POSIX alone")
def test_which_processes_have_ended():
    assert not _has_ended(os.getpid())
    assert not _has_ended(1)
    killed = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        assert not _has_ended(killed.pid)
        killed.kill()
        # Nobody has waited for it yet.
        for _ in range(200):
            if _has_ended(killed.pid):
                break
            time.sleep(0.01)
        assert _has_ended(killed.pid) or not sys.platform.startswith("linux")
    finally:
        killed.kill()
        killed.wait()
    assert _has_ended(killed.pid)
    assert not _has_ended(2**80)


def test_the_approach_of_full_contact_is_refused_and_one_below_it_is_solved():
    """On a periodic boundary any pressure above that of closing has the same approach."""
    body = rc.Body(rc.WavySurface(1e-3, 8.0), rc.Elastic(1.0, 0.0))
    given = rc.ContactProblem(body, grid=rc.Grid((16, 16), 16.0), boundary="periodic", threads=1)
    full = float(given.initial_gap.mean())
    with pytest.raises(rc.InputError, match="below that of full contact"):
        given.solve(approach=full)
    below = given.solve(approach=0.95 * full)
    assert below.status is rc.Status.CONVERGED
    assert 0.5 < below.contact.mean() <= 1.0
    assert below.approach == pytest.approx(0.95 * full)


def test_a_sweep_is_solved_from_the_largest_load_down_and_told_in_the_order_that_was_asked():
    loads = tuple(Load("pressure", value) for value in (2.0, 5.0, 1.0, 3.0))
    assert order_of_solving(loads) == [1, 3, 0, 2]
    body = rc.Body(rc.WavySurface(1.0, 8.0), rc.Elastic(1.0, 0.0))
    given = rc.ContactProblem(body, grid=rc.Grid((16, 16), 16.0), boundary="periodic", threads=1)
    asked = [0.02, 0.05, 0.01]
    np.testing.assert_allclose(given.sweep(pressure=asked).mean_pressure, asked)
