"""Contacts whose body flows below its surface: closed forms, invariance, conditions, energy, and refusals."""

import math

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.typing import LoadIncrement

from roughcontact_volume import LinearHardening, Plastic, PlasticFlow, SwiftHardening, VolumeOperators
from roughcontact_volume.box import count_layers, find_yield_depth, list_layers
from roughcontact_volume.forecast import make_elastic

YOUNG, POISSON, LIMIT, RADIUS = 210e9, 0.3, 1e9, 1e-3
MODULUS = YOUNG / (1.0 - POISSON**2)
# Johnson, Contact Mechanics, section 6.2: a ball yields first at a maximum pressure of 1.60 Y, at a depth of 0.48 a.
FIRST_RADIUS = np.pi * 1.6 * LIMIT * RADIUS / (2.0 * MODULUS)
FIRST_FORCE = 2.0 / 3.0 * np.pi * FIRST_RADIUS**2 * 1.6 * LIMIT


def make_ball(cells=15, width=6.0, hardening="4GPa", *, of="counterbody", centre=(0.0, 0.0), **others):
    """Return a rigid ball on a flat that flows, on a grid of a width in radii of the contact at first yield."""
    accuracy = others.pop("accuracy", 0.1)
    flat = rc.Body(rc.FlatSurface(), Plastic(YOUNG, POISSON, LIMIT, hardening, accuracy=accuracy))
    ball = rc.Body(rc.ParaboloidSurface(RADIUS, center=centre), rc.Rigid())
    grid = others.pop("grid", rc.Grid((cells, cells), width * FIRST_RADIUS))
    return rc.ContactProblem(*((ball, flat) if of == "counterbody" else (flat, ball)), grid=grid, **others)


def read(state):
    """Return what the process of a state remembers."""
    return state.added[0].memory[0]


def numbers(state):
    return {name: value for name, (value, _) in state.added[0].numbers.items()}


@pytest.fixture(scope="module")
def path():
    """A ball that is pressed, unloaded and pressed again."""
    return make_ball().path(force=[5.0 * FIRST_FORCE, 2.0 * FIRST_FORCE, 0.0, 5.0 * FIRST_FORCE])


class TestFirstYield:
    def test_below_it_the_contact_is_the_elastic_one(self):
        problem = make_ball(cells=31, width=2.6)
        elastic = attrs.evolve(problem, counterbody=rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, POISSON)), laws=())
        found = problem.solve(force=0.9 * FIRST_FORCE)
        assert not read(found)["accumulated_strain"].any()
        assert found.pressure == pytest.approx(elastic.solve(force=0.9 * FIRST_FORCE).pressure, abs=3e-4 * LIMIT)
        assert found.certificate["plastic flow"].residual == 0.0

    def test_is_at_its_depth_and_pressure(self):
        problem = make_ball(cells=31, width=2.6)
        found = problem.solve(force=1.1 * FIRST_FORCE)
        strain = read(found)["accumulated_strain"]
        layer, x, y = np.unravel_index(strain.argmax(), strain.shape)
        layers = list_layers(problem.plan.grid, len(strain))
        top, bottom = np.cumsum(layers)[layer] - layers[layer], np.cumsum(layers)[layer]
        radius = FIRST_RADIUS * 1.1 ** (1.0 / 3.0)
        assert top < 0.48 * radius < bottom
        assert (x, y) == (15, 15)
        assert found.pressure.max() == pytest.approx(1.6 * LIMIT * 1.1 ** (1.0 / 3.0), rel=0.02)


