"""A surface of one's own that wraps another is treated like those that ship."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import roughcontact as rc
from scenes import WRAPPERS, Doubled, DoubledPlain, make_problem

SIZE = 32e-6
GRID = rc.Grid((32, 32), SIZE)
STEEL = rc.Elastic(200e9, 0.3)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=5e-8, longest=SIZE, shortest=8e-6, seed=3)
FLAT = rc.FlatSurface()
MASK = np.zeros(GRID.shape, dtype=bool)
MASK[4:9, 20:25] = True
MAP = rc.HeightMap(ROUGH.heights(GRID), SIZE, periodic=True, history=("polished",))
INNER = [MAP, ROUGH, rc.WavySurface(1e-8, SIZE), rc.SphereSurface(1e-3)]


@attrs.frozen
class Highest(rc.Surface):
    """The highest of several surfaces and a plane."""

    several: tuple[rc.Surface, ...]
    plane: rc.Surface = FLAT

    def heights(self, grid):
        return np.maximum.reduce([part.heights(grid) for part in (*self.several, self.plane)])


def problem(surface, boundary="periodic", **options):
    return make_problem(surface, STEEL, **{"grid": None, "boundary": boundary, **options})


@pytest.mark.parametrize("wrapper", WRAPPERS)
class TestParts:
    """What a wrapper knows it knows from its parts."""

    def test_grid_provenance_and_non_measured_points(self, wrapper):
        incomplete = attrs.evolve(MAP, non_measured=MASK)
        surface = wrapper(incomplete)
        assert surface.parts == (incomplete,)
        contact = problem(surface)
        assert contact.plan.grid == GRID
        assert contact.plan.histories == (("polished",), ())
        np.testing.assert_array_equal(contact.plan.non_measured, MASK)
        assert not contact.solve(pressure=1e8).contact[MASK].any()

    def test_a_free_surface_stays_free(self, wrapper):
        surface = wrapper(ROUGH)
        assert surface.own_grid is None
        assert surface.non_measured_on(GRID) is None
        assert surface.resample_to(rc.Grid((64, 64), SIZE)) is surface
        with pytest.raises(rc.InputError, match="carry no grid"):
            problem(surface)

    def test_it_is_solved_as_the_heights_it_gives(self, wrapper):
        plain = rc.HeightMap(2 * MAP.values, SIZE, periodic=True)
        one, other = (problem(surface).solve(pressure=1e8) for surface in (plain, wrapper(MAP)))
        np.testing.assert_array_equal(one.pressure, other.pressure)

    def test_it_is_refined_and_extrapolated_as_the_heights_it_gives(self, wrapper):
        plain = rc.HeightMap(2 * MAP.values, SIZE, periodic=True)
        one, other = (rc.on_grid(problem(surface), (64, 64)).solve(pressure=1e8) for surface in (plain, wrapper(MAP)))
        assert one.area().value == other.area().value
        ladders = [rc.extrapolate(problem(surface), pressure=1e8, levels=2) for surface in (plain, wrapper(MAP))]
        assert ladders[0].area.value == ladders[1].area.value

    def test_seeds_reach_the_random_surface_inside(self, wrapper):
        assert wrapper(MAP).reseed(1) is None
        surface = wrapper(rc.WavySurface(1e-8, SIZE) + ROUGH)
        expected = rc.WavySurface(1e-8, SIZE) + attrs.evolve(ROUGH, seed=10)
        np.testing.assert_array_equal(surface.reseed(7).heights(GRID), 2 * expected.heights(GRID))

    @pytest.mark.parametrize("inner", INNER)
    def test_it_is_moved_with_its_parts(self, wrapper, inner):
        moved = wrapper(inner).shift_half_cell(GRID, periodic=True).heights(GRID)
        np.testing.assert_array_equal(moved, 2 * inner.shift_half_cell(GRID, periodic=True).heights(GRID))


def test_a_shift_by_two_half_cells_is_one_by_a_cell():
    fine = rc.Grid((64, 64), SIZE)
    for surface in (ROUGH, Doubled(ROUGH), rc.HeightMap(ROUGH.heights(fine), SIZE, periodic=True)):
        once = rc.HeightMap(surface.shift_half_cell(fine, periodic=True).heights(fine), SIZE, periodic=True)
        twice = once.shift_half_cell(fine, periodic=True).heights(fine)
        np.testing.assert_allclose(twice, np.roll(surface.heights(fine), (1, 1), axis=(0, 1)), atol=1e-20)


def test_surfaces_in_tuples_are_parts_too():
    surface = Highest((rc.WavySurface(1e-8, SIZE), ROUGH))
    assert surface.parts == (rc.WavySurface(1e-8, SIZE), ROUGH, rc.FlatSurface())
    assert surface.reseed(2) == Highest((rc.WavySurface(1e-8, SIZE), attrs.evolve(ROUGH, seed=5)))
    assert surface.with_parts([MAP, ROUGH, ROUGH]) == Highest((MAP, ROUGH), ROUGH)
    with pytest.raises(rc.InputError, match="a list of 3 surfaces, but got 2"):
        surface.with_parts([MAP, ROUGH])


def test_non_measured_points_are_not_shifted():
    with pytest.raises(rc.InputError, match="non-measured points cannot be shifted"):
        Doubled(attrs.evolve(MAP, non_measured=MASK)).shift_half_cell(GRID, periodic=True)


@pytest.fixture
def registered():
    rc.surfaces.register("doubled")(Doubled)
    yield
    del rc.surfaces._classes["doubled"]


@pytest.mark.usefixtures("registered")
def test_a_study_varies_the_seed_inside(tmp_path):
    study = rc.Study(problems=problem(Doubled(ROUGH), grid=GRID), pressure=[1e8], seeds=[0, 1])
    areas = [record.areas["blend"][0] for record in study.run(tmp_path).records]
    assert areas[0] == problem(Doubled(ROUGH), grid=GRID).solve(pressure=1e8).area().value
    assert areas[1] == problem(Doubled(attrs.evolve(ROUGH, seed=4)), grid=GRID).solve(pressure=1e8).area().value
    with pytest.raises(rc.InputError, match="no surface of the problem 'problem' has one"):
        rc.Study(problems=problem(Doubled(MAP)), pressure=[1e8], seeds=[1])


def test_a_wrapper_is_saved_and_loaded(tmp_path):
    solution = problem(Doubled(MAP)).solve(pressure=1e8)
    with pytest.warns(UserWarning, match="Doubled must be registered"):
        solution.save(tmp_path / "x.npz")
    loaded = rc.ContactSolution.load(tmp_path / "x.npz", verify=False)
    np.testing.assert_array_equal(loaded.pressure, solution.pressure)


@pytest.mark.usefixtures("registered")
def test_a_registered_wrapper_is_solved_again_from_its_file(tmp_path):
    solution = problem(Doubled(MAP + rc.WavySurface(1e-8, SIZE))).solve(pressure=1e8)
    solution.save(tmp_path / "x.npz")
    origin = rc.ContactSolution.load(tmp_path / "x.npz").origin
    again = rc.ContactProblem(**origin.problem).solve(**origin.load)
    np.testing.assert_array_equal(again.pressure, solution.pressure)


class TestContract:
    """Attributes of one's own are not mistaken, and mistakes get a sentence."""

    def test_an_attribute_named_history_stays_the_users(self):
        @attrs.frozen
        class Ground(rc.Surface):
            history: str = "ground"
            grid: str = "cast iron"

            def heights(self, grid):
                return ROUGH.heights(grid)

        plan = problem(Ground(), grid=GRID).plan
        assert plan.histories == ((), ())
        assert "g; r; o" not in str(plan)

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("provenance", "ground"),
            ("own_grid", (32, 32)),
            ("parts", 3),
            ("parts", ("inner",)),
            ("non_measured_on", lambda grid: np.zeros((3, 3), dtype=bool)),
            ("non_measured_on", lambda grid: np.zeros(grid.shape)),
        ],
    )
    def test_a_wrong_answer_is_named(self, name, value):
        answer = staticmethod(value) if callable(value) else value
        wrong = type("Wrong", (rc.Surface,), {name: answer, "heights": lambda self, grid: ROUGH.heights(grid)})
        with pytest.raises(rc.InputError, match="Wrong"):
            problem(wrong(), grid=None if name == "own_grid" else GRID)

    def test_a_plain_class_without_with_parts_is_told_what_to_define(self):
        class Plain(rc.Surface):
            def __init__(self, inner):
                self.inner = inner

            heights = DoubledPlain.heights

        assert problem(Plain(ROUGH), grid=GRID).solve(pressure=1e8).status.success
        for use in (lambda s: s.reseed(1), lambda s: s.shift_half_cell(GRID, periodic=True)):
            with pytest.raises(rc.InputError, match=r"define Plain\.with_parts"):
                use(Plain(ROUGH))

    def test_a_surface_that_stretches_its_parts_is_not_moved_with_them(self):
        @attrs.frozen
        class Stretched(Doubled):
            def heights(self, grid):
                return self.inner.heights(rc.Grid(grid.shape, (0.5 * grid.size[0], 0.5 * grid.size[1])))

        with pytest.raises(rc.InputError, match="moves or stretches its parts"):
            Stretched(ROUGH).shift_half_cell(GRID, periodic=True).heights(GRID)

    def test_a_gridded_surface_of_ones_own_is_not_resampled(self):
        @attrs.frozen
        class Table(rc.Surface):
            own_grid = GRID

            def heights(self, grid):
                return ROUGH.heights(grid)

        assert problem(Table()).plan.grid == GRID
        with pytest.raises(rc.InputError, match="Table is not known between"):
            rc.on_grid(problem(Table()), (64, 64))
