from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughcontact.extrapolation import exponential, power_law, richardson

CELLS = np.array([64, 128, 256, 512, 1024, 2048])


@given(st.floats(0.1, 10), st.floats(-5, 5).filter(lambda k: abs(k) > 0.01), st.floats(50, 600))
def test_exponential_data_are_recovered(limit, k, t):
    fit = exponential(CELLS, limit + k * np.exp(-CELLS / t))
    assert fit.value == pytest.approx(limit, abs=1e-6 * abs(k))
    assert fit.parameters["t"] == pytest.approx(t, rel=1e-4)


@given(st.floats(0.1, 10), st.floats(-5, 5).filter(lambda c: abs(c) > 0.01), st.floats(0.5, 3))
def test_power_data_are_recovered(limit, c, q):
    data = limit + c * (64 / CELLS) ** q
    fit = power_law(CELLS, data)
    assert fit.value == pytest.approx(limit, abs=1e-5 * abs(c))
    assert fit.parameters["q"] == pytest.approx(q, rel=1e-4)
    assert fit.trustworthy
    observed, known = richardson(CELLS, data), richardson(CELLS, data, order=q)
    for fit in (observed, known):
        assert fit.value == pytest.approx(limit, abs=1e-8)
        assert fit.trustworthy
    assert observed.parameters["q"] == pytest.approx(q, rel=1e-6)


def test_grids_may_come_in_any_order_and_unevenly():
    cells = np.array([300, 64, 100, 777])
    fit = richardson(cells, 2 + 5.0 / cells**1.5)
    assert fit.value == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize(
    ("fit", "words"),
    [
        (exponential([64, 128], [2.0, 1.0]), "2 grids cannot determine 3 parameters"),
        (power_law([64, 128, 256], [2.0, 1.0, 0.6]), "determine 3 parameters exactly"),
        (exponential(CELLS, [5.0, 3.0, 2.0, 2.4, 2.1, 2.0]), "monotonically"),
        (exponential(CELLS, 1 + 64 / CELLS), "misses the data"),
        (exponential(CELLS, 1 + np.exp(-CELLS / 5)), "decay length"),
        (exponential(CELLS, 2 - 1e-4 * CELLS), "decay length"),
        (power_law(CELLS, 1 + np.log(2048 / CELLS)), "order q"),
        (richardson(CELLS, [5.0, 3.0, 2.0, 1.9, 1.5, 1.0]), "do not converge"),
        (richardson(CELLS, [5.0, 3.0, 2.0, 1.9, 1.8, 1.9]), "do not converge"),
        (richardson(CELLS, 1 + 64 / CELLS, order=3.0), "next coarser grid"),
        (richardson([64, 128, 256, 512], [1.0, 3.0, 2.0, 1.5]), "monotonically"),
    ],
)
def test_warnings_of_an_extrapolation(fit, words):
    assert not fit.trustworthy
    assert any(words in warning for warning in fit.warnings)


def test_values_that_do_not_converge_return_the_finest():
    assert richardson(CELLS, [5.0, 3.0, 2.0, 1.9, 1.5, 1.0]).value == 1.0


def test_equal_values_are_their_own_limit():
    assert exponential(CELLS, np.full(6, 2.0)).value == pytest.approx(2.0)
    assert power_law(CELLS, np.full(6, 2.0)).value == pytest.approx(2.0)
