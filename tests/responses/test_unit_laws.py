"""The fit of a power over the table of an interface."""

from __future__ import annotations

import math

import numpy as np
import pytest

from roughcontact._answers.laws.columns import fit_power


class TestFit:
    def test_a_small_exponent_may_be_one(self):
        pressures = np.geomspace(1.0, 1e4, 21)
        assert fit_power(pressures, pressures**-0.05, np.zeros(21)).exponent == pytest.approx(-0.05)

    def test_it_ends_where_the_curve_bends(self):
        pressures = np.geomspace(1.0, 1e6, 31)
        values = np.where(pressures < 1e4, pressures**0.9, 1e4**0.9 * (pressures / 1e4) ** 0.3)
        found = fit_power(pressures, values, 1e-4 * values)
        assert found.exponent == pytest.approx(0.9, abs=0.005)
        assert 1e4 / 1.6 < found.pressures[1] < 2e4
        assert found.misfit <= 0.01
        assert "pressure^(0.9" in str(found)

    def test_a_logarithm_has_none(self):
        pressures = np.geomspace(1.0, 1e4, 21)
        assert fit_power(pressures, np.log(1e6 / pressures), np.zeros(21)) is None
        assert fit_power(pressures[:3], pressures[:3], np.zeros(3)) is None
        assert fit_power(pressures, np.full(21, math.inf), np.zeros(21)) is None

    def test_the_standard_deviation_is_the_scatter(self):
        rng, pressures = np.random.default_rng(0), np.geomspace(1.0, 1e3, 13)
        found = [
            fit_power(pressures, pressures**0.5 * np.exp(0.02 * rng.standard_normal(13)), 0.06 * pressures**0.5)
            for _ in range(200)
        ]
        whole = [one for one in found if one.loads == 13]
        assert len(whole) > 190
        scatter = np.std([one.exponent for one in whole])
        assert 0.25 < scatter / np.mean([one.exponent_std for one in whole]) < 1.0
        exact = [
            fit_power(pressures, pressures**0.5 * np.exp(0.004 * rng.standard_normal(13)), np.zeros(13))
            for _ in range(99)
        ]
        wide = [one for one in exact if one is not None and one.loads == 13]
        assert np.std([one.exponent for one in wide]) == pytest.approx(
            np.mean([one.exponent_std for one in wide]), rel=0.25
        )
