"""Exponentially graded half-spaces: waves, cells and contact."""

import mpmath as mp
import numpy as np
import pytest
import roughcontact as rc

from independent import sphere_by_rings
from roughcontact_layered import GradedKernel, Layer, LayeredKernel
from roughcontact_layered.graded import respond_graded
from roughcontact_layered.stack import respond

SURFACE = rc.Elastic(1e9, 0.3)
C = SURFACE.compliance
POISSON = (-0.99, -0.5, 1e-3, 0.2, 0.45, 0.49999, 0.5)


def by_roots(gradient, poisson):
    """Return q u / p over (1 - nu^2) / E0 from both exponential stress functions, with 60 digits."""
    with mp.workdps(60):
        alpha, nu = mp.mpf(gradient), mp.mpf(poisson)
        k = nu / (1 - nu)
        one, other = (alpha / 2 - mp.sqrt(1 + alpha**2 / 4 + sign * mp.sqrt(-k) * alpha) for sign in (1, -1))
        # A pressure of one and no traction along the surface.
        weights = -other / (one - other), one / (one - other)
        second, third = (sum(w * root**n for w, root in zip(weights, (one, other), strict=True)) for n in (2, 3))
        return float(mp.re(third - alpha * second - alpha * k))


@pytest.mark.parametrize("poisson", POISSON)
def test_waves_are_both_stress_functions(poisson):
    gradients = np.concatenate((np.geomspace(1e-6, 1e6, 25), -np.geomspace(1e-6, 1e6, 25)))
    expected = [by_roots(gradient, poisson) for gradient in gradients]
    np.testing.assert_allclose(respond_graded(gradients, poisson), expected, rtol=1e-14)


@pytest.mark.parametrize("poisson", [*POISSON, 0.0])
def test_without_a_gradient_it_is_the_homogeneous_half_space(poisson):
    assert respond_graded(np.zeros(1), poisson).item() == 2.0
    small = respond_graded(np.array([1e-12, -1e-12]), poisson) / 2.0 - 1.0
    np.testing.assert_allclose(small, 0.0, atol=1e-10)
    surface = rc.Elastic(1e9, poisson)
    cells = (9, 7), (1e-6, 2e-6), surface.compliance
    none, little = (GradedKernel(gradient, surface=surface).coefficients(*cells) for gradient in (0.0, 1e-8))
    np.testing.assert_array_equal(none, rc.Love().coefficients(*cells))
    np.testing.assert_allclose(little, none, rtol=1e-10)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_many_thin_layers_are_the_gradient(poisson):
    """At second order in their thickness, extrapolated."""
    q = np.array([1.0, 2.0, 4.0])
    found = []
    for count in (150, 300):
        thickness = 12.0 / count
        layers = [Layer(np.exp((i + 0.5) * thickness), poisson, thickness) for i in range(count)]
        found.append(respond(tuple(layers), rc.Elastic(np.exp(12.0), poisson), q)[0] / (1.0 - poisson**2))
    expected = respond_graded(1.0 / q, poisson)
    coarse, fine = found
    np.testing.assert_allclose(fine, expected, rtol=1e-3)
    np.testing.assert_allclose((4.0 * fine - coarse) / 3.0, expected, rtol=2e-5)


def test_a_softening_half_space_bends_as_a_plate_under_long_waves():
    """Its stiffness E0 / (1 - nu^2) / |alpha|^3 is the second moment of the modulus about its centre."""
    assert respond_graded(np.array([-1e4]), 0.3).item() == pytest.approx(1e12, rel=1e-6)


def test_a_stiffening_half_space_is_stiffer_and_a_softening_one_softer():
    values = respond_graded(np.linspace(-5.0, 5.0, 41), 0.3)
    assert (np.diff(values) < 0.0).all()


@pytest.mark.parametrize("gradient", [2e3, 2e5, 2e6])
def test_cells_near_and_far_are_one_function(gradient):
    """Up to rounding of a half-space of the surface, for far from a force a stiffening body hardly moves."""
    kernel = GradedKernel(gradient, surface=SURFACE)
    spacing = 1e-6, 1.2e-6
    whole = kernel.coefficients((80, 70), spacing, C)
    fine = kernel.coefficients((242, 212), (spacing[0] / 3, spacing[1] / 3), C)
    love = rc.Love().coefficients((80, 70), spacing, C)
    for i, j in ((0, 0), (1, 0), (3, 7), (10, 2), (11, 11), (60, 5), (79, 69)):
        rows, columns = (np.abs(np.arange(3 * k - 1, 3 * k + 2)) for k in (i, j))
        assert whole[i, j] == pytest.approx(fine[np.ix_(rows, columns)].sum(), abs=1e-11 * love[i, j])


