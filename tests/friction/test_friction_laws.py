"""Laws of friction: their limits, what they refuse, and what a law of one's own must give."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import roughcontact as rc

PRESSURE = np.array([[0.0, 1e6], [2e9, 5e7]])


def test_limits():
    assert np.array_equal(rc.Coulomb(0.3).limit(PRESSURE), 0.3 * PRESSURE)
    assert np.array_equal(rc.LimitedCoulomb(0.3, "200MPa").limit(PRESSURE), np.minimum(0.3 * PRESSURE, 2e8))
    assert not rc.Coulomb(0).limit(PRESSURE).any()


def test_coefficients_may_vary_over_the_surface():
    coefficient = np.array([[0.1, 0.2], [0.3, 0.0]])
    for law in (rc.Coulomb(coefficient), rc.LimitedCoulomb(coefficient, 1e12)):
        assert np.array_equal(law.limit(PRESSURE), coefficient * PRESSURE)
        with pytest.raises(ValueError, match="read-only"):
            law.coefficient[0, 0] = 1.0
        copy = pickle.loads(pickle.dumps(law))
        assert np.array_equal(copy.limit(PRESSURE), coefficient * PRESSURE)


@pytest.mark.parametrize(
    "wrong", [-0.1, np.nan, np.inf, "-0.3", "0.3 Pa", None, [0.1, 0.2], [[0.1, -0.2]], [[0.1], [0.1, 0.2]]]
)
def test_coefficients_that_are_refused(wrong):
    for make in (rc.Coulomb, lambda value: rc.LimitedCoulomb(value, 1e6)):
        with pytest.raises(rc.InputError, match=r"^The coefficient of friction must be a "):
            make(wrong)


@pytest.mark.parametrize("wrong", [0.0, -1e6, "3 m", [[1e6, 0.0]]])
def test_strengths_that_are_refused(wrong):
    with pytest.raises(rc.InputError, match=r"^The shear strength"):
        rc.LimitedCoulomb(0.3, wrong)


def test_laws_have_names():
    assert {"coulomb", "limited-coulomb"} <= set(rc.frictions)
    assert rc.frictions.create("coulomb", 0.2).coefficient == 0.2
