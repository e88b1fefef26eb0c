"""Layers on both bodies: their displacements add, and each body has its own stress."""

import attrs
import numpy as np
import pytest
import roughcontact as rc

from roughcontact_layered import Anisotropic, AnisotropicKernel, GradedKernel, Layer, LayeredKernel, PairKernel

STEEL = rc.Elastic(1e9, 0.3)
RUBBER = rc.Elastic(2e8, 0.45)
C = STEEL.compliance
COATING = LayeredKernel((Layer(3e9, 0.2, 0.3), Layer(0.5e9, 0.4, 0.2)), substrate=STEEL)
PAD = LayeredKernel(Layer(RUBBER.young, RUBBER.poisson, 0.4), substrate=rc.Rigid())
BALL = rc.ParaboloidSurface(20.0)
FLAT = rc.FlatSurface()


def solve(body, counterbody, kernel, boundary="free", force=3e7):
    grid = rc.Grid((24, 30), (4.0, 3.0))
    problem = rc.ContactProblem(body, counterbody, grid=grid, kernel=kernel, boundary=boundary)
    return problem.solve(force=force, tolerance=1e-9)


@pytest.mark.parametrize("kernel", [COATING, PAD, GradedKernel(2.0, surface=STEEL)])
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (0.3, 0.9)])
def test_two_equal_bodies_have_twice_the_compliance(kernel, spacing):
    own = kernel.own_material.compliance
    pair = PairKernel(body=kernel, counterbody=kernel)
    qx, qy = (np.linspace(0.1, np.pi, 7) / side for side in spacing)
    waves = qx[:, None], qy[None, :]
    for one, two in (
        (kernel.coefficients((20, 15), spacing, own), pair.coefficients((20, 15), spacing, 2 * own)),
        (kernel.spectrum(*waves, spacing, own), pair.spectrum(*waves, spacing, 2 * own)),
        (1.0 / kernel.effective_modulus(qx, own), 1.0 / pair.effective_modulus(qx, 2 * own)),
    ):
        np.testing.assert_allclose(two, 2.0 * one, rtol=1e-12)


def test_layers_of_the_same_material_are_half_spaces():
    parts = [LayeredKernel(Layer(one.young, one.poisson, 0.7), substrate=one) for one in (STEEL, RUBBER)]
    compliance = C + RUBBER.compliance
    found = PairKernel(*parts).coefficients((20, 15), (1.0, 1.3), compliance)
    np.testing.assert_allclose(found, rc.Love().coefficients((20, 15), (1.0, 1.3), compliance), rtol=1e-12)


def test_a_pair_without_layers_on_one_body_is_the_kernel_of_the_other():
    plain = LayeredKernel(Layer(RUBBER.young, RUBBER.poisson, 0.7), substrate=RUBBER)
    compliance = C + RUBBER.compliance
    pair = PairKernel(body=COATING, counterbody=plain).coefficients((20, 15), (1.0, 1.3), compliance)
    np.testing.assert_allclose(COATING.coefficients((20, 15), (1.0, 1.3), compliance), pair, rtol=1e-12)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_bodies_can_be_exchanged(boundary):
    grid = rc.Grid((12, 10), (4.0, 3.0))
    problems = [
        rc.ContactProblem(*bodies, grid=grid, boundary=boundary, kernel=PairKernel(*kernels))
        for bodies, kernels in (
            ((rc.Body(BALL, STEEL), rc.Body(FLAT, RUBBER)), (COATING, PAD)),
            ((rc.Body(BALL, RUBBER), rc.Body(FLAT, STEEL)), (PAD, COATING)),
        )
    ]
    one, other = (problem.solve(force=3e7, tolerance=1e-9) for problem in problems)
    np.testing.assert_allclose(other.pressure, one.pressure, rtol=0, atol=1e-12 * one.pressure.max())
    assert other.approach == pytest.approx(one.approach, rel=1e-12)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_each_body_has_the_stress_below_its_own_layers(boundary):
    both = solve(rc.Body(BALL, STEEL), rc.Body(FLAT, RUBBER), PairKernel(body=COATING, counterbody=PAD), boundary)
    depths = [0.0, 0.2, 0.3]
    fields = {}
    for name, kernel, material in (("body", COATING, STEEL), ("counterbody", PAD, RUBBER)):
        fields[name] = both.stress(depths, body=name, friction=0.3).components
        # The same pressure on this body alone, against a rigid one.
        alone = rc.ContactProblem(rc.Body(BALL, material), grid=both.grid, kernel=kernel, boundary=boundary)
        traction = np.stack((0.3 * both.pressure, 0.0 * both.pressure))
        pressed = attrs.evolve(alone.solve(force=3e7), pressure=both.pressure)
        sign = 1.0 if name == "body" else -1.0
        found = pressed.stress(depths, traction=sign * traction).components
        np.testing.assert_allclose(fields[name], found, rtol=0, atol=1e-9 * both.pressure.max())
    assert np.abs(fields["body"] - fields["counterbody"]).max() > 0.1 * both.pressure.max()


