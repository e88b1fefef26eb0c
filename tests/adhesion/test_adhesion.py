"""Contact with adhesion through the public classes: closed forms, limits, energies, paths, files and refusals."""

import itertools
import math
from functools import partial

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.errors import InputError, NotConverged
from roughcontact.reference import DMT, JKR, JohnsonWave, MaugisDugdale, PastewkaRobbins
from scenes import each_once, make_problem, rather_slow

MODULUS = 1e9
RADIUS = 1e-6
WORK = 0.05
MATERIAL = rc.Elastic(young=0.75 * MODULUS, poisson=0.5)
HARD = rc.ElasticPerfectlyPlastic(young=0.75 * MODULUS, poisson=0.5, hardness=60e6)
UNIT = math.pi * WORK * RADIUS
JKR_BALL = JKR(RADIUS, MODULUS, WORK)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-8, longest=1e-6, shortest=1e-7, seed=3)
LAW = rc.Exponential(work=0.02, range=3e-9)
BOUNDARIES = ("free", "periodic", "wrapped")


def make_rough(shape=(48, 48), size=1e-6, law=LAW, material=MATERIAL, boundary="periodic", **parts):
    return make_problem(ROUGH, material, grid=rc.Grid(shape, size), boundary=boundary, adhesion=law, **parts)


def make_ball(law, side, cells, *, boundary="free", center=(0.0, 0.0)):
    """Return a ball on a domain of a side, m, with so many cells along it, its centre moved by parts of a cell."""
    places = tuple(side / cells * place for place in center)
    body = rc.Body(rc.ParaboloidSurface(RADIUS, center=places), MATERIAL)
    return rc.ContactProblem(body, grid=rc.Grid((cells, cells), side), boundary=boundary, adhesion=law)


def make_maugis(transition, smoothing):
    """Return the closed form for Maugis' parameter, and the smoothed law."""
    strength = 0.5 * transition * math.cbrt(math.pi * WORK * (4.0 / 3.0 * MODULUS) ** 2 / RADIUS)
    return MaugisDugdale(RADIUS, MODULUS, WORK, strength), rc.Dugdale(WORK, strength, smoothing)


class TestReference:
    """The closed forms against values of the literature and against each other."""

    @pytest.mark.parametrize(
        ("transition", "pull_off"),
        [(0.1, 1.9506), (0.25, 1.8468), (0.5, 1.7182), (1, 1.6007), (2, 1.5346), (3, 1.5168), (5, 1.5063)],
    )
    def test_pull_off_of_maugis(self, transition, pull_off):
        ball, _ = make_maugis(transition, 0.2)
        assert ball.transition == pytest.approx(transition)
        assert ball.pull_off / UNIT == pytest.approx(-pull_off, abs=5e-5)

    @pytest.mark.parametrize(("transition", "limit"), [(1e-5, DMT(RADIUS, MODULUS, WORK)), (300.0, JKR_BALL)])
    def test_maugis_between_its_limits(self, transition, limit):
        ball, _ = make_maugis(transition, 0.2)
        radius = JKR_BALL.radius_at_zero_load
        assert ball.pull_off == pytest.approx(limit.pull_off, rel=2e-3)
        assert ball.contact_radius(UNIT) == pytest.approx(limit.contact_radius(UNIT), rel=2e-3)
        assert ball.approach(radius) == pytest.approx(limit.approach(radius), rel=5e-3)

    @pytest.mark.parametrize("ball", [JKR_BALL, DMT(RADIUS, MODULUS, WORK), make_maugis(0.7, 0.2)[0]])
    def test_radius_and_force_are_inverse(self, ball):
        for force in (0.9 * ball.pull_off, 0.0, 3.0 * UNIT):
            assert ball.force(ball.contact_radius(force)) == pytest.approx(force, abs=1e-9 * UNIT)

    def test_radius_without_load(self):
        assert JKR_BALL.contact_radius(0.0) == pytest.approx(JKR_BALL.radius_at_zero_load)
        assert JKR_BALL.force(JKR_BALL.radius_at_zero_load) == pytest.approx(0.0, abs=1e-12 * UNIT)

    @pytest.mark.parametrize(("alpha", "pull_off", "half_width"), [(0.1, 0.0220, 0.0697), (0.2, 0.0556, 0.1136)])
    def test_wave(self, alpha, pull_off, half_width):
        wave = make_wave(alpha)
        assert wave.alpha == pytest.approx(alpha)
        assert wave.pull_off / wave.full_contact_pressure == pytest.approx(-pull_off, abs=5e-5)
        assert wave.half_width(0.0) / wave.wavelength == pytest.approx(half_width, abs=5e-5)

    def test_wave_spreads_without_a_load(self):
        # Johnson: from alpha = 0.57 on the contact becomes full by itself.
        assert make_wave(0.565).pressure_of_full_contact > 0.0 > make_wave(0.575).pressure_of_full_contact

    def test_criterion_at_its_limit(self):
        softer = PastewkaRobbins(rms_slope=0.1, rms_curvature=1e6, modulus=1e6, work=0.05, range=1e-9)
        limit = attrs.evolve(softer, modulus=1e6 / softer.ratio)
        left = 0.1 * 1e-9 * limit.modulus / (2.0 * 0.05) * (0.1 * 4e-7 / 4e-9) ** (2 / 3)
        assert left == pytest.approx(math.pi * (3 / 16) ** (2 / 3))

    def test_what_has_no_solution_is_refused(self):
        with pytest.raises(InputError, match="force"):
            JKR_BALL.contact_radius(1.01 * JKR_BALL.pull_off)
        with pytest.raises(InputError, match="no strip is stable"):
            _ = make_wave(5.0).pull_off


