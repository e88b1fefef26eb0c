"""The zone, the imprint and the curve of an indentation, and its first yield: closed forms and energy."""

import attrs
import numpy as np
import pytest
import roughcontact as rc

from roughcontact_volume import FindImprint, FindOwnYield, FindPlasticZone, find_indentation
from test_process import FIRST_FORCE, FIRST_RADIUS, LIMIT, MODULUS, POISSON, RADIUS, YOUNG, make_ball, numbers, read

FORCE = 5.0 * FIRST_FORCE


@pytest.fixture(scope="module")
def path():
    """A ball that is pressed and lifted."""
    parts = np.array([0.1, 0.25, 0.4, 0.6, 0.8, 1.0, 0.75, 0.5, 0.25, 0.1, 0.0])
    return make_ball(cells=21, width=6.5).path(force=FORCE * parts)


@pytest.fixture(scope="module")
def found(path):
    """What it tells as an indentation."""
    return find_indentation(path)


class TestIndentation:
    def test_work_is_that_of_the_flow_the_residual_stress_and_the_pressure(self, found):
        table = found.table().columns
        assert found.work == pytest.approx(found.energies.sum(axis=1), abs=0.03 * found.work[5])
        assert found.lost[10] == table["plastic_work"][10] + table["residual_energy"][10]
        assert np.all(np.diff(table["plastic_work"]) >= 0.0)
        assert table["elastic_energy"][10] == 0.0

    def test_below_first_yield_it_is_hertz(self):
        force = 0.8 * FIRST_FORCE
        hertz = find_indentation(make_ball(cells=31, width=3.0).path(force=[0.4 * force, force, 0.0]))
        radius = (3.0 * force * RADIUS / (4.0 * MODULUS)) ** (1.0 / 3.0)
        area = np.pi * radius**2
        # Of a paraboloid the contact depth of Oliver and Pharr is that of Hertz.
        for one in (hertz.area, hertz.read_area):
            assert one.value == pytest.approx(area, rel=0.01)
        assert hertz.hardness.value == pytest.approx(force / area, rel=0.01)
        assert hertz.stiffness.value == pytest.approx(2.0 * radius * MODULUS, rel=0.01)
        assert hertz.read_modulus.value == pytest.approx(MODULUS, rel=0.01)
        assert not hertz.lost.any()
        assert hertz.energies[1, 2] == pytest.approx(0.4 * force * radius**2 / RADIUS, rel=0.01)

    def test_is_within_the_published_hardness(self, path, found):
        assert found.hardness.value == pytest.approx(FORCE / path[5].area().value)
        # From 1.07 Y at first yield to 2.8 Y; a ball at five times its load is near the former.
        assert 1.3 * LIMIT < found.hardness.value < 1.8 * LIMIT
        assert found.read_hardness.value == pytest.approx(found.hardness.value, rel=0.05)
        assert found.read_modulus.value == pytest.approx(found.modulus, rel=0.05)

    def test_stiffness_is_the_slope_of_the_unloading(self, path, found):
        problem = make_ball(cells=21, width=6.5)
        begin = problem.path(force=FORCE * np.array([0.1, 0.25, 0.4, 0.6, 0.8, 1.0]))
        small = begin.extend(force=[0.98 * FORCE])
        slope = (small.force[-2] - small.force[-1]) / (small.approach[-2] - small.approach[-1])
        assert found.stiffness.value == pytest.approx(slope, rel=0.04)

    @pytest.mark.parametrize(
        ("make", "sentence"),
        [
            (lambda: make_ball().path(force=[FIRST_FORCE, 0.0])[1:], "no load"),
            (lambda: make_ball(boundary="periodic").path(force=FIRST_FORCE, shift=[(0, 0), (2, 0)]), "shift="),
        ],
    )
    def test_refusals(self, make, sentence):
        with pytest.raises(rc.InputError, match=sentence):
            find_indentation(make())

    def test_warns_where_strains_are_not_small(self):
        soft = make_ball(cells=15, width=20.0, accuracy=1.0, hardening=None)
        warnings = find_indentation(soft.path(force=[60.0 * FIRST_FORCE, 120.0 * FIRST_FORCE])).warnings
        assert any("strains are taken as small" in text for text in warnings)


