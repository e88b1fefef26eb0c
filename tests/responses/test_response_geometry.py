"""Responses do not depend on how many cells a domain has, nor on how a contact lies on its grid."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from scenes import rather_slow

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from tangential_reference import TangentialKernel, slide, tangential_ratio

STEEL = rc.Elastic(2 * 0.91, 0.3)
FLAT = rc.Body(rc.FlatSurface(), STEEL)
# Odd, prime and composite numbers of cells along x, with another one along y.
SHAPES = [
    (48, 50), (50, 37), (53, 48), (64, 33), (66, 41), (76, 32), (81, 40), (84, 45), (90, 34), (97, 36),
    (98, 64), (100, 35), (110, 49), (127, 31), (128, 50), (150, 38), (200, 33), (233, 40), (250, 32), (300, 44),
]  # fmt: skip
ORDINARY = [(53, 48), (64, 33), (81, 40), (97, 36), (128, 50), (250, 32)]
RADIUS, A = 1e3, 5.0


def ask(name, **arguments):
    return rc.responses.create(name, **arguments)


@pytest.mark.parametrize("boundary", ["free", "periodic", pytest.param("wrapped", marks=pytest.mark.slow)])
@pytest.mark.parametrize("shape", rather_slow(SHAPES, ORDINARY), ids="{0[0]}x{0[1]}".format)
def test_any_number_of_cells(shape, boundary):
    grid = rc.Grid(shape, (float(shape[0]), float(shape[1])))
    # A ball whose sides end in a plane.
    square = (grid.x - 0.3) ** 2 + (grid.y + 0.2) ** 2
    heights = np.maximum(-square / (2 * RADIUS), -1.2 * A**2 / RADIUS)
    surface = rc.HeightMap(heights, size=grid.size, periodic=boundary != "free")
    solution = rc.ContactProblem(rc.Body(surface, STEEL), FLAT, boundary=boundary, threads=1).solve(
        force=4 / 3 * A**3 / RADIUS
    )
    peak = 2 * A / (math.pi * RADIUS)
    # Near the contact neither the images nor the border change the stress: Hertz.
    assert solution.stress().maximum.value == pytest.approx(0.6202 * peak, rel=0.03)
    assert solution.first_yield(0.6202 * peak).force.value == pytest.approx(solution.force, rel=0.1)
    flows = [solution.leakage(axis=axis, viscosity=1.0, pressure_drop=1.0) for axis in (0, 1)]
    assert all(0.3 < flow.flow_factor < 3.0 for flow in flows)
    assert np.isfinite(solution.gradient("participation")).all()
    if boundary == "wrapped":
        return
    stiffness = solution.stiffness().value
    # Johnson (1985): 2 E* a; images in the shorter direction make it larger.
    assert stiffness == pytest.approx(2 * A, rel=0.01 if boundary == "free" else 0.5)
    assert solution.conductance((1.0, 3.0)).value == pytest.approx(1.5 * stiffness, rel=2e-3)
    tangential = [solution.response(ask("tangential-stiffness", axis=axis)).value for axis in (0, 1)]
    assert 0.997 < sum(1 / one for one in tangential) * stiffness / (1.7 / 0.7) < 1.0 + 1e-5
    slips = [solution.partial_slip(tangential_force=1e-2 * solution.force, friction=1.0, axis=k) for k in (0, 1)]
    for one, slip in zip(tangential, slips, strict=True):
        assert slip.tangential_force / slip.displacement.value == pytest.approx(one, rel=0.05)


def answers(solution, axes=(0, 1)):
    """Return the numbers of all responses with their uncertainties; those along x first."""
    first, second = axes
    found = [
        solution.stiffness(),
        solution.conductance((50.0, 20.0)),
        solution.conductance(50.0, film_resistance=1e-2),
        solution.stress().maximum,
        solution.stress().maximum_shear,
    ]
    for axis in (first, second):
        found.append(solution.response(ask("tangential-stiffness", axis=axis)))
        found.append(solution.leakage(axis=axis, viscosity=1e-3, pressure_drop=1e5))
        slip = solution.partial_slip(tangential_force=0.1 * solution.force, friction=0.2, axis=axis)
        found += [slip.displacement, slip.energy]
    return np.array([[one.value, one.uncertainty] for one in found])


@pytest.mark.parametrize(
    ("boundary", "shape", "sides"),
    [
        ("free", (37, 50), (1.0, 3.0)),
        ("periodic", (64, 45), (1.0, 1.0)),
        pytest.param("free", (64, 45), (1.0, 1.0), marks=pytest.mark.slow),
        pytest.param("periodic", (37, 50), (1.0, 3.0), marks=pytest.mark.slow),
    ],
)
def test_transposed_and_mirrored_contacts_answer_alike(boundary, shape, sides):
    size = shape[0] * sides[0], shape[1] * sides[1]
    surface = rc.SelfAffineSurface(hurst=0.7, rms_slope=0.1, shortest=16.0, longest=40.0, seed=4)
    heights = surface.heights(rc.Grid(shape, size))

    def solve(heights, size):
        body = rc.Body(rc.HeightMap(heights, size=size, periodic=boundary == "periodic"), STEEL)
        return rc.ContactProblem(body, FLAT, boundary=boundary, threads=1).solve(pressure=5e-3)

    wanted = answers(solve(heights, size))
    for found in (answers(solve(heights[:, ::-1], size)), answers(solve(heights.T, size[::-1]), (1, 0))):
        np.testing.assert_allclose(found[:, 0], wanted[:, 0], rtol=2e-3)
        np.testing.assert_allclose(found[:, 1], wanted[:, 1], rtol=5e-2)


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_units_change_the_unit_alone(boundary):
    surface = rc.SelfAffineSurface(hurst=0.7, rms_slope=0.1, shortest=12.0, longest=40.0, seed=4)
    heights = surface.heights(rc.Grid((48, 66), (48.0, 66.0)))

    def solve(length, stress):
        body = rc.Body(
            rc.HeightMap(length * heights, size=(48.0 * length, 66.0 * length), periodic=boundary == "periodic"),
            rc.Elastic(stress * 2 * 0.91, 0.3),
        )
        flat = rc.Body(rc.FlatSurface(), rc.Elastic(stress * 2 * 0.91, 0.3))
        return rc.ContactProblem(body, flat, boundary=boundary, threads=1).solve(pressure=5e-3 * stress)

    def measure(solution, length):
        conductance = solution.conductance(50.0, film_resistance=1e-2 * length)
        slip = solution.partial_slip(tangential_force=0.1 * solution.force, friction=0.2, axis=1)
        flow = solution.leakage(viscosity=1e-3, pressure_drop=1e5)
        tangential = solution.response("tangential-stiffness")
        maximum = solution.stress().maximum
        found = solution.stiffness(), tangential, conductance, slip.displacement, slip.energy, flow, maximum
        return np.array([[one.value, one.uncertainty] for one in found])

    length, stress = 1e-6, 1e11
    units = np.array([length * stress, length * stress, length, length, length**3 * stress, length**3, stress])
    one, other = measure(solve(1.0, 1.0), 1.0), measure(solve(length, stress), length) / units[:, np.newaxis]
    np.testing.assert_allclose(other[:, 0], one[:, 0], rtol=1e-3)
    np.testing.assert_allclose(other[:, 1], one[:, 1], rtol=2e-2)


def press_rough(poisson, boundary, kernel="love"):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=48.0, seed=6)
    steel = rc.Elastic(2 * (1 - poisson**2), poisson)
    grid = rc.Grid((48, 65), (48.0, 65.0))
    bodies = rc.Body(surface, steel), rc.Body(rc.FlatSurface(), steel)
    return rc.ContactProblem(*bodies, grid=grid, boundary=boundary, kernel=kernel, threads=1).solve(pressure=5e-3)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_tangential_stiffness_is_that_of_an_own_solver(boundary, poisson):
    solution = press_rough(poisson, boundary)
    normal = solution.stiffness()
    for axis in (0, 1):
        found = solution.response(ask("tangential-stiffness", axis=axis))
        ratio = tangential_ratio(solution.contact, solution.grid.spacing, poisson, axis, boundary == "periodic")
        # Periodic cells of the package are constant in pressure, and those of the reference are waves.
        assert found.value / normal.value == pytest.approx(ratio, rel=1e-5 if boundary == "free" else 2e-3)
        assert found.uncertainty / found.value >= normal.uncertainty / normal.value


def test_partial_slip_beside_friction_in_every_cell():
    solution = press_rough(0.4, "periodic", "fourier")
    for axis, sliding in ((0, 0.3), (1, 0.7)):
        near = solution.partial_slip(tangential_force=sliding * 0.3 * solution.force, friction=0.3, axis=axis)
        kernel = TangentialKernel(solution.grid.shape, solution.grid.spacing, 0.4, axis, True)
        traction = slide(kernel, 0.3 * solution.pressure, near.displacement.value, near.traction)
        force = float(traction[0].sum()) * solution.grid.cell_area
        found = solution.partial_slip(tangential_force=force, friction=0.3, axis=axis).displacement
        assert abs(found.value / near.displacement.value - 1.0) < 0.03
        assert abs(found.value - near.displacement.value) < 3 * found.uncertainty
