"""Inclusions: by Eshelby's, between mixtures, judged from the fields, refused where they do not hold."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.responses import FirstYield

from closed_forms import apply_hooke, as_components, as_tensor, find_inhomogeneity_strain
from roughcontact_volume import (
    Cuboid,
    Ellipsoid,
    Inclusion,
    Inclusions,
    MaterialField,
    Sphere,
    StrainedRegion,
    draw_moduli,
    find_inclusion_answers,
)
from roughcontact_volume.equivalent_strain import Contrast, find_eigenstrain
from roughcontact_volume.inclusions import find_region

YOUNG, NU = 1e9, 0.3
# A Hertz contact of radius 1e-4 m.
RADIUS, FORCE = 10e-3, 0.1465
BALL = rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid())
FLAT = rc.Body(rc.FlatSurface(), rc.Elastic(YOUNG, NU))


def _make_problem(laws, *, cells=20, side=3e-4, boundary="free"):
    return rc.ContactProblem(FLAT, BALL, grid=rc.Grid((cells, cells), side), boundary=boundary, laws=laws)


def _make_sphere(contrast, **others):
    return Inclusion(Sphere(4e-5), contrast * YOUNG, NU, centre=(0.0, 0.0, 7e-5), **others)


def _remembered(state):
    fields = state.to_dict()
    return {name: fields[f"{name}_with_inclusions"] for name in ("approach", "peak_pressure", "von_mises")}


def _find_error_in_the_deep(axes, moduli, side):
    """Error of the mean strain in an ellipsoid between the mixtures, over its largest component."""
    inclusion = Inclusion(Ellipsoid(axes), moduli[0] * YOUNG, moduli[1], centre=(0.0, 0.0, 6.0))
    cells = 2 * round(3.0 / side) + 1
    region = find_region((inclusion,), rc.Grid((cells, cells), cells * side), rc.Boundary.FREE, YOUNG, NU)
    far = as_tensor([2e-3, -1e-3, -3e-3, 5e-4, 1e-3, -1e-3])
    stress_far = as_components(apply_hooke(far, YOUNG, NU))[:, np.newaxis]
    uncut = region.cells.bulk["softer"] == region.cells.bulk["stiffer"]

    def find_stress(eigenstrain, error):
        stress = region.operators.find_stress(region.spread(eigenstrain))
        return stress.reshape(6, -1)[:, region.cells.places] + stress_far

    found = []
    for mixture in ("softer", "stiffer"):
        start = np.zeros((6, uncut.size))
        eigenstrain = find_eigenstrain(region.find_contrast(mixture), find_stress, start, 1e-4)
        stress = find_stress(eigenstrain, 0.0)
        strain = (1.0 + NU) / YOUNG * stress + eigenstrain
        strain[:3] -= NU / YOUNG * stress[:3].sum(axis=0)
        found.append(strain[:, uncut].mean(axis=1))
    exact = as_components(find_inhomogeneity_strain(axes, (moduli[0] * YOUNG, moduli[1]), (YOUNG, NU), far))
    return np.abs(np.mean(found, axis=0) - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize(
    ("axes", "moduli"), [((1.0, 1.0, 1.0), (0.2, 0.3)), ((1.0, 1.0, 1.0), (3.0, 0.3)), ((1.25, 1.0, 0.75), (3.0, 0.15))]
)
def test_an_ellipsoid_in_the_deep_has_eshelbys_strain(axes, moduli):
    # Between first and second order: cells that its boundary cuts have a mixture without a direction.
    coarse, fine = (_find_error_in_the_deep(axes, moduli, side) for side in (0.25, 0.125))
    assert fine < 0.04
    assert fine < 0.75 * coarse


def test_the_same_modulus_changes_nothing():
    plain = _make_problem(()).solve(force=FORCE)
    state = _make_problem(Inclusions([_make_sphere(1.0)])).solve(force=FORCE)
    assert state.pressure == pytest.approx(plain.pressure, abs=1e-4 * plain.pressure.max())
    assert _remembered(state)["approach"]["uncertainty"] == 0.0


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("contrast", [0.1, 10.0])
def test_a_sphere_below_a_contact(contrast, boundary):
    plain = _make_problem((), boundary=boundary).solve(force=FORCE)
    state = _make_problem(Inclusions([_make_sphere(contrast)]), boundary=boundary).solve(force=FORCE)
    assert state.certificate["inclusions"].residual < 1e-4
    assert state.certificate.error < 1e-4
    # A softer body sinks deeper, a stiffer one less, and the mixtures lie on both sides of the state.
    assert (state.approach > plain.approach) == (contrast < 1.0)
    bounds = _remembered(state)["approach"]
    assert abs(bounds["value"] - state.approach) < bounds["uncertainty"]
    assert 0.0 < bounds["uncertainty"] < 0.02 * plain.approach


@pytest.mark.parametrize(
    ("inclusion", "boundary"),
    [
        (Inclusion(Ellipsoid((5e-5, 3e-5, 4e-5)), 4e9, 0.25, centre=(2e-5, -1e-5, 6e-5)), "periodic"),
        pytest.param(_make_sphere(0.2), "free", marks=pytest.mark.slow),
        pytest.param(
            Inclusion(Cuboid((7e-5, 9e-5, 6e-5)), 3e8, NU, centre=(0.0, 3e-5, 5e-5)), "free", marks=pytest.mark.slow
        ),
    ],
)
def test_a_finer_grid_lies_between_the_mixtures(inclusion, boundary):
    coarse, fine = (
        [_make_problem(laws, cells=cells, boundary=boundary).solve(force=FORCE) for laws in ((), Inclusions(inclusion))]
        for cells in (20, 44)
    )
    bounds = _remembered(coarse[1])["approach"]
    reference = fine[1].approach / fine[0].approach * coarse[0].approach
    assert abs(bounds["value"] - reference) < bounds["uncertainty"]


def test_softer_and_stiffer_inclusions_side_by_side():
    # The steps contract for mixed contrasts too.
    pair = [
        Inclusion(Sphere(3e-5), contrast * YOUNG, NU, centre=(x, 0.0, 5e-5))
        for contrast, x in ((0.1, -3.5e-5), (10.0, 3.5e-5))
    ]
    state = _make_problem(Inclusions(pair)).solve(force=FORCE)
    assert state.certificate.error < 1e-4
    mirrored = [attrs.evolve(one, centre=(-one.centre[0], *one.centre[1:])) for one in pair]
    other = _make_problem(Inclusions(mirrored)).solve(force=FORCE)
    assert other.pressure[::-1] == pytest.approx(state.pressure, abs=2e-4 * state.pressure.max())


def test_the_steps_contract_as_promised():
    random = np.random.default_rng(5)
    # The strain of a body that is free of any eigenstrain is the largest admissible one: T = 0.
    contrast = Contrast(random.uniform(0.1, 10.0, 30), random.uniform(0.1, 10.0, 30), 2.0, 1.0)
    far = random.normal(size=(6, 30))
    calls = []

    def find_stress(strain, error):
        calls.append(error)
        return far

    eigenstrain = find_eigenstrain(contrast, find_stress, np.zeros((6, 30)), 1e-10)
    assert contrast.measure(contrast.find_step(far, eigenstrain)) < 1e-9
    assert len(calls) < 60


def test_a_wrong_eigenstrain_is_judged():
    law = Inclusions([_make_sphere(3.0)])
    problem = _make_problem(law)
    state = problem.solve(force=FORCE)
    (known,) = [one for one in state.added if one.kind == "laws"]
    (memory,) = known.memory
    (right,) = law.judge(problem, state, None, {}, memory)
    (wrong,) = law.judge(problem, state, None, {}, {**memory, "eigenstrain": 1.01 * memory["eigenstrain"]})
    assert right.residual < 2e-5
    assert wrong.residual > 1e-3


def test_either_body_may_have_it():
    body = _make_problem(Inclusions([_make_sphere(3.0)])).solve(force=FORCE)
    turned = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(RADIUS), rc.Rigid()),
        FLAT,
        grid=rc.Grid((20, 20), 3e-4),
        laws=Inclusions([_make_sphere(3.0)], side="counterbody"),
    ).solve(force=FORCE)
    assert turned.pressure == pytest.approx(body.pressure, abs=1e-6 * body.pressure.max())


@pytest.mark.parametrize("power", [-40, 30])
def test_units_of_pressure_do_not_matter(power):
    factor = 2.0**power
    state = _make_problem(Inclusions([_make_sphere(3.0)])).solve(force=FORCE)
    stiff = rc.Body(rc.FlatSurface(), rc.Elastic(factor * YOUNG, NU))
    inclusion = attrs.evolve(_make_sphere(3.0), young=factor * 3.0 * YOUNG)
    problem = rc.ContactProblem(stiff, BALL, grid=rc.Grid((20, 20), 3e-4), laws=Inclusions(inclusion))
    assert np.array_equal(problem.solve(force=factor * FORCE).pressure, factor * state.pressure)


def test_oblong_cells_and_a_transposed_domain():
    inclusion = Inclusion(Ellipsoid((6e-5, 3e-5, 3e-5)), 4.0 * YOUNG, NU, centre=(2e-5, 1e-5, 5e-5))
    turned = Inclusion(Ellipsoid((3e-5, 6e-5, 3e-5)), 4.0 * YOUNG, NU, centre=(1e-5, 2e-5, 5e-5))
    one = rc.ContactProblem(FLAT, BALL, grid=rc.Grid((15, 45), 3e-4), laws=Inclusions(inclusion)).solve(force=FORCE)
    other = rc.ContactProblem(FLAT, BALL, grid=rc.Grid((45, 15), 3e-4), laws=Inclusions(turned)).solve(force=FORCE)
    assert one.certificate.error < 1e-4
    assert pytest.approx(one.pressure, abs=1e-4 * one.pressure.max()) == other.pressure.T


def test_loads_follow_each_other():
    path = _make_problem(Inclusions([_make_sphere(0.3)])).sweep(force=[0.5 * FORCE, FORCE])
    alone = _make_problem(Inclusions([_make_sphere(0.3)])).solve(force=FORCE)
    assert path[1].pressure == pytest.approx(alone.pressure, abs=1e-4 * alone.pressure.max())


def test_a_material_field_is_taken_cell_by_cell():
    side = 1.5e-5
    law = Inclusions([Inclusion(Cuboid((5 * side, 4 * side, 4 * side)), 3.0 * YOUNG, NU, (0.5 * side, 0.0, 4 * side))])
    problem = _make_problem(law)
    young = np.full((4, 20, 20), YOUNG)
    young[:, 8:13, 8:12] *= 3.0
    field = MaterialField(young, NU, np.full(4, side), depth=2 * side)
    state = _make_problem(Inclusions(field)).solve(force=FORCE)
    assert state.pressure == pytest.approx(problem.solve(force=FORCE).pressure, abs=1e-5 * state.pressure.max())
    assert _remembered(state)["approach"]["uncertainty"] == 0.0


def test_random_moduli_to_the_surface():
    grid = rc.Grid((20, 20), 3e-4)
    layers = np.full(6, 1.5e-5)
    young = draw_moduli(grid, layers, YOUNG, 0.8, 4e-5, seed=3)
    assert np.array_equal(young, draw_moduli(grid, layers, YOUNG, 0.8, 4e-5, seed=3))
    state = _make_problem(Inclusions(MaterialField(young, NU, layers))).solve(force=FORCE)
    assert state.certificate.error < 1e-4


def test_random_moduli_have_their_deviation_and_length():
    grid = rc.Grid((128, 128), 128.0)
    logarithm = np.log(draw_moduli(grid, np.ones(3), 1.0, 0.3, 6.0, seed=2))
    assert logarithm.std() == pytest.approx(0.3, rel=0.1)
    for shifted in (np.roll(logarithm, 4, axis=1), np.roll(logarithm, 4, axis=2)):
        assert np.mean(logarithm * shifted) / logarithm.var() == pytest.approx(np.exp(-16.0 / 36.0), abs=0.08)
    assert np.mean(logarithm[0] * logarithm[2]) / logarithm.var() == pytest.approx(np.exp(-4.0 / 36.0), abs=0.05)


def test_a_soft_patch_to_the_surface_is_softer_than_the_body_and_stiffer_than_its_half_space():
    law = Inclusions(MaterialField(np.full((8, 20, 20), 0.5 * YOUNG), NU, np.full(8, 1.5e-5)))
    body, patch = (_make_problem(laws).solve(force=FORCE).approach for laws in ((), law))
    soft = rc.Body(rc.FlatSurface(), rc.Elastic(0.5 * YOUNG, NU))
    softest = rc.ContactProblem(soft, BALL, grid=rc.Grid((20, 20), 3e-4)).solve(force=FORCE).approach
    assert 1.2 * body < patch < 0.98 * softest


@pytest.mark.parametrize(
    ("inclusions", "message"),
    [
        ([Inclusion(Sphere(4e-5), YOUNG, NU, (0.0, 0.0, 3e-5))], "reaches the surface: its top lies at a depth of -10"),
        ([Inclusion(Sphere(4e-5), YOUNG, NU, (0.0, 1.3e-4, 7e-5))], "over the border of the domain along y"),
        ([_make_sphere(0.05)], "between 0.1 and 10"),
        ([_make_sphere(11.0)], "between 0.1 and 10"),
        ([Inclusion(Sphere(4e-5), 3e9, 0.499, (0.0, 0.0, 7e-5))], "The bulk modulus of an inclusion"),
        ([_make_sphere(2.0), _make_sphere(3.0)], "Two inclusions overlap"),
        ([Inclusion(Sphere(4e-7), 2e9, NU, (7.5e-6, 0.0, 7e-5))], "smaller than a cell"),
        ([], "an Inclusion, a list of them, or a MaterialField"),
        ("sphere", "an Inclusion, a list of them, or a MaterialField"),
        (MaterialField(np.full((2, 10, 10), YOUNG), NU, [1e-5, 1e-5]), "has the cells of the grid"),
    ],
)
def test_what_does_not_hold_is_refused(inclusions, message):
    def solve():
        _make_problem(Inclusions(inclusions)).solve(force=FORCE)

    with pytest.raises(rc.InputError, match=message):
        solve()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"shape": "sphere"}, "a Sphere, an Ellipsoid or a Cuboid"),
        ({"centre": (0.0, 0.0)}, "three finite numbers"),
        ({"centre": (0.0, 0.0, float("nan"))}, "three finite numbers"),
        ({"young": -1.0}, "Young"),
        ({"poisson": 0.7}, "Poisson"),
    ],
)
def test_wrong_inclusions_are_refused(given, message):
    right = {"shape": Sphere("40um"), "young": "3GPa", "poisson": 0.3, "centre": (0.0, 0.0, "70um")}
    with pytest.raises(rc.InputError, match=message):
        Inclusion(**right | given)


@pytest.mark.parametrize("make", [lambda: Sphere(0.0), lambda: Ellipsoid((1.0, 2.0)), lambda: Cuboid((1.0, -1.0, 1.0))])
def test_wrong_shapes_are_refused(make):
    with pytest.raises(rc.InputError, match=r"The (radius|semi-axes|lengths)"):
        make()


def test_attraction_is_refused():
    law = Inclusions([_make_sphere(3.0)])
    with pytest.raises(rc.InputError, match="adhesion"):
        rc.ContactProblem(
            FLAT, BALL, grid=rc.Grid((20, 20), 3e-4), laws=law, adhesion=rc.Exponential(work=1e-3, range=1e-8)
        ).solve(force=FORCE)


def test_the_answers_add_the_error_of_the_cells():
    state = _make_problem(Inclusions([_make_sphere(3.0)])).solve(force=FORCE)
    found = find_inclusion_answers(state)
    bounds = _remembered(state)
    assert found.approach.uncertainty > bounds["approach"]["uncertainty"]
    assert found.approach.value == pytest.approx(state.response("approach").value, rel=0.01)
    assert found.peak_pressure.value == pytest.approx(state.peak_pressure().value, rel=0.02)
    assert found.von_mises.value == bounds["von_mises"]["value"]
    assert str(found).startswith("approach ")
    with pytest.raises(rc.InputError, match="has no Inclusions"):
        find_inclusion_answers(_make_problem(()).solve(force=FORCE))


@pytest.mark.parametrize("response", ["stress", "stiffness", "tangential-stiffness", FirstYield("1GPa")])
def test_answers_of_uniform_bodies_are_refused(response):
    state = _make_problem(Inclusions([_make_sphere(1.5)])).solve(force=FORCE)
    with pytest.raises(rc.InputError, match="inclusions change"):
        state.response(response)
    assert state.area().fraction > 0.1


def test_another_strain_of_the_body_is_refused():
    region = StrainedRegion(Sphere(3e-5), 1e-3, centre=(0.0, 0.0, 7e-5))
    with pytest.raises(rc.InputError, match="without other strain below its surface"):
        _make_problem([Inclusions([_make_sphere(1.5)]), region]).solve(force=FORCE)


def test_friction_is_refused():
    with pytest.raises(rc.InputError, match="not with the tractions of friction"):
        _make_problem(Inclusions([_make_sphere(1.5)])).path(force=[FORCE], tangential_force=[(0.01, 0.0)], friction=0.3)
