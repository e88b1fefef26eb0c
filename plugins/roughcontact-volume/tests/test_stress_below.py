"""The stress below bodies that have flowed: closed forms, equilibrium, what it is made of, and its file."""

import attrs
import numpy as np
import pytest
import roughcontact as rc

from roughcontact_volume import FindResidualStress, FindTotalStress, VolumeOperators
from test_process import FIRST_FORCE, FIRST_RADIUS, LIMIT, POISSON, YOUNG, make_ball, read


@pytest.fixture(scope="module")
def path():
    """A ball that is pressed and lifted."""
    return make_ball(hardening=None).path(force=[5.0 * FIRST_FORCE, 0.0])


@pytest.fixture(scope="module")
def stress(path):
    """The residual stress that it leaves."""
    return path[1].response(FindResidualStress())


def test_nothing_is_left_by_a_load_below_first_yield():
    state = make_ball(cells=21, width=4.0).solve(force=0.8 * FIRST_FORCE)
    left = state.response(FindResidualStress(depth=2.0 * FIRST_RADIUS))
    assert not left.components.any()
    assert left.maximum.value == left.maximum.uncertainty == 0.0
    # There it is the stress of the elastic contact, whose maximum is by Hertz 0.62 of the largest pressure.
    found = state.response(FindTotalStress())
    largest = 0.62 * 1.6 * LIMIT * 0.8 ** (1.0 / 3.0)
    assert found.maximum.value == pytest.approx(largest, abs=2.0 * found.maximum.uncertainty)
    assert abs(found.maximum.depth - 0.48 * FIRST_RADIUS) < 0.25 * FIRST_RADIUS
    elastic = state.stress(found.depths[1:4], body="counterbody").components
    middle = found.components[:, 1:4].swapaxes(0, 1)
    assert middle == pytest.approx(elastic, abs=0.04 * LIMIT)


def test_residual_stress_is_left_by_the_unloading(path):
    loaded, lifted = (state.response(FindResidualStress()) for state in path)
    assert np.array_equal(loaded.components, lifted.components)
    assert path[1].response(FindTotalStress()).components == pytest.approx(lifted.components, abs=1e-9 * LIMIT)
    # Compression in the zone, tension below it.
    profile = lifted.find_profile().columns
    assert profile["xx"].min() < -0.15 * LIMIT
    assert profile["xx"][np.argmin(profile["xx"]) :].max() > 0.02 * LIMIT
    assert profile["xx"] == pytest.approx(profile["yy"], abs=1e-4 * LIMIT)


def test_total_stress_is_that_of_pressure_and_plastic_strain_within_the_yield_stress(path):
    state = path[0]
    found = state.response(FindTotalStress(depth=4.0 * FIRST_RADIUS))
    operators = VolumeOperators(state.grid, rc.Boundary.FREE, np.diff(found.interfaces), YOUNG, POISSON)
    strain = np.zeros(operators.shape)
    strain[:, : read(state)["plastic_strain"].shape[1]] = read(state)["plastic_strain"]
    total = operators.press(state.pressure) + operators.find_stress(strain)
    assert found.components == pytest.approx(total, abs=1e-9 * LIMIT)
    assert found.maximum.value == pytest.approx(LIMIT, rel=3e-4)
    assert found.interfaces[-1] >= 4.0 * FIRST_RADIUS
    with pytest.raises(rc.InputError, match="ask for the response 'total-stress'"):
        state.stress(body="counterbody")


def test_residual_stress_is_in_equilibrium():
    problem = make_ball(cells=14, boundary="periodic")
    state = problem.path(force=[4.0 * FIRST_FORCE, 0.0])[1]
    found = state.response(FindResidualStress(depth=5.0 * problem.plan.grid.size[0]))
    xx, _, zz, yz, xz, _ = found.components
    size = np.abs(xx).max()
    for component in (zz, yz, xz):
        assert np.abs(component.mean(axis=(1, 2))).max() < 1e-10 * size
    # The forces through all planes across x are the same.
    forces = np.einsum("z,zxy->x", np.diff(found.interfaces), xx)
    assert np.ptp(forces) < 1e-5 * np.einsum("z,zxy->x", np.diff(found.interfaces), np.abs(xx)).max()