@pytest.mark.parametrize("gradient", [3e5, 1e6])
def test_the_spectrum_is_the_transform_of_the_coefficients(gradient):
    """The displacement falls exponentially, so that its transform needs no images."""
    kernel, n, spacing = GradedKernel(gradient, surface=SURFACE), 512, (1e-6, 1.3e-6)
    index = np.minimum(np.arange(n), n - np.arange(n))
    transform = np.fft.fft2(kernel.coefficients((n // 2 + 1, n // 2 + 1), spacing, C)[np.ix_(index, index)]).real
    q = 2 * np.pi * np.fft.fftfreq(n)[1:]
    spectrum = kernel.spectrum(q[:, None] / spacing[0], q[None, :] / spacing[1], spacing, C)
    np.testing.assert_allclose(spectrum[:200:20, :200:20], transform[1:201:20, 1:201:20], rtol=1e-7)


@pytest.mark.parametrize("product", [0.1, 0.5, 2.0])
def test_load_and_approach_of_a_sphere_are_those_of_the_axisymmetric_problem(product):
    contact = 0.01
    kernel = GradedKernel(product / contact, surface=SURFACE)
    force, approach = sphere_by_rings(lambda q: kernel.response(q, C), 1.0 / C, 1.0, contact)
    assert force > 4.0 / (3.0 * C) * contact**3
    body = rc.Body(rc.ParaboloidSurface(radius=1.0), SURFACE)
    problem = rc.ContactProblem(body, grid=rc.Grid((129, 129), 3.2 * contact), kernel=kernel)
    solution = problem.solve(force=force)
    assert solution.approach == pytest.approx(approach, rel=2e-4)
    area = solution.area()
    assert area.value == pytest.approx(np.pi * contact**2, rel=2e-3)
    assert abs(area.value - np.pi * contact**2) < 3.0 * area.uncertainty + 1e-3 * area.value


def test_lengths_and_moduli_scale():
    one = GradedKernel(1e5, surface=SURFACE).coefficients((9, 7), (1e-6, 2e-6), C)
    softer = GradedKernel(1e5 / 3, surface=rc.Elastic(0.2e9, 0.3)).coefficients((9, 7), (3e-6, 6e-6), 5 * C)
    np.testing.assert_allclose(softer, 15 * one, rtol=1e-11)


def test_it_is_symmetric_in_x_and_y():
    kernel = GradedKernel(1e5, surface=SURFACE)
    one = kernel.coefficients((30, 20), (1e-6, 2e-6), C)
    other = kernel.coefficients((20, 30), (2e-6, 1e-6), C)
    np.testing.assert_allclose(other, one.T, rtol=1e-12, atol=1e-14 * one.max())


def test_a_softening_half_space_needs_a_periodic_boundary():
    body = rc.Body(rc.WavySurface(1e-8, 1e-5), SURFACE)
    kernel = GradedKernel(-1e5, surface=SURFACE)
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1e-5), kernel=kernel)
    with pytest.raises(rc.InputError, match="sinks infinitely"):
        problem.solve(pressure=1e4)
    periodic = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1e-5), kernel=kernel, boundary="periodic")
    assert periodic.solve(pressure=1e4).status.success


def test_layers_as_a_kernel_give_the_same_contact():
    depth, count = 1e-5, 60
    layers = [Layer(1e9 * np.exp((i + 0.5) * 5.0 / count), 0.3, 5.0 * depth / count) for i in range(count)]
    stack = LayeredKernel(layers, substrate=rc.Elastic(1e9 * np.exp(5.0), 0.3))
    graded = GradedKernel(1.0 / depth, surface=SURFACE)
    q = np.array([2e5])
    below = stack.response(q, stack.substrate.compliance)
    assert below == pytest.approx(graded.response(q, C), rel=3e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: GradedKernel("steep", surface=SURFACE), "gradient"),
        (lambda: GradedKernel(np.inf, surface=SURFACE), "gradient"),
        (lambda: GradedKernel(1.0, surface=1e9), "surface"),
        (lambda: GradedKernel(1.0, surface=SURFACE).coefficients((2, 2), (1.0, 1.0), 0.5 * C), "softer"),
        (lambda: rc.kernels.create("graded"), "without arguments"),
    ],
)
def test_bad_input_is_refused_in_words(make, words):
    with pytest.raises(rc.InputError, match=words):
        make()
