"""Gradients: against differences of full solves, in closed form, and what is refused."""

from __future__ import annotations

import math
import warnings

import attrs
import numpy as np
import pytest

import roughcontact as rc
from scenes import rather_slow

BOUNDARIES = ("free", "periodic", "wrapped")
NUMBERS = ("own", "force", "approach", "mean-gap", "participation")
MODULUS = 1e11
BALL = rc.Elastic(MODULUS, 0.0)


@attrs.frozen(eq=False)
class Scene:
    """A random rough surface, on a random grid, and the load and the direction of its change."""

    heights: np.ndarray
    size: tuple[float, float]
    boundary: str
    hardness: float
    pressure: float
    direction: np.ndarray
    weights: np.ndarray

    @classmethod
    def draw(cls, seed):
        rng = np.random.default_rng(seed)
        shape = tuple(rng.integers(16, 28, 2))
        size = tuple(n * 1e-6 * rng.uniform(0.7, 1.4) for n in shape)
        waves = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1]))
        waves[0, 0] = 1.0
        noise = np.fft.rfft2(rng.normal(size=shape)) * np.where(waves < 0.25, waves**-1.2, 0.0)
        heights = np.fft.irfft2(noise, s=shape)
        heights *= 1e-7 / heights.std()
        slope = np.std(np.hypot(*np.gradient(heights, size[0] / shape[0], size[1] / shape[1])))
        pressure = rng.uniform(0.03, 0.4) * MODULUS * slope
        direction, weights = 1e-7 * rng.normal(size=shape), rng.normal(size=shape)
        scene = cls(heights, size, BOUNDARIES[seed % 3], math.inf, pressure, direction, weights)
        if seed // 3 % 2:
            hardness = max(0.5 * scene.solve(pressure=pressure).pressure.max(), 2.5 * pressure)
            scene = attrs.evolve(scene, hardness=hardness)
        return scene

    def solve(self, change=0.0, modulus=MODULUS, **load):
        capped = math.isfinite(self.hardness)
        material = rc.ElasticPerfectlyPlastic(modulus, 0.0, self.hardness) if capped else rc.Elastic(modulus, 0.0)
        surface = rc.HeightMap(self.heights + change, size=self.size, periodic=self.boundary != "free")
        solver = rc.ProjectedConjugateGradient(tolerance=1e-12)
        problem = rc.ContactProblem(rc.Body(surface, material), boundary=self.boundary, solver=solver, threads=1)
        return problem.solve(**load)

    def measure(self, solution, name):
        pressure, cell = solution.pressure, solution.grid.cell_area
        match name:
            case "own":
                return float(np.sum(self.weights * pressure**2))
            case "force" | "approach":
                return getattr(solution, name)
            case "mean-gap":
                return float(solution.gap.mean())
            case "participation":
                return float(9 / 8 * cell * pressure.sum() ** 2 / np.sum(pressure**2))

    def differentiate(self, solution, name, *with_respect_to):
        of = (lambda pressure: 2.0 * self.weights * pressure) if name == "own" else name
        return solution.gradient(of, *with_respect_to)


def is_same_set(one, other):
    summits = (np.argmin(each.initial_gap) for each in (one, other))
    contact, saturated = (np.array_equal(getattr(one, k), getattr(other, k)) for k in ("contact", "saturated"))
    return contact and saturated and len(set(summits)) == 1


def find_ends(solve, middle):
    """Return the largest step at which both ends have the same cells in contact as the middle, and the ends."""
    for step in (1e-5, 1e-6, 1e-7):
        ends = [solve(sign * step) for sign in (1, -1)]
        if all(is_same_set(middle, end) for end in ends):
            return step, ends
    return None


def compare(seeds):
    """Return the errors of the gradients along a random direction of the heights, over their size, by number."""
    errors, without = [], 0
    for seed in seeds:
        scene = Scene.draw(seed)
        middle = scene.solve(pressure=scene.pressure)
        for load in ({"pressure": scene.pressure}, {"approach": middle.approach}):
            middle = scene.solve(**load)
            found = find_ends(lambda step, scene=scene, load=load: scene.solve(step * scene.direction, **load), middle)
            if found is None:
                without += 1
                continue
            step, ends = found
            for name in NUMBERS:
                parts = scene.differentiate(middle, name) * scene.direction
                one, other = (scene.measure(end, name) for end in ends)
                # White noise, whose effects add up as a random walk; where nothing changes, the number itself.
                size = max(math.sqrt(np.sum(parts**2)), 1e-3 * abs(one))
                errors.append(abs((one - other) / (2 * step) - parts.sum()) / size)
    assert without <= len(seeds) // 4
    return errors


@pytest.mark.slow
def test_gradients_are_differences_of_solves_on_fifty_scenes():
    assert max(compare(range(100, 150))) < 1e-6


