"""Conductance of contacts on layers beside Hankel's integrals, limits and sums over cells."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
from scipy import special

from roughcontact_layered import GradedKernel, Layer, LayeredKernel
from roughcontact_layered.conduction import conduct

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
    q = np.atleast_1d(q)
    count = len(pairs)
    matrix = np.zeros((q.size, 2 * count + 1, 2 * count + 1))
    right = np.zeros((q.size, 2 * count + 1, 1))
    # Flow over q at the surface, and temperature and flow at each interface.
    right[:, 0] = 1.0
    decays = [np.exp(-q * h) for _, h in pairs]
    matrix[:, 0, 0] = pairs[0][0]
    matrix[:, 0, 1] = -pairs[0][0] * decays[0]
    for n, ((k, _), decay) in enumerate(zip(pairs, decays, strict=True)):
        below = substrate if n + 1 == count else pairs[n + 1][0]
        row = 2 * n + 1
        for column, value, slope in ((0, decay, decay), (1, 1.0, -1.0)):
            matrix[:, row, 2 * n + column] = value
            matrix[:, row + 1, 2 * n + column] = k * slope
        matrix[:, row, 2 * n + 2] = -1.0
        matrix[:, row + 1, 2 * n + 2] = -below
        if n + 1 < count:
            matrix[:, row, 2 * n + 3] = -decays[n + 1]
            matrix[:, row + 1, 2 * n + 3] = below * decays[n + 1]
    found = np.linalg.solve(matrix, right)[..., 0]
    return found[:, 0] + found[:, 1] * decays[0]


def resist(pairs, substrate, other, radius):
    """Return the resistance of an isothermal disc by Ritz's method, flows (1 - r^2)^(k - 1/2), k = 0 .. 11."""
    edges = np.concatenate(([0.0], np.geomspace(1e-4, 1.0, 30), np.arange(1.0, 500.0) * 1.5))
    at, w = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    s = (edges[:-1, None] + half * (at + 1)).ravel()
    w = (half * w).ravel()
    top = 1 / pairs[0][0]
    rest = solve_layers(pairs, substrate, s / radius) - top
    orders = np.arange(12)
    transforms = np.array(
        [2.0 ** (k - 0.5) * special.gamma(k + 0.5) * special.jv(k + 0.5, s) / s ** (k + 0.5) for k in orders]
    )
    energy = (transforms * (w * rest)) @ transforms.T
    # Of a half-space: the product of both transforms integrated (Weber and Schafheitlin).
    for i in orders:
        for j in orders:
            a, b = i + 0.5, j + 0.5
            lam = a + b
            integral = (
                special.gamma(lam)
                * special.gamma(0.5)
                / (
                    2.0**lam
                    * special.gamma((-a + b + lam + 1) / 2)
                    * special.gamma((a + b + lam + 1) / 2)
                    * special.gamma((a - b + lam + 1) / 2)
                )
            )
            factor = 2.0 ** (i + j - 1) * special.gamma(a) * special.gamma(b)
            energy[i, j] += (top + 1 / other) * factor * integral
    flows = np.array([1.0 / (2 * k + 1) for k in orders])
    return 1.0 / (flows @ np.linalg.solve(energy, flows)) / (2 * np.pi * radius)


@pytest.mark.parametrize("ratio", [1e-3, 0.3, 1.0, 20.0])
def test_waves_in_layers_are_those_of_the_boundary_value_problem(ratio):
    pairs = ((2.0 * ratio, 0.7), (5.0, 0.3), (0.5 * ratio, 2.0))
    q = np.geomspace(1e-4, 30.0, 40)
    own, rest = conduct([k for k, _ in pairs], 3.0, [h for _, h in pairs], q)
    exact = solve_layers(pairs, 3.0, q)
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
    # That of a disc of the same area, by two flows, which is a little more.
    area = np.sqrt(ball(stack(*pairs), cells).area().value / np.pi)
    assert found.constriction[0] == pytest.approx(resist(pairs, 2.0, 5.0, area), rel=2e-3)
    assert found.constriction[0] > resist(pairs, 2.0, 5.0, area) * (1 - 1e-6)
    assert abs(found.interaction) < 5e-3 * exact


