"""A process that is solved with the contact: springs under each cell, which a local compliance solves too."""

from typing import ClassVar

import attrs
import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Elastic(young=210e9, poisson=0.3)
GRID = rc.Grid((24, 20), (100e-6, 90e-6))
COMPLIANCE = 2e-17


@attrs.frozen
class Compliance(rc.Law):
    """Springs under each cell, m/Pa."""

    value: float = attrs.field(default=COMPLIANCE, metadata={"unit": "m/Pa"})

    def change_gap(self, problem, increment, memory):
        return np.zeros(problem.plan.grid.shape)

    def find_local_compliance(self, problem, increment, memory):
        return self.value


@rc.laws.register("test-springs")
@attrs.frozen
class Springs(rc.CoupledProcess):
    """The same springs, found by contacts in turn, two layers of them."""

    value: float = attrs.field(default=COMPLIANCE, metadata={"unit": "m/Pa"})
    parts: tuple[float, ...] = (1.0,)
    remembered: ClassVar = {
        "layers": ("deflection of each layer", "m"),
        "deflection": ("deflection of the springs", "m"),
    }
    of_material: ClassVar = True

    def start(self, problem):
        shape = problem.plan.grid.shape
        return {"layers": np.zeros((2, *shape)), "deflection": np.zeros(shape)}

    def change_gap(self, problem, increment, memory):
        return memory["layers"].sum(axis=0)

    def settle(self, problem, press, increment, memory):
        offset = self.change_gap(problem, increment, memory)
        for part in self.parts:
            for _ in range(60):
                found = press(offset, part=part, tolerance=1e-8)
                offset = offset + 0.5 * (self.value * found.pressure - offset)
        layers = np.stack([0.25 * offset, 0.75 * offset])
        return {"layers": layers, "deflection": layers.sum(axis=0)}

    def judge(self, problem, state, increment, before, after):
        error = np.abs(self.value * state.pressure - after["layers"].sum(axis=0)).max()
        scale = self.value * state.pressure.max() or 1.0
        yield rc.results.Condition("springs", error / scale, "error of the deflection over the largest", tolerance=1e-3)


@rc.materials.register("test-bedded")
@attrs.frozen
class Bedded(rc.Material):
    """Steel on springs."""

    softness: float = attrs.field(default=COMPLIANCE, metadata={"unit": "m/Pa"})
    compliance = STEEL.compliance
    pressure_limit = np.inf

    def bring_laws(self, side):
        return (Springs(self.softness),)


def press(*laws, material=STEEL, **others):
    ball = rc.Body(rc.SphereSurface(radius=1e-3), material)
    return rc.ContactProblem(ball, grid=GRID, laws=laws, **others)


def test_springs_are_those_of_a_local_compliance():
    careful = rc.ProjectedConjugateGradient(tolerance=1e-8)
    found = press(material=Bedded(), solver=careful).solve(force=2.0)
    other = press(Compliance(), solver=careful).solve(force=2.0)
    np.testing.assert_allclose(found.pressure, other.pressure, atol=1e-5 * other.pressure.max())
    assert found.approach == pytest.approx(other.approach, rel=1e-6)
    assert found.certificate["springs"].residual < 1e-5
    assert found.convolutions > 60


@pytest.mark.parametrize("kind", ["force", "approach"])
def test_a_part_of_an_increment_begins_at_the_state_before(kind):
    """The last contact alone decides, whatever the parts on the way: its load is the one given."""
    loads = [1.0, 3.0, 0.0, 2.0] if kind == "force" else [0.4e-6, 0.6e-6, 0.0, 0.5e-6]
    seen = []

    class Halves(Springs):
        def settle(self, problem, press, increment, memory):
            seen.extend([press(self.change_gap(problem, increment, memory), part=0.5)])
            return super().settle(problem, press, increment, memory)

    problem = attrs.evolve(press(material=Bedded()), body=rc.Body(rc.SphereSurface(radius=1e-3), Bedded()))
    object.__setattr__(problem, "laws", (Halves(),))
    path = problem.path(**{kind: loads})
    middle = [getattr(one, kind) for one in seen]
    np.testing.assert_allclose(middle, [0.5 * (a + b) for a, b in zip([0.0, *loads], loads, strict=False)], rtol=1e-9)
    np.testing.assert_allclose(getattr(path, kind), loads, rtol=1e-9)
    assert path[2].force == 0.0
    assert path[2].certificate.error < 1e-4


@pytest.mark.parametrize("ending", ["npz", "nc"])
def test_a_memory_of_any_shape_is_saved_and_verified(tmp_path, ending):
    if ending == "nc":
        pytest.importorskip("h5netcdf")
    state = press(material=Bedded()).path(force=[2.0, 1.0])[-1]
    file = tmp_path / f"state.{ending}"
    state.save(file)
    again = rc.ContactSolution.load(file)
    assert again.certificate == state.certificate
    assert again.added[0].memory[0]["layers"].shape == (2, *GRID.shape)
    assert set(again.added[0].list_fields()) == {"deflection"}
    np.testing.assert_array_equal(again.pressure, state.pressure)


def test_a_memory_that_does_not_fit_the_pressure_is_refused():
    state = press(material=Bedded()).solve(force=2.0)
    effect = state.added[0]
    layers = 1.01 * effect.memory[0]["layers"]
    wrong = attrs.evolve(effect, memory=({"layers": layers, "deflection": layers.sum(axis=0)},))
    with pytest.raises(rc.InputError, match="Its springs is violated"):
        state._add(wrong).verify()