class TestForecast:
    def test_says_the_box_that_the_solve_takes(self):
        problem = make_ball(accuracy=1.0)
        found = problem.solve(force=2.0 * FIRST_FORCE)
        rows = problem.explain(force=2.0 * FIRST_FORCE).splitlines()[-2:]
        layers = read(found)["accumulated_strain"].shape[0]
        depth = list_layers(problem.plan.grid, layers).sum()
        assert rows[0].startswith(f"box        {layers} layers to {depth * 1e6:.4g} µm at force")
        assert rows[1].startswith("flow       about 10 stresses")
        plan = problem.explain(force=2.0 * FIRST_FORCE)
        assert f"{plan.memory / 2**20:.3g} MiB" in rows[0]
        # One strain of the box at least.
        assert plan.memory > 8 * 6 * layers * problem.plan.grid.cells
        assert plan.seconds > 0.0

    def test_of_loads_that_do_not_flow_or_are_refused(self):
        plan = make_ball().explain(force=0.5 * FIRST_FORCE)
        assert "stays below the yield stress" in plan
        assert plan.memory == 0.0
        assert "box        refused: A wrapped" in make_ball(boundary="wrapped").explain(force=FIRST_FORCE)
        assert "name a load" in make_ball().explain()
        assert math.isnan(make_ball().explain().memory)


class TestLoading:
    def test_unloading_is_elastic(self, path):
        first, half, rest, _ = map(read, path)
        for state in (half, rest):
            assert np.array_equal(state["plastic_strain"], first["plastic_strain"])
            assert not state["last_flow"].any()
        assert path[2].force == 0.0
        assert path[2].approach == pytest.approx(first["imprint"].max(), rel=0.05)

    def test_second_loading_adds_no_strain(self, path):
        first, again = path[0], path[3]
        assert np.array_equal(read(again)["accumulated_strain"], read(first)["accumulated_strain"])
        assert again.pressure == pytest.approx(first.pressure, abs=1e-4 * LIMIT)
        assert again.approach == pytest.approx(first.approach, rel=1e-5)

    def test_a_contact_flows_to_less_pressure_and_a_wider_area(self, path):
        elastic = 1.6 * LIMIT * 5.0 ** (1.0 / 3.0)
        assert path[0].pressure.max() < 0.85 * elastic
        assert numbers(path[2])["pile_up"] > 0.0
        # Published for this ball (Kogut, Etsion, J. Appl. Mech. 69 (2002) 657): F = 1.03 w^1.425.
        approach = FIRST_RADIUS**2 / RADIUS
        assert path[0].force / FIRST_FORCE == pytest.approx(1.03 * (path[0].approach / approach) ** 1.425, rel=0.05)

    def test_loads_of_every_kind_lead_to_the_same_state(self, path):
        problem = make_ball()
        by_pressure = problem.solve(pressure=path[0].mean_pressure)
        assert by_pressure.pressure == pytest.approx(path[0].pressure, abs=1e-4 * LIMIT)
        by_approach = problem.solve(approach=path[0].approach)
        assert "step_error_of_approach" not in numbers(by_approach)
        assert numbers(by_approach)["step_error_of_force"] > 0.0
        # Its steps are equal in approach.
        assert by_approach.force == pytest.approx(path[0].force, rel=0.01)

    def test_substeps_state_their_error(self):
        force = 5.0 * FIRST_FORCE
        coarse, fine = (make_ball(cells=11, width=5.0, accuracy=one).solve(force=force) for one in (0.5, 0.02))
        stated = numbers(coarse)
        assert "step_error_of_force" not in stated
        for error, one, other in (
            (stated["step_error_of_approach"], coarse.approach, fine.approach),
            (stated["step_error_of_maximum_pressure"], coarse.pressure.max(), fine.pressure.max()),
            (stated["step_error_of_imprint"], numbers(coarse)["imprint_depth"], numbers(fine)["imprint_depth"]),
        ):
            assert abs(one - other) < 1.5 * error

    def test_work_of_a_cycle_is_plastic_work_and_what_is_left_in_the_residual_stress(self):
        deepest = 6.0 * FIRST_RADIUS**2 / RADIUS
        up = np.linspace(0.0, deepest, 8)[1:]
        problem = make_ball(cells=13, width=7.0, accuracy=1.0)
        loading = problem.path(approach=up)
        down = np.linspace(deepest, 0.0, 17)[1:]
        unloading = loading.extend(approach=down)
        approach = np.append(0.0, unloading.approach)
        force = np.append(0.0, unloading.force)
        lost = np.trapezoid(force, approach)
        found = numbers(unloading[-1])
        assert lost == pytest.approx(found["plastic_work"] + found["residual_energy"], rel=0.03)
        assert 0.02 < found["residual_energy"] / found["plastic_work"] < 0.5