def make_wave(alpha):
    amplitude, length, modulus = 1e-6, 1e-4, 1e6
    return JohnsonWave(amplitude, length, modulus, 0.5 * (alpha * math.pi * amplitude) ** 2 * modulus / length)


def solve_wave(alpha, cells, place=0.0):
    """Return Johnson's wave, its crest `place` cells aside, and its problem with the shortest range for the cells."""
    wave = make_wave(alpha)
    grid = rc.Grid((cells, 4), (wave.wavelength, 4.0 * wave.wavelength / cells))
    phase = 2.0 * np.pi * (grid.x / wave.wavelength - place / cells)
    heights = np.broadcast_to(wave.amplitude * np.cos(phase), grid.shape)
    body = rc.Body(rc.HeightMap(heights, grid.size), rc.Elastic(0.75 * wave.modulus, 0.5))
    return wave, rc.ContactProblem(body, boundary="periodic", adhesion=rc.ShortRange(wave.work))


class TestBall:
    """Pull-off, radius and approach of a ball against Maugis, Johnson and Derjaguin."""

    @pytest.mark.parametrize(
        ("transition", "smoothing", "side", "cells"),
        [
            (0.1, 0.2, 535e-9, 64),
            (0.25, 0.2, 450e-9, 56),
            (0.5, 0.2, 380e-9, 60),
            (1.0, 0.3, 340e-9, 80),
            pytest.param(2.0, 0.5, 300e-9, 128, marks=pytest.mark.slow),
            pytest.param(3.0, 0.7, 290e-9, 200, marks=pytest.mark.slow),
            pytest.param(5.0, 1.0, 270e-9, 320, marks=pytest.mark.slow),
        ],
    )
    def test_pull_off_between_derjaguin_and_johnson(self, transition, smoothing, side, cells):
        exact, law = make_maugis(transition, smoothing)
        found = make_ball(law, side, cells).pull_off()
        assert found.value == pytest.approx(exact.pull_off, rel=3e-3)
        assert found.uncertainty < 0.01 * abs(found.value)

    def test_radius_and_approach(self):
        exact, law = make_maugis(0.5, 0.2)
        problem = make_ball(law, 380e-9, 64)
        for force in (0.0, 2.0 * UNIT, -UNIT):
            solution = problem.solve(force=force)
            radius = exact.contact_radius(force)
            assert math.sqrt(solution.area().value / math.pi) == pytest.approx(radius, rel=0.01)
            assert solution.approach == pytest.approx(
                exact.approach(radius), abs=0.01 * exact.approach(exact.radius_at_zero_load)
            )
            assert solution.force == pytest.approx(force, abs=1e-10 * UNIT)

    def test_force_over_the_approach(self):
        exact, law = make_maugis(0.5, 0.2)
        radii = np.array([35e-9, 55e-9, 75e-9])
        approaches = [exact.approach(radius) for radius in radii]
        sweep = make_ball(law, 380e-9, 64).sweep(approach=approaches)
        expected = np.array([exact.force(radius) for radius in radii])
        np.testing.assert_allclose(sweep.force, expected, atol=0.006 * abs(exact.pull_off))

    def test_any_place_of_the_centre(self):
        _, law = make_maugis(0.5, 0.3)
        found = [make_ball(law, 450e-9, 48, boundary="wrapped", center=place).solve(force=0.0) for place in PLACES]
        areas = np.array([solution.area().value for solution in found])
        # An approach counts from the first touch of a cell, which lies beside the summit.
        approaches = np.array([state.approach - state.origin.source.summit for state in found])
        assert np.ptp(areas) < 0.02 * areas.mean()
        assert np.ptp(approaches) < 0.004 * approaches.mean()

    @pytest.mark.slow
    def test_limit_of_johnson_by_two_ranges(self):
        found = []
        for cells in (64, 128):
            problem = make_ball(rc.ShortRange(WORK), 285e-9, cells)
            radius = math.sqrt(problem.solve(force=0.0).area().value / math.pi)
            found.append((problem.plan.interaction.range**1.5, radius / JKR_BALL.radius_at_zero_load))
        (far, coarse), (near, fine) = found
        assert fine - (coarse - fine) * near / (far - near) == pytest.approx(1.0, rel=5e-3)
        # Pull-off is extrapolated on one grid.
        assert problem.pull_off().value / UNIT == pytest.approx(-1.5, rel=5e-3)

    @pytest.mark.parametrize("law", [rc.Exponential, rc.VanDerWaals])
    def test_limit_of_derjaguin(self, law):
        # The ball is so stiff that it keeps its form: the force is that of the rigid gap.
        stiff = rc.Elastic(young=0.75e14, poisson=0.5)
        cells, side = 64, 500e-9
        problem = rc.ContactProblem(
            rc.Body(rc.ParaboloidSurface(RADIUS, center=(0.5 * side / cells, 0.5 * side / cells)), stiff),
            grid=rc.Grid((cells, cells), side),
            adhesion=law(WORK, 2e-9),
        )
        solution = problem.solve(approach=-1e-12)
        gap = problem.initial_gap + 1e-12
        rigid = float(np.sum(problem.adhesion.tension(gap))) * problem.grid.cell_area
        assert solution.force == pytest.approx(-rigid, rel=2e-3)
        if law is rc.Exponential:
            # On the whole half-space it is that of Derjaguin.
            assert solution.force == pytest.approx(DMT(RADIUS, 1e14, WORK).pull_off, rel=5e-3)


