"""Normal and tangential stiffness beside closed forms, bounds and differences of solves."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import roughcontact as rc
from roughcontact.responses import Stiffness, TangentialStiffness


def solve_ball(cells, rng, *, radii=(1.0, 1.0), spacing=(1.0, 1.0), poisson=0.0, counter=None, boundary="free"):
    """Return Hertz's contact of a mean semi-axis of so many cells of side 1 m, at a random place; E* = 1 Pa or more."""
    radius = 1000.0
    n = 2 * math.ceil(1.2 * cells * max(radii) ** 0.7 + 6)
    grid = rc.Grid((math.ceil(n / spacing[0]), math.ceil(n / spacing[1])), (n, n))
    centre = tuple(rng.uniform(-0.5, 0.5, 2) * spacing)
    surface = rc.ParaboloidSurface(tuple(radius * part for part in radii), center=centre)
    bodies = [rc.Body(surface, rc.Elastic(1.0, poisson))]
    if counter is not None:
        bodies.append(rc.Body(rc.FlatSurface(), counter))
    problem = rc.ContactProblem(*bodies, grid=grid, boundary=boundary, threads=1)
    force = 4 / 3 * problem.plan.modulus * cells**3 / radius
    return problem.solve(force=force), force


def punch_of(shape, boundary="free", size=None):
    """Return the contact of a flat punch, the true cells of an array, pressed without edges touching elsewhere."""
    heights = np.where(shape, 1.0, 0.0)
    surface = rc.HeightMap(heights, shape.shape if size is None else size, periodic=boundary == "periodic")
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary=boundary, threads=1)
    return problem.solve(force=1e-3)


def errors_of_balls(cells, count, seed, **more):
    rng, errors = np.random.default_rng(seed), []
    for _ in range(count):
        solution, _ = solve_ball(cells, rng, **more)
        found = solution.stiffness()
        assert found.unit == "N/m"
        assert not found.warnings
        errors.append((found.value / (2 * cells) - 1, found.uncertainty / (2 * cells)))
    return np.array(errors).T


@pytest.mark.parametrize(("cells", "std"), [(3, 1.2e-2), (6, 3e-3), (12, 1e-3), (24, 5e-4)])
def test_hertz(cells, std):
    errors, uncertainties = errors_of_balls(cells, 8 if cells < 24 else 3, seed=cells)
    assert np.sqrt(np.mean(errors**2)) < std
    assert abs(errors.mean()) < 0.6 * std
    assert np.mean(np.abs(errors) <= 2 * uncertainties) >= 0.8
    assert uncertainties.max() < 1.5 * std


def test_hertz_on_oblong_cells():
    errors, uncertainties = errors_of_balls(10, 4, seed=1, spacing=(1.0, 2.0))
    assert np.abs(errors).max() < 5e-3
    assert (np.abs(errors) <= 2.5 * uncertainties).all()


def hertz_ellipse(radii, force, modulus):
    """Return the semi-axes of Hertz's ellipse, the greater first; Johnson (1985), section 4.2."""
    ratio = max(radii) / min(radii)

    def miss(e):
        return (ellipe(e * e) / (1 - e * e) - ellipk(e * e)) / (ellipk(e * e) - ellipe(e * e)) - ratio

    eccentricity = brentq(miss, 1e-6, 1 - 1e-9)
    m = eccentricity**2
    long = (3 * force * max(radii) * (ellipk(m) - ellipe(m)) / (math.pi * modulus * m)) ** (1 / 3)
    return long, long * math.sqrt(1 - m)


def mean_along_x(radii):
    """Return the mean of cos^2 of the angle between the waves of an ellipse and x; Mindlin (1949)."""
    if radii[0] == radii[1]:
        return 0.5
    long, short = hertz_ellipse(radii, 1.0, 1.0)
    m = 1 - (short / long) ** 2
    along_short = (ellipk(m) - ellipe(m)) / (m * ellipk(m))
    return along_short if radii[0] < radii[1] else 1 - along_short


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("radii", [(1.0, 4.0), (2.5, 1.0)])
def test_ellipses(radii, poisson):
    rng = np.random.default_rng(7)
    solution, force = solve_ball(9, rng, radii=radii, poisson=poisson, counter=rc.Elastic(1.0, poisson))
    long, short = hertz_ellipse([1000.0 * part for part in radii], force, solution.modulus)
    m = 1 - (short / long) ** 2
    normal = math.pi * solution.modulus * long / ellipk(m)
    found = solution.stiffness()
    assert found.value == pytest.approx(normal, rel=4e-3)
    along_x = mean_along_x([1000.0 * part for part in radii])
    for axis, mean in enumerate((along_x, 1 - along_x)):
        tangential = solution.response(TangentialStiffness(axis))
        expected = normal * (1 - poisson) / (1 - poisson * mean)
        assert tangential.value == pytest.approx(expected, rel=6e-3)


