"""Tangential stiffness of unlike bodies: pressure and traction together, against dense matrices."""

import numpy as np
import pytest

import roughcontact as rc
from scenes import each_once


def stiffness_of(solution, axis):
    return solution.response(rc.responses.create("tangential-stiffness", axis=axis))


def displace_cells(problem, cells):
    """Return the matrix from tractions x, y, z on cells to their displacements, dimensionless."""
    convolution, chosen = problem.shear_convolution, np.flatnonzero(cells)
    columns = []
    for of in "xyz":
        for cell in chosen:
            load = np.zeros((1, *cells.shape))
            load.flat[cell] = 1.0
            columns.append(convolution.apply(load, of, "xyz").reshape(3, -1)[:, chosen].ravel())
    return np.array(columns).T


def move_rigidly(matrix, axis, letters):
    """Return the displacement along an axis by a unit force on cells that all move as one."""
    count = matrix.shape[0] // letters
    sums = np.repeat(np.eye(letters), count, axis=0)
    system = np.block([[matrix, -sums], [sums.T, np.zeros((letters, letters))]])
    right = np.zeros(len(system))
    right[matrix.shape[0] + axis] = 1.0
    return np.linalg.solve(system, right)[matrix.shape[0] + axis]


@pytest.mark.slow
@each_once(
    {
        "axis": [0, 1],
        "boundary poisson": [("free", 0.0), ("free", 0.2), ("periodic", 0.3), ("free-periodic", 0.2)],
    }
)
def test_it_is_that_of_a_dense_system(boundary, poisson, axis):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=2e-8, shortest=6e-6, longest=3e-5, seed=4)
    body = rc.Body(rough + rc.ParaboloidSurface((2e-3, 5e-3)), rc.Elastic(70e9, poisson))
    problem = rc.ContactProblem(body, grid=rc.Grid((18, 14), (27e-6, 14e-6)), boundary=boundary)
    solution = problem.solve(pressure=400e6)
    assert 50 < np.count_nonzero(solution.contact) < 250
    matrix = displace_cells(problem, solution.contact)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
    count = np.count_nonzero(solution.contact)
    coupled = move_rigidly(matrix, axis, 3)
    uncoupled = move_rigidly(matrix[: 2 * count, : 2 * count], axis, 2)
    assert coupled < uncoupled
    # The correction of the edge in the normal stiffness serves both.
    normal = move_rigidly(matrix[2 * count :, 2 * count :], 0, 1)
    expected = solution.stiffness().value * normal / coupled
    assert stiffness_of(solution, axis).value == pytest.approx(expected, rel=3e-4)


def test_bodies_that_exchange_their_materials_have_the_same_stiffness():
    steel, rubber = rc.Elastic(210e9, 0.3), rc.Elastic(1e9, 0.3)
    ball = rc.ParaboloidSurface(1e-3)
    grid = rc.Grid((24, 24), 60e-6)
    one = rc.ContactProblem(rc.Body(ball, steel), rc.Body(rc.FlatSurface(), rubber), grid=grid).solve(force=1e-2)
    other = rc.ContactProblem(rc.Body(ball, rubber), rc.Body(rc.FlatSurface(), steel), grid=grid).solve(force=1e-2)
    found = stiffness_of(one, 0)
    assert found.value == pytest.approx(stiffness_of(other, 0).value, rel=1e-6)
    assert not any("unlike" in str(warning) for warning in found.warnings)


def test_like_bodies_have_the_stiffness_of_shear_alone():
    # Mindlin, J. Appl. Mech. 16 (1949) 259-268.
    steel = rc.Elastic(210e9, 0.3)
    bodies = rc.Body(rc.ParaboloidSurface(1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    solution = rc.ContactProblem(*bodies, grid=rc.Grid((48, 48), 60e-6)).solve(force=1.0)
    ratio = stiffness_of(solution, 0).value / solution.stiffness().value
    assert ratio == pytest.approx(2 * (1 - 0.3) / (2 - 0.3), rel=2e-3)
    assert stiffness_of(solution, 1).value == pytest.approx(stiffness_of(solution, 0).value, rel=1e-6)
