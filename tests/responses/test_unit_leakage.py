"""The network of flow: iteration beside elimination, and how many cells need pyamg."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.flow import network as networks
from roughcontact._answers.flow.dissection import dissect
from roughcontact._answers.flow.faces import find_creases
from roughcontact._answers.flow.network import make_network
from test_leakage import WATER, solved, with_gap


def test_iteration_finds_the_flow_of_elimination():
    pytest.importorskip("pyamg")
    solution = solved(cells=128, x=0.15)
    network = make_network(solution.gap, ~solution.contact, aspect=1.0, periodic=True)
    exact = networks.eliminate(network)
    pressure, converged = networks.iterate(network)
    assert converged
    flows = [float(network.dissipation(one)[1].sum()) for one in (exact, pressure)]
    assert flows[1] == pytest.approx(flows[0], rel=2e-3)
    # The pressure of a dead end, through which nothing flows, may be off.
    np.testing.assert_allclose(network.find_flow(pressure), network.find_flow(exact), atol=2e-3 * flows[0])


def test_large_flows_need_pyamg(monkeypatch):
    monkeypatch.setattr(networks, "MAX_ELIMINATION_CELLS", 10)
    monkeypatch.setitem(sys.modules, "pyamg", None)
    with pytest.raises(rc.MissingPackage, match=r"pip install 'roughcontact\[flow\]'"):
        with_gap(np.full((8, 8), 1e-6)).leakage(axis=0, **WATER)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
@pytest.mark.parametrize("cells", [2.2, 3.0, 4.0, 8.0])
def test_rough_heights_of_any_resolution_have_no_creases(cells, hurst):
    surface = rc.SelfAffineSurface(
        hurst=hurst, rms_slope=0.05, shortest=cells / 64.0, longest=1.0, rolloff=0.25, seed=17
    )
    for size in ((1.0, 1.0), (1.0, 0.6)):
        heights = surface.heights(rc.Grid((64, 64), size))
        assert find_creases(-heights) == 0.0
        # Grooves that meet them have, ridges have none of the kind, nor have steps.
        x, y = np.meshgrid(*(np.arange(64) / 64.0,) * 2, indexing="ij")
        grooves = np.maximum(0.0, 1.0 - np.abs((4.0 * x + 3.0 * y) % 1.0 - 0.5) / 0.15)
        high = 10.0 * np.ptp(heights)
        assert find_creases(high * grooves - heights) == 1.0
        assert find_creases(-high * grooves - heights) == 0.0
        assert find_creases(high * (grooves > 0.5) - heights) == 0.0


def make_matrix(leak, conductances):
    cells = np.arange(leak.size).reshape(leak.shape)
    matrix = np.diag(leak.ravel())
    for axis, conductance in enumerate(conductances):
        pairs = zip(cells.ravel(), np.roll(cells, -1, axis).ravel(), conductance.ravel(), strict=True)
        for one, other, value in pairs:
            matrix[[one, other], [one, other]] += value
            matrix[[one, other], [other, one]] -= value
    return matrix


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (2, 2), (5, 4), (33, 12), (6, 90), (31, 37)])
def test_dissection_solves_what_numpy_does(shape):
    random = np.random.default_rng(3)
    leak = 0.01 * random.random(shape)
    # Conductances of liquid films differ by orders; a line of one cell has no neighbour along its short side.
    conductances = [10.0 ** random.uniform(-6.0, 0.0, shape) * (count > 1) for count in shape]
    right = random.random((leak.size, 2))
    found = dissect(leak, conductances).solve(right)
    np.testing.assert_allclose(found, np.linalg.solve(make_matrix(leak, conductances), right), rtol=1e-8)


@pytest.mark.parametrize(("shape", "axis"), [((40, 31), 0), ((60, 14), 1)])
def test_both_eliminations_find_one_flow(monkeypatch, shape, axis):
    problem = rc.ContactProblem(
        rc.Body(
            rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.1, longest=1.0, seed=2), rc.Elastic(1e9, 0.3)
        ),
        grid=rc.Grid(shape, (1.0, 0.7)),
        boundary="periodic",
    )
    solution = problem.solve(pressure=2e6)
    sparse = solution.leakage(axis=axis, **WATER)
    law = rc.film_law(problem, [0.8, 2.0], sampling=False)
    monkeypatch.setattr(networks, "_MIN_DISSECTED_CELLS", 0)
    monkeypatch.setattr(networks, "_MIN_DISSECTED_FRACTION", 0.0)
    assert solution.leakage(axis=axis, **WATER).value == pytest.approx(sparse.value, rel=1e-10)
    dissected = rc.film_law(problem, [0.8, 2.0], sampling=False)
    for name, column in law.columns.items():
        np.testing.assert_allclose(dissected[name].values, column.values, rtol=1e-10, atol=1e-12, err_msg=name)


def test_matrices_that_rounding_spoils_are_left_to_sparse_elimination(monkeypatch):
    def fail(*_):
        raise np.linalg.LinAlgError

    monkeypatch.setattr(networks, "_MIN_DISSECTED_CELLS", 0)
    monkeypatch.setattr(networks, "dissect", fail)
    flow = with_gap(np.full((8, 8), 1e-6)).leakage(axis=0, **WATER)
    assert flow.flow_factor == pytest.approx(1.0)
