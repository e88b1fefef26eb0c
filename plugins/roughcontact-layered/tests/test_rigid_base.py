"""Layers on a rigid base: waves, cells, contacts of balls and rollers, and the stress in the layer."""

import attrs
import numpy as np
import pytest
import roughcontact as rc

from independent import (
    boundary_values,
    layer_on_rigid_base,
    series_by_rings,
    sphere_by_rings,
    stress_of_waves,
    von_mises_below_sphere,
)
from roughcontact_layered import Layer, LayeredKernel

BASE = rc.Rigid()
Q = np.geomspace(1e-4, 1e4, 17)
# Eight times as long as wide, and the other way round, with cells of 1 : 3; odd and composite numbers; Poisson's ratio.
GRIDS = (((96, 36), (4.0, 0.5), 0.3), ((36, 96), (0.5, 4.0), 0.5), ((35, 33), (3.5, 1.1), 0.5))


def pad(poisson=0.3, thickness=1.0, young=1e9):
    return LayeredKernel(Layer(young, poisson, thickness), substrate=BASE)


def material(kernel):
    return rc.Elastic(kernel.layers[0].young, kernel.layers[0].poisson)


def ball(kernel, grid, boundary="free", radius=1.0):
    body = rc.Body(rc.ParaboloidSurface(radius=radius), rc.Rigid())
    padded = rc.Body(rc.FlatSurface(), material(kernel))
    return rc.ContactProblem(body, padded, grid=grid, kernel=kernel, boundary=boundary)


@pytest.mark.parametrize("poisson", [-0.5, 0.0, 0.3, 0.49, 0.5])
def test_one_layer_is_the_closed_form_and_the_boundary_value_problem(poisson):
    kernel = pad(poisson, 0.7, 2.0)
    found = kernel.response(Q, kernel.layers[0].compliance) * Q
    exact = [layer_on_rigid_base(kernel.layers[0], q) for q in Q]
    problem = [float(boundary_values(kernel.layers, BASE, q)) for q in Q]
    np.testing.assert_allclose(problem, exact, rtol=1e-14)
    # Of the incompressible layer, long waves move the surface by (q h)^3, which is the difference of larger terms.
    np.testing.assert_allclose(found, exact, rtol=1e-12, atol=1e-16 * (Q * 0.7 * kernel.layers[0].compliance).max())


@pytest.mark.parametrize("ratio", [1e-3, 0.1, 10.0, 1e3])
@pytest.mark.parametrize("poisson", [0.25, 0.5])
def test_two_layers_solve_the_boundary_value_problem(ratio, poisson):
    layers = (Layer(ratio, poisson, 1.0), Layer(1.0, 0.4, 0.3))
    kernel = LayeredKernel(layers, substrate=BASE)
    exact = [float(boundary_values(layers, BASE, q)) for q in Q]
    np.testing.assert_allclose(kernel.response(Q, layers[0].compliance) * Q, exact, rtol=1e-11)


def test_uniform_pressure_compresses_each_layer_by_its_uniaxial_modulus():
    layers = (Layer(2.0, 0.3, 0.5), Layer(5.0, -0.2, 1.5))
    expected = sum(e.thickness * (1 + e.poisson) * (1 - 2 * e.poisson) / (e.young * (1 - e.poisson)) for e in layers)
    kernel = LayeredKernel(layers, substrate=BASE)
    assert kernel.uniform_compliance == pytest.approx(expected, rel=1e-15)
    assert kernel.response(np.array([1e-7]), layers[0].compliance).item() == pytest.approx(expected, rel=1e-9)
    assert LayeredKernel(layers, substrate=rc.Elastic(1.0, 0.3)).uniform_compliance == np.inf


