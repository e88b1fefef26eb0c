"""Tangential stiffness of contacts on layers beside Ritz's method with Hankel's integrals."""

import numpy as np
import pytest
import roughcontact as rc
from roughcontact.typing import pair_constants
from scipy import linalg, special

from roughcontact_layered import GradedKernel, Layer, LayeredKernel
from roughcontact_layered.shear import respond_across
from roughcontact_layered.stack import half_space, respond, wave_generator

STEEL = rc.Elastic(1e9, 0.3)
FLAT = rc.Body(rc.FlatSurface(), STEEL)
TWO = (Layer(5e9, 0.2, 0.7), Layer(0.3e9, 0.4, 0.4))


def ball(kernel, cells, counterbody=FLAT, turned=False):
    n = 2 * int(np.ceil(1.5 * cells + 5))
    bodies = (rc.Body(rc.ParaboloidSurface(1000.0), STEEL), counterbody)
    problem = rc.ContactProblem(
        *bodies[:: -1 if turned else 1], grid=rc.Grid((n, n), float(n)), kernel=kernel, threads=1
    )
    top = kernel.layers[0].compliance + bodies[1].material.compliance
    return problem.solve(force=4 / 3 / top * cells**3 / 1000.0)


def tangential(solution, axis=0):
    return solution.response(rc.responses.create("tangential-stiffness", axis))


def list_responses(layers, other, q):
    """Return q times the compliances along, across, along the normal, and between the first and the last."""
    one = [respond(layers, STEEL, q, place)[0] for place in ((0, 0), (1, 1), (0, 1))]
    along, normal, coupling = one
    across = respond_across(layers, STEEL, q)[0]
    if other.compliance:
        c, nu = other.compliance, other.poisson
        along, normal, across = along + 2 * c, normal + 2 * c, across + 2 * c / (1 - nu)
        coupling = coupling + (1 - 2 * nu) * (1 + nu) / other.young
    return along, across, normal, -coupling


def resist(layers, other, radius, terms=10):
    """Return the compliance of a disc that sticks: tractions of the angles 0 and 2, pressures of the angle 1.

    Their factors are r^n (1 - r^2)^(k - 1/2), with Sonine's transforms; energies are summed over waves.
    """
    edges = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 30), np.arange(1.0, 1200.0) * 1.5))
    at, w = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (at + 1)).ravel()
    w = (half * w).ravel()
    along, across, normal, coupling = list_responses(layers, other, s / radius)

    def transform(n):
        return np.array(
            [
                2.0 ** (k - 0.5) * special.gamma(k + 0.5) * special.jv(n + k + 0.5, s) / s ** (k + 0.5)
                for k in range(terms)
            ]
        )

    shear, second, pressure = transform(0), transform(2), transform(1)
    none = np.zeros_like(shear)
    of_along = np.concatenate((shear, -second, none))
    of_across = np.concatenate((shear, second, none))
    of_normal = np.concatenate((none, none, pressure))
    energy = (of_along * (w * along)) @ of_along.T + (of_across * (w * across)) @ of_across.T
    energy += (of_normal * (w * normal)) @ of_normal.T
    mixed = (of_along * (w * coupling)) @ of_normal.T
    energy = 0.5 * (energy + mixed + mixed.T)
    # The tail of products that fall as the square, with the mean 1/2 of the squares of sines; coupling has mean zero.
    tail = np.zeros_like(energy)
    firsts = {0: (1, 1), terms: (-1, 1), 2 * terms: (0, 0)}
    for i, (a, b) in firsts.items():
        for j, (c, d) in firsts.items():
            # J_{1/2} and J_{5/2} of both have opposite signs far away.
            sign = -1.0 if (i == terms) != (j == terms) else 1.0
            tail[i, j] = 0.5 * sign * (a * c * along[-1] + b * d * across[-1])
    tail[2 * terms, 2 * terms] = 0.5 * normal[-1]
    energy += tail * 0.5 / edges[-1]
    flows = np.concatenate([[1.0 / (2 * k + 1) for k in range(terms)], np.zeros(2 * terms)])
    return 1.0 / (flows @ np.linalg.solve(energy, flows)) / (2 * np.pi * radius)


