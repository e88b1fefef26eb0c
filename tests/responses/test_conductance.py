"""Contact conductance beside Holm, Greenwood and the bounds of films."""

from __future__ import annotations

import math
import re

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.responses import Conductance, ContactConductance
from scenes import make_problem


def ball(cells, seed, hardness=None, boundary="free", size=None):
    n = 2 * math.ceil(1.3 * cells + 5) if size is None else size
    rng = np.random.default_rng(seed)
    surface = rc.ParaboloidSurface(1000.0, center=tuple(rng.uniform(-0.5, 0.5, 2)))
    material = rc.Elastic(1.0, 0.0) if hardness is None else rc.ElasticPerfectlyPlastic(1.0, 0.0, hardness)
    problem = make_problem(surface, material, grid=rc.Grid((n, n), float(n)), boundary=boundary, threads=1)
    return problem.solve(force=4 / 3 * cells**3 / 1000.0)


def discs(centres, radii, n):
    """Return the contact of flat discs of one height."""
    x, y = np.mgrid[:n, :n] + 0.5
    heights = np.zeros((n, n))
    for (cx, cy), a in zip(centres, radii, strict=True):
        heights[(x - cx) ** 2 + (y - cy) ** 2 < a * a] = 1.0
    problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, (n, n)), rc.Elastic(1.0, 0.0)), threads=1)
    return problem.solve(force=1e-3)


@pytest.mark.parametrize("conductivity", [50.0, (400.0, 15.0)])
def test_holm(conductivity):
    resistivity = sum(1 / k for k in np.broadcast_to(conductivity, 2))
    for seed in range(4):
        solution = ball(8, seed)
        found = solution.conductance(conductivity)
        assert isinstance(found, Conductance)
        assert found.value == pytest.approx(4 * 8 / resistivity, rel=4e-3)
        assert abs(found.value - 32 / resistivity) <= 2.5 * found.uncertainty
        assert found.per_area == found.value / solution.grid.area
        assert found.patches.sum() == pytest.approx(found.value)
        assert found.constriction[0] == pytest.approx(resistivity / 32, rel=4e-3)
        assert abs(found.interaction) < 5e-3 / found.value
        # Barber's analogy.
        stiffness = solution.stiffness().value
        assert found.value == pytest.approx(2 * stiffness / (solution.modulus * resistivity), rel=1e-3)


def test_greenwood():
    rng = np.random.default_rng(4)
    spots = [(24.0, 24.0), (24.0, 72.0), (72.0, 24.0), (72.0, 72.0), (48.0, 48.0)]
    centres = np.array(spots) + rng.uniform(-1, 1, (5, 2))
    solution = discs(centres, rng.uniform(5, 9, 5), 96)
    found = solution.conductance(2.0)
    assert found.patches.size == 5
    # Potentials of discs of the area of their cells, each in the field of point currents of the others.
    labels = solution.patches.labels
    places = np.array([np.argwhere(labels == k + 1).mean(axis=0) for k in range(5)])
    radii = np.sqrt(solution.patches.areas / math.pi)
    distances = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    np.fill_diagonal(distances, 1.0)
    resistances = 1 / (math.pi * distances)
    np.fill_diagonal(resistances, 1 / (2 * radii))
    # Of two half-spaces of resistivity 1/2 each.
    currents = 2 * np.linalg.solve(resistances, np.ones(5))
    assert found.value == pytest.approx(currents.sum(), rel=8e-3)
    np.testing.assert_allclose(found.patches, currents, rtol=0.03)
    # Greenwood (1966): the same with currents proportional to the radii, an upper bound of the resistance.
    off = resistances - np.diag(np.diag(resistances))
    greenwood = 0.5 * (1 / (2 * radii.sum()) + radii @ off @ radii / radii.sum() ** 2)
    assert 1 / found.value < greenwood * 1.008
    assert found.interaction == pytest.approx(1 / currents.sum() - 0.25 / radii.sum(), rel=0.06)


@pytest.mark.parametrize("film", [0.1, 1.0, 10.0, 100.0])
def test_a_film_between_its_bounds(film):
    a, area = 10.0, math.pi * 100.0
    found = ball(a, 2).conductance(1.0, film_resistance=film)
    # Rayleigh: currents of both problems apart, and a uniform current.
    lower = 1 / (2 * a) + film / area
    upper = 16 / (3 * math.pi**2 * a) + film / area
    assert 0.999 * lower < 1 / found.value < 1.001 * upper
    assert found.film[0] == pytest.approx(film / area, rel=2e-3)


