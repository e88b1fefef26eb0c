import mpmath as mp
import numpy as np
import pytest
import roughcontact as rc

from independent import boundary_values, one_layer
from roughcontact_layered import Layer, LayeredKernel

Q = np.geomspace(1e-6, 1e6, 20)
RATIOS = (1e-4, 0.1, 1.0, 10.0, 1e4)
STEEL = rc.Elastic(1.0, 0.3)


def response(layers, substrate=STEEL):
    return LayeredKernel(layers, substrate=substrate).response(Q, substrate.compliance) * Q


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("poisson", [(0.3, 0.3), (0.5, 0.2), (0.0, 0.5), (-0.5, 0.5), (0.5, 0.5)])
def test_one_layer_solves_the_boundary_value_problem(ratio, poisson):
    layer, substrate = Layer(ratio, poisson[0], 1.0), rc.Elastic(1.0, poisson[1])
    exact = [float(boundary_values((layer,), substrate, q)) for q in Q]
    np.testing.assert_allclose(response((layer,), substrate), exact, rtol=1e-13)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("second", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("poisson", [0.25, 0.5])
def test_two_layers_solve_the_boundary_value_problem(ratio, second, poisson):
    layers = (Layer(ratio, poisson, 1.0), Layer(second, 0.4, 0.3))
    exact = [float(boundary_values(layers, STEEL, q)) for q in Q]
    np.testing.assert_allclose(response(layers), exact, rtol=2e-12)


@pytest.mark.parametrize("ratio", RATIOS)
def test_one_layer_is_the_closed_form(ratio):
    layer = Layer(ratio, 0.4, 1.0)
    # The closed form itself cancels for long waves under a stiff layer.
    np.testing.assert_allclose(response((layer,)), one_layer(layer, STEEL, Q), rtol=1e-12 * max(1.0, ratio))


def test_thick_layers_hide_and_thin_ones_vanish_linearly():
    layer = Layer(4.0, 0.2, 1.0)
    kernel = LayeredKernel(layer, substrate=STEEL)
    short = np.array([10.0, 12.0])
    beyond = kernel.rest(short) * short
    # The rest falls as x^2 exp(-2 x).
    assert np.log(beyond[0] / beyond[1]) / 4.0 == pytest.approx(1.0, abs=0.15)
    lost = kernel.response(np.array([1e-4, 2e-4]), STEEL.compliance) * np.array([1e-4, 2e-4]) - 2 * STEEL.compliance
    assert lost[1] / lost[0] == pytest.approx(2.0, rel=2e-3)


def test_a_layer_cut_in_two_and_equal_layers_change_nothing():
    whole = response((Layer(7.0, 0.5, 1.0),))
    np.testing.assert_allclose(response((Layer(7.0, 0.5, 0.3), Layer(7.0, 0.5, 0.7))), whole, rtol=1e-14)
    same = response((Layer(1.0, 0.3, 1.0), Layer(1.0, 0.3, 2.0)))
    np.testing.assert_allclose(same, 2 * STEEL.compliance, rtol=1e-15)


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_response_is_positive_and_hardly_exceeds_that_of_the_softest(ratio):
    values = response((Layer(ratio, 0.3, 1.0), Layer(1.0, 0.5, 0.1)))
    assert values.min() > 0.0
    assert values.max() <= 2.0 * max(STEEL.compliance, 0.91 / ratio) * 1.01


def test_the_closed_form_with_many_digits_is_the_boundary_value_problem():
    with mp.workdps(30):
        value = boundary_values((Layer(2.0, 0.3, 1.0),), STEEL, 0.7)
    assert float(value) == pytest.approx(one_layer(Layer(2.0, 0.3, 1.0), STEEL, 0.7), rel=1e-14)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Layer(0.0, 0.3, 1.0), "Young"),
        (lambda: Layer(1.0, 0.6, 1.0), "Poisson"),
        (lambda: Layer(1.0, 0.3, 0.0), "thickness"),
        (lambda: Layer(1.0, 0.3, "thin"), "thickness"),
        (lambda: LayeredKernel((), substrate=STEEL), "one Layer or more"),
        (lambda: LayeredKernel((STEEL,), substrate=STEEL), "one Layer or more"),
        (lambda: LayeredKernel(Layer(1.0, 0.3, 1.0), substrate=1.0), "substrate"),
        (lambda: rc.kernels.create("layered"), "without arguments"),
    ],
)
def test_bad_input_is_refused_in_words(make, words):
    with pytest.raises(rc.InputError, match=words):
        make()


def test_a_substrate_softer_than_both_bodies_is_refused():
    body = rc.Body(rc.ParaboloidSurface(radius=1.0), rc.Elastic(2.0, 0.3))
    kernel = LayeredKernel(Layer(1.0, 0.3, 1.0), substrate=STEEL)
    problem = rc.ContactProblem(body, grid=rc.Grid((16, 16), (1.0, 1.0)), kernel=kernel)
    with pytest.raises(rc.InputError, match="softer"):
        problem.solve(force=1e-3)