@pytest.mark.parametrize("component", [(0, 0), (0, 1), (1, 1)])
def test_waves_are_those_of_the_matrix_exponential(component):
    q = np.geomspace(0.01, 6.0, 12)
    found, _ = respond(TWO, STEEL, q, component)
    for one, value in zip(q, found, strict=True):
        state = np.concatenate((half_space(STEEL.young, STEEL.poisson), np.eye(2)))
        for layer in reversed(TWO):
            state = linalg.expm(-one * layer.thickness * wave_generator(layer.young, layer.poisson)) @ state
        exact = -(state[:2] @ np.linalg.inv(state[2:]))[component]
        assert value == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("shape", "spacing"), [((12, 5), (1.0, 3.0)), ((5, 16), (1.0, 0.5))])
def test_coefficients_are_sums_over_finer_cells(axis, shape, spacing):
    kernel = LayeredKernel(TWO, substrate=STEEL).shear_kernel(axis, pair_constants(STEEL, STEEL))
    compliance = 2 * STEEL.compliance
    found = kernel.coefficients(shape, spacing, compliance)
    finer = kernel.coefficients(tuple(3 * n for n in shape), tuple(side / 3 for side in spacing), compliance)
    i, j = (np.abs(3 * np.arange(n)[:, None] + [-1, 0, 1]) for n in shape)
    sums = finer[i[:, None, :, None], j[None, :, None, :]].sum(axis=(2, 3))
    np.testing.assert_allclose(found, sums, rtol=1e-7)


def test_the_axes_exchange():
    pair = pair_constants(STEEL, STEEL)
    x, y = (LayeredKernel(TWO, substrate=STEEL).shear_kernel(axis, pair) for axis in (0, 1))
    compliance = 2 * STEEL.compliance
    q = np.array([[0.1], [0.9]])
    one = x.spectrum(q, 2.0 * q.T, (1.0, 1.5), compliance)
    np.testing.assert_allclose(y.spectrum(2.0 * q, q.T, (1.5, 1.0), compliance).T, one, rtol=1e-12)


@pytest.mark.parametrize("axis", [0, 1])
def test_layers_of_the_same_material_change_little(axis):
    """Tractions across the force, which are neglected, make a light contact softer by less than 0.4 %."""
    same = LayeredKernel((Layer(1e9, 0.3, 0.7), Layer(1e9, 0.3, 2.0)), substrate=STEEL)
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8.0, longest=32.0, seed=3)
    found = []
    for kernel in (same, "love"):
        body = rc.Body(surface, STEEL)
        problem = rc.ContactProblem(body, FLAT, grid=rc.Grid((64, 60), (64.0, 90.0)), kernel=kernel)
        found.append(tangential(problem.solve(pressure=2e6), axis))
    assert 0.996 * found[1].value < found[0].value < found[1].value
    assert abs(found[0].value - found[1].value) < found[0].uncertainty


@pytest.mark.parametrize(
    ("young", "poisson", "thickness", "other"),
    [
        (5e9, 0.2, 0.2, STEEL),
        (5e9, 0.2, 1.0, STEEL),
        (0.3e9, 0.4, 1.0, STEEL),
        (5e9, 0.2, 1.0, rc.Rigid()),
        (0.3e9, 0.4, 0.2, rc.Rigid()),
    ],
)
def test_a_disc_that_sticks_on_a_layer(young, poisson, thickness, other):
    """Pressure that changes with the force, which is neglected, makes the contact stiffer by up to 0.21 beta^2."""
    kernel = LayeredKernel(Layer(young, poisson, 12.0 * thickness), substrate=STEEL)
    solution = ball(kernel, 12, rc.Body(rc.FlatSurface(), other))
    exact = 1 / resist(kernel.layers, other, np.sqrt(solution.area().value / np.pi))
    waves = np.geomspace(0.02, 1.0, 9)
    betas = kernel.coupling(waves, 1 / solution.modulus, pair_constants(STEEL, other))
    allowed = 0.25 * np.abs(betas).max() ** 2
    found = tangential(solution)
    assert -allowed - 2e-3 < found.value / exact - 1 < 4e-3
    assert abs(found.value - exact) < 1.5 * found.uncertainty
    assert any("coupling" in text for text in found.warnings) == (other != STEEL)