def test_uncertainty_of_the_maximum_covers_more_substeps():
    coarse, fine = (
        make_ball(cells=17, width=7.0, accuracy=accuracy)
        .solve(force=8.0 * FIRST_FORCE)
        .response(FindResidualStress())
        .maximum
        for accuracy in (0.5, 0.01)
    )
    assert abs(coarse.value - fine.value) < 2.0 * np.hypot(coarse.uncertainty, fine.uncertainty)
    assert fine.uncertainty < coarse.uncertainty < 0.3 * coarse.value


def test_lies_in_the_frame_of_its_body():
    grid = rc.Grid((16, 12), (6.4 * FIRST_RADIUS, 4.8 * FIRST_RADIUS))
    problem = make_ball(grid=grid, of="counterbody", boundary="periodic")
    path = problem.path(force=3.0 * FIRST_FORCE, shift=[(0, 0), (-3, 1)])
    for state in path:
        memory = read(state)
        total = state.response(FindTotalStress(depth=0.5 * FIRST_RADIUS))
        flowing = memory["last_flow"].any(axis=0)[: len(total.depths)]
        limit = LIMIT + 4e9 * memory["accumulated_strain"][: len(total.depths)]
        assert total.von_mises[flowing] == pytest.approx(limit[flowing], rel=3e-4)


class TestPlaces:
    def test_profiles_are_linear_between_the_cells(self, stress):
        x, y = stress.grid.x[:, 0], stress.grid.y[0]
        at = stress.find_profile(x[4], y[9]).columns
        assert np.array_equal(at["zz"], stress.components[2, :, 4, 9])
        between = stress.find_profile(0.5 * (x[4] + x[5]), y[9]).columns
        assert between["xz"] == pytest.approx(stress.components[4, :, 4:6, 9].mean(axis=-1), abs=1e-6 * LIMIT)
        assert stress.find_profile("1um").columns["von_mises"].shape == stress.depths.shape

    def test_planes(self, stress):
        x, y = stress.grid.x[:, 0], stress.grid.y[0]
        assert stress.cut(x=x[3]) == pytest.approx(stress.components[:, :, 3], abs=1e-6 * LIMIT)
        assert stress.cut(y=y[-1]) == pytest.approx(stress.components[..., -1], abs=1e-6 * LIMIT)
        assert np.array_equal(stress.cut(depth=stress.depths[2]), stress.components[:, 2])

    @pytest.mark.parametrize(
        ("ask", "sentence"),
        [
            (lambda stress: stress.cut(), "one place"),
            (lambda stress: stress.cut(x=0.0, depth=1e-6), "one place"),
            (lambda stress: stress.cut(x=1.0), "The place along x"),
            (lambda stress: stress.cut(depth="1m"), "The depth"),
            (lambda stress: stress.find_profile(y="deep"), "The place along y"),
            (lambda stress: stress.save("stress.txt"), "vtr"),
        ],
    )
    def test_refusals(self, stress, ask, sentence):
        with pytest.raises(rc.InputError, match=sentence):
            ask(stress)

    def test_file_for_paraview(self, stress, tmp_path):
        pyvista = pytest.importorskip("pyvista")
        stress.save(tmp_path / "stress.vtr")
        mesh = pyvista.read(tmp_path / "stress.vtr")
        nz, nx, ny = stress.von_mises.shape
        values = mesh.cell_data["stress_xz"].reshape(nz, ny, nx)[::-1].swapaxes(1, 2)
        assert np.array_equal(values, stress.components[4])
        assert mesh.bounds[4:] == pytest.approx((-stress.interfaces[-1], 0.0))
        assert mesh.bounds[1] == pytest.approx(0.5 * stress.grid.size[0])


def test_a_contact_in_which_nothing_can_flow():
    problem = make_ball()
    flat = rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, POISSON))
    state = attrs.evolve(problem, counterbody=flat, laws=()).solve(force=FIRST_FORCE)
    with pytest.raises(rc.InputError, match="give one of them the material Plastic"):
        state.response(FindResidualStress())


def test_a_depth_that_is_none():
    with pytest.raises(rc.InputError, match="The depth of the stress"):
        FindTotalStress(depth=-1.0)
