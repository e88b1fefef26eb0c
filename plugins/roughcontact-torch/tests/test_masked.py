"""The masked solver: certified, the contact of the default solver, at its cost, and hardly a number for the host."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from roughcontact.solving import make_task
from roughcontact.testing import claims
from roughcontact.typing import Load

from roughcontact_torch import MaskedConjugateGradient, TorchFFT, masked, solve_at_once
from roughcontact_torch.graph import GraphedIteration
from roughcontact_torch.masked_grid import MaskedGrid
from test_contact import SMALL_PROBLEMS, STEEL, _Waits, assert_same_small_contact, problem

DEVICES = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]
FREE_PERIODIC = ("free", "periodic")
PLASTIC = rc.ElasticPerfectlyPlastic(1e9, 0.3, 8e7)


def tensors(device="cpu", **parts):
    return {"convolver": TorchFFT(device), "solver": MaskedConjugateGradient(**parts)}


def assert_same_contact(parts, load, device="cpu", cells=2):
    """The certificate is once more that of numpy's transforms: `verify` recomputes it."""
    reference, ours = problem(**parts), problem(**parts, **tensors(device))
    expected, found = (one.solve(**load, tolerance=1e-8) for one in (reference, ours))
    assert found.status is rc.Status.CONVERGED
    reference.verify(found)
    assert np.abs(found.pressure - expected.pressure).max() < 1e-4 * expected.pressure.max()
    assert np.count_nonzero(found.contact != expected.contact) <= cells
    assert found.approach == pytest.approx(expected.approach, rel=1e-6)
    return found


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("boundary", ["periodic", "free", "wrapped", FREE_PERIODIC, FREE_PERIODIC[::-1]], ids=str)
@pytest.mark.parametrize("material", [STEEL, PLASTIC], ids=["elastic", "plastic"])
def test_load_and_approach(device, boundary, material):
    parts = {"boundary": boundary, "material": material}
    found = assert_same_contact(parts, {"pressure": 1e7}, device)
    assert found.saturated.any() == (material is PLASTIC)
    assert_same_contact(parts, {"approach": 0.7 * found.approach}, device)


@pytest.mark.parametrize("boundary", ["periodic", "free", FREE_PERIODIC], ids=str)
@pytest.mark.parametrize(
    ("shape", "size"), [((128, 16), (128.0, 16.0)), ((45, 63), (45.0, 189.0)), ((37, 96), (37.0, 32.0))]
)
def test_any_domain_and_its_mirror_image(boundary, shape, size):
    """Domains of 8 to 1, cells of 1 to 3 and their transposes; odd and composite numbers of cells."""
    heights = np.random.default_rng(3).normal(size=shape)

    def solve(values, size, boundary, **parts):
        body = rc.Body(rc.HeightMap(values, size=size, periodic=True), STEEL)
        return rc.ContactProblem(body, boundary=boundary, **parts).solve(pressure=2e7, tolerance=1e-8)

    turned = boundary[::-1] if isinstance(boundary, tuple) else boundary
    expected = solve(heights, size, boundary)
    found = solve(heights, size, boundary, **tensors())
    mirrored = solve(heights.T, size[::-1], turned, **tensors())
    assert found.status is mirrored.status is rc.Status.CONVERGED
    peak = expected.peak_pressure().value
    for one in (found.pressure, mirrored.pressure.T):
        assert np.abs(one - expected.pressure).max() < 1e-5 * peak


def test_contact_at_the_border_of_a_free_domain():
    tilted = rc.HeightMap(np.add.outer(np.linspace(0.0, 3.0, 64), np.zeros(64)), size=(64.0, 64.0))
    found = assert_same_contact({"surface": tilted, "boundary": "free"}, {"pressure": 2e6})
    assert found.contact[-1].all()


@pytest.mark.parametrize(
    ("pressure", "material"), [(1.4e8, STEEL), (4e8, STEEL), (8e7, PLASTIC), (0.99999 * 8e7, PLASTIC), (1e-3, STEEL)]
)
def test_nearly_full_full_saturated_and_light_contact(pressure, material):
    found = assert_same_contact({"n": 128, "material": material}, {"pressure": pressure})
    if material is STEEL and pressure == 4e8:
        assert found.contact.all()
        assert found.iterations == 0


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("part", [1e-3, 1e-9])
def test_an_approach_that_is_small_beside_the_heights(boundary, part):
    height = problem().initial_gap.max()
    found = assert_same_contact({"boundary": boundary}, {"approach": part * height})
    assert found.contact.any()


def test_points_that_were_not_measured_carry_nothing():
    heights = np.random.default_rng(0).normal(size=(64, 64))
    heights[10:20, 30:50] = np.nan
    surface = rc.HeightMap(heights, size=(64.0, 64.0), periodic=True)
    found = assert_same_contact({"surface": surface}, {"pressure": 1e8})
    assert not found.contact[10:20, 30:50].any()


