"""Estimates: scaled exactly, added with a bound of the uncertainty, and refused where nothing can be said of it."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc

NUMBERS = st.floats(-1e6, 1e6).filter(lambda value: value == 0.0 or abs(value) > 1e-6)
SPREADS = st.floats(0.0, 1e6)
A = rc.Estimate(12.0, 0.5, "N", ("the grid is coarse",))
B = rc.Estimate(5.0, 0.2, "N", ("the grid is coarse", "the border cuts it"))


def pair_of(estimate):
    return estimate.value, estimate.uncertainty


class TestNumbers:
    @given(NUMBERS, SPREADS, NUMBERS.filter(bool))
    def test_scaling_is_exact_and_keeps_the_relative_uncertainty(self, value, spread, factor):
        found = rc.Estimate(value, spread, "N")
        assert pair_of(found * factor) == pair_of(factor * found) == (value * factor, spread * abs(factor))
        assert pair_of(found / factor) == (value / factor, spread / abs(factor))
        assert pair_of(-found) == (-value, spread)

    @given(NUMBERS, SPREADS, NUMBERS)
    def test_a_number_in_the_unit_is_exact(self, value, spread, shift):
        found = rc.Estimate(value, spread, "N")
        assert pair_of(found + shift) == pair_of(shift + found) == (value + shift, spread)
        assert pair_of(shift - found) == (shift - value, spread)

    @pytest.mark.parametrize("two", [2, 2.0, np.float64(2.0), np.float32(2.0), np.int64(2)])
    def test_of_python_and_numpy_alike(self, two):
        for found in (A * two, two * A, A / (1 / two), A + A):
            assert type(found) is rc.Estimate
            assert pair_of(found) == (24.0, 1.0)
            assert (found.unit, found.warnings) == ("N", A.warnings)
        assert pair_of(two + A) == (14.0, 0.5)


class TestSums:
    def test_the_bound_holds_for_any_correlation(self):
        """Draws of two errors of known correlation: the spread of sum and difference is at most the one stated."""
        draws = np.random.default_rng(0)
        first, other = draws.standard_normal((2, 100_000))
        for correlation in (-1.0, -0.5, 0.0, 0.5, 1.0):
            second = correlation * first + math.sqrt(1.0 - correlation**2) * other
            for sign, stated in ((1.0, A + B), (-1.0, A - B)):
                spread = float(np.std(A.uncertainty * first + sign * B.uncertainty * second))
                assert spread <= stated.uncertainty * 1.01
        # It is reached where both errors grow together.
        assert (A + B).uncertainty == pytest.approx(float(np.std(0.7 * first)), rel=0.01)

    def test_warnings_are_said_once(self):
        assert (A + B).warnings == ("the grid is coarse", "the border cuts it")
        assert pair_of(sum([A, B, A])) == pytest.approx((29.0, 1.2))

    def test_the_spread_of_other_places_is_added_too(self):
        rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6)
        grid = rc.Grid((32, 32), 32e-6)
        body = rc.Body(rough, rc.materials.copper)
        area = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=5e7).area()
        assert area.sampling > 0.0
        assert type(2 * area) is rc.Estimate
        for twice in (area + area, 2 * area, pickle.loads(pickle.dumps(area + area))):
            assert twice.sampling == pytest.approx(2.0 * area.sampling)
        assert (area + 1e-9).sampling == pytest.approx(area.sampling)
        assert (A + A).sampling is None


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: A * B, "cannot be multiplied by another one: how their errors are correlated is not known"),
        (lambda: A / B, "cannot be divided by another one"),
        (lambda: A + rc.Estimate(1.0, 0.1, "m"), "different units cannot be added: 'N' and 'm'"),
        (lambda: A - rc.Estimate(1.0, 0.1, ""), "different units cannot be added: 'N' and no unit"),
        (lambda: A * "2", "must be a number, but got '2'"),
        (lambda: A * True, "must be a number, but got True"),
        (lambda: A * math.nan, "must be a number, but got nan"),
        (lambda: A + math.inf, "must be a number or an estimate"),
        (lambda: np.ones(2) * A, "must be a number, but got an array"),
        (lambda: A / 0, "must be a number other than 0"),
        (lambda: f"{A:zz}", "must be that of a number, such as '.3g'"),
    ],
)
def test_what_has_no_answer_is_refused(call, words):
    with pytest.raises(rc.InputError, match=words):
        call()


def test_a_format_is_that_of_both_numbers():
    assert f"{A:.2f}" == "(12.00 +- 0.50) N"
    assert f"{rc.Estimate(3.0, 0.1, ''):.1e}" == "(3.0e+00 +- 1.0e-01)"
    assert f"{A}" == str(A)


def test_tables_have_as_many_digits_as_the_uncertainty_and_prefixes_of_volumes():
    flows = [rc.Estimate(9.5389e-15, 1.1e-16, "m3/s"), rc.Estimate(5.3386e-15, 7.1e-17, "m3/s")]
    assert rc.faces.write_column(flows) == ["9540 ± 110 µm³/s", "5339 ± 71 µm³/s"]
    assert rc.faces.write_column([rc.Estimate(2.4497e-17, 3e-19, "m3")]) == ["24.50 ± 0.30 µm³"]
    assert rc.faces.write_column([rc.Estimate(9.5389e-15, 1.1e-16, "1/m")]) == ["9.54e-15 ± 1.1e-16 1/m"]