def test_long_waves_squeeze_an_incompressible_layer_as_a_film():
    """Reynolds's film with walls that do not slip: u = q^2 h^3 p / (3 G)."""
    kernel = pad(0.5, 0.7, 3.0)
    q = np.array([1e-3])
    assert kernel.uniform_compliance == 0.0
    assert kernel.response(q, kernel.layers[0].compliance).item() == pytest.approx(
        (q * q).item() * 0.7**3 / 3.0, rel=1e-6
    )


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.49])
@pytest.mark.parametrize(("spacing", "n"), [((1.0, 1.0), 45), ((0.9, 0.3), 64), ((0.3, 0.9), 64)])
def test_all_coefficients_together_are_the_response_to_each_wave(poisson, spacing, n):
    """They fall exponentially, so that a sum over few cells is whole, uniform pressure included."""
    kernel = pad(poisson, 0.25, 1.0)
    compliance = kernel.layers[0].compliance
    index = np.minimum(np.arange(n), n - np.arange(n))
    coefficients = kernel.coefficients((n // 2 + 1, n // 2 + 1), spacing, compliance)
    transform = np.fft.fft2(coefficients[np.ix_(index, index)]).real
    qx, qy = (2 * np.pi * np.fft.fftfreq(n) / side for side in spacing)
    with np.errstate(invalid="ignore"):
        spectrum = kernel.spectrum(qx[:, None], qy[None, :], spacing, compliance)
    spectrum[0, 0] = kernel.uniform_compliance
    np.testing.assert_allclose(transform, spectrum, rtol=0, atol=1e-9 * spectrum.max())


@pytest.mark.parametrize("thickness", [1e-2, 0.2, 1.0, 5.0])
@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_cells_near_and_far_are_one_function(poisson, thickness):
    kernel = pad(poisson, thickness, 1.0)
    compliance = kernel.layers[0].compliance
    whole = kernel.coefficients((80, 70), (1.0, 1.2), compliance)
    fine = kernel.coefficients((242, 212), (1 / 3, 0.4), compliance)
    love = rc.Love().coefficients((80, 70), (1.0, 1.2), compliance)
    for i, j in ((0, 0), (1, 0), (3, 7), (10, 2), (11, 11), (60, 5), (79, 69)):
        rows, columns = (np.abs(np.arange(3 * k - 1, 3 * k + 2)) for k in (i, j))
        assert whole[i, j] == pytest.approx(fine[np.ix_(rows, columns)].sum(), abs=1e-11 * love[i, j])


def test_thick_layers_are_their_half_space():
    love = rc.Love().coefficients((64, 64), (1.0, 1.0), 1.0)
    errors = []
    for thickness in (1e5, 2e5):
        kernel = pad(0.3, thickness, 1.0)
        compliance = kernel.layers[0].compliance
        errors.append(np.abs(kernel.coefficients((64, 64), (1.0, 1.0), compliance) / (compliance * love) - 1).max())
    assert errors[0] == pytest.approx(2.0 * errors[1], rel=1e-2)
    assert errors[0] < 2e-3


@pytest.mark.parametrize("poisson", [0.3, 0.5])
@pytest.mark.parametrize("thickness", [0.1, 0.3, 3.0])
def test_load_approach_and_area_of_a_ball_are_those_of_the_axisymmetric_problem(poisson, thickness):
    contact = 0.01
    kernel = pad(poisson, thickness * contact)
    compliance = kernel.layers[0].compliance
    force, approach = sphere_by_rings(lambda q: kernel.response(q, compliance), 1 / compliance, 1.0, contact)
    solution = ball(kernel, rc.Grid((129, 129), 3.2 * contact)).solve(force=force)
    assert force > 4 / (3 * compliance) * contact**3
    assert solution.approach == pytest.approx(approach, rel=1e-4)
    area = solution.area()
    assert area.value == pytest.approx(np.pi * contact**2, rel=1e-3)
    assert abs(area.value - np.pi * contact**2) < 3 * area.uncertainty


def test_a_thin_compressible_layer_is_winklers_foundation():
    """A ball loads it by M / h times the penetration: pi M a^4 / (4 h R), and sinks by a^2 / (2 R)."""
    contact = 0.01
    errors = []
    for thickness in (0.1, 0.05):
        kernel = pad(0.3, thickness * contact)
        foundation = 1.0 / kernel.uniform_compliance
        solution = ball(kernel, rc.Grid((129, 129), 3.2 * contact)).solve(approach=contact**2 / 2)
        penetration = solution.approach - solution.initial_gap
        middle = penetration > 0.7 * solution.approach
        # Below a paraboloid the pressure is greater by a constant, of the order of the curvature times h.
        excess = solution.pressure[middle] / foundation - penetration[middle]
        assert np.ptp(excess) < 1e-3 * solution.approach
        errors.append(solution.force / (np.pi * foundation * contact**4 / 4) - 1.0)
    # 1 / (0.9522 * 4 * 0.5129^2) - 1 = -0.2 % by the axisymmetric series, at a tenth of the radius.
    assert errors[0] == pytest.approx(-2.0e-3, abs=3e-4)
    assert abs(errors[1]) < 0.6 * abs(errors[0])


def test_a_thin_incompressible_layer_is_a_film_in_balance():
    """Its pressure is 3 G (a^2 - r^2)^2 / (32 h^3 R), the approach a^2 / (4 R); both are approached as h falls."""
    contact = 0.01
    shear = 1e9 / 3.0
    found = []
    for thickness in (0.1, 0.05):
        kernel = pad(0.5, thickness * contact)
        compliance = kernel.layers[0].compliance
        force, _ = sphere_by_rings(lambda q, k=kernel, c=compliance: k.response(q, c), 1 / compliance, 1.0, contact)
        solution = ball(kernel, rc.Grid((97, 97), 2.5 * contact)).solve(force=force)
        film = np.pi * shear * contact**6 / (32 * (thickness * contact) ** 3)
        found.append((solution.approach / contact**2, (force / film) ** (1 / 6)))
    # The edge lies a multiple of the thickness beyond that of the film.
    (thick, wide), (thin, narrow) = found
    assert 2 * thin - thick == pytest.approx(0.25, rel=0.05)
    assert 2 * narrow - wide == pytest.approx(1.0, rel=0.05)
    assert abs(thin - 0.25) < 0.6 * abs(thick - 0.25)
    assert abs(narrow - 1.0) < 0.6 * abs(wide - 1.0)


@pytest.mark.parametrize("solver", ["auto", "spectral-gradient"])
def test_a_layer_that_bulges_touches_above_the_approach(solver):
    """Of a thin incompressible layer the contact ends where the initial gap is twice the approach."""
    contact = 0.01
    kernel = pad(0.5, 0.1 * contact)
    grid = rc.Grid((128, 108), (6 * contact, 5 * contact))
    body = rc.Body(rc.ParaboloidSurface(radius=1.0), rc.Rigid())
    problem = rc.ContactProblem(
        body, rc.Body(rc.FlatSurface(), material(kernel)), grid=grid, kernel=kernel, solver=solver
    )
    solution = problem.solve(approach=0.3 * contact**2)
    highest = solution.initial_gap[solution.contact].max()
    assert 1.3 * solution.approach < highest < 2.0 * solution.approach
    assert solution.residuals.penetration < 1e-4


@pytest.mark.parametrize(("shape", "size", "poisson"), GRIDS)
def test_free_and_periodic_pressures_agree_and_the_datum_differs_by_the_mean_compression(shape, size, poisson):
    kernel = pad(poisson, 0.015)
    grid = rc.Grid(shape, size)
    force = 1e4
    free = ball(kernel, grid, radius=50.0).solve(force=force, tolerance=1e-9)
    periodic = ball(kernel, grid, "periodic", radius=50.0).solve(force=force, tolerance=1e-9)
    np.testing.assert_allclose(periodic.pressure, free.pressure, rtol=0, atol=1e-6 * free.pressure.max())
    mean = periodic.mean_pressure * kernel.uniform_compliance
    assert periodic.approach + mean == pytest.approx(free.approach, rel=1e-6)
    given = ball(kernel, grid, radius=50.0).solve(approach=free.approach, tolerance=1e-9)
    assert given.force == pytest.approx(force, rel=1e-5)


@pytest.mark.parametrize(("shape", "size", "poisson"), [((24, 6), (1.0, 0.4), 0.5), ((5, 24), (0.4, 1.0), 0.3)])
def test_free_along_one_axis_is_a_long_periodic_domain(shape, size, poisson):
    kernel = pad(poisson, 0.1)
    axis = int(shape[1] > shape[0])
    boundary = ("free", "periodic") if axis == 0 else ("periodic", "free")
    pressure = np.random.default_rng(1).random(shape)
    mixed = ball(kernel, rc.Grid(shape, size), boundary).convolution.apply(pressure)
    longer = tuple(7 * n if k == axis else n for k, n in enumerate(shape))
    padded = np.zeros(longer)
    inside = tuple(slice(3 * n, 4 * n) if k == axis else slice(None) for k, n in enumerate(shape))
    padded[inside] = pressure
    sides = tuple(7 * side if k == axis else side for k, side in enumerate(size))
    problem = ball(kernel, rc.Grid(longer, sides), "periodic")
    unit = kernel.layers[0].compliance * problem.grid.spacing[0]
    expected = problem.convolution.apply(padded)[inside] + padded.mean() * kernel.uniform_compliance / unit
    np.testing.assert_allclose(mixed, expected, rtol=0, atol=3e-8 * np.abs(mixed).max())


def test_the_axes_can_be_exchanged_and_units_changed():
    pressures = []
    for order, metre, pascal in ((1, 1.0, 1.0), (-1, 1.0, 1.0), (1, 1e-6, 1e3)):
        layers = (Layer(1e9 * pascal, 0.4, 0.05 * metre), Layer(3e8 * pascal, 0.2, 0.04 * metre))
        kernel = LayeredKernel(layers, substrate=BASE)
        grid = rc.Grid((48, 18)[::order], (4.0 * metre, 0.5 * metre)[::order])
        solution = ball(kernel, grid, radius=20.0 * metre).solve(pressure=1e4 * pascal, tolerance=1e-9)
        pressures.append((solution.pressure if order == 1 else solution.pressure.T) / pascal)
    for other in pressures[1:]:
        np.testing.assert_allclose(other, pressures[0], rtol=0, atol=1e-7 * pressures[0].max())


@pytest.mark.parametrize(("axis", "shape"), [(0, (64, 6)), (1, (5, 64))])
def test_a_wave_of_pressure_has_the_stress_of_the_boundary_value_problem(axis, shape):
    size = (4.0, 3.0)
    layers = (Layer(3e9, 0.2, 0.5), Layer(0.5e9, 0.4, 0.4))
    kernel = LayeredKernel(layers, substrate=BASE)
    length = size[axis]
    amplitudes = (1e-4, 0.0) if axis == 0 else (0.0, 1e-4)
    body = rc.Body(
        rc.WavySurface(amplitudes, (length if axis == 0 else 1.5, length if axis else 2.0)), material(kernel)
    )
    problem = rc.ContactProblem(body, grid=rc.Grid(shape, size), kernel=kernel, boundary="periodic")
    solution = problem.solve(pressure=1e7)
    assert solution.contact.all()
    places = ((0.0, 0), (0.3, 0), (0.5, 0), (0.7, 1), (0.9, 1))
    found = solution.stress([depth for depth, _ in places]).components
    q = np.array([2 * np.pi / length])
    wave = np.exp(-2j * np.pi * np.arange(64) / 64)
    pressure = 2 * np.mean(np.moveaxis(solution.pressure, axis, 0)[:, 0] * wave)
    order = (0, 1, 2, 4) if axis == 0 else (1, 0, 2, 3)
    for place, (depth, number) in enumerate(places):
        exact = [one.item() for one in stress_of_waves(layers, BASE, q, depth, number)]
        for component, value in zip(order, exact, strict=True):
            amplitude = 2 * np.mean(np.moveaxis(found[place, component], axis, 0)[:, 0] * wave) / pressure
            part = -amplitude.imag if component == order[3] else amplitude.real
            assert part == pytest.approx(value, abs=2e-3)


@pytest.mark.parametrize(("thickness", "poisson"), [(0.5, 0.5), (1.0, 0.3)])
def test_the_maximum_stress_in_the_layer_is_the_integral_of_hankel(thickness, poisson):
    kernel = pad(poisson, thickness)
    compliance = kernel.layers[0].compliance
    series, _ = series_by_rings(lambda q: kernel.response(q, compliance), 1 / compliance, 20.0, 1.0)
    force = 2 * np.pi * sum(c / (2 * k + 1) for k, c in enumerate(series, 1))
    r = np.linspace(0.0, 1.3, 53)
    inside = np.linspace(0.1, 1.0, 10) * thickness
    exact = [von_mises_below_sphere(kernel, series, 1.0, depth, 0, r).max() for depth in inside]
    solution = ball(kernel, rc.Grid((40, 37), (10 / 3, 37 / 12)), radius=20.0).solve(force=force)
    stress = solution.stress(inside, body="counterbody")
    assert stress.profile == pytest.approx(np.array(exact), rel=3e-3)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_stress_reaches_the_base_and_no_further(boundary):
    kernel = pad(0.45, 0.3)
    solution = ball(kernel, rc.Grid((32, 24), (4.0, 3.0)), boundary, radius=20.0).solve(force=3e7)
    stress = solution.stress(body="counterbody", friction=0.2)
    assert stress.depths.max() == pytest.approx(0.3, rel=1e-12)
    assert 0.0 <= stress.maximum.depth <= 0.3
    surface = solution.stress([0.0], body="counterbody", friction=0.2).components[0] / solution.pressure.max()
    if boundary == "free":
        assert surface[2] == pytest.approx(-solution.pressure / solution.pressure.max(), abs=1e-6)
    with pytest.raises(rc.InputError, match="at most 300 mm, down to the rigid base"):
        solution.stress([0.1, 0.31], body="counterbody")


def test_a_cut_in_the_layer_changes_nothing():
    whole = pad(0.45, 0.5)
    cut = LayeredKernel((Layer(1e9, 0.45, 0.2), Layer(1e9, 0.45, 0.3)), substrate=BASE)
    fields = []
    for kernel in (whole, cut):
        solution = ball(kernel, rc.Grid((24, 30), (4.0, 3.0)), radius=20.0).solve(force=3e7)
        fields.append(solution.stress([0.0, 0.1, 0.35, 0.5], body="counterbody", friction=0.3).components)
    assert np.abs(fields[0] - fields[1]).max() < 1e-6 * solution.pressure.max()


def test_the_wrong_material_is_refused_in_words():
    kernel = LayeredKernel((Layer(2e9, 0.4, 0.2), Layer(1e9, 0.3, 0.2)), substrate=BASE)
    grid = rc.Grid((16, 16), 4.0)
    stiff = rc.Body(rc.ParaboloidSurface(20.0), rc.Elastic(210e9, 0.3))
    with pytest.raises(rc.InputError, match=r"The topmost layer .* alone is softer"):
        rc.ContactProblem(stiff, grid=grid, kernel=kernel).solve(force=1e6)
    soft = rc.Body(rc.ParaboloidSurface(20.0), rc.Elastic(1e9, 0.4))
    solution = rc.ContactProblem(soft, grid=grid, kernel=kernel).solve(force=1e6)
    with pytest.raises(rc.InputError, match="another material than that of the body or of the counterbody"):
        solution.stress()
    with pytest.raises(rc.InputError, match=r"or Rigid\(\) for a rigid base"):
        LayeredKernel(kernel.layers, substrate=kernel)


def test_a_body_with_a_pressure_limit_has_the_stress_of_its_layers():
    kernel = LayeredKernel(Layer(3e9, 0.2, 0.5), substrate=rc.Elastic(1e9, 0.3))
    fields = []
    for steel in (rc.Elastic(1e9, 0.3), rc.ElasticPerfectlyPlastic(1e9, 0.3, hardness=1e9)):
        body = rc.Body(rc.ParaboloidSurface(20.0), steel)
        problem = rc.ContactProblem(body, grid=rc.Grid((16, 16), 4.0), kernel=kernel)
        fields.append(problem.solve(force=3e7).stress([0.3, 0.7]).components)
    uncoated = attrs.evolve(problem, kernel="love").solve(force=3e7).stress([0.3, 0.7]).components
    np.testing.assert_allclose(fields[1], fields[0], rtol=0, atol=1e-4 * np.abs(fields[0]).max())
    assert np.abs(fields[0] - uncoated).max() > 0.1 * np.abs(uncoated).max()
