"""Stiffness and gradients with adhesion: beside differences of solves, the kernel, Maugis, and without adhesion."""

import math

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.errors import InputError
from roughcontact.reference import MaugisDugdale

MODULUS = 1e9
SOFT = rc.Elastic(young=0.75 * MODULUS, poisson=0.5)
HARD = rc.ElasticPerfectlyPlastic(young=0.75 * MODULUS, poisson=0.5, hardness=60e6)
LAWS = (rc.Exponential(0.02, 6e-9), rc.Dugdale(0.02, 6e6), rc.VanDerWaals(0.02, 1e-8))
NUMBERS = ("own", "force", "approach", "mean-gap", "participation")
SQUARE = ((24, 24), (1e-6, 1e-6))
SHAPES = [SQUARE, ((27, 25), (1e-6, 1e-6)), ((32, 16), (2e-6, 1e-6)), ((30, 10), (1e-6, 1e-6))]
NAMES = ["square", "odd", "2 to 1", "cells 1 to 3"]
APPROACH = {"approach": 3e-9}
PRESSURE = {"pressure": 5e6}


@attrs.frozen(eq=False)
class Scene:
    """A rough surface and its law, solved far beyond the default tolerance."""

    boundary: str = "periodic"
    law: rc.Interaction | None = LAWS[0]
    material: rc.Elastic = SOFT
    shape: tuple[int, int] = SQUARE[0]
    size: tuple[float, float] = SQUARE[1]

    @property
    def heights(self):
        surface = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-8, longest=1e-6, shortest=2e-7, seed=3)
        return surface.heights(rc.Grid(self.shape, self.size))

    def solve(self, change=0.0, start=None, **load):
        heights = rc.HeightMap(self.heights + change, self.size, periodic=self.boundary != "free")
        solver = rc.ProjectedConjugateGradient() if self.law is None else rc.GapDescent()
        problem = rc.ContactProblem(
            rc.Body(heights, self.material), boundary=self.boundary, adhesion=self.law, solver=solver, threads=1
        )
        return problem.solve(**load, tolerance=1e-11, start=start)

    @property
    def weights(self):
        return np.random.default_rng(1).normal(size=self.shape)

    def measure(self, solution, name):
        match name:
            case "own":
                return float(np.sum(self.weights * solution.pressure**2))
            case "mean-gap":
                return float(solution.gap.mean())
            case "participation":
                contact = solution.contact_pressure
                return float(9 / 8 * solution.grid.cell_area * contact.sum() ** 2 / np.sum(contact**2))
            case _:
                return getattr(solution, name)

    def differentiate(self, solution, name, *with_respect_to):
        of = (lambda pressure: 2.0 * self.weights * pressure) if name == "own" else name
        return solution.gradient(of, *with_respect_to)


def find_ends(solve, middle):
    """Return the longest of some steps at whose ends the cells in contact are those of the middle, and the ends."""
    for step in (1e-3, 1e-4, 1e-5, 1e-6):
        ends = [solve(sign * step) for sign in (1, -1)]
        if all(np.array_equal(getattr(end, k), getattr(middle, k)) for end in ends for k in ("contact", "saturated")):
            return step, ends
    raise AssertionError("the contact changes at each step")


def check_gradients(scene, load, names=NUMBERS):
    """Compare derivatives along a random direction of the heights, and by the load, with differences of solves."""
    direction = 1e-9 * np.random.default_rng(0).normal(size=scene.shape)
    middle = scene.solve(**load)
    ((kind, value),) = load.items()
    step, ends = find_ends(lambda step: scene.solve(step * direction, middle.pressure, **load), middle)
    of_load, by_load = find_ends(lambda step: scene.solve(0.0, middle.pressure, **{kind: value * (1 + step)}), middle)
    for name in names:
        one, other = (scene.measure(end, name) for end in ends)
        parts = scene.differentiate(middle, name) * direction
        # White noise, whose effects add up as a random walk; where nothing changes, the number itself.
        size = max(math.sqrt(np.sum(parts**2)), 1e-3 * abs(one))
        assert abs((one - other) / (2 * step) - parts.sum()) < 1e-5 * size, name
        one, other = (scene.measure(end, name) for end in by_load)
        found = value * float(scene.differentiate(middle, name, "load"))
        size = max(abs(found), 1e-3 * abs(one))
        assert abs((one - other) / (2 * of_load) - found) < 1e-5 * size, name


