"""A physics of one's own is a value of a problem: laws that change the gap, and processes that remember.

A lubricant of given pressure presses the surfaces apart; wear takes the summits away, load by load.
"""

import itertools
import json
import pickle
from typing import ClassVar

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.__main__ import main

STEEL = rc.Elastic(young=210e9, poisson=0.3)
GRID = rc.Grid((32, 32), 100e-6)


@rc.laws.register("test-lubricant")
@attrs.frozen
class Lubricant(rc.Law):
    """A given pressure, Pa, wherever the fresh gap is wider than a bound, m."""

    pressure: float = attrs.field(metadata={"unit": "Pa"})
    wider: float = attrs.field(default=1e-6, metadata={"unit": "m"})

    def _act(self, initial_gap):
        return np.where(initial_gap > self.wider, self.pressure, 0.0)

    def change_gap(self, problem, increment, memory):
        return problem.displace(self._act(problem.initial_gap))

    def list_numbers(self, state, memory):
        carried = float(self._act(state.origin.scene.initial_gap).sum()) * state.grid.cell_area
        return {"lubricant_load": (carried, "N"), "share": rc.Estimate(carried / state.force, 0.0, "")}


@rc.laws.register("test-wear")
@attrs.frozen
class Wear(rc.Process):
    """Archard's law: each load wears the surfaces by a rate, m/Pa, times the pressure."""

    rate: float = attrs.field(metadata={"unit": ""})

    remembered: ClassVar = {"height_loss": ("height lost by wear", "m")}

    def change_gap(self, problem, increment, memory):
        return memory["height_loss"]

    def remember(self, state, increment, memory):
        return {"height_loss": memory["height_loss"] + self.rate * state.contact_pressure}

    def list_numbers(self, state, memory):
        return {"worn_volume": (float(memory["height_loss"].sum()) * state.grid.cell_area, "m3")}

    def list_conditions(self, state, memory):
        # Archard: the volume of the last load is the rate times the force.
        rest = memory["height_loss"] - state.added[0].before[0]["height_loss"] if state.added else 0.0
        yield rc.results.Condition("wear", float(np.min(rest) < 0.0), "heights that grow")


def press(*laws, boundary="free", grid=GRID, **others):
    """Return a ball on a rigid flat, or a wave where the domain repeats."""
    surface = rc.SphereSurface(radius=1e-3) if boundary == "free" else rc.WavySurface(1e-6, 50e-6)
    return rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, laws=laws, **others)


@pytest.fixture(scope="module")
def worn():
    return press(Wear(1e-17)).sweep(force=[1.0, 2.0, 0.5])


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_pressure_of_a_lubricant_and_that_of_the_contact_act_together(boundary):
    """The gap under both pressures is nowhere negative, and closed where the surfaces press: by one product."""
    law = Lubricant("20MPa", 0.2e-6)
    problem = press(law, boundary=boundary)
    solution = problem.solve(pressure=5e7)
    both = solution.pressure + law._act(problem.initial_gap)
    gap = problem.initial_gap + press(boundary=boundary).displace(both) - solution.approach
    assert gap.min() >= -1e-5 * np.ptp(problem.initial_gap)
    assert np.abs(gap[solution.pressure > 0.0]).max() <= 1e-5 * np.ptp(problem.initial_gap)
    assert solution.pressure[law._act(problem.initial_gap) > 0.0].max() < 5e7
    dry = press(boundary=boundary).solve(pressure=5e7)
    # On a periodic boundary the mean of a displacement is not counted.
    assert (solution.approach > dry.approach) is (boundary == "free")


def test_worn_surfaces_are_those_of_a_height_map():
    """Each load after the first is that of a map of the worn heights, which is another road."""
    careful = rc.ProjectedConjugateGradient(tolerance=1e-8)
    fresh = press().body.heights(GRID)
    for before, state in itertools.pairwise(press(Wear(1e-17), solver=careful).sweep(force=[1.0, 2.0, 0.5])):
        loss = before.added[0].memory[0]["height_loss"]
        body = rc.Body(rc.HeightMap(fresh - loss, GRID.size), STEEL)
        other = rc.ContactProblem(body, grid=GRID, solver=careful).solve(force=state.force)
        np.testing.assert_allclose(state.pressure, other.pressure, atol=1e-4 * state.pressure.max())
        # The approach counts from the first touch of the fresh surfaces.
        later = float((fresh.max() - (fresh - loss)).min())
        assert state.approach == pytest.approx(other.approach + later, rel=1e-5)


def test_the_worn_volume_is_that_of_archard(worn):
    volumes = worn.table().columns["worn_volume"]
    np.testing.assert_allclose(volumes, 1e-17 * np.cumsum([1.0, 2.0, 0.5]), rtol=1e-12)
    assert worn.table().units["worn_volume"] == "m3"


