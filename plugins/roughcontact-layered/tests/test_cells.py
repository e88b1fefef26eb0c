import numpy as np
import pytest
import roughcontact as rc
from scipy import special

from roughcontact_layered import Layer, LayeredKernel
from roughcontact_layered.radial import tabulate

STEEL = rc.Elastic(1.0, 0.3)
C = STEEL.compliance


@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.0, 0.3), (0.2, 1.0)])
def test_equal_layers_are_loves_half_space(spacing):
    kernel = LayeredKernel((Layer(1.0, 0.3, 0.7), Layer(1.0, 0.3, 2.0)), substrate=STEEL)
    love = rc.Love()
    np.testing.assert_allclose(
        kernel.coefficients((40, 30), spacing, C), love.coefficients((40, 30), spacing, C), rtol=1e-12
    )
    qx, qy = (np.linspace(0.01, np.pi, 9) / side for side in spacing)
    waves = qx[:, None], qy[None, :]
    np.testing.assert_allclose(kernel.spectrum(*waves, spacing, C), love.spectrum(*waves, spacing, C), rtol=1e-12)


def test_the_point_force_is_hankels_integral():
    """The rest decays with the wave number, so that plain quadrature in fine panels does as well."""
    kernel = LayeredKernel(Layer(0.2, 0.4, 1.0), substrate=STEEL)
    table = tabulate(kernel, 0.05, 50.0)
    at, weight = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0.0, 24.0, 1201)
    half = 0.5 * np.diff(edges)[:, None]
    q = (edges[:-1, None] + half * (at + 1.0)).ravel()
    w = (half * weight).ravel()
    values = kernel.rest(q) * q
    for r in (0.1, 1.0, 7.0, 40.0):
        exact = np.sum(w * values * special.j0(q * r)) / (2 * np.pi)
        scale = C / (np.pi * r)
        assert table.displacement(np.array([r]), np.zeros(1)).item() == pytest.approx(exact, abs=1e-12 * scale + 1e-14)


@pytest.mark.parametrize(
    ("layers", "substrate"),
    [
        ((Layer(5.0, 0.25, 0.3), Layer(0.05, 0.5, 0.2), Layer(20.0, 0.2, 1.5)), STEEL),
        ((Layer(1.0, 0.3, 0.3), Layer(1e-3, 0.5, 0.05)), rc.Rigid()),
    ],
)
def test_the_rest_at_any_wave_number_is_that_of_the_layers(layers, substrate):
    """A plate on an incompressible layer has the poles that are nearest to real wave numbers."""
    kernel = LayeredKernel(layers, substrate=substrate)
    q = np.geomspace(1e-9, 1e4, 4001)
    exact = kernel.respond(q)[1]
    np.testing.assert_allclose(kernel.rest(q) * q, exact, rtol=0, atol=3e-14 * np.abs(exact).max())


@pytest.mark.parametrize("ratio", [0.1, 0.5, 5.0])
@pytest.mark.parametrize("thickness", [1e-2, 0.2, 1.0, 5.0])
def test_cells_near_and_far_are_one_function(ratio, thickness):
    """Cells made of finer cells: the sum of their coefficients at one point is that of the whole."""
    kernel = LayeredKernel(Layer(ratio, 0.25, thickness), substrate=STEEL)
    whole = kernel.coefficients((80, 70), (1.0, 1.2), C)
    fine = kernel.coefficients((242, 212), (1 / 3, 0.4), C)
    for i, j in ((0, 0), (1, 0), (3, 7), (10, 2), (11, 11), (60, 5), (79, 69)):
        rows, columns = (np.abs(np.arange(3 * k - 1, 3 * k + 2)) for k in (i, j))
        assert whole[i, j] == pytest.approx(fine[np.ix_(rows, columns)].sum(), rel=1e-11)


