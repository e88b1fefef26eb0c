"""Wear by the energy that friction loses: cycles of loads, closed forms, invariance, files."""

import html
import re
import runpy

import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(young=210e9, poisson=0.3)
ALUMINIUM = rc.Elastic(young=70e9, poisson=0.33)
FRICTION = 0.3
PARTIAL = {"tangential_force": [(0.18, 0.0), (-0.18, 0.0)]}
# Six times the displacement from which a ball slides.
GROSS = {"displacement": [(7.5e-7, 0.0), (-7.5e-7, 0.0)]}


def press_ball(coefficient, shape=(24, 24), size=(100e-6, 100e-6), other=STEEL, **parts):
    ball = rc.Body(rc.ParaboloidSurface(radius=1e-3), STEEL)
    laws = rc.EnergyWear(coefficient)
    return rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), other), grid=rc.Grid(shape, size), laws=laws, **parts)


def fret(problem, cycles, loads=PARTIAL, **options):
    return problem.path(force=1.0, friction=FRICTION, cycles=cycles, **{**loads, **options})


def worn(state):
    """Return what the law remembers: height lost, m, and energy per area, J/m2."""
    memory = next(one for one in state.added if one.kind == "laws").memory[0]
    return memory["worn_height"], memory["friction_work"]


def numbers(state):
    return {name: value for name, (value, _) in state.added[-1].numbers.items()}


@pytest.mark.parametrize("loads", [PARTIAL, GROSS])
def test_the_volume_is_the_energy_times_the_coefficient(loads):
    coefficient = 1e-14
    path = fret(press_ball(coefficient), [1, 2, 200], loads)
    for state in path:
        found = numbers(state)
        assert found["worn_volume"] == pytest.approx(coefficient * found["friction_work"], rel=1e-13)
    # Each step of the first two cycles stands for itself.
    lost = sum(state.dissipated.value for state in path[:4])
    assert numbers(path[3])["friction_work"] == pytest.approx(lost, rel=1e-12)
    assert path.cycles.tolist() == [1, 1, 2, 2, 200, 200]
    assert path[-1].sheared.residuals.energy < 1e-13
    path.verify()


@pytest.mark.slow
def test_in_sliding_it_is_the_law_of_archard():
    """Of the same volume, by another road: implicit increments of a contact without friction."""
    far = {"displacement": [(1e-5, 0.0), (-1e-5, 0.0)]}
    last = fret(press_ball(5e-14), [260], far, accuracy=5e-3)[-1]
    volume = numbers(last)["worn_volume"]
    ball = press_ball(0.0)
    rubbed = rc.ContactProblem(ball.body, ball.counterbody, grid=ball.grid, laws=rc.Archard(1e-16))
    alone = rubbed.path(force=1.0, sliding=[0.0, volume / 1e-16])[-1]
    height, other = worn(last)[0], alone.added[0].memory[0]["worn_height"]
    assert height.max() > 0.2 * last.approach
    np.testing.assert_allclose(height, other, atol=3e-3 * other.max())
    assert last.approach == pytest.approx(alone.approach, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("loads", "depth", "bound"), [(PARTIAL, 0.04, 0.01), (GROSS, 0.4, 2e-3)])
def test_smaller_jumps_change_little(loads, depth, bound):
    """Partial slip, all of whose wear is on a ring, needs jumps of a thousandth of the approach; sliding does not."""
    fresh = press_ball(0.0).path(force=1.0, friction=FRICTION, **loads)
    coefficient = depth * fresh[0].approach / (1e4 * fresh.work[-1].max())
    found = [
        worn(fret(press_ball(coefficient), [10000], loads, accuracy=accuracy)[-1])[0].max()
        for accuracy in np.array([2.0, 1.0, 0.5]) * (4e-3 if loads is PARTIAL else 3e-2)
    ]
    assert found[-1] > depth * fresh[0].approach
    changes = np.abs(np.diff(found)) / found[-1]
    assert changes[1] < bound
    # First order in the jumps.
    assert changes[1] < 0.7 * changes[0]


@pytest.mark.slow
def test_jumps_end_where_every_cycle_does():
    coefficient = 2e-12
    often = fret(press_ball(coefficient), [1, 40], accuracy=1e-9)
    jumps = fret(press_ball(coefficient), [1, 40], accuracy=2e-3)
    assert "last of 39 computed for 39" in often.reasons[-1]
    assert int(jumps.reasons[-1].split(" computed")[0].split()[-1]) < 15
    height = worn(often[-1])[0]
    np.testing.assert_allclose(worn(jumps[-1])[0], height, atol=0.02 * height.max())