@given(st.lists(st.floats(0.1, 3.0), min_size=2, max_size=4))
def test_a_sweep_goes_in_the_order_of_its_loads(forces):
    path = press(Wear(3e-17), grid=rc.Grid((16, 16), 100e-6)).sweep(force=forces)
    lost = [float(state.added[0].memory[0]["height_loss"].sum()) for state in path]
    np.testing.assert_allclose(np.diff([0.0, *lost]), 3e-17 * np.array(forces) / path[0].grid.cell_area, rtol=1e-10)


def test_several_laws_add_up():
    law = Lubricant("1GPa")
    twice = press(law, law).solve(force=1.0)
    once = press(Lubricant("2GPa")).solve(force=1.0)
    np.testing.assert_allclose(twice.pressure, once.pressure, rtol=1e-4, atol=1e-5 * once.pressure.max())


def test_a_law_without_effect_changes_no_bit():
    nothing = press(Lubricant("0Pa")).solve(force=1.0)
    np.testing.assert_array_equal(nothing.pressure, press().solve(force=1.0).pressure)


def test_wear_of_surfaces_that_attract_each_other_is_remembered_along_a_cycle():
    law = rc.Exponential(work=0.1, range=200e-9)
    cycle = press(Wear(1e-16), adhesion=law).cycle(approach=[-50e-9, 50e-9, 150e-9])
    lost = [float(state.added[0].memory[0]["height_loss"].sum()) for state in cycle]
    assert np.all(np.diff(lost) >= 0.0)
    assert lost[-1] > lost[0]


def test_worn_surfaces_that_do_not_reach_each_other_carry_nothing():
    apart = press(Wear(1e-15)).sweep(approach=[500e-9, 1e-9])[1]
    assert not apart.pressure.any()
    assert apart.approach == 1e-9
    assert apart.gap.min() > 0.0


def test_text_certificate_and_data_state_it(worn):
    text = str(worn[1])
    assert "laws              Wear(rate=1e-17)" in text
    assert "worn volume       3e-17 m3" in text or "worn volume       30 µm3" in text
    assert "wear" in [one.name for one in worn[1].certificate.conditions]
    found = json.loads(json.dumps(worn[1].to_dict()))
    assert found["worn_volume"]["unit"] == "m3"
    assert found["inputs"]["laws"][0].endswith("Wear(rate=10e-18)") or "Wear" in found["inputs"]["laws"][0]
    assert "share" in press(Lubricant("1MPa")).solve(force=1.0).to_dict()
    assert "law        Wear(rate=1e-17): remembers" in press(Wear(1e-17)).explain()


@pytest.mark.parametrize("ending", ["npz", "nc"])
def test_a_state_is_saved_and_verified(worn, tmp_path, ending):
    file = tmp_path / f"state.{ending}"
    worn[2].save(file)
    loaded = rc.load(file)
    np.testing.assert_array_equal(loaded.added[0].memory[0]["height_loss"], worn[2].added[0].memory[0]["height_loss"])
    assert loaded.added[0].numbers == worn[2].added[0].numbers
    assert not loaded.added[0].memory[0]["height_loss"].flags.writeable


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_states_on_any_grid_are_verified(seed):
    """Grids of odd sides, slender cells and lost points, on every boundary, with one law or two."""
    random = np.random.default_rng(seed)
    shape = tuple(random.integers(5, 24, 2).tolist())
    size = (1e-4, float(random.choice([1e-4, 3e-4, 8e-4])))
    boundary = [("free", "free"), ("periodic", "periodic"), ("free", "periodic"), ("periodic", "free")][seed % 4]
    heights = 1e-7 * random.standard_normal(shape)
    if seed % 3 == 0:
        heights[random.random(shape) < 0.1] = np.nan
    surface = rc.HeightMap(heights, size, periodic=boundary == ("periodic", "periodic"))
    laws = [Wear(1e-5 / 200e9), Lubricant("1MPa", "100nm")][: 1 + seed % 2]
    problem = rc.ContactProblem(rc.Body(surface, STEEL), boundary=boundary, laws=laws)
    for state in problem.sweep(pressure=[3e8, 1e8]):
        state.verify()


def test_a_file_whose_law_is_not_registered_keeps_the_fields(tmp_path):
    @attrs.frozen
    class Own(Wear):
        pass

    state = press(Own(1e-17)).solve(force=1.0)
    with pytest.warns(UserWarning, match=r"keeps the fields of the solution\. To solve it again, the law .*Own"):
        state.save(tmp_path / "state.npz")
    with pytest.raises(rc.InputError, match="cannot be verified"):
        rc.load(tmp_path / "state.npz")
    loaded = rc.load(tmp_path / "state.npz", verify=False)
    np.testing.assert_array_equal(loaded.added[0].memory[0]["height_loss"], state.added[0].memory[0]["height_loss"])
    assert "worn volume" in str(loaded)


