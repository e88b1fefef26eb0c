"""Single increments of bodies that relax."""

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._parts.grid import Load
from roughcontact._solve.problem import run_solve
from roughcontact._solve.solution import LoadIncrement


@pytest.mark.parametrize("times", [[1.0], [0.01, 1.0, 50.0], [1e-6, 1e-3, 1.0, 1e3, 1e6]])
def test_a_wave_in_full_contact_is_exact_in_one_increment(times):
    """For any series and length, with the same bits in other units of force."""
    load = Load("pressure", 1e5)
    for after in (0.3, 100.0):
        found = []
        for scale in (1.0, 2.0**30, 2.0**-40):
            moduli = [1e6 * scale, *(3e6 * scale / len(times) for _ in times)]
            rubber = rc.Viscoelastic(moduli, times, 0.0)
            body = rc.Body(rc.WavySurface(1e-6, 1e-3), rubber)
            others = {
                "grid": rc.Grid((16, 16), 1e-3),
                "boundary": "periodic",
                "solver": rc.ProjectedConjugateGradient(tolerance=1e-10),
            }
            problem = rc.ContactProblem(body, laws=rc.Relaxation(rubber), **others)
            scaled = attrs.evolve(load, value=scale * load.value)
            first = run_solve(problem, scaled)
            last = run_solve(problem, scaled, before=first, increment=LoadIncrement(scaled, time=after))
            part = np.ptp(last.pressure) / np.ptp(first.pressure)
            assert part == pytest.approx(rubber.relaxed(after) / rubber.relaxed(0.0), rel=1e-9)
            found.append(last.pressure / scale)
        np.testing.assert_array_equal(found[1], found[0])
        np.testing.assert_array_equal(found[2], found[0])
