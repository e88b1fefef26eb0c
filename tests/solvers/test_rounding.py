"""Success only as far as float64 can tell, loads near every limit, and solves that always end."""

from __future__ import annotations

import warnings

import attrs
import numpy as np
import pytest

import roughcontact as rc
from extended_precision import violations
from roughcontact.__main__ import main
from roughcontact.typing import Outcome
from strategies import strict

UNIT = 1e11 * 1e-7 / 1e-6  # contact modulus times peak-to-valley height over cell, Pa
# Solves of one contact, or of the search for an area: more than are ever needed, and far fewer than endless.
ENDLESS = 100


def draw(seed, shape=(6, 5)):
    return np.random.default_rng(seed).standard_normal(shape)


def contact(heights, hardness=None, *, boundary="periodic", solver="projected-cg", non_measured=None):
    heights = 1e-7 * heights / np.ptp(heights)
    size = tuple(1e-6 * n for n in heights.shape)
    surface = rc.HeightMap(heights, size, periodic=True, non_measured=non_measured)
    material = rc.Elastic(1e11, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1e11, 0.0, hardness)
    solver = strict(solver) if isinstance(solver, str) else solver
    return rc.ContactProblem(rc.Body(surface, material), boundary=boundary, solver=solver)


@pytest.mark.parametrize("solver", ["projected-cg", "spectral-gradient"])
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_an_approach_far_below_the_heights_takes_pressure(boundary, solver):
    problem = contact(draw(0), boundary=boundary, solver=solver)
    one, two = (problem.solve(approach=depth) for depth in (1e-15, 2e-15))
    assert one.force > 0.0
    assert two.force == pytest.approx(2.0 * one.force, rel=1e-6)
    with pytest.raises(rc.InputError, match=r"out of all proportion|range of double"):
        problem.solve(approach=1e-60)


@pytest.mark.parametrize(("missing", "status"), [(1e-8, "CONVERGED_TO_ROUNDING"), (1e-11, "UNRESOLVED")])
def test_a_load_close_to_the_limit_is_known_to_rounding(missing, status):
    problem = contact(draw(1), 0.1 * UNIT)
    solution = problem.solve(pressure=0.1 * UNIT * (1.0 - missing), throw=False)
    assert solution.status.name == status
    assert solution.residuals.error > 1e-8
    if status == "UNRESOLVED":
        assert solution.residuals.error > 1e-5


@attrs.frozen
class Claiming(rc.Solver):
    """Returns a uniform pressure with any status."""

    status: rc.Status
    tolerance: float = 1e-8

    def solve(self, convolution, task):
        pressure = np.full(task.initial_gap.shape, task.mean_pressure)
        return Outcome(pressure=pressure, status=self.status, iterations=0, convolutions=0, errors=())


@pytest.mark.parametrize("status", [rc.Status.CONVERGED, rc.Status.RESCUED, rc.Status.CONVERGED_TO_ROUNDING])
def test_the_certificate_lets_no_solver_claim_more_than_rounding(status):
    problem = contact(draw(2), solver=Claiming(status))
    assert problem.solve(pressure=1e13 * UNIT, throw=False).status is rc.Status.UNRESOLVED
    assert rc.Status.RESCUED.within(1e-7, 1e-8) is rc.Status.CONVERGED_TO_ROUNDING
    assert rc.Status.RESCUED.within(1e-9, 1e-8) is rc.Status.RESCUED
    assert rc.Status.CONVERGED.within(1e-4, 1e-3) is rc.Status.UNRESOLVED
    assert rc.Status.STALLED.within(1.0, 1e-8) is rc.Status.STALLED


def near_a_limit(seed):
    """A small problem, and a load or approach close to nothing, to the limit or to full contact."""
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(4, 13, 2))
    heights = [np.round, np.exp, np.positive][rng.integers(3)](rng.standard_normal(shape))
    limits = [None, UNIT * 10 ** rng.uniform(-3, 2), UNIT * 10 ** rng.uniform(-3, 2) * np.exp(0.5 * draw(seed, shape))]
    hardness = limits[rng.integers(3)]
    boundary = ["free", "periodic", "wrapped"][rng.integers(3)]
    solver = ["projected-cg", "spectral-gradient"][rng.integers(2) if boundary != "periodic" else 0]
    problem = contact(heights, hardness, boundary=boundary, solver=solver)
    part = rng.choice([10 ** rng.uniform(-14, 0), 1.0 - 10 ** rng.uniform(-12, -1)])
    if rng.random() < 0.4:
        return problem, {"approach": float(part * problem.initial_gap.mean())}
    return problem, {"pressure": float(part * (UNIT if hardness is None else np.mean(hardness)))}


def judge_block(seeds):
    solved = 0
    for seed in seeds:
        problem, load = near_a_limit(seed)
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            solution = problem.solve(throw=False, **load)
        assert solution.status.success or solution.status is rc.Status.UNRESOLVED, (seed, str(solution.status))
        if solution.status.success:
            found = violations(problem, load, solution)
            bound = 2e-5 if solution.status is rc.Status.CONVERGED_TO_ROUNDING else 2e-8
            assert found.error <= bound, seed
            assert found.load <= 1e-12, seed
            assert found.bounded, seed
            assert solution.pressure.any(), seed
            solved += 1
    assert solved > 0.8 * len(seeds)


