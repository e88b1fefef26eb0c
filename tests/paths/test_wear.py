"""Wear over a sliding distance: Archard's law by implicit increments."""

from typing import ClassVar

import attrs
import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(young=210e9, poisson=0.3)
# Radius of contact, m, of the fresh pin, its radius and force.
PIN_CONTACT = 50e-6
PIN_RADIUS = 1e-3
PIN_FORCE = 4.0 / 3.0 * 210e9 / (1.0 - 0.3**2) * PIN_CONTACT**3 / PIN_RADIUS
CAP = np.pi * PIN_CONTACT**4 / (4.0 * PIN_RADIUS)
COEFFICIENT = 1e-16


def wear_pin(volume, cells, *, reach, **others):
    """Return the path of a pin that loses so many times the segment above its fresh contact of so many cells."""
    n = 2 * int(reach * cells) + 3
    grid = rc.Grid((n, n), n * PIN_CONTACT / cells)
    body = rc.Body(rc.ParaboloidSurface(radius=PIN_RADIUS), STEEL)
    problem = rc.ContactProblem(body, grid=grid, laws=rc.Archard(COEFFICIENT))
    return problem.path(force=PIN_FORCE, sliding=[0.0, volume * CAP / (COEFFICIENT * PIN_FORCE)], **others)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("volume", "reach", "radius", "peak"),
    [(0.3, 1.5, 1.090, 0.905), (3.0, 1.7, 1.434, 0.435), (30.0, 2.6, 2.372, None)],
)
def test_a_pin_wears_as_rings_do(volume, reach, radius, peak):
    """Radius and maximum pressure over Hertz's, of axisymmetric rings by sets of cells, extrapolated in the distance.

    At the deepest wear a cell of the edge may have the maximum, which is not that of the spot.
    """
    path = wear_pin(volume, 12, reach=reach)
    hertz = 1.5 * PIN_FORCE / (np.pi * PIN_CONTACT**2)
    assert path.table().columns["worn_volume"][-1] == pytest.approx(volume * CAP, rel=1e-12)
    if peak is not None:
        assert path[-1].pressure.max() / hertz == pytest.approx(peak, rel=3e-3)
    area = path[-1].area()
    assert area.estimator == "cell-count"
    assert abs(area.value - np.pi * (radius * PIN_CONTACT) ** 2) <= 2.0 * area.uncertainty


@pytest.mark.slow
def test_smaller_increments_change_little():
    depths = [
        wear_pin(3.0, 12, reach=1.7, accuracy=accuracy).table().columns["wear_depth"][-1] for accuracy in (1e-3, 2.5e-4)
    ]
    assert depths[1] == pytest.approx(depths[0], rel=1e-3)


@rc.laws.register("test-explicit-wear")
@attrs.frozen
class ExplicitWear(rc.Process):
    """Archard's law by the pressure at the begin of each increment."""

    rate: float = attrs.field(metadata={"unit": ""})

    remembered: ClassVar = {"height_loss": ("height lost by wear", "m"), "last": ("last pressure", "Pa")}

    def change_gap(self, problem, increment, memory):
        return memory["height_loss"] + self.rate * memory["last"]

    def remember(self, state, increment, memory):
        return {"height_loss": memory["height_loss"] + self.rate * memory["last"], "last": state.pressure}


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_many_explicit_increments_end_where_the_implicit_ones_do(boundary):
    grid = rc.Grid((24, 20), (120e-6, 100e-6))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=0.3e-6, shortest=40e-6, longest=100e-6, seed=2)
    body = rc.Body(surface, STEEL)
    pressure, distance = 200e6, 0.4
    worn = rc.ContactProblem(body, grid=grid, boundary=boundary, laws=rc.Archard(COEFFICIENT)).path(
        pressure=pressure, sliding=[0.0, distance], accuracy=3e-4
    )
    steps = 400
    law = ExplicitWear(COEFFICIENT * distance / steps)
    slow = rc.ContactProblem(body, grid=grid, boundary=boundary, laws=law).sweep(pressure=[pressure] * (steps + 1))
    lost = [path[-1].added[0].memory[0] for path in (worn, slow)]
    depth = lost[0]["worn_height"]
    np.testing.assert_allclose(lost[1]["height_loss"], depth, atol=0.01 * depth.max())
    assert worn.increments[-1] < 60


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_coefficient_for_each_cell_is_solved_as_one_number(boundary):
    surface = rc.SphereSurface(radius=1e-3) if boundary == "free" else rc.WavySurface(1e-6, 50e-6)
    grid = rc.Grid((32, 24), (100e-6, 80e-6) if boundary == "free" else (100e-6, 50e-6))
    paths = []
    for coefficient in (COEFFICIENT, np.full(grid.shape, COEFFICIENT)):
        problem = rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary, laws=rc.Archard(coefficient))
        paths.append(problem.path(pressure=50e6, sliding=[0.0, 1.0]))
    one, other = (path[-1] for path in paths)
    np.testing.assert_allclose(one.pressure, other.pressure, atol=1e-3 * one.pressure.max())


