"""Random contact problems, each judged in extended precision: nothing wrong may be called a success."""

from __future__ import annotations

import warnings

import attrs
import mpmath as mp
import numpy as np
import pytest
from hypothesis import given

import roughcontact as rc
from extended_precision import EXTENDED, Long, Scene, exact_pressure, love, love_by_mpmath, love_waves, violations
from fuzz_cases import FAILED, Case, build, case_of
from roughcontact.testing import judge
from strategies import wild_problems

# Problems of docs/studies/random_problems.py, of which the slow tests judge every second one, in so many blocks.
PROBLEMS = 10_000
BLOCKS = 10
# Largest grid on which the exact pressure is found as well, cells.
EXACT_CELLS = 64
# Largest error of the pressure, over the peak, over the error that the status allows, times the smallest eigenvalue of
# the compliances of elastic cells over the largest compliance. Measured at most 1.5 on 1500 problems.
PRESSURE = 100.0

SUCCESSES = {"CONVERGED", "CONVERGED_TO_ROUNDING", "RESCUED"}

pytestmark = pytest.mark.skipif(not EXTENDED, reason="np.longdouble has no more digits than a double here")


def fault_of(case):
    """Solve a case; return the status or the refusal, and what is wrong with a success, or None."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rc.ContactWarning)
        try:
            problem, load, start = build(case)
            solution = problem.solve(**load, start=start, throw=False)
        except rc.InputError as error:
            return f"refused: {' '.join(str(error).split()[:5])}", None
        _ = str(solution)
    if not solution.status.success:
        return solution.status.name, None
    scene = Scene.of(problem, load)
    verdict = violations(problem, load, solution, scene)
    fault = None if verdict.holds else str(verdict)
    if fault is None and solution.pressure.size <= EXACT_CELLS:
        fault = compare_with_exact(scene, solution, verdict)
    return solution.status.name, fault


def phases(shape, aspect):
    """Wave numbers of a periodic grid of cells (1, aspect), both from zero up."""
    qx, qy = (2 * np.pi * np.arange(n // 2 + 1) / n for n in shape)
    return qx[:, None], qy[None, :] / aspect


def compare_with_exact(scene, solution, verdict):
    """Return what is wrong with a pressure beside the exact one, or None."""
    exact = exact_pressure(scene, solution.pressure)
    if exact is None:
        return None
    error = solution.pressure.ravel() - exact
    relative = float(np.abs(error).max() / exact.max())
    elastic = (exact > 0) & (exact < scene.limit)
    block = scene.matrix[np.ix_(elastic, elastic)] / scene.matrix.max()
    softest = np.linalg.eigvalsh(block.astype(float)).min(initial=1.0)
    # Twice the load times the error of the gap bounds the energy of the difference, whatever the matrix.
    energy = float(error @ scene.matrix @ error)
    bound = 4.0 * float(exact.sum()) * verdict.allowed * verdict.scale
    if relative * max(softest, 0.0) > PRESSURE * verdict.allowed or energy > bound:
        return f"pressure off by {relative:.1e} of the peak, energy {energy:.1e}, allowed {bound:.1e}: {verdict}"
    return None


def check(numbers):
    """Solve and judge the cases of these numbers, and assert that none is wrong."""
    found = {number: fault_of(case_of(number)) for number in numbers}
    wrong = {number: (case_of(number), *found[number]) for number in numbers if found[number][1]}
    assert not wrong, wrong
    # Most must end in a success, or the judge would have nothing to say.
    successes = sum(status in SUCCESSES for status, _ in found.values())
    assert successes > 0.7 * len(found)


@given(wild_problems())
def test_problems_that_hypothesis_draws_are_right_or_say_so(drawn):
    problem, load = drawn
    try:
        solution = problem.solve(**load)
    except (rc.InputError, rc.NotConverged):
        return
    found = violations(problem, load, solution)
    assert found.holds, found


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_many_random_problems_called_solved_are(block):
    size = PROBLEMS // BLOCKS
    check(range(block * size, (block + 1) * size, 2))


@pytest.mark.parametrize("case", FAILED, ids=range(len(FAILED)))
def test_a_problem_that_was_wrong_once_is_right(case):
    status, fault = fault_of(case)
    assert fault is None, f"{status}: {fault}"


class TestJudge:
    """The judge itself: against mpmath, closed forms, and faults put in."""

    @pytest.mark.parametrize("aspect", [1e-8, 1e-3, 0.3, 1.0, 50.0, 1e5, 1e8])
    def test_its_kernel_is_loves(self, aspect):
        found = love(*np.indices((6, 6)), aspect)
        for i, j in np.ndindex(6, 6):
            high = float(found[i, j])
            with mp.workdps(60):
                value = mp.mpf(high) + mp.mpf(float(found[i, j] - Long(high)))
                assert abs(value * mp.pi / love_by_mpmath(i, j, 1, aspect) - 1) < 1e-17

    @pytest.mark.parametrize("aspect", [1e-8, 0.3, 1.0, 7.0, 1e8])
    def test_its_waves_sum_all_aliases(self, aspect):
        """A pressure that alternates is a sum over odd waves; half as many aliases give the same digits."""
        waves = love_waves((5, 4), aspect)
        kernel = rc.Love().spectrum(*phases((5, 4), aspect), (1.0, aspect), 1.0)
        np.testing.assert_allclose(waves.ravel()[1:].astype(float), kernel.ravel()[1:], rtol=4e-15)

    def test_the_exact_pressure_of_two_cells(self):
        """Two cells of compliances a and b: p1 - p2 = h / (a - b), p1 + p2 = load."""
        heights, young = np.array([[1e-3, 0.0]]), 1e9
        problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=(1.0, 2.0)), rc.Elastic(young, 0.3)))
        solution = problem.solve(pressure=1e7)
        scene = Scene.of(problem, {"pressure": 1e7})
        (a, b), _ = scene.matrix
        half = Long(1e-3) / (a - b) / 2
        exact = np.array([1e7 + half, 1e7 - half]).astype(float)
        for start in (solution.pressure, np.array([[0.0, 1.0]])):
            np.testing.assert_allclose(exact_pressure(scene, start).astype(float), exact, rtol=1e-15)

    def test_the_judge_of_plug_ins_allows_no_more_than_documented(self):
        """The displacement is 1e12 times the heights: no rounding excuses what is wrong by all of them."""
        problem, load, _ = build(Case((8, 8), 0, height=-9.0, young=2.0, load=("pressure", 12.0)))
        solution = problem.solve(**load, throw=False)
        claimed = attrs.evolve(solution, status=rc.Status.CONVERGED_TO_ROUNDING)
        assert not violations(problem, load, claimed).holds
        assert not judge(problem, load, claimed).holds

    @pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
    def test_faults_are_found(self, boundary):
        case = Case((6, 7), 3, boundary=boundary, limited="number", limit=0.0, load=("share", -0.3))
        problem, load, _ = build(case)
        solution = problem.solve(**load)
        assert violations(problem, load, solution).holds
        assert 0 < solution.saturated.sum() < solution.contact.sum()
        skewed = solution.pressure * (1.0 + 1e-6 * np.arange(6)[:, None])
        assert not violations(problem, load, attrs.evolve(solution, pressure=skewed)).holds
        assert not violations(problem, load, attrs.evolve(solution, approach=1.000001 * solution.approach)).holds
        assert not violations(problem, {"pressure": 1.00001 * load["pressure"]}, solution).holds
        over = np.where(solution.saturated, np.nextafter(solution.pressure, np.inf), solution.pressure)
        assert not violations(problem, load, attrs.evolve(solution, pressure=over)).holds
