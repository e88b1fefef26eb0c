"""Flow factors and asperity pressure over the separation: closed forms, averaging, symmetry, fits, files, refusals."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(210e9, 0.3)
SIDE = 1e-3


def pair(heights, size=SIDE, other=None, material=STEEL, boundary="periodic", **parts):
    """Return the problem of heights on a flat, or on other heights."""
    size = (size, size) if np.ndim(size) == 0 else size
    bodies = [
        rc.Body(rc.HeightMap(one, size=size, periodic=True), material) if one is not None else rc.RIGID_FLAT
        for one in (heights, other)
    ]
    return rc.ContactProblem(*bodies, boundary=boundary, threads=1, **parts)


def wave(cells, direction=(1, 0)):
    """Return a cosine of amplitude 1 um that repeats along a direction of whole numbers, on a square."""
    x = (np.arange(cells) + 0.5) / cells
    return 1e-6 * np.cos(2.0 * np.pi * (direction[0] * x[:, np.newaxis] + direction[1] * x))


def ask(problem, separations, **options):
    """Return pressure and shear flow factors, shape (rows, 2, 2)."""
    law = rc.film_law(problem, separations, sampling=False, **options)
    pressure = np.array([[law[f"phi_{k}"].values for k in row] for row in (("xx", "xy"), ("xy", "yy"))])
    shear = np.array([[law[f"phi_s_{k}"].values for k in row] for row in (("xx", "xy"), ("yx", "yy"))])
    return law, pressure.transpose(2, 0, 1), shear.transpose(2, 0, 1)


def closed_form(a):
    """Return the factors of a wave of amplitude a times the mean gap, across and along it, and across of shear."""
    across = (1.0 - a * a) ** 2.5 / (1.0 + 0.5 * a * a)
    return across, 1.0 + 1.5 * a * a, 1.5 * a * a / (1.0 + 0.5 * a * a)


class TestWaves:
    """One-dimensional roughness: series across, parallel along it."""

    amplitudes = np.array([0.8, 0.5, 0.2])

    @pytest.mark.parametrize("width", [6, 1])
    @pytest.mark.parametrize("turned", [False, True])
    def test_waves_are_exact_along_both_axes(self, turned, width):
        heights = np.tile(wave(64)[:, :1], (1, width))
        size = (SIDE, 0.37 * SIDE if width > 1 else SIDE / 64.0)
        problem = pair(heights.T, size[::-1]) if turned else pair(heights, size)
        separations = math.sqrt(2.0) / self.amplitudes
        law, pressure, shear = ask(problem, separations)
        x, y = (1, 0) if turned else (0, 1)
        for row, a in enumerate(self.amplitudes):
            across, along, dragged = closed_form(a)
            assert pressure[row, x, x] == pytest.approx(across, rel=1e-12)
            assert pressure[row, y, y] == pytest.approx(along, rel=1e-12)
            assert shear[row, x, x] == pytest.approx(dragged * separations[row], rel=1e-12)
            assert abs(shear[row, y, y]) < 1e-12
            assert abs(pressure[row, 0, 1]) < 1e-13
        np.testing.assert_allclose(law["contact_factor"].values, 1.0, rtol=1e-12)
        np.testing.assert_allclose(law["mean_gap"].values, separations * law.rms_height, rtol=1e-12)
        assert not law["asperity_pressure"].values.any()

    def test_turned_waves_converge_in_second_order(self):
        a = 0.7
        across, along, dragged = closed_form(a)
        direction = np.array([2.0, 1.0]) / math.sqrt(5.0)
        beside = np.array([-1.0, 2.0]) / math.sqrt(5.0)
        true = across * np.outer(direction, direction) + along * np.outer(beside, beside)
        separation = math.sqrt(2.0) / a
        errors = []
        for cells in (32, 64):
            _, pressure, shear = ask(pair(wave(cells, (2, 1))), [separation, 2.0 * separation])
            errors.append(
                [
                    np.abs(pressure[0] - true).max(),
                    np.abs(shear[0] / separation - dragged * np.outer(direction, direction)).max(),
                ]
            )
        orders = np.log2(np.array(errors[0]) / errors[1])
        assert (orders > 1.85).all()
        assert errors[1][0] < 4e-3

    @pytest.mark.parametrize("numbers", [(4, 3), (3, 3), (2, -3)])
    def test_oblique_grooves_of_some_cells(self, numbers):
        """V-grooves of 4 to 10 cells: by the mean of two cells the flow along them errs by 4 to 8 %, and 1 to 2 %."""
        along = np.array([-numbers[1], numbers[0]]) / math.hypot(*numbers)
        across = np.array(numbers) / math.hypot(*numbers)

        def film(part):
            return 1.0 + 2.0 * np.maximum(0.0, 1.0 - np.abs(part % 1.0 - 0.5) / 0.3)

        period = film((np.arange(100_000) + 0.5) / 100_000)
        factors = np.array([1.0 / np.mean(period**-3), np.mean(period**3)]) / period.mean() ** 3
        true = factors[0] * np.outer(across, across) + factors[1] * np.outer(along, along)
        for cells, allowed in ((32, 0.03), (64, 0.006)):
            x = (np.arange(cells) + 0.5) / cells
            gap = film(numbers[0] * x[:, np.newaxis] + numbers[1] * x + 0.13)
            separation = gap.mean() / gap.std()
            _, pressure, _ = ask(pair(-1e-6 * gap), [separation, 2.0 * separation])
            assert np.abs(pressure[0] - true).max() < allowed * factors[1]

    def test_ridges_in_contact(self):
        """Westergaard: p* = pi E* A / l; the gap is the integral of its slope, cos psi sqrt(sin^2 psi - p / p*)."""
        cells = 384
        psi = np.pi * (np.arange(cells) + 0.5) / cells
        ratios = np.array([0.8, 0.5, 0.2, 0.05])
        sines = np.sin(psi)[:, np.newaxis]
        inside = np.sqrt(np.maximum(sines**2 - ratios, 0.0))
        gaps = 2.0 * (sines * inside - ratios * np.arccosh(np.maximum(sines / np.sqrt(ratios), 1.0)))
        problem = pair(np.tile(wave(cells)[:, :1], (1, 4)), (SIDE, 4.0 * SIDE / cells))
        separations = gaps.mean(axis=0) * math.sqrt(2.0)
        law, pressure, shear = ask(problem, separations)
        np.testing.assert_allclose(pressure[:, 1, 1], [21.9515, 7.8298, 4.1176, 2.9643], rtol=1e-4)
        full = np.pi * law.modulus * 1e-6 / SIDE
        np.testing.assert_allclose(law["asperity_pressure"].values / full, ratios, rtol=2e-3)
        # What cannot flow rides in the valleys.
        np.testing.assert_array_equal(pressure[:, 0, 0] < 1e-20, True)
        np.testing.assert_allclose(shear[:, 0, 0], separations, rtol=1e-12)


@pytest.mark.parametrize(("peklenik", "separation", "allowed"), [(3.0, 20.0, 0.01), (1.0, 40.0, 0.02)])
def test_light_roughness_is_that_of_tripp(peklenik, separation, allowed):
    """phi = 1 + 3 / H^2 (1 - 3 T), phi_s = 3 T / H with T the mean of q q / q^2 over the power (1983)."""
    cells = 128
    q = np.fft.fftfreq(cells, 1.0 / cells)
    qx, qy = q[:, np.newaxis], q
    ring = np.hypot(peklenik * qx, qy)
    spectrum = np.where((ring > 3.0) & (ring < 16.0) & (np.abs(qx) < 16) & (np.abs(qy) < 16), 1.0, 0.0)
    noise = np.fft.fft2(np.random.default_rng(4).normal(size=(cells, cells)))
    heights = np.real(np.fft.ifft2(noise * spectrum))
    heights *= 1e-6 / heights.std()
    power = np.abs(np.fft.fft2(heights)) ** 2
    power /= power.sum()
    square = np.maximum(qx**2 + qy**2, 1.0)
    tensor = np.array([[np.sum(power * one * other / square) for other in (qx, qy)] for one in (qx, qy)])
    _, pressure, shear = ask(pair(heights), [separation, separation + 1.0])
    change = (pressure[0] - np.eye(2)) * separation**2 / 3.0
    np.testing.assert_allclose(change, np.eye(2) - 3.0 * tensor, atol=3.0 * allowed)
    np.testing.assert_allclose(shear[0] * separation / 3.0, tensor, atol=allowed)


def test_a_tilted_pad_of_many_ridges_is_that_of_the_averaged_equation():
    """A smooth wall slides at U below a rough pad at rest: q = -g^3 p' / 12 + U g / 2, less by U Sq phi_s / 2."""
    ends = 7.0, 3.5
    rows = np.linspace(3.0, 7.5, 19)
    _, pressure, shear = ask(pair(np.tile(wave(64)[:, :1], (1, 4))), rows)
    loads = []
    for periods in (16, 32, None):
        x = (np.arange(64 * (periods or 32)) + 0.5) / (64 * (periods or 32))
        h = ends[0] + (ends[1] - ends[0]) * x
        if periods:
            g = h - math.sqrt(2.0) * np.cos(2.0 * np.pi * periods * x)
            cubes, films = g**3, g
        else:
            cubes = h**3 * np.interp(h, rows, pressure[:, 0, 0])
            films = h - np.interp(h, rows, shear[:, 0, 0])
        flow = 0.5 * np.sum(films / cubes) / np.sum(1.0 / cubes)
        slope = (6.0 * films - 12.0 * flow) / cubes
        loads.append(np.mean(np.cumsum(slope)) / x.size)
    flow = 0.5 * np.sum(h**-2) / np.sum(h**-3)
    without = np.mean(np.cumsum(6.0 / h**2 - 12.0 * flow / h**3)) / x.size
    off = np.abs(np.array(loads[:2]) / loads[2] - 1.0)
    assert off[1] < 0.6 * off[0]
    assert off[1] < 0.05
    assert abs(without / loads[2] - 1.0) > 0.1


