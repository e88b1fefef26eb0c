"""Contact on crystals: cells, symmetry, and Hertz's ellipse."""

import numpy as np
import pytest
import roughcontact as rc

from independent import hertz_ellipse
from roughcontact_layered import Anisotropic, AnisotropicKernel, TransverselyIsotropic

SILICON = Anisotropic.cubic(165.7e9, 63.9e9, 79.6e9, normal=(1, 1, 0), x_axis=(0, 0, 1))
COPPER = Anisotropic.cubic(168.3e9, 122.1e9, 75.7e9, normal=(1, 1, 0), x_axis=(0, 0, 1))
FIBRES = Anisotropic(TransverselyIsotropic(15e9, 7e9, 6e9, 235e9, 15e9).stiffness, normal=(1, 0, 0), x_axis=(0, 0, 1))
GRAPHITE = Anisotropic(
    TransverselyIsotropic(1060e9, 180e9, 15e9, 36.5e9, 4.5e9).stiffness, normal=(1, 0, 0), x_axis=(0, 0, 1)
)
CRYSTALS = {"silicon": SILICON, "copper": COPPER, "fibres": FIBRES, "graphite": GRAPHITE}
RADIUS = 1e-3


def across(crystal):
    """Return the crystal turned by 90 degrees about the normal."""
    return Anisotropic(crystal.stiffness, crystal.normal, np.cross(crystal.normal, crystal.x_axis))


def indented(crystal, shape, size, surface=None, boundary="free"):
    wafer = rc.Body(surface or rc.ParaboloidSurface(radius=RADIUS), crystal)
    return rc.ContactProblem(wafer, grid=rc.Grid(shape, size), boundary=boundary, kernel=AnisotropicKernel(crystal))


@pytest.mark.parametrize("crystal", CRYSTALS.values(), ids=CRYSTALS)
@pytest.mark.parametrize("spacing", [(1.0, 1.2), (1.0, 0.4)])
def test_cells_near_and_far_are_one_function(crystal, spacing):
    """Cells made of finer cells: the sum of their coefficients at one point is that of the whole."""
    kernel = AnisotropicKernel(crystal)
    whole = kernel.coefficients((80, 70), spacing, crystal.compliance)
    fine = kernel.coefficients((242, 212), (spacing[0] / 3, spacing[1] / 3), crystal.compliance)
    bound = 2e-9 if crystal is GRAPHITE else 1e-11
    for i, j in ((0, 0), (1, 0), (3, 7), (10, 2), (2, 10), (11, 11), (20, 3), (60, 5), (79, 69)):
        rows, columns = (np.abs(np.arange(3 * k - 1, 3 * k + 2)) for k in (i, j))
        assert whole[i, j] == pytest.approx(fine[np.ix_(rows, columns)].sum(), rel=bound)


@pytest.mark.parametrize("crystal", CRYSTALS.values(), ids=CRYSTALS)
def test_the_spectrum_is_the_sum_over_all_aliases(crystal):
    kernel = AnisotropicKernel(crystal)
    spacing = 1.0, 1.3
    theta = np.array([0.1, 1.3, 3.1])
    found = kernel.spectrum((theta / spacing[0])[:, None], (theta / spacing[1])[None, :], spacing, crystal.compliance)
    # A plain sum with a smooth end, for it alternates.
    orders = np.arange(-200, 201)
    end = np.where(np.abs(orders) < 100, 1.0, np.cos(0.5 * np.pi * (np.abs(orders) - 100) / 101) ** 2)
    phases = theta[:, None] + 2 * np.pi * orders
    factors = end * np.sinc(phases / (2 * np.pi))
    for i in range(3):
        for j in range(3):
            qx, qy = phases[i][:, None] / spacing[0], phases[j][None, :] / spacing[1]
            response = 2 / (np.hypot(qx, qy) * kernel.directional_modulus(np.arctan2(qy, qx), crystal.compliance))
            assert found[i, j] == pytest.approx(factors[i] @ response @ factors[j], rel=1e-9)


