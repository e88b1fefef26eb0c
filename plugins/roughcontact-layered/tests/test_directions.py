"""The response of crystals by direction, against closed forms, the eigenvalue problem, and each other."""

import numpy as np
import pytest
import roughcontact as rc
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from independent import stroh_compliance
from roughcontact_layered import Anisotropic, AnisotropicKernel, TransverselyIsotropic
from roughcontact_layered.directions import respond_to_directions

SILICON = 165.7e9, 63.9e9, 79.6e9
COPPER = 168.3e9, 122.1e9, 75.7e9
SURFACES = [((0, 0, 1), (1, 0, 0)), ((1, 1, 0), (0, 0, 1)), ((1, 1, 1), (1, -1, 0))]
ANGLES = np.linspace(0.0, np.pi, 13)


def isotropic(young, poisson):
    lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = young / (2.0 * (1.0 + poisson))
    return lame + 2.0 * shear, lame, shear


def along_fibres(material):
    """Return the surface along the axis of a transversely isotropic body, with the axis along x."""
    return Anisotropic(material.stiffness, normal=(1, 0, 0), x_axis=(0, 0, 1))


WOOD = TransverselyIsotropic(c11=1.8e9, c12=0.9e9, c13=1.0e9, c33=12e9, c44=0.8e9)
GRAPHITE = TransverselyIsotropic(c11=1060e9, c12=180e9, c13=15e9, c33=36.5e9, c44=4.5e9)


@pytest.mark.parametrize("poisson", [-0.5, 0.0, 0.3, 0.49])
def test_an_isotropic_body_is_that_of_hertz_in_any_orientation(poisson):
    steel = rc.Elastic(210e9, poisson)
    for normal, x_axis in [*SURFACES, ((1, 2, 3), (3, 0, -1))]:
        crystal = Anisotropic.cubic(*isotropic(210e9, poisson), normal=normal, x_axis=x_axis)
        assert crystal.compliance == pytest.approx(steel.compliance, rel=1e-13)
        np.testing.assert_allclose(crystal.directions.at(ANGLES), steel.compliance, rtol=1e-13)
        kernel = AnisotropicKernel(crystal)
        found = kernel.coefficients((12, 15), (1e-6, 2e-6), steel.compliance)
        np.testing.assert_allclose(found, rc.Love().coefficients((12, 15), (1e-6, 2e-6), steel.compliance), rtol=1e-13)