def test_a_hard_patch_wears_less():
    """The half of a pin that does not wear carries the load in the end; each cell loses k p s as the rule says."""
    grid = rc.Grid((33, 33), 150e-6)
    coefficient = np.where(grid.x > 0.0, 10.0 * COEFFICIENT, 0.0) + np.zeros(grid.shape)
    body = rc.Body(rc.SphereSurface(radius=1e-3), STEEL)
    path = rc.ContactProblem(body, grid=grid, laws=rc.Archard(coefficient)).path(force=1.0, sliding=[0.0, 0.1, 1.0])
    last = path[-1]
    assert last.certificate.error < 2e-5
    assert not last.added[0].memory[0]["worn_height"][:17].any()
    assert last.pressure[:17].sum() > 0.9 * last.pressure.sum()


def test_worn_height_is_taken_from_the_body_that_wears():
    body = rc.Body(rc.SphereSurface(radius=1e-3), STEEL)
    flat = rc.Body(rc.FlatSurface(), STEEL)
    grid = rc.Grid((32, 32), 150e-6)
    problem = rc.ContactProblem(body, flat, grid=grid, laws=rc.Archard(COEFFICIENT, of="counterbody"))
    path = problem.path(force=1.0, sliding=[0.0, 1.0])
    ball, worn = path.bodies
    assert ball is body
    lost = -float(worn.heights(grid).sum()) * grid.cell_area
    assert lost == pytest.approx(COEFFICIENT * 1.0 * 1.0, rel=1e-10)


@pytest.mark.parametrize("forces", [1.0, [0.5, 1.0]])
def test_the_convolutions_are_those_of_all_increments(forces):
    """Of the state at the begin of a load that rises too, and of the few increments that were tried and refused."""
    told = []
    body = rc.Body(rc.SphereSurface(radius=1e-3), STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((20, 20), 150e-6), laws=rc.Archard(COEFFICIENT))
    path = problem.path(force=forces, sliding=[0.5, 2.0], on_increment=told.append)
    assert len(told) == sum(path.increments) > 20
    assert 1.0 <= path.convolutions / sum(state.convolutions for state in told) < 1.3


def test_units_by_powers_of_two_change_no_bit():
    found = []
    for scale in (1.0, 2.0**30):
        body = rc.Body(rc.ParaboloidSurface(radius=1e-3), rc.Elastic(young=2e9 * scale, poisson=0.3))
        problem = rc.ContactProblem(body, grid=rc.Grid((24, 24), 100e-6), laws=rc.Archard(COEFFICIENT / scale))
        found.append(problem.path(pressure=1e6 * scale, sliding=[0.0, 1.0])[-1].added[0].memory[0]["worn_height"])
    np.testing.assert_array_equal(*found)


def test_wear_and_flattening_act_together():
    """A step in which the pressure reaches the hardness wears no more than the hardness allows."""
    soft = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=1e9)
    body = rc.Body(rc.SphereSurface(radius=1e-3), soft)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 150e-6), laws=rc.Archard(COEFFICIENT))
    path = problem.path(force=2.0, sliding=[0.0, 0.1, 1.0])
    columns = path.table().columns
    assert columns["worn_volume"][-1] == pytest.approx(COEFFICIENT * 2.0 * 1.0, rel=1e-10)
    assert columns["plastic_work"][-1] == pytest.approx(1e9 * columns["flattened_volume"][-1], rel=1e-10)
    assert np.diff(columns["flattened_volume"]).min() >= 0.0


def test_a_worn_path_comes_back_from_its_file(tmp_path):
    path = wear_pin(0.3, 6, reach=1.5)
    path.save(tmp_path / "path.npz")
    again = rc.load(tmp_path / "path.npz")
    assert str(again) == str(path)
    np.testing.assert_array_equal(again.sliding, path.sliding)


def test_wear_beside_adhesion_is_refused():
    body = rc.Body(rc.ParaboloidSurface(radius=1e-6), rc.Elastic(young=1e9, poisson=0.3))
    law = rc.Exponential(work=0.05, range=8e-9)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 0.8e-6), adhesion=law, laws=rc.Archard(1e-15))
    with pytest.raises(rc.InputError, match="adhesion"):
        problem.path(force=1e-6, sliding=[0.0, 1e-3])


@pytest.mark.parametrize(
    "given", [{"coefficient": -1.0}, {"coefficient": "1MPa"}, {"coefficient": 1e-16, "of": "both"}]
)
def test_a_wrong_law_gets_a_sentence(given):
    with pytest.raises(rc.InputError):
        rc.Archard(**given)


@pytest.mark.slow
def test_the_depth_of_a_pin_is_known_on_twelve_cells():
    depths = [wear_pin(3.0, cells, reach=1.7).table().columns["wear_depth"][-1] for cells in (12, 24)]
    assert depths[0] == pytest.approx(depths[1], rel=1e-3)
