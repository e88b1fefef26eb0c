"""The bits of a result do not depend on the number of threads of numpy's BLAS."""

import os
import subprocess
import sys

import numpy as np
import pytest

from roughcontact._base.arrays import matrix_product, sum_of_products

# Contacts large enough for a BLAS to take a second thread, as for sums over more than 10,000 cells: prints a digest of
# each field and answer.
SCRIPT = """
import hashlib
import warnings

import numpy as np
import roughcontact as rc
from roughcontact._answers.flow.dissection import dissect

warnings.simplefilter("ignore")
surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=3e-4, seed=3)
steel = rc.Elastic(210e9, 0.3)


def tell(name, *values):
    digest = hashlib.sha256()
    for value in values:
        digest.update(np.ascontiguousarray(value).tobytes())
    print(name, digest.hexdigest()[:12])


for boundary, pressure in (("periodic", 8e9), ("free", 2e9), ("free-periodic", 2e9)):
    problem = rc.ContactProblem(rc.Body(surface, steel), grid=rc.Grid((256, 256), 256e-6), boundary=boundary)
    solution = problem.solve(pressure=pressure)
    tell(boundary, solution.pressure, solution.gap, solution.approach)
    tell("area", solution.area().value, solution.area().uncertainty)
    for name in ("approach", "mean-gap", "patches", "peak-pressure", "perimeter"):
        found = solution.response(name)
        tell(name, found.value, found.uncertainty)
    tell("stiffness", solution.stiffness().value, solution.stiffness().uncertainty)
    tell("gradient", solution.gradient("force"))
    tell("stress", solution.stress(depths=[1e-6, 2e-5]).components)
problem = rc.ContactProblem(rc.Body(surface, steel), grid=rc.Grid((192, 160), 192e-6))
solution = problem.solve(approach=3e-7)
tell("given approach", solution.pressure, solution.force)
tell("leakage", solution.leakage(axis=0, viscosity=1e-3, pressure_drop=1e5).value)
random = np.random.default_rng(1)
conductances = random.random((2, 300, 200))
tell("dissection", dissect(np.full((300, 200), 1e-3), conductances).solve(random.random((60000, 2))))
path = problem.path(force=[2.0, 2.0], tangential_force=[(0.0, 0.0), (0.2, 0.0)], friction=rc.Coulomb(0.3))
tell("path", path[-1].shear)
soft = rc.Body(surface, rc.Elastic(3e6, 0.5))
law = rc.Exponential(0.05, 3e-7)
problem = rc.ContactProblem(soft, grid=rc.Grid((256, 256), 256e-6), boundary="periodic", adhesion=law)
tell("adhesion", problem.solve(pressure=1e4).pressure)
"""


def run_with_threads(count):
    threads = {"OPENBLAS_NUM_THREADS": count, "MKL_NUM_THREADS": count, "OMP_NUM_THREADS": count}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=os.environ | threads, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.slow
def test_one_and_two_threads_of_the_blas_give_the_same_bits():
    assert run_with_threads("1") == run_with_threads("2")


@pytest.mark.parametrize("shape", [(1, 1, 1), (70, 130, 300), (5, 4000, 7), (200, 3, 9000)])
@pytest.mark.parametrize("kind", [float, complex])
def test_products_in_parts_are_products(shape, kind):
    random = np.random.default_rng(2)
    m, k, n = shape
    one, other = random.standard_normal((m, k)).astype(kind), random.standard_normal((k, n)).astype(kind)
    np.testing.assert_allclose(matrix_product(one, other), one @ other, atol=1e-11)


def test_sums_of_products_take_arrays_of_any_shape():
    random = np.random.default_rng(2)
    one, other = random.standard_normal((2, 30, 41))
    for pick in (lambda field: field, np.ravel, np.transpose):
        assert sum_of_products(pick(one), pick(other)) == pytest.approx(np.vdot(one, other))