@pytest.mark.parametrize(("shape", "size", "film"), [((64, 8), (64.0, 24.0), 0.0), ((8, 33), (24.0, 33.0), 3.0)])
@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic"), ("periodic", "free")])
def test_layers_of_the_same_conductivity_change_nothing(boundary, shape, size, film):
    found = []
    for kernel in (stack((2.0, 3.0), (2.0, 1.0)), "love"):
        solution = ball(kernel, 5, boundary, shape, size)
        # The area of layers, which has no images, is not the matter here.
        found.append(attrs.evolve(solution, moduli=None).conductance((2.0, 5.0), film))
    one, two = found
    assert one.value == pytest.approx(two.value, rel=1e-10)
    assert one.uncertainty == pytest.approx(two.uncertainty, rel=1e-9)
    np.testing.assert_allclose(one.constriction, two.constriction, rtol=1e-12)


@pytest.mark.parametrize("k", [0.05, 30.0])
def test_a_thick_layer_is_all_and_a_thin_one_is_nothing(k):
    thick, layer = (
        ball(kernel, 8).conductance(values).value
        for kernel, values in ((stack((k, 1e6)), (2.0, 5.0)), ("love", (k, 5.0)))
    )
    assert thick == pytest.approx(layer, rel=1e-5)
    thin, substrate = (ball(kernel, 8).conductance((2.0, 5.0)).value for kernel in (stack((k, 1e-6)), "love"))
    assert thin == pytest.approx(substrate, rel=1e-4)


@pytest.mark.parametrize("boundary", ["free", "periodic", ("free", "periodic")])
def test_the_axes_can_be_exchanged(boundary):
    kernel = stack((0.3, 2.0), (10.0, 1.0))
    x, y = np.mgrid[:28, :12]
    heights = np.sin(x / 4.0) * np.cos(y / 2.0) + 0.3 * np.cos(x / 7.0 + y)
    found = []
    for turned in (False, True):
        grid = rc.Grid((12, 28), (36.0, 28.0)) if turned else rc.Grid((28, 12), (28.0, 36.0))
        body = rc.Body(rc.HeightMap(heights.T if turned else heights, grid.size), STEEL)
        sides = boundary[::-1] if turned and isinstance(boundary, tuple) else boundary
        problem = rc.ContactProblem(body, FLAT, grid=grid, kernel=kernel, boundary=sides)
        found.append(problem.solve(pressure=5e6).conductance((2.0, 5.0), 0.5))
    assert found[0].value == pytest.approx(found[1].value, rel=1e-5)
    assert found[0].uncertainty == pytest.approx(found[1].uncertainty, rel=1e-4)
    assert found[0].patches.size > 2


def test_units_cancel():
    values = []
    for length, unit in ((1.0, 1.0), (2.0**-20, 2.0**8)):
        layer = Layer(STEEL.young, STEEL.poisson, 2.0 * length, 0.5 * unit)
        body = rc.Body(rc.ParaboloidSurface(100.0 * length), STEEL)
        grid = rc.Grid((24, 20), (24.0 * length, 20.0 * length))
        problem = rc.ContactProblem(body, FLAT, grid=grid, kernel=LayeredKernel(layer, substrate=STEEL))
        solution = problem.solve(force=1e9 * length**2)
        found = solution.conductance((2.0 * unit, 5.0 * unit), 3.0 * length / unit)
        values.append([found.value / (length * unit), found.uncertainty / (length * unit)])
    np.testing.assert_allclose(values[1], values[0], rtol=1e-9)


def test_the_layers_lie_on_the_body_of_the_substrate():
    other = rc.Elastic(2e9, 0.2)
    kernel = stack((0.3, 3.0))
    coated, bare = rc.Body(rc.ParaboloidSurface(1000.0), STEEL), rc.Body(rc.FlatSurface(), other)
    values = []
    for bodies, conductivity in (((coated, bare), (2.0, 5.0)), ((bare, coated), (5.0, 2.0))):
        problem = rc.ContactProblem(*bodies, grid=rc.Grid((24, 24), 24.0), kernel=kernel)
        solution = problem.solve(force=5e8)
        values.append(solution.conductance(conductivity).value)
    assert values[0] == pytest.approx(values[1], rel=1e-6)
    swapped = solution.conductance((2.0, 5.0)).value
    assert swapped != pytest.approx(values[1], rel=0.02)
    # A hardness makes no other body of the substrate.
    hard = rc.Body(rc.ParaboloidSurface(1000.0), rc.ElasticPerfectlyPlastic(STEEL.young, STEEL.poisson, 1e12))
    problem = rc.ContactProblem(hard, bare, grid=rc.Grid((24, 24), 24.0), kernel=kernel)
    limited = problem.solve(force=5e8)
    assert limited.conductance((2.0, 5.0)).value == pytest.approx(values[0], rel=1e-6)
    soft = LayeredKernel(Layer(3e9, 0.3, 3.0), substrate=STEEL)
    stresses = [
        rc.ContactProblem(one, bare, grid=rc.Grid((24, 24), 24.0), kernel=soft)
        .solve(force=5e8)
        .stress([1.0])
        .components
        for one in (coated, hard)
    ]
    np.testing.assert_allclose(stresses[1], stresses[0], atol=1e-4 * np.abs(stresses[0]).max())