def test_a_state_whose_condition_does_not_hold_is_not_solved():
    """One turn is too few, which the contact itself does not show."""

    class Hasty(Springs):
        def settle(self, problem, press, increment, memory):
            layers = np.stack([0.5 * self.value * press(memory["deflection"]).pressure] * 2)
            return {"layers": layers, "deflection": layers.sum(axis=0)}

    problem = press(material=Bedded())
    object.__setattr__(problem, "laws", (Hasty(),))
    state = problem.solve(force=2.0, throw=False)
    assert state.status is rc.Status.UNCONFIRMED
    assert state.residuals.error < 1e-5
    assert state.certificate["springs"].residual > 0.01
    with pytest.raises(rc.NotConverged, match="springs"):
        problem.solve(force=2.0)


def test_what_it_returns_is_checked():
    class Loud(Springs):
        def settle(self, problem, press, increment, memory):
            return {"layers": np.full((2, 2), np.nan), "deflection": memory["deflection"]}

    problem = press(material=Bedded())
    object.__setattr__(problem, "laws", (Loud(),))
    with pytest.raises(rc.InputError, match="must be finite numbers"):
        problem.solve(force=1.0)


def test_a_material_brings_its_law_and_no_other_one():
    problem = press(material=Bedded(1e-17))
    assert problem.laws == (Springs(1e-17),)
    softer = attrs.evolve(problem, body=rc.Body(rc.SphereSurface(radius=1e-3), Bedded(3e-17)))
    assert softer.laws == (Springs(3e-17),)
    assert rc.ContactProblem(**softer.parts).laws == softer.laws
    with pytest.raises(rc.InputError, match="one that a material brings"):
        press(Springs())


def test_materials_of_both_bodies_bring_a_process_that_joins():
    class Joined(Springs):
        def join(self, other):
            return Joined(self.value + other.value)

    class Both(Bedded):
        def bring_laws(self, side):
            return (Joined(self.softness),)

    ball = rc.Body(rc.SphereSurface(radius=1e-3), Both(3e-17))
    problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), Both(1e-17)), grid=GRID)
    assert problem.laws == (Joined(4e-17),)
    alone = attrs.evolve(problem, counterbody=rc.Body(rc.FlatSurface(), STEEL))
    assert alone.laws == (Joined(3e-17),)
    assert rc.ContactProblem(**problem.parts).laws == problem.laws


@pytest.mark.parametrize(
    ("others", "sentence"),
    [
        ({"adhesion": rc.Exponential(work=0.05, range=20e-9)}, "is not solved with adhesion"),
        ({"laws": (Compliance(),)}, "is alone in changing it"),
        ({"counterbody": rc.Body(rc.FlatSurface(), Bedded(1e-18))}, "is alone in changing it"),
    ],
)
def test_what_is_not_solved_with_it_is_refused(others, sentence):
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(radius=1e-3), Bedded()), grid=GRID, **others)
    with pytest.raises(rc.InputError, match=sentence):
        problem.solve(force=1.0)


@attrs.frozen
class Buried(rc.Process):
    """A law that has changed what lies below a surface and its heights, and knows the error of an answer."""

    limits: tuple[str, ...] = ()
    remembered: ClassVar = {"loss": ("height lost", "m")}
    left_behind: ClassVar = "what is buried"

    def change_gap(self, problem, increment, memory):
        return memory["loss"]

    def remember(self, state, increment, memory):
        return {"loss": memory["loss"] + 1e-8 * (state.pressure > 0.0)}

    def divide(self, problem, memory):
        return memory["loss"], 0.0

    def list_errors(self, state, memory):
        return {"peak-pressure": 1e8}

    def explain_limits(self, memory):
        return dict.fromkeys(self.limits, "something is buried there")


@pytest.mark.parametrize(
    ("limit", "refused", "answered"),
    [
        ("inner stress", ["stress", "first-yield"], ["stiffness", "tangential-stiffness"]),
        ("inner flow", ["stiffness", "tangential-stiffness", "gradient"], ["stress", "unloading"]),
        ("inner moduli", ["stiffness", "tangential-stiffness", "gradient", "unloading"], ["stress"]),
    ],
)
def test_answers_are_refused_that_do_not_know_what_a_law_does_below(limit, refused, answered):
    asked = {
        "stress": rc.responses.create("stress", [1e-5]),
        "first-yield": rc.responses.create("first-yield", "1GPa"),
        "stiffness": rc.responses.create("stiffness"),
        "unloading": rc.responses.create("stiffness", unloading=True),
        "tangential-stiffness": rc.responses.create("tangential-stiffness"),
        "gradient": rc.responses.create("gradient", "approach"),
    }
    state = press(Buried((limit,))).solve(force=2.0)
    plain = press(Buried()).solve(force=2.0)
    for name in refused:
        with pytest.raises(rc.InputError, match="is not known for this contact: something is buried there"):
            state.response(asked[name])
    for name in answered:
        assert str(state.response(asked[name])) == str(plain.response(asked[name]))


def test_a_law_adds_its_errors_to_the_uncertainty():
    state = press(Buried()).solve(force=2.0)
    plain = press().solve(force=2.0).peak_pressure()
    assert state.peak_pressure().uncertainty == pytest.approx(np.hypot(plain.uncertainty, 1e8), rel=1e-6)
    assert state.response("patches").uncertainty == press().solve(force=2.0).response("patches").uncertainty


def test_bodies_warn_of_what_is_not_in_their_heights():
    path = press(Buried()).path(force=[2.0, 0.0])
    with pytest.warns(rc.ContactWarning, match="but not what is buried: extend the path"):
        body, _ = path.bodies
    assert body.heights(GRID).min() < 0.0
