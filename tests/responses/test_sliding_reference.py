"""The stress below a sliding sphere and a sliding cylinder: point and line forces, edges, symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.reference import SlidingCylinder, SlidingSphere

XX, YY, ZZ, YZ, XZ, XY = range(6)


def normal_point_force(x, y, z, nu):
    """Return the stress by a unit force along z; Johnson (1985), sec. 3.2."""
    square, away, lateral = x * x + y * y, np.sqrt(x * x + y * y + z * z), 1.0 - 2.0 * nu
    diagonal = lateral / (away * (away + z))
    return np.array(
        [
            diagonal * (x * x - y * y) / square + lateral * y * y * z / (away**3 * square) - 3 * x * x * z / away**5,
            diagonal * (y * y - x * x) / square + lateral * x * x * z / (away**3 * square) - 3 * y * y * z / away**5,
            -3 * z**3 / away**5,
            -3 * y * z * z / away**5,
            -3 * x * z * z / away**5,
            lateral * x * y * (2 * away + z) / (away**3 * (away + z) ** 2) - 3 * x * y * z / away**5,
        ]
    ) / (2.0 * np.pi)


def tangential_point_force(x, y, z, nu):
    """Return the stress by a unit force along x; Johnson (1985), sec. 3.6."""
    r, lateral = np.sqrt(x * x + y * y + z * z), 1.0 - 2.0 * nu
    near = 1.0 / (r * (r + z) ** 2)
    curved = 1.0 / (r**3 * (r + z) ** 2) + 2.0 / (r**2 * (r + z) ** 3)
    return np.array(
        [
            -3 * x**3 / r**5 + lateral * x * (1 / r**3 - 3 * near + x * x * curved),
            -3 * x * y * y / r**5 + lateral * x * (1 / r**3 - near + y * y * curved),
            -3 * x * z * z / r**5,
            -3 * x * y * z / r**5,
            -3 * x * x * z / r**5,
            -3 * x * x * y / r**5 + lateral * y * (x * x * curved - near),
        ]
    ) / (2.0 * np.pi)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_the_sphere_is_the_integral_of_point_forces(nu):
    nodes, weights = np.polynomial.legendre.leggauss(160)
    angle = 0.25 * np.pi * (nodes + 1.0)
    turn = np.arange(320) * (2.0 * np.pi / 320)
    x, y = (np.sin(angle)[:, np.newaxis] * part for part in (np.cos(turn), np.sin(turn)))
    load = (0.25 * np.pi * weights * np.sin(angle) * np.cos(angle) ** 2)[:, np.newaxis] * (2.0 * np.pi / 320)
    for place in ((0.7, -0.2, 0.25), (-1.3, 0.9, 0.4), (1e-9, 0.0, 0.5), (0.1, 1.1, 2.0)):
        u, v, z = place[0] - x, place[1] - y, place[2]
        normal, shear = (
            (force(u, v, z, nu) * load).sum(axis=(1, 2)) for force in (normal_point_force, tangential_point_force)
        )
        found = SlidingSphere(2.0, 3.0, 0.4, nu).stress(*(2.0 * part for part in place))
        np.testing.assert_allclose(found, 3.0 * (normal + 0.4 * shear), atol=1e-12)


def test_the_cylinder_is_the_integral_of_line_forces():
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angle = 0.5 * np.pi * nodes
    load = 0.5 * np.pi * weights * np.cos(angle) ** 2
    for x, z in ((0.3, 0.2), (-1.4, 0.3), (0.0, 1.0)):
        u = x - np.sin(angle)
        # Flamant's line forces; Johnson (1985), sec. 2.2 and 2.3.
        ray = -2.0 / np.pi * load / (u * u + z * z) ** 2
        xx, zz, xz = (
            (ray * (part + 0.4 * shear)).sum()
            for part, shear in ((u * u * z, u**3), (z**3, u * z * z), (u * z * z, u * u * z))
        )
        found = SlidingCylinder(2.0, 3.0, 0.4, 0.3).stress(2.0 * x, 2.0 * z)
        np.testing.assert_allclose(found, 3.0 * np.array([xx, 0.3 * (xx + zz), zz, 0.0, xz, 0.0]), atol=1e-12)


@pytest.mark.parametrize("mu", [0.0, 0.25, -0.5])
def test_the_surface_carries_the_tractions(mu):
    x, y = np.linspace(-1.5, 1.5, 31)[:, np.newaxis], np.linspace(-1.5, 1.5, 21)
    sphere, cylinder = SlidingSphere(1.0, 2.0, mu, 0.3), SlidingCylinder(1.0, 2.0, mu, 0.3)
    pressure = 2.0 * np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    for found, load in ((sphere.stress(x, y, 0.0), pressure), (cylinder.stress(y, 0.0), pressure[15])):
        np.testing.assert_allclose(found[ZZ], -load, atol=1e-12)
        np.testing.assert_allclose(found[XZ], -mu * load, atol=1e-12)
        np.testing.assert_allclose(found[YZ], 0.0, atol=1e-12)
    rear = math.copysign(1.0, -mu)
    tension = 2.0 * (0.4 / 3.0 + math.pi * 4.3 / 8.0 * abs(mu))
    assert sphere.stress(rear, 0.0, 0.0)[XX] == pytest.approx(tension)
    assert cylinder.stress(rear, 0.0)[XX] == pytest.approx(4.0 * abs(mu))


def test_a_turn_of_the_friction_mirrors_the_stress():
    x, y, z = np.random.default_rng(1).uniform(0.1, 1.5, (3, 20))
    signs = np.array([1, 1, 1, 1, -1, -1])[:, np.newaxis]
    one, other = SlidingSphere(1.0, 1.0, 0.3, 0.2), SlidingSphere(1.0, 1.0, -0.3, 0.2)
    np.testing.assert_allclose(one.stress(x, y, z), signs * other.stress(-x, y, z), atol=1e-14)
    signs = np.array([1, 1, 1, -1, 1, -1])[:, np.newaxis]
    np.testing.assert_allclose(one.stress(x, y, z), signs * one.stress(x, -y, z), atol=1e-14)


def test_bad_places_and_numbers_get_a_sentence():
    sphere, cylinder = SlidingSphere(1.0, 1.0, 0.3, 0.2), SlidingCylinder(1.0, 1.0, 0.3, 0.2)
    for x, z in ((0.0, -1.0), (math.nan, 1.0), ("here", 1.0), (np.zeros(3), np.zeros(2))):
        with pytest.raises(rc.InputError):
            sphere.stress(x, 0.0, z)
        with pytest.raises(rc.InputError):
            cylinder.stress(x, z)
    for numbers in ((0.0, 1.0, 0.3, 0.2), (1.0, -1.0, 0.3, 0.2), (1.0, 1.0, math.inf, 0.2), (1.0, 1.0, 0.3, 0.6)):
        for closed_form in (SlidingSphere, SlidingCylinder):
            with pytest.raises(rc.InputError):
                closed_form(*numbers)
