"""Domains that are free along one axis and periodic along the other: rollers, seals and lines."""

import itertools
import math

import mpmath as mp
import numpy as np
import pytest

import roughcontact as rc
from extended_precision import love_by_mpmath
from roughcontact.typing import BoundKernel, PairConstants

FREE_PERIODIC = rc.Boundary.FREE_PERIODIC
PERIODIC_FREE = rc.Boundary.PERIODIC_FREE
STEEL = rc.Elastic(210e9, 0.3)
MODULUS = 210e9 / (1 - 0.3**2)
RADIUS = 20e-3


def exchange(pair, boundary):
    """Return a pair whose first entry belongs to the free axis, in the order x, y."""
    return pair if boundary is FREE_PERIODIC else pair[::-1]


def press_roller(half_width, cells, boundary=FREE_PERIODIC, along=4, place=0.0, aspect=1.0, **parts):
    """Return the contact of a cylinder, its half width and its place in cells of 1 µm across."""
    size = (cells * 1e-6, along * aspect * 1e-6)
    body = rc.Body(
        rc.ParaboloidSurface(exchange((RADIUS, math.inf), boundary), exchange((place * 1e-6, 0.0), boundary)), STEEL
    )
    grid = rc.Grid(exchange((cells, along), boundary), exchange(size, boundary))
    load = line_load(half_width * 1e-6)
    return rc.ContactProblem(body, grid=grid, boundary=boundary, **parts).solve(force=load * size[1])


def line_load(half_width):
    """Return Hertz's load per length, N/m (Johnson 1985, eq. 4.43)."""
    return math.pi * half_width**2 * MODULUS / (4 * RADIUS)


# --- the kernel -------------------------------------------------------------------------------------------------------


