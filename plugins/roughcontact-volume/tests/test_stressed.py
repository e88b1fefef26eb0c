"""Bodies that have a residual stress before any load: first yield, work, relaxation, answers, and refusals."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.responses import FirstYield

from roughcontact_volume import (
    FindOwnYield,
    FindResidualStress,
    FindTotalStress,
    Plastic,
    ResidualStress,
    VolumeOperators,
)
from test_process import FIRST_FORCE, FIRST_RADIUS, LIMIT, POISSON, RADIUS, YOUNG, make_ball, numbers, read


def make_stressed(stress, **others):
    """Return a ball on a flat with a residual stress, over the yield stress, the same at all depths."""
    problem = make_ball(**others)
    residual = stress if isinstance(stress, ResidualStress) else ResidualStress([0.0], [stress * LIMIT])
    flat = problem.counterbody if problem.counterbody.material.compliance else problem.body
    stressed = rc.Body(flat.surface, attrs.evolve(flat.material, residual=residual))
    side = "counterbody" if flat is problem.counterbody else "body"
    return attrs.evolve(problem, **{side: stressed})


@pytest.mark.parametrize("stress", [-0.3, 0.3])
def test_it_flows_first_where_the_response_says(stress):
    problem = make_stressed(stress, cells=21, width=2.8)
    elastic = attrs.evolve(problem, counterbody=rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, POISSON)), laws=())
    asked = FirstYield(LIMIT, body="counterbody", residual=ResidualStress([0.0], [stress * LIMIT]))
    expected = elastic.solve(force=FIRST_FORCE).response(asked).force.value
    assert (expected > FIRST_FORCE) == (stress < 0.0)
    below, above = (problem.solve(force=part * expected) for part in (0.93, 1.08))
    assert not read(below)["accumulated_strain"].any()
    assert below.certificate["plastic flow"].residual == 0.0
    assert read(above)["accumulated_strain"].any()
    if stress > 0.0:
        assert below.response(FindOwnYield()).force.value == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_work_of_a_cycle_counts_the_energy_that_the_residual_stress_has_won():
    deepest = 6.0 * FIRST_RADIUS**2 / RADIUS
    parts = np.append(np.linspace(0.0, 1.0, 6)[1:], np.linspace(1.0, 0.0, 7)[1:])
    path = make_stressed(0.4, cells=9, width=7.0, accuracy=1.0).path(approach=deepest * parts)
    lost = np.trapezoid(np.append(0.0, path.force), np.append(0.0, path.approach))
    found = numbers(path[-1])
    assert lost == pytest.approx(found["plastic_work"] + found["residual_energy"], rel=0.03)
    # Tension is relieved: it gives more than flow leaves.
    assert found["residual_energy"] < -0.1 * found["plastic_work"]


def test_rolling_relieves_tension_and_leaves_compression():
    """A ball rolls once over a flat that is peened, ground, or neither, at twice the load of first yield."""
    grid = rc.Grid((20, 10), (8.0 * FIRST_RADIUS, 4.0 * FIRST_RADIUS))
    track = [(cells, 0) for cells in (-4, -2, 0, 2, 4)]
    common = {"grid": grid, "of": "body", "boundary": "periodic", "hardening": None, "accuracy": 1.0}
    left, work = {}, {}
    for stress in (-0.6, 0.0, 0.5):
        by_depth = ResidualStress(np.array([0.0, 1.5, 3.0]) * FIRST_RADIUS, np.array([1.0, 1.0, 0.0]) * stress * LIMIT)
        path = make_stressed(by_depth, **common).path(force=2.0 * FIRST_FORCE, shift=track)
        profile = path[-1].response(FindResidualStress(depth=FIRST_RADIUS)).find_profile().columns
        left[stress], work[stress] = profile["xx"], numbers(path[-1])["plastic_work"]
    assert work[-0.6] == 0.0
    assert left[-0.6] == pytest.approx(-0.6 * LIMIT)
    assert work[0.5] > 5.0 * work[0.0] > 0.0
    # Where the body flows, at half the radius of the contact, what is left hardly depends on what there was.
    deep = np.argmin(left[0.0])
    assert left[0.5][deep] < left[0.0][deep] + 0.3 * LIMIT < 0.2 * LIMIT


def make_peened():
    peened = ResidualStress(np.array([0.0, 0.5, 2.0]) * FIRST_RADIUS, np.array([-0.2, -0.5, 0.3]) * LIMIT)
    return make_stressed(peened, cells=9, width=5.0)


@pytest.fixture(scope="module")
def path():
    """A ball that is pressed into a peened body, with tension below the compression, and lifted."""
    return make_peened().path(force=[0.2 * FIRST_FORCE, 4.0 * FIRST_FORCE, 0.0])


class TestAnswers:
    def test_stress_is_that_of_the_pressure_the_strain_and_the_material(self, path):
        state = path[1]
        total, left = (state.response(ask(depth=3.0 * FIRST_RADIUS)) for ask in (FindTotalStress, FindResidualStress))
        operators = VolumeOperators(state.grid, rc.Boundary.FREE, np.diff(total.interfaces), YOUNG, POISSON)
        strain = np.zeros(operators.shape)
        known = read(state)["plastic_strain"][:, : strain.shape[1]]
        strain[:, : known.shape[1]] = known
        assert strain.any()
        expected = operators.find_stress(strain)
        at = np.linspace(total.interfaces[:-1], total.interfaces[1:], 2001)
        given = np.interp(at, np.array([0.0, 0.5, 2.0]) * FIRST_RADIUS, np.array([-0.2, -0.5, 0.3]) * LIMIT)
        expected[:2] += given.mean(axis=0)[:, np.newaxis, np.newaxis]
        assert left.components == pytest.approx(expected, abs=1e-3 * LIMIT)
        assert total.components - left.components == pytest.approx(operators.press(state.pressure), abs=1e-6 * LIMIT)
        assert total.maximum.value < (1.0 + 3e-4) * (LIMIT + 4e9 * read(state)["accumulated_strain"].max())

    def test_a_body_that_has_not_flowed_has_it_too(self, path):
        assert not read(path[0])["accumulated_strain"].any()
        assert numbers(path[0])["residual_stress"] == 0.5 * LIMIT
        assert numbers(path[0])["residual_energy"] == 0.0
        assert path[0].response(FindResidualStress(depth=FIRST_RADIUS)).von_mises.max() > 0.4 * LIMIT
        with pytest.raises(rc.InputError, match="has a residual stress"):
            path[0].stress(body="counterbody")

    def test_hold_after_saving(self, path, tmp_path):
        path[1].save(tmp_path / "state.npz")
        again = rc.load(tmp_path / "state.npz")
        make_peened().verify(again)
        found, expected = (state.origin.scene.counterbody.material for state in (again, path[1]))
        assert found == expected
        assert hash(found) == hash(expected)
        other = attrs.evolve(make_peened(), counterbody=make_stressed(0.1).counterbody)
        assert found != other.counterbody.material
        with pytest.raises(rc.InputError, match="plastic flow is violated"):
            other.verify(again)


@pytest.mark.parametrize(
    ("residual", "sentence"),
    [
        (ResidualStress([0.0, 1e-5], ["0MPa", "-1GPa"]), "The residual stress alone makes the material yield"),
        ("-400MPa", "The residual stress of a material"),
    ],
)
def test_residual_stresses_that_a_material_cannot_have(residual, sentence):
    with pytest.raises(rc.InputError, match=sentence):
        Plastic("210GPa", 0.3, "1GPa", residual=residual)


def test_the_box_reaches_a_layer_that_yields_apart_from_the_zone_below_the_contact():
    depth, stress = np.array([0.0, 1.4, 1.42, 2.4, 2.5]), np.array([0.0, 0.0, 0.9, 0.9, 0.0])
    problem = make_stressed(ResidualStress(depth * FIRST_RADIUS, stress * LIMIT), cells=11, width=5.0, accuracy=1.0)
    state = problem.solve(force=1.4 * FIRST_FORCE)
    flows = read(state)["accumulated_strain"].any(axis=(1, 2))
    # Between both it stays elastic, and so does the lowest layer.
    changes = np.flatnonzero(np.diff(np.concatenate(([False], flows)).astype(int)))
    assert len(changes) == 4
    assert state.certificate["plastic flow"].residual < 2e-4
