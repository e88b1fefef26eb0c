"""The network of flow: iteration beside elimination, and how many cells need pyamg."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._answers.flow import network as networks
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