def test_mindlin_for_round_contacts_of_two_materials():
    rng = np.random.default_rng(3)
    # Of the same (1 - 2 nu) / G: uncoupled.
    g1, nu1, nu2 = 1.0, 0.3, 0.4
    g2 = g1 * (1 - 2 * nu2) / (1 - 2 * nu1)
    body = rc.Elastic(2 * g1 * (1 + nu1), nu1)
    surface = rc.ParaboloidSurface(1000.0, center=tuple(rng.uniform(-0.5, 0.5, 2)))
    other = rc.Body(rc.FlatSurface(), rc.Elastic(2 * g2 * (1 + nu2), nu2))
    problem = rc.ContactProblem(rc.Body(surface, body), other, grid=rc.Grid((40, 40), 40.0), threads=1)
    solution = problem.solve(approach=0.1)
    radius = solution.stiffness().value / (2 * solution.modulus)
    compliance = (2 - nu1) / g1 + (2 - nu2) / g2
    assert solution.response("tangential-stiffness").value == pytest.approx(8 * radius / compliance, rel=1e-3)


@pytest.mark.parametrize("shape", [(40, 40), (32, 256), (257, 31), (24, 200)])
@pytest.mark.parametrize("radii", [(1e3, 1e3), (200.0, 3000.0)])
def test_tangential_stiffness_does_not_depend_on_the_domain(shape, radii):
    steel = rc.Elastic(2 * 0.91, 0.3)
    grid = rc.Grid(shape, (float(shape[0]), float(shape[1])))
    body = rc.Body(rc.ParaboloidSurface(radii, (0.2, 0.3)), steel)
    solution = rc.ContactProblem(body, rc.Body(rc.FlatSurface(), steel), grid=grid).solve(force=0.4)
    tangential = [solution.response(TangentialStiffness(axis)).value for axis in (0, 1)]
    ratios = np.divide(solution.stiffness().value, tangential)
    # Tractions in proportion to the normal answer give both compliances the sum of those of round contacts,
    # (2 - nu) / (1 - nu), whatever the shape; the true ones store a little less energy.
    assert 0.997 < ratios.sum() / (1.7 / 0.7) < 1.0 + 1e-5
    assert ratios[0] == pytest.approx((1 - 0.3 * mean_along_x(radii)) / 0.7, rel=3e-3)


@pytest.mark.parametrize("side", [8, 16, 40])
def test_square_punch(side):
    shape = np.zeros((side + 12, side + 9), dtype=bool)
    shape[5 : 5 + side, 4 : 4 + side] = True
    found = punch_of(shape).stiffness()
    # Pi times the capacity of the unit square, 0.3667896 (Read, J. Comput. Phys. 133 (1997) 1).
    error = found.value / (math.pi * 0.3667896 * side) - 1
    assert abs(error) < 0.12 / side
    assert abs(error) <= 3 * found.uncertainty / found.value


@pytest.mark.parametrize("fraction", [0.25, 0.6, 0.85])
def test_strips_of_westergaard(fraction):
    n, length = 96, 1e-4
    grid = rc.Grid((n, 8), (length, length * 8 / n))
    heights = 1e-6 * np.cos(2 * np.pi * (grid.x + 0.3e-6) / length) + 0 * grid.y
    surface = rc.HeightMap(heights, grid.size, periodic=True)
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1e9, 0.0)), boundary="periodic", threads=1)
    pressure = math.pi * 1e9 * 1e-6 / length * math.sin(math.pi * fraction / 2) ** 2
    found = problem.solve(pressure=pressure).stiffness()
    exact = grid.area * math.pi * 1e9 / (2 * length) / -math.log(math.sin(math.pi * fraction / 2))
    assert found.value == pytest.approx(exact, rel=0.02)
    assert abs(found.value - exact) <= 2 * found.uncertainty


def test_lattice_of_discs():
    n, radius = 48, 6.0
    errors = []
    for seed in range(4):
        centre = np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
        x, y = np.mgrid[:n, :n] - 0.5 * n
        shape = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 < radius**2
        found = punch_of(shape, "periodic").stiffness()
        # The count differs from the area of the disc: compare with a disc of the area of the cells.
        a = math.sqrt(shape.sum() / math.pi)
        exact = 1 / (1 / (2 * a) - 3.9002649 / (math.pi * n))
        errors.append(found.value / exact - 1)
    assert np.abs(errors).max() < 0.015
    assert abs(np.mean(errors)) < 0.01