def rough(cells=64, seed=1, **parts):
    return rc.SelfAffineSurface(
        hurst=0.8, rms_height=1e-6, shortest=SIDE / 8.0, longest=SIDE, rolloff=SIDE / 4.0, seed=seed
    ).heights(rc.Grid((cells, cells), SIDE))


class TestSymmetry:
    rows = (0.75, 1.5, 4.0)

    def test_turned_and_mirrored_pairs_have_turned_factors(self):
        heights = rough()
        law, pressure, shear = ask(pair(heights), self.rows)
        _, turned, dragged = ask(pair(heights.T), self.rows)
        np.testing.assert_allclose(turned, pressure[:, ::-1, ::-1], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(dragged, shear[:, ::-1, ::-1], rtol=1e-6, atol=1e-9)
        _, mirrored, _ = ask(pair(heights[::-1]), self.rows)
        np.testing.assert_allclose(mirrored[:, 0, 1], -pressure[:, 0, 1], rtol=1e-6, atol=1e-9)
        _, moved, _ = ask(pair(np.roll(heights, (5, 9), (0, 1))), self.rows)
        np.testing.assert_allclose(moved, pressure, rtol=1e-6, atol=1e-9)
        assert law["area"].values[0] > law["area"].values[1] > law["area"].values[2] == 0.0
        # The viscous factor is known by reciprocity: at a row h (1 - phi_fp) is the dragged film.
        one = law["phi_fp_xy"].values * law.separations + law["phi_s_yx"].values
        np.testing.assert_allclose(one, 0.0, atol=1e-12)

    def test_a_rough_counterbody_drags_the_other_way(self):
        heights = rough()
        _, pressure, shear = ask(pair(heights), self.rows)
        problem = pair(np.zeros(heights.shape), other=heights, material=rc.Elastic(420e9, 0.3))
        other, same, opposite = ask(problem, self.rows)
        np.testing.assert_allclose(same[2], pressure[2], rtol=1e-9)
        np.testing.assert_allclose(opposite[2], -shear[2], rtol=1e-9, atol=1e-12)
        assert other.rms_heights == pytest.approx((0.0, 1e-6), rel=0.3)

    def test_two_rough_walls_drag_as_each_of_them_alone(self, tmp_path):
        one, other = rough(), rough(seed=2).T
        both = (one + other).std()
        rows = np.array([6.0, 8.0])
        _, _, shear = ask(pair(one, other=other), rows)
        alone = [ask(pair(wall), rows * both / wall.std())[2] * wall.std() / both for wall in (one, other)]
        np.testing.assert_allclose(shear, alone[0] - alone[1], rtol=1e-9, atol=1e-12)
        law = rc.film_law(pair(one, other=other), [1.0, 6.0], sampling=False)
        assert "phi_xx" in law.columns
        (refusal,) = (text for text in law.warnings if "phi_s" in text)
        for ask_for in (
            lambda: law["phi_s_xx"],
            lambda: law.plot("phi_s_yy"),
            lambda: law.to_text(tmp_path / "shear.txt", "phi_s_xy"),
            lambda: law.to_comsol(tmp_path / "shear.txt", columns=["phi_xx", "phi_s_xx"]),
        ):
            with pytest.raises(rc.InputError) as refused:
                ask_for()
            assert str(refused.value) == refusal
        assert not list(tmp_path.iterdir())
        with pytest.raises(rc.InputError, match="no column of the law named 'phi_s_zz'"):
            law["phi_s_zz"]

    def test_lengths_and_moduli_change_the_scale_alone(self):
        law, pressure, _ = ask(pair(rough()), self.rows)
        large, same, _ = ask(pair(2.0**8 * rough(), 2.0**8 * SIDE, material=rc.Elastic(2.0 * 210e9, 0.3)), self.rows)
        np.testing.assert_allclose(same, pressure, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(large["asperity_pressure"].values, 2.0 * law["asperity_pressure"].values, rtol=1e-6)


def test_uncertainties_hold_on_a_finer_grid_and_other_places_differ_more():
    coarse, fine = (rc.film_law(pair(rough(cells)), (0.75, 1.5, 2.5), sampling=cells == 40) for cells in (40, 120))
    for name in ("phi_xx", "phi_yy", "phi_s_xx", "phi_s_yy", "asperity_pressure"):
        one, other = coarse[name], fine[name]
        assert (np.abs(one.values - other.values) < 2.5 * (one.uncertainties + other.uncertainties)).all(), name
        assert (one.sampling[:2] > one.uncertainties[:2]).all(), name
        assert other.sampling is None


def test_uncertainties_hold_in_creased_grooves():
    """Oblique grooves with a sharp bottom, five cells wide, whose flow errs by several per cent."""

    def groove(cells):
        x = (np.arange(cells) + 0.5) / cells
        part = np.abs((x[:, np.newaxis] + 2.0 * x + 0.37) % 1.0 - 0.5)
        return np.minimum(1e-6 * (16.0 * part - 2.0), 0.0)

    z, finer = groove(48), groove(192)
    h = 2.0 * np.std(z)
    laws = [rc.film_law(pair(one), [h / np.std(one), 3.0 * h / np.std(one)], sampling=False) for one in (z, finer)]
    for name in ("phi_xx", "phi_yy", "phi_xy", "phi_fp_xx", "phi_fp_yy"):
        coarse, fine = (law[name] for law in laws)
        errors = np.abs(coarse.values - fine.values)
        assert (errors < 2.0 * coarse.uncertainties).all(), name
        assert (fine.uncertainties < coarse.uncertainties).all(), name


def test_nothing_flows_across_ridges_that_never_end():
    x = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    heights = 1e-6 * (np.cos(2.0 * x[:, np.newaxis]) + 0.2 * np.cos(x[:, np.newaxis] + 2.0 * x))
    law, pressure, shear = ask(pair(heights), [0.7, 5.0])
    assert pressure[0, 0, 0] == 0.0
    assert pressure[0, 1, 1] > 1.0
    assert law["phi_xx"].uncertainties[0] == 0.0
    assert shear[0, 0, 0] == pytest.approx(0.7, rel=1e-12)


def test_mirror_images_are_no_other_places():
    z = rough(33)[:, :32]
    size = SIDE, 32 / 33 * SIDE
    mirrored = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    one = rc.film_law(pair(z, size), [1.0, 2.0])
    law = rc.film_law(pair(mirrored, (2.0 * size[0], 2.0 * size[1])), [1.0, 2.0])
    for name in ("asperity_pressure", "area", "phi_xx", "phi_xy", "phi_s_yy"):
        np.testing.assert_allclose(law[name].sampling, one[name].sampling, rtol=1e-5, err_msg=name)


def test_a_hardness_changes_the_film_less_than_the_separation():
    hard = rc.ElasticPerfectlyPlastic(210e9, 0.3, hardness=1e9)
    law = rc.film_law(pair(rough(32), material=hard), [0.75, 1.0, 1.5, 2.5], sampling=False)
    factor = law["contact_factor"].values
    assert 0.6 < factor[0] < factor[-1] < 1.0
    assert (law["mean_gap"].values > law.separations * law.rms_height).all()


def test_a_plan_counts_what_is_solved(monkeypatch):
    problem = pair(rough(cells=32))
    for sampling, states in ((True, 10), (False, 2)):
        counts = []
        plan = rc.faces.plan_film(problem, [3.0, 1.0], sampling=sampling)
        law = rc.film_law(problem, [3.0, 1.0], sampling=sampling, on_row=lambda *both, to=counts: to.append(both))
        assert counts == [(done, states) for done in range(1, states + 1)]
        assert (plan.states, plan.separations) == (states, tuple(law.separations))
    assert rc.faces.plan_film(pair(rough(cells=64)), [1.0, 3.0]).seconds > plan.seconds
    with pytest.raises(rc.InputError, match="on_row= must be a function of 2 arguments, done, total"):
        rc.film_law(problem, [1.0, 3.0], on_row=lambda done: None)
    monkeypatch.setattr("roughcontact._base.machine.available_memory", lambda: 2**20)
    with pytest.raises(rc.InputError, match="A film law needs"):
        rc.faces.plan_film(pair(rough(cells=128)), [1.0, 3.0])


def test_a_range_has_steps_between_which_lines_hold():
    assert rc.faces.space_separations(2.0, 5.5) == [2.0, 2.25, 2.5, 3.0, 3.5, 4.0, 5.0, 5.5]
    for first, last in ((0.0, 1.0), (2.0, 2.0), (1.0, 101.0)):
        with pytest.raises(rc.InputError, match="separation of a range must be a finite number"):
            rc.faces.space_separations(first, last)


class TestFits:
    law = rc.film_law(pair(rough(32)), [0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 4.0], sampling=False)

    def test_fits_are_within_their_misfit(self):
        x, pressure = self.law.separations, self.law["asperity_pressure"].values / self.law.modulus
        carries = pressure > 0.0
        found = self.law.fit("persson")
        fitted = found.constants["factor"] * np.exp(-x / found.constants["decay"])
        off = np.abs(fitted / np.where(carries, pressure, 1.0) - 1.0)[carries]
        assert off.max() == pytest.approx(found.misfit)
        found = self.law.fit("greenwood-tripp")
        factor, offset, sigma = found.constants.values()
        t = np.linspace(-12.0, 12.0, 4001)[:, np.newaxis]
        integrand = np.maximum(t - (x - offset) / sigma, 0.0) ** 2.5 * np.exp(-0.5 * t**2)
        fitted = factor * integrand.sum(axis=0) * (t[1, 0] - t[0, 0]) / math.sqrt(2.0 * math.pi)
        off = np.abs(fitted / np.where(carries, pressure, 1.0) - 1.0)[carries]
        assert off.max() == pytest.approx(found.misfit, rel=1e-3)
        assert found.misfit < 0.3
        assert "greenwood-tripp" in str(self.law)

    def test_plot(self):
        pyplot = pytest.importorskip("matplotlib.pyplot")
        axes = self.law.plot()
        assert self.law.plot("phi_yy", axes) is axes
        assert len(axes.collections) == 2
        axes = self.law.plot("asperity_pressure")
        assert axes.get_yscale() == "log"
        assert axes.get_xlabel() == "separation over Sq"
        sampled = rc.film_law(pair(rough(32)), [1.0, 2.0])
        assert len(sampled.plot("phi_s_xx", dark=True).collections) > 1
        for wrong, sentence in ((("phi",), "column"), (("phi_xx", 5), "The axes")):
            with pytest.raises(rc.InputError, match=sentence):
                self.law.plot(*wrong)
        pyplot.close("all")

    def test_the_peklenik_number_tells_the_lay(self):
        assert self.law.fit("patir-cheng").constants["peklenik"] == pytest.approx(1.0, abs=0.5)
        x = np.linspace(0.0, 1.0, 48, endpoint=False)
        across = 1e-6 * np.cos(16.0 * np.pi * x)[:, np.newaxis] * (1.0 + 0.3 * np.cos(2.0 * np.pi * x))
        found = [rc.film_law(pair(one), [2.0, 3.0], sampling=False).fit("patir-cheng") for one in (across, across.T)]
        numbers = [one.constants["peklenik"] for one in found]
        assert numbers[0] < 0.2
        assert numbers[0] * numbers[1] == pytest.approx(1.0, rel=1e-3)

    def test_fits_that_cannot_be_made_are_refused(self):
        law = rc.film_law(pair(wave(16)), [1.0, 1.2], sampling=False)
        assert any("waves fit into the domain" in text for text in law.warnings)
        with pytest.raises(rc.InputError, match="separations with contact"):
            law.fit("persson")
        with pytest.raises(rc.InputError, match=r"1\.5 Sq or more"):
            law.fit("patir-cheng")
        with pytest.raises(rc.InputError, match="greenwood-tripp"):
            law.fit("other")


class TestFiles:
    law = rc.film_law(pair(rough(16)), [1.0, 2.0, 4.0])

    def test_files_have_the_columns(self, tmp_path):
        law = self.law
        law.to_text(tmp_path / "p.txt", "asperity_pressure", units="mm")
        found = np.loadtxt(tmp_path / "p.txt")
        np.testing.assert_allclose(found[:, 0], 1e3 * law.separations * law.rms_height)
        np.testing.assert_allclose(found[:, 1], 1e-6 * law["asperity_pressure"].values)
        law.to_comsol(tmp_path / "c.txt", columns=["phi_xx", "phi_s_yy", "mean_gap"])
        found = np.loadtxt(tmp_path / "c.txt", comments="%")
        np.testing.assert_allclose(found[:, 1:].T, [law[name].values for name in ("phi_xx", "phi_s_yy", "mean_gap")])
        law.to_json(tmp_path / "l.json")
        content = json.loads((tmp_path / "l.json").read_text())
        assert content["kind"] == "film law"
        names = [one["name"] for one in content["columns"]]
        assert names == list(law.columns)
        one = content["columns"][names.index("phi_yy")]
        np.testing.assert_array_equal(one["values"], law["phi_yy"].values)
        np.testing.assert_array_equal(one["uncertainty_sample"], law["phi_yy"].sampling)
        law.to_csv(tmp_path / "l.csv")
        heading = (tmp_path / "l.csv").read_text().splitlines()[0].split(",")
        assert heading[:3] == ["separation_over_sq", "separation [m]", "asperity_pressure [Pa]"]
        assert {"phi_s_xy [1]", "phi_s_xy_uncertainty [1]", "phi_s_xy_sampling [1]"} < set(heading)
        assert "other places" in str(law)

    @pytest.mark.parametrize("units", ["cm", 3])
    def test_bad_files_are_refused(self, units, tmp_path):
        with pytest.raises(rc.InputError, match="units"):
            self.law.to_text(tmp_path / "p.txt", "area", units=units)
        with pytest.raises(rc.InputError, match="no column of the law named 'flow'"):
            self.law.to_comsol(tmp_path / "c.txt", columns=["flow"])
        with pytest.raises(rc.InputError, match="needs a column"):
            self.law.to_comsol(tmp_path / "c.txt", columns=[])
        assert not list(tmp_path.iterdir())


def lost():
    heights = rough(16)
    mask = np.zeros(heights.shape, dtype=bool)
    mask[3, 4] = True
    surface = rc.HeightMap(heights, size=(SIDE, SIDE), periodic=True, non_measured=mask)
    return rc.ContactProblem(rc.Body(surface, STEEL), boundary="periodic")


@pytest.mark.parametrize(
    ("problem", "separation", "message"),
    [
        (lambda: 3, [1.0, 2.0], "ContactProblem"),
        (lambda: pair(wave(16), boundary="free"), [1.0, 2.0], "boundary='periodic'"),
        (lambda: pair(wave(16), adhesion=rc.Exponential(0.05, 1e-6)), [1.0, 2.0], "attract"),
        (lost, [1.0, 2.0], "fill"),
        (lambda: pair(wave(16)), [1.0], "two or more"),
        (lambda: pair(wave(16)), 1.0, "two or more"),
        (lambda: pair(wave(16)), [1.0, -2.0], "above 0"),
        (lambda: pair(wave(16)), [1.0, math.nan], "finite"),
        (lambda: pair(wave(16)), [1.0, 1.0], "twice"),
    ],
)
def test_what_has_no_law_is_refused(problem, separation, message):
    with pytest.raises(rc.InputError, match=message):
        rc.film_law(problem(), separation)
