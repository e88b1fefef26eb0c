"""The solve of a case by one process."""

from unittest import mock

import roughcontact as rc

# One process would solve small grids on whole fields; slabs, which are for large ones, list the cells in contact.
METHOD = "roughcontact._solve.solvers.conjugate.field_descent.FieldDescent.serves"


def solve_alone(case, heights):
    """Return the solution of `rc.ContactProblem`."""
    material = rc.Elastic(1e9, 0.0)
    if case["hardness"] is not None:
        material = rc.ElasticPerfectlyPlastic(1e9, 0.0, case["hardness"])
    surface = rc.HeightMap(heights, case["size"])
    problem = rc.ContactProblem(rc.Body(surface, material), boundary=case["boundary"])
    with mock.patch(METHOD, return_value=False):
        return problem.solve(**case["load"], tolerance=case["tolerance"])