def test_a_path_without_cycles_wears_as_its_cycles():
    """Two cycles written out are two cycles."""
    coefficient = 1e-12
    loads = PARTIAL["tangential_force"]
    out = press_ball(coefficient).path(force=1.0, tangential_force=loads * 2, friction=FRICTION, substeps=1)
    again = fret(press_ball(coefficient), [1, 2])
    np.testing.assert_allclose(worn(out[-1])[0], worn(again[-1])[0], atol=1e-5 * worn(out[-1])[0].max())


def test_a_coefficient_for_each_cell_and_the_body_that_wears():
    field = np.full((24, 24), 1e-13)
    field[:, 12:] = 0.0
    problem = press_ball(field)
    path = fret(problem, [1, 50])
    height, work = worn(path[-1])
    np.testing.assert_allclose(height, field * work)
    assert not height[:, 12:].any()
    assert work[:, 12:].any()
    law = rc.EnergyWear(field, of="counterbody")
    other = fret(rc.ContactProblem(problem.body, problem.counterbody, grid=problem.grid, laws=law), [1, 50])
    for one, wears in ((path, 0), (other, 1)):
        bodies = one.bodies
        assert bodies[1 - wears] is (problem.body, problem.counterbody)[1 - wears]
        lost = (problem.body, problem.counterbody)[wears].heights(problem.grid) - bodies[wears].heights(problem.grid)
        np.testing.assert_allclose(lost, height, atol=1e-7 * height.max())


class TestInvariance:
    """Turned and scaled contacts, and unlike bodies that exchange their places."""

    @pytest.mark.slow
    @pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
    def test_exchange_of_the_axes(self, other):
        options = {"solver": rc.ProjectedConjugateGradient(tolerance=1e-7), "other": other}
        one = press_ball(1e-13, (20, 32), (75e-6, 100e-6), **options)
        turned = press_ball(1e-13, (32, 20), (100e-6, 75e-6), **options)
        loads = {"tangential_force": [(0.1, 0.05), (-0.1, 0.0)], "substeps": 2}
        mirrored = {"tangential_force": [(0.05, 0.1), (0.0, -0.1)], "substeps": 2}
        path, other_path = fret(one, [1, 100], loads), fret(turned, [1, 100], mirrored)
        height = worn(path[-1])[0]
        np.testing.assert_allclose(worn(other_path[-1])[0].T, height, atol=1e-3 * height.max())

    @pytest.mark.parametrize("other", [STEEL, ALUMINIUM])
    def test_units_by_powers_of_two_change_no_bit(self, other):
        found = []
        for scale in (1.0, 2.0**20):
            bodies = [
                rc.Body(surface, rc.Elastic(young=material.young * scale, poisson=material.poisson))
                for surface, material in ((rc.ParaboloidSurface(radius=1e-3), STEEL), (rc.FlatSurface(), other))
            ]
            laws = rc.EnergyWear(1e-13 / scale)
            problem = rc.ContactProblem(*bodies, grid=rc.Grid((16, 16), 100e-6), laws=laws)
            force = [(0.18 * scale, 0.0), (-0.18 * scale, 0.0)]
            path = problem.path(force=scale, tangential_force=force, friction=0.3, cycles=[1, 60], substeps=2)
            found.append(worn(path[-1])[0])
        np.testing.assert_array_equal(*found)


def test_wear_and_flattening_act_together():
    soft = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=1e9)
    body = rc.Body(rc.ParaboloidSurface(radius=1e-3), soft)
    flat = rc.Body(rc.FlatSurface(), STEEL)
    problem = rc.ContactProblem(body, flat, grid=rc.Grid((24, 24), 100e-6), laws=rc.EnergyWear(1e-13))
    path = fret(problem, [1, 50])
    found = numbers(path[-1])
    assert found["worn_volume"] == pytest.approx(1e-13 * found["friction_work"], rel=1e-12)
    assert found["plastic_work"] == pytest.approx(1e9 * found["flattened_volume"], rel=1e-10)
    path.verify()


@pytest.fixture(scope="module")
def fretted():
    return fret(press_ball(1e-13), [1, 30])


