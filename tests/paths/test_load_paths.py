"""Paths of loads along which a contact is flattened: unloading, reloading, energy, files."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc

HARDNESS = 30e6
SOFT = rc.ElasticPerfectlyPlastic(young=1e9, poisson=0.0, hardness=HARDNESS)
CAREFUL = rc.ProjectedConjugateGradient(tolerance=1e-9)


def press_rough(boundary, shape=(32, 32), size=(1e-3, 1e-3), seed=1, material=SOFT, **others):
    """Return a rough body on a rigid flat, whose waves of the slope 0.1 have eight cells."""
    wave = 8.0 * max(side / n for side, n in zip(size, shape, strict=True))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=wave, longest=max(size), seed=seed)
    others.setdefault("solver", CAREFUL)
    return rc.ContactProblem(rc.Body(surface, material), grid=rc.Grid(shape, size), boundary=boundary, **others)


def solve_by_lists_of_cells(matrix, gap, mean, limit):
    """Return pressure and approach by sets of elastic, saturated and open cells, exchanged by turns: a dense matrix."""
    n = gap.size
    saturated = np.zeros(n, dtype=bool)
    elastic = gap < np.quantile(gap, 0.3)
    for _ in range(500):
        cells = np.flatnonzero(elastic)
        held = matrix[np.ix_(cells, np.flatnonzero(saturated))].sum(axis=1) * limit
        system = np.zeros((cells.size + 1, cells.size + 1))
        system[:-1, :-1] = matrix[np.ix_(cells, cells)]
        system[:-1, -1] = -1.0
        system[-1, :-1] = 1.0
        right = np.append(-gap[cells] - held, n * mean - limit * saturated.sum())
        found = np.linalg.solve(system, right)
        pressure = np.where(saturated, limit, 0.0)
        pressure[cells] = found[:-1]
        approach = found[-1]
        left = gap + matrix @ pressure - approach
        scale = np.ptp(gap)
        opened = elastic & (pressure < 0.0)
        full = elastic & (pressure > limit)
        joined = ~elastic & ~saturated & (left < -1e-12 * scale)
        freed = saturated & (left > 1e-12 * scale)
        if not (opened | full | joined | freed).any():
            return pressure, approach
        elastic = (elastic & ~opened & ~full) | joined | freed
        saturated = (saturated & ~freed) | full
    raise AssertionError("the sets of cells do not settle")


@pytest.mark.parametrize(("shape", "size"), [((14, 12), (1e-3, 1e-3)), ((9, 18), (0.4e-3, 2e-3))])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_path_is_that_of_sets_of_cells(boundary, shape, size):
    """Loads up and down, the flattening carried along by each side alone."""
    problem = press_rough(boundary, shape, size, seed=5)
    loads = np.array([0.05, 0.3, 0.1, 0.0, 0.2, 0.35, 0.3]) * HARDNESS * 0.8
    path = problem.path(pressure=loads)
    cells = np.eye(shape[0] * shape[1]).reshape(-1, *shape)
    matrix = np.stack([problem.displace(one) for one in cells]).reshape(cells.shape[0], -1).T
    lost = np.zeros(shape[0] * shape[1])
    for load, state in zip(loads, path, strict=True):
        gap = problem.initial_gap.ravel() + lost
        if load == 0.0:
            assert not state.pressure.any()
            assert state.approach == pytest.approx(gap.min(), rel=1e-9)
            continue
        pressure, approach = solve_by_lists_of_cells(matrix, gap, load, HARDNESS)
        np.testing.assert_allclose(state.pressure.ravel(), pressure, atol=1e-6 * HARDNESS)
        assert state.approach == pytest.approx(approach, rel=1e-7)
        overlap = np.maximum(approach - gap - matrix @ pressure, 0.0)
        lost += np.where(pressure >= HARDNESS, overlap, 0.0)
    worn = path[-1].added[0].memory[0]["flattened_height"].ravel()
    np.testing.assert_allclose(worn, lost, atol=1e-7 * lost.max())


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_one_increment_for_a_reversal_is_exact(boundary):
    """Many loads up and many down end where one of each does; nothing flows while the load falls."""
    problem = press_rough(boundary, seed=2)
    top = 0.2 * HARDNESS
    once = problem.path(pressure=[top, 0.4 * top])
    steps = np.linspace(0.0, 1.0, 9)[1:]
    often = problem.path(pressure=[*(top * steps), *(top * (1.0 - 0.6 * steps))])
    for one, other in zip(once, (often[7], often[15]), strict=True):
        assert one.saturated.any() or one is once[1]
        np.testing.assert_allclose(one.pressure, other.pressure, atol=1e-6 * HARDNESS)
        assert one.approach == pytest.approx(other.approach, rel=1e-7)
    work = often.table().columns["plastic_work"]
    np.testing.assert_allclose(work[8:], work[7], rtol=1e-7)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_flattened_bodies_carry_the_load_again(boundary):
    """The bodies that are left, as another problem, have the pressure of the path, and no gap where they flowed."""
    problem = press_rough(boundary, seed=3)
    path = problem.path(pressure=[0.2 * HARDNESS])
    body, flat = path.bodies
    assert flat is problem.counterbody
    again = rc.ContactProblem(body, grid=problem.grid, boundary=boundary, solver=CAREFUL).solve(pressure=0.2 * HARDNESS)
    np.testing.assert_allclose(again.pressure, path[0].pressure, atol=1e-6 * HARDNESS)
    assert np.abs(again.gap[path[0].saturated]).max() < 1e-6 * np.ptp(problem.initial_gap)


@pytest.mark.slow
def test_the_work_that_is_lost_is_the_hardness_times_the_volume():
    """And that of the loop of force and approach, which the trapezoidal rule gives too large."""
    problem = press_rough("free", seed=4)
    steps = np.linspace(0.0, 1.0, 65)[1:]
    top = 0.02
    path = problem.path(force=[*(top * steps), *(top * (1.0 - steps))])
    last = path.table().columns
    assert last["plastic_work"][-1] == pytest.approx(HARDNESS * last["flattened_volume"][-1], rel=1e-12)
    loop = np.trapezoid(np.append(0.0, path.force), np.append(0.0, path.approach))
    assert loop == pytest.approx(last["plastic_work"][-1], rel=2e-3)
    assert loop > last["plastic_work"][-1]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_stiffness_on_unloading_is_the_slope_of_the_falling_load(boundary):
    surface = rc.WavySurface(2e-6, 0.25e-3) if boundary == "periodic" else rc.SphereSurface(radius=5e-3)
    grid = rc.Grid((128, 128), 1e-3)
    problem = rc.ContactProblem(rc.Body(surface, SOFT), grid=grid, boundary=boundary, solver=CAREFUL)
    path = problem.path(pressure=[0.2 * HARDNESS, 0.2 * HARDNESS * (1.0 - 1e-5)])
    slope = (path[0].force - path[1].force) / (path[0].approach - path[1].approach)
    found = path[0].stiffness(unloading=True)
    assert path[0].saturated.mean() > 0.05
    assert abs(found.value - slope) <= max(2.0 * found.uncertainty, 0.03 * slope)
    assert found.value > 1.03 * path[0].stiffness().value


def test_elastic_bodies_have_one_stiffness():
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=1.0)
    assert solution.stiffness(unloading=True).value == solution.stiffness().value


def test_without_a_limit_a_path_remembers_nothing():
    """Its states are those of single solves, up to the tolerance."""
    problem = press_rough("periodic", material=rc.Elastic(young=1e9, poisson=0.0))
    path = problem.path(pressure=[1e6, 3e6, 2e6])
    for state in path:
        alone = problem.solve(pressure=state.mean_pressure)
        np.testing.assert_allclose(state.pressure, alone.pressure, atol=1e-6 * alone.pressure.max())
    assert "flattened_volume" not in path.table().columns


def test_adhesion_remembers_flattening():
    """Summits that were flattened stick better; the loop loses the hardness times the volume."""
    law = rc.Exponential(work=0.05, range=8e-9)
    soft = rc.ElasticPerfectlyPlastic(young=1e9, poisson=0.3, hardness=60e6)
    grid = rc.Grid((48, 48), 0.8e-6)
    found = {}
    for material in (soft, rc.Elastic(young=1e9, poisson=0.3)):
        body = rc.Body(rc.ParaboloidSurface(radius=0.9e-6), material)
        cycle = rc.ContactProblem(body, grid=grid, adhesion=law).cycle(approach=np.linspace(-20e-9, 20e-9, 11))
        found[type(material)] = cycle
    plastic = found[rc.ElasticPerfectlyPlastic]
    assert plastic.pull_off.value < 1.3 * found[rc.Elastic].pull_off.value < 0.0
    lost = plastic.unloading[-1].added[0].numbers["plastic_work"][0]
    assert abs(plastic.dissipated.value - lost) < max(2.0 * plastic.dissipated.uncertainty, 0.05 * lost)


def test_a_path_with_adhesion_goes_on_from_the_state_before():
    """Pulled apart, the surfaces stick as on the branch of unloading of a cycle, not as where they are pressed."""
    body = rc.Body(rc.ParaboloidSurface(20e-6), rc.Elastic(young=7.5e6, poisson=0.5))
    law = rc.Exponential(work=0.05, range=30e-9)
    problem = rc.ContactProblem(body, grid=rc.Grid((64, 64), 4.8e-6), adhesion=law)
    up = np.linspace(-160e-9, 40e-9, 8)
    cycle = problem.cycle(approach=up)
    path = problem.path(approach=[*up, *up[-2::-1]])
    forces = [*cycle.loading.force, *cycle.unloading.force[1:]]
    assert np.abs(cycle.loading.force - cycle.unloading.force[::-1]).max() > 0.1 * np.abs(forces).max()
    np.testing.assert_allclose(path.force, forces, atol=1e-3 * np.abs(forces).max())


@given(st.lists(st.just(0.0) | st.floats(1e-3, 0.3), min_size=1, max_size=6), st.sampled_from(["free", "periodic"]))
def test_whatever_the_loads_heights_are_lost_for_good(parts, boundary):
    problem = press_rough(boundary, (16, 12), seed=7, solver="auto")
    loads = [0.05 * HARDNESS, *(part * HARDNESS for part in parts)]
    path = problem.path(pressure=loads)
    lost = [state.added[0].memory[0]["flattened_height"] for state in path]
    for before, after in itertools.pairwise(lost):
        assert (after - before).min() >= 0.0
    for state, load in zip(path, loads, strict=True):
        assert state.mean_pressure == pytest.approx(load, rel=1e-9, abs=1e-300)
        assert state.certificate.error <= 2e-5
        assert state.pressure.max() <= HARDNESS


def test_a_path_comes_back_from_its_file(tmp_path):
    path = press_rough("periodic", seed=6).path(pressure=[0.2 * HARDNESS, 0.0, 0.1 * HARDNESS])
    path.save(tmp_path / "path.npz")
    again = rc.load(tmp_path / "path.npz")
    assert again.increments == path.increments
    assert str(again) == str(path)
    for one, other in zip(path, again, strict=True):
        np.testing.assert_array_equal(one.pressure, other.pressure)
        np.testing.assert_array_equal(one.gap, other.gap)
    again.verify()


@pytest.mark.parametrize("kind", ["flattening", "wear", "relaxation"])
def test_a_path_goes_on_from_its_file(kind, tmp_path):
    """Times and distances count from the start; loads of another kind may follow."""
    material = {"relaxation": rc.Viscoelastic([2e8, 8e8], [1.0], 0.0)}.get(kind, SOFT)
    laws = rc.Archard(1e-13) if kind == "wear" else ()
    problem = press_rough("free", seed=8, material=material, laws=laws, solver="auto")
    passed = {"wear": "sliding", "relaxation": "time"}.get(kind)

    def along(values):
        return {} if passed is None else {passed: values}

    whole = problem.path(pressure=[2e6, 3e6, 1e6], **along([0.0, 1.0, 2.0]))
    problem.path(pressure=[2e6, 3e6], **along([0.0, 1.0])).save(tmp_path / "path.npz")
    found = rc.load(tmp_path / "path.npz").extend(pressure=1e6, **along([2.0]))
    np.testing.assert_allclose(found[-1].pressure, whole[-1].pressure, atol=0.01 * whole[-1].pressure.max())
    assert found[-1].approach == pytest.approx(whole[-1].approach, rel=1e-3)
    if passed is not None:
        with pytest.raises(rc.InputError, match="count from its start"):
            found.extend(pressure=1e6, **along([1.0]))
    held = found.extend(approach=found[-1].approach, **along([2.0]))
    assert held[-1].force == pytest.approx(found[-1].force, rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"force": [1.0, -1.0]}, "at least 0"),
        ({"force": [0.0, 1.0]}, "above 0"),
        ({"force": [1.0], "substeps": 2}, "friction"),
        ({"force": [1.0], "tangential_force": [(1.0, 0.0)]}, "friction"),
        ({"force": 1.0, "sliding": ["0m", "1m"]}, "Nothing changes with the sliding distance"),
        ({"force": 1.0, "time": ["0s", "1s"], "friction": 0.3, "tangential_force": [(1, 0)]}, "where bodies slide"),
        ({"force": [1.0, 2.0, 3.0], "sliding": ["0m", "1m"]}, "one value for each place"),
        ({"force": 1.0, "time": ["1s", "0s"]}, "not fall"),
        ({"force": 1.0, "time": "1s"}, "a list"),
        ({"force": [1.0], "accuracy": 0.0}, "above 0"),
    ],
)
def test_what_does_not_fit_gets_a_sentence(arguments, said):
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(ball, grid=rc.Grid((16, 16), 100e-6))
    with pytest.raises(rc.InputError, match=said):
        problem.path(**arguments)