@pytest.mark.parametrize("ratio", [0.1, 5.0])
@pytest.mark.parametrize("thickness", [1e-2, 0.2, 1.0])
def test_the_spectrum_is_the_transform_of_the_coefficients(ratio, thickness):
    """The difference to the substrate's half-space falls as r^-3; at short waves its cut-off end does not count."""
    kernel, love, n = LayeredKernel(Layer(ratio, 0.25, thickness), substrate=STEEL), rc.Love(), 256
    spacing, shape = (1.0, 1.3), (n // 2 + 1, n // 2 + 1)
    difference = kernel.coefficients(shape, spacing, C) - love.coefficients(shape, spacing, C)
    index = np.minimum(np.arange(n), n - np.arange(n))
    transform = np.fft.fft2(difference[np.ix_(index, index)]).real
    q = 2 * np.pi * np.fft.fftfreq(n)[1:]
    waves = q[:, None] / spacing[0], q[None, :] / spacing[1]
    spectrum = kernel.spectrum(*waves, spacing, C) - love.spectrum(*waves, spacing, C)
    size = love.spectrum(*waves, spacing, C)
    i, j = 40, 55
    assert abs(spectrum - transform[1:, 1:])[i, j] < 1e-9 * size[i, j]


@pytest.mark.parametrize("layers", [Layer(0.1, 0.3, 0.05), (Layer(8.0, 0.25, 0.4), Layer(0.1, 0.5, 1.0))])
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.0, 3.0), (6.0, 1.0)])
@pytest.mark.parametrize("axis", [0, 1])
def test_free_along_one_axis_is_a_sum_over_images_of_the_free_coefficients(layers, spacing, axis):
    """Of a pressure without a mean along the periodic axis; what layers add to the half-space falls as r^-3."""
    kernel = LayeredKernel(layers, substrate=STEEL)
    shape = (9, 10) if axis == 0 else (10, 9)
    periods = 81
    boundary = ("free", "periodic") if axis == 0 else ("periodic", "free")
    body = rc.Body(rc.ParaboloidSurface(radius=200.0), STEEL)
    pressure = np.random.default_rng(3).standard_normal(shape)
    pressure -= pressure.mean(axis=1 - axis, keepdims=True)
    repeated = np.tile(pressure, (1, periods) if axis == 0 else (periods, 1))

    def displace(pressure, kernel, boundary):
        sides = tuple(n * side for n, side in zip(pressure.shape, spacing, strict=True))
        problem = rc.ContactProblem(body, grid=rc.Grid(pressure.shape, sides), kernel=kernel, boundary=boundary)
        return problem.convolution.apply(pressure)

    found = displace(pressure, kernel, boundary) - displace(pressure, "love", boundary)
    images = displace(repeated, kernel, "free") - displace(repeated, "love", "free")
    middle = slice(periods // 2 * 10, (periods // 2 + 1) * 10)
    images = images[:, middle] if axis == 0 else images[middle]
    np.testing.assert_allclose(found, images, rtol=0, atol=1e-8 * np.abs(found).max())


def test_thick_layers_are_their_half_space_and_thin_ones_the_substrate():
    love = rc.Love().coefficients((64, 64), (1.0, 1.0), 1.0)
    layers = [Layer(4.0, 0.25, h) for h in (1e5, 2e5, 1e-5, 2e-5)]
    found = [LayeredKernel(layer, substrate=STEEL).coefficients((64, 64), (1.0, 1.0), C) for layer in layers]
    top = layers[0].compliance
    beyond = [np.abs(values / (top * love) - 1).max() for values in found[:2]]
    within = [np.abs(values / (C * love) - 1).max() for values in found[2:]]
    # A far substrate moves the surface by its distance's inverse, a thin layer by its thickness.
    assert beyond[0] / beyond[1] == pytest.approx(2.0, rel=1e-2)
    assert within[1] / within[0] == pytest.approx(2.0, rel=1e-2)
    assert beyond[0] < 4e-3
    assert within[0] < 1e-4


def test_free_is_the_direct_sum():
    kernel = LayeredKernel((Layer(3.0, 0.3, 2.0), Layer(0.2, 0.5, 1.0)), substrate=STEEL)
    body, grid = rc.Body(rc.ParaboloidSurface(radius=200.0), STEEL), rc.Grid((18, 14), (18.0, 14.0))
    pressure = np.random.default_rng(1).random(grid.shape)
    one, other = (
        rc.ContactProblem(body, grid=grid, kernel=kernel, convolver=name).convolution.apply(pressure)
        for name in ("dc-fft", "direct")
    )
    np.testing.assert_allclose(one, other, rtol=1e-13)


def test_work_is_positive_and_reciprocal():
    kernel = LayeredKernel(Layer(10.0, 0.3, 0.5), substrate=STEEL)
    body, grid = rc.Body(rc.ParaboloidSurface(radius=200.0), STEEL), rc.Grid((32, 32), (32.0, 32.0))
    rng = np.random.default_rng(2)
    for boundary in ("free", "periodic"):
        apply = rc.ContactProblem(body, grid=grid, kernel=kernel, boundary=boundary).convolution.apply
        one, other = rng.standard_normal((2, 32, 32))
        one, other = one - one.mean(), other - other.mean()
        assert np.sum(one * apply(one)) > 0.0
        assert np.sum(one * apply(other)) == pytest.approx(np.sum(other * apply(one)), rel=1e-10)