class TestZone:
    def test_is_that_of_the_process(self, path):
        state = path[5]
        zone = state.response(FindPlasticZone())
        stated = numbers(state)
        assert zone.volume.value == pytest.approx(stated["plastic_volume"])
        assert zone.depth.value == pytest.approx(stated["plastic_depth"])
        assert zone.largest.value == stated["plastic_strain"]
        assert 0.3 * FIRST_RADIUS < zone.largest.depth < 1.2 * FIRST_RADIUS
        table = zone.table().columns
        assert table["area"] @ np.diff(zone.interfaces) == pytest.approx(zone.volume.value)
        assert table["largest_strain"].max() == zone.largest.value

    def test_uncertainty_covers_another_grid(self, path):
        other = make_ball(cells=34, width=6.5).solve(force=FORCE).response(FindPlasticZone())
        zone = path[5].response(FindPlasticZone())
        for one, two in zip(zone.estimates.values(), other.estimates.values(), strict=True):
            assert abs(one.value - two.value) < 2.0 * np.hypot(one.uncertainty, two.uncertainty)
            assert one.uncertainty < 0.25 * one.value

    def test_file_for_paraview(self, path, tmp_path):
        pyvista = pytest.importorskip("pyvista")
        path[5].response(FindPlasticZone()).save(tmp_path / "zone.vtr")
        mesh = pyvista.read(tmp_path / "zone.vtr")
        assert mesh.cell_data["accumulated_strain"].max() == read(path[5])["accumulated_strain"].max()

    def test_of_a_body_that_never_flowed(self):
        zone = make_ball().solve(force=0.5 * FIRST_FORCE).response(FindPlasticZone())
        assert [one.value for one in zone.estimates.values()] == [0.0, 0.0, 0.0]
        assert [one.uncertainty for one in zone.estimates.values()] == [0.0, 0.0, 0.0]


class TestImprint:
    def test_is_that_of_the_process_and_of_the_bodies(self, path):
        imprint = path[10].response(FindImprint())
        assert imprint.estimates["depth"].value == numbers(path[10])["imprint_depth"]
        assert imprint.estimates["pile_up"].value == numbers(path[10])["pile_up"]
        lifted = make_ball(cells=21, width=6.5).path(force=[FORCE, 0.0])
        with pytest.warns(rc.ContactWarning, match="residual stress and the hardening"):
            _, flat = lifted.bodies
        left = lifted[1].response(FindImprint()).displacement
        assert flat.heights(lifted[1].grid) == pytest.approx(-left, abs=1e-15)

    def test_uncertainty_covers_another_grid(self):
        one, other = (
            make_ball(cells=cells, width=5.0, accuracy=0.05).solve(force=3.0 * FIRST_FORCE).response(FindImprint())
            for cells in (13, 23)
        )
        for coarse, fine in zip(one.estimates.values(), other.estimates.values(), strict=True):
            assert 0.0 < fine.uncertainty < coarse.uncertainty < 0.3 * coarse.value
            assert abs(coarse.value - fine.value) < 2.0 * np.hypot(coarse.uncertainty, fine.uncertainty)


class TestOwnYield:
    @pytest.mark.parametrize("parts", [[0.5], [3.0], [3.0, 0.0]])
    def test_is_that_of_hertz_whatever_the_load(self, parts):
        # Von Mises stress on the axis over the largest pressure, at depths over the radius.
        z = np.linspace(0.4, 0.6, 2001)
        stress = np.abs((1.0 + POISSON) * (1.0 - z * np.arctan(1.0 / z)) - 1.5 / (1.0 + z**2))
        peak = LIMIT / stress.max()
        force = np.pi**3 * RADIUS**2 * peak**3 / (6.0 * MODULUS**2)
        depth = z[stress.argmax()] * np.pi * peak * RADIUS / (2.0 * MODULUS)
        state = make_ball(cells=30, width=3.0).path(force=FIRST_FORCE * np.array(parts))[-1]
        found = state.response(FindOwnYield())
        assert abs(found.force.value - force) < 2.0 * found.force.uncertainty
        assert found.maximum.depth == pytest.approx(depth, rel=0.05)

    def test_needs_a_body_that_yields(self):
        flat = rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, POISSON))
        state = attrs.evolve(make_ball(), counterbody=flat, laws=()).solve(force=FIRST_FORCE)
        with pytest.raises(rc.InputError, match="ask for 'first-yield'"):
            state.response(FindOwnYield())
