"""Uncertainties from two grids: the diagonal phases of a map."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc

ELASTIC = rc.Elastic(1.0, 0.0)
ANSWERS = ("approach", "mean-gap", "peak-pressure", "perimeter")


def solve(heights, size, boundary="periodic", **load):
    periodic = boundary == "periodic"
    body = rc.Body(rc.HeightMap(heights, size=size, periodic=periodic), ELASTIC)
    return rc.ContactProblem(body, boundary=boundary).solve(**(load or {"pressure": 1e-3}))


def rough(shape, size, seed=1):
    side = min(size)
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=side / 8, longest=side / 2, seed=seed)
    return surface.heights(rc.Grid(shape, size))


@pytest.fixture(scope="module")
def turned():
    grid = rc.Grid((66, 44), (1.5, 1.0))
    cusps = 0.01 * (2.0 * ((2 * grid.x + grid.y) % 1.0) - 1.0) ** 2
    return solve(cusps + 1e-4 * np.cos(2 * np.pi * grid.y), (1.5, 1.0), pressure=2e-3)


def test_phases_are_the_contact_on_every_second_point():
    heights = rough((64, 32), (2.0, 1.0))
    solution = solve(heights, (2.0, 1.0))
    phases = solution.phases()
    assert solution.phases() is phases
    for offset, state in enumerate(phases.states):
        alone = solve(heights[offset::2, offset::2], (2.0, 1.0), pressure=1e-3)
        assert state.grid.matches(alone.grid)
        assert state.force == pytest.approx(solution.force, rel=1e-9)
        np.testing.assert_allclose(state.pressure, alone.pressure, atol=5e-3 * alone.pressure.max())
        assert state.status.success


@pytest.mark.parametrize("shape", [(87, 87), (63, 64), (48, 145)])
def test_steps_of_odd_periodic_maps_stay_steps(shape):
    """A height between both sides would be an edge that is not sharp, and one beyond them alone in contact."""
    grid = rc.Grid(shape, (1.0, 1.0))
    inside = np.hypot(grid.x - 0.03, grid.y + 0.05) < 0.23
    solution = solve(np.where(inside, 0.0, -0.05), (1.0, 1.0))
    for state in solution.phases().states:
        gaps = np.unique(state.initial_gap)
        np.testing.assert_allclose(gaps, (0.0, 0.05), atol=1e-15)
    perimeter = solution.response("perimeter")
    assert abs(perimeter.value - 0.46 * np.pi) <= 2.0 * perimeter.uncertainty < 0.45 * np.pi * 0.46


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
@pytest.mark.parametrize("shape", [(64, 48), (63, 49), (96, 32), (48, 65)])
def test_grids_of_any_shape_have_phases(shape, boundary):
    """An odd periodic side gets one point more, an odd free side loses its last row."""
    solution = solve(rough(shape, (1.0, 1.0)), (1.0, 1.0), boundary)
    free = solution.boundary.free_axes
    wanted = tuple((n - (n % 2) * (1 if ends else -1)) // 2 for n, ends in zip(shape, free, strict=True))
    for state in solution.phases().states:
        assert state.grid.shape == wanted
        assert state.boundary is solution.boundary
        assert state.force == pytest.approx(solution.force, rel=1e-9)
    area = solution.area(uncertainty="two grids")
    assert area.value == solution.area().value
    assert 0.0 < area.uncertainty < 0.5 * area.value


def test_the_transposed_map_has_the_same_uncertainties(turned):
    heights = -turned.initial_gap
    other = solve(np.ascontiguousarray(heights.T), turned.grid.size[::-1], pressure=2e-3)
    for name in ANSWERS:
        one, two = (each.response(name, uncertainty="two grids") for each in (turned, other))
        assert two.uncertainty == pytest.approx(one.uncertainty, rel=0.02)


def test_the_uncertainty_is_half_the_root_mean_square_of_the_changes():
    solution = solve(rough((64, 64), (1.0, 1.0)), (1.0, 1.0))
    phases = solution.phases()
    assert not phases.flagged
    for name in ANSWERS:
        found = solution.response(name, uncertainty="two grids")
        changes = [state.response(name).value - found.value for state in phases.states]
        assert found.uncertainty == pytest.approx(0.5 * math.sqrt(np.mean(np.square(changes))), rel=1e-12)
        assert found.value == solution.response(name).value


def test_flagged_answers_have_the_larger_of_both_uncertainties(turned):
    assert turned.phases().flagged
    found, model = (turned.response("approach", uncertainty=kind) for kind in ("two grids", "model"))
    changes = [state.response("approach").value - found.value for state in turned.phases().states]
    half = 0.5 * math.sqrt(np.mean(np.square(changes)))
    assert found.uncertainty == pytest.approx(max(model.uncertainty, half), rel=1e-9)


def test_the_area_of_creases_and_edges_is_extrapolated(turned):
    """Strips between straight cusps have the width of their closed form; the edge of a punch errs with the cell."""
    level, others = turned.area("level-set").value, [one.area("level-set").value for one in turned.phases().states]
    area = turned.area(uncertainty="two grids")
    assert area.value == pytest.approx(level + (level - np.mean(others)) / 3, rel=1e-12)
    grid = rc.Grid((50, 50), 1.0)
    disc = solve(np.where(np.hypot(grid.x - 0.003, grid.y + 0.006) < 0.21, 0.0, -0.1), 1.0, "free", force=1e-3)
    found = disc.area(uncertainty="two grids")
    assert abs(found.value - math.pi * 0.21**2) < 2.0 * found.uncertainty


@pytest.mark.parametrize("radius", [8.26, 10.1, 21.5])
def test_where_both_grids_agree_the_model_judges_the_area(radius):
    """The symmetry of a disc gives both grids the same cells, which err by the same."""
    grid = rc.Grid((72, 72), 72.0)
    heights = np.where(np.hypot(grid.x, grid.y) < radius, 0.0, -1.0)
    body = rc.Body(rc.HeightMap(heights, size=72.0), rc.ElasticPerfectlyPlastic(1.0, 0.0, 0.01))
    true = math.pi * radius**2
    solution = rc.ContactProblem(body).solve(force=0.8 * 0.01 * true)
    assert solution.phases().flagged
    area = solution.area()
    assert area.uncertainty == pytest.approx(solution.area(uncertainty="model").uncertainty, rel=1e-9)
    assert abs(area.value - true) <= 2.0 * area.uncertainty < 0.2 * true


def test_errors_lie_within_the_uncertainties_of_creases():
    """Beside the same surface on cells a quarter as long: the model alone knows nothing of the creases."""

    def cusps(cells):
        grid = rc.Grid((cells, cells), 1.0)
        dents = [(-0.3, -0.2), (0.2, 0.3), (0.25, -0.3), (-0.2, 0.25), (0.0, 0.0)]
        fields = []
        for x, y in dents:
            dx, dy = (d - np.round(d) for d in (grid.x - x, grid.y - y))
            fields.append(0.5 * (dx**2 + dy**2))
        return solve(np.min(fields, axis=0), 1.0, pressure=1e-2)

    coarse, fine = cusps(50), cusps(200)
    for name in ("approach", "mean-gap", "perimeter"):
        found = coarse.response(name, uncertainty="two grids")
        assert abs(found.value - fine.response(name).value) < 2.0 * found.uncertainty
    area = coarse.area(uncertainty="two grids")
    assert abs(area.value - fine.area(uncertainty="two grids").value) < 2.0 * area.uncertainty


def test_a_load_by_the_approach_is_kept():
    """The highest point of a phase may be lower, and touches later."""
    heights = rough((64, 64), (1.0, 1.0))
    solution = solve(heights, (1.0, 1.0), approach=0.3 * float(np.ptp(heights)))
    for offset, state in enumerate(solution.phases().states):
        lower = float(heights.max() - heights[offset::2, offset::2].max())
        assert state.approach == pytest.approx(solution.approach - lower, rel=1e-6)


def test_lost_points_stay_lost():
    heights = rough((48, 48), (1.0, 1.0))
    lost = np.zeros(heights.shape, dtype=bool)
    lost[10:14, 20:30] = True
    body = rc.Body(rc.HeightMap(heights, size=1.0, non_measured=lost, periodic=True), ELASTIC)
    solution = rc.ContactProblem(body, boundary="periodic").solve(pressure=1e-3)
    for offset, state in enumerate(solution.phases().states):
        np.testing.assert_array_equal(state.non_measured, lost[offset::2, offset::2])


def test_a_line_of_single_cells_is_refused():
    body = rc.Body(rc.ParaboloidSurface((1.0, math.inf)), ELASTIC)
    problem = rc.ContactProblem(body, grid=rc.Grid((64, 1), (0.2, 1.0)), boundary=("free", "periodic"))
    solution = problem.solve(force=1e-3)
    with pytest.raises(rc.InputError, match="64 x 1 cells has no coarser one"):
        solution.phases()


def test_what_has_no_phases_is_refused_in_a_sentence(tmp_path):
    solution = solve(rough((32, 32), (1.0, 1.0)), (1.0, 1.0))
    with pytest.raises(rc.InputError, match="two grids"):
        solution.area(uncertainty="three grids")
    solution.save(tmp_path / "saved.npz")
    again = rc.load(tmp_path / "saved.npz")
    assert again.area(uncertainty="two grids") == solution.area(uncertainty="two grids")
    body = rc.Body(rc.SphereSurface(1e-3), rc.Elastic(210e9, 0.3))
    law = rc.Exponential(0.05, 1e-8)
    sticky = rc.ContactProblem(body, grid=rc.Grid((32, 32), 20e-6), adhesion=law).solve(force=1e-3)
    with pytest.raises(rc.InputError, match="attract each other"):
        sticky.area(uncertainty="two grids")


def test_warnings_are_those_of_the_uncertainty_that_is_stated():
    """A model that says that waves have too few cells is not asked."""
    solution = solve(rough((40, 40), (1.0, 1.0)), (1.0, 1.0))
    found = solution.area(uncertainty="two grids")
    rules = {getattr(text, "rule", "") for text in found.warnings}
    assert "resolution" not in rules
    assert ("uncertainty" in rules) == (found.uncertainty > 0.05 * found.value)


def test_flagged_contacts_are_judged_by_two_grids_unless_the_model_is_asked(turned):
    assert turned.area() == turned.area(uncertainty="two grids")
    assert turned.area("level-set") == turned.area("level-set", uncertainty="two grids")
    assert turned.response("approach") == turned.response("approach", uncertainty="two grids")
    # Nothing widens a maximum that is as uncertain as itself.
    assert turned.peak_pressure() == turned.peak_pressure(uncertainty="model")
    assert turned.area().estimator == "level-set, two grids"
    assert turned.explain().startswith("uncertainties by two grids: ")
    model = attrs.evolve(turned, uncertainty="model")
    assert model.area() == turned.area(uncertainty="model") != turned.area()
    assert model.explain() == "uncertainties by a model of the errors, as asked"
    assert all(state.uncertainty == "model" for state in turned.phases().states)


def test_a_bounded_maximum_is_judged_by_the_model_unless_two_grids_are_asked():
    """Of heights that are rough at the scale of the cells."""
    rng = np.random.default_rng(4)
    solution = solve(rough((48, 48), (1.0, 1.0)) + 2e-4 * rng.standard_t(2, (48, 48)), (1.0, 1.0), pressure=1e-2)
    assert solution.response("flags").unresolved
    assert not solution.response("flags").unbounded
    kinds = ("auto", "model", "two grids")
    peak, model, both = (solution.response("peak-pressure", uncertainty=kind) for kind in kinds)
    assert peak == model
    changes = [state.response("peak-pressure").value - peak.value for state in solution.phases().states]
    assert both.uncertainty == pytest.approx(max(model.uncertainty, math.sqrt(np.mean(np.square(changes)))))


def test_smooth_contacts_and_lost_points_are_judged_by_the_model():
    heights = rough((48, 48), (1.0, 1.0))
    smooth = solve(heights, (1.0, 1.0))
    assert smooth.area() == smooth.area(uncertainty="model")
    assert smooth.response("judgement").phases is None
    assert "smooth heights" in smooth.explain()
    lost = np.zeros(heights.shape, dtype=bool)
    lost[10:14, 20:30] = True
    steps = np.where(np.arange(48)[:, None] < 24, heights, heights - 0.1)
    body = rc.Body(rc.HeightMap(steps, size=1.0, non_measured=lost, periodic=True), ELASTIC)
    solution = rc.ContactProblem(body, boundary="periodic").solve(pressure=1e-3)
    assert "not measured" in solution.explain()
    assert solution.area() == solution.area(uncertainty="model")


def test_what_has_no_single_number_is_refused_an_uncertainty(turned):
    with pytest.raises(rc.InputError, match="not a number that has one uncertainty"):
        turned.response("flags", uncertainty="two grids")


def test_stress_maxima_have_the_uncertainty_of_their_solution():
    """Of heights that are rough at the scale of the cells, whose stress is bounded."""
    rng = np.random.default_rng(4)
    solution = solve(rough((48, 48), (1.0, 1.0)) + 2e-4 * rng.standard_t(2, (48, 48)), (1.0, 1.0), pressure=1e-2)
    assert solution.response("flags").rough_tail
    both, model = solution.stress(), attrs.evolve(solution, uncertainty="model").stress()
    for name in ("von_mises", "shear"):
        found, alone = both.estimates[name], model.estimates[name]
        others = [state.stress().estimates[name].value for state in solution.phases().states]
        added = math.sqrt(np.mean(np.square(np.array(others) - found.value)))
        wanted = alone.uncertainty if alone.uncertainty >= alone.value else max(alone.uncertainty, added)
        assert found.value == alone.value
        assert found.uncertainty == pytest.approx(wanted)


def test_stiffness_at_sharp_edges_has_half_the_change_over_two_grids(turned):
    for name in ("stiffness", "tangential-stiffness"):
        found = turned.response(name, uncertainty="auto")
        alone = turned.response(name, uncertainty="model")
        others = [state.response(name).value for state in turned.phases().states]
        change = math.sqrt(np.mean(np.square(np.array(others) - found.value)))
        assert found.value == alone.value
        assert found.uncertainty == pytest.approx(max(0.5 * change, 0.1 * alone.uncertainty))
        assert found.uncertainty < alone.uncertainty


def test_a_study_can_say_no(tmp_path, turned):
    problem = turned.origin.source
    areas = {}
    for kind in ("auto", "model", "auto"):
        study = rc.Study(problem, pressure=[2e-3], responses=["approach"], uncertainty=kind, fields=True)
        result = study.run(tmp_path)
        (record,) = result
        expected = attrs.evolve(turned, uncertainty=kind)
        assert record.areas["blend"] == (expected.area().value, expected.area().uncertainty)
        assert record.estimates["approach"].uncertainty == expected.response("approach").uncertainty
        assert result.solution(record).area() == expected.area()
        areas[kind] = record.areas["blend"]
        # Only what is asked of the solution changes, not what was solved.
        assert result.computed == (kind == "auto" and len(areas) == 1)
    assert areas["auto"] != areas["model"]
    with pytest.raises(rc.InputError, match="The uncertainty"):
        rc.Study(problem, pressure=[2e-3], uncertainty="three grids")
