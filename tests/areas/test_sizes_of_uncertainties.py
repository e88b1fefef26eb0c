"""Uncertainties are near the errors, neither too small nor many times too large, and fall with the cells.

The errors are those beside the same rough contacts on a fine grid.
"""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.responses import find_percolation

STEEL = rc.Elastic(1.82, 0.3)
FLAT = rc.Body(rc.FlatSurface(), STEEL)
CELLS = (40, 64, 160)
# At most how large they are over the errors, root mean squares, and at least the order at which they fall.
QUANTITIES = {
    "peak-pressure": (8.0, 2.0),
    "perimeter": (6.0, 1.2),
    "patches": (6.0, 0.7),
    "approach": (20.0, 2.3),
    "mean-gap": (12.0, 2.3),
}
AREAS = "blend", "cell-count", "hertz", "level-set", "level-set-richardson", "perimeter"
# What the theories of tangential stiffness and of leakage omit does not fall with the cells.
RESPONSES = {
    "stiffness": (4.0, 1.7),
    "tangential stiffness": (4.0, 0.5),
    "conductance": (4.0, 1.7),
    "conductance with films": (4.0, 1.1),
    "leakage": (6.0, 1.3),
    "area that sticks": (4.0, 1.2),
    "area that slips": (4.0, 1.2),
}
# A maximum stress less than two cells deep is found on finer cells: it is as good on 40 cells as on 160, where the
# planes through the cells of these have it, and does not fall between them. At most how large the uncertainties are
# over it, medians on each of the grids.
STRESS = (0.003, 0.002, 0.002)
# At most how large the uncertainties are over the errors.
LARGEST = {name: largest for name, (largest, _) in (QUANTITIES | RESPONSES).items()} | {"stress": 4.0}


def press(seed, load, cells):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3.0, longest=16.0, seed=seed)
    grid = rc.Grid((cells, cells), 32.0)
    return rc.ContactProblem(rc.Body(surface, STEEL), FLAT, grid=grid, boundary="periodic", threads=1).solve(
        pressure=load
    )


def ask_quantities(solution):
    return {name: solution.response(name) for name in QUANTITIES}


def ask_responses(solution):
    slip = solution.partial_slip(tangential_force=0.06 * solution.force, friction=0.2, axis=1)
    return {
        "stiffness": solution.stiffness(),
        "tangential stiffness": solution.response(rc.responses.create("tangential-stiffness", axis=1)),
        "conductance": solution.conductance((1.0, 2.0)),
        "conductance with films": solution.conductance(1.0, film_resistance=2.0),
        "leakage": solution.leakage(axis=0, viscosity=1.0, pressure_drop=1.0),
        "area that sticks": slip.stick_area,
        "area that slips": slip.slip_area,
        "stress": solution.stress().maximum,
    }


def tabulate(ask, first_seed, count):
    """Return values and uncertainties over the values of the fine grid by answer, shape (count, 3) each."""
    found = [
        [ask(press(first_seed + k, load, cells)) for cells in CELLS]
        for k, load in enumerate(np.geomspace(1e-3, 1.5e-2, count))
    ]
    tables = {}
    for name in found[0][0]:
        values = np.array([[one[name].value for one in row] for row in found])
        stds = np.array([[one[name].uncertainty for one in row] for row in found])
        tables[name] = values / values[:, -1:], stds / values[:, -1:]
    return tables


@pytest.fixture(scope="module")
def tables():
    return tabulate(ask_quantities, 400, 12) | tabulate(ask_responses, 600, 4)


@pytest.mark.slow
@pytest.mark.parametrize("name", LARGEST)
def test_uncertainties_of_rough_contacts_are_near_the_errors(name, tables):
    values, stds = tables[name]
    errors, stated = np.abs(values[:, :2] - 1.0), stds[:, :2]
    assert np.mean(errors <= 2.0 * stated) >= 0.85
    assert np.sqrt(np.mean(stated**2)) <= LARGEST[name] * np.sqrt(np.mean(errors**2))


@pytest.mark.slow
@pytest.mark.parametrize("name", [*QUANTITIES, *RESPONSES])
def test_uncertainties_fall_with_the_cells(name, tables):
    _, smallest = (QUANTITIES | RESPONSES)[name]
    medians = np.median(tables[name][1], axis=0)
    assert np.log(medians[0] / medians[-1]) / np.log(CELLS[-1] / CELLS[0]) >= smallest


@pytest.mark.slow
def test_uncertainties_of_stresses_are_small_on_each_grid(tables):
    assert (np.median(tables["stress"][1], axis=0) <= STRESS).all()


@pytest.mark.slow
def test_the_uncertainty_of_the_load_that_closes_a_gap_is_near_the_error():
    errors, stated = [], []
    for seed, (boundary, axis) in enumerate([("periodic", 0), ("free", 0), ("periodic", 1), ("free", 1)]):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=16.0, seed=30 + seed)
        body = rc.Body(surface, STEEL)
        coarse, fine = (
            find_percolation(
                rc.ContactProblem(body, FLAT, grid=rc.Grid((cells, cells), 32.0), boundary=boundary, threads=1),
                axis=axis,
                within=0.02,
            )
            for cells in (32, 128)
        )
        for one, true in ((coarse.pressure, fine.pressure), (coarse.area_fraction, fine.area_fraction)):
            errors.append(abs(one.value / true.value - 1.0))
            stated.append(one.uncertainty / true.value)
            assert true.uncertainty < 0.04 * true.value
    assert (np.array(errors) <= 2.0 * np.array(stated)).all()
    assert np.sqrt(np.mean(np.square(stated))) <= 6.0 * np.sqrt(np.mean(np.square(errors)))


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("load", [2e-4, 3e-3])
def test_the_unit_of_length_changes_no_estimate_of_many_small_patches(boundary, load):
    """About micrometres and kilometres beside metres, in powers of two, which change no digit."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3.0, longest=16.0, seed=71)
    heights = surface.heights(rc.Grid((60, 44), (60.0, 44.0)))

    def ask(length, stress):
        size = 60.0 * length, 44.0 * length
        body = rc.Body(
            rc.HeightMap(length * heights, size=size, periodic=boundary == "periodic"), rc.Elastic(stress, 0.0)
        )
        solution = rc.ContactProblem(body, boundary=boundary, threads=1).solve(pressure=load * stress, tolerance=1e-9)
        assert solution.patches.count > 5
        found = [solution.area(name) for name in AREAS]
        found += [solution.response(name) for name in QUANTITIES]
        units = [length**2] * len(AREAS) + [stress, length, 1.0, length, length]
        return np.array([[one.value / unit, one.uncertainty / unit] for one, unit in zip(found, units, strict=True)])

    wanted = ask(1.0, 1.0)
    for length, stress in ((2.0**-20, 2.0**37), (2.0**10, 2.0**-10)):
        np.testing.assert_allclose(ask(length, stress), wanted, rtol=1e-9)
