"""The linear answer of a contact: the restricted system solved, beside dense matrices and differences of solves."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.linear.tangent import Tangent
from roughcontact._parts.surfaces.statistics import rms_slope
from roughcontact._solve.problem import problem_of
from roughcontact.errors import NotConverged
from scenes import each_once

YOUNG, POISSON = 2e11, 0.3
MODULUS = YOUNG / (1 - POISSON**2)
BOUNDARIES = ("free", "periodic", "wrapped")


def press_noise(boundary, load, shape=(20, 16), hardness=None, seed=3, solver="auto", **more):
    """Return the contact of white noise at a load over E* times the rms slope, on cells that are not square."""
    size = (shape[0] * 1.5e-6, shape[1] * 1e-6)
    noise = np.random.default_rng(seed).standard_normal(shape)
    surface = rc.HeightMap(1e-7 * noise, size)
    scale = MODULUS * rms_slope(surface.values, rc.Grid(shape, size))
    material = rc.Elastic(YOUNG, POISSON)
    if hardness is not None:
        material = rc.ElasticPerfectlyPlastic(YOUNG, POISSON, hardness * scale)
    problem = rc.ContactProblem(rc.Body(surface, material), boundary=boundary, solver=solver, threads=1, **more)
    return problem, problem.solve(pressure=load * scale)


def matrix_of(solution, cells):
    """Return the kernel between cells, m/Pa, column by column."""
    problem = problem_of(solution)
    unit, chosen = solution.grid.spacing[0] / solution.modulus, np.flatnonzero(cells)
    columns = []
    for cell in chosen:
        pressure = np.zeros(cells.size)
        pressure[cell] = 1.0
        columns.append(problem.convolution.apply(pressure.reshape(cells.shape)).ravel()[chosen])
    return unit * np.array(columns).T


@each_once(
    {
        "compliance": [0.0, 3.0],
        "load hardness": [(0.002, None), (0.1, None), (0.1, 0.3), (0.6, None)],
        "boundary": BOUNDARIES,
    }
)
def test_the_solution_is_that_of_the_matrix(boundary, load, hardness, compliance):
    _, solution = press_noise(boundary, load, hardness=hardness)
    compliance *= solution.grid.spacing[0] / solution.modulus
    right = np.random.default_rng(1).standard_normal(solution.grid.shape)
    for saturated in (False, True):
        tangent = Tangent(solution, saturated=saturated, compliance=compliance)
        chosen = np.flatnonzero(tangent.cells)
        matrix = matrix_of(solution, tangent.cells) + compliance * np.eye(chosen.size)
        exact = np.linalg.solve(matrix, right.ravel()[chosen])
        for tolerance in (1e-12, 1e-3):
            found = tangent.solve(right, tolerance)
            assert found.error <= tolerance
            assert not found.values[~tangent.cells].any()
            error = np.abs(found.values.ravel()[chosen] - exact).max() / np.abs(exact).max()
            assert error < 10 * tolerance
            product = right.ravel()[chosen] @ exact
            assert found.product == pytest.approx(product, rel=max(100 * tolerance**2, 1e-6))


def test_in_full_contact_the_mean_is_omitted():
    _, solution = press_noise("periodic", 40.0)
    tangent = Tangent(solution)
    assert tangent.is_rigid
    right = np.random.default_rng(0).standard_normal(solution.grid.shape)
    found = tangent.solve(right)
    assert abs(found.values.mean()) < 1e-12 * np.abs(found.values).max()
    unit = solution.grid.spacing[0] / solution.modulus
    displacement = unit * problem_of(solution).convolution.apply(found.values)
    np.testing.assert_allclose(displacement, right - right.mean(), atol=1e-10)
    assert not tangent.solve(np.ones(solution.grid.shape)).values.any()
    assert not Tangent(solution, compliance=1e-9 * unit).is_rigid


@each_once(
    {
        "boundary": ["free", "periodic"],
        "hardness": [None, 0.3],
    }
)
def test_it_is_the_difference_of_solves(boundary, hardness):
    solver = rc.ProjectedConjugateGradient(tolerance=1e-12)
    problem, solution = press_noise(boundary, 0.1, hardness=hardness, solver=solver, seed=5)
    answer = Tangent(solution).solve(np.ones(solution.grid.shape))
    stiffness = answer.values.sum() * solution.grid.cell_area
    best = np.inf
    for step in (1e-7, 1e-6, 1e-5):
        ends = [problem.solve(approach=solution.approach * (1 + sign * step)) for sign in (-1, 1)]
        if all(((end.pressure > 0) == solution.contact).all() for end in ends):
            assert all((end.saturated == solution.saturated).all() for end in ends)
            difference = (ends[1].force - ends[0].force) / (ends[1].approach - ends[0].approach)
            best = min(best, abs(difference / stiffness - 1))
    assert best < 1e-5


def test_the_matrix_is_symmetric():
    _, solution = press_noise("free", 0.2)
    tangent, rng = Tangent(solution), np.random.default_rng(2)
    one, other = rng.standard_normal((2, *solution.grid.shape))
    products = [(tangent.solve(a).values * b).sum() for a, b in ((one, other), (other, one))]
    assert products[0] == pytest.approx(products[1], rel=1e-10)


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**60])
def test_units_change_nothing_but_the_scale(scale):
    _, solution = press_noise("free", 0.1)
    ones = np.ones(solution.grid.shape)
    one = Tangent(solution).solve(ones)
    other = Tangent(solution).solve(scale * ones)
    np.testing.assert_array_equal(other.values, scale * one.values)


def test_a_layered_kernel_and_other_convolvers_serve():
    _, solution = press_noise("periodic", 0.05, kernel="fourier")
    _, direct = press_noise("free", 0.05, convolver="direct")
    _, fast = press_noise("free", 0.05)
    ones = np.ones(solution.grid.shape)
    assert Tangent(solution).solve(ones).error < 1e-12
    values = [Tangent(one).solve(ones).values.sum() for one in (direct, fast)]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


def test_what_cannot_be_solved_is_said():
    _, solution = press_noise("free", 0.05)
    with pytest.raises(rc.InputError, match="which problem"):
        Tangent(attrs.evolve(solution, origin=None))
    with pytest.raises(NotConverged, match="residual"):
        Tangent(solution).solve(np.full(solution.grid.shape, np.nan))
