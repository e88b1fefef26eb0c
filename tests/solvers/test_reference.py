"""The closed forms satisfy each other, their integrals and their limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate

from roughcontact import InputError, reference

FORCES = st.floats(1e-6, 1e6)
RADII = st.floats(1e-6, 1e2)
MODULI = st.floats(1e3, 1e13)


@given(FORCES, RADII, MODULI)
def test_hertz_satisfies_its_own_geometry(force, radius, modulus):
    contact = reference.hertz_sphere(force, radius, modulus)
    a = contact.semi_axes[0]
    assert contact.p_max == pytest.approx(1.5 * force / contact.area)
    # The pressure bends the surfaces to the sphere: u(0) - u(a) = a^2 / 2R.
    assert np.pi * contact.p_max * a / (4 * modulus) == pytest.approx(a**2 / (2 * radius))
    assert contact.approach == pytest.approx(np.pi * contact.p_max * a / (2 * modulus))


@given(FORCES, RADII, st.floats(1.0001, 1e6), MODULI)
def test_elliptic_hertz_carries_its_load_and_turns_with_its_radii(force, radius, ratio, modulus):
    contact = reference.hertz_elliptic(force, (ratio * radius, radius), modulus)
    turned = reference.hertz_elliptic(force, (radius, ratio * radius), modulus)
    assert contact.semi_axes[0] > contact.semi_axes[1]
    assert turned.semi_axes == contact.semi_axes[::-1]
    assert contact.p_max * contact.area * 2 / 3 == pytest.approx(force)


@given(FORCES, RADII, MODULI)
def test_elliptic_hertz_tends_to_the_sphere(force, radius, modulus):
    sphere = reference.hertz_sphere(force, radius, modulus)
    nearly = reference.hertz_elliptic(force, (radius * (1 + 1e-9), radius), modulus)
    assert nearly.p_max == pytest.approx(sphere.p_max, rel=1e-8)
    assert nearly.approach == pytest.approx(sphere.approach, rel=1e-8)
    assert nearly.semi_axes == pytest.approx(sphere.semi_axes, rel=1e-8)


@pytest.mark.parametrize("sharp", [1e-6, 1.0, 1e3])
def test_only_the_ratio_of_the_radii_says_that_an_ellipse_is_too_slender(sharp):
    reference.hertz_elliptic(1.0, (sharp, 0.9e24 * sharp), 1e11)
    with pytest.raises(InputError, match="cylinders"):
        reference.hertz_elliptic(1.0, (1.1e24 * sharp, sharp), 1e11)


def test_elliptic_hertz_bends_the_surface_to_the_paraboloid():
    """Displacement under the ellipse of pressure, integrated in polar coordinates around each point."""
    modulus, radii = 1e11, (3e-2, 1e-2)
    contact = reference.hertz_elliptic(50.0, radii, modulus)
    a, b = contact.semi_axes

    def displacement(x, y):
        def ray(angle):
            c, s = np.cos(angle), np.sin(angle)
            # p along a ray is the root of a quadratic: its integral to the edge is elementary.
            q2 = (c / a) ** 2 + (s / b) ** 2
            q1 = x * c / a**2 + y * s / b**2
            q0 = 1 - (x / a) ** 2 - (y / b) ** 2
            root = np.sqrt(q0 * q2 + q1**2)
            return (root**2 * np.arccos(q1 / root) - q1 * np.sqrt(q0 * q2)) / (2 * q2**1.5)

        return contact.p_max / (np.pi * modulus) * integrate.quad(ray, 0, 2 * np.pi, epsabs=0, epsrel=1e-10)[0]

    assert displacement(0, 0) == pytest.approx(contact.approach, rel=1e-8)
    for x, y in ((0.5 * a, 0.0), (0.0, 0.7 * b), (0.3 * a, 0.4 * b)):
        depth = x**2 / (2 * radii[0]) + y**2 / (2 * radii[1])
        assert displacement(x, y) == pytest.approx(contact.approach - depth, rel=1e-8)


def test_the_papers_analytic_rows():
    """Table 1 and 2, first column: they need E* = 200 GPa / (1 - 0.3^2)."""
    wave = reference.WavyContact(0.5e-6, 12.5e-6, 200e9 / (1 - 0.3**2))
    for load, p_max, area in ((50, 10.52, 0.713), (100, 13.26, 1.131), (200, 16.71, 1.796)):
        assert round(wave.light_p_max(load * 1e6) / 1e9, 2) == p_max
        assert round(100 * wave.light_area_fraction(load * 1e6), 3) == area


def test_the_light_wave_is_hertz_on_each_summit():
    amplitude, wavelength, modulus, mean = 1e-6, 1e-4, 1e11, 1e5
    wave = reference.WavyContact(amplitude, wavelength, modulus)
    radius = wavelength**2 / (4 * np.pi**2 * amplitude)
    summit = reference.hertz_sphere(mean * wavelength**2, radius, modulus)
    assert wave.light_area_fraction(mean) == pytest.approx(summit.area / wavelength**2)
    assert wave.light_p_max(mean) == pytest.approx(summit.p_max)


def test_full_contact_of_the_wave_closes_at_its_pressure():
    wave = reference.WavyContact(1e-6, 1e-4, 1e11)
    x = np.linspace(0, 1e-4, 41)
    field = wave.full_contact(x[:, None], x[None, :], wave.full_contact_pressure)
    assert field.min() == pytest.approx(0.0, abs=1e-9 * field.max())
    assert wave.heavy_area_fraction(wave.full_contact_pressure) == 1.0


@pytest.mark.parametrize("fraction", [0.01, 0.3, 0.7, 0.99])
def test_the_load_of_westergaard_is_inside_the_strip(fraction):
    strip = reference.Westergaard(1e-6, 1e-4, 1e11)
    mean = fraction * strip.full_contact_pressure
    a = strip.half_width(mean)
    carried, _ = integrate.quad(lambda x: float(strip.pressure(np.array(x), mean)), -a, a, limit=200)
    assert carried == pytest.approx(mean * 1e-4, rel=1e-6)
    assert strip.pressure(np.array([1.001 * a, 5e-5]), mean).max() == 0.0


def test_westergaard_is_a_cosine_at_full_contact_and_hertz_at_light_load():
    strip = reference.Westergaard(1e-6, 1e-4, 1e11)
    x = np.linspace(-5e-5, 5e-5, 30)
    full = strip.pressure(x, strip.full_contact_pressure)
    np.testing.assert_allclose(full, strip.full_contact_pressure * (1 + np.cos(2 * np.pi * x / 1e-4)), rtol=1e-9)
    mean = 1e-6 * strip.full_contact_pressure
    radius = (1e-4 / (2 * np.pi)) ** 2 / 1e-6
    line = np.sqrt(4 * mean * 1e-4 * radius / (np.pi * 1e11))
    assert strip.half_width(mean) == pytest.approx(line, rel=1e-5)


def test_the_punch_carries_its_load():
    punch = reference.FlatPunch(7.0, 1e-3, 1e11)

    def integral(weight):
        # r = a sin(t) takes the singularity at the edge away.
        def term(t):
            return weight(1e-3 * np.sin(t)) * float(punch.pressure(np.array(1e-3 * np.sin(t)))) * 1e-3 * np.cos(t)

        return integrate.quad(term, 0, np.pi / 2 - 1e-9)[0]

    assert integral(lambda r: 2 * np.pi * r) == pytest.approx(7.0, rel=1e-6)
    # Displacement of the axis: the integral of p / (pi E* r) over the face.
    assert integral(lambda r: 2 / 1e11) == pytest.approx(punch.approach, rel=1e-6)