def test_a_path_is_saved_and_verified(worn, tmp_path):
    worn.save(tmp_path / "sweep.npz")
    loaded = rc.load(tmp_path / "sweep.npz")
    assert [one.approach for one in loaded] == [one.approach for one in worn]


def test_a_state_with_another_memory_is_refused(worn):
    state = worn[1]
    forged = attrs.evolve(state.added[0], memory=({"height_loss": state.added[0].memory[0]["height_loss"] * 2.0},))
    with pytest.raises(rc.InputError, match="Its memory 'height_loss' contradicts its laws"):
        attrs.evolve(state, added=(forged,)).verify()
    with pytest.raises(rc.InputError, match="Its laws are not those of its problem"):
        press().verify(attrs.evolve(state, added=()).__class__(**attrs.asdict(state, recurse=False)))
    state.verify()


def test_its_fields_are_in_datasets_and_image_data(worn, tmp_path):
    found = worn[1].to_xarray()["height_loss"]
    assert found.attrs == {"long_name": "height lost by wear", "units": "m"}
    worn[1].save(tmp_path / "state.vti")
    assert b'Name="height_loss"' in (tmp_path / "state.vti").read_bytes()


@pytest.mark.slow
def test_the_page_states_it_and_writes_no_script_of_a_state_that_follows_others(worn):
    page = worn[1].to_html()
    assert "Wear(" in page
    assert "problem.solve(force" not in page
    assert "problem.solve(force" in press(Lubricant("1MPa")).solve(force=1.0).to_html()


def test_a_pickle_keeps_it(worn):
    again = pickle.loads(pickle.dumps(worn))[1]
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(worn[0])).pressure, worn[0].pressure)
    np.testing.assert_array_equal(again.added[0].offset, worn[1].added[0].offset)
    assert not again.added[0].offset.flags.writeable
    assert again.certificate == worn[1].certificate


TABLE = {
    "laws": [{"type": "test-wear", "rate": 1e-17}],
    "grid": {"shape": [32, 32], "size": "100um"},
    "body": {"surface": {"type": "sphere", "radius": "1mm"}, "material": {"young": "210GPa", "poisson": 0.3}},
}


def test_a_study_follows_the_loads_and_resumes(worn, tmp_path):
    """Its problem is a table, as in a study file; a state that was lost is solved again from the one before."""
    study = rc.Study(problems={"ball": rc.faces.build_problem(TABLE)}, force=["1N", "2N", "0.5N"], fields=True)
    result = study.run(tmp_path)
    approaches = [record.approach for record in result]
    np.testing.assert_allclose(approaches, [state.approach for state in worn], rtol=1e-6)
    (tmp_path / f"{result[2].key}.npz").unlink()
    again = study.run(tmp_path)
    assert again.computed == 1
    assert [record.approach for record in again] == approaches


@rc.laws.register("test-tender")
@attrs.frozen
class Tender(Wear):
    """Wear that is not known under light loads."""

    def change_gap(self, problem, increment, memory):
        if increment.load.value < 2e-9:
            raise rc.InputError("Under so light a load the wear is not known.")
        return memory["height_loss"]


def test_a_study_does_not_forget_a_load_that_failed(tmp_path):
    """What the second load would have worn is not known, so that there is no third state."""
    study = rc.Study(problems={"ball": press(Tender(1e-15))}, approach=["500nm", "1nm", "500nm"])
    found = study.run(tmp_path)
    assert [record.status for record in found] == ["CONVERGED", "REFUSED", "REFUSED"]
    assert "remembers the state at the load before it" in found[2].message


def test_a_study_unloads_bodies_that_remember(worn, tmp_path):
    law = Wear(1e-17)
    small = rc.Grid((16, 16), 100e-6)
    study = rc.Study(problems={"ball": press(law, Lubricant("0MPa"), grid=small)}, force=["1N", "2N"])
    table = study.run(tmp_path / "share").table()
    # A number of a law has its uncertainty beside it.
    assert (table.columns["share_uncertainty"], table.units["share_uncertainty"]) == ([0.0, 0.0], "")
    assert "worn_volume_uncertainty" not in table.columns
    unloaded = rc.Study(problems={"ball": press(law, grid=small)}, force=["1N", "0N", "1N"]).run(tmp_path / "rest")
    assert [record.status for record in unloaded] == 3 * ["CONVERGED"]
    first, rest, last = (record.numbers["worn_volume"][0] for record in unloaded)
    assert first == rest == pytest.approx(0.5 * last)
    for problem, forces in ((press(law), ["0N", "1N"]), (press(), ["1N", "0N"]), (press(law), ["1N", "-1N"])):
        with pytest.raises(rc.InputError, match=r"Problem '0': .* finite number"):
            rc.Study(problems={"0": problem}, force=forces)


