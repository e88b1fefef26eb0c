"""Stick and slip within given limits: closed forms, an own judge on random tasks, invariance, refusals."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._solve.solvers import ProjectedShearCG, SpectralShearGradient, shear_solvers
from roughcontact._solve.solvers.conjugate.preconditioner import solve_on_blocks
from roughcontact._solve.solvers.shear import preconditioner
from roughcontact._solve.solvers.shear.base import ShearSystem
from roughcontact._solve.solvers.shear.descent import Face, ShearDescent
from roughcontact._solve.solvers.shear.discs import ForceControl, project_to_discs
from roughcontact._solve.solvers.shear.preconditioner import CoarseCorrection, PunchWeights
from roughcontact.typing import BoundKernel, PairConstants, ShearTask, natural_residual
from scenes import each_once
from strategies import seeds

MODULUS, RADIUS, CELL, FRICTION = 100e9, 1e-2, 1e-6, 0.3
# Without Poisson's ratio tangential displacement is the normal one, turned.
TURNED = rc.Elastic(2 * MODULUS, 0.0)
GAMMA = 0.3 / 0.7
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=8e-6, longest=64e-6, rolloff=32e-6, seed=3)


def convolve(grid, boundary, gamma, compliance=1.0):
    kernel = BoundKernel(rc.Love(), compliance=compliance, pair=PairConstants(0.0, gamma))
    convolver = rc.DCFFT() if boundary == "free" else rc.CircularFFT()
    return convolver.prepare(kernel, grid, rc.Boundary(boundary)).shear()


def convolve_cells(shape, boundary="free", gamma=GAMMA):
    return convolve(rc.Grid(shape, (float(shape[0]), float(shape[1]))), boundary, gamma)


def press(surface, cells, boundary="free", **load):
    body, flat = rc.Body(surface, TURNED), rc.Body(rc.FlatSurface(), TURNED)
    grid = rc.Grid((cells, cells), cells * CELL)
    return rc.ContactProblem(body, flat, grid=grid, boundary=boundary, threads=1).solve(**load)


def press_ball(cells):
    """Return the contact of a ball between four cells, of a radius in cells."""
    return press(rc.ParaboloidSurface(RADIUS), 2 * (cells + 4), force=4 * MODULUS * (cells * CELL) ** 3 / (3 * RADIUS))


def slide(solution, force, gamma=0.0, friction=FRICTION, solver=None, **task):
    """Solve a contact under a tangential force, N, along x and y."""
    convolution = convolve(solution.grid, str(solution.boundary), gamma, 1.0 / MODULUS)
    limit = rc.Coulomb(friction).limit(solution.pressure)
    given = tuple(one / solution.grid.cell_area for one in force)
    found = ShearTask(limit=limit, offset=np.zeros((2, *limit.shape)), shear_force=given, **task)
    return (solver or ProjectedShearCG()).solve(convolution, found)


def judge(convolution, task, outcome):
    """Return the violation of stick and slip, of the limits and of the force, each over the limits."""
    q, s = outcome.shear, task.limit
    size = np.hypot(*q)
    w = task.offset + np.reshape(outcome.displacement, (2, 1, 1)) - convolution.apply(q)
    trial = q + w / np.mean(convolution.own)
    reach = np.hypot(*trial)
    nearest = np.where(reach > s, trial * (s / np.where(reach > 0, reach, 1)), trial)
    load = [abs(q[k].sum() - force) for k, force in enumerate(task.shear_force) if force is not None]
    for one, other in zip(task.displacement, outcome.displacement, strict=True):
        assert one is None or one == other
    return np.hypot(*(q - nearest)).max() / s.max(), (size - s).max() / s.max(), max(load, default=0.0) / s.sum()


def make_task(seed):
    """Return a random convolution and task: limits, offsets, starts, and what is given along each axis."""
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(2, 28, 2))
    limit = np.abs(rng.standard_normal(shape)) ** rng.choice([0.5, 1.0, 4.0]) * (
        rng.random(shape) < rng.choice([0.2, 0.6, 1.0])
    )
    limit.flat[0] = 1.0
    offset = 10.0 ** rng.uniform(-5, 1) * (rng.random() < 0.7) * rng.standard_normal((2, *shape))
    angle, fraction = rng.uniform(0, 2 * np.pi), rng.choice([0.0, 0.1, 0.5, 0.9, 0.9999])
    force = fraction * limit.sum() * np.array([np.cos(angle), np.sin(angle)])
    moved = 10.0 ** rng.uniform(-2, 1) * rng.standard_normal(2)
    is_force = rng.random(2) < 0.6
    convolution = convolve_cells(shape, rng.choice(["free", "periodic"]), rng.choice([0.0, GAMMA, 1.0, -0.4]))
    return convolution, ShearTask(
        limit=limit,
        offset=offset,
        shear_force=tuple(float(one) if chosen else None for one, chosen in zip(force, is_force, strict=True)),
        displacement=tuple(None if chosen else float(one) for one, chosen in zip(moved, is_force, strict=True)),
        start=rng.standard_normal((2, *shape)) if rng.random() < 0.4 else None,
    )


@pytest.mark.parametrize(
    ("cells", "moved", "traction"), [(16, 6e-4, (0.065, 0.027, 0.013)), (64, 6e-5, (0.016, 0.007, 0.004))]
)
def test_cattaneo_and_mindlins_ball(cells, moved, traction):
    solution = press_ball(cells)
    a = cells * CELL
    x = (np.arange(solution.grid.shape[0]) - (solution.grid.shape[0] - 1) / 2) * CELL
    r = np.hypot(x[:, np.newaxis], x)
    peak = 2 * MODULUS * a / (np.pi * RADIUS)
    for fraction, rms in zip((0.2, 0.5, 0.9), traction, strict=True):
        found = slide(solution, (fraction * FRICTION * solution.force, 0.0))
        assert found.status.success
        c = a * (1 - fraction) ** (1 / 3)
        assert found.displacement[0] / (FRICTION * (a**2 - c**2) / RADIUS) == pytest.approx(1, abs=moved)
        exact = (
            FRICTION
            * peak
            * (np.sqrt(np.maximum(1 - (r / a) ** 2, 0)) - c / a * np.sqrt(np.maximum(1 - (r / c) ** 2, 0)))
        )
        inside = solution.pressure > 0
        error = found.shear[0] - exact
        assert np.sqrt(np.mean(error[inside] ** 2)) < rms * np.sqrt(np.mean(exact[inside] ** 2))
        assert not found.shear[1].any()
        sticks = np.hypot(*found.shear) < 0.999 * FRICTION * solution.pressure
        assert np.sqrt(sticks.sum() / np.pi) * CELL / c == pytest.approx(1, abs=0.03)


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_the_closed_form_is_nearly_right_with_poissons_ratio(poisson):
    # It takes the traction parallel to the force; on balls that is wrong by some 1e-3 of the displacement.
    solution = press_ball(32)
    gamma = poisson / (1 - poisson)
    for fraction, error in ((0.2, 7e-4), (0.5, 1.5e-3), (0.9, 3.5e-3)):
        found = slide(solution, (0.0, fraction * FRICTION * solution.force), gamma)
        exact = (1 + gamma / 2) * FRICTION * (32 * CELL) ** 2 / RADIUS * (1 - (1 - fraction) ** (2 / 3))
        assert -error < found.displacement[1] / exact - 1 < 0
        assert np.abs(found.shear[0]).max() > 0.01 * FRICTION * solution.peak_pressure().value


@each_once(
    {
        "boundary": ["free", "periodic"],
        "angle": [0.0, 0.5],
    }
)
def test_without_poissons_ratio_it_is_partial_slip(boundary, angle):
    solver = rc.solvers.resolve("projected-cg").with_tolerance(1e-9)
    body, flat = rc.Body(ROUGH, TURNED), rc.Body(rc.FlatSurface(), TURNED)
    problem = rc.ContactProblem(
        body, flat, grid=rc.Grid((48, 48), 48 * CELL), boundary=boundary, solver=solver, threads=1
    )
    solution = problem.solve(pressure=0.1 * 0.05 * MODULUS)
    force = 0.4 * FRICTION * solution.force
    known = solution.partial_slip(tangential_force=force, friction=FRICTION)
    found = slide(solution, (force * math.cos(angle), force * math.sin(angle)), tolerance=1e-8)
    assert np.hypot(*found.displacement) == pytest.approx(known.displacement.value, rel=1e-7)
    along = math.cos(angle) * found.shear[0] + math.sin(angle) * found.shear[1]
    assert np.abs(along - known.traction).max() < 1e-6 * known.traction.max()
    across = math.cos(angle) * found.shear[1] - math.sin(angle) * found.shear[0]
    assert np.abs(across).max() < 1e-6 * known.traction.max()


@pytest.mark.parametrize(("tolerance", "is_estimated"), [(1e-2, True), (1e-4, True), (1e-9, False)])
def test_one_descent_finds_what_it_estimates(tolerance, is_estimated):
    """Without the product that verifies it; where float32 does not reach the tolerance, float64 goes on."""
    solution = press(ROUGH, 64, "periodic", pressure=0.06 * 0.05 * MODULUS)
    convolution = convolve(solution.grid, "periodic", GAMMA, 1.0 / MODULUS)
    limit = rc.Coulomb(FRICTION).limit(solution.pressure)
    force = 0.5 * float(limit.sum())
    task = ShearTask(
        limit=limit, offset=np.zeros((2, *limit.shape)), shear_force=(force, 0.1 * force), tolerance=tolerance
    )
    found = ProjectedShearCG().approximate(convolution, task)
    slip = np.array(found.displacement)[:, np.newaxis, np.newaxis] - convolution.apply(found.shear)
    residual = natural_residual(found.shear, slip, limit, 0.5 * sum(convolution.own))
    assert found.status is rc.Status.CONVERGED
    assert found.residual <= tolerance
    assert residual <= 1.1 * found.residual + 1e-12
    assert found.shear.sum(axis=(1, 2)) == pytest.approx([force, 0.1 * force], rel=1e-12)
    products = ProjectedShearCG().solve(convolution, task).products
    assert (found.products < products) == is_estimated
    # It is found again from itself, by the verification of the start alone.
    again = ProjectedShearCG().approximate(convolution, attrs.evolve(task, start=found.shear, tolerance=2 * tolerance))
    assert (again.iterations, again.products) == (0, 1)


def test_rough_contact_in_few_iterations():
    solution = press(ROUGH, 128, "periodic", pressure=0.06 * 0.05 * MODULUS)
    for gamma in (0.0, GAMMA):
        for fraction in (0.2, 0.5, 0.9):
            found = slide(solution, (fraction * FRICTION * solution.force, 0.0), gamma)
            assert found.status is rc.Status.CONVERGED
            assert found.iterations <= 16
            # One with the kernel and one with its inverse, verifications, and the weights of new faces.
            assert found.products <= 2 * found.iterations + 12


@each_once(
    {
        "fraction": [0.4, 0.9],
        "pressure contact": [(0.15, 0.3), (0.6, 0.83), (1.0, 0.97)],
    }
)
def test_rough_contact_in_few_iterations_up_to_nearly_full_contact(pressure, contact, fraction):
    """Given the displacement instead of the force too: without displacing what lags behind at once up to 44."""
    solution = press(ROUGH, 128, "periodic", pressure=pressure * 0.05 * MODULUS)
    assert np.mean(solution.pressure > 0.0) == pytest.approx(contact, rel=0.2)
    given = fraction * FRICTION * solution.force
    found = slide(solution, (0.6 * given, 0.8 * given), GAMMA)
    assert found.status is rc.Status.CONVERGED
    assert found.iterations <= 25
    moved = ShearTask(
        limit=FRICTION * solution.pressure,
        offset=np.zeros((2, *solution.pressure.shape)),
        displacement=found.displacement,
    )
    other = ProjectedShearCG().solve(convolve(solution.grid, "periodic", GAMMA, 1.0 / MODULUS), moved)
    assert other.status is rc.Status.CONVERGED
    assert other.iterations <= 30


@pytest.fixture
def weighs_cells(monkeypatch):
    """Weigh the cells of grids of any size, as otherwise of large ones alone."""
    monkeypatch.setattr(preconditioner, "_MAX_SMALL_CELLS", 0)


def make_face(shape, boundary, slipping):
    """Return the face at which the cells of spots stick, but for a part that slips along x, and its system."""
    i, j = np.indices(shape)
    limit = np.where(np.hypot(i % 16 - 8, j % 16 - 8) < 5, 1.0, 0.0)
    task = ShearTask(limit=limit, offset=np.zeros((2, *shape)), shear_force=(0.0, 0.0))
    system = ShearSystem(convolve_cells(shape, boundary), task)
    slips = np.random.default_rng(4).random(system.limit.size) < slipping
    shear = np.stack([slips * system.limit, np.zeros(slips.size)])
    return system, Face.find(system, PunchWeights(system), shear, 0.4 * shear)


@pytest.mark.usefixtures("weighs_cells")
@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("slipping", [0.0, 0.4])
def test_weights_are_the_shear_if_all_cells_are_displaced_alike(boundary, slipping):
    """By products with the inverse kernel along x and y alone; it turns no cell where all stick."""
    system, face = make_face((48, 64), boundary, slipping)
    weights = face.weights
    root = np.sqrt(face.ease)
    for axis, found in enumerate((weights.xx, weights.yy)):
        alone = np.zeros((2, face.slips.size), dtype=np.float32)
        alone[axis] = 1.0
        exact = root * face.restrict(system.multiply_inverse(root * face.restrict(alone)))[axis]
        exact += (1.0 - face.ease) * face.ease / system.own * face.restrict(alone)[axis]
        assert np.corrcoef(found, exact)[0, 1] > 0.9
        # On a periodic domain that product has a shear of the mean, too.
        assert np.mean(found) == pytest.approx(np.mean(exact), rel=0.15 if boundary == "free" else 1.0)
    assert not (face.slips * weights.xx).any()
    vectors = np.random.default_rng(1).normal(size=(2, face.slips.size)).astype(np.float32)
    product = weights.multiply(vectors)
    assert np.abs(product - face.restrict(product)).max() < 1e-6
    assert np.einsum("an,an->", vectors, product) > 0.0


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_equal_weights_lie_in_the_face(boundary):
    _, face = make_face((32, 32), boundary, 0.4)
    weights = face.weights
    vectors = np.random.default_rng(1).normal(size=(2, face.slips.size)).astype(np.float32)
    product = weights.multiply(vectors)
    assert product == pytest.approx(face.ease * face.restrict(vectors), abs=1e-6)
    xx, xy, yy = weights.total
    for vector in np.eye(2):
        alike = weights.multiply(vector.astype(np.float32)[:, np.newaxis]).sum(axis=1)
        assert alike == pytest.approx(np.array([[xx, xy], [xy, yy]]) @ vector, rel=1e-5)


@settings(deadline=None, max_examples=20)
@given(seed=seeds)
def test_random_tasks_hold_with_the_weights_of_large_grids(seed):
    convolution, task = make_task(seed)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(preconditioner, "_MAX_SMALL_CELLS", 0)
        found = ProjectedShearCG().solve(convolution, task)
    assert found.status.success
    assert judge(convolution, task, found)[0] <= task.tolerance


@pytest.mark.usefixtures("weighs_cells")
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_coarse_correction_of_shear_solves_its_system_on_the_blocks(boundary):
    """Woodbury: the far part and the sums of the weights; the few steps leave some per cent."""
    system, face = make_face((32, 32), boundary, 0.4)
    correction = CoarseCorrection(system, face.weights)
    bx, by = correction._shape
    units = np.eye(2 * bx * by).reshape(-1, 2 * bx, by)
    inverse = np.stack([correction._invert(unit.astype(np.float32)).ravel() for unit in units], axis=1)
    assert inverse == pytest.approx(inverse.T, abs=1e-5 * float(np.abs(inverse).max()))
    assert np.linalg.eigvalsh(inverse).min() > -1e-6 * np.abs(inverse).max()
    residual = face.restrict(np.random.default_rng(7).normal(size=(2, face.slips.size)).astype(np.float32))
    sums = np.zeros((2, bx * by))
    for total, values in zip(sums, face.weights.multiply(residual), strict=True):
        np.add.at(total, correction._blocks.numbers, values)
    right = sums.reshape(2 * bx, by).astype(np.float32)
    solution = solve_on_blocks(right, correction._invert, correction._respond)
    # Times the inverse of the approximation: in float32 its own inverse is not known.
    start = inverse @ right.ravel()
    image = solution.ravel() + inverse @ correction._respond(solution).ravel()
    assert np.linalg.norm(image - start) < 0.1 * np.linalg.norm(start)
    spread = solution.reshape(2, -1)[:, correction._blocks.numbers]
    assert correction.apply(residual) == pytest.approx(face.weights.multiply(spread), rel=1e-4, abs=1e-5)


@settings(deadline=None, max_examples=30)
@given(seed=seeds)
def test_random_tasks_hold_before_an_own_judge(seed):
    convolution, task = make_task(seed)
    found = ProjectedShearCG().solve(convolution, task)
    assert found.status.success
    residual, beyond, load = judge(convolution, task, found)
    assert residual == pytest.approx(found.residual, rel=1e-3, abs=1e-12)
    assert residual <= task.tolerance
    assert beyond < 1e-15
    assert load < 1e-14


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(seed=seeds)
# Near rounding a step goes uphill, and the next ones fall again.
@example(seed=23)
@example(seed=1098701)
def test_both_solvers_agree_and_forget_their_start(seed):
    convolution, task = make_task(seed)
    task = attrs.evolve(task, tolerance=1e-9)
    found = ProjectedShearCG().solve(convolution, task)
    others = [
        SpectralShearGradient().solve(convolution, attrs.evolve(task, max_iterations=20_000)),
        ProjectedShearCG().solve(convolution, attrs.evolve(task, start=-3.0 * found.shear)),
        ProjectedShearCG().solve(convolution, attrs.evolve(task, start=found.shear)),
    ]
    for other in others:
        assert other.status.success
        assert np.abs(other.shear - found.shear).max() < 1e-6


@settings(deadline=None, max_examples=10)
@given(seed=seeds, stress=st.integers(-60, 60), compliance=st.integers(-60, 60))
def test_powers_of_two_and_signs_change_no_bit(seed, stress, compliance):
    convolution, task = make_task(seed)
    found = ProjectedShearCG().solve(convolution, task)
    q, k = 2.0**stress, 2.0**compliance
    grid = convolution.setup.grid
    kernel = convolution.setup.kernel
    scaled = convolve(grid, str(convolution.setup.boundary), kernel.pair.gamma, k)

    def change(sign):
        return attrs.evolve(
            task,
            limit=q * task.limit,
            offset=sign * q * k * task.offset,
            shear_force=tuple(one if one is None else sign * q * one for one in task.shear_force),
            displacement=tuple(one if one is None else sign * q * k * one for one in task.displacement),
            start=None if task.start is None else sign * q * task.start,
        )

    for sign in (1.0, -1.0):
        other = ProjectedShearCG().solve(scaled, change(sign))
        assert np.array_equal(other.shear, sign * q * found.shear)
        assert other.displacement == tuple(sign * q * k * one for one in found.displacement)
        assert other.residual == found.residual


@settings(deadline=None, max_examples=15)
@given(seed=seeds)
def test_axes_may_be_exchanged(seed):
    convolution, task = make_task(seed)
    setup = convolution.setup
    shape = setup.grid.shape[::-1]
    turned = convolve_cells(shape, str(setup.boundary), setup.kernel.pair.gamma)
    task = attrs.evolve(task, tolerance=1e-9)

    def exchange(field):
        return np.ascontiguousarray(field[::-1].transpose(0, 2, 1))

    found = ProjectedShearCG().solve(convolution, task)
    other = ProjectedShearCG().solve(
        turned,
        attrs.evolve(
            task,
            limit=np.ascontiguousarray(task.limit.T),
            offset=exchange(task.offset),
            shear_force=task.shear_force[::-1],
            displacement=task.displacement[::-1],
            start=None if task.start is None else exchange(task.start),
        ),
    )
    assert np.abs(exchange(other.shear) - found.shear).max() < 1e-6


@settings(deadline=None, max_examples=15)
@given(seed=seeds)
def test_force_and_displacement_give_the_same_state(seed):
    convolution, task = make_task(seed)
    task = attrs.evolve(task, tolerance=1e-9)
    found = ProjectedShearCG().solve(convolution, task)
    moved = attrs.evolve(task, shear_force=(None, None), displacement=found.displacement, start=None)
    other = ProjectedShearCG().solve(convolution, moved)
    assert judge(convolution, moved, other)[0] <= 1e-9
    # The displacement decides where anything sticks; else its direction alone matters.
    assert np.abs(other.shear - found.shear).max() < 1e-3


def test_friction_that_varies_over_the_surface():
    solution = press_ball(12)
    friction = np.where(np.arange(solution.grid.shape[0])[:, np.newaxis] % 4 < 2, 0.1, 0.3) * np.ones(
        solution.grid.shape
    )
    limit = friction * solution.pressure
    force = 0.6 * limit.sum() * solution.grid.cell_area
    found = slide(solution, (force, 0.0), GAMMA, friction)
    assert found.status.success
    size = np.hypot(*found.shear)
    slips = (size > (1 - 1e-9) * limit) & (limit > 0)
    sticks = size < (1 - 1e-3) * limit
    assert slips[friction == 0.1].sum() / (limit > 0)[friction == 0.1].sum() > 0.5
    assert sticks[friction == 0.3].sum() > sticks[friction == 0.1].sum()


def test_displacement_beyond_sliding():
    limit = np.full((12, 10), 2.0)
    task = ShearTask(limit=limit, offset=np.zeros((2, 12, 10)), displacement=(300.0, 400.0))
    found = ProjectedShearCG().solve(convolve_cells((12, 10)), task)
    assert found.status.success
    assert np.hypot(*found.shear) == pytest.approx(limit)
    assert found.shear[0].sum() == pytest.approx(0.6 * limit.sum(), rel=0.01)


def test_full_periodic_contact_moves_as_one():
    # The mean shear of a periodic domain moves nothing: any displacement makes it slide.
    task = ShearTask(limit=np.ones((16, 8)), offset=np.zeros((2, 16, 8)), displacement=(1e-3, 0.0))
    found = ProjectedShearCG().solve(convolve_cells((16, 8), "periodic"), task)
    assert found.status is rc.Status.CONVERGED
    assert found.shear[0] == pytest.approx(1.0)


def test_given_limits_are_kept_where_nothing_touches():
    limit = np.zeros((8, 6))
    task = ShearTask(limit=limit, offset=np.ones((2, 8, 6)), shear_force=(0.0, 0.0))
    for solver in (ProjectedShearCG(), SpectralShearGradient()):
        found = solver.solve(convolve_cells((8, 6)), task)
        assert found.status.success
        assert not found.shear.any()
    limit[3, 4] = 1.0
    found = ProjectedShearCG().solve(convolve_cells((8, 6)), attrs.evolve(task, limit=limit, shear_force=(0.0, 0.5)))
    assert found.shear[1, 3, 4] == 0.5
    assert np.count_nonzero(found.shear) == 1


def test_a_second_method_continues_where_the_first_stalls(monkeypatch):
    convolution, task = make_task(5)
    expected = ProjectedShearCG().solve(convolution, attrs.evolve(task, tolerance=1e-9))
    monkeypatch.setattr(ShearDescent, "run", lambda self, start, *_: start.shear)
    found = ProjectedShearCG().solve(convolution, attrs.evolve(task, tolerance=1e-9))
    assert found.status is rc.Status.RESCUED
    assert np.abs(found.shear - expected.shear).max() < 1e-6


def test_what_does_not_converge_says_so(monkeypatch):
    convolution, task = make_task(5)
    for solver in (ProjectedShearCG(), SpectralShearGradient()):
        found = solver.solve(convolution, attrs.evolve(task, tolerance=1e-12, max_iterations=2))
        assert found.status is rc.Status.MAXIMUM_ITERATIONS
        assert judge(convolution, task, found)[0] == pytest.approx(found.residual, rel=1e-6)
        broken = attrs.evolve(task, offset=task.offset * np.nan)
        assert solver.solve(convolution, broken).status is rc.Status.NOT_FINITE
    found = ProjectedShearCG().solve(convolution, attrs.evolve(task, tolerance=1e-300))
    assert found.status in (rc.Status.CONVERGED_TO_ROUNDING, rc.Status.STALLED, rc.Status.MAXIMUM_ITERATIONS)
    assert found.residual < 1e-12
    assert ProjectedShearCG is shear_solvers["projected-cg"]


def test_what_is_refused():
    limit = np.ones((4, 4))
    offset = np.zeros((2, 4, 4))
    with pytest.raises(rc.InputError, match=r"slide: the tangential force is 1\.0625 times the force of sliding"):
        ShearTask(limit=limit, offset=offset, shear_force=(17.0, 0.0))
    with pytest.raises(rc.InputError, match="slide"):
        ShearTask(limit=limit, offset=offset, shear_force=(9.6, 12.8))
    with pytest.raises(rc.InputError, match="above the force of sliding"):
        ShearTask(limit=0 * limit, offset=offset, shear_force=(1.0, None), displacement=(None, 0.0))
    for force, displacement in (((None, 0.0), (None, None)), ((1.0, 0.0), (1.0, None))):
        with pytest.raises(rc.InputError, match="Along x either the tangential force or the displacement"):
            ShearTask(limit=limit, offset=offset, shear_force=force, displacement=displacement)


@settings(deadline=None, max_examples=40)
@given(seed=seeds)
def test_projection_keeps_force_and_limits(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 40))
    limit = rng.random(count) ** 3 + 1e-9
    values = 10.0 ** rng.uniform(-3, 3) * rng.standard_normal((2, count))
    axes = rng.permutation([1.0, float(rng.random() < 0.5)])
    force = axes * rng.uniform(0, 0.999) * limit.sum() * np.array([0.6, -0.8])
    control = ForceControl(force, axes)
    found, shift = control.project(values, limit)
    assert control.find_error(found, limit) < 1e-15 * (100 + np.abs(values).max() / limit.max())
    assert (np.hypot(*found) <= limit * (1 + 1e-15)).all()
    # The nearest one: the projection of the shifted values, with a shift along the given axes alone.
    assert not shift[axes == 0.0].any()
    assert np.abs(found - project_to_discs(values + shift[:, np.newaxis], limit)).max() <= 1e-12 * np.abs(values).max()


def test_natural_residual_is_zero_if_and_only_if_stick_and_slip_hold():
    limit = np.array([2.0, 1.0])
    shear = np.array([[1.2, 0.0], [0.5, -1.0]])
    slip = np.array([[0.0, 0.0], [0.0, -3.0]])
    assert natural_residual(shear, slip, limit, 0.7) == pytest.approx(0.0, abs=1e-15)
    assert natural_residual(shear, slip + np.array([[0.07], [0.0]]), limit, 0.7) == pytest.approx(0.05, rel=0.01)
    assert natural_residual(shear, -slip, limit, 0.7) > 0.5
    assert natural_residual(0.5 * shear, slip, limit, 0.7) > 0.2