class TestConditions:
    def test_judging_ones_are_small(self, path):
        for state in path:
            conditions = {one.name: one for one in state.certificate.conditions}
            assert conditions["plastic flow"].judges
            assert conditions["plastic flow"].residual < 2e-4
            assert conditions["box"].residual == 0.0
            assert conditions["yield"].residual < 2e-4
            assert conditions["flow direction"].residual < 1e-6
            assert conditions["plastic volume strain"].residual < 1e-14

    def test_are_those_of_the_fields(self, path):
        state = path[0]
        memory = read(state)
        grid = state.grid
        layers = list_layers(grid, len(memory["accumulated_strain"]))
        operators = VolumeOperators(grid, rc.Boundary.FREE, layers, YOUNG, POISSON)
        xx, yy, zz, yz, xz, xy = operators.press(state.pressure) + operators.find_stress(memory["plastic_strain"])
        equivalent = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (yz**2 + xz**2 + xy**2))
        limit = LIMIT + 4e9 * memory["accumulated_strain"]
        assert equivalent.max() > LIMIT
        assert (equivalent / limit - 1.0).max() < 2e-4
        flowed = memory["last_flow"].any(axis=0)
        assert np.abs(equivalent / limit - 1.0)[flowed].max() < 2e-4
        # The gap is that of the surfaces with the imprint.
        assert memory["imprint"] == pytest.approx(operators.displace(memory["plastic_strain"]), abs=1e-15)
        plain = make_ball().initial_gap
        gap = plain + memory["imprint"] + state.displacement - state.approach
        assert gap == pytest.approx(state.gap, abs=1e-5 * state.approach)

    @pytest.mark.parametrize(
        ("change", "name"),
        [
            (lambda memory: memory | {"plastic_strain": 1.05 * memory["plastic_strain"]}, "plastic flow"),
            (lambda memory: memory | {"accumulated_strain": 0.9 * memory["accumulated_strain"]}, "yield"),
            (lambda memory: memory | {"last_flow": np.roll(memory["last_flow"], 1, axis=0)}, "flow direction"),
            (lambda memory: memory | {"plastic_strain": memory["plastic_strain"] + 1e-5}, "plastic volume strain"),
            (lambda memory: memory | {"accumulated_strain": memory["accumulated_strain"] + 1e-5}, "box"),
            (lambda memory: memory | {"accumulated_strain": memory["accumulated_strain"] + 1e-5}, "border"),
        ],
    )
    def test_see_what_is_wrong(self, path, change, name):
        state = path[0]
        law = state.added[0].laws[0]
        increment = LoadIncrement(rc.typing.Load("force", state.force))
        problem = make_ball()
        wrong = change(dict(read(state)))
        found = {one.name: one.residual for one in law.judge(problem, state, increment, wrong, wrong)}
        assert found[name] > 1e-3

    def test_hold_after_saving(self, path, tmp_path):
        path.save(tmp_path / "path.npz")
        again = rc.load(tmp_path / "path.npz")
        again.verify()
        assert np.array_equal(read(again[3])["plastic_strain"], read(path[3])["plastic_strain"])