@pytest.mark.parametrize("seed", rather_slow(range(3), [0]))
@pytest.mark.parametrize("kind", ["pressure", "force", "approach"])
def test_modulus_and_load(kind, seed):
    scene = Scene.draw(200 + seed)
    middle = scene.solve(pressure=scene.pressure)
    value = {"pressure": scene.pressure, "force": middle.force, "approach": middle.approach}[kind]
    middle = scene.solve(**{kind: value})
    cases = {
        "modulus": (MODULUS, lambda step: scene.solve(modulus=MODULUS * (1 + step), **{kind: value})),
        "load": (value, lambda step: scene.solve(**{kind: value * (1 + step)})),
    }
    for variable, (unit, solve) in cases.items():
        step, ends = find_ends(solve, middle)
        for name in NUMBERS:
            one, other = (scene.measure(end, name) for end in ends)
            found = scene.differentiate(middle, name, variable)
            assert found.shape == ()
            size = max(abs(found * unit), 1e-3 * abs(one))
            assert abs((one - other) / (2 * step) - found * unit) < 1e-6 * size, (variable, name)


def press_ball(cells=8, place=(0.2, -0.3), **load):
    ball = rc.Body(rc.ParaboloidSurface(1e-2, np.multiply(place, 1e-6)), BALL)
    problem = rc.ContactProblem(ball, grid=rc.Grid((4 * cells, 4 * cells), 4e-6 * cells), threads=1)
    return problem.solve(**(load or {"approach": (cells * 1e-6) ** 2 / 1e-2}))


def test_closed_forms_of_a_ball():
    solution = press_ball(12)
    force, approach = solution.force, solution.approach
    # F ~ E* approach^(3/2).
    assert solution.gradient("force", "modulus") == pytest.approx(force / MODULUS, rel=1e-3)
    assert solution.gradient("force", "load") == pytest.approx(1.5 * force / approach, rel=3e-3)
    assert solution.gradient("participation", "load") == pytest.approx(math.pi * 1e-2, rel=3e-2)
    # Both bodies raised and brought apart as much: nothing changes but the count from the highest cell.
    assert abs(solution.gradient("force").sum()) < 1e-8 * np.abs(solution.gradient("force")).sum()
    under_force = press_ball(12, force=force)
    assert under_force.gradient("approach", "load") == pytest.approx(approach / (1.5 * force), rel=3e-3)
    assert under_force.gradient("approach", "modulus") == pytest.approx(-approach / MODULUS / 1.5, rel=3e-3)


def test_area_of_separate_summits():
    for place in np.random.default_rng(0).uniform(-0.5, 0.5, (4, 2)):
        # Hertz: dA / d(approach) = pi R.
        assert press_ball(6, place).gradient("area", "load") == pytest.approx(math.pi * 1e-2, rel=0.03)


def test_area_of_a_ball_under_a_given_load():
    # Hertz: A = pi (3 F R / 4 E*)^(2/3).
    solution = press_ball(8, force=press_ball(8).force)
    area = solution.area().value
    assert solution.gradient("area", "modulus") == pytest.approx(-2 * area / (3 * MODULUS), rel=1e-6)
    assert solution.gradient("area", "load") == pytest.approx(2 * area / (3 * solution.force), rel=1e-6)
    assert abs(press_ball(8).gradient("area", "modulus")) < 0.02 * area / MODULUS
    with pytest.warns(UserWarning, match="even its sign may be wrong"):
        by_heights = solution.gradient("area")
    grid = solution.grid
    radius = np.hypot(grid.x - 0.2e-6, grid.y + 0.3e-6)
    # A tip r^2 / 2R + c r^4 carries F = 4 E* a^3 / 3R + 64 E* c a^5 / 15 (Sneddon).
    assert np.sum(by_heights * radius**2) == pytest.approx(4 * area * 1e-2 / 3, rel=2e-3)
    assert np.sum(by_heights * radius**4) == pytest.approx(32 / 15 * area**2 * 1e-2 / math.pi, rel=0.02)
    assert abs(np.sum(by_heights * grid.x)) < 1e-9 * area


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_area_depends_on_load_over_modulus(boundary):
    heights = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=12e-6, longest=48e-6, seed=3).heights(
        rc.Grid((48, 45), (48e-6, 90e-6))
    )

    def solve(heights, size):
        body = rc.Body(rc.HeightMap(heights, size=size, periodic=boundary == "periodic"), BALL)
        return rc.ContactProblem(body, boundary=boundary, threads=1).solve(pressure=2e-3 * MODULUS)

    solution = solve(heights, (48e-6, 90e-6))
    assert solution.patches.count > 3
    by_modulus, by_load = (solution.gradient("area", name) for name in ("modulus", "load"))
    assert by_modulus * MODULUS == pytest.approx(-by_load * solution.mean_pressure, rel=1e-5)
    with pytest.warns(UserWarning, match="sign"):
        one, turned = (found.gradient("area") for found in (solution, solve(heights[::-1].T, (90e-6, 48e-6))))
    np.testing.assert_allclose(turned, one[::-1].T, atol=2e-3 * np.abs(one).max())
    if boundary == "periodic":
        with pytest.warns(UserWarning, match="sign"):
            moved = solve(np.roll(heights, (20, 31), (0, 1)), (48e-6, 90e-6)).gradient("area")
        np.testing.assert_allclose(moved, np.roll(one, (20, 31), (0, 1)), atol=2e-3 * np.abs(one).max())


