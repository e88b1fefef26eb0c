"""Constants of a pair of materials."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

import roughcontact as rc
from roughcontact._parts.materials import combined_pressure_limit, contact_modulus
from strategies import moduli


def test_contact_modulus_is_of_the_plane_strain_moduli():
    steel, glass = rc.Elastic(210e9, 0.3), rc.Elastic(70e9, 0.2)
    expected = 1 / ((1 - 0.3**2) / 210e9 + (1 - 0.2**2) / 70e9)
    assert contact_modulus(steel, glass) == pytest.approx(expected, rel=1e-15)


def test_the_papers_contact_modulus():
    assert contact_modulus(rc.Elastic(200e9, 0.3), rc.Rigid()) == pytest.approx(219.78e9, rel=1e-5)


@given(moduli, moduli)
def test_the_pair_is_softer_than_either(one, other):
    first, second = rc.Elastic(one, 0.3), rc.Elastic(other, 0.1)
    together = contact_modulus(first, second)
    assert together == contact_modulus(second, first)
    assert together < min(contact_modulus(first, rc.Rigid()), contact_modulus(second, rc.Rigid()))


def test_the_softer_limit_counts():
    soft, hard = rc.ElasticPerfectlyPlastic(1e9, 0.3, 1e6), rc.ElasticPerfectlyPlastic(1e9, 0.3, 2e6)
    assert combined_pressure_limit(hard, soft) == 1e6
    assert combined_pressure_limit(rc.Rigid(), hard) == 2e6
    assert combined_pressure_limit(rc.Rigid(), rc.Elastic(1.0, 0.0)) == math.inf


def test_the_softer_limit_counts_cell_by_cell():
    hardness = np.array([[1e6, 3e6], [2e6, 4e6]])
    patchy, uniform = rc.ElasticPerfectlyPlastic(1e9, 0.3, hardness), rc.ElasticPerfectlyPlastic(1e9, 0.3, 2.5e6)
    np.testing.assert_array_equal(combined_pressure_limit(patchy, uniform), np.minimum(hardness, 2.5e6))
    other = rc.ElasticPerfectlyPlastic(1e9, 0.3, np.ones((3, 3)))
    with pytest.raises(rc.InputError, match="different shapes"):
        combined_pressure_limit(patchy, other)