@pytest.mark.parametrize("film", [0.03, 0.3, 3.0, 300.0])
def test_a_film_does_not_depend_on_the_grid(film):
    # The resistance of the film over the radius of the spot, for a conductivity of one.
    def conduct(cells, seed):
        return ball(cells, seed).conductance(1.0, film * cells)

    fine = conduct(24, 0).value / 24
    found = [conduct(5, seed) for seed in range(1, 5)]
    errors, stds = (
        np.array(part) for part in zip(*((one.value / 5, one.uncertainty / 5) for one in found), strict=True)
    )
    errors = errors / fine - 1.0
    assert np.abs(errors).max() < 6e-3
    assert (np.abs(errors) < 2.5 * stds / fine).all()
    if film > 10.0:
        # Nothing but the area counts.
        areas = np.array([ball(5, seed).area().uncertainty / ball(5, seed).area().value for seed in range(1, 5)])
        # The areas of balls are known to 1e-5; of the rest of the resistance 5e-5 remain.
        assert (stds / fine < 1.5 * areas + 5e-5).all()


def test_full_contact_says_that_nothing_resists():
    body, grid = rc.Body(rc.WavySurface(1e-7, 1e-5), rc.Elastic(1e9, 0.3)), rc.Grid((16, 12), 1e-5)
    full = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=1e9)
    found = full.conductance(50.0)
    assert found.value == math.inf
    assert any("touch everywhere" in warning for warning in found.warnings)
    assert str(found).startswith("infinite conductance; uncertain: ")
    assert not full.conductance(50.0, film_resistance=1e-9).warnings


def test_a_film_in_full_contact_is_all_there_is():
    body, grid = rc.Body(rc.WavySurface(1e-7, 1e-5), rc.Elastic(1e9, 0.3)), rc.Grid((16, 12), 1e-5)
    solution = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=1e9)
    assert solution.conductance(10.0).value == math.inf
    assert "inf" in str(solution.conductance(10.0))
    found = solution.conductance(10.0, film_resistance=1e-6)
    assert found.value == pytest.approx(grid.area / 1e-6, rel=1e-5)


def test_units_and_moduli_cancel():
    heights = 1e-2 * np.random.default_rng(1).standard_normal((24, 20))
    values = []
    for length, young in ((1.0, 1.0), (2.0**-30, 2.0**40)):
        body = rc.Body(rc.HeightMap(length * heights, (24 * length, 20 * length)), rc.Elastic(young, 0.3))
        solution = rc.ContactProblem(body, threads=1).solve(force=1e-3 * young * length**2)
        found = solution.conductance((3.0, 5.0), film_resistance=0.1 * length)
        values.append([found.value / length, found.uncertainty / length, *(found.patches / length)])
    np.testing.assert_allclose(values[1], values[0], rtol=1e-12)


def test_text_ends_and_refusals():
    solution = ball(6, 0)
    assert re.search(r"through 1 patch$", str(solution.conductance(50.0)))
    unit = solution.conductance(1.0).value
    for value, prefix in ((4e-3, "m"), (4.0, ""), (4e3, "k")):
        assert str(solution.conductance(value / unit)).startswith(f"4 {prefix}W/K ({prefix}S if")
    empty = attrs.evolve(solution, pressure=0.0 * solution.pressure).conductance(50.0, 1e-6)
    assert empty.value == empty.uncertainty == empty.interaction == 0.0
    assert empty.patches.size == empty.constriction.size == 0
    for conductivity, film in ((0.0, 0.0), (-1.0, 0.0), ((1.0, 2.0, 3.0), 0.0), ("a", 0.0), (1.0, -1.0), (1.0, "b")):
        with pytest.raises(rc.InputError):
            ContactConductance(conductivity, film)
    body, grid = rc.Body(rc.WavySurface(1e-7, 1e-5), rc.Elastic(1e9, 0.3)), rc.Grid((16, 12), 1e-5)
    wrapped = rc.ContactProblem(body, grid=grid, boundary="wrapped").solve(pressure=1e6)
    with pytest.raises(rc.InputError, match="wrapped"):
        wrapped.conductance(1.0)
    with pytest.raises(rc.InputError, match="layer"):
        attrs.evolve(solution, moduli=((1e-6, 1e-3), (1.0, 2.0))).conductance(1.0)
