"""Closed forms, and the order at which the discrete solutions come near them."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import reference
from scenes import each_once

MODULUS = 1e11
BODY = rc.Elastic(MODULUS, 0.0)
RADIUS = 1e-2


def observed_order(sizes, errors):
    return -np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0]


def hertz_on(n, *, solver="auto", half_box=1e-3, fraction=0.3, radii=(RADIUS, RADIUS)):
    """Sphere or ellipsoid whose contact radius is `fraction` of the half box; return solution and closed form."""
    a = fraction * half_box
    exact = reference.hertz_sphere(4 * MODULUS * a**3 / (3 * RADIUS), RADIUS, MODULUS)
    if radii[0] != radii[1]:
        exact = reference.hertz_elliptic(4 * MODULUS * a**3 / (3 * RADIUS), radii, MODULUS)
    force = 4 * MODULUS * a**3 / (3 * RADIUS)
    grid = rc.Grid((n, n), 2 * half_box)
    problem = rc.ContactProblem(rc.Body(rc.ParaboloidSurface(radii), BODY), grid=grid, solver=solver)
    return problem.solve(force=force), exact


@pytest.mark.parametrize("solver", ["auto", "polonsky-keer"])
def test_hertz_at_128(solver):
    solution, exact = hertz_on(128, solver=solver)
    assert solution.pressure.max() == pytest.approx(exact.p_max, rel=1e-3)
    # The approach counts from the highest grid point, half a cell diagonal off the summit.
    offset = (solution.grid.spacing[0] ** 2 / 4) / RADIUS
    assert solution.approach + offset == pytest.approx(exact.approach, rel=2e-3)


def test_hertz_converges_with_second_order():
    """The error depends on the position of the edge between the grid points: mean over nearby sizes."""
    sizes = np.array([32, 64, 128, 256])
    p_max, approach = [], []
    for n in sizes:
        errors = []
        for fraction in (0.27, 0.285, 0.3, 0.315):
            solution, exact = hertz_on(int(n), fraction=fraction)
            offset = (solution.grid.spacing[0] ** 2 / 4) / RADIUS
            # Against the closed form at the nearest grid point to the summit.
            nearest = exact.pressure(*(np.array(solution.grid.spacing) / 2))
            errors.append([solution.pressure.max() / nearest - 1, (solution.approach + offset) / exact.approach - 1])
        rms = np.sqrt(np.mean(np.square(errors), axis=0))
        p_max.append(rms[0])
        approach.append(rms[1])
    assert observed_order(sizes, p_max) == pytest.approx(2.0, abs=0.4)
    assert observed_order(sizes, approach) == pytest.approx(2.0, abs=0.4)


def test_hertz_pressure_field():
    solution, exact = hertz_on(128)
    field = exact.pressure(solution.grid.x, solution.grid.y)
    assert np.abs(solution.pressure - field).sum() / field.sum() < 5e-3


@pytest.mark.parametrize("radii", [(RADIUS, 3 * RADIUS), (4 * RADIUS, RADIUS)])
def test_elliptic_hertz(radii):
    solution, exact = hertz_on(128, fraction=0.2, radii=radii)
    assert solution.pressure.max() == pytest.approx(exact.p_max, rel=3e-3)
    field = exact.pressure(solution.grid.x, solution.grid.y)
    assert np.abs(solution.pressure - field).sum() / field.sum() < 1e-2


def full_contact(kernel, n):
    wave = reference.WavyContact(1e-6, 1e-4, MODULUS)
    mean = 1.2 * wave.full_contact_pressure
    grid = rc.Grid((n, n), 1e-4)
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface(1e-6, 1e-4), BODY),
        grid=grid,
        boundary="periodic",
        kernel=kernel,
        solver=rc.SpectralGradient(tolerance=1e-13),
    )
    solution = problem.solve(pressure=mean)
    return solution, wave.full_contact(grid.x, grid.y, mean)


def test_full_contact_of_a_wave_is_exact_with_the_fourier_kernel():
    solution, exact = full_contact("fourier", 32)
    assert solution.contact.all()
    np.testing.assert_allclose(solution.pressure, exact, rtol=1e-10)


def test_full_contact_of_a_wave_converges_with_loves_kernel():
    sizes = np.array([16, 32, 64, 128])
    errors = []
    for n in sizes:
        solution, exact = full_contact("love", int(n))
        errors.append(np.abs(solution.pressure / exact - 1).max())
    assert observed_order(sizes, errors) == pytest.approx(2.0, abs=0.3)


@each_once(
    {
        "kernel": ["love", "fourier"],
        "fraction": [0.1, 0.5, 0.9],
    }
)
def test_westergaard(kernel, fraction):
    """The strip's edges lie anywhere in a cell: mean over positions of the wave on the grid."""
    wave = reference.Westergaard(1e-6, 1e-4, MODULUS)
    mean = fraction * wave.full_contact_pressure
    sizes, errors = np.array([64, 128, 256, 512]), []
    for n in sizes:
        grid = rc.Grid((int(n), 1), 1e-4)
        missed = []
        for shift in (0.0, 0.2, 0.4, 0.6, 0.8):
            surface = rc.WavySurface((1e-6, 0.0), 1e-4, phase=2 * np.pi * shift / n)
            problem = rc.ContactProblem(rc.Body(surface, BODY), grid=grid, boundary="periodic", kernel=kernel)
            solution = problem.solve(pressure=mean)
            exact = wave.pressure(grid.x + shift * grid.spacing[0], mean)
            missed.append(np.abs(solution.pressure - exact).sum() / exact.sum())
            width = solution.area("cell-count").fraction * n
            assert abs(width - 2 * wave.half_width(mean) / grid.spacing[0]) <= 2.0
        errors.append(np.mean(missed))
    assert errors[-1] < 2e-3
    assert observed_order(sizes, errors) == pytest.approx(1.5, abs=0.4)


@pytest.mark.parametrize("fraction", [0.9, 0.97, 0.99])
def test_nearly_full_contact_of_the_wave(fraction):
    """Johnson's limit holds as the last gaps close; the error decreases with their area."""
    wave = reference.WavyContact(1e-6, 1e-4, MODULUS)
    problem = rc.ContactProblem(
        rc.Body(rc.WavySurface(1e-6, 1e-4), BODY), grid=rc.Grid((256, 256), 1e-4), boundary="periodic", kernel="fourier"
    )
    mean = fraction * wave.full_contact_pressure
    gaps = 1 - problem.solve(pressure=mean).area("perimeter").fraction
    assert gaps == pytest.approx(1 - wave.heavy_area_fraction(mean), rel=0.12)


def test_flat_punch_indents_as_it_should():
    """The punch is a step in the heights; its edge is only known to half a cell."""
    n, radius = 192, 1e-4
    grid = rc.Grid((n, n), 4e-4)
    r = np.hypot(grid.x, grid.y)
    heights = np.where(r <= radius, 0.0, -1e-5)
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=grid.size), BODY))
    solution = problem.solve(force=10.0)
    covered = np.sqrt(np.count_nonzero(heights == 0.0) * grid.cell_area / np.pi)
    exact = reference.FlatPunch(10.0, covered, MODULUS)
    assert solution.approach == pytest.approx(exact.approach, rel=5e-3)
    inner = r < 0.7 * radius
    np.testing.assert_allclose(solution.pressure[inner], exact.pressure(r[inner]), rtol=2e-2)