@pytest.mark.parametrize("crystal", CRYSTALS.values(), ids=CRYSTALS)
@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_a_crystal_turned_by_90_degrees_is_the_transpose(crystal, boundary):
    surface = rc.WavySurface(1e-8, (2e-6, 3e-6))
    other = rc.WavySurface(1e-8, (3e-6, 2e-6))
    one = indented(crystal, (20, 24), (4e-6, 6e-6), surface, boundary).solve(pressure=1e8)
    turned = indented(across(crystal), (24, 20), (6e-6, 4e-6), other, boundary).solve(pressure=1e8)
    np.testing.assert_allclose(turned.pressure.T, one.pressure, atol=1e-4 * one.pressure.max())
    assert turned.area().value == pytest.approx(one.area().value, rel=1e-4)


def test_lengths_and_moduli_scale():
    kernel = AnisotropicKernel(FIBRES)
    softer = AnisotropicKernel(Anisotropic(0.5 * np.array(FIBRES.stiffness), FIBRES.normal, FIBRES.x_axis))
    one = kernel.coefficients((9, 7), (1.0, 2.0), FIBRES.compliance)
    np.testing.assert_allclose(softer.coefficients((9, 7), (3.0, 6.0), 2 * FIBRES.compliance), 6 * one, rtol=1e-12)


def test_free_is_the_direct_sum():
    pressure = np.random.default_rng(1).random((18, 14))
    wafer, grid = rc.Body(rc.ParaboloidSurface(radius=RADIUS), COPPER), rc.Grid((18, 14), (1.8e-5, 1.4e-5))
    kernel = AnisotropicKernel(COPPER)
    one, other = (
        rc.ContactProblem(wafer, grid=grid, kernel=kernel, convolver=name).convolution.apply(pressure)
        for name in ("dc-fft", "direct")
    )
    np.testing.assert_allclose(one, other, rtol=1e-13)


@pytest.mark.parametrize("name", CRYSTALS)
@pytest.mark.parametrize("radii", [(1.0, 1.0), (1.0, 3.0)])
def test_a_paraboloid_has_the_ellipse_of_the_closed_form(name, radii):
    """Area and maximum pressure, with their uncertainties, on n and on 4 n cells a side."""
    crystal, force = CRYSTALS[name], 1.0
    radii = RADIUS * radii[0], RADIUS * radii[1]
    kernel = AnisotropicKernel(crystal)
    axes, approach, peak = hertz_ellipse(
        lambda angle: kernel.directional_modulus(angle, crystal.compliance), radii, force
    )
    exact = np.pi * axes[0] * axes[1]
    surface = rc.ParaboloidSurface(radius=radii)
    errors = []
    for cells in (24, 96):
        sides = 3.0 * axes[0], 3.0 * axes[1]
        solution = indented(crystal, (cells, cells), sides, surface).solve(force=force)
        for estimator in ("blend", "hertz", "level-set"):
            area = solution.area(estimator)
            assert abs(area.value - exact) < 3.0 * area.uncertainty + 1e-5 * exact
            assert abs(area.value - exact) < (5e-4 if estimator != "level-set" else 0.02) * exact
        found = solution.peak_pressure()
        assert abs(found.value - peak) < 3.0 * found.uncertainty + 3e-5 * peak
        errors.append(abs(solution.approach / approach - 1.0))
    assert errors[0] < 0.02
    # Second order in the length of a cell.
    assert errors[1] < errors[0] / 10.0


@pytest.mark.parametrize("crystal", CRYSTALS.values(), ids=CRYSTALS)
@pytest.mark.parametrize("axis", [0, 1])
def test_waves_along_an_axis_are_westergaards_with_the_modulus_of_that_direction(crystal, axis):
    modulus = 1.0 / crystal.directions.at(np.array([0.5 * np.pi * axis])).item()
    heights, length = 1e-8, 1e-6
    surface = rc.WavySurface((heights, 0.0) if axis == 0 else (0.0, heights), length)
    full = np.pi * modulus * heights / length
    solution = indented(crystal, (32, 32), (length, length), surface, "periodic").solve(pressure=0.3 * full)
    exact = 2.0 / np.pi * np.arcsin(np.sqrt(0.3))
    area = solution.area("level-set")
    assert area.fraction == pytest.approx(exact, rel=0.01)
    assert abs(area.fraction - exact) < 2.0 * area.uncertainty / solution.grid.area
    assert solution.peak_pressure().value == pytest.approx(2.0 * full * np.sqrt(0.3), rel=2e-3)