PLACES = ((0.0, 0.0), (0.5, 0.5), (0.3, -0.2), (5.2, -3.1))


class TestWave:
    """A wavy flat against Johnson."""

    @pytest.mark.parametrize(
        "alpha", [pytest.param(0.1, marks=pytest.mark.slow), 0.2, pytest.param(0.3, marks=pytest.mark.slow)]
    )
    def test_pull_off_and_width(self, alpha):
        wave, problem = solve_wave(alpha, 256)
        found = problem.pull_off()
        assert found.value / problem.plan.grid.area == pytest.approx(wave.pull_off, rel=0.02)
        assert (
            abs(found.value / problem.plan.grid.area - wave.pull_off) < 2.0 * found.uncertainty / problem.plan.grid.area
        )
        area = problem.solve(pressure=0.0).area()
        assert 0.5 * area.value / problem.plan.grid.area == pytest.approx(
            wave.half_width(0.0) / wave.wavelength, rel=0.08
        )

    @pytest.mark.parametrize("place", [0.0, 0.13, 0.37])
    def test_full_contact_without_a_load(self, place):
        fractions = [solve_wave(alpha, 256, place)[1].solve(pressure=0.0).contact.mean() for alpha in (0.5, 0.55, 0.60)]
        assert 0.45 < fractions[0] < fractions[1] < 0.75
        assert fractions[2] == 1.0

    def test_rounds_without_adhesion_stay_on_the_loading_branch(self):
        for alpha, is_full in ((0.55, False), (0.60, True)):
            problem = attrs.evolve(solve_wave(alpha, 128)[1], solver="majorise")
            assert problem.solve(pressure=0.0).contact.all() == is_full


class TestEnergy:
    """Work and energy, and the limit without adhesion."""

    @pytest.mark.parametrize("boundary", BOUNDARIES)
    def test_the_force_is_the_derivative_of_the_energy(self, boundary):
        solver = rc.solvers.create("gap-descent", tolerance=1e-9)
        problem = make_rough(law=rc.Exponential(0.02, 8e-9), boundary=boundary, solver=solver)
        cycle = problem.cycle(approach=np.linspace(2e-9, 3e-9, 9))
        gained = np.diff(cycle.energies[0][[0, -1]])[0]
        force = cycle.loading.force
        work = (1e-9 / 24.0) * (force[0] + 4.0 * force[1:-1:2].sum() + 2.0 * force[2:-1:2].sum() + force[-1])
        assert gained == pytest.approx(work, rel=1e-4)
        # Nothing jumps, so that the way back is the way there.
        assert cycle.jumps == ()
        assert abs(cycle.dissipated.value) < 1e-8 * abs(work)
        np.testing.assert_allclose(cycle.unloading.force[::-1], force, atol=1e-8 * np.abs(force).max())
        assert len(cycle.loading) == len(cycle.unloading) == 9

    def test_without_work_it_is_the_contact_without_adhesion(self):
        without = make_rough(law=None).solve(pressure=20e6, tolerance=1e-8)
        differences = []
        for work in (1e-3, 1e-4, 1e-5):
            solution = make_rough(law=rc.Exponential(work, 5e-9)).solve(pressure=20e6, tolerance=1e-8)
            differences.append(np.abs(solution.pressure - without.pressure).max() / without.pressure.max())
        assert differences[0] < 0.01
        for before, after in itertools.pairwise(differences):
            assert before / after == pytest.approx(10.0, rel=0.1)

    @each_once(
        {
            "boundary": BOUNDARIES,
            "load": [{"pressure": 5e6}, {"pressure": 0.0}, {"approach": 3e-9}],
        }
    )
    def test_two_solvers_find_the_same_contact(self, boundary, load):
        first = make_rough(boundary=boundary).solve(**load)
        second = make_rough(boundary=boundary, solver="majorise").solve(**load)
        np.testing.assert_array_equal(first.contact, second.contact)
        np.testing.assert_allclose(first.pressure, second.pressure, atol=1e-4 * first.pressure.max())
        assert first.convolutions < second.convolutions

    @pytest.mark.parametrize(
        ("surface", "shape", "size", "law", "pressure"),
        [
            (
                rc.SelfAffineSurface(hurst=0.874, rms_slope=0.1, shortest=2.08e-7, longest=1.39e-6, seed=947930913),
                (50, 58),
                (1.5e-6, 0.58e-6),
                rc.Dugdale(work=0.1277, strength=32.56e6, smoothing=0.3),
                0.0,
            ),
            (
                rc.SelfAffineSurface(hurst=0.808, rms_slope=0.1, shortest=3.49e-7, longest=9.28e-7, seed=1939494715),
                (54, 63),
                (0.54e-6, 1.89e-6),
                rc.ShortRange(work=0.1541),
                0.814e6,
            ),
        ],
        ids=["cells 3:1 without a load", "cells 1:3 under a load"],
    )
    def test_no_stable_state_is_leapt_over(self, surface, shape, size, law, pressure):
        body = rc.Body(surface, rc.Elastic(1e9, 0.0))
        problem = rc.ContactProblem(body, grid=rc.Grid(shape, size), boundary="periodic", adhesion=law)
        smallest = attrs.evolve(problem, solver="majorise").solve(pressure=pressure)
        largest = problem.solve(pressure=pressure, branch="unloading")
        found = problem.solve(pressure=pressure)
        np.testing.assert_array_equal(found.contact, smallest.contact)
        assert found.contact.sum() < largest.contact.sum()
        assert found.convolutions < 150


