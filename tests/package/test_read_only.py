"""No array of a solution can be written to, however the solution was obtained."""

from __future__ import annotations

import copy
import pickle

import attrs
import numpy as np
import pytest

import roughcontact as rc
from scenes import make_problem

HARDNESS = np.linspace(1e9, 3e9, 120).reshape(12, 10)


def solve():
    material = rc.ElasticPerfectlyPlastic(210e9, 0.3, HARDNESS)
    return make_problem(rc.ParaboloidSurface(1e-3), material, grid=rc.Grid((12, 10), 1e-4)).solve(force=2.0)


def load(solution, folder, suffix):
    path = folder / f"solution.{suffix}"
    solution.save(path)
    return rc.ContactSolution.load(path)


WAYS = {
    "solved": lambda solution, folder: solution,
    "unpickled": lambda solution, folder: pickle.loads(pickle.dumps(solution)),
    "copied": lambda solution, folder: copy.copy(solution),
    "copied deeply": lambda solution, folder: copy.deepcopy(solution),
    "evolved": lambda solution, folder: attrs.evolve(solution, seconds=0.0),
    "made": lambda solution, folder: attrs.evolve(solution, pressure=solution.pressure.copy()),
    "loaded from npz": lambda solution, folder: load(solution, folder, "npz"),
    "loaded from nc": lambda solution, folder: load(solution, folder, "nc"),
}


def arrays_of(solution):
    """Yield every array that a public attribute of the solution, of its patches or of its area gives."""
    for thing in (solution, solution.patches, solution.area()):
        for name in dir(thing):
            value = None if name.startswith("_") else getattr(thing, name, None)
            if isinstance(value, np.ndarray):
                yield name, value


@pytest.mark.parametrize("way", WAYS)
def test_no_array_of_a_solution_can_be_written_to(tmp_path, way):
    original = solve()
    solution = WAYS[way](original, tmp_path)
    found = dict(arrays_of(solution))
    assert {"pressure", "displacement", "initial_gap", "pressure_limit", "gap", "contact", "saturated"} <= set(found)
    for name, array in found.items():
        if name not in ("areas", "mean_pressures"):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
    for name in ("pressure", "displacement", "gap", "contact", "saturated"):
        np.testing.assert_array_equal(getattr(solution, name), getattr(original, name))


@pytest.mark.parametrize("way", [lambda it: pickle.loads(pickle.dumps(it)), copy.copy, copy.deepcopy])
def test_no_array_of_a_copied_problem_can_be_written_to(way):
    heights = 1e-7 * np.random.default_rng(0).random((12, 10))
    heights[3, 4] = np.nan
    surface = rc.HeightMap(heights, (1.2e-4, 1e-4), history=("measured",))
    body = rc.Body(surface, rc.ElasticPerfectlyPlastic(210e9, 0.3, HARDNESS))
    solution = rc.ContactProblem(body).solve(force=0.5)
    for again in (way(body), way(solution).origin.problem["body"]):
        arrays = (again.surface.values, again.surface.non_measured, again.material.hardness)
        for array, original in zip(arrays, (surface.values, surface.non_measured, HARDNESS), strict=True):
            np.testing.assert_array_equal(array, original)
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
        assert again.surface.history == ("measured",)
        assert again.surface.grid.matches(surface.grid)


def test_arrays_given_to_a_solution_stay_their_owner_s():
    solution = solve()
    pressure = solution.pressure.copy()
    attrs.evolve(solution, pressure=pressure)
    pressure[0, 0] = 1.0
