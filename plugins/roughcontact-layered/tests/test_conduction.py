"""Conductance of contacts on layers beside Hankel's integrals, limits and sums over cells."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
from scipy import special

from roughcontact_layered import GradedKernel, Layer, LayeredKernel
from roughcontact_layered.conduction import LayeredConduction, conduct

STEEL = rc.Elastic(1e9, 0.3)
FLAT = rc.Body(rc.FlatSurface(), STEEL)


def stack(*pairs):
    """Return layers of the substrate's elasticity, by their conductivity and thickness: Hertz's contact remains."""
    layers = tuple(Layer(STEEL.young, STEEL.poisson, thickness, k) for k, thickness in pairs)
    return LayeredKernel(layers, substrate=STEEL)


def ball(kernel, cells, boundary="free", shape=None, size=None, counterbody=FLAT):
    """Return the contact of a ball of a radius in cells."""
    n = 2 * int(np.ceil(1.3 * cells + 5))
    grid = rc.Grid(shape or (n, n), size or float(n))
    body = rc.Body(rc.ParaboloidSurface(1000.0, center=(0.2, -0.3)), STEEL)
    problem = rc.ContactProblem(body, counterbody, grid=grid, kernel=kernel, boundary=boundary, threads=1)
    modulus = problem.plan.modulus
    return problem.solve(force=4 / 3 * modulus * cells**3 / 1000.0)


def solve_layers(pairs, substrate, q):
    """Return q T / f from all constants at once: a growing and a decaying wave in each layer, referred to its sides."""
    count = len(pairs)
    matrix = np.zeros((2 * count + 1, 2 * count + 1))
    right = np.zeros(2 * count + 1)
    # Flow k (A - B e) at the surface over q.
    for n, (k, h) in enumerate(pairs):
        e = np.exp(-q * h)
        if n == 0:
            matrix[0, :2] = k, -k * e
            right[0] = 1.0
        row, last = 2 * n + 1, n + 1 == count
        below = substrate if last else pairs[n + 1][0]
        after = 1.0 if last else np.exp(-q * pairs[n + 1][1])
        matrix[row, 2 * n : 2 * n + 3] = e, 1.0, -1.0
        matrix[row + 1, 2 * n : 2 * n + 3] = k * e, -k, -below
        if not last:
            matrix[row, 2 * n + 3] = -after
            matrix[row + 1, 2 * n + 3] = below * after
    found = np.linalg.solve(matrix, right)
    return found[0] + found[1] * np.exp(-q * pairs[0][1])


def resist(pairs, substrate, other, radius):
    """Return the resistance of an isothermal disc by Ritz's method, flows (1 - r^2)^(k - 1/2), k = 0 .. 11."""
    edges = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 30), np.arange(1.0, 500.0) * 1.5))
    at, w = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (at + 1)).ravel()
    w = (half * w).ravel()
    top = 1 / pairs[0][0]
    rest = np.array([solve_layers(pairs, substrate, q / radius) - top if q < 600 else 0.0 for q in s])
    orders = np.arange(12)
    transforms = np.array([
        2.0 ** (k - 0.5) * special.gamma(k + 0.5) * special.jv(k + 0.5, s) / s ** (k + 0.5) for k in orders
    ])
    energy = (transforms * (w * rest)) @ transforms.T
    # Of a half-space: the product of both transforms integrated (Weber and Schafheitlin).
    for i in orders:
        for j in orders:
            a, b = i + 0.5, j + 0.5
            lam = a + b
            integral = special.gamma(lam) * special.gamma(0.5) / (
                2.0**lam * special.gamma((-a + b + lam + 1) / 2) * special.gamma((a + b + lam + 1) / 2)
                * special.gamma((a - b + lam + 1) / 2)
            )
            factor = 2.0 ** (i + j - 1) * special.gamma(a) * special.gamma(b)
            energy[i, j] += (top + 1 / other) * factor * integral
    flows = np.array([1.0 / (2 * k + 1) for k in orders])
    return 1.0 / (flows @ np.linalg.solve(energy, flows)) / (2 * np.pi * radius)


@pytest.mark.parametrize("ratio", [1e-3, 0.3, 1.0, 20.0])
def test_waves_in_layers_are_those_of_the_boundary_value_problem(ratio):
    pairs = ((2.0 * ratio, 0.7), (5.0, 0.3), (0.5 * ratio, 2.0))
    layers = stack(*pairs).layers
    q = np.geomspace(1e-4, 30.0, 40)
    own, rest = conduct(layers, 3.0, q)
    exact = np.array([solve_layers(pairs, 3.0, one) for one in q])
    np.testing.assert_allclose(own, exact, rtol=1e-12)
    np.testing.assert_allclose(rest, exact - 1 / pairs[0][0], atol=1e-13 * exact.max())


@pytest.mark.parametrize("k", [0.1, 3.0, 40.0])
@pytest.mark.parametrize("thickness", [0.1, 0.5, 2.0])
def test_an_isothermal_disc_on_a_layer(k, thickness):
    cells = 12
    pairs = ((k, thickness * cells),)
    found = ball(stack(*pairs), cells).conductance((2.0, 5.0))
    exact = resist(pairs, 2.0, 5.0, cells)
    assert found.value == pytest.approx(1 / exact, rel=3e-3)
    assert abs(found.value - 1 / exact) < 3 * found.uncertainty
    # The flow of a half-space needs a little more: at most a few per cent.
    assert exact * (1 - 3e-3) < found.constriction[0] < 1.08 * exact