@pytest.mark.slow
def test_random_loads_near_their_limits_against_extended_precision():
    judge_block(range(100))


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_more_random_loads_near_their_limits(block):
    judge_block(range(1000 * (block + 1), 1000 * (block + 1) + 600))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("distance", [-1e-2, -1e-5, -1e-8, -1e-12, 1e-12, 1e-6, 1e-2, 10.0])
def test_an_approach_near_full_contact_with_a_limit(seed, distance):
    for hardness in (3.0 * UNIT, 40.0 * UNIT * np.exp(0.3 * draw(seed))):
        problem = contact(draw(seed), hardness)
        load = {"approach": float(problem.initial_gap.mean()) * (1.0 + distance)}
        solution = problem.solve(**load)
        assert violations(problem, load, solution).error <= 2e-8


@pytest.mark.parametrize("fraction", [0.99, 1.0 - 1e-5, 1.0 - 1e-9, 1.0])
def test_limits_by_cell_near_the_maximum_load(fraction):
    hardness = UNIT * np.exp(draw(5))
    for boundary in ("free", "periodic", "wrapped"):
        problem = contact(draw(4), hardness, boundary=boundary, solver="spectral-gradient")
        load = {"pressure": float(hardness.mean() * fraction)}
        assert violations(problem, load, problem.solve(**load)).error <= 2e-8


@pytest.mark.parametrize("solver", ["projected-cg", "spectral-gradient", "polonsky-keer"])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_any_start_comes_to_the_load(solver, boundary):
    problem = contact(draw(3, (12, 12)), boundary=boundary, solver=solver)
    cold = problem.solve(pressure=0.1 * UNIT)
    other = problem.solve(pressure=0.2 * UNIT)
    for start in (np.zeros((12, 12)), np.full((12, 12), 5e-324), np.full((12, 12), 1e300), other.pressure):
        warm = problem.solve(pressure=0.1 * UNIT, start=start)
        assert warm.status.success
        np.testing.assert_allclose(warm.pressure, cold.pressure, atol=1e-6 * cold.pressure.max())


@pytest.fixture
def count_solves(monkeypatch):
    """A list with an entry for each solve, which stops an endless one."""
    seen, solve = [], rc.ProjectedConjugateGradient.solve

    def counted(self, convolution, task):
        seen.append(task)
        assert len(seen) < ENDLESS
        return solve(self, convolution, task)

    monkeypatch.setattr(rc.ProjectedConjugateGradient, "solve", counted)
    return seen


MASK = np.arange(30).reshape(6, 5) % 4 == 0


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
@pytest.mark.parametrize("hardness", [0.1 * UNIT, UNIT * np.exp(draw(7))])
def test_non_measured_points_carry_nothing(boundary, hardness, count_solves):
    problem = contact(draw(6), hardness, boundary=boundary, non_measured=MASK)
    maximum = float(np.mean(np.where(MASK, 0.0, hardness)))
    for fraction in (0.5, 1.0 - 1e-9, 1.0):
        count_solves.clear()
        solution = problem.solve(pressure=fraction * maximum)
        assert not solution.contact[MASK].any()
        assert solution.residuals.load <= 1e-12
    for depth in (1e-8, 1e-6, 1e-4):
        count_solves.clear()
        assert not problem.solve(approach=depth).contact[MASK].any()
    with pytest.raises(rc.InputError, match="non-measured points carry nothing"):
        problem.solve(pressure=1.01 * maximum)
    with pytest.raises(rc.InputError, match="non-measured points carry nothing"):
        problem.sweep(pressure=[0.1 * maximum, 1.01 * maximum])
    count_solves.clear()
    with pytest.raises(rc.InputError, match="No load gives an area"):
        problem.solve_area(0.99, "cell-count")


def test_points_that_never_leave_contact_end_the_solve():
    """A solver that loads non-measured points whatever their depth gets no certificate."""
    problem = contact(draw(6), non_measured=MASK, solver=Claiming(rc.Status.CONVERGED))
    assert problem.solve(pressure=0.1 * UNIT, throw=False).status is rc.Status.UNCONFIRMED


def test_an_overloaded_map_with_non_measured_points_is_refused_everywhere(tmp_path, count_solves, capsys):
    heights = 1e-7 * np.where(MASK, np.nan, draw(6))
    np.savetxt(tmp_path / "map.txt", heights)
    load = "--pressure 9GPa --young 100GPa --hardness 10GPa --size 6um 5um --unit 1m --non-measured keep"
    assert main(["solve", str(tmp_path / "map.txt"), *load.split(), "-o", str(tmp_path / "out")]) == 2
    assert "non-measured points carry nothing" in capsys.readouterr().err
    problem = contact(draw(6), 0.1 * UNIT, non_measured=MASK)
    with pytest.raises(rc.InputError, match=r"Problem .holes.: .*non-measured points carry nothing"):
        rc.Study(problems={"holes": problem}, pressure=[0.09 * UNIT])


@pytest.mark.parametrize(
    ("height", "size", "young"), [(1e-45, 1.0, 1.0), (1.0, 1e45, 1.0), (1.0, 1e-45, 1.0), (1.0, 1.0, 1e45)]
)
def test_magnitudes_beyond_float64_are_refused_at_once(height, size, young):
    surface = rc.HeightMap(height * draw(0), (size, size))
    with pytest.raises(rc.InputError, match=r"out of all proportion|range of double"):
        rc.ContactProblem(rc.Body(surface, rc.Elastic(young, 0.3)))
