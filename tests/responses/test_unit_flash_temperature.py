"""Flash temperature beside closed forms, symmetries and balances."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact._answers.flow.conduction import Conduction, sum_periodic_waves, sum_sources
from roughcontact.responses import FlashTemperature, SlidingHeat
from scenes import make_problem

# Maximum and mean of k T / (q l) over the Peclet number V l / 2D, l half the side or the radius; the maximum under
# Hertz's pressure.
PECLET = [0.0, 0.1, 1.0, 5.0, 10.0, 100.0]
SQUARE = [(1.1222, 0.9465), (1.0648, 0.8875), (0.7968, 0.5948), (0.4726, 0.3103), (0.3472, 0.2247), (0.1122, 0.0738)]
CIRCLE = [(1.0, 0.8485), (0.9544, 0.8017), (0.7324, 0.5551), (0.4527, 0.2940), (0.3383, 0.2126), (0.1119, 0.0686)]
HERTZ = {0.0: 0.25 * math.pi, 1.0: 0.5846, 10.0: 0.2627, 100.0: 0.0869}
# One body alone takes the heat, with a flux of one on a unit length.
ALONE = {"conductivity": (0.0, 1.0), "diffusivity": 1.0}


def heat(flow, spacing, peclet, angle=0.0, boundary=rc.Boundary.FREE):
    """Return the temperature by a flow, k = D = 1, V = 2 Pe."""
    grid = rc.Grid(flow.shape, (flow.shape[0] * spacing[0], flow.shape[1] * spacing[1]))
    conduction = Conduction(grid, boundary)
    velocity = 2.0 * peclet * math.cos(angle), 2.0 * peclet * math.sin(angle)
    return conduction.apply(conduction.find_waves(1.0, 1.0, velocity), flow)


def disc(cells, samples=8):
    """Return how much of each cell a unit disc covers."""
    n = 2 * cells + 2
    at = (np.arange(n * samples) + 0.5) / samples - 0.5 * n
    inside = at[:, np.newaxis] ** 2 + at**2 < cells**2
    return inside.reshape(n, samples, n, samples).mean(axis=(1, 3))


def ball(cells, shift=(0.0, 0.0), size=None, **options):
    """Return a ball on a flat, on a contact of radius one of some cells."""
    n = 2 * math.ceil(1.2 * cells) + 2 if size is None else size
    surface = rc.ParaboloidSurface(1000.0, center=tuple(one / cells for one in shift))
    grid = rc.Grid((n, n), n / cells)
    return make_problem(surface, rc.Elastic(1.0, 0.0), grid=grid, threads=1, **options).solve(force=4e-3 / 3.0)


def rough(shape=(48, 40), sides=(1.0, 1.0), boundary="periodic", seed=3, pressure=5e-3, unit=1.0, **options):
    """Return a rough contact."""
    heights = np.random.default_rng(seed).standard_normal(shape)
    waves = np.fft.rfft2(heights)
    waves *= np.hypot(np.fft.fftfreq(shape[0])[:, None] / sides[0], np.fft.rfftfreq(shape[1])[None] / sides[1]) < 0.12
    heights = 0.1 * np.fft.irfft2(waves, shape)
    size = (shape[0] * sides[0] * unit, shape[1] * sides[1] * unit)
    body = rc.Body(rc.HeightMap(unit * heights, size), rc.Elastic(1.0, 0.3))
    return rc.ContactProblem(body, boundary=boundary, threads=1, **options).solve(pressure=pressure)


def ask(solution, speed=3.0, **changes):
    arguments = {"conductivity": (2.0, 3.0), "diffusivity": (1.0, 0.5), "direction": 0.0, **changes}
    return solution.flash_temperature(0.3, speed, **arguments)


class TestSources:
    @pytest.mark.parametrize(("peclet", "known"), list(zip(PECLET, SQUARE, strict=True)))
    def test_a_square(self, peclet, known):
        fine = 33
        found = heat(np.ones((fine, fine)), (2.0 / fine, 2.0 / fine), peclet)
        # At a Peclet number the hottest place is at the end of the square.
        assert found.max() == pytest.approx(known[0], rel=2e-3 if peclet <= 10.0 else 0.02)
        assert found.mean() == pytest.approx(known[1], rel=2e-3)
        if peclet == 0.0:
            assert found[16, 16] == pytest.approx(4.0 / math.pi * math.asinh(1.0), rel=1e-6)

    @pytest.mark.parametrize(("peclet", "known"), list(zip(PECLET, CIRCLE, strict=True)))
    def test_a_circle(self, peclet, known):
        flow = disc(32)
        found = heat(flow, (1.0 / 32.0, 1.0 / 32.0), peclet)
        assert found.max() == pytest.approx(known[0], rel=4e-3)
        assert (found * flow).sum() / flow.sum() == pytest.approx(known[1], rel=2e-3)
        if peclet == 0.0:
            assert known == pytest.approx((1.0, 8.0 / (3.0 * math.pi)), abs=5e-4)
        # The fit of Tian and Kennedy (1994), https://doi.org/10.1115/1.2927035, is within 3 %.
        assert found.max() == pytest.approx(2.0 / math.sqrt(math.pi * (1.273 + peclet)), rel=0.03)

    def test_a_fast_source_heats_each_line_by_itself(self):
        found = heat(np.ones((64, 9)), (2.0 / 64.0, 2.0 / 9.0), 1e4)
        # One-dimensional conduction over the time since the cell entered.
        entered = (np.arange(64) + 0.5) / 32.0
        exact = np.sqrt(4.0 * entered / math.pi / 2e4)
        np.testing.assert_allclose(found[:, 4], exact, rtol=1e-3)
        np.testing.assert_allclose(found[4:, 4], exact[4:], rtol=1e-4)
        assert found[-1, 4] == pytest.approx(2.0 / math.sqrt(math.pi) * 1e-2, rel=5e-3)

    def test_a_cell_at_rest_is_loves(self):
        found = sum_sources((40, 24), (1.0, 1.6), (0.0, 0.0))
        x, y = np.arange(-39.0, 40.0)[:, None], 1.6 * np.arange(-23.0, 24.0)
        right, left, above, below = x + 0.5, x - 0.5, y + 0.8, y - 0.8

        def part(along, across):
            return along * np.arcsinh(across / np.abs(along)) + across * np.arcsinh(along / np.abs(across))

        exact = part(right, above) - part(right, below) - part(left, above) + part(left, below)
        np.testing.assert_allclose(found, exact / (2.0 * math.pi), rtol=1e-6)
        assert found[0, 0] == pytest.approx(1.6 / (2.0 * math.pi * math.hypot(x[0, 0], y[0])), rel=1e-3)

    @pytest.mark.slow
    @pytest.mark.parametrize("peclet", [(0.0, 0.0), (0.3, -0.2), (40.0, 25.0)])
    @pytest.mark.parametrize("shape", [(15, 24), (1, 6)])
    def test_periodic_cells_are_the_sum_of_all_waves(self, shape, peclet):
        sides = (1.0, 1.7)
        total = 0.0
        for i in range(-40, 41):
            qx = 2.0 * np.pi * (np.fft.fftfreq(shape[0])[:, None] + i)
            for j in range(-40, 41):
                qy = 2.0 * np.pi / 1.7 * (np.arange(shape[1] // 2 + 1)[None] / shape[1] + j)
                root = np.sqrt(qx**2 + qy**2 + 1j * (qx * peclet[0] + qy * peclet[1]))
                part = np.sinc(0.5 * qx / np.pi) * np.sinc(0.85 * qy / np.pi)
                total += part / np.where(root == 0.0, 1.0, root)
        total[0, 0] = 0.0
        found = sum_periodic_waves(shape, sides, peclet)
        np.testing.assert_allclose(found, total, atol=4e-6 * np.abs(total).max() * (1.0 + max(peclet)))

    def test_a_large_period_is_free(self):
        flow = np.zeros((160, 160))
        flow[76:84, 78:82] = 1.0
        free, periodic = (heat(flow, (1.0, 1.0), 2.0, 0.6, one) for one in (rc.Boundary.FREE, rc.Boundary.PERIODIC))
        near = (slice(70, 90), slice(70, 90))
        # Up to the mean that is omitted.
        difference = (free - periodic)[near]
        assert np.ptp(difference) < 0.02 * free.max()

    @given(st.floats(0.0, 50.0), st.floats(0.0, 6.3), st.sampled_from([rc.Boundary.FREE, rc.Boundary.PERIODIC]))
    def test_symmetries(self, peclet, angle, boundary):
        flow = np.random.default_rng(1).random((9, 7))
        found = heat(flow, (1.0, 3.0), peclet, angle, boundary)
        size = np.abs(found).max()
        mirrored = heat(flow[::-1], (1.0, 3.0), peclet, math.pi - angle, boundary)[::-1]
        turned = heat(flow.T, (3.0, 1.0), peclet, 0.5 * math.pi - angle, boundary).T
        # Reciprocity: what one cell heats another, that heats it in the opposite direction.
        other = np.random.default_rng(2).random((9, 7))
        back = heat(other, (1.0, 3.0), peclet, angle + math.pi, boundary)
        assert np.abs(mirrored - found).max() < 2e-6 * size
        assert np.abs(turned - found).max() < 2e-6 * size
        assert np.sum(found * other) == pytest.approx(np.sum(back * flow), rel=1e-6, abs=1e-6 * size)


class TestContact:
    @pytest.mark.parametrize("peclet", HERTZ)
    def test_hertz(self, peclet):
        solution = ball(16, (0.3, -0.2))
        # At rest if the body alone moves, which does not conduct.
        speed = (1.0, 0.0) if peclet == 0.0 else (0.0, 2.0 * peclet)
        found = solution.flash_temperature(1.0, speed, **ALONE)
        exact = HERTZ[peclet] * 1.5 * found.heat / math.pi
        assert found.value == pytest.approx(exact, rel=2e-3)
        # The values are known to four digits.
        assert abs(found.value - exact) <= 2.0 * found.uncertainty + 1e-3 * found.value
        assert found.fraction.value == 0.0
        assert found.heat == pytest.approx(solution.force * abs(speed[1] - speed[0]), rel=1e-6)
        assert found.peclet[1] == pytest.approx(peclet, rel=1e-3)

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_both_bodies_have_one_temperature_and_all_heat(self, boundary):
        solution = rough(boundary=boundary)
        found = ask(solution, direction=25.0)
        cells = solution.contact
        body, counterbody = found.temperatures
        assert np.abs(body - counterbody)[cells].max() < 1e-4 * body.max()
        assert found.heat == pytest.approx(0.3 * 3.0 * solution.force, rel=1e-6)
        assert 0.0 < found.fraction.value < 1.0
        assert found.value >= body[cells].max() * (1.0 - 1e-12)
        assert isinstance(found, FlashTemperature)
        assert found.unit == "K"
        # Each alone is hotter, and the partition is at least as good as the constant one of Blok.
        alone = [ask(solution, direction=25.0, conductivity=k) for k in ((2.0, 0.0), (0.0, 3.0))]
        assert found.blok == pytest.approx(1.0 / sum(1.0 / one.blok for one in alone))
        assert found.blok_fraction == pytest.approx(alone[1].blok / (alone[0].blok + alone[1].blok))
        assert [one.fraction.value for one in alone] == [1.0, 0.0]
        assert not alone[0].temperatures[1][~cells].any()
        np.testing.assert_array_equal(alone[0].temperatures[1][cells], alone[0].temperatures[0][cells])

    def test_the_partition_of_a_ball(self):
        # Body at rest and moving counterbody of one material; by a dense equation in shared notes.
        for peclet, part, blok in ((4.5, 0.266, 0.319), (45.0, 0.104, 0.140)):
            found = ball(16).flash_temperature(1.0, 2.0 * peclet, conductivity=1.0, diffusivity=1.0)
            assert found.fraction.value == pytest.approx(part, abs=1.5e-3)
            assert found.blok_fraction == pytest.approx(blok, abs=1.5e-3)
            assert found.value == pytest.approx(found.blok, rel=0.02)

    def test_alike_bodies_at_opposite_speeds_take_half_each(self):
        found = ball(8).flash_temperature(1.0, (2.0, -2.0), conductivity=1.0, diffusivity=1.0)
        assert found.fraction.value == pytest.approx(0.5, abs=1e-6)

    def test_the_bodies_change_places(self):
        solution = rough()
        found = ask(solution, (1.0, 3.0))
        swapped = ask(solution, (3.0, 1.0), conductivity=(3.0, 2.0), diffusivity=(0.5, 1.0))
        assert swapped.value == pytest.approx(found.value, rel=1e-5)
        assert swapped.fraction.value == pytest.approx(1.0 - found.fraction.value, abs=1e-5)
        assert swapped.peclet == pytest.approx(found.peclet[::-1])

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    def test_directions(self, boundary):
        def turn(solution):
            return attrs.evolve(solution, pressure=np.ascontiguousarray(solution.pressure[::-1]))

        solution = rough((33, 41), (1.0, 3.0), boundary)
        found = ask(solution, direction=30.0)
        backwards = ask(solution, -3.0, direction=210.0)
        np.testing.assert_allclose(backwards.temperatures, found.temperatures, rtol=1e-9, atol=1e-9 * found.value)
        assert ask(solution, -3.0, direction=30.0).value != pytest.approx(found.value, rel=1e-4)
        mirrored = ask(turn(solution), direction=150.0)
        scale = 1e-5 * found.value
        np.testing.assert_allclose(mirrored.temperatures[:, ::-1], found.temperatures, atol=scale)
        assert mirrored.value == pytest.approx(found.value, rel=1e-5)

    def test_units(self):
        one, other = rough(), rough(unit=2.0**-20)
        found = ask(one)
        scaled = ask(other, 3.0 * 2.0**20, conductivity=(2.0 * 2.0**10, 3.0 * 2.0**10))
        # T = q u / k: the flux rises with the speed.
        factor = 2.0**20 * 2.0**-20 / 2.0**10
        np.testing.assert_allclose(scaled.temperatures, factor * found.temperatures, rtol=1e-6, atol=1e-8)
        texts = one.flash_temperature(
            0.3, "300cm/s", conductivity=("2W/(m K)", 3.0), diffusivity=("1e6mm2/s", "0.5 m2/s"), direction=0.0
        )
        np.testing.assert_allclose(texts.temperatures, found.temperatures, rtol=1e-12)

    def test_friction_that_varies(self):
        solution = rough()
        field = np.full(solution.grid.shape, 0.3)
        found = solution.flash_temperature(field, 3.0, conductivity=(2.0, 3.0), diffusivity=(1.0, 0.5))
        np.testing.assert_array_equal(found.temperatures, ask(solution).temperatures)
        with pytest.raises(rc.InputError, match=r"The shape of the coefficient of friction must be \(\) or"):
            solution.flash_temperature(field[1:], 3.0, conductivity=1.0, diffusivity=1.0)

    def test_adhesion_and_friction(self):
        tension = rough(adhesion=rc.Exponential(1e-4, 0.05))
        found = ask(tension)
        assert found.heat == pytest.approx(0.9 * tension.contact_pressure.sum() * tension.grid.cell_area)
        grid = rc.Grid((24, 24), 3.0)
        sliding = make_problem(rc.ParaboloidSurface(1000.0), rc.Elastic(1.0, 0.3), grid=grid).slide(
            force=1e-3, friction=0.3
        )
        assert ask(sliding).heat == pytest.approx(0.9e-3, rel=1e-5)

    def test_uncertainty_falls_with_the_cells_and_holds(self):
        exact = ask(ball(32, (0.2, 0.1)))
        stds = []
        for cells in (4, 8, 16):
            for shift in ((0.0, 0.5), (0.25, 0.3), (-0.4, 0.1)):
                found = ask(ball(cells, shift))
                assert abs(found.value - exact.value) <= 2.0 * found.uncertainty
                assert abs(found.mean.value - exact.mean.value) <= 2.0 * found.mean.uncertainty + exact.mean.uncertainty
                assert abs(found.fraction.value - exact.fraction.value) <= 2.0 * found.fraction.uncertainty
            stds.append(found.uncertainty)
        assert stds[0] > 3.0 * stds[1] > 6.0 * stds[2]

    def test_slender_contacts_that_nearly_fill_their_domain(self):
        # The response of a domain cut there has waves that are nearly zero.
        surface = rc.ParaboloidSurface((4000.0, 1000.0))
        for speed in (1e-3, 5.0):
            grid = rc.Grid((128, 64), (5.2, 2.6))
            solution = make_problem(surface, rc.Elastic(1.0, 0.0), grid=grid, threads=1).solve(force=1e-3)
            found = solution.flash_temperature(0.3, speed, conductivity=(1.0, 0.5), diffusivity=1.0, direction=60.0)
            body, counterbody = found.temperatures
            assert np.abs(body - counterbody)[solution.contact].max() < 1e-5 * found.value

    def test_no_contact_is_cold(self):
        solution = rough(boundary="free")
        empty = attrs.evolve(solution, pressure=0.0 * solution.pressure)
        found = ask(empty)
        assert (found.value, found.uncertainty, found.heat, found.blok) == (0.0, 0.0, 0.0, 0.0)
        assert str(found).startswith("0 K +- 0 K")


def test_it_reads_well():
    steel = rc.Elastic("210GPa", 0.3)
    body = rc.Body(rc.SphereSurface("5mm"), steel)
    solution = rc.ContactProblem(body, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((64, 64), "400um")).solve(
        force=10
    )
    found = solution.flash_temperature(0.2, "10m/s", conductivity="45W/m/K", diffusivity="12mm2/s")
    text = str(found)
    assert text.startswith(f"{found.value:.5g} K +- ")
    assert "of 20 W into the body; Peclet 0 and 28.6; by Blok" in text
    response = SlidingHeat(0.2, "10m/s", conductivity="45W/m/K", diffusivity="12mm2/s")
    assert response.speed == (0.0, 10.0)
    assert solution.response(response).value == found.value


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"friction": 0.0}, "The coefficient of friction must be a finite number, above 0"),
        ({"speed": 0.0}, "The speed of the surfaces must be other than 0"),
        ({"speed": (2.0, 2.0)}, "two that differ, to slide"),
        ({"speed": "5"}, "The speed of the surfaces must be"),
        ({"speed": (1.0, 2.0, 3.0)}, "one value or two"),
        ({"conductivity": 0.0}, "The thermal conductivity of the bodies must be above 0"),
        ({"conductivity": -1.0}, "The thermal conductivity of the bodies must be"),
        ({"diffusivity": (1.0, 0.0)}, "The thermal diffusivity of the bodies must be"),
        ({"direction": math.inf}, "The direction must be"),
        ({"speed": 1e7}, "The Peclet number of a cell, .* must be at most 100000"),
    ],
)
def test_wrong_arguments(changes, words):
    arguments = {"friction": 0.3, "speed": 1.0, "conductivity": 1.0, "diffusivity": 1.0, **changes}
    with pytest.raises(rc.InputError, match=words):
        rough().flash_temperature(**arguments)


def test_what_is_refused():
    for boundary in ("wrapped", "free-periodic"):
        with pytest.raises(rc.InputError, match=r"needs boundary='free' or 'periodic'"):
            ask(rough(boundary=boundary))
    with pytest.raises(rc.InputError, match="known for homogeneous half-spaces"):
        ask(attrs.evolve(rough(), moduli=((1e-6, 1e-3), (1.0, 2.0))))
    full = rough(pressure=1.0)
    assert full.contact.all()
    with pytest.raises(rc.InputError, match="The surfaces touch everywhere and repeat"):
        ask(full)
    assert ask(rough(pressure=1.0, boundary="free")).value > 0.0