def test_a_transversely_isotropic_body_needs_no_kernel_of_its_own():
    wood = TransverselyIsotropic(1.8e9, 0.9e9, 1.0e9, 12e9, 0.8e9)
    grid = rc.Grid((32, 32), 2e-4)
    surface = rc.ParaboloidSurface(radius=RADIUS)
    default = rc.ContactProblem(rc.Body(surface, wood), grid=grid).solve(force=0.1)
    general = indented(Anisotropic(wood.stiffness), grid.shape, grid.size).solve(force=0.1)
    np.testing.assert_allclose(general.pressure, default.pressure, atol=1e-9 * default.pressure.max())
    assert default.warnings == general.warnings == ()


def test_two_crystals_are_twice_as_compliant():
    one = AnisotropicKernel(SILICON).coefficients((5, 4), (1.0, 1.0), SILICON.compliance)
    both = AnisotropicKernel((SILICON, SILICON)).coefficients((5, 4), (1.0, 1.0), 2 * SILICON.compliance)
    np.testing.assert_allclose(both, 2 * one, rtol=1e-14)


def test_an_isotropic_body_on_a_crystal_adds_its_own_compliance():
    steel = rc.Elastic(210e9, 0.3)
    both = AnisotropicKernel(SILICON).coefficients((5, 4), (1.0, 1.0), SILICON.compliance + steel.compliance)
    own = AnisotropicKernel(SILICON).coefficients((5, 4), (1.0, 1.0), SILICON.compliance)
    np.testing.assert_allclose(both - own, rc.Love().coefficients((5, 4), (1.0, 1.0), steel.compliance), rtol=1e-12)


def test_a_body_stiffer_than_the_crystal_is_refused():
    kernel = AnisotropicKernel(FIBRES)
    body = rc.Body(rc.ParaboloidSurface(radius=RADIUS), rc.Elastic(210e9, 0.3))
    with pytest.raises(rc.InputError, match="The crystal alone is softer"):
        rc.ContactProblem(body, grid=rc.Grid((16, 16), 1e-5), kernel=kernel).solve(force=1.0)


def test_a_kernel_that_does_not_know_the_directions_warns():
    body = rc.Body(rc.ParaboloidSurface(radius=RADIUS), FIBRES)
    grid = rc.Grid((32, 32), 1e-4)
    warned = rc.ContactProblem(body, grid=grid).solve(force=1.0).warnings
    assert any(warning.rule == "isotropy" for warning in warned)
    known = rc.ContactProblem(body, grid=grid, kernel=AnisotropicKernel(FIBRES)).solve(force=1.0).warnings
    assert not any(warning.rule == "isotropy" for warning in known)


def test_answers_that_need_isotropic_bodies_are_refused():
    solution = indented(FIBRES, (32, 32), (1e-4, 1e-4)).solve(force=1.0)
    for ask in (
        lambda: solution.stress(),
        lambda: solution.conductance(conductivity=(1.0, 1.0)),
        lambda: solution.partial_slip(tangential_force=0.01, friction=0.2),
        lambda: solution.response("tangential-stiffness"),
    ):
        with pytest.raises(rc.InputError):
            ask()


@pytest.mark.parametrize("crystal", [COPPER, FIBRES], ids=["copper", "fibres"])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_areas_on_rough_surfaces_hold_on_a_finer_grid(crystal, boundary):
    """As on isotropic bodies, where errors over their standard deviations have an rms of 1.1."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=6e-6, longest=5e-5, seed=21)
    coarse, fine = (
        indented(crystal, (cells, cells), (1e-4, 1e-4), surface, boundary).solve(pressure=0.01 / crystal.compliance)
        for cells in (96, 288)
    )
    one, other = coarse.area(), fine.area()
    assert abs(one.value - other.value) < 3.0 * np.hypot(one.uncertainty, other.uncertainty)
    assert one.uncertainty < 0.02 * other.value
    assert fine.iterations <= 15


def test_it_is_kept_in_files(tmp_path):
    solution = indented(COPPER, (32, 32), (1e-5, 1e-5)).solve(force=1e-3)
    solution.save(tmp_path / "copper.npz")
    again = rc.ContactSolution.load(tmp_path / "copper.npz")
    assert again.directional_moduli == solution.directional_moduli
    assert again.area().value == solution.area().value
    assert again.origin.problem["kernel"] == AnisotropicKernel(COPPER)