class TestLoads:
    """Loads of any sign, and how they end."""

    def test_contact_without_a_load(self):
        solution = make_rough().solve(pressure=0.0)
        assert solution.status is rc.Status.CONVERGED
        assert solution.contact.any()
        assert solution.area().value > 0.0
        forces = solution.contact_pressure.sum()
        assert forces > 0.0
        assert abs(solution.pressure.sum()) < 1e-10 * forces
        np.testing.assert_allclose(solution.pressure, solution.contact_pressure - solution.tension, rtol=1e-14)
        assert solution.attractive_area().value > 0.0

    def test_tensile_load(self):
        problem = make_rough(law=rc.Exponential(0.05, 3e-9))
        relaxed = problem.solve(pressure=0.0)
        pulled = problem.solve(pressure=-1e5)
        assert pulled.force == pytest.approx(-1e5 * 1e-12, rel=1e-9)
        assert pulled.approach < relaxed.approach
        assert pulled.contact.sum() <= relaxed.contact.sum()

    def test_before_the_first_touch(self):
        solution = make_rough().solve(approach=-5e-9)
        assert not solution.contact.any()
        assert solution.force < 0.0
        assert solution.approach == -5e-9
        np.testing.assert_array_equal(solution.pressure, -solution.tension)
        assert solution.area().value == 0.0

    @pytest.mark.parametrize("boundary", BOUNDARIES)
    @pytest.mark.parametrize("branch", ["loading", "unloading"])
    def test_more_than_pull_off_separates(self, boundary, branch):
        problem = make_rough(boundary=boundary)
        solution = problem.solve(pressure=-1e8, branch=branch, throw=False)
        assert solution.status is rc.Status.SEPARATED
        assert not solution.status.success
        with pytest.raises(NotConverged, match="come apart"):
            problem.solve(pressure=-1e8, branch=branch)

    def test_adhesion_enlarges_the_contact(self):
        with_law = make_rough().solve(pressure=10e6)
        without = make_rough(law=None).solve(pressure=10e6)
        assert with_law.area().value > without.area().value + 2.0 * with_law.area().uncertainty
        assert with_law.approach > without.approach

    def test_hardness_bounds_the_pressure(self):
        solution = make_rough(material=HARD).solve(pressure=5e6)
        assert solution.saturated.any()
        assert solution.contact_pressure.max() <= 60e6 + LAW.strength
        assert solution.pressure.max() == 60e6
        assert solution.pressure.min() >= -LAW.strength
        assert solution.contact.sum() > make_rough().solve(pressure=5e6).contact.sum()


class TestPaths:
    """Cycles, jumps and pull-off."""

    @pytest.fixture(scope="class")
    @staticmethod
    def cycle():
        return make_ball(rc.ShortRange(WORK), 285e-9, 64).cycle(approach=np.linspace(-4e-9, 3e-9, 15))

    def test_jumps_cost_energy(self, cycle):
        losses = np.concatenate(cycle.losses)
        assert len(cycle.jumps) >= 2
        assert cycle.dissipated.value > 0.0
        assert cycle.dissipated.value == pytest.approx(losses.sum())
        assert losses.max() > 0.2 * cycle.dissipated.value
        # The first of unloading is the last of loading.
        assert cycle.unloading[0] is cycle.loading[-1]

    def test_the_loss_is_the_area_of_the_loop(self, cycle):
        up, down = cycle.loading, cycle.unloading
        area = np.trapezoid(up.force, up.approach) + np.trapezoid(down.force, down.approach)
        returned = cycle.energies[1][-1] - cycle.energies[0][0]
        assert cycle.dissipated.value == pytest.approx(area - returned, rel=1e-9)
        assert abs(returned) < 0.01 * cycle.dissipated.value

    def test_branches_differ(self, cycle):
        assert cycle.pull_off.value < cycle.pull_in.value < 0.0
        backwards = cycle.unloading.force[::-1]
        assert (backwards <= cycle.loading.force + 1e-3 * abs(cycle.pull_off.value)).all()
        assert "pull-off" in repr(cycle)
        assert "jumps" in str(cycle)

    def test_pull_off_is_the_minimum_on_unloading(self):
        _, law = make_maugis(0.5, 0.3)
        problem = make_ball(law, 400e-9, 40, boundary="wrapped")
        estimate = problem.pull_off()
        exact, _ = make_maugis(0.5, 0.3)
        radius = exact.contact_radius(0.98 * exact.pull_off)
        around = exact.approach(radius) + np.linspace(-3e-9, 3e-9, 13)
        cycle = problem.cycle(approach=around)
        assert cycle.pull_off.value == pytest.approx(estimate.value, rel=2e-3)

    def test_a_sweep_keeps_its_order(self):
        problem = make_rough()
        sweep = problem.sweep(approach=[3e-9, 0.0, -3e-9])
        np.testing.assert_array_equal(sweep.approach, [3e-9, 0.0, -3e-9])
        for state in sweep:
            alone = problem.solve(approach=state.approach)
            assert state.force == pytest.approx(alone.force, rel=1e-3)