class TestInvariance:
    @pytest.mark.parametrize("boundary", [("free", "free"), ("periodic", "periodic"), ("free", "periodic")])
    def test_transposed(self, boundary):
        force = 4.0 * FIRST_FORCE
        size = (5.0 * FIRST_RADIUS, 7.0 * FIRST_RADIUS)
        # Cells of about 1 : 3.
        one, other = (
            make_ball(grid=rc.Grid(shape, sides), boundary=words).solve(force=force)
            for shape, sides, words in (((21, 10), size, boundary), ((10, 21), size[::-1], boundary[::-1]))
        )
        strain = read(other)["plastic_strain"].swapaxes(-1, -2)[[1, 0, 2, 4, 3, 5]]
        assert read(one)["plastic_strain"] == pytest.approx(strain, abs=2e-4 * np.abs(strain).max())
        assert one.pressure == pytest.approx(other.pressure.T, abs=2e-4 * LIMIT)

    def test_moved_over_a_periodic_grid(self):
        cells = 14
        width = 6.0 * FIRST_RADIUS
        force = 4.0 * FIRST_FORCE
        heights = make_ball(cells, boundary="periodic").body.heights(rc.Grid((cells, cells), width))
        flat = make_ball().counterbody
        one, other = (
            rc.ContactProblem(
                rc.Body(rc.HeightMap(np.roll(heights, shift, axis=(0, 1)), width, periodic=True), rc.Rigid()),
                flat,
                boundary="periodic",
            ).solve(force=force)
            for shift in ((0, 0), (3, -5))
        )
        strain = np.roll(read(one)["plastic_strain"], (3, -5), axis=(-2, -1))
        assert read(other)["plastic_strain"] == pytest.approx(strain, abs=2e-4 * np.abs(strain).max())

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_same_bits_in_units_of_powers_of_two(self, boundary):
        force = 4.0 * FIRST_FORCE
        one = make_ball(boundary=boundary).solve(force=force)
        stress, length = 2.0**13, 2.0**-7
        flat = rc.Body(rc.FlatSurface(), Plastic(YOUNG * stress, POISSON, LIMIT * stress, 4e9 * stress, accuracy=0.1))
        ball = rc.Body(rc.ParaboloidSurface(RADIUS * length), rc.Rigid())
        grid = rc.Grid((15, 15), 6.0 * FIRST_RADIUS * length)
        other = rc.ContactProblem(ball, flat, grid=grid, boundary=boundary).solve(force=force * stress * length**2)
        assert np.array_equal(read(one)["plastic_strain"], read(other)["plastic_strain"])
        assert np.array_equal(read(one)["imprint"] * length, read(other)["imprint"])
        assert np.array_equal(one.pressure * stress, other.pressure)

    def test_the_body_flows_as_the_counterbody_does(self):
        one, other = (make_ball(of=of).solve(force=4.0 * FIRST_FORCE) for of in ("body", "counterbody"))
        assert np.array_equal(read(one)["plastic_strain"], read(other)["plastic_strain"])


class TestBox:
    def test_grows_with_the_load_and_keeps_what_it_has(self):
        path = make_ball(cells=13, width=12.0, accuracy=1.0).path(force=[2.0 * FIRST_FORCE, 16.0 * FIRST_FORCE])
        first, second = (read(state)["accumulated_strain"] for state in path)
        assert len(second) > len(first)
        assert np.all(second[: len(first)] >= first)
        assert not second[-1].any()

    def test_holds_a_flow_in_the_uppermost_layer_alone(self):
        # A single cell presses on a flat of long cells.
        heights = np.zeros((9, 8))
        heights[4, 4] = 1e-7
        peak = rc.Body(rc.HeightMap(heights, ("100um", "100um")), rc.Rigid())
        flat = rc.Body(rc.FlatSurface(), Plastic(YOUNG, 0.0, LIMIT, "4GPa", accuracy=1.0))
        found = rc.ContactProblem(peak, flat).solve(force=1.5 * LIMIT * (1e-4 / 8.0) * (1e-4 / 9.0))
        memory = read(found)
        assert len(memory["accumulated_strain"]) > 1
        assert memory["accumulated_strain"][0].any()
        assert found.certificate["plastic flow"].residual < 2e-4

    @pytest.mark.parametrize("load", [2.0, 10.0])
    def test_the_first_one_holds_a_flow(self, load):
        radius = FIRST_RADIUS * load ** (1.0 / 3.0)
        problem = make_ball(grid=rc.Grid((15, 15), 3.6 * radius), hardening=None)
        pressure = make_elastic(problem).solve(force=load * FIRST_FORCE).pressure
        depth = find_yield_depth(problem.grid, problem.boundary, problem.counterbody.material, pressure)
        found = read(problem.solve(force=load * FIRST_FORCE))["accumulated_strain"]
        assert len(found) == count_layers(problem.grid, depth)
        assert found[-4:].any()

    def test_a_deeper_one_changes_nothing(self, monkeypatch):
        force = 4.0 * FIRST_FORCE
        one = make_ball().solve(force=force)
        monkeypatch.setattr("roughcontact_volume.box._LOWEST_STRESS", 0.3)
        other = make_ball().solve(force=force)
        strain, deeper = read(one)["plastic_strain"], read(other)["plastic_strain"]
        assert deeper.shape[1] > strain.shape[1]
        assert deeper[:, : strain.shape[1]] == pytest.approx(strain, abs=3e-4 * np.abs(strain).max())

    def test_a_shallow_one_grows_by_itself(self, monkeypatch):
        force = 4.0 * FIRST_FORCE
        one = make_ball().solve(force=force)
        monkeypatch.setattr("roughcontact_volume.box._LOWEST_STRESS", 1.35)
        other = make_ball().solve(force=force)
        strain, grown = read(one)["plastic_strain"], read(other)["plastic_strain"]
        assert not grown[:, -1].any()
        common = min(strain.shape[1], grown.shape[1])
        assert grown[:, :common] == pytest.approx(strain[:, :common], abs=1e-3 * np.abs(strain).max())