def test_open_circle_near_full_contact():
    n, errors = 64, []
    grid = rc.Grid((n, n), float(n))
    for seed in range(3):
        shift = np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
        x, y = grid.x - shift[0], grid.y - shift[1]
        heights = 1e-3 * (np.cos(2 * np.pi * x / n) + np.cos(2 * np.pi * y / n))
        surface = rc.HeightMap(heights, grid.size, periodic=True)
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary="periodic", threads=1)
        full = math.pi * 1e-3 * 2 / n
        solution = problem.solve(pressure=0.93 * full)
        found = solution.stiffness()
        hole = math.sqrt((grid.area - solution.area().value) / math.pi)
        errors.append(found.value / (3 * n**4 / (8 * hole**3)) - 1)
        assert found.uncertainty < 0.15 * found.value
    assert np.abs(errors).max() < 0.15


def press_waves(cells, size, periods, share):
    """Return the contact of waves, at a fraction of the pressure of full contact."""
    grid = rc.Grid(cells, size)
    q = [2 * math.pi * number / side for number, side in zip(periods, size, strict=True)]
    heights = 1e-3 * (np.cos(q[0] * (grid.x - 0.37)) + np.cos(q[1] * (grid.y - 0.63)))
    problem = rc.ContactProblem(
        rc.Body(rc.HeightMap(heights, size, periodic=True), rc.Elastic(1.0, 0.0)), boundary="periodic"
    )
    return problem.solve(pressure=share * 0.5e-3 * sum(q))


@pytest.mark.parametrize("share", [0.9, 0.97, 0.99])
@pytest.mark.parametrize("turned", [False, True])
def test_near_full_contact_an_uncertain_stiffness_is_warned_of(share, turned):
    """There it errs by 17 to 80 %, on few cells 1:2; the conductance is the same number."""
    scene = ((31, 16), (31.0, 32.0), (4, 2))
    solution = press_waves(*(pair[::-1] if turned else pair for pair in scene), share)
    for found in (
        solution.stiffness(),
        solution.response("tangential-stiffness"),
        solution.conductance(conductivity=1.0),
    ):
        assert found.uncertainty > 0.07 * found.value > 0.0
        assert any("uncertainty is above 7 %" in text for text in found.warnings)


def test_near_full_contact_the_correction_leaves_a_stiffness():
    """The stiffness of the smallest open parts grows without bound: its inverse is corrected (5 % of it were left)."""
    fine = press_waves((120, 128), (30.0, 96.0), (2, 3), 0.998).stiffness()
    assert fine.value == pytest.approx(1e7, rel=0.5)


@pytest.mark.parametrize("seed", [14, 17, 19])
def test_a_contact_patch_that_the_grid_does_not_show(seed):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=6.0, longest=24.0, seed=seed)
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    grids = [rc.Grid((n, n), 48.0) for n in (48, 192)]
    coarse, fine = (rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=5e-4) for grid in grids)
    assert fine.patches.count == coarse.patches.count + 1
    for estimate, true in ((coarse.stiffness(), fine.stiffness()), (coarse.conductance(1.0), fine.conductance(1.0))):
        assert (
            0.04 * true.value < true.value - estimate.value < 2.5 * math.hypot(estimate.uncertainty, true.uncertainty)
        )


def test_the_uncertainty_of_a_large_contact_is_of_the_size_of_its_error():
    errors, stated = [], []
    for seed in range(3):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=0.2, longest=1.0, rolloff=0.5, seed=seed)
        body = rc.Body(surface, rc.Elastic(1e9, 0.0))
        found = [
            rc.ContactProblem(body, grid=rc.Grid(cells, 1.0), boundary="periodic").solve(pressure=3e7).stiffness()
            for cells in ((96, 96), (192, 192))
        ]
        errors.append(abs(found[0].value - found[1].value))
        stated.append(found[0].uncertainty)
        assert errors[-1] < 2.0 * math.hypot(*(one.uncertainty for one in found))
    assert np.median(stated) < 2.5 * np.median(errors)