class TestRefusals:
    """What does not hold with adhesion is refused in a sentence that says what to do."""

    @pytest.mark.parametrize(
        ("call", "sentence"),
        [
            (lambda p: p.solve(pressure=1e6, area_within=0.01), "accuracy cannot be asked for"),
            (lambda p: p.solve(pressure=1e6, peak_within=0.01), "accuracy cannot be asked for"),
            (lambda p: p.solve_area(0.1), "sweep the loads instead"),
            (lambda p: p.solve(pressure=1e6, branch="up"), "'loading', 'unloading'"),
            (lambda p: p.cycle(approach=[1e-9, 0.0]), "must ascend"),
            (lambda p: p.cycle(approach=[1e-9]), "two of them or more"),
            (lambda p: p.solve(pressure=1e6).partial_slip(tangential_force=1e-8, friction=0.3), "attract each other"),
            (lambda p: attrs.evolve(p, solver="projected-cg"), "knows no tension"),
            (lambda p: attrs.evolve(p, adhesion=rc.Exponential(np.full((3, 3), 0.02), 3e-9)), "the grid has"),
            (lambda p: attrs.evolve(p, adhesion=rc.Exponential(0.02, np.full((3, 3), 3e-9))), "the grid has"),
            (lambda p: attrs.evolve(p, adhesion=3.0), "an Interaction such as Exponential"),
            (lambda p: attrs.evolve(p, adhesion=rc.Exponential(5.0, 1e-9)).pull_off(), "cells of at most"),
            (lambda p: attrs.evolve(p, adhesion=rc.Exponential(5.0, 1e-9)).cycle(approach=[0, 1e-9]), "a range"),
        ],
    )
    def test_with_adhesion(self, call, sentence):
        with pytest.raises(InputError, match=sentence):
            call(make_rough((32, 32)))

    @pytest.mark.parametrize(
        ("call", "sentence"),
        [
            (lambda p: p.solve(pressure=1e6, branch="unloading"), "omit branch="),
            (lambda p: p.solve(pressure=-1e6), "above 0"),
            (lambda p: p.solve(pressure=0.0), "above 0"),
            (lambda p: p.solve(approach=-1e-9), "above 0"),
            (lambda p: p.cycle(approach=[0.0, 1e-9]), "give the problem a law"),
            (lambda p: p.pull_off(), "give the problem a law"),
            (lambda p: p.solve(pressure=1e6).attractive_area(), "give the problem adhesion="),
        ],
    )
    def test_without_adhesion(self, call, sentence):
        with pytest.raises(InputError, match=sentence):
            call(make_rough((32, 32), law=None))

    def test_a_short_range_is_told(self):
        problem = make_rough((32, 32), law=rc.Exponential(0.5, 2.5e-9))
        solution = problem.solve(pressure=1e6, throw=False)
        assert any("cohesive length" in text for text in solution.warnings)
        assert "cohesive length" in problem.explain()
        resolved = make_rough((32, 32)).solve(pressure=1e6)
        assert not any("cohesive length" in text for text in resolved.warnings)


class TestFiles:
    """What is saved comes back, and is verified."""

    @pytest.mark.parametrize("suffix", [".npz", ".nc"])
    @pytest.mark.parametrize(
        "law", [LAW, rc.Dugdale(0.02, 6e6), rc.ShortRange(0.02)], ids=lambda law: type(law).__name__
    )
    def test_solution_of_a_law(self, tmp_path, suffix, law):
        problem = make_rough((32, 32), law=law)
        solution = problem.solve(pressure=5e6, throw=False)
        solution.save(tmp_path / f"contact{suffix}")
        loaded = rc.ContactSolution.load(tmp_path / f"contact{suffix}")
        np.testing.assert_array_equal(loaded.tension, solution.tension)
        np.testing.assert_array_equal(loaded.contact_pressure, solution.contact_pressure)
        assert loaded.residuals == solution.residuals
        assert loaded.area() == solution.area()
        problem.verify(loaded)
        rc.ContactProblem(**loaded.origin.problem).verify(loaded)

    def test_arrays_of_a_law(self, tmp_path):
        work = np.where(np.arange(32) < 16, 0.03, 0.001)[:, None] * np.ones((32, 32))
        solution = make_rough((32, 32), law=rc.Exponential(work, 3e-9)).solve(pressure=0.0)
        half = solution.tension.sum(axis=1)
        assert half[:16].sum() > 5.0 * half[16:].sum()
        solution.save(tmp_path / "halves.npz")
        loaded = rc.ContactSolution.load(tmp_path / "halves.npz")
        np.testing.assert_array_equal(loaded.origin.problem["adhesion"].work, work)

    def test_a_false_tension_is_found(self):
        problem = make_rough((32, 32))
        solution = problem.solve(pressure=5e6)
        tension = solution.tension.copy()
        tension[solution.tension == solution.tension.max()] *= 0.5
        with pytest.raises(InputError, match="contradicts"):
            problem.verify(attrs.evolve(solution, tension=tension))
        with pytest.raises(InputError, match="tension contradicts"):
            make_rough((32, 32), law=None).verify(attrs.evolve(solution))


class TestWithoutAdhesion:
    """Without a law nothing changes."""

    def test_parts_and_file(self, tmp_path):
        problem = make_rough((32, 32), law=None)
        assert "adhesion" not in problem.parts
        assert "adhesion" in make_rough((32, 32)).parts
        solution = problem.solve(pressure=5e6)
        assert solution.tension is None
        assert solution.contact_pressure is solution.pressure
        solution.save(tmp_path / "plain.npz")
        with np.load(tmp_path / "plain.npz", allow_pickle=False) as arrays:
            stored = b"".join(arrays[name].tobytes() for name in arrays.files if arrays[name].dtype.kind != "f")
            assert not any("tension" in name or "adhesion" in name for name in arrays.files)
        assert b"adhesion" not in stored.replace(b"\0", b"")
        assert not any(line.startswith(("adhesion", "branch")) for line in problem.explain().splitlines())
        assert "tension" not in str(solution)


