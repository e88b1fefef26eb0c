"""Approach and mean gap where the highest summit lies between the cells: tips, neighbours that are higher, kinks."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.reference import hertz_sphere
from scenes import each_once

ELASTIC = rc.Elastic(1.0, 0.0)


def press_cone(shape, cell, center, radius):
    grid = rc.Grid(shape, (shape[0] * cell[0], shape[1] * cell[1]))
    slope = 1e-3
    heights = -slope * np.hypot(grid.x - center[0], grid.y - center[1])
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=grid.size), ELASTIC))
    # Love's cone: F = pi a^2 slope E* / 2, and an approach of pi a slope / 2.
    return problem.solve(force=0.5 * math.pi * slope * radius**2), 0.5 * math.pi * slope * radius


@each_once(
    {
        "cell": [(1.0, 1.0), (1.0, 3.0), (3.0, 1.0)],
        "shape": [(31, 32), (61, 29), (24, 64)],
    }
)
def test_the_approach_of_a_cone_at_any_place(shape, cell):
    rng = np.random.default_rng(11)
    for _ in range(3):
        center = rng.uniform(-1.5, 1.5, 2) * cell
        radius = rng.uniform(2.0, 3.2) * max(cell)
        solution, true = press_cone(shape, cell, center, radius)
        found = solution.response("approach")
        assert found.value == pytest.approx(true, rel=0.025)
        assert abs(found.value - true) <= 2.0 * found.uncertainty < 0.2 * true


def test_the_approach_of_a_fine_cone_with_its_tip_between_four_cells():
    solution, true = press_cone((40, 40), (1.0, 1.0), (0.0, 0.0), 12.0)
    assert solution.approach < 0.97 * true
    found = solution.response("approach")
    assert found.value == pytest.approx(true, rel=1e-3)
    assert found.uncertainty < 5e-3 * true


def two_balls(lower, shape=(64, 40)):
    """Return two balls, one with its summit on a cell, the other between four and lower by this part of a rise."""
    grid = rc.Grid(shape, (float(shape[0]), float(shape[1])))
    radius, rise = 100.0, 0.25 / 100.0
    on_a_cell, between = (-15.5, 0.5), (16.0, 0.0)
    first, second = (-((grid.x - x) ** 2 + (grid.y - y) ** 2) / (2.0 * radius) for x, y in (on_a_cell, between))
    heights = np.maximum(first, second - lower * rise)
    return rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=grid.size), ELASTIC)), rise


@pytest.mark.parametrize("lower", [-0.5, 0.5])
def test_the_highest_summit_is_not_that_of_the_highest_cell(lower):
    problem, rise = two_balls(lower)
    deeper = two_balls(3.0)[0]
    # The highest cell is that of the first ball in all of them; the second one of the last is far below.
    added = []
    for one in (problem, deeper):
        solution = one.solve(force=0.5)
        added.append(solution.response("approach").value - solution.approach)
    assert added[0] - added[1] == pytest.approx(max(0.0, -lower) * rise, abs=5e-3 * rise)


def rough_map(cells):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=1.0, longest=6.0, rolloff=6.0, seed=5)
    return surface.heights(rc.Grid((cells, cells), 12.0))


@pytest.mark.parametrize("factor", [2, 4])
def test_a_linear_map_touches_first_at_the_highest_of_its_points(factor):
    coarse = rc.HeightMap(rough_map(48), size=12.0, periodic=True)
    linear = coarse.resample((48 * factor, 48 * factor), "bilinear")
    problem = rc.ContactProblem(rc.Body(linear, ELASTIC), boundary="periodic")
    solution = problem.solve(pressure=2e-3)
    body = rc.Body(coarse.resample((48 * 8, 48 * 8), "bilinear"), ELASTIC)
    fine = rc.ContactProblem(body, boundary="periodic").solve(pressure=2e-3)
    # Both maps have one mean plane, so that what the approach grows by is what the gap shrinks by.
    points = rough_map(48)
    highest = float(points.max() - points.mean())
    gap = float(fine.gap.mean())
    for name, true in (("mean-gap", gap), ("approach", highest - gap)):
        found = solution.response(name, uncertainty="model")
        assert found.value == pytest.approx(true, rel=2e-3)
        assert abs(found.value - true) <= 2.0 * found.uncertainty < 0.01 * true


@pytest.mark.parametrize(("shape", "size"), [((64, 64), (1.0, 1.0)), ((51, 153), (1.0, 1.0)), ((112, 56), (2.0, 1.0))])
def test_flat_lands_that_touch_do_not_make_a_smooth_summit_linear(shape, size):
    """A bump on a land, both in contact: lands are linear between all points, the summit is not."""
    grid = rc.Grid(shape, size)
    x, y = grid.x - 0.0371, grid.y + 0.0223
    heights = 0.01 * np.exp(-0.5 * (x**2 + y**2) / 0.07**2)
    body = rc.Body(rc.HeightMap(heights, size=size, periodic=True), ELASTIC)
    solution = rc.ContactProblem(body, boundary="periodic").solve_for(area="85%").solution
    # Both surfaces have the same mean plane.
    highest = 0.01 - float(heights.mean())
    gap, approach = (solution.response(name, uncertainty="model") for name in ("mean-gap", "approach"))
    error = abs(approach.value + gap.value - highest)
    assert error < 0.015 * highest
    assert error <= 2.0 * math.hypot(approach.uncertainty, gap.uncertainty)


def test_four_cells_a_wave_show_the_highest_summit():
    """Polynomials of eighth order see the summits of band-limited surfaces at four cells a wave."""
    highest = find_highest(rough_map(480))
    for cells, most in ((36, 0.02), (48, 3e-3), (96, 1e-4)):
        heights = rough_map(cells)
        body = rc.Body(rc.HeightMap(heights, size=12.0, periodic=True), ELASTIC)
        solution = rc.ContactProblem(body, boundary="periodic").solve(pressure=2e-3)
        # What is added for uniform pressure on each cell is subtracted from the gap.
        shift = solution.gap.mean() - solution.response("mean-gap").value
        found = solution.response("approach")
        rise = found.value - solution.approach - shift
        assert rise == pytest.approx(highest - heights.max(), abs=most * found.value)
        assert abs(rise - highest + heights.max()) <= 2.0 * found.uncertainty


def find_highest(heights):
    """Return the height of the highest summit of a fine map, by parabolas along both axes."""
    i, j = np.unravel_index(np.argmax(heights), heights.shape)
    rise = 0.0
    for line in (heights[i - 1 : i + 2, j], heights[i, j - 1 : j + 2]):
        rise += (line[2] - line[0]) ** 2 / (8.0 * (2.0 * line[1] - line[0] - line[2]))
    return heights[i, j] + rise


def test_a_ball_that_yields_has_a_wider_uncertainty():
    force, radius = 4e-3 / 3, 1000.0
    limit = hertz_sphere(force, radius, 1.0).p_max / 2.0
    solutions = []
    for material in (ELASTIC, rc.ElasticPerfectlyPlastic(1.0, 0.0, limit)):
        body = rc.Body(rc.ParaboloidSurface(radius), material)
        solutions.append(rc.ContactProblem(body, grid=rc.Grid((48, 48), 4.8)).solve(force=force))
    elastic, plastic = (solution.response("approach").uncertainty for solution in solutions)
    assert plastic > 5.0 * elastic


@pytest.mark.parametrize(("shape", "size"), [((61, 48), (61.0, 48.0)), ((41, 90), (123.0, 90.0))])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_ball_in_a_wrapped_domain_is_that_of_a_free_one(shape, size, axis):
    """Its heights do not repeat: a spline across the border swung far inside, and the area erred by .4 %."""
    grid = rc.Grid(shape, size)
    heights = -((grid.x + 0.15 * size[0]) ** 2 + 1.5 * (grid.y - 0.2 * size[1]) ** 2) / 2e3
    found = []
    for boundary in ("wrapped", "free"):
        surface = rc.HeightMap(heights.T if axis else heights, size[::-1] if axis else size)
        found.append(rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary=boundary).solve(force=0.1))
    wrapped, free = found
    assert wrapped.area().value == pytest.approx(free.area().value, rel=1e-8)
    assert wrapped.peak_pressure().value == pytest.approx(free.peak_pressure().value, rel=1e-8)


@each_once(
    {
        "shape size boundary": [((40, 33), (40.0, 33.0), "periodic"), ((29, 45), (87.0, 45.0), ("periodic", "free"))],
        "axis": [0, 1],
    }
)
def test_a_ball_that_does_not_repeat_in_a_periodic_domain_is_that_of_finer_cells(shape, size, boundary, axis):
    """A spline across the border swung far inside: 13 standard deviations of the area, 15 of the maximum pressure."""
    kinds = boundary[::-1] if axis and isinstance(boundary, tuple) else boundary
    found = []
    for fold in (1, 4):
        grid = rc.Grid((fold * shape[0], fold * shape[1]), size)
        heights = -((grid.x + 0.15 * size[0]) ** 2 + 1.5 * (grid.y - 0.2 * size[1]) ** 2) / 2e3
        surface = rc.HeightMap(heights.T if axis else heights, size[::-1] if axis else size)
        found.append(rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary=kinds).solve(force=0.02))
    for ask in (rc.ContactSolution.area, rc.ContactSolution.peak_pressure):
        coarse, fine = (ask(one) for one in found)
        assert coarse.value == pytest.approx(fine.value, rel=1e-4)
        assert abs(coarse.value - fine.value) < 2.0 * math.hypot(coarse.uncertainty, fine.uncertainty)


@pytest.mark.parametrize(
    ("shape", "count", "distance", "turn", "curvature"), [((55, 55), 3, 4.03, 0.3, 1.5), ((41, 67), 2, 3.8, 1.0, 1.0)]
)
def test_balls_half_of_a_wrapped_domain_apart_are_within_two(shape, count, distance, turn, curvature):
    """The slope by each load jumps half of the domain away: areas and maxima were off by 3 to 6 standard deviations."""
    radius = 0.5 * distance / math.sin(math.pi / count)
    side = 2.0 * radius + 4.0
    angles = turn + 2.0 * math.pi * np.arange(count) / count
    found = []
    for fold in (1, 3):
        grid = rc.Grid((fold * shape[0], fold * shape[1]), side)
        x, y = (place - center for place, center in ((grid.x, 0.1), (grid.y, -0.2)))
        balls = [-((x - radius * math.cos(a)) ** 2 + curvature * (y - radius * math.sin(a)) ** 2) / 2.0 for a in angles]
        surface = rc.HeightMap(np.max(balls, axis=0), grid.size)
        problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(1.0, 0.0)), boundary="wrapped")
        found.append(problem.solve(force=count * (1.0 if count == 2 else 0.9)))
    for name in ("blend", "peak-pressure"):
        ask = rc.ContactSolution.area if name == "blend" else rc.ContactSolution.response
        coarse, fine = (ask(one, name, uncertainty="model") for one in found)
        assert abs(coarse.value - fine.value) < 2.0 * math.hypot(coarse.uncertainty, fine.uncertainty)
        assert coarse.uncertainty < 0.01 * coarse.value
