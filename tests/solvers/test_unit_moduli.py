"""Ellipses of equal area beneath crystals."""

from __future__ import annotations

import numpy as np

from roughcontact._answers.areas.ellipses import find_ellipses
from roughcontact._answers.areas.summits import find_area_factor, find_axes_ratio


def test_isotropic_ellipses_are_those_of_hertz():
    ratio = np.array([1.0, 0.7, 0.2, 0.05])
    mean = 0.5 * (1.0 + ratio)
    turn = np.array([0.0, 0.3, 1.0, 2.0])
    deviator = 0.5 * (1.0 - ratio) * np.stack((np.cos(2.0 * turn), np.sin(2.0 * turn)))
    found = find_ellipses((1.0,) * 128, np.ones(4), mean, deviator)
    assert found.known.all()
    np.testing.assert_allclose(found.axes_ratio, find_axes_ratio(ratio), rtol=2e-5)
    np.testing.assert_allclose(found.area, np.pi * (0.75 / mean) ** (2 / 3) * find_area_factor(ratio), rtol=1e-5)
    # The longer axis lies where the curvature is smaller.
    np.testing.assert_allclose(np.cos(2.0 * (found.angle - turn))[1:], -1.0, atol=1e-9)


def test_an_ellipse_turns_with_the_body_and_its_surface():
    angles = np.linspace(0.0, np.pi, 128, endpoint=False)
    mean = np.ones(1)

    def ellipse(turn):
        moduli = 1.0 / (1.0 + 0.4 * np.cos(2.0 * (angles - turn)))
        deviator = 0.3 * np.array([[np.cos(2.0 * (turn + 0.5))], [np.sin(2.0 * (turn + 0.5))]])
        return find_ellipses(tuple(moduli), mean, mean, deviator)

    one = ellipse(0.0)
    for turn in (0.3, 1.2, 2.9):
        other = ellipse(turn)
        np.testing.assert_allclose((other.area, other.axes_ratio), (one.area, one.axes_ratio), rtol=1e-9)
        np.testing.assert_allclose(np.cos(2.0 * (other.angle - one.angle - turn)), 1.0, atol=1e-9)