def test_bounds_on_a_rough_ball():
    grid = rc.Grid((96, 96), 96.0)
    ball = -(grid.x**2 + grid.y**2) / 2000.0
    noise = rc.SelfAffineSurface(hurst=0.8, rms_height=0.02, longest=48.0, shortest=8.0, seed=2).heights(grid)
    body = rc.Body(rc.HeightMap(ball + noise, grid.size), rc.Elastic(1.0, 0.0))
    problem = rc.ContactProblem(body, grid=grid, threads=1)
    solution = problem.solve(force=0.5)
    found, area = solution.stiffness(), solution.area()
    i, j = np.nonzero(solution.contact)
    corners = np.hypot(i - i.mean(), j - j.mean()).max() + 1
    assert 2 * math.sqrt(area.value / math.pi) < found.value + 2 * found.uncertainty
    assert found.value < 2 * corners
    # Barber (2003): roughness between lo and hi moves the curve of force and approach of the ball by at most that; the
    # force is a convex function of the approach.
    absolute = solution.approach - problem.summit
    force_of = lambda d: 4 / 3 * math.sqrt(1000.0) * max(d, 0.0) ** 1.5  # noqa: E731
    steps = np.linspace(0.02, 2.0, 60)
    upper = min((force_of(absolute + s + noise.max()) - solution.force) / s for s in steps)
    lower = max((solution.force - force_of(absolute - s + noise.max())) / s for s in steps)
    assert lower < found.value < upper


@pytest.mark.parametrize(("length", "modulus"), [(2.0**-60, 1.0), (2.0**40, 2.0**-30)])
def test_units(length, modulus):
    values = []
    for scale, young in ((1.0, 1.0), (length, modulus)):
        heights = scale * 1e-2 * np.random.default_rng(1).standard_normal((24, 20))
        body = rc.Body(rc.HeightMap(heights, (24 * scale, 20 * scale)), rc.Elastic(young, 0.3))
        problem = rc.ContactProblem(body, rc.Body(rc.FlatSurface(), rc.Elastic(young, 0.3)), threads=1)
        solution = problem.solve(force=1e-3 * young * scale**2)
        values.append([solution.stiffness().value, solution.response("tangential-stiffness").value])
    np.testing.assert_allclose(values[1], np.array(values[0]) * length * modulus, rtol=1e-12)


def test_ends_and_refusals():
    surface = rc.WavySurface(1e-7, 1e-5)
    body, grid = rc.Body(surface, rc.Elastic(1e11, 0.3)), rc.Grid((16, 12), 1e-5)
    full = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=1e11)
    for response in ("stiffness", "tangential-stiffness"):
        assert full.response(response).value == math.inf
        assert any("touch everywhere" in warning for warning in full.response(response).warnings)
        assert str(full.response(response)).startswith("inf N/m; uncertain: ")
    light = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=1e6)
    empty = attrs.evolve(light, pressure=0.0 * light.pressure)
    assert empty.stiffness().value == 0.0
    wrapped = rc.ContactProblem(body, grid=grid, boundary="wrapped").solve(pressure=1e6)
    with pytest.raises(rc.InputError, match="wrapped"):
        wrapped.stiffness()
    free = rc.ContactProblem(body, grid=grid).solve(pressure=2e9)
    assert free.stiffness().warnings == ()
    for axis in (2, -1, 0.5, "x"):
        with pytest.raises(rc.InputError, match="axis"):
            TangentialStiffness(axis)
    other = rc.Body(rc.FlatSurface(), rc.Elastic(3e9, 0.2))
    coupled = rc.ContactProblem(body, other, grid=grid, boundary="periodic").solve(pressure=1e5)
    assert coupled.response("tangential-stiffness").value > 0.0
    assert Stiffness() == Stiffness()


@pytest.mark.parametrize("beta_of", [(70e9, 0.33), (1e9, 0.1)], ids=["aluminium", "plastic"])
def test_unlike_bodies_have_a_tangential_stiffness(beta_of):
    """Steel on another material: waves differ by gamma, the mean of both directions of a disc by half of it."""
    body = rc.Body(rc.ParaboloidSurface(1e-2, center=(0.3e-6, 0.1e-6)), rc.Elastic(210e9, 0.3))
    other = rc.Elastic(*beta_of)
    problem = rc.ContactProblem(body, rc.Body(rc.FlatSurface(), other), grid=rc.Grid((48, 48), 48e-6), threads=1)
    solution = problem.solve(approach=18e-6**2 / 1e-2)
    pair = problem.shear_convolution.setup.kernel.pair
    found = solution.response("tangential-stiffness")
    alone = solution.stiffness().value / (1.0 + 0.5 * pair.gamma)
    # The pressure changes too: stiffer by 0.08 to 0.18 of the square of beta.
    assert 1.0 - 2e-3 < found.value / alone < 1.0 + 0.2 * pair.beta**2 + 2e-3