@given(*SMALL_PROBLEMS)
@settings(max_examples=40, deadline=None)
def test_any_small_problem(seed, shape, boundary, load, limited):
    assert_same_small_contact(seed, shape, boundary, load, limited, **tensors())


class _OnTensors(rc.Solver):
    """The masked solver on tensors, whatever the convolver."""

    tolerance = 1e-8

    def solve(self, convolution, task):
        setup = convolution.setup
        prepared = TorchFFT("cpu").prepare(setup.kernel, setup.grid, setup.boundary)
        return MaskedConjugateGradient(self.tolerance).solve(prepared, task)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["conditions of contact", "bounds", "powers of two change no bit"])
def test_it_conforms(name):
    (claim,) = (one for one in claims("solver") if one.name == name)
    claim.check(_OnTensors())


def rough(n, boundary, shortest, limit=None):
    """Return a contact of docs/trust/solver_cost.md."""
    surface = rc.SelfAffineSurface(
        hurst=0.8, rms_slope=0.1, shortest=float(shortest), longest=float(n), rolloff=n / 8, seed=0
    )
    material = rc.Elastic(1.0, 0.0) if limit is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, limit)
    return {"surface": surface, "n": n, "material": material, "boundary": boundary}


@pytest.mark.parametrize("n", [128, 256, pytest.param(512, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("boundary", "shortest", "load"),
    [("periodic", 8, 0.05), ("periodic", 8, 0.2), ("periodic", 8, 1.0), ("periodic", 2, 0.2), ("free", 8, 0.05)],
)
def test_it_takes_hardly_more_products_than_the_default_solver(n, boundary, shortest, load):
    parts = rough(n, boundary, shortest)
    expected, found = (problem(**parts, **ours).solve(pressure=0.1 * load) for ours in ({}, tensors()))
    assert found.status is rc.Status.CONVERGED
    assert found.convolutions <= expected.convolutions + 4
    assert abs(np.count_nonzero(found.contact) - np.count_nonzero(expected.contact)) <= 4


@pytest.mark.parametrize("load", ["pressure", "approach"])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("material", [STEEL, PLASTIC], ids=["elastic", "plastic"])
def test_an_iteration_reads_no_number(load, boundary, material):
    """Tensors of the device `meta` have shapes alone: a number of theirs cannot be read."""
    ours = problem(boundary=boundary, material=material, **tensors())
    task = make_task(ours.plan, ours.initial_gap, Load.of(**{load: 1e7 if load == "pressure" else 0.5}))
    (descent, *_) = masked._make_descents(ours.convolution, [task])
    descent = attrs.evolve(descent, grid=_without_values(descent.grid), **_parts_without_values(descent))
    blocks = _without_values(descent.grid.blocks(0.1))
    pressure = torch.empty_like(descent.initial_gap)
    state, _ = descent.start(pressure, descent.grid.displace(pressure))
    for _ in range(2):
        state = descent.iterate(state, blocks)
    state, violations = descent.verify(descent.renew(state))
    assert state.pressure.shape == (1, 64, 64)
    assert state.pressure.device.type == "meta"
    with pytest.raises(RuntimeError):
        float(violations.error)


def _without_values(part):
    return attrs.evolve(part, **_parts_without_values(part))


def _parts_without_values(part):
    values = ((field.name, getattr(part, field.name)) for field in attrs.fields(type(part)))
    return {name: value.to("meta") for name, value in values if isinstance(value, torch.Tensor)}


@pytest.mark.parametrize(
    "parts", [{}, {"boundary": "free"}, {"material": PLASTIC}, {"boundary": FREE_PERIODIC}], ids=str
)
def test_the_host_reads_once_in_four_iterations_and_once_on_each_grid(parts, monkeypatch):
    ours = problem(n=128, **parts, **tensors())
    task = make_task(ours.plan, ours.initial_gap, Load.of(pressure=1e7))
    ours.plan.solver.solve(ours.convolution, task)
    readings = []
    read = MaskedGrid.read
    monkeypatch.setattr(
        MaskedGrid, "read", lambda grid, *numbers: readings.append(len(numbers)) or read(grid, *numbers)
    )
    with _Waits() as waits:
        solved = ours.plan.solver._solve(ours.convolution, [task])
    assert waits.count == 0
    grids = {level.shape for level in solved.levels}
    assert len(readings) - len(grids) <= solved.levels[-1].iterations / 4
    assert len(grids) == 3


def test_loads_that_are_solved_at_once_are_those_that_are_solved_alone():
    ours = problem(**tensors())
    pressures = [1e5, 1e6, 2e7, 4e8]
    found = solve_at_once(ours, pressures)
    for load, one in zip(pressures, found, strict=True):
        expected = ours.solve(pressure=load)
        assert one.status is rc.Status.CONVERGED
        assert one.mean_pressure == pytest.approx(load, rel=1e-12)
        assert np.abs(one.pressure - expected.pressure).max() < 1e-3 * expected.pressure.max()
        assert np.count_nonzero(one.contact != expected.contact) <= 2
        assert one.origin.load == {"pressure": load}
        ours.verify(one)


def test_surfaces_that_are_solved_at_once():
    surfaces = [rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=32.0, seed=k) for k in range(3)]
    materials = [STEEL, PLASTIC, rc.Elastic(2e9, 0.1)]
    problems = [problem(one, material=other, **tensors()) for one, other in zip(surfaces, materials, strict=True)]
    found = solve_at_once(problems, [1e7] * 3)
    for ours, one in zip(problems, found, strict=True):
        expected = ours.solve(pressure=1e7)
        assert np.abs(one.pressure - expected.pressure).max() < 1e-3 * expected.pressure.max()
        ours.verify(one)


GEOMETRIES = [
    ((128, 16), (128.0, 16.0)),
    ((16, 128), (16.0, 128.0)),
    ((40, 40), (40.0, 120.0)),
    ((40, 40), (120.0, 40.0)),
    ((37, 37), (37.0, 37.0)),
    ((45, 63), (63.0, 45.0)),
]


@given(
    st.integers(0, 10**6),
    st.sampled_from(GEOMETRIES),
    st.sampled_from([*rc.Boundary]),
    st.lists(st.floats(-3.0, 0.3), min_size=2, max_size=4),
    st.booleans(),
)
@settings(max_examples=30, deadline=None)
def test_contacts_that_are_solved_at_once_on_any_domain(seed, geometry, boundary, loads, own_surfaces):
    shape, size = geometry
    random = np.random.default_rng(seed)
    body = rc.Body(rc.HeightMap(random.normal(size=shape), size=size, periodic=True), rc.Elastic(1.0, 0.0))
    parts = {"boundary": boundary, **tensors(tolerance=1e-8)}
    first = rc.ContactProblem(body, **parts)
    problems = [first] * len(loads)
    if own_surfaces:
        maps = (rc.HeightMap(random.normal(size=shape), size=size, periodic=True) for _ in loads)
        problems = [rc.ContactProblem(rc.Body(one, rc.Elastic(1.0, 0.0)), **parts) for one in maps]
    pressures = [10.0**load for load in loads]
    singles = [one.solve(pressure=load) for one, load in zip(problems, pressures, strict=True)]
    found = solve_at_once(problems if own_surfaces else first, pressures)
    for expected, one in zip(singles, found, strict=True):
        assert one.status.success
        assert abs(np.count_nonzero(one.contact) - np.count_nonzero(expected.contact)) <= 1
        assert np.abs(one.pressure - expected.pressure).max() < 1e-5 * expected.pressure.max()
    if all(one.status is rc.Status.CONVERGED for one in (*singles, *found)):
        # All go on until the last one is solved.
        assert {one.iterations for one in found} == {found[0].iterations}
        assert abs(found[0].iterations - max(one.iterations for one in singles)) <= 4


def test_what_cannot_be_solved_at_once_is_refused_in_words():
    ours = problem(**tensors())
    others = [problem(n=32, **tensors()), problem(boundary="free", **tensors()), problem(**tensors(tolerance=1e-8))]
    for other in others:
        with pytest.raises(rc.InputError, match="the same cells, boundary"):
            solve_at_once([ours, other], [1e7, 1e7])
    with pytest.raises(rc.InputError, match="a pressure each"):
        solve_at_once([ours], [1e7, 2e7])
    with pytest.raises(rc.InputError, match="masked solver on tensors"):
        solve_at_once(problem(convolver="torch"), [1e7])
    with pytest.raises(rc.InputError, match="more than the bodies can carry"):
        solve_at_once(problem(material=PLASTIC, **tensors()), [1e7, 9e7])


def test_numpys_arrays_are_refused_in_words():
    with pytest.raises(rc.InputError, match="choose convolver='torch'"):
        problem(solver=MaskedConjugateGradient()).solve(pressure=1e7)


def test_a_limit_that_differs_from_cell_to_cell_is_left_to_the_default_solver():
    limit = np.where(np.add.outer(np.arange(64), np.arange(64)) % 2, 8e7, 6e7)
    material = rc.ElasticPerfectlyPlastic(1e9, 0.3, limit)
    expected, found = (problem(material=material, **parts).solve(pressure=1e7) for parts in ({}, tensors()))
    assert np.abs(found.pressure - expected.pressure).max() < 1e-4 * expected.pressure.max()


def test_the_default_solver_continues():
    found = problem(**tensors(max_iterations=1)).solve(pressure=1e7, tolerance=1e-10)
    assert found.status is rc.Status.RESCUED
    problem().verify(found)


def test_a_start_near_the_solution_saves_products():
    ours = problem(**tensors())
    first = ours.solve(pressure=1e7)
    assert ours.solve(pressure=1.01e7, start=first.pressure).convolutions < first.convolutions


def test_steps_are_reported():
    steps = []
    found = problem(**tensors()).solve(pressure=1e7, on_step=steps.append)
    assert [step.error for step in steps] == list(found.errors)
    assert steps[-1].iteration == found.iterations


def test_it_has_a_name_and_explains_itself():
    assert rc.solvers.create("masked") == MaskedConjugateGradient()
    assert "lists of active cells" in problem(convolver="torch", solver="masked").explain()


@pytest.mark.parametrize("control", ["pressure", "approach"])
@pytest.mark.parametrize("boundary", ["free", FREE_PERIODIC, FREE_PERIODIC[::-1]], ids=str)
@pytest.mark.parametrize(
    ("shape", "size", "center"),
    [
        ((256, 256), (1e-3, 1e-3), (2e-4, -1e-4)),
        ((256, 64), (2e-3, 2.5e-4), (-9.9e-4, 0.0)),
        ((135, 192), (5e-4, 2e-3), (0, 0)),
    ],
    ids=["square", "at the border, 8 to 1", "odd, cells of 1 to 3"],
)
def test_only_the_cells_that_can_touch_are_solved(shape, size, center, boundary, control):
    body = rc.Body(rc.ParaboloidSurface(1e-2, center=center), rc.Elastic(1e11, 0.3))
    whole = rc.ContactProblem(body, grid=rc.Grid(shape, size), boundary=boundary)
    load = {"force": 0.5} if control == "pressure" else {"approach": 5e-8}
    expected, found = (attrs.evolve(whole, **parts).solve(**load, tolerance=1e-8) for parts in ({}, tensors()))
    assert found.status is rc.Status.CONVERGED
    assert max(np.prod(level.shape) for level in found.levels) < 0.7 * np.prod(shape)
    whole.verify(found)
    assert np.abs(found.pressure - expected.pressure).max() < 1e-4 * expected.pressure.max()
    assert found.approach == pytest.approx(expected.approach, rel=1e-6)


def started(load):
    """The descent on the finest grid of a small contact, its first state and its blocks."""
    ours = problem(boundary="free", material=PLASTIC, **tensors())
    task = make_task(ours.plan, ours.initial_gap, Load.of(**{load: 1e7 if load == "pressure" else 0.5}))
    (descent, *_) = masked._make_descents(ours.convolution, [task])
    pressure = torch.full_like(descent.initial_gap, task.mean_pressure or 0.0)
    state, _ = descent.start(pressure, descent.grid.displace(pressure))
    return descent, state, descent.grid.blocks(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("load", ["pressure", "approach"])
def test_the_compiler_takes_an_iteration_whole(load):
    descent, state, blocks = started(load)
    compiled = torch.compile(descent.iterate, backend="eager", fullgraph=True)(state, blocks)
    for one, other in zip(compiled, descent.iterate(state, blocks), strict=True):
        assert torch.equal(one, other)


@pytest.mark.parametrize("load", ["pressure", "approach"])
def test_an_iteration_in_place_is_the_iteration(load):
    """What a CUDA graph replays, here by the processor: the same memory at each iteration, checks between."""
    descent, state, blocks = started(load)
    done = []

    def record(work):
        work()
        return lambda: done.append(work())

    in_place = GraphedIteration(lambda one: descent.iterate(one, blocks), record)
    found = state
    places = set()
    for k in range(6):
        state = descent.iterate(state, blocks)
        found = in_place(found)
        places.add(tuple(value.data_ptr() for value in found))
        for one, other in zip(found, state, strict=True):
            assert torch.equal(one, other)
        if k == 2:
            state, found = (descent.renew(descent.verify(one)[0]) for one in (state, found))
    assert len(places) == 1
    assert len(set(*places)) == len(state)
    assert len(done) == 6


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
@pytest.mark.parametrize("load", [{"pressure": 1e7}, {"approach": 0.5}], ids=str)
def test_a_compiled_iteration_is_replayed_on_a_gpu(load):
    eager, compiled = (problem(n=128, **tensors("cuda", compiled=compiled)) for compiled in (False, True))
    expected = eager.solve(**load)
    for found in (compiled.solve(**load), compiled.solve(**load)):
        assert found.status is rc.Status.CONVERGED
        assert found.iterations == expected.iterations
        assert np.abs(found.pressure - expected.pressure).max() < 1e-4 * expected.pressure.max()