@attrs.frozen
class Costly(Lubricant):
    """One that says what it takes."""

    def explain_work(self, problem, load):
        yield "cost", "unknown" if load is None else f"two solves at {load} on {problem.plan.grid.cells} cells"


def test_a_plan_says_what_a_law_takes():
    problem = press(Costly(1e6))
    assert problem.explain().splitlines()[-1] == "cost       unknown"
    assert problem.explain(force="2N").splitlines()[-1] == "cost       two solves at force 2 N on 1024 cells"
    assert press().explain(pressure="1MPa") == press().explain()
    assert "two solves at force 3 N" in rc.Study(problems={"0": problem}, force=["1N", "3N"]).explain()
    with pytest.raises(rc.InputError, match="force"):
        problem.explain(force=-1.0)


def test_the_command_follows_the_loads(worn, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    np.savez("ball.npz", heights=press().body.heights(GRID), size=GRID.size)
    steel = ["--young", "210GPa", "--poisson", "0.3"]
    law = ["--law", "test-wear", "rate=1e-17", "--law", "test-lubricant", "pressure=0MPa"]
    assert main(["solve", "ball.npz", "--loads", "1N", "2N", "0.5N", *steel, *law, "--json"]) in (0, 3)
    found = json.loads(capsys.readouterr().out)["solutions"]
    assert [one["approach"]["value"] for one in found] == pytest.approx([state.approach for state in worn], rel=1e-6)
    assert found[2]["worn_volume"]["value"] == pytest.approx(3.5e-17)
    assert main(["solve", "ball.npz", "--force", "1N", *steel, "--law", "test-weer", "rate=1"]) == 2
    assert "There is no law named 'test-weer'. Did you mean 'test-wear'?" in capsys.readouterr().err
    along = ["--friction", "0.3", "--tangential", "0.1N", "--counterbody-young", "210GPa"]
    sliding = ["--law", "archard", "coefficient=1e-16m2/N"]
    assert main(["solve", "ball.npz", "--force", "1N", *steel, *sliding, *along]) == 2
    assert "neither time nor a sliding distance passes" in capsys.readouterr().err


class TestRefusals:
    """What a law gives wrongly, and what does not hold with laws, gets a sentence."""

    def test_a_field_of_another_shape(self):
        @attrs.frozen
        class Wrong(rc.Law):
            def change_gap(self, problem, increment, memory):
                return np.zeros(3)

        with pytest.raises(rc.InputError, match=r"change_gap of Wrong\(\) must be finite numbers of shape \(32, 32\)"):
            press(Wrong()).solve(force=1.0)

    @pytest.mark.parametrize("found", [None, {}, {"height": np.zeros(GRID.shape)}, {"height_loss": np.full(9, np.nan)}])
    def test_a_memory_of_another_kind(self, found):
        @attrs.frozen
        class Wrong(rc.Process):
            remembered: ClassVar = {"height_loss": ("height lost", "m")}

            def change_gap(self, problem, increment, memory):
                return memory["height_loss"]

            def remember(self, state, increment, memory):
                return found

        with pytest.raises(rc.InputError, match="height_loss"):
            press(Wrong()).solve(force=1.0)

    @pytest.mark.parametrize("given", ["unknown-law", 3, [None], rc.FlatSurface()])
    def test_what_is_no_law(self, given):
        with pytest.raises(rc.InputError, match="law"):
            rc.ContactProblem(press().body, grid=GRID, laws=given)

    def test_an_approach_at_which_changed_surfaces_do_not_touch(self):
        problem = press(Lubricant("100MPa"))
        with pytest.raises(rc.InputError, match="the surfaces do not touch"):
            problem.solve(approach=1e-9)

    def test_friction_beside_laws(self):
        flat = rc.Body(rc.FlatSurface(), STEEL)
        problem = rc.ContactProblem(press().body, flat, grid=GRID, laws=rc.Archard(1e-17))
        with pytest.raises(rc.InputError, match="neither time nor a sliding distance"):
            problem.path(force=1.0, tangential_force=[(0.1, 0.0)], friction=0.3)

    def test_an_interface_law_of_what_remembers(self):
        with pytest.raises(rc.InputError, match="a law of the problem remembers"):
            rc.interface_law(press(Wear(1e-17), boundary="periodic"), pressure=[1e7, 2e7])
