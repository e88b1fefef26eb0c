import math
import subprocess
import sys

import attrs
import numpy as np
import pytest
import roughcontact as rc

from independent import sphere_by_rings
from roughcontact_layered import Layer, LayeredKernel

STEEL = rc.Elastic(1e9, 0.3)
C = STEEL.compliance


def sphere(kernel, cells, contact, radius=1.0):
    grid = rc.Grid((cells, cells), (3.2 * contact, 3.2 * contact))
    return rc.ContactProblem(rc.Body(rc.ParaboloidSurface(radius=radius), STEEL), grid=grid, kernel=kernel)


def rings(kernel, contact):
    """Split off the half-space of the topmost layer: what is left falls with the wave number."""
    return sphere_by_rings(lambda q: kernel.response(q, C), 1 / kernel.layers[0].compliance, 1.0, contact)


def coating(ratio, thickness):
    return LayeredKernel(Layer(ratio * STEEL.young, 0.3, thickness), substrate=STEEL)


@pytest.mark.parametrize("ratio", [0.25, 0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("contact", [0.003, 0.01, 0.03])
def test_load_and_approach_of_a_sphere_are_those_of_the_axisymmetric_problem(ratio, contact):
    kernel = coating(ratio, 0.01)
    force, approach = rings(kernel, contact)
    hertz = 4 / (3 * C) * contact**3
    assert (force > hertz) == (ratio > 1.0) or ratio == 1.0
    solution = sphere(kernel, 129, contact).solve(force=force)
    assert solution.approach == pytest.approx(approach, rel=5e-5)
    assert solution.area().value == pytest.approx(np.pi * contact**2, rel=2e-3)


@pytest.mark.parametrize("ratio", [0.1, 0.25, 4.0, 10.0])
@pytest.mark.parametrize("thickness", [0.3, 1.0])
def test_the_stiffness_is_the_slope_of_load_over_approach(ratio, thickness):
    contact = 0.01
    kernel = coating(ratio, thickness * contact)
    loads = [rings(kernel, factor * contact) for factor in (0.995, 1.0, 1.005)]
    exact = (loads[2][0] - loads[0][0]) / (loads[2][1] - loads[0][1])
    found = sphere(kernel, 39, contact).solve(force=loads[1][0]).stiffness()
    assert found.value == pytest.approx(exact, rel=3e-3)
    assert abs(found.value - exact) < 2.5 * found.uncertainty


@pytest.mark.parametrize("ratio", [0.1, 0.5, 2.0, 10.0])
@pytest.mark.parametrize("thickness", [0.01, 0.1, 0.3, 1.0, 5.0])
def test_the_default_area_is_right_or_warns(ratio, thickness):
    contact = 0.01
    kernel = coating(ratio, thickness * contact)
    force, _ = rings(kernel, contact) if thickness >= 0.3 else (None, 0)
    if force is None:
        force = 4 / 3 * kernel.effective_modulus(np.array([2.0 / contact]), C).item() * contact**3
        exact = sphere(kernel, 384, contact).solve(force=force).area("level-set-richardson").value
    else:
        exact = np.pi * contact**2
    for cells, allowed in ((32, 0.02), (64, 0.005)):
        area = sphere(kernel, cells, contact).solve(force=force).area()
        error = abs(area.value - exact)
        assert area.warnings or error < allowed * exact
        assert error < max(6 * area.uncertainty, 0.01 * exact)


def test_the_modulus_at_the_edge_is_the_layers_and_is_kept_in_files(tmp_path):
    solution = sphere(coating(10.0, 0.05), 32, 0.01).solve(force=1e3)
    length = 0.5 * solution.grid.spacing[0]
    assert solution.effective_modulus(1.0 / length) == pytest.approx(10.0 / C, rel=1e-3)
    assert solution.modulus == pytest.approx(1.0 / C)
    solution.save(tmp_path / "layered.npz")
    again = rc.ContactSolution.load(tmp_path / "layered.npz")
    assert again.moduli == solution.moduli
    assert again.area().value == solution.area().value
    assert again.origin.problem["kernel"] == coating(10.0, 0.05)
    # Without the plug-in the fields are there, and the problem says what is missing.
    script = (
        "import sys; sys.modules['roughcontact_layered.kernel'] = None\n"
        "import roughcontact as rc\n"
        f"solution = rc.ContactSolution.load({str(tmp_path / 'layered.npz')!r}, verify=False)\n"
        "print(solution.force)\n"
        "try: solution.origin.problem\n"
        "except rc.InputError as error: print(error)"
    )
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    force, missing = output.splitlines()
    assert float(force) == solution.force
    assert "layered" in missing


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("ratio", [0.1, 0.5, 2.0])
def test_the_default_solver_takes_few_more_iterations(boundary, ratio):
    # Smaller grids are solved on whole fields.
    grid = rc.Grid((192, 192), (1e-4, 1e-4))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=6e-6, longest=5e-5, seed=3)

    def solved(kernel):
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, kernel=kernel)
        first = problem.convolution
        solution = problem.solve(pressure=5e6)
        assert problem.convolution is first
        return solution

    love = solved("love").iterations
    for thickness in (3e-7, 3e-6, 3e-5):
        assert solved(coating(ratio, thickness)).iterations <= 1.2 * love + 1