def test_which_body_has_the_layers_does_not_matter():
    other = rc.Body(rc.FlatSurface(), rc.Elastic(2e9, 0.1))
    kernel = LayeredKernel(TWO, substrate=STEEL)
    found = [tangential(ball(kernel, 6, other, turned)) for turned in (False, True)]
    assert found[0].value == pytest.approx(found[1].value, rel=1e-5)
    assert found[0].uncertainty == pytest.approx(found[1].uncertainty, rel=1e-4)


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
def test_the_domain_can_be_turned(boundary):
    kernel = LayeredKernel(Layer(5e9, 0.2, 2.0), substrate=STEEL)
    x, y = np.mgrid[:16, :6]
    heights = np.sin(x / 3.0) * np.cos(y / 2.0) + 0.3 * np.cos(x / 7.0 + y)
    found = []
    for turned in (False, True):
        grid = rc.Grid((6, 16), (18.0, 16.0)) if turned else rc.Grid((16, 6), (16.0, 18.0))
        body = rc.Body(rc.HeightMap(heights.T if turned else heights, grid.size), STEEL)
        sides = boundary[::-1] if turned and isinstance(boundary, tuple) else boundary
        problem = rc.ContactProblem(body, FLAT, grid=grid, kernel=kernel, boundary=sides)
        found.append(tangential(problem.solve(pressure=5e6), 1 if turned else 0))
    assert found[0].value == pytest.approx(found[1].value, rel=1e-5)


def test_units_cancel():
    values = []
    for length, unit in ((1.0, 1.0), (2.0**-20, 2.0**8)):
        steel = rc.Elastic(1e9 * unit, 0.3)
        kernel = LayeredKernel(Layer(3e9 * unit, 0.2, 2.0 * length), substrate=steel)
        body = rc.Body(rc.ParaboloidSurface(100.0 * length), steel)
        problem = rc.ContactProblem(body, grid=rc.Grid((24, 20), (24.0 * length, 20.0 * length)), kernel=kernel)
        found = tangential(problem.solve(force=1e9 * unit * length**2))
        values.append([found.value / (length * unit), found.uncertainty / (length * unit)])
    np.testing.assert_allclose(values[1], values[0], rtol=1e-6)


def test_what_is_not_known_is_refused_in_words():
    graded = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(1000.0), STEEL),
        grid=rc.Grid((16, 16), 16.0),
        kernel=GradedKernel(0.1, surface=STEEL),
    )
    with pytest.raises(rc.InputError, match="needs the response to shear, which this kernel of a graded body"):
        tangential(graded.solve(force=1e8))
    other = rc.Body(rc.ParaboloidSurface(1000.0), rc.Elastic(2e9, 0.2))
    neither = LayeredKernel(Layer(1e9, 0.3, 1.0), substrate=rc.Elastic(3e9, 0.3))
    problem = rc.ContactProblem(other, FLAT, grid=rc.Grid((16, 16), 16.0), kernel=neither)
    with pytest.raises(rc.InputError, match="which body carries the layers"):
        tangential(problem.solve(force=1e8))
    coated = LayeredKernel(Layer(5e9, 0.2, 2.0), substrate=STEEL)
    problem = rc.ContactProblem(
        rc.Body(rc.ParaboloidSurface(1000.0), STEEL), grid=rc.Grid((16, 16), 16.0), kernel=coated
    )
    with pytest.raises(rc.InputError, match="ratio of tangential to normal compliance is the same for all waves"):
        problem.solve(force=1e8).partial_slip(tangential_force=1e5, friction=0.3)
    with pytest.raises(rc.InputError, match="response to shear, which friction needs"):
        problem.path(force=1e8, tangential_force=[(1e6, 0.0)], friction=0.3)