class TestShapes:
    """Domains and cells that are not square, on all boundaries."""

    @pytest.mark.parametrize("boundary", BOUNDARIES)
    @pytest.mark.parametrize(
        ("shape", "size"),
        [((128, 16), (2e-6, 2.5e-7)), ((60, 20), (1e-6, 1e-6)), ((45, 39), (1e-6, 0.9e-6))],
        ids=["8 to 1", "cells 1 to 3", "odd"],
    )
    def test_transposed(self, boundary, shape, size):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-8, longest=5e-7, shortest=1e-7, seed=3)
        heights = surface.heights(rc.Grid(shape, size))
        law = rc.Exponential(0.02, 4e-9)
        first, second = (
            rc.ContactProblem(rc.Body(rc.HeightMap(values, sides), MATERIAL), boundary=boundary, adhesion=law)
            for values, sides in ((heights, size), (heights.T.copy(), size[::-1]))
        )
        for load in ({"pressure": 5e6}, {"approach": 2e-9}):
            one = first.solve(**load, tolerance=1e-7)
            other = second.solve(**load, tolerance=1e-7)
            scale = np.abs(one.pressure).max()
            np.testing.assert_allclose(other.pressure.T, one.pressure, atol=1e-6 * scale)
            np.testing.assert_array_equal(other.tension.T > 0.0, one.tension > 0.0)


@attrs.frozen(eq=False)
class Parabolic(rc.Interaction):
    """A tension that falls linearly to zero at a range: a law of one's own."""

    work: float
    range: float

    def tension(self, gap):
        return 2.0 * self.work / self.range * np.maximum(1.0 - gap / self.range, 0.0)

    def slope(self, gap):
        return np.where(gap < self.range, -2.0 * self.work / self.range**2, 0.0)

    def energy(self, gap):
        return -self.work * np.maximum(1.0 - gap / self.range, 0.0) ** 2


class TestOwnLaw:
    """A law in fewer than twenty lines goes through solve, cycle and file."""

    @pytest.fixture
    @staticmethod
    def law(monkeypatch):
        monkeypatch.setattr(rc.interactions, "_classes", dict(rc.interactions._classes))
        rc.interactions.register("parabolic")(Parabolic)
        return Parabolic(0.02, 8e-9)

    @pytest.mark.slow
    def test_solve_cycle_and_file(self, tmp_path, law):
        assert isinstance(rc.interactions, type(rc.kernels))
        problem = make_rough((32, 32), law=law)
        solution = problem.solve(pressure=0.0)
        assert solution.contact.any()
        cycle = problem.cycle(approach=[-4e-9, 0.0, 4e-9])
        assert cycle.loading.force[1] < 0.0 < cycle.loading.force[2]
        assert problem.pull_off().value < cycle.loading.force[1] < 0.0
        solution.save(tmp_path / "own.npz")
        loaded = rc.ContactSolution.load(tmp_path / "own.npz")
        problem.verify(loaded)
        assert loaded.origin.problem["adhesion"].range == 8e-9


ROUGH_RUBBER = rc.SelfAffineSurface(hurst=0.8, rms_height=0.5e-6, longest=50e-6, shortest=20e-6, seed=4)


def press_rubber(boundary="periodic", shape=(48, 48), size=100e-6, **parts):
    """Return rough rubber whose contact carries a tension of some 20 kPa."""
    law = rc.Exponential("50mJ/m2", "300nm")
    rubber = rc.Elastic(2e6, 0.5)
    return make_problem(ROUGH_RUBBER, rubber, grid=rc.Grid(shape, size), boundary=boundary, adhesion=law, **parts)


class TestLoadsThatAreCarried:
    """No load that another branch carries is called separated."""

    @pytest.mark.parametrize("boundary", ["periodic", ("free", "periodic")])
    def test_below_pull_off_the_surfaces_hold(self, boundary):
        problem = press_rubber(boundary, shape=(48, 32))
        lowest = problem.pull_off().value
        for fraction in (0.6, 0.95):
            solution = problem.solve(force=fraction * lowest)
            assert solution.status.success
            assert solution.contact.any()
            assert solution.force == pytest.approx(fraction * lowest, rel=1e-6)

    def test_beyond_pull_off_they_come_apart(self):
        problem = press_rubber()
        lowest = problem.pull_off().value
        assert problem.solve(force=1.1 * lowest, throw=False).status is rc.Status.SEPARATED

    def test_a_study_follows_the_order_of_its_loads(self, tmp_path):
        problem = press_rubber()
        loads = [0.0, -5e3, -12e3, -20e3]
        sweep = problem.sweep(pressure=loads)
        study = rc.Study(problems={"rubber": problem}, pressure=loads, fields=True)
        found = study.run(tmp_path)
        assert [record.status for record in found] == [state.status.name for state in sweep]
        assert [record.approach for record in found] == pytest.approx([state.approach for state in sweep], rel=1e-6)
        # Continued from the files.
        for record in found[2:]:
            (tmp_path / f"{record.key}.npz").unlink()
        again = study.run(tmp_path)
        assert [one.approach for one in again] == pytest.approx([one.approach for one in found], rel=1e-6)


