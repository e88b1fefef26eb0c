"""The solve of a case by one process."""

import roughcontact as rc


def solve_alone(case, heights):
    """Return the solution of `rc.ContactProblem`."""
    material = rc.Elastic(1e9, 0.0)
    if case["hardness"] is not None:
        material = rc.ElasticPerfectlyPlastic(1e9, 0.0, case["hardness"])
    surface = rc.HeightMap(heights, case["size"])
    problem = rc.ContactProblem(rc.Body(surface, material), boundary=case["boundary"])
    return problem.solve(**case["load"], tolerance=case["tolerance"])