class TestFiles:
    """What is read again is what was followed, and is followed on."""

    def test_a_path_in_a_file(self, fretted, tmp_path):
        fretted.save(tmp_path / "path.npz")
        again = rc.load(tmp_path / "path.npz")
        assert str(again) == str(fretted)
        assert again.cycles.tolist() == [1, 1, 30, 30]
        np.testing.assert_array_equal(worn(again[-1])[0], worn(fretted[-1])[0])

    def test_its_arguments_follow_it_again(self, fretted):
        again = press_ball(1e-13).path(**fretted.list_arguments())
        np.testing.assert_array_equal(worn(again[-1])[0], worn(fretted[-1])[0])

    def test_a_path_is_followed_on_from_its_file(self, fretted, tmp_path):
        fretted.save(tmp_path / "path.npz")
        longer = rc.load(tmp_path / "path.npz").extend(cycles=[60, 90])
        whole = fret(press_ball(1e-13), [1, 30, 60, 90])
        assert longer.cycles.tolist() == whole.cycles.tolist()
        assert longer.reasons == whole.reasons
        np.testing.assert_array_equal(worn(longer[-1])[0], worn(whole[-1])[0])
        with pytest.raises(rc.InputError, match="ends with cycle 30"):
            fretted.extend(cycles=[10])
        with pytest.raises(rc.InputError, match="loads that do not return"):
            fretted.extend(tangential_force=(0.1, 0.0))

    @pytest.mark.slow
    @pytest.mark.parametrize("loads", [PARTIAL, {"displacement": [(4e-8, 0.0), (8e-8, 2e-8), (-8e-8, 0.0)]}])
    def test_unlike_bodies_go_on_to_the_same_bits(self, loads):
        """Of cycles in several increments, whose wear is of all of them."""
        problem = press_ball(1e-12, other=ALUMINIUM)
        whole = fret(problem, [1, 20, 50], loads, substeps=2)
        longer = fret(problem, [1, 20], loads, substeps=2).extend(cycles=[50], substeps=2)
        assert longer.reasons == whole.reasons
        np.testing.assert_array_equal(worn(longer[-1])[0], worn(whole[-1])[0])
        np.testing.assert_array_equal(longer[-1].shear, whole[-1].shear)
        assert longer.cycle_wear == whole.cycle_wear > 0.0

    @pytest.mark.slow
    def test_the_script_of_its_page_follows_it_again(self, fretted, tmp_path):
        script = re.search(r"<h2>Run it again</h2>\s*<pre><code>(.*?)</code>", fretted.to_html(), re.DOTALL)[1]
        (tmp_path / "again.py").write_text(html.unescape(script))
        again = runpy.run_path(str(tmp_path / "again.py"))["path"]
        np.testing.assert_array_equal(worn(again[-1])[0], worn(fretted[-1])[0])

    def test_texts_and_tables(self, fretted):
        found = fretted.table()
        assert found.columns["cycle"].tolist() == [1, 1, 30, 30]
        assert np.all(np.diff(found.columns["worn_volume"]) > 0.0)
        assert (found.units["worn_volume"], found.units["friction_work"]) == ("m3", "J")
        assert "worn volume" in str(fretted)
        assert "energy lost" not in str(fretted)
        assert "of cycle 30, the last of" in fretted.explain()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"cycles": [0, 1]}, "at least 1"),
        ({"cycles": [1.5]}, "whole numbers"),
        ({"cycles": [10, 5]}, "rise"),
        ({"cycles": []}, "cycles"),
        ({"cycles": 5}, "cycles"),
        ({"cycles": [1], "force": [1.0, 2.0]}, "substeps="),
        ({"cycles": [1], "accuracy": 2.0}, "accuracy"),
    ],
)
def test_what_does_not_fit_gets_a_sentence(options, said):
    arguments = {"force": 1.0, "friction": 0.3, **PARTIAL, **options}
    with pytest.raises(rc.InputError, match=said):
        press_ball(1e-14).path(**arguments)


def test_cycles_need_friction_and_a_law_of_wear():
    ball = press_ball(1e-14)
    with pytest.raises(rc.InputError, match="cycles= of a path is used only with friction"):
        ball.path(force=1.0, cycles=[1, 2])
    elastic = rc.ContactProblem(ball.body, ball.counterbody, grid=ball.grid)
    with pytest.raises(rc.InputError, match="EnergyWear"):
        fret(elastic, [1, 2])
    with pytest.raises(rc.InputError, match="neither time nor"):
        fret(rc.ContactProblem(ball.body, ball.counterbody, grid=ball.grid, laws=rc.Archard(1e-16)), [1, 2])