class TestPasses:
    def test_strain_falls_from_pass_to_pass_in_the_frame_of_the_body(self):
        # A ball rolls along a track, again and again.
        grid = rc.Grid((24, 12), (9.6 * FIRST_RADIUS, 4.8 * FIRST_RADIUS))
        track = [(cells, 0) for cells in (-4, -2, 0, 2, 4)]
        shifts = 3 * track
        path = make_ball(grid=grid, of="body", boundary="periodic", hardening=None).path(
            force=3.0 * FIRST_FORCE, shift=shifts
        )
        after = [read(path[5 * number + 4])["accumulated_strain"] for number in range(3)]
        layers = len(after[-1])
        deep = [np.pad(one, ((0, layers - len(one)), (0, 0), (0, 0)))[:, 10:14] for one in after]
        new = [float((two - one).max()) for one, two in zip([np.zeros_like(deep[0]), *deep], deep, strict=False)]
        assert new[0] > 3.0 * new[1] > 6.0 * new[2] > 0.0

    def test_a_counterbody_keeps_its_strain_in_its_own_frame(self):
        grid = rc.Grid((16, 12), (6.4 * FIRST_RADIUS, 4.8 * FIRST_RADIUS))
        force = 3.0 * FIRST_FORCE
        common = {"grid": grid, "boundary": "periodic"}
        body = make_ball(of="body", **common).path(force=force, shift=[(0, 0), (3, 1)])
        counterbody = make_ball(of="counterbody", **common).path(force=force, shift=[(0, 0), (-3, -1)])
        strain = read(body[1])["plastic_strain"]
        assert read(counterbody[1])["plastic_strain"] == pytest.approx(strain, abs=3e-4 * np.abs(strain).max())
        assert np.abs(read(body[1])["imprint"] - read(body[0])["imprint"]).max() > 0.3 * read(body[0])["imprint"].max()