def sum_images(i, j, sides, cells, datum):
    """Return a coefficient of E* = 1 with 60 digits: near images, the strip less those, and the rest extrapolated."""
    with mp.workdps(60):
        dx, dy = map(mp.mpf, sides)
        x, y, length = i * dx, j * dy, cells * dy
        low, high = x - dx / 2, x + dx / 2
        strip = -2 * sum(s * (end * mp.log(abs(end)) - end) for s, end in ((1, high), (-1, low))) + 2 * dx * mp.log(
            datum
        )
        rows = []
        first = 12 + int(2 * x / length)
        for last in range(first, first + 40, 4):
            reach = (last + mp.mpf(1) / 2) * length
            total = mp.fsum(love_by_mpmath(i, j + m * cells, dx, dy) for m in range(-last, last + 1))
            near = mp.quad(
                lambda s, reach=reach: love_by_mpmath(i, (y - s) / (2 * reach), dx, 2 * reach), [-dy / 2, dy / 2]
            )
            rows.append((1 / reach**2, total + (dy * strip - near) / length))
        return float(
            sum(value * mp.fprod(other / (other - size) for other, _ in rows if other != size) for size, value in rows)
            / mp.pi
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "sides"),
    [
        ((5, 9), (1.0, 3.0)),
        ((4, 1), (1.0, 2.0)),
        pytest.param((8, 6), (1.0, 1.0), marks=pytest.mark.slow),
        pytest.param((5, 4), (3.0, 1.0), marks=pytest.mark.slow),
        pytest.param((24, 3), (1.0, 1.0), marks=pytest.mark.slow),
    ],
)
def test_coefficients_are_sums_over_all_images(shape, sides):
    grid = rc.Grid(shape, (shape[0] * sides[0], shape[1] * sides[1]))
    found = BoundKernel(rc.Love()).responses(grid, FREE_PERIODIC)
    for i, j in ((0, 0), (1, 0), (shape[0] - 1, shape[1] // 2)):
        expected = sum_images(i, j, sides, shape[1], grid.size[0])
        assert found[i, j] == pytest.approx(expected, rel=1e-12)


def test_the_other_order_of_the_axes_is_the_transpose():
    kernel = BoundKernel(rc.Love(), pair=PairConstants(0.2, 0.4))
    one, other = rc.Grid((9, 6), (9e-6, 12e-6)), rc.Grid((6, 9), (12e-6, 9e-6))
    exchanged = {"xx": "yy", "yy": "xx", "xy": "xy", "zx": "zy", "zy": "zx"}
    np.testing.assert_array_equal(kernel.responses(one, FREE_PERIODIC), kernel.responses(other, PERIODIC_FREE).T)
    for component, partner in exchanged.items():
        np.testing.assert_array_equal(
            kernel.shear_responses(component, one, FREE_PERIODIC),
            kernel.shear_responses(partner, other, PERIODIC_FREE).T,
        )


def test_uniform_shear_is_that_of_plane_and_antiplane_strain():
    # Johnson (1985), sec. 2.3 and 2.4: along the free axis as pressure, along the other 1/(1 - nu) times as much; and a
    # tangential line moves the surfaces beside it by -(beta/E*) Q inwards, and outwards.
    pair = PairConstants(beta=0.2, gamma=0.4)
    kernel = BoundKernel(rc.Love(), pair=pair)
    grid = rc.Grid((16, 4), (16.0, 4.0))
    normal, xx, yy, xy, zx = (
        kernel.mixed_coefficients(grid, FREE_PERIODIC, component)[:, 0] for component in ("zz", "xx", "yy", "xy", "zx")
    )
    np.testing.assert_allclose(xx, normal, rtol=1e-12)
    np.testing.assert_allclose(yy, (1 + pair.gamma) * normal, rtol=1e-12)
    assert not xy.any()
    np.testing.assert_allclose(zx, np.where(np.arange(16) > 0, pair.beta, 0.0), rtol=1e-12)


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
@pytest.mark.parametrize("shape", [(40, 33), (33, 40), (1, 9), (9, 1)])
def test_parts_of_the_waves_are_those_of_the_whole(boundary, shape):
    kernel = BoundKernel(rc.Love())
    grid = rc.Grid(shape, (1.0, 2.0))
    along = 1 - boundary.free_axis
    whole = kernel.mixed_coefficients(grid, boundary)
    bounds = [whole.shape[along] * part // 3 for part in range(4)]
    parts = [kernel.mixed_coefficients(grid, boundary, part=slice(*ends)) for ends in itertools.pairwise(bounds)]
    np.testing.assert_allclose(np.concatenate(parts, axis=along), whole, rtol=0, atol=1e-14 * whole.max())


class Coated(rc.InfluenceKernel):
    """A layer on a stiffer base, its modulus E* (1 + exp(-2 q h)), whose far field is that of the base."""

    thickness = 2.0

    def spectrum(self, qx, qy, spacing, compliance):
        q = np.hypot(qx, qy)
        return rc.Love().spectrum(qx, qy, spacing, compliance) / (1.0 + np.exp(-2.0 * q * self.thickness))

    def coefficients(self, shape, spacing, compliance):
        raise NotImplementedError  # the boundary asks for both forms, and uses the spectrum


def test_uniform_pressure_on_a_layer_has_the_far_field_of_its_base():
    grid = rc.Grid((32, 4), (32.0, 4.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        layered = BoundKernel(Coated()).mixed_coefficients(grid, FREE_PERIODIC)[:, 0]
    love = BoundKernel(rc.Love()).mixed_coefficients(grid, FREE_PERIODIC)[:, 0]
    # The rest is the transform of Love's waves times 1/(1 + exp(-2 q h)) - 1/2, here on a far longer domain.
    count = 2**19
    q = 2 * np.pi * np.fft.rfftfreq(count)
    rest = np.zeros(q.size)
    rest[1:] = rc.Love().spectrum(q[1:, None], np.zeros((1, 1)), (1.0, 1.0), 1.0)[:, 0] * (
        1.0 / (1.0 + np.exp(-4.0 * q[1:])) - 0.5
    )
    rest[0] = 2.0 * Coated.thickness / 2.0
    expected = 0.5 * love + np.fft.irfft(rest, count)[:32]
    np.testing.assert_allclose(layered, expected, atol=1e-8 * love[0])


# --- Hertz's line -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
@pytest.mark.parametrize(("half_width", "allowed"), [(6.3, 5e-3), (16.8, 1e-3)])
@pytest.mark.parametrize(("place", "aspect", "along"), [(0.0, 1.0, 1), (0.37, 3.0, 4), (1.5, 1 / 3, 7)])
def test_hertz_line(boundary, half_width, allowed, place, aspect, along):
    cells = 3 * int(half_width) + 4
    solution = press_roller(half_width, cells, boundary, along, place, aspect)
    half, length, load = half_width * 1e-6, along * aspect * 1e-6, line_load(half_width * 1e-6)
    area, peak = solution.area(), solution.peak_pressure()
    assert area.value == pytest.approx(2 * half * length, rel=allowed)
    assert abs(area.value - 2 * half * length) <= 3 * area.uncertainty
    assert peak.value == pytest.approx(2 * load / (math.pi * half), rel=3e-3)
    assert solution.response("perimeter").value == pytest.approx(2 * length, rel=1e-12)
    approach = solution.response("approach")
    datum = cells * 1e-6
    exact = load / (math.pi * MODULUS) * (2 * math.log(2 * datum / half) + 1)
    assert approach.value == pytest.approx(exact, rel=3e-3)
    stiffness = math.pi * MODULUS / (2 * math.log(2 * datum / half)) * length
    found = solution.stiffness()
    assert found.value == pytest.approx(stiffness, rel=0.01)
    assert abs(found.value - stiffness) <= 3 * found.uncertainty


def press_line(length, along, boundary, kernel, wavy, transposed=False):
    """Return the contact of a cylinder or a wave, 41 cells on 0.4 mm, under 60 kN/m."""
    turn = -1 if transposed else 1
    grid = rc.Grid((41, along)[::turn], (4e-4, length)[::turn])
    x = grid.y if transposed else grid.x
    heights = -(x**2) / (2 * RADIUS)
    if wavy:
        heights = 1e-6 * np.cos(2 * np.pi * (x / 4e-4 - 0.1)) - 2e-7 * np.cos(4 * np.pi * x / 4e-4)
    body = rc.Body(rc.HeightMap(heights * np.ones(grid.shape), size=grid.size), STEEL)
    problem = rc.ContactProblem(body, grid=grid, boundary=boundary, kernel=kernel)
    return problem.solve(force=6e4 * length)


def find_line_answers(solution, length, axis):
    """Return the answers of a line, those that grow with its length over it, with their uncertainties."""
    leak = solution.leakage(axis=1 - axis, viscosity=1e-3, pressure_drop=1e5)
    extensive = {
        "area": solution.area(),
        "perimeter": solution.response("perimeter"),
        "stiffness": solution.stiffness(),
        "conductance": solution.conductance(50.0, 1e-6),
        **{
            f"tangential {name}": solution.response(rc.responses.create("tangential-stiffness", axis=number))
            for name, number in (("across", axis), ("along", 1 - axis))
        },
    }
    intensive = {
        "peak": solution.peak_pressure(),
        "approach": solution.response("approach"),
        "mean gap": solution.response("mean-gap"),
        "stress": solution.stress().maximum,
    }
    found = {name: (answer.value / length, answer.uncertainty / length) for name, answer in extensive.items()}
    found["leak"] = leak.value * length, leak.uncertainty * length
    return found | {name: (answer.value, answer.uncertainty) for name, answer in intensive.items()}


@pytest.mark.parametrize(
    ("boundary", "kernel"),
    [
        (FREE_PERIODIC, "love"),
        (rc.Boundary.PERIODIC, "fourier"),
        pytest.param(rc.Boundary.PERIODIC, "love", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("wavy", [False, True])
def test_answers_do_not_depend_on_the_length_of_a_line(boundary, kernel, wavy):
    turned = PERIODIC_FREE if boundary is FREE_PERIODIC else boundary
    square = press_line(4e-4 / 41, 1, boundary, kernel, wavy)
    expected = find_line_answers(square, 4e-4 / 41, 0)
    for length, transposed in ((1.0, True), (3e-6, False)):
        solution = press_line(length, 1, turned if transposed else boundary, kernel, wavy, transposed)
        assert len(solution.warnings) == len(square.warnings)
        for name, (value, uncertainty) in find_line_answers(solution, length, int(transposed)).items():
            assert value == pytest.approx(expected[name][0], rel=1e-3), name
            assert uncertainty == pytest.approx(expected[name][1], rel=0.05, abs=1e-5 * value), name


@pytest.mark.parametrize("length", [1.0, 1e-6])
def test_wave_of_one_cell_along_it_is_westergaards(length):
    exact = rc.reference.Westergaard(1e-6, 4e-4, MODULUS)
    grid = rc.Grid((1, 600), (length, 4e-4))
    heights = 1e-6 * np.cos(2 * np.pi * (grid.y / 4e-4 - 0.1037))
    body = rc.Body(rc.HeightMap(heights, size=grid.size), STEEL)
    solution = rc.ContactProblem(body, grid=grid, boundary="periodic").solve(pressure=2e8)
    ratio = 2e8 / exact.full_contact_pressure
    answers = {
        2 * exact.half_width(2e8) * length: solution.area(),
        2 * math.sqrt(2e8 * exact.full_contact_pressure): solution.peak_pressure(),
        # The integral of the displacement over the load (Johnson 1985, eq. 13.8).
        1e-6 * ratio * (1 - math.log(ratio)): solution.response("approach"),
        exact.full_contact_pressure / 1e-6 / -math.log(ratio) * grid.area: solution.stiffness(),
    }
    for value, found in answers.items():
        assert found.value == pytest.approx(value, rel=3e-3)
        assert abs(found.value - value) <= 3 * found.uncertainty + 1e-4 * value
        assert found.uncertainty <= 0.02 * value


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
def test_first_yield_of_a_line_of_one_cell(boundary):
    solution = press_roller(12.2, 60, boundary, along=1, aspect=1e6)
    found = solution.first_yield(4e7)
    # The von Mises stress in the middle plane, plane strain (Johnson 1985, eq. 4.49).
    s = np.linspace(0.3, 1.5, 4001)
    root = np.sqrt(1 + s**2)
    x, z = -((1 + 2 * s**2) / root - 2 * s), -1 / root
    y = 0.3 * (x + z)
    highest = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2)).max()
    pressure = 4e7 / highest
    exact = math.pi * pressure**2 * RADIUS / MODULUS * solution.grid.size[1 - boundary.free_axis]
    assert found.force.value == pytest.approx(exact, rel=5e-3)
    assert abs(found.force.value - exact) <= 3 * found.force.uncertainty
    assert found.force.uncertainty <= 0.02 * exact
    assert not found.warnings


def test_a_given_approach_finds_the_load():
    solver = rc.ProjectedConjugateGradient(tolerance=1e-8)
    by_load = press_roller(9.0, 40, solver=solver)
    body = rc.Body(rc.ParaboloidSurface((RADIUS, math.inf)), STEEL)
    problem = rc.ContactProblem(body, grid=by_load.grid, boundary=FREE_PERIODIC, solver=solver)
    assert problem.solve(approach=by_load.approach).force == pytest.approx(by_load.force, rel=1e-6)


def test_a_window_of_the_cells_that_touch_changes_nothing():
    # The solver works on the part between the borders; the displacement keeps its datum.
    narrow = press_roller(5.0, 24)
    wide = press_roller(5.0, 240)
    np.testing.assert_allclose(wide.pressure[108:132], narrow.pressure, atol=1e-4 * narrow.pressure.max())
    more = line_load(5e-6) / (math.pi * MODULUS) * 2 * math.log(10.0)
    assert wide.approach - narrow.approach == pytest.approx(more, rel=1e-5)


def test_crowned_roller():
    # An ellipse of 50 : 1, along a periodic axis long enough for its images not to act, and on a free domain.
    radii = (1.0, 600.0)
    exact = rc.reference.hertz_elliptic(force := 0.4, radii, 1.0)
    b, a = sorted(exact.semi_axes)
    assert 50 < a / b < 52
    grid = rc.Grid((24, 160), (4 * b, 4 * a))
    body = rc.Body(rc.ParaboloidSurface(radii), rc.Elastic(1.0, 0.0))
    for boundary in ("free", ("free", "periodic")):
        solution = rc.ContactProblem(body, grid=grid, boundary=boundary).solve(force=force)
        assert solution.area().value == pytest.approx(exact.area, rel=6e-3)
        # Images two lengths away raise the pressure by 0.1 %.
        assert solution.peak_pressure().value == pytest.approx(exact.p_max, rel=2e-3)


@pytest.mark.parametrize("lay", [(0.0, 4e-6), (4e-6, 0.0)])
def test_rough_roller_beside_far_periodic_images(lay):
    # Waves along and across a roller; images 16 lengths away change p by 1 % of their distance squared.
    cells, along = 64, 32
    size = (cells * 1e-6, along * 1e-6)
    x = (np.arange(cells) - (cells - 1) / 2)[:, None] * 1e-6
    y = (np.arange(along) - (along - 1) / 2)[None, :] * 1e-6
    heights = -(x**2) / (2 * RADIUS)
    for place, wavelength in zip((x, y), (8e-6, 8e-6), strict=True):
        if wavelength and lay[0 if place is x else 1]:
            heights = heights + 1e-9 * np.cos(2 * np.pi * place / wavelength + 0.4)
    heights = np.broadcast_to(heights, (cells, along)) + np.zeros((cells, along))
    load = line_load(10e-6) * size[1]
    near = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size), STEEL), boundary=("free", "periodic"))
    far_heights = np.full((16 * cells, along), heights.min() - 1e-6)
    far_heights[:cells] = heights
    far = rc.ContactProblem(rc.Body(rc.HeightMap(far_heights, (16 * size[0], size[1])), STEEL), boundary="periodic")
    one, other = near.solve(force=load), far.solve(force=load)
    np.testing.assert_allclose(other.pressure[:cells], one.pressure, atol=5e-3 * one.pressure.max())
    # The far domain has a step where the roller ends.
    areas = [solution.area(uncertainty="model").value for solution in (other, one)]
    assert areas[0] == pytest.approx(areas[1], rel=5e-3)


def test_lines_do_not_depend_on_how_many_cells_lie_along_them():
    one, other = press_roller(7.4, 30, along=1), press_roller(7.4, 30, along=6)
    np.testing.assert_allclose(np.repeat(one.pressure, 6, axis=1), other.pressure, rtol=1e-4, atol=1e-5 * MODULUS)
    assert one.approach == pytest.approx(other.approach, rel=1e-5)


def test_adhesion_of_a_roller():
    # Barquins, J. Adhesion 26 (1988) 1-12: P = pi E a^2 / (4 R) - sqrt(2 pi E a w), with its minimum at the pull-off.
    modulus, work, radius = 4e6 / 0.75, 0.05, 1e-2
    half = (2 * work * radius**2 / (math.pi * modulus)) ** (1 / 3)
    pull_off = math.pi * modulus * half**2 / (4 * radius) - math.sqrt(2 * math.pi * modulus * half * work)
    grid = rc.Grid((1024, 1), (8 * half, 1e-5))
    body = rc.Body(rc.ParaboloidSurface((radius, math.inf)), rc.Elastic(4e6, 0.5))
    problem = rc.ContactProblem(
        body, grid=grid, boundary=("free", "periodic"), adhesion=rc.Exponential(work, range=2e-7)
    )
    found = problem.solve(force=0.5 * pull_off * grid.size[1])
    a = np.linspace(half, 6 * half, 100_000)
    loads = math.pi * modulus * a**2 / (4 * radius) - np.sqrt(2 * math.pi * modulus * a * work)
    width = np.count_nonzero(found.contact) * grid.spacing[0]
    # The range of the law, a fifth of the gap beside the contact, makes it 1.7 % narrower; half of it 0.4 %.
    assert width == pytest.approx(2 * float(np.interp(0.5 * pull_off, loads, a)), rel=0.025)


# --- below the surface ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
def test_stress_below_a_line(boundary):
    # McEwen, Phil. Mag. 40 (1949) 454-459, as in Johnson (1985), eq. 4.49.
    half, cells = 25e-6, 128
    solution = press_roller(25.0, cells, boundary, along=8)
    peak = 2 * line_load(half) / (math.pi * half)
    x = exchange((solution.grid.x.ravel(), solution.grid.y.ravel()), boundary)[0]
    for depth in (0.5 * half, half, 3 * half):
        stress = solution.stress(depths=[depth]).components[0]
        if boundary is PERIODIC_FREE:
            stress = stress[[1, 0, 2, 4, 3, 5]].transpose(0, 2, 1)
        term = half**2 - x**2 + depth**2
        root = np.sqrt(term**2 + 4 * x**2 * depth**2)
        m, n = np.sqrt((root + term) / 2), np.sqrt((root - term) / 2) * np.sign(x)
        ratio = (depth**2 + n**2) / (m**2 + n**2)
        xx = -peak / half * (m * (1 + ratio) - 2 * depth)
        zz = -peak / half * m * (1 - ratio)
        xz = -peak / half * n * (m**2 - depth**2) / (m**2 + n**2)
        expected = np.array([xx, 0.3 * (xx + zz), zz, 0 * x, xz, 0 * x])
        np.testing.assert_allclose(stress, np.repeat(expected[:, :, None], 8, axis=2), atol=1e-3 * peak)


# --- the doors --------------------------------------------------------------------------------------------------------


def test_a_pair_names_a_boundary():
    body = rc.Body(rc.SphereSurface(1.0), STEEL)
    grid = rc.Grid((8, 8), 1e-3)
    for given, boundary in (
        (("free", "periodic"), FREE_PERIODIC),
        (["periodic", "free"], PERIODIC_FREE),
        ("free-periodic", FREE_PERIODIC),
        (("free", "free"), rc.Boundary.FREE),
        (PERIODIC_FREE, PERIODIC_FREE),
    ):
        assert rc.ContactProblem(body, grid=grid, boundary=given).boundary is boundary
    for wrong in (("wrapped", "free"), ("free",), ("free", 1), "free, periodic", None):
        with pytest.raises(rc.InputError, match=r"The boundary must be one of 'free', .*'periodic-free'"):
            rc.ContactProblem(body, grid=grid, boundary=wrong)


def test_a_kernel_without_coefficients_is_refused():
    body = rc.Body(rc.WavySurface(1e-9, 1e-4), STEEL)
    with pytest.raises(rc.InputError, match="no real-space coefficients"):
        rc.ContactProblem(body, grid=rc.Grid((8, 8), 1e-4), boundary=("free", "periodic"), kernel="fourier")


@pytest.mark.parametrize("radius", [(math.inf, math.inf), (-math.inf, 1.0), (math.nan, math.inf), math.inf])
def test_a_paraboloid_has_one_infinite_radius_at_most(radius):
    with pytest.raises(rc.InputError, match="The radius of curvature must be"):
        rc.ParaboloidSurface(radius)


def test_a_line_is_saved_and_read(tmp_path):
    solution = press_roller(6.0, 24)
    solution.save(tmp_path / "line.npz")
    read = rc.ContactSolution.load(tmp_path / "line.npz")
    assert read.boundary is FREE_PERIODIC
    np.testing.assert_array_equal(read.pressure, solution.pressure)
    assert str(read.area()) == str(solution.area())


def test_flow_along_a_line_and_across():
    solution = press_roller(6.0, 24)
    assert solution.leakage(axis=0, viscosity=1e-3, pressure_drop=1e5).value == 0.0
    along = solution.leakage(axis=1, viscosity=1e-3, pressure_drop=1e5)
    gap = solution.gap[:, 0]
    width = solution.grid.spacing[0]
    assert along.value == pytest.approx(np.sum(gap**3) * width * 1e5 / (12e-3 * solution.grid.size[1]), rel=1e-6)


# --- rollers that end ------------------------------------------------------------------------------------------------


def press_crowned(boundary, crown, rough=0.0, shape=(45, 97), place=0.0):
    """Return the contact of a roller of 10 mm with a crown, m, on 400 µm x 3 mm."""
    surface = rc.ParaboloidSurface(exchange((10e-3, crown), boundary), exchange((0.0, place), boundary))
    if rough:
        surface += rc.SelfAffineSurface(hurst=0.8, rms_height=rough, shortest=7e-5, longest=2e-4, seed=2)
    grid = rc.Grid(exchange(shape, boundary), exchange((400e-6, 3e-3), boundary))
    return rc.ContactProblem(rc.Body(surface, STEEL), grid=grid, boundary=boundary).solve(force=20.0)


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
def test_a_roller_that_ends_is_called_one_of_a_row(boundary):
    """Its approach is 15 to 37 % less than that of a single one, which ends before the border."""

    def row(**parts):
        return [text for text in press_crowned(boundary, **parts).warnings if "one of a row" in text]

    assert row(crown=1.0)
    assert row(crown=1.0, rough=5e-8, place=3e-4)
    assert not row(crown=math.inf)
    assert not row(crown=math.inf, rough=3e-7)
    # The contact goes on across the border.
    assert not row(crown=100.0)


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
@pytest.mark.parametrize("name", ["logarithmic", "rounded ends", "flat behind the ends"])
def test_a_profile_that_ends_is_called_one_of_a_row(name, boundary):
    """On cells 1:3, away from the middle; a straight one, jolted alike by a step within the contact, is not."""
    across, along = ((np.arange(count) + 0.5) / count - 0.5 for count in (40, 51))
    place = np.abs(along - 0.03)
    drop = {
        "logarithmic": -np.log(1.0 - np.minimum(place / 0.55, 0.999) ** 2),
        "rounded ends": np.maximum(place - 0.33, 0.0) ** 2 / 0.02,
        "flat behind the ends": np.where(place < 0.3, 0.0, 1.0),
    }[name]
    profiles = {"ends": drop, "straight": np.where(place < 0.3, 0.0, 1e-3)}
    found = {}
    for kind, profile in profiles.items():
        heights = -((400e-6 * across[:, None]) ** 2) / 20e-3 - 4e-6 * profile
        size = exchange((400e-6, 1.53e-3), boundary)
        surface = rc.HeightMap(heights if boundary is FREE_PERIODIC else heights.T, size=size, periodic=False)
        solution = rc.ContactProblem(rc.Body(surface, STEEL), boundary=boundary).solve(force=15.0)
        found[kind] = [text for text in solution.warnings if "one of a row" in text]
    assert found["ends"]
    assert not found["straight"]


@pytest.mark.parametrize(
    ("boundary", "along"),
    [
        (FREE_PERIODIC, 1),
        (PERIODIC_FREE, 3),
        pytest.param(FREE_PERIODIC, 3, marks=pytest.mark.slow),
        pytest.param(PERIODIC_FREE, 1, marks=pytest.mark.slow),
    ],
)
def test_the_largest_shear_below_a_line_is_as_uncertain_as_its_straight_edges(along, boundary):
    """Their cells err alike: by 0.3 to 0.1 % of 0.300 p_max (Johnson 1985, p. 102), several times as below a ball."""
    errors = []
    for half_width in (5.4, 6.3, 9.3):
        for place in (-0.4, 0.0, 0.3):
            solution = press_roller(half_width, 29, boundary, along=along, place=place)
            found = solution.stress().maximum_shear
            true = 0.30028 * 0.5 * MODULUS * half_width * 1e-6 / RADIUS
            errors.append(abs(found.value - true) / found.uncertainty)
            assert found.uncertainty < 0.004 * true
            assert found.warnings == ()
    assert np.mean(np.array(errors) < 2.0) > 0.85


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
def test_the_maximum_pressure_of_a_line_is_as_uncertain_as_its_edges_and_its_residual(boundary):
    """On many cells both count: by the bend of the pressure alone 81 % were within two standard deviations."""
    errors = []
    for half_width, cells, place in ((150.3, 613, -0.4), (231.7, 811, 0.2), (322.4, 1818, 0.45), (290.8, 701, 0.1)):
        found = press_roller(half_width, cells, boundary, along=1, place=place).peak_pressure()
        true = 0.5 * MODULUS * half_width * 1e-6 / RADIUS
        errors.append(abs(found.value - true) / found.uncertainty)
        assert found.uncertainty < 1e-3 * true
    assert max(errors) < 2.0


@pytest.mark.parametrize("boundary", [FREE_PERIODIC, PERIODIC_FREE])
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("name", ["one end", "tilted", "wave", "straight"])
def test_a_roller_with_one_end_is_called_one_of_a_row(boundary, mirrored, name):
    """It touches one side of the border, which was silent."""
    along = (np.arange(97) + 0.5) / 97
    fall = {
        "one end": 0.3e-6 * np.log(1.0 / (1.0 - 0.97 * np.clip(along / 0.6 - 2.0 / 3.0, 0.0, 1.0) ** 2)),
        "tilted": 1e-6 * along,
        "wave": 0.5e-6 * np.cos(2.0 * np.pi * along + 1.0),
        "straight": 0.0 * along,
    }[name]
    x = (np.arange(45) + 0.5) / 45 * 400e-6 - 200e-6
    heights = -((x[:, np.newaxis]) ** 2) / 20e-3 - (fall[::-1] if mirrored else fall)
    heights = heights if boundary == FREE_PERIODIC else heights.T
    body = rc.Body(rc.HeightMap(heights, size=exchange((400e-6, 3e-3), boundary)), STEEL)
    solution = rc.ContactProblem(body, boundary=boundary).solve(force=60.0)
    assert any("one of a row" in text for text in solution.warnings) == (name in ("one end", "tilted"))
