"""Contacts whose bodies both flow: symmetry, one of them elastic, their order, and which one is asked."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.responses import FirstYield

from roughcontact_volume import (
    FindImprint,
    FindOwnYield,
    FindPlasticZone,
    FindResidualStress,
    FindTotalStress,
    Plastic,
    PlasticFlow,
    PlasticZonePanel,
    find_indentation,
    judge_passes,
)
from test_process import FIRST_FORCE, FIRST_RADIUS, LIMIT, POISSON, RADIUS, YOUNG, make_ball, numbers, read

SIDES = ("body", "counterbody")
STEEL = Plastic(YOUNG, POISSON, LIMIT, "4GPa", accuracy=0.2)


def make_pair(one, other, cells=9, radius=0.5 * RADIUS, **others):
    """Return a ball on a flat; of two equal bodies each deforms as below a rigid ball of twice the radius."""
    grid = others.pop("grid", rc.Grid((cells, cells), 5.0 * FIRST_RADIUS))
    ball = rc.Body(rc.ParaboloidSurface(radius), one)
    return rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), other), grid=grid, **others)


def read_side(state, side):
    """Return what is remembered of a side, by the names of a single body."""
    ending = f"_of_{side}"
    return {name.removesuffix(ending): one for name, one in read(state).items() if name.endswith(ending)}


@pytest.fixture(scope="module")
def path():
    """Two equal bodies that are pressed, lifted and pressed again."""
    return make_pair(STEEL, STEEL).path(force=[2.0 * FIRST_FORCE, 0.0, 3.0 * FIRST_FORCE])


def test_equal_bodies_flow_equally_and_as_one_below_a_rigid_one(path):
    alone = make_ball(cells=9, width=5.0, accuracy=0.2).path(force=path.force)
    for state, single in zip(path, alone, strict=True):
        one, other = (read_side(state, side)["plastic_strain"] for side in SIDES)
        size = np.abs(one).max()
        assert one == pytest.approx(other, abs=1e-8 * size)
        assert one == pytest.approx(read(single)["plastic_strain"], abs=1e-4 * size)
        assert state.pressure == pytest.approx(single.pressure, abs=1e-4 * LIMIT)
        assert state.approach == pytest.approx(2.0 * single.approach, rel=1e-4)
    assert {f"plastic flow of the {side}" for side in SIDES} < {one.name for one in path[2].certificate.conditions}


def test_beside_a_body_that_stays_elastic_one_flows_as_alone():
    hard = attrs.evolve(STEEL, yield_stress=1e15)
    loads = [2.0 * FIRST_FORCE, 0.5 * FIRST_FORCE, 2.5 * FIRST_FORCE]
    both = make_pair(hard, STEEL, cells=7)
    assert both.laws == (PlasticFlow("both"),)
    alone = attrs.evolve(both, body=rc.Body(both.body.surface, rc.Elastic(YOUNG, POISSON)))
    assert alone.laws == (PlasticFlow("counterbody"),)
    for state, single in zip(both.path(force=loads), alone.path(force=loads), strict=True):
        found = read_side(state, "counterbody")
        assert all(np.array_equal(found[name], values) for name, values in read(single).items())
        assert np.array_equal(state.pressure, single.pressure)
        assert not read_side(state, "body")["plastic_strain"].any()


def test_one_may_yield_after_the_other():
    """It comes near its yield stress, and into a box, only at the second load."""
    harder = Plastic(YOUNG, POISSON, 1.4 * LIMIT, "4GPa", accuracy=1.0)
    path = make_pair(STEEL, harder, cells=7).path(force=[1.1 * FIRST_FORCE, 8.0 * FIRST_FORCE])
    first, second = (read_side(state, "counterbody")["accumulated_strain"] for state in path)
    assert first.shape[0] == 1
    assert second.any()
    assert not second[-1].any()
    assert path[1].certificate["plastic flow of the counterbody"].residual < 2e-4


def test_each_keeps_its_strain_in_its_own_frame_whichever_it_is():
    grid = rc.Grid((12, 10), (5.0 * FIRST_RADIUS, 4.2 * FIRST_RADIUS))
    soft = attrs.evolve(STEEL, yield_stress=0.9 * LIMIT, accuracy=1.0)
    problem = make_pair(STEEL, soft, grid=grid, boundary="periodic")
    swapped = rc.ContactProblem(problem.counterbody, problem.body, grid=grid, boundary="periodic")
    one = problem.path(force=2.0 * FIRST_FORCE, shift=[(0, 0), (3, 1)])
    other = swapped.path(force=2.0 * FIRST_FORCE, shift=[(0, 0), (-3, -1)])
    for side, opposite in (SIDES, SIDES[::-1]):
        found, expected = read_side(one[1], side)["imprint"], read_side(other[1], opposite)["imprint"]
        assert expected.max() > 1e-9
        assert found == pytest.approx(expected, abs=1e-6 * expected.max())
    assert judge_passes(problem.path(force=0.2 * FIRST_FORCE, shift=[(0, 0)] * 2), 1, "body").verdict == "stays elastic"


class TestAnswers:
    @pytest.mark.parametrize("ask", [FindPlasticZone, FindImprint, FindResidualStress, FindTotalStress])
    def test_ask_for_a_body(self, path, ask):
        with pytest.raises(rc.InputError, match="say which with body="):
            path[0].response(ask())
        one, other = (path[0].response(ask(body=side)).estimates for side in SIDES)
        for name, found in one.items():
            assert found.value == pytest.approx(other[name].value, rel=1e-6)

    def test_ask_for_a_body_that_flows(self):
        state = make_ball(cells=9, width=5.0, accuracy=1.0).solve(force=0.5 * FIRST_FORCE)
        for ask in (FindPlasticZone(body="body"), FindOwnYield(body="body")):
            with pytest.raises(rc.InputError, match="The body does not"):
                state.response(ask)
        with pytest.raises(rc.InputError, match="The body"):
            FindImprint(body="left")

    def test_first_yield_is_that_of_a_body(self):
        harder = Plastic(YOUNG, POISSON, 1.1 * LIMIT)
        state = make_pair(STEEL, harder).solve(force=0.5 * FIRST_FORCE)
        elastic = make_pair(*[rc.Elastic(YOUNG, POISSON)] * 2).solve(force=0.5 * FIRST_FORCE)
        found = state.response(FindOwnYield(body="counterbody")).force.value
        expected = elastic.response(FirstYield(1.1 * LIMIT, body="counterbody")).force.value
        assert found == pytest.approx(expected, rel=1e-6)
        with pytest.raises(rc.InputError, match="say which"):
            state.response(FindOwnYield())

    def test_energies_are_those_of_both(self, path):
        table = find_indentation(path).table().columns
        for name in ("plastic_work", "residual_energy"):
            assert table[name][2] == sum(numbers(path[2])[f"{name}_of_{side}"] for side in SIDES)

    def test_bodies_have_their_imprints(self, path):
        with pytest.warns(rc.ContactWarning, match="but not the residual stress"):
            bodies = path.bodies
        grid = path[0].grid
        gap = -sum(body.heights(grid) for body in bodies)
        before = make_pair(STEEL, STEEL)
        change = gap + before.body.heights(grid) + before.counterbody.heights(grid)
        imprints = sum(read_side(path[2], side)["imprint"] for side in SIDES)
        assert change - change.mean() == pytest.approx(imprints - imprints.mean(), abs=1e-6 * imprints.max())

    @pytest.mark.parametrize("side", SIDES)
    def test_conditions_see_what_is_wrong_of_either(self, path, side):
        state = path[0]
        law, effect = state.added[0].laws[0], state.added[0]
        name = f"plastic_strain_of_{side}"
        wrong = {**effect.memory[0], name: 1.05 * effect.memory[0][name]}
        increment = effect._find_increment(state)
        found = {one.name: one.residual for one in law.judge(make_pair(STEEL, STEEL), state, increment, wrong, wrong)}
        assert found[f"plastic flow of the {side}"] > 1e-3

    def test_hold_after_saving(self, path, tmp_path):
        path[0].save(tmp_path / "state.npz")
        again = rc.load(tmp_path / "state.npz")
        make_pair(STEEL, STEEL).verify(again)
        for side in SIDES:
            found, expected = (read_side(one, side)["plastic_strain"] for one in (again, path[0]))
            assert np.array_equal(found, expected)


def test_panels_show_the_deeper_plastic_zone():
    state = make_pair(attrs.evolve(STEEL, yield_stress=1e15), STEEL, cells=7).solve(force=2.0 * FIRST_FORCE)
    assert state.plot("plastic-zone").get_legend().get_texts()[-1].get_text().endswith(", counterbody")
    assert "nothing has flowed" in state.plot(PlasticZonePanel(body="body")).get_legend().get_texts()[-1].get_text()
