"""Stiff and extreme contacts: each converges and is verified, or says in a sentence why not."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from scenes import each_once
from strategies import STRICT, strict


def rough_map(n=32, seed=0):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1.0, shortest=6.0, longest=float(n), seed=seed)
    return surface.heights(rc.Grid((n, n), float(n)))


def solve(heights, size, young=1e9, load=0.01, boundary="free", **options):
    """Solve at `load` times E times peak-to-valley height over side."""
    surface = rc.HeightMap(heights, size=np.broadcast_to(size, 2))
    body = rc.Body(surface, rc.Elastic(young, 0.3))
    problem = rc.ContactProblem(body, boundary=boundary, solver=STRICT, **options)
    mean = load * young * float(np.ptp(heights) / max(surface.size))
    return problem.solve(pressure=mean), mean


def verify(solution, mean):
    assert solution.status.success
    assert solution.residuals.error <= 2e-8 or solution.status is rc.Status.CONVERGED_TO_ROUNDING
    assert solution.mean_pressure == pytest.approx(mean, rel=1e-12)
    assert solution.pressure.min() >= 0
    for field in (solution.pressure, solution.gap, solution.displacement):
        assert np.isfinite(field).all()


@pytest.mark.parametrize("young", [1.0, 1e5, 1e15, 1e-30, 1e30])
def test_any_modulus(young):
    verify(*solve(rough_map() * 1e-7, 1e-5, young=young))


@pytest.mark.parametrize("height", [1e-12, 1e-3, 1e3])
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_any_height_and_size(height, size):
    verify(*solve(rough_map() * height, size))


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_a_load_so_light_that_one_cell_touches(boundary):
    solution, mean = solve(rough_map(), 1.0, load=1e-9, boundary=boundary)
    verify(solution, mean)
    assert solution.contact.sum() == 1


@pytest.mark.parametrize("load", [1e2, 1e6])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_load_far_beyond_full_contact(boundary, load):
    solution, mean = solve(rough_map(), 1.0, load=load, boundary=boundary)
    verify(solution, mean)
    assert solution.contact.all()


@pytest.mark.parametrize("solver", ["projected-cg", "spectral-gradient", "polonsky-keer"])
@pytest.mark.parametrize(("load", "status"), [(1e9, rc.Status.CONVERGED_TO_ROUNDING), (1e12, rc.Status.UNRESOLVED)])
def test_a_pressure_that_dwarfs_its_own_variation_is_known_to_rounding(load, status, solver):
    """On a periodic domain the mean pressure displaces nothing, but its rounding does."""
    surface = rc.HeightMap(rough_map(16), size=1.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3)), boundary="periodic", solver=strict(solver))
    solution = problem.solve(pressure=load * 1e9, throw=False)
    assert solution.status is status
    assert solution.iterations < 1000


def test_a_single_needle():
    heights = np.zeros((33, 33))
    heights[16, 16] = 1.0
    solution, mean = solve(heights, 1.0, load=1e-6)
    verify(solution, mean)
    assert solution.contact.sum() == 1
    assert solution.pressure[16, 16] == pytest.approx(mean * 33**2, rel=1e-12)


def test_three_equal_needles_share_the_load():
    heights = np.zeros((32, 32))
    heights[[4, 4, 20], [4, 20, 12]] = 1.0
    solution, mean = solve(heights, 1.0, load=1e-6, boundary="free")
    verify(solution, mean)
    assert solution.contact.sum() == 3


def test_a_step():
    heights = np.zeros((40, 24))
    heights[:20] = 1e-3
    solution, mean = solve(heights, 1.0, load=1e-2)
    verify(solution, mean)
    assert solution.contact[:20].all()
    assert not solution.contact[20:].any()


def test_a_tilted_flat_punch():
    grid = rc.Grid((48, 48), 1.0)
    heights = np.where(np.hypot(grid.x, grid.y) < 0.3, 1e-3 * grid.x, -1.0)
    solution, mean = solve(heights, 1.0, load=1e-6)
    verify(solution, mean)
    pressed = solution.pressure.sum(axis=1)
    assert pressed[24:].sum() > pressed[:24].sum()


def test_two_scales_1e6_apart():
    heights = rough_map() + 1e-6 * np.random.default_rng(1).standard_normal((32, 32))
    verify(*solve(heights, 1.0))


def test_a_large_offset_is_removed():
    plain, _ = solve(rough_map(), 1.0)
    offset, mean = solve(rough_map() + 2.0**20, 1.0)
    verify(offset, mean)
    np.testing.assert_allclose(offset.pressure, plain.pressure, atol=1e-6 * plain.pressure.max())


@each_once(
    {
        "shape": [(2, 1), (1, 2), (2, 2), (1, 50), (2, 512), (101, 7), (13, 17)],
        "boundary": ["free", "periodic", "wrapped"],
    }
)
def test_any_shape(shape, boundary):
    heights = np.random.default_rng(0).standard_normal(shape)
    verify(*solve(heights, shape, boundary=boundary))


@pytest.mark.parametrize("aspect", [0.05, 20.0])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_long_cells(aspect, boundary):
    verify(*solve(rough_map(), (1.0, aspect), boundary=boundary))


@pytest.mark.parametrize("aspect", [1e-3, 1e3])
def test_very_long_cells_converge_or_say_that_they_do_not(aspect):
    surface = rc.HeightMap(rough_map(16), size=(1.0, aspect))
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3)))
    solution = problem.solve(pressure=1e7, tolerance=1e-8, throw=False)
    assert solution.status.success == (solution.residuals.error <= 2e-8)


def test_white_noise_and_checkerboard():
    verify(*solve(np.random.default_rng(0).random((64, 64)), 1.0))
    verify(*solve(np.indices((20, 20)).sum(axis=0) % 2.0, 1.0))


def test_the_hardness_is_the_mean_pressure():
    surface = rc.HeightMap(rough_map(), size=1.0)
    problem = rc.ContactProblem(rc.Body(surface, rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e6)))
    solution = problem.solve(pressure=1e6)
    verify(solution, 1e6)
    assert (solution.pressure == 1e6).all()
    assert solution.saturated.all()


@pytest.mark.parametrize("young", [1e-3, 210.0])
def test_what_float64_cannot_resolve_is_not_called_converged(young):
    """A modulus in GPa given as Pa: the displacement is 1e12 times the peak-to-valley height."""
    surface = rc.HeightMap(1e-9 * np.random.default_rng(0).standard_normal((64, 64)), size=0.1)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(young, 0.3)))
    solution = problem.solve(pressure=1e6, throw=False)
    assert solution.status.success == (solution.residuals.error <= 1e-5)


@pytest.mark.parametrize(
    ("heights", "size", "load"),
    [
        (1.0, 1e200, {"force": 1e6}),
        (1e300, 1.0, {"pressure": 1.0}),
        (1.0, 1.0, {"pressure": 1e-320}),
    ],
)
def test_beyond_the_range_of_float64_is_refused(heights, size, load):
    def make_and_solve():
        surface = rc.HeightMap(heights * rough_map(8 * 2), size=size)
        rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.3))).solve(**load)

    with pytest.raises(rc.InputError, match=r"out of all proportion|range of double|[Cc]heck (the|its) unit"):
        make_and_solve()


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_the_hardness_as_mean_pressure_on_three_cells(boundary):
    """On a periodic grid a uniform pressure displaces nothing: the rounding of that must not be the scale."""
    surface = rc.HeightMap(np.array([[0.126, -0.132, 0.640]]), size=(1.0, 3.0))
    for hardness in (257.5, np.nextafter(257.5, np.inf)):
        problem = rc.ContactProblem(rc.Body(surface, rc.ElasticPerfectlyPlastic(1e3, 0.3, hardness)), boundary=boundary)
        verify(problem.solve(pressure=257.5), 257.5)
