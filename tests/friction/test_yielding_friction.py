"""Paths with friction along which the bodies yield: flattened heights, energies, invariance, files."""

import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import frictional_paths

from scenes import rather_slow

HARDNESS = 1e9
SOFT = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=HARDNESS)
STEEL = rc.Elastic(young=210e9, poisson=0.3)
ALUMINIUM = rc.Elastic(young=70e9, poisson=0.33)
FORCES = [2.0, 2.0, 1.0, 0.5, 2.0, 3.0]
PUSHED = [(0.0, 0.0), (0.3, 0.0), (0.2, 0.0), (-0.1, 0.0), (0.3, 0.0), (0.3, 0.0)]


def press_ball(other=STEEL, shape=(32, 32), size=(100e-6, 100e-6), material=SOFT, **parts):
    body = rc.Body(rc.ParaboloidSurface(radius=1e-3), material)
    flat = rc.Body(rc.FlatSurface(), other)
    return rc.ContactProblem(body, flat, grid=rc.Grid(shape, size), threads=1, **parts)


def follow(problem, force=FORCES, pushed=PUSHED, friction=0.3, substeps=1, **options):
    return problem.path(force=force, tangential_force=pushed, friction=friction, substeps=substeps, **options)


def lost_heights(state):
    """Return what both surfaces have lost together."""
    return next(one for one in state.added if one.kind == "laws").memory[0]["flattened_height"]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
def test_states_and_energies_hold_on_flattened_heights(other, boundary):
    """The balance with the gap that opens and the heights that are lost, beside the certificate."""
    problem = press_ball(other, (27, 32), boundary=boundary)
    path = follow(problem)
    assert path[0].saturated.any()
    before, lost, gap = None, np.zeros(problem.grid.shape), problem.initial_gap
    for state in path:
        residuals = state.sheared.residuals
        assert residuals.slip < 1e-5
        assert residuals.cone < 1e-15
        assert residuals.energy < 1e-14
        flattened = lost_heights(state) - lost
        assert flattened.min() >= 0.0
        assert not flattened[state.pressure < HARDNESS].any()
        if before is not None:
            # The gap of what is left: the cells that have flowed touch.
            left = state.gap + flattened
            pressure = 0.5 * (before.pressure + state.pressure)
            shear = 0.5 * (before.shear + state.shear)
            terms = (
                pressure.sum() * (state.approach - before.approach),
                -(pressure * flattened).sum(),
                (pressure * (left - gap)).sum(),
                shear.sum(axis=(1, 2)) @ np.subtract(state.tangential_displacement, before.tangential_displacement),
                -(shear * state.slip).sum(),
            )
            change = (state.elastic_energy - before.elastic_energy) / problem.grid.cell_area
            assert sum(terms) == pytest.approx(change, abs=1e-11 * max(map(abs, terms)))
        before, lost, gap = state, lost_heights(state), state.gap + flattened
    path.verify()


def test_like_bodies_are_flattened_as_without_friction():
    """Their pressure does not know the traction, whatever the loads."""
    solver = rc.ProjectedConjugateGradient(tolerance=1e-8)
    path = follow(press_ball(solver=solver))
    alone = press_ball(solver=solver).path(force=FORCES)
    for state, other in zip(path, alone, strict=True):
        np.testing.assert_allclose(state.pressure, other.pressure, atol=1e-6 * HARDNESS)
        assert state.approach == pytest.approx(other.approach, rel=1e-7)
    np.testing.assert_allclose(lost_heights(path[-1]), lost_heights(alone[-1]), atol=1e-12)


def test_no_flow_under_a_falling_load_and_as_many_increments():
    """Flattening of like bodies does not depend on the increments; slip converges with them."""
    once, often = (follow(press_ball(), substeps=count) for count in (1, 4))
    for one, other in zip(once, often, strict=True):
        np.testing.assert_allclose(lost_heights(one), lost_heights(other), atol=2e-5 * lost_heights(one).max())
    np.testing.assert_array_equal(lost_heights(once[1]), lost_heights(once[3]))


@pytest.mark.parametrize("seed", rather_slow(range(60), range(0, 60, 10)))
def test_random_paths_are_confirmed_by_dense_matrices(seed):
    """The judge carries what has flowed by itself."""
    _, outcome, violations = frictional_paths.run(seed, yields=True)
    assert outcome == "verified" or outcome.startswith("refused: The bodies slide"), violations


@pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
def test_exchange_of_the_axes(other):
    pushed = [(0.0, 0.0), (0.3, 0.1), (0.1, -0.1)]
    solver = rc.ProjectedConjugateGradient(tolerance=1e-7)
    one = follow(press_ball(other, (24, 32), (75e-6, 100e-6), solver=solver), [2.0, 2.0, 1.0], pushed)
    turned = press_ball(other, (32, 24), (100e-6, 75e-6), solver=solver)
    for state, mirrored in zip(one, follow(turned, [2.0, 2.0, 1.0], [x[::-1] for x in pushed]), strict=True):
        assert np.abs(state.shear - mirrored.shear[::-1].transpose(0, 2, 1)).max() < 1e-4 * state.shear_strength.max()
        assert np.abs(lost_heights(state) - lost_heights(mirrored).T).max() < 1e-4 * lost_heights(state).max()


@pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
def test_units_by_powers_of_two_change_no_bit(other):
    found = []
    for scale in (1.0, 2.0**20):
        soft = rc.ElasticPerfectlyPlastic(young=210e9 * scale, poisson=0.3, hardness=HARDNESS * scale)
        material = rc.Elastic(young=other.young * scale, poisson=other.poisson)
        problem = press_ball(material, (24, 24), material=soft)
        forces = [scale * force for force in FORCES[:4]]
        found.append(follow(problem, forces, [(scale * x, scale * y) for x, y in PUSHED[:4]]))
    for one, other_state in zip(*found, strict=True):
        np.testing.assert_array_equal(lost_heights(one), lost_heights(other_state))
        np.testing.assert_array_equal(2.0**20 * one.shear, other_state.shear)


def test_what_changes_neither_with_slip_nor_at_once_is_refused():
    for law, name in ((rc.Archard(1e-16), "Archard"), (rc.Relaxation(rc.Viscoelastic([1e6, 1e6], [1.0], 0.5)), "Rel")):
        with pytest.raises(rc.InputError, match=name):
            follow(press_ball(laws=law))


def test_bodies_come_apart_later_after_they_were_flattened():
    for other in (STEEL, ALUMINIUM):
        path = follow(press_ball(other), [2.0, 0.0], [(0.0, 0.1), (0.0, 0.0)], substeps=2)
        end = path[-1]
        assert not end.pressure.any()
        assert end.approach == pytest.approx((press_ball().initial_gap + lost_heights(path[0])).min(), rel=1e-12)
        assert end.approach > 0.0
        end.verify()


@pytest.fixture(scope="module")
def path():
    return follow(press_ball(ALUMINIUM), FORCES[:4], PUSHED[:4])


class TestFiles:
    """What is read again knows what has flowed."""

    def test_a_path_in_a_file(self, path, tmp_path):
        path.save(tmp_path / "path.npz")
        again = rc.load(tmp_path / "path.npz")
        assert str(again) == str(path)
        for one, other in zip(again, path, strict=True):
            np.testing.assert_array_equal(lost_heights(one), lost_heights(other))

    def test_states_that_do_not_follow_each_other(self, path, tmp_path):
        law = next(one for one in path[2].added if one.kind == "laws")
        forged = attrs.evolve(law, before=({name: 0.5 * values for name, values in law.before[0].items()},))
        states = [*path[:2], path[2]._add(forged), path[3]]
        attrs.evolve(path, states=tuple(states)).save(tmp_path / "path.npz")
        with pytest.raises(rc.InputError, match="follow each other"):
            rc.load(tmp_path / "path.npz", verify=False)

    def test_a_height_that_was_not_lost(self, path):
        law = next(one for one in path[1].added if one.kind == "laws")
        memory = {name: 1.01 * values for name, values in law.memory[0].items()}
        with pytest.raises(rc.InputError, match="contradicts its laws"):
            path[1]._add(attrs.evolve(law, memory=(memory,))).verify()

    def test_a_path_is_followed_on_from_its_file(self, path, tmp_path):
        path.save(tmp_path / "path.npz")
        begun = rc.load(tmp_path / "path.npz")
        whole = follow(press_ball(ALUMINIUM))
        longer = begun.extend(force=FORCES[4:], tangential_force=PUSHED[4:], substeps=1)
        assert len(longer) == len(whole)
        for one, other in zip(longer, whole, strict=True):
            np.testing.assert_allclose(
                lost_heights(one), lost_heights(other), atol=1e-4 * lost_heights(whole[-1]).max()
            )
            assert np.abs(one.shear - other.shear).max() < 1e-4 * other.shear_strength.max()
        longer.save(tmp_path / "longer.npz")
        assert str(rc.load(tmp_path / "longer.npz")) == str(longer)

    @pytest.mark.parametrize(
        ("options", "said"),
        [
            ({"tangential_force": (0.1, 0.0)}, "normal loads by force="),
            ({"force": [1.0], "displacement": (0.0, 0.0)}, "along tangential_force="),
            ({"force": [1.0], "tangential_force": (0.1, 0.0), "cycles": [2]}, "for loads that return"),
            ({"force": [1.0]}, "neither"),
        ],
    )
    def test_what_does_not_continue_it_gets_a_sentence(self, path, options, said):
        with pytest.raises(rc.InputError, match=said):
            path.extend(**options)


def test_one_load_holds_on():
    """Of like bodies one increment for each turn is exact, before and after."""
    problem = press_ball(shape=(24, 24))
    turns = [(0.3, 0.0), (-0.3, 0.0), (0.3, 0.0)]
    whole = problem.path(force=2.0, tangential_force=turns, friction=0.3)
    longer = problem.path(force=2.0, tangential_force=turns[:2], friction=0.3).extend(tangential_force=turns[2])
    assert longer.increments == whole.increments == (1, 1, 1)
    assert np.abs(longer[2].shear - whole[2].shear).max() < 1e-4 * whole[2].shear_strength.max()
    assert longer.numbers[2].dissipated.value == pytest.approx(whole.numbers[2].dissipated.value, rel=1e-3)
    with pytest.raises(rc.InputError, match="where the normal load changes"):
        longer.extend(force=[1.0], tangential_force=turns[0])


@pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
def test_bodies_come_apart_at_an_approach(other):
    """Flattened, they no longer touch where they did."""
    problem = press_ball(other, shape=(24, 24))
    path = problem.path(approach=[1e-6, 1e-9], displacement=[(5e-8, 0.0), (0.0, 0.0)], friction=0.3, substeps=1)
    assert path[0].saturated.any()
    assert not path[1].pressure.any()
    assert not path[1].shear.any()
    path.verify()