class TestZeroLoad:
    def test_one_cell_that_touches_has_no_net_pressure(self):
        tip = rc.Body(rc.ParaboloidSurface(100e-9), rc.Elastic(160e9, 0.25))
        law = rc.Dugdale("50mJ/m2", "300MPa")
        solution = rc.ContactProblem(tip, grid=rc.Grid((32, 32), 320e-9), adhesion=law).solve(force=0.0)
        assert solution.status.success
        assert solution.force == 0.0

    @pytest.mark.parametrize("shape", [(32, 32), (48, 16)])
    def test_a_flat_pad_comes_off_with_the_strength_of_its_area(self, shape):
        pad = np.zeros(shape)
        inside = tuple(slice(n // 4, 3 * n // 4) for n in shape)
        pad[inside] = 50e-9
        law = rc.Exponential(0.05, 2e-9)
        problem = rc.ContactProblem(rc.Body(rc.HeightMap(pad, (3.2e-6, 3.2e-6)), rc.Elastic(160e9, 0.25)), adhesion=law)
        assert problem.solve(force=0.0).status.success
        strength = 0.05 / 2e-9 * pad[inside].size * problem.plan.grid.cell_area
        assert problem.pull_off().value == pytest.approx(-strength, rel=0.03)


class TestCyclesOfFewStates:
    @pytest.mark.slow
    def test_pull_off_is_that_of_the_problem(self):
        ball = rc.Body(rc.ParaboloidSurface(1e-6, (2e-9, -1e-9)), rc.Elastic(1e9, 0.0))
        law = rc.Exponential(0.05, 6e-9)
        problem = rc.ContactProblem(ball, grid=rc.Grid((64, 64), 400e-9), adhesion=law)
        expected = problem.pull_off()
        for states in (7, 9, 21):
            found = problem.cycle(approach=np.linspace(-17e-9, 12e-9, states)).pull_off
            assert abs(found.value - expected.value) < 2.0 * math.hypot(found.uncertainty, expected.uncertainty)

    def test_a_hardness_that_is_reached_is_not_forgotten(self):
        soft = rc.ElasticPerfectlyPlastic(1e9, 0.0, hardness=30e6)
        ball = rc.Body(rc.ParaboloidSurface(1e-6), soft)
        law = rc.Exponential(0.05, 6e-9)
        problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 400e-9), adhesion=law)
        cycle = problem.cycle(approach=[-16e-9, 0.0, 12e-9])
        assert cycle.unloading[-1].added[0].numbers["plastic_work"][0] > 0.0
        with pytest.raises(rc.InputError, match="each state is a first loading"):
            problem.sweep(approach=[12e-9, 6e-9])


class TestBorderAndRange:
    def test_a_tension_that_a_free_border_cuts_off_is_warned_of_and_counted(self):
        tip = rc.Body(rc.ParaboloidSurface(1e-6), rc.Elastic(70e9, 0.3))
        law = rc.Exponential(0.05, 5e-9)
        wide = rc.ContactProblem(tip, grid=rc.Grid((140, 140), 140 * 5e-9), adhesion=law).pull_off()
        assert not wide.warnings
        for shape in ((50, 50), (66, 44)):
            grid = rc.Grid(shape, (shape[0] * 5e-9, shape[1] * 5e-9))
            found = rc.ContactProblem(tip, grid=grid, adhesion=law).pull_off()
            assert [text.rule for text in found.warnings] == ["border tension"]
            assert abs(found.value - wide.value) < 2.0 * found.uncertainty

    def test_a_range_that_the_cells_choose_is_no_mistake(self):
        tip = rc.Body(rc.ParaboloidSurface(1e-6), rc.Elastic(1e7, 0.49))
        problem = rc.ContactProblem(tip, grid=rc.Grid((48, 64), 3e-6), adhesion=rc.ShortRange(0.05))
        solution = problem.solve(force=0.0)
        assert not [text for text in solution.warnings if text.rule == "cohesive length"]
        assert not problem.plan.warnings
        assert not problem.pull_off().warnings
        limit = (4.5 * math.pi * 0.05 * 1e-12 / problem.plan.modulus) ** (1 / 3)
        area = solution.area()
        assert abs(area.value - math.pi * limit**2) < 2.0 * area.uncertainty

    @pytest.mark.parametrize(("range_", "words"), [("0.2nm", "by a factor of about"), ("0.9nm", "% off")])
    def test_the_warning_of_a_short_range_says_how_much(self, range_, words):
        tip = rc.Body(rc.ParaboloidSurface(1e-6), rc.Elastic(1e9, 0.3))
        law = rc.Exponential("50mJ/m2", range_)
        problem = rc.ContactProblem(tip, grid=rc.Grid((32, 32), 300e-9), adhesion=law)
        assert any(words in text for text in problem.plan.warnings)

    @pytest.mark.parametrize("shape", [(24, 24), (30, 30), (36, 24)])
    def test_no_less_than_what_is_cut_off_is_counted(self, shape):
        tip = rc.Body(rc.ParaboloidSurface(1e-6), rc.Elastic(70e9, 0.3))
        size = (shape[0] * 5e-9, shape[1] * 5e-9)
        for law in (rc.Exponential(0.05, 5e-9), rc.VanDerWaals(0.05, 3e-9)):
            found = rc.ContactProblem(tip, grid=rc.Grid(shape, size), adhesion=law).pull_off()
            # All of it is 2 pi w R.
            assert abs(found.value + 2.0 * math.pi * 0.05 * 1e-6) < 2.0 * found.uncertainty
            assert found.uncertainty <= abs(found.value)

    def test_a_patch_at_the_border_of_a_rough_surface_hides_no_more_than_the_force(self):
        problem = press_rough(SURFACES[102], (33, 29), 1.0, "free", 0.13)
        found = problem.pull_off()
        assert "border tension" in [text.rule for text in found.warnings]
        assert found.uncertainty <= 2.0 * abs(found.value)