def test_two_bodies_of_one_material_keep_their_layers_apart():
    other = LayeredKernel(Layer(0.2e9, 0.4, 0.3), substrate=STEEL)
    solution = solve(rc.Body(BALL, STEEL), rc.Body(FLAT, STEEL), PairKernel(body=COATING, counterbody=other))
    exchanged = solve(rc.Body(BALL, STEEL), rc.Body(FLAT, STEEL), PairKernel(body=other, counterbody=COATING))
    for name, opposite in (("body", "counterbody"), ("counterbody", "body")):
        one = solution.stress([0.25], body=name).components
        np.testing.assert_allclose(
            exchanged.stress([0.25], body=opposite).components, one, rtol=0, atol=1e-9 * solution.pressure.max()
        )
    apart = solution.stress([0.25]).components - solution.stress([0.25], body="counterbody").components
    assert np.abs(apart).max() > 0.05 * solution.pressure.max()


def test_what_is_not_known_is_refused_in_words():
    pair = PairKernel(body=COATING, counterbody=PAD)
    ball, flat = rc.Body(BALL, STEEL), rc.Body(FLAT, RUBBER)
    with pytest.raises(rc.InputError, match="give each kernel the material of its body"):
        solve(ball, rc.RIGID_FLAT, pair)
    with pytest.raises(rc.InputError, match="give each kernel the material of its body"):
        solve(ball, rc.Body(FLAT, rc.Elastic(1e7, 0.45)), pair)
    with pytest.raises(rc.InputError, match="another material than that of the body: give both the same one"):
        solve(rc.Body(BALL, RUBBER), rc.Body(FLAT, STEEL), pair).stress([0.1])
    graded = PairKernel(body=COATING, counterbody=GradedKernel(0.5, surface=RUBBER))
    solution = solve(ball, flat, graded)
    assert solution.stress([0.1]).maximum.value > 0.0
    with pytest.raises(rc.InputError, match="but this kernel is of a layer"):
        solution.stress([0.1], body="counterbody")
    silicon = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=(1, 1, 1), x_axis=(1, -1, 0))
    for wrong in (AnisotropicKernel(silicon), pair, STEEL, "layered"):
        with pytest.raises(rc.InputError, match="The kernel of one of two bodies must be a LayeredKernel or"):
            PairKernel(body=COATING, counterbody=wrong)


def test_a_file_keeps_both_kernels(tmp_path):
    pair = PairKernel(body=COATING, counterbody=PAD)
    solution = solve(rc.Body(BALL, STEEL), rc.Body(FLAT, RUBBER), pair)
    solution.save(tmp_path / "pair.npz")
    again = rc.ContactSolution.load(tmp_path / "pair.npz")
    assert again.origin.problem["kernel"] == pair
    assert again.area().value == solution.area().value