class TestGradients:
    """Derivatives by heights, load and modulus against differences of full solves."""

    @pytest.mark.parametrize("load", [APPROACH, PRESSURE], ids=["approach", "pressure"])
    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    @pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
    def test_laws(self, law, boundary, load):
        check_gradients(Scene(boundary, law), load)

    @pytest.mark.parametrize("load", [APPROACH, PRESSURE], ids=["approach", "pressure"])
    @pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
    def test_hardness(self, boundary, load):
        scene = Scene(boundary, material=HARD)
        assert scene.solve(**load).saturated.any()
        check_gradients(scene, load)

    @pytest.mark.parametrize("boundary", ["free", "periodic"])
    @pytest.mark.parametrize(("shape", "size"), SHAPES[1:], ids=NAMES[1:])
    def test_shapes(self, shape, size, boundary):
        check_gradients(Scene(boundary, shape=shape, size=size), APPROACH, ("own", "force"))

    def test_tensile_load(self):
        check_gradients(Scene("periodic", rc.Exponential(0.05, 6e-9)), {"pressure": -1e5})

    def test_before_the_first_touch(self):
        scene = Scene("free")
        assert not scene.solve(approach=-5e-9).contact.any()
        check_gradients(scene, {"approach": -5e-9}, ("own", "force", "mean-gap"))

    @pytest.mark.parametrize("load", [APPROACH, PRESSURE], ids=["approach", "pressure"])
    def test_modulus(self, load):
        def solve(step):
            material = rc.Elastic(SOFT.young * (1 + step), SOFT.poisson)
            return attrs.evolve(scene, material=material).solve(0.0, middle.pressure, **load)

        scene = Scene("free")
        middle = scene.solve(**load)
        step, ends = find_ends(solve, middle)
        for name in NUMBERS:
            one, other = (scene.measure(end, name) for end in ends)
            found = MODULUS * float(scene.differentiate(middle, name, "modulus"))
            assert abs((one - other) / (2 * step) - found) < 1e-5 * max(abs(found), 1e-3 * abs(one)), name

    def test_full_contact(self):
        solution = Scene().solve(pressure=3e8)
        assert solution.contact.all()
        assert np.abs(solution.gradient("mean-gap")).max() < 1e-12
        assert solution.stiffness().value == math.inf

    def test_transposed(self):
        scene = Scene("free", shape=(30, 10))
        turned = attrs.evolve(scene, shape=(10, 30))
        one = scene.solve(**PRESSURE)
        body = rc.Body(rc.HeightMap(scene.heights.T.copy(), scene.size[::-1]), SOFT)
        problem = rc.ContactProblem(body, adhesion=scene.law, threads=1)
        other = problem.solve(**PRESSURE, tolerance=1e-11)
        assert turned.shape == other.grid.shape
        np.testing.assert_allclose(
            other.gradient("approach").T, one.gradient("approach"), atol=1e-7 * np.abs(one.gradient("approach")).max()
        )
        assert other.stiffness().value == pytest.approx(one.stiffness().value, rel=1e-6)