class TestRefusals:
    @pytest.mark.parametrize(
        ("make", "sentence"),
        [
            (
                lambda problem: attrs.evolve(
                    problem,
                    body=attrs.evolve(problem.body, material=rc.ElasticPerfectlyPlastic(210e9, 0.3, 5e9)),
                ),
                "count its flow twice",
            ),
            (
                lambda problem: attrs.evolve(
                    problem, body=attrs.evolve(problem.body, material=rc.Viscoelastic((1e9, 1e9), (1.0,), 0.3))
                ),
                "relaxation",
            ),
            (lambda problem: attrs.evolve(problem, laws=rc.Archard("1e-16m2/N")), "other laws"),
            (lambda problem: attrs.evolve(problem, boundary="wrapped"), "wrapped"),
            (lambda problem: attrs.evolve(problem, adhesion=rc.Exponential(work=0.05, range=2e-9)), "adhesion"),
        ],
    )
    def test_what_is_not_solved_with_it(self, make, sentence):
        with pytest.raises(rc.InputError, match=sentence):
            make(make_ball()).solve(force=FIRST_FORCE)

    def test_friction_along_a_path(self):
        with pytest.raises(rc.InputError, match="tractions of friction"):
            make_ball().path(force=FIRST_FORCE, displacement=[(1e-9, 0.0)], friction=0.3)

    def test_a_load_that_yields_the_bulk(self):
        wave = rc.Body(rc.WavySurface("1um", "100um"), rc.Rigid())
        flat = rc.Body(rc.FlatSurface(), Plastic(YOUNG, POISSON, "100MPa"))
        problem = rc.ContactProblem(wave, flat, grid=rc.Grid((16, 16), "100um"), boundary="periodic")
        with pytest.raises(rc.InputError, match="yields the bulk"):
            problem.solve(pressure="1GPa")

    def test_a_flow_that_is_not_found(self, monkeypatch):
        monkeypatch.setattr("roughcontact_volume.step._MAX_EVALUATIONS", 2)
        found = make_ball().solve(force=5.0 * FIRST_FORCE, throw=False)
        assert not found.status.success
        assert not found.certificate["plastic flow"].holds
        assert "not converged" in str(found.area())
        with pytest.raises(rc.NotConverged, match="plastic flow"):
            make_ball().solve(force=5.0 * FIRST_FORCE)

    def test_a_side_of_another_name(self):
        with pytest.raises(rc.InputError, match="The body that flows"):
            PlasticFlow("left")


@pytest.mark.slow
def test_ball_against_finite_elements():
    # Axisymmetric elements of 1/24 of the radius and 8 substeps: F = 10.07 at w = 5, 1.095 unloaded to w = 2, in units
    # of first yield; residual stress on the axis -0.42 Y.
    approach = FIRST_RADIUS**2 / RADIUS
    flat = rc.Body(rc.FlatSurface(), Plastic(200.0 * LIMIT, POISSON, LIMIT, 4.0 * LIMIT, accuracy=0.005))
    scale = YOUNG / (200.0 * LIMIT)
    radius = FIRST_RADIUS * scale
    ball = rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid())
    problem = rc.ContactProblem(ball, flat, grid=rc.Grid((37, 37), 37 * 2.42 * radius / 8.0))
    places = np.array([1.0, 2.0, 3.0, 5.0, 2.0, 0.0, 5.0])
    path = problem.path(approach=places * approach * scale**2)
    force = path.force / (FIRST_FORCE * scale**2)
    assert force == pytest.approx([1.0, 2.778, 4.946, 10.07, 1.095, 0.0, 10.07], rel=0.02)
    assert force[3] == pytest.approx(10.07, rel=0.004)
    assert np.array_equal(read(path[6])["accumulated_strain"], read(path[3])["accumulated_strain"])
    memory = read(path[5])["plastic_strain"]
    layers = list_layers(path[0].grid, memory.shape[1])
    residual = VolumeOperators(path[0].grid, rc.Boundary.FREE, layers, 200.0 * LIMIT, POISSON).find_stress(memory)
    assert residual[0, :, 18, 18].min() / LIMIT == pytest.approx(-0.42, abs=0.03)
    assert numbers(path[3])["plastic_strain"] == pytest.approx(0.00824, rel=0.02)


def test_hardening_bounds_the_strain():
    soft, hard = (
        numbers(make_ball(hardening=one).solve(force=5.0 * FIRST_FORCE))["plastic_strain"]
        for one in (LinearHardening(0.0), SwiftHardening(0.005, 0.5))
    )
    assert 0.0 < hard < 0.8 * soft


def test_conditions_take_the_stress_of_the_numbers(path, monkeypatch):
    state = path[3]
    law, memory = state.added[0].laws[0], read(state)
    products = []
    find_stress = VolumeOperators.find_stress
    monkeypatch.setattr(VolumeOperators, "find_stress", lambda *some: products.append(some) or find_stress(*some))
    increment = LoadIncrement(rc.typing.Load("force", state.force))
    for count in (1, 2):
        assert law.list_numbers(state, memory) == state.added[0].numbers
        found = {one.name: one for one in law.judge(make_ball(), state, increment, memory, memory)}
        assert found["plastic flow"] == state.certificate["plastic flow"]
        assert len(products) == count