@pytest.mark.parametrize("constants", [SILICON, COPPER])
@pytest.mark.parametrize("surface", SURFACES)
def test_cubic_crystals_are_strohs_eigenvalue_problem(constants, surface):
    crystal = Anisotropic.cubic(*constants, normal=surface[0], x_axis=surface[1])
    expected = [stroh_compliance(crystal.stiffness, *surface, angle) for angle in ANGLES]
    np.testing.assert_allclose(crystal.directions.at(ANGLES), expected, rtol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_stiffness_is_strohs_eigenvalue_problem(seed):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((6, 6))
    normal, x_axis = Rotation.random(rng=rng).as_matrix()[:2]
    crystal = Anisotropic(1e9 * (root @ root.T + np.eye(6)), normal, x_axis)
    expected = [stroh_compliance(crystal.stiffness, normal, x_axis, angle) for angle in ANGLES]
    np.testing.assert_allclose(crystal.directions.at(ANGLES), expected, rtol=1e-9)
    # Waves q and -q have the same response.
    np.testing.assert_allclose(crystal.directions.at(ANGLES + np.pi), crystal.directions.at(ANGLES), rtol=1e-12)


@pytest.mark.parametrize("material", [WOOD, GRAPHITE])
def test_an_axis_along_the_normal_gives_the_closed_form(material):
    np.testing.assert_allclose(Anisotropic(material.stiffness).directions.at(ANGLES), material.compliance, rtol=1e-12)


@pytest.mark.parametrize("material", [WOOD, GRAPHITE])
def test_waves_along_and_across_fibres_have_closed_forms(material):
    """Delafargue and Ulm (2004), eqs. 12 and 13."""
    along, across = along_fibres(material).directions.at(np.array([0.0, 0.5 * np.pi]))
    mean = np.sqrt(material.c11 * material.c33)
    soft = 1.0 / material.c44 + 2.0 / (mean + material.c13)
    assert along == pytest.approx(0.5 * np.sqrt(material.c33 / (mean**2 - material.c13**2) * soft), rel=1e-10)
    assert across == pytest.approx(material.c11 / (material.c11**2 - material.c12**2), rel=1e-10)


def test_the_moduli_of_silicon_are_ordered_as_its_youngs_moduli():
    moduli = [1e-9 / Anisotropic.cubic(*SILICON, normal=n, x_axis=x).compliance for n, x in SURFACES]
    assert moduli == pytest.approx([164.814, 172.812, 175.303], abs=1e-3)


def test_symmetric_surfaces_have_the_symmetry_of_the_crystal():
    square, _, triangle = (Anisotropic.cubic(*COPPER, normal=n, x_axis=x).directions for n, x in SURFACES)
    np.testing.assert_allclose(square.at(ANGLES + 0.5 * np.pi), square.at(ANGLES), rtol=1e-12)
    np.testing.assert_allclose(triangle.at(ANGLES + np.pi / 3.0), triangle.at(ANGLES), rtol=1e-12)


def test_a_turned_crystal_has_turned_directions():
    one = along_fibres(WOOD).directions
    other = Anisotropic(WOOD.stiffness, normal=(1, 0, 0), x_axis=(0, 1, 1)).directions
    np.testing.assert_allclose(other.at(ANGLES + 0.25 * np.pi), one.at(ANGLES), rtol=1e-11)


def test_the_rule_converges_for_the_most_anisotropic_crystals():
    assert along_fibres(GRAPHITE).directions.even.size < 512
    extreme = along_fibres(TransverselyIsotropic(1e15, 1e14, 1.0, 1e9, 1e6))
    with pytest.raises(rc.InputError, match="differs too much"):
        AnisotropicKernel(extreme)


def test_units_scale():
    stiffness = np.array(WOOD.stiffness)
    one, other = (along_fibres(WOOD).directions, Anisotropic(1e3 * stiffness, (1, 0, 0), (0, 0, 1)).directions)
    np.testing.assert_allclose(1e3 * other.at(ANGLES), one.at(ANGLES), rtol=1e-13)


def test_the_function_takes_a_tensor():
    delta = np.eye(3)
    _, c12, c44 = isotropic(1.0, 0.25)
    tensor = c12 * np.einsum("ij,kl", delta, delta) + c44 * (
        np.einsum("ik,jl->ijkl", delta, delta) + np.einsum("il,jk->ijkl", delta, delta)
    )
    np.testing.assert_allclose(respond_to_directions(tensor, ANGLES), 1.0 - 0.25**2, rtol=1e-14)


def lopsided():
    return Anisotropic.cubic(*SILICON, normal=(1, 1, 0), x_axis=(1, -1, 1))


def test_a_response_that_is_not_even_is_refused_with_the_angle_that_helps():
    with pytest.raises(rc.InputError, match=r"35\.26 degrees"):
        AnisotropicKernel(lopsided())
    angle = lopsided().directions.turn_to_even
    normal, x = np.array([1, 1, 0]) / np.sqrt(2), np.array([1, -1, 1]) / np.sqrt(3)
    turned = np.cos(angle) * x + np.sin(angle) * np.cross(normal, x)
    AnisotropicKernel(Anisotropic.cubic(*SILICON, normal=normal, x_axis=turned))
    with pytest.raises(rc.InputError, match="no plane of symmetry"):
        AnisotropicKernel(Anisotropic.cubic(*SILICON, normal=(1, 2, 3), x_axis=(3, 0, -1)))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Anisotropic(np.eye(5)), "6 rows of 6"),
        (lambda: Anisotropic("silicon"), "6 rows of 6"),
        (lambda: Anisotropic([[1.0], [2.0, 3.0]]), "6 rows of 6"),
        (lambda: Anisotropic(np.full((6, 6), np.nan)), "finite"),
        (lambda: Anisotropic(np.eye(6) + np.eye(6, k=1)), "not symmetric"),
        (lambda: Anisotropic(np.ones((6, 6))), "not positive definite"),
        (lambda: Anisotropic.cubic(100e9, 120e9, 50e9), "not positive definite"),
        (lambda: Anisotropic(np.eye(6), normal=(0, 0, 0)), "normal"),
        (lambda: Anisotropic(np.eye(6), x_axis=(0, 0, 1)), "does not lie in the surface"),
        (lambda: Anisotropic(np.eye(6), x_axis="x"), "three numbers"),
        (lambda: Anisotropic.cubic(-1.0, 0.0, 1.0), "above 0"),
        (lambda: Anisotropic.cubic(1.0, "stiff", 1.0), "c12"),
        (lambda: TransverselyIsotropic(1.0, 2.0, 0.0, 1.0, 1.0), "not positive definite"),
        (lambda: AnisotropicKernel(rc.Elastic(1.0, 0.3)), "one Anisotropic material"),
        (lambda: AnisotropicKernel(()), "one Anisotropic material"),
        (lambda: rc.kernels.create("anisotropic"), "without arguments"),
    ],
)
def test_bad_input_is_refused_in_words(make, words):
    with pytest.raises(rc.InputError, match=words):
        make()


@pytest.mark.parametrize(
    ("along", "across", "shear", "poisson", "parallel", "perpendicular"),
    [
        (55, 10, 3, 0.25, 23.5, 10.12),
        (30, 10, 3, 0.25, 17.12, 10.01),
        (80, 10, 3, 0.25, 28.63, 10.12),
        (55, 5, 3, 0.25, 22.5, 5.97),
        (55, 15, 3, 0.25, 24.03, 13.83),
        (55, 10, 1, 0.25, 14.52, 7.99),
        (55, 10, 5, 0.25, 28.7, 11.26),
        (55, 10, 3, 0.5, 23.84, 10.6),
    ],
)
def test_wood_has_the_published_indentation_moduli(along, across, shear, poisson, parallel, perpendicular):
    """Jäger et al. (2011), Fig. 4, read from its curves: https://doi.org/10.1016/j.compositesa.2011.02.007 (GPa)."""
    compliance = np.diag([1 / across, 1 / across, 1 / along, 1 / shear, 1 / shear, 2 * (1 + poisson) / across])
    compliance[0, 1] = compliance[1, 0] = -poisson / across
    compliance[:2, 2] = compliance[2, :2] = -0.25 / along
    c = np.linalg.inv(compliance)
    wall = TransverselyIsotropic(c[0, 0], c[0, 1], c[0, 2], c[2, 2], c[3, 3])
    assert 1.0 / wall.compliance == pytest.approx(parallel, rel=0.01)
    assert 1.0 / along_fibres(wall).compliance == pytest.approx(perpendicular, rel=0.015)