def test_area_under_a_given_load_says_what_it_is_worth():
    scene = Scene.draw(4)
    solution = scene.solve(pressure=scene.pressure)
    assert solution.patches.count > 1
    with pytest.warns(UserWarning, match="even its sign may be wrong"):
        gradient = solution.gradient("area")
    # What raises all heights changes nothing.
    assert abs(gradient.sum()) < 1e-8 * np.abs(gradient).sum()


def test_full_contact():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.01, shortest=8e-6, longest=32e-6, seed=1)
    problem = rc.ContactProblem(rc.Body(surface, BALL), grid=rc.Grid((32, 32), 32e-6), boundary="periodic", threads=1)
    solution = problem.solve(pressure=0.1 * MODULUS)
    assert solution.contact.all()
    # The gap is closed, and the pressure is the mean one plus that of the heights: J = sum p^2 = n p^2 + ...
    assert np.abs(solution.gradient("mean-gap")).max() < 1e-15
    assert solution.gradient("mean-gap", "load") == 0.0
    by_load = solution.gradient(lambda pressure: 2 * pressure, "load")
    assert by_load == pytest.approx(2 * 1024 * solution.mean_pressure)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert not solution.gradient("area").any()


def test_scales_change_nothing_else():
    def solve(longer, stiffer):
        heights = longer * 1e-7 * np.random.default_rng(0).normal(size=(16, 20))
        body = rc.Body(rc.HeightMap(heights, size=(16e-6 * longer, 30e-6 * longer)), rc.Elastic(1e9 * stiffer, 0.0))
        return rc.ContactProblem(body, threads=1).solve(pressure=1e7 * stiffer)

    one, other = solve(1.0, 1.0), solve(2.0**30, 2.0**-12)
    assert np.array_equal(other.gradient("approach"), one.gradient("approach"))
    assert np.array_equal(other.gradient("participation"), one.gradient("participation") * 2.0**30)
    assert other.gradient("approach", "load") == one.gradient("approach", "load") * 2.0**42


def test_what_is_refused():
    solution = press_ball()
    for of, words in (
        ("stiffness", "take the difference of two solves"),
        ("conductance", "take the difference of two solves"),
        ("mean gap", "Did you mean 'mean-gap'"),
        (None, "a name or a function"),
        (lambda: 1.0, "a function of 1 argument, pressure"),
        (lambda pressure: pressure[1:], "finite numbers of shape"),
        (lambda pressure: np.nan * pressure, "finite numbers of shape"),
        (lambda pressure: "x", "finite numbers of shape"),
    ):
        with pytest.raises(rc.InputError, match=words):
            solution.gradient(of)
    with pytest.raises(rc.InputError, match="with_respect_to="):
        solution.gradient("force", "hardness")
    with pytest.raises(rc.InputError, match="does not say which problem"):
        attrs.evolve(solution, origin=None).gradient("force")
    # An error in a user's function passes as it is.
    with pytest.raises(ZeroDivisionError):
        solution.gradient(lambda pressure: pressure / (1 // 0))
    soft = rc.Body(rc.WavySurface(1e-6, 1e-5), rc.ElasticPerfectlyPlastic(MODULUS, 0.0, 1e6))
    saturated = rc.ContactProblem(soft, grid=rc.Grid((8, 8), 1e-5), threads=1).solve(pressure=1e6)
    with pytest.raises(rc.InputError, match="All cells in contact are at the pressure limit"):
        saturated.gradient("approach")


def test_non_measured_points_have_no_gradient():
    mask = np.zeros((16, 16), dtype=bool)
    mask[3:9, 4:12] = True
    surface = rc.HeightMap(1e-7 * np.random.default_rng(2).normal(size=(16, 16)), size=16e-6, non_measured=mask)
    solution = rc.ContactProblem(rc.Body(surface, BALL), threads=1).solve(pressure=1e8)
    for name in ("approach", "participation"):
        assert not solution.gradient(name)[mask].any()
    with pytest.raises(rc.InputError, match="not measured"):
        solution.gradient("mean-gap")