class TestStiffness:
    """Normal stiffness beside neighbouring states, closed forms, and the contact without adhesion."""

    @pytest.mark.parametrize("load", [-1.0, 0.0, 2.0])
    def test_a_ball_of_maugis(self, load):
        # The ball and work are such that the transition parameter is 0.5.
        radius, work = 1e-6, 0.05
        strength = 0.25 * math.cbrt(math.pi * work * (4.0 / 3.0 * MODULUS) ** 2 / radius)
        theory = MaugisDugdale(radius, MODULUS, work, strength)
        force = load * math.pi * work * radius
        near = theory.contact_radius(force) * np.array([1.0 + 1e-4, 1.0 - 1e-4])
        forces, approaches = ([function(a) for a in near] for function in (theory.force, theory.approach))
        exact = (forces[0] - forces[1]) / (approaches[0] - approaches[1])
        for place in ((0.0, 0.0), (0.3, -0.2), (0.5, 0.1)):
            body = rc.Body(rc.ParaboloidSurface(radius, center=np.multiply(place, 7e-9)), SOFT)
            grid = rc.Grid((64, 64), 64 * 7e-9)
            problem = rc.ContactProblem(body, grid=grid, adhesion=rc.Dugdale(work, strength, 0.2), threads=1)
            found = problem.solve(force=force).stiffness()
            assert found.value == pytest.approx(exact, rel=0.03)
            assert abs(found.value - exact) < 3.0 * found.uncertainty
            assert found.uncertainty < 0.05 * exact

    def test_where_the_edge_sticks_to_the_cells_it_says_so(self):
        coarse, fine = (Scene("free", rc.Exponential(0.3, 1.2e-8), shape=(n, n)).solve(**APPROACH) for n in (16, 128))
        first, second = coarse.stiffness(), fine.stiffness()
        assert first.uncertainty > 4.0 * second.uncertainty
        assert abs(first.value - second.value) < 2.5 * math.hypot(first.uncertainty, second.uncertainty)

    def test_behind_pull_off_it_is_negative(self):
        path = BALL.sweep(approach=APPROACHES)
        lowest = int(path.force.argmin())
        assert path[lowest + 2].contact.any()
        values = [state.stiffness().value for state in (path[lowest - 2], path[lowest + 2])]
        assert values[0] > 0.0 > values[1]


def make_ball():
    body = rc.Body(rc.ParaboloidSurface(1e-6, center=(2e-9, 1e-9)), SOFT)
    return rc.ContactProblem(body, grid=rc.Grid((50, 50), 300e-9), adhesion=rc.Exponential(0.05, 1.5e-9), threads=1)


BALL = make_ball()
APPROACHES = np.linspace(0.0, -2.5e-9, 21)


class TestRefusals:
    """What is unstable or near a jump is said, and what does not carry over is refused."""

    def test_area(self):
        with pytest.raises(InputError, match="its edge is that of a crack"):
            Scene().solve(**APPROACH).gradient("area")

    def test_wrapped_stiffness(self):
        with pytest.raises(InputError, match="stiffness means nothing"):
            Scene("wrapped").solve(**APPROACH).stiffness()

    def test_separated(self):
        solution = Scene("free").solve(**APPROACH)
        apart = attrs.evolve(solution, status=rc.Status.SEPARATED)
        for ask in (apart.stiffness, apart.stability, lambda: apart.gradient("force")):
            with pytest.raises(InputError, match="have come apart"):
                ask()

    def test_unstable_at_an_approach(self):
        solution = Scene("free").solve(approach=-5e-9)
        stronger = attrs.evolve(solution.origin.source, adhesion=rc.Exponential(1.0, 6e-9))
        unstable = attrs.evolve(solution, origin=attrs.evolve(solution.origin, source=stronger))
        assert unstable.stability().value < 0.0
        for ask in (unstable.stiffness, lambda: unstable.gradient("force")):
            with pytest.raises(InputError, match="not stable at a given approach"):
                ask()

    def test_unstable_under_a_load(self):
        path = BALL.sweep(approach=APPROACHES)
        state = path[int(path.force.argmin()) + 2]
        loaded = attrs.evolve(state, origin=attrs.evolve(state.origin, load={"force": state.force}))
        assert np.isfinite(state.gradient("force")).all()
        with pytest.raises(InputError, match="Under a given load the state is not stable"):
            loaded.gradient("approach")

    def test_near_a_jump(self):
        lowest = BALL.pull_off().value
        path = BALL.sweep(force=np.array([0.0, 0.6, 0.9, 0.98, 0.999]) * lowest)
        assert not any("jump" in text for text in path[0].stability().warnings)
        assert any("jump" in text for text in path[-1].stability().warnings)
        with pytest.warns(UserWarning, match="close to a jump"):
            path[-1].gradient("approach", "load")