def test_an_elastic_layer_conducts_too_and_is_kept_in_files(tmp_path):
    """A film that conducts badly lowers the conductance of a contact that a stiff layer makes smaller."""
    layer = Layer(5e9, 0.2, 2.0, conductivity=0.1)
    solution = ball(LayeredKernel(layer, substrate=STEEL), 10)
    radius = np.sqrt(solution.area().value / np.pi)
    found = solution.conductance((2.0, 5.0))
    assert found.value == pytest.approx(1 / resist(((0.1, 2.0),), 2.0, 5.0, radius), rel=4e-3)
    solution.save(tmp_path / "layer.npz")
    again = rc.ContactSolution.load(tmp_path / "layer.npz")
    assert again.conductance((2.0, 5.0)).value == pytest.approx(found.value, rel=1e-12)


def test_full_contact_and_empty_contact():
    kernel = stack((0.3, 3.0))
    body = rc.Body(rc.WavySurface(1e-3, 16.0), STEEL)
    problem = rc.ContactProblem(body, FLAT, grid=rc.Grid((16, 12), 16.0), kernel=kernel, boundary="periodic")
    full = problem.solve(pressure=1e9)
    assert full.conductance(2.0).value == np.inf
    assert full.conductance(2.0, film_resistance=4.0).value == pytest.approx(64.0, rel=1e-5)
    empty = attrs.evolve(full, pressure=0.0 * full.pressure).conductance(2.0)
    assert empty.value == empty.constriction.size == 0


def test_many_patches_have_the_constriction_of_their_areas():
    kernel = stack((0.3, 1.5))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=16.0, seed=3)
    problem = rc.ContactProblem(rc.Body(surface, STEEL), FLAT, grid=rc.Grid((128, 128), 128.0), kernel=kernel)
    solution = problem.solve(pressure=2e6)
    found = solution.conductance((2.0, 5.0))
    assert found.patches.size > 200
    radii = np.sqrt(solution.area().patches / np.pi)
    for n in np.argsort(radii)[[100, 180, -1]]:
        assert found.constriction[n] == pytest.approx(resist(((0.3, 1.5),), 2.0, 5.0, radii[n]), rel=2e-3)


@pytest.mark.parametrize("conductivity", [0.0, -1.0, np.nan, np.inf, "copper", True, (1.0, 2.0)])
def test_a_bad_conductivity_is_refused(conductivity):
    with pytest.raises(rc.InputError, match="conductivity of a layer"):
        Layer(1e9, 0.3, 1.0, conductivity)


def test_what_is_not_known_is_refused_in_words():
    unknown = LayeredKernel((Layer(1e9, 0.3, 1.0, 2.0), Layer(2e9, 0.3, 1.0)), substrate=STEEL)
    with pytest.raises(rc.InputError, match=r"conductivity of each layer, but Layer\(young=2000000000.0"):
        ball(unknown, 4).conductance(2.0)
    with pytest.raises(rc.InputError, match="graded body"):
        ball(GradedKernel(0.1, surface=STEEL), 4).conductance(2.0)
    other = rc.Body(rc.ParaboloidSurface(1000.0), rc.Elastic(2e9, 0.2))
    neither = LayeredKernel(Layer(1e9, 0.3, 1.0, 2.0), substrate=rc.Elastic(3e9, 0.3))
    problem = rc.ContactProblem(other, FLAT, grid=rc.Grid((16, 16), 16.0), kernel=neither)
    with pytest.raises(rc.InputError, match="which body carries the layers"):
        problem.solve(force=1e8).conductance(2.0)
    wrapped = ball(stack((1.0, 1.0)), 4, "wrapped")
    with pytest.raises(rc.InputError, match="wrapped"):
        wrapped.conductance(2.0)