# Longest and shortest wave of rough surfaces of slope 0.1, in cells, and their Hurst exponent.
SURFACES = {102: (27.0, 9.0, 0.8), 7: (24.0, 8.0, 0.6), 8: (30.0, 6.0, 0.9)}


def press_rough(waves, shape, ratio, boundary, work, seed=102, law=rc.ShortRange):
    """Return a problem of a rough surface on cells of 1 : ratio, and a law of a work of adhesion, in hundredths."""
    longest, shortest, hurst = waves
    surface = rc.SelfAffineSurface(hurst=hurst, rms_slope=0.1, shortest=shortest, longest=longest, seed=seed)
    grid = rc.Grid(shape, (float(shape[0]), ratio * shape[1]))
    body = rc.Body(surface, rc.Elastic(1.0, 0.0))
    return rc.ContactProblem(body, grid=grid, boundary=boundary, adhesion=law(0.01 * work), threads=1)


def follow_finely(problem, step):
    """Return the lowest force on a path of short steps from zero load, until the attraction cannot pull lower."""
    state = problem.solve(pressure=0.0)
    lowest = 0.0
    while float(state.tension.sum()) * problem.grid.cell_area > -lowest:
        state = problem.sweep(approach=[state.approach, state.approach - step])[-1]
        lowest = min(lowest, state.force)
    return lowest


class TestRoughPullOff:
    @pytest.mark.parametrize(("ratio", "shape"), [(1.0, (24, 31)), (3.0, (31, 9)), (1 / 3, (27, 72))])
    @pytest.mark.parametrize("seed", rather_slow([3, 4, 5], [3]))
    def test_no_summit_that_holds_later_is_missed(self, ratio, shape, seed):
        law = partial(rc.Exponential, range=0.1)
        problem = press_rough(SURFACES[8], shape, ratio, "periodic", 0.1, seed, law)
        found = problem.pull_off()
        lowest = follow_finely(problem, 0.01 * np.ptp(problem.initial_gap))
        assert found.value <= lowest * (1.0 - 2e-3)

    @pytest.mark.slow
    @pytest.mark.parametrize(("ratio", "shape"), [(1.0, (27, 24)), (3.0, (32, 11)), (1 / 3, (21, 64))])
    def test_a_short_range_is_as_uncertain_as_unlike_summits_make_it(self, ratio, shape):
        waves = SURFACES[7] if ratio <= 1.0 else (36.0, 24.0, 0.6)
        coarse = press_rough(waves, shape, ratio, "periodic", 0.2).pull_off()
        fine = press_rough(waves, tuple(4 * n for n in shape), ratio, "periodic", 0.2)
        fine = attrs.evolve(fine, grid=rc.Grid(fine.grid.shape, (float(shape[0]), ratio * shape[1]))).pull_off()
        assert coarse.value < 0.0
        assert 0.1 < coarse.uncertainty / abs(coarse.value) < 1.0
        assert abs(coarse.value - fine.value) < 2.0 * math.hypot(coarse.uncertainty, fine.uncertainty)

    def test_a_cycle_knows_that_its_range_is_no_limit(self):
        tip = rc.Body(rc.ParaboloidSurface(1e-6, (3e-9, 8e-9)), rc.Elastic(1e7, 0.49))
        problem = rc.ContactProblem(tip, grid=rc.Grid((32, 48), 3e-6), adhesion=rc.ShortRange(0.05))
        approach = np.linspace(-4e-7, 2e-8, 9)
        found = problem.cycle(approach=approach).pull_off
        alone = attrs.evolve(problem, adhesion=problem.plan.interaction).cycle(approach=approach).pull_off
        limit = -1.5 * math.pi * 0.05 * 1e-6
        assert found.value == alone.value
        assert found.value < 1.02 * limit
        assert abs(found.value - limit) < 2.0 * math.sqrt(found.uncertainty**2 - alone.uncertainty**2)

    @pytest.mark.slow
    @pytest.mark.parametrize("ratio", [1.0, 1 / 3])
    def test_a_sharp_law_sticks_more_than_its_cohesive_length_says(self, ratio):
        random = np.random.default_rng(13)
        errors = []
        for smoothing in (0.05, 0.05, 0.1, 0.1, 0.1, 0.1):
            strength = 0.45 * 0.5 * (math.pi * 0.05 * (16 / 9) * 1e18 / 1e-6) ** (1 / 3)
            law = rc.Dugdale(0.05, strength, smoothing)
            cell = law.cohesive_cells((1.0, 1.0), 1e9) / random.uniform(2.6, 3.4)
            side = 2.0 * 1.4 * (4.5 * math.pi * 0.05 * 1e-12 / 1e9) ** (1 / 3)
            shape = (math.ceil(side / cell), math.ceil(side / cell / ratio))
            place = random.uniform(-0.5, 0.5, 2) * cell
            tip = rc.Body(rc.ParaboloidSurface(1e-6, tuple(place)), rc.Elastic(1e9, 0.0))
            grid = rc.Grid(shape, (shape[0] * cell, shape[1] * cell * ratio))
            found = rc.ContactProblem(tip, grid=grid, adhesion=law).pull_off()
            exact = MaugisDugdale(1e-6, 1e9, 0.05, strength).pull_off
            errors.append(abs(found.value - exact) / math.hypot(found.uncertainty, 5e-4 * exact))
        assert np.sum(np.array(errors) < 2.0) >= 5