@pytest.mark.parametrize(("boundary", "seed"), [("periodic", 21), ("periodic", 22), ("free", 23)])
@pytest.mark.parametrize(("ratio", "cells", "more"), [(10.0, 0.5, 2.2), (10.0, 1.0, 2.6), (30.0, 1.0, 4.5)])
def test_a_stiff_layer_as_thin_as_a_cell_takes_a_few_times_the_iterations(boundary, seed, ratio, cells, more):
    """Between masks the inverse kernel takes 5 to 20 times as many; the seeds were used for no constant."""
    grid = rc.Grid((128, 128), (128.0, 128.0))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=64.0, seed=seed)
    kernel = coating(ratio, cells)
    homogeneous, layered = (
        rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, kernel=k).solve(
            pressure=0.02 * modulus, tolerance=1e-8
        )
        for k, modulus in (("love", 1.0 / C), (kernel, kernel.effective_modulus(np.array([0.4]), C).item()))
    )
    assert layered.status.name == "CONVERGED"
    assert layered.iterations <= more * homogeneous.iterations


@pytest.mark.parametrize("shape", [(48, 48), (45, 64), (33, 31)])
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_a_given_approach_under_a_stiff_layer_gives_the_load_of_that_approach(boundary, shape):
    grid = rc.Grid(shape, (48.0, 60.0))
    surface = rc.WavySurface(0.05, (24.0, 20.0))
    problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, kernel=coating(10.0, 0.7))
    loaded = problem.solve(pressure=1e-3 / C, tolerance=1e-8)
    given = problem.solve(approach=loaded.approach, tolerance=1e-8)
    assert given.mean_pressure == pytest.approx(1e-3 / C, rel=1e-4)
    for solution in (loaded, given):
        assert solution.residuals.complementarity < 1e-6
        assert solution.residuals.penetration < 1e-6


@pytest.mark.parametrize("boundary", ["periodic", ("free", "periodic")])
def test_layers_of_the_substrate_change_no_area_beside_images(boundary):
    ball = rc.Body(rc.ParaboloidSurface(1e-3, (3e-6, 0.0)), STEEL)
    problem = rc.ContactProblem(ball, grid=rc.Grid((31, 33), 100e-6), boundary=boundary)
    layered = attrs.evolve(problem, kernel=LayeredKernel(Layer(STEEL.young, STEEL.poisson, 5e-6), substrate=STEEL))
    one, other = (each.solve(pressure=1.4e6) for each in (problem, layered))
    for estimator in ("hertz", "blend"):
        assert other.area(estimator).value == pytest.approx(one.area(estimator).value, rel=1e-9)


def press_coated_line(length, boundary, transposed, young):
    turn = -1 if transposed else 1
    grid = rc.Grid((45, 1)[::turn], (3e-4, length)[::turn])
    steel = rc.Elastic(young=210e9, poisson=0.3)
    roller = rc.Body(rc.ParaboloidSurface((10e-3, math.inf)[::turn], (2e-6, 0.0)[::turn]), steel)
    kernel = LayeredKernel(Layer(young, 0.25, 12e-6, conductivity=20.0), substrate=steel)
    problem = rc.ContactProblem(roller, rc.Body(rc.FlatSurface(), steel), grid=grid, boundary=boundary, kernel=kernel)
    return problem.solve(force=5e4 * length)


@pytest.mark.parametrize(
    ("boundary", "young"),
    [
        ("periodic", 60e9),
        ("periodic", 700e9),
        pytest.param(("free", "periodic"), 700e9, marks=pytest.mark.slow),  # coefficients of three grids
    ],
)
def test_answers_of_a_coated_line_do_not_depend_on_its_length(boundary, young):
    def find(length, transposed):
        turned = boundary if isinstance(boundary, str) or not transposed else boundary[::-1]
        solution = press_coated_line(length, turned, transposed, young)
        tangential = rc.responses.create("tangential-stiffness", axis=int(transposed))
        extensive = solution.area(), solution.stiffness(), solution.response(tangential), solution.conductance(50.0)
        stress = (solution.stress().maximum,) if boundary == "periodic" else ()
        intensive = solution.peak_pressure(), solution.response("approach"), solution.response("mean-gap"), *stress
        pairs = [(one.value / length, one.uncertainty / length) for one in extensive]
        return np.array(pairs + [(one.value, one.uncertainty) for one in intensive])

    expected = find(3e-4 / 45, transposed=False)
    for length, transposed in ((1.0, False), (1e-3, True)):
        found = find(length, transposed)
        np.testing.assert_allclose(found[:, 0], expected[:, 0], rtol=1e-3)
        relative, known = (pairs[:, 1] / pairs[:, 0] for pairs in (found, expected))
        np.testing.assert_allclose(relative, known, rtol=0.05, atol=1e-5)
