"""The kit for plug-in authors: what ships passes it, and what is broken on purpose does not, by name of the claim."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
import pytest

import roughcontact as rc
import roughcontact.testing as kit
from roughcontact.__main__ import main
from roughcontact.typing import Outcome, PreparedConvolution, RawMap, ShearConvolution, ShearSolver
from unit_files import describe

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "plugins" / "roughcontact-example"
HARDNESS = np.linspace(1e8, 1e9, 120).reshape(12, 10)
(CAREFUL_SHEAR_CLASS,) = entry_points(group="roughcontact.shear_solvers", name="projected-cg")
CAREFUL_SHEAR = CAREFUL_SHEAR_CLASS.load()()
# Registered classes that cannot be made without arguments.
MADE = {
    "archard": [rc.Archard(1e-17)],
    "energy-wear": [rc.EnergyWear(1e-14)],
    "steady-sliding": [rc.SteadySliding(0.1, 30.0)],
    "relaxation": [rc.Relaxation(rc.Viscoelastic([2e11, 1e11], [1.0], 0.3))],
    "viscoelastic": [rc.Viscoelastic([1e9, 2e9], [1.0], 0.3)],
    "conductance": [rc.responses.create("conductance", (50.0, 20.0)), rc.responses.create("conductance", 1.0, 1e-9)],
    "leakage": [rc.responses.create("leakage", viscosity=1e-3, pressure_drop=1e5)],
    "elastic": [rc.Elastic(200e9, 0.3)],
    "elastic-perfectly-plastic": [rc.ElasticPerfectlyPlastic(2e11, 0.3, h) for h in (1e9, 1e5, HARDNESS)],
    "coulomb": [rc.Coulomb(0.3), rc.Coulomb(0.3 * HARDNESS / HARDNESS.max())],
    "dugdale": [rc.Dugdale(0.05, 1e7)],
    "exponential": [rc.Exponential(0.05, 2e-9), rc.Exponential(np.linspace(0.02, 0.05, 12).reshape(3, 4), 2e-9)],
    "first-yield": [rc.responses.create("first-yield", 1e9)],
    "flash-temperature": [
        rc.responses.create("flash-temperature", 0.2, 1.0, conductivity=k, diffusivity=(1e-5, 1e-6), direction=20.0)
        for k in (45.0, (0.0, 45.0))
    ],
    "gradient": [rc.responses.create("gradient", of) for of in ("approach", "mean-gap", "participation")],
    "paraboloid": [rc.ParaboloidSurface((1e-2, 2e-2))],
    "partial-slip": [rc.responses.create("partial-slip", tangential_force=1e-3, friction=0.3)],
    "limited-coulomb": [rc.LimitedCoulomb(0.3, 2e8), rc.LimitedCoulomb(0.3, 0.1 * HARDNESS)],
    "short-range": [rc.ShortRange(0.05)],
    "van-der-waals": [rc.VanDerWaals(0.03, 3e-10)],
    "non-gaussian": [
        rc.NonGaussianSurface(hurst=0.8, rms_height=1e-7, longest=20e-6, shortest=3e-6, seed=1, skewness=-0.5)
    ],
    "self-affine": [rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=20e-6, shortest=3e-6, seed=1)],
    "sphere": [rc.SphereSurface(1e-2)],
    "sum": [rc.WavySurface(1e-6, 1e-5) + rc.SphereSurface(1e-2)],
    "wavy": [rc.WavySurface(1e-6, 1e-5)],
}


def shipped():
    for kind, registry in kit.KINDS.items():
        for name in registry:
            if registry[name].__module__.partition(".")[0] == "roughcontact":
                for number, part in enumerate(MADE.get(name) or [registry.create(name)]):
                    yield pytest.param(kind, part, id=f"{kind}-{name}" + (f"-{number}" if number else ""))


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "part"), list(shipped()))
def test_what_ships_conforms(kind, part):
    report = kit.check(part)
    assert report.kind == kind
    assert len(report.findings) == len(kit.claims(kind)) >= 5
    report.raise_for_failures()


def test_maps_and_sums_conform():
    noise = rc.HeightMap(np.random.default_rng(0).random((9, 8)), size=(1e-4, 1e-4))
    for surface in (noise, rc.WavySurface(1e-6, 1e-5) + rc.SphereSurface(1e-2)):
        kit.check(surface).raise_for_failures()


@attrs.frozen
class Crooked(rc.Love):
    """Love's kernel but for one thing."""

    fault: str

    def coefficients(self, shape, spacing, compliance):
        values = super().coefficients(shape, spacing, compliance)
        faults = {
            "shape": lambda: values[:-1],
            "nan": lambda: np.where(values == values.max(), np.nan, values),
            "shrunk": lambda: values * (1 + 1e-4 * (shape[0] > 10)),
            "negative": lambda: values - 0.9 * values.max() * np.eye(*shape),
            "rounded": lambda: values * (1.0 + 1e-15 * (spacing[0] > 1e-3)),
            "near": lambda: values * 1.01,
            "stiffer": lambda: values / compliance**2 * 1e-22,
        }
        return faults.get(self.fault, lambda: values)()

    def coefficients_from(self, first, shape, spacing, compliance):
        values = super().coefficients_from(first, shape, spacing, compliance)
        return values * 1.01 if first and self.fault == "rows" else values

    def effective_modulus(self, wavenumber, compliance):
        return 1.1 / compliance + 0.0 * wavenumber if self.fault == "modulus" else None

    def directional_modulus(self, angle, compliance):
        return (1.0 + 0.1 * np.cos(2.0 * angle)) / compliance if self.fault == "directions" else None

    def spectrum(self, qx, qy, spacing, compliance):
        if self.fault == "writes":
            qx += 0.0 * qx + 1e-3
        values = super().spectrum(qx, qy, spacing, compliance)
        return values * (1.0 + 0.1 * np.sign(qx)) if self.fault == "lopsided" else values


@attrs.frozen
class CrookedShear(rc.Love):
    """Love's kernel but for one thing in its response to shear."""

    fault: str

    def change(self, component, values, spacing):
        faults = {
            "shape": lambda: values[:-1],
            "moody": lambda: values * (1 + next(MOODS)),
            "rounded": lambda: values * (1.0 + 1e-15 * (spacing[0] > 1e-3)),
            "large": lambda: values * (10.0 if component == "xy" else 1.0),
            "soft": lambda: values * (1.1 if component == "yy" else 1.0),
            "turned": lambda: values * (-1.0 if component == "xy" else 1.0),
        }
        return faults.get(self.fault, lambda: values)()

    def shear_coefficients(self, component, shape, spacing, compliance, pair):
        values = super().shear_coefficients(component, shape, spacing, compliance, pair)
        return 1.01 * values if self.fault == "near" else self.change(component, values, spacing)

    def shear_spectrum(self, component, qx, qy, spacing, compliance, pair):
        values = super().shear_spectrum(component, qx, qy, spacing, compliance, pair)
        return np.abs(values) if self.fault == "even" else self.change(component, values, spacing)


@attrs.frozen(eq=False)
class PlannedShear(ShearConvolution):
    """Somebody else's convolution of shear, with a flaw."""

    plan: ShearConvolution
    fault: str

    @property
    def setup(self):
        return self.plan.setup

    def apply(self, tractions, of="xy", to="xy"):
        moved = self.plan.apply(tractions, of, to)
        faults = {
            "drift": lambda: moved + 1e-6 * np.cumsum(moved, axis=1),
            "double": lambda: np.asarray(moved, dtype=np.float64),
        }
        return faults.get(self.fault, lambda: moved)()

    def inverse(self, dtype=np.float64):
        found = self.plan.inverse(dtype)
        sign = -1.0 if self.fault == "pulls" else 1.0
        return attrs.evolve(found, symbols={name: sign * symbol for name, symbol in found.symbols.items()})


CACHE = np.ones((40, 40))


class Shares(rc.InfluenceKernel):
    """Hands out its own memory."""

    def coefficients(self, shape, spacing, compliance):
        return CACHE[: shape[0], : shape[1]]


class Nothing(rc.InfluenceKernel):
    pass


@attrs.frozen(eq=False)
class Planned(PreparedConvolution):
    plan: PreparedConvolution
    fault: str
    memory: list = attrs.Factory(list)

    @property
    def setup(self):
        return self.plan.setup

    def apply(self, pressure):
        moved = self.plan.apply(pressure)
        if self.fault == "writes" and pressure.flags.writeable:
            pressure *= 2.0
        if self.fault == "remembers":
            self.memory[:] = self.memory or [np.empty(moved.shape)]
            self.memory[0][...] = moved
            return self.memory[0]
        faults = {
            "square": lambda: moved * (1.0 + 1e-6 * pressure.max()),
            "drift": lambda: moved + 1e-6 * np.cumsum(pressure, axis=0),
            "pulls": lambda: -moved,
            "double": lambda: np.asarray(moved, dtype=np.float64),
        }
        return faults.get(self.fault, lambda: moved)()

    def shear(self):
        return PlannedShear(self.plan.shear(), self.fault)


@attrs.frozen
class Faulty(rc.Convolver):
    fault: str

    @property
    def boundaries(self):
        return frozenset({rc.Boundary.FREE})

    def transform_shape(self, grid, boundary):
        return grid.shape

    def prepare(self, kernel, grid, boundary):
        return Planned(rc.DCFFT().prepare(kernel, grid, rc.Boundary.FREE), self.fault)


@attrs.frozen
class Liar(rc.Solver):
    """The uniform pressure, or somebody else's with a flaw, said to be converged."""

    fault: str
    tolerance: float = 1e-8

    def solve(self, convolution, task):
        if self.fault == "mute":
            raise rc.InputError("no")
        if self.fault == "array":
            return task.initial_gap
        if self.fault == "writes":
            task.initial_gap[...] *= 0.5
        if self.fault == "uniform":
            pressure = np.full(task.initial_gap.shape, 0.1 if task.mean_pressure is None else task.mean_pressure)
            return Outcome(pressure=pressure, status=rc.Status.CONVERGED, iterations=0, convolutions=0, errors=())
        found = rc.ProjectedConjugateGradient().solve(convolution, task)
        if self.fault == "raises" and found.status is rc.Status.NOT_FINITE:
            raise RuntimeError("lost")
        if self.fault == "gives up":
            return attrs.evolve(found, status=rc.Status.STALLED)
        if self.fault == "light":
            return attrs.evolve(found, pressure=found.pressure * (1 - 1e-10))
        if self.fault == "below":
            return attrs.evolve(found, pressure=np.where(found.pressure > 0, found.pressure, -1e-30))
        if self.fault == "stubborn" and task.start is not None:
            return attrs.evolve(found, pressure=task.start)
        if self.fault == "moody":
            noise = np.random.default_rng().random(found.pressure.shape)
            return attrs.evolve(found, pressure=found.pressure * (1 + 1e-15 * noise))
        return attrs.evolve(found, status=rc.Status.CONVERGED)


class Bare(rc.Convolver):
    """Prepares a function."""

    boundaries = frozenset({rc.Boundary.FREE})

    def transform_shape(self, grid, boundary):
        return grid.shape

    def prepare(self, kernel, grid, boundary):
        return np.cumsum


@attrs.frozen
class Careless(rc.AreaEstimator):
    """Counts cells, wrongly."""

    fault: str

    def estimate(self, solution):
        count, cells = int(solution.contact.sum()), solution.contact.size
        counted = {
            "falls": cells - count,
            "corner": count - 0.25 * solution.contact[:1, : cells // 3].sum(),
            "metres": count * (1.0 - min(0.5, solution.grid.spacing[0])),
            "moody": count * (1.0 - 1e-9 * np.random.default_rng().random()),
            "large": count if cells > 9 else np.nan,
            "more": count + 1,
        }.get(self.fault, count)
        value = counted * solution.grid.cell_area
        bar = {"certain": 0.0, "negative": -value}.get(self.fault, 0.5 * value)
        patches = np.full(solution.patches.count, 0.5 * value) if self.fault == "patches" else None
        return rc.Area(value, counted / cells, bar, "careless", patches=patches)


@attrs.define(eq=False)
class Soft(rc.Material):
    compliance: float = 1e-9
    pressure_limit: float = 1e9


@attrs.define
class Unhashable(Soft):
    pass


class Hidden(rc.Material):
    """Holds what no file can."""

    def __init__(self, compliance):
        self._rule = lambda: compliance

    @property
    def compliance(self):
        return self._rule()

    @property
    def pressure_limit(self):
        return 1e9


@attrs.frozen
class Sinks(rc.FlatteningModel):
    fault: str

    def height_loss(self, solution):
        lower = rc.Overlap().height_loss(solution)
        ramp = np.linspace(0, 1, lower.shape[1])
        faults = {"short": lower[1:], "sinks": lower + 1e-9, "grows": -lower, "leans": lower * ramp}
        if self.fault == "moody":
            return lower * (1.0 - 1e-9 * np.random.default_rng().random())
        return faults.get(self.fault, lower)


class Restless(rc.Surface):
    def heights(self, grid):
        return np.random.default_rng().integers(0, 9, grid.shape)


@attrs.frozen
class Wrapper(rc.Surface):
    """Another surface, but for one thing."""

    surface: rc.Surface
    fault: str
    seed: int = 1

    @property
    def own_grid(self):
        return rc.Grid((8, 8), 1e-5) if self.fault == "grid" else self.surface.own_grid

    @property
    def provenance(self):
        return "words" if self.fault == "words" else ()

    def heights(self, grid):
        return self.surface.heights(grid) + (1e-6 * self.seed if self.fault == "odd" else 0.0)

    def with_parts(self, parts):
        return Wrapper(rc.FlatSurface() if self.fault == "loses" else parts[0], self.fault)

    def resample_to(self, grid, interpolation=None):
        return rc.FlatSurface() if self.fault == "loses" else self

    def shift_half_cell(self, grid, *, periodic):
        return rc.WavySurface(1e-3, 1e-5) if self.fault == "grows" else self


class Credulous(rc.SurfaceReader):
    suffixes = frozenset({"TXT"})

    def read(self, path):
        return RawMap(np.zeros((2, 2)))


WAVY = rc.WavySurface(1e-6, 1e-5)


@attrs.frozen
class Answers(rc.Response):
    """The area as a response, but for one thing."""

    fault: str

    def respond(self, solution):
        area = solution.area()
        value, warnings = area.value, ()
        if self.fault == "mute":
            return None
        if self.fault == "corner":
            value += 1e-3 * float(solution.initial_gap[0, 0])
        if self.fault == "metres":
            value += 1e-10
        if self.fault == "moody":
            value *= 1 + next(MOODS)
        if self.fault == "words":
            warnings = "doubtful"
        return rc.Estimate(value, 0.0, "m2", warnings)


MOODS = iter(np.linspace(0.0, 1.0, 100))


@attrs.frozen
class Scribbles(rc.Panel):
    """A panel with one fault."""

    subject: str
    fault: str = ""

    def draw(self, subject, axes):
        if self.fault == "fails":
            raise KeyError("contact")
        if self.fault == "refuses":
            raise rc.InputError("There is nothing to draw.")
        if self.fault != "nothing":
            axes.plot([0.0, 1.0], [0.0, np.random.default_rng().random() if self.fault == "moody" else 1.0])


class Misattracts(rc.Interaction):
    """An exponential law with one fault."""

    def __init__(self, fault):
        self.fault = fault

    def decay(self, gap):
        return (1e-9 if self.fault == "weak" else 1.0) * np.exp(-np.asarray(gap) / 1e-9)

    def tension(self, gap):
        sign = -1.0 if self.fault == "repels" else 1.0
        values = sign * 1e6 * self.decay(gap)
        return values.ravel() if self.fault == "flat" and values.ndim > 1 else values

    def slope(self, gap):
        return (2e15 if self.fault == "slope" else -1e15) * self.decay(gap)

    def energy(self, gap):
        lasting = 1e-6 if self.fault == "lasting" else 0.0
        return (-2e-3 if self.fault == "energy" else -1e-3) * self.decay(gap) - lasting

    @property
    def reach(self):
        return 1.4e-8

    def resolve(self, spacing, modulus):
        # On other grids than the kit's own it hardly attracts.
        return Misattracts("weak") if self.fault == "moody" and modulus != 1e7 else self


class Slippery(rc.FrictionLaw):
    """Coulomb's law with one fault."""

    def __init__(self, fault):
        self.fault = fault

    def limit(self, pressure):
        if self.fault == "writes":
            pressure *= 0.5
        if self.fault == "falls":
            return 1e6 * np.minimum(pressure / 1e3, 1e3 / (pressure + 1e-300))
        if self.fault == "sticky":
            return 0.3 * pressure + 1.0
        if self.fault == "mean":
            return 0.3 * np.full_like(pressure, pressure.mean())
        noise = np.random.default_rng().random() if self.fault == "moody" else 0.0
        return (0.3 + 0.1 * noise) * pressure


@rc.laws.register("test-forgetful")
@attrs.frozen
class Forgetful(rc.Process):
    """Wear with one fault."""

    fault: str

    remembered: ClassVar = {"lost": ("height lost", "m")}

    def change_gap(self, problem, increment, memory):
        if self.fault == "writes":
            problem.initial_gap.flags.writeable = True
            problem.initial_gap[...] *= 1.0 + 1e-9
        noise = np.random.default_rng().random() if self.fault == "moody" else 1.0
        return noise * memory["lost"]

    def remember(self, state, increment, memory):
        if self.fault == "forgets":
            return memory
        return {"lost": memory["lost"] + 1e-17 * state.pressure}

    def list_conditions(self, state, memory):
        yield rc.results.Condition("balance", 0.1 if self.fault == "uncertain" else 0.0, "what is lost twice")


class Loose(ShearSolver):
    """A solver of shear with one fault."""

    def __init__(self, fault):
        self.fault = fault

    def solve(self, convolution, task):
        found = CAREFUL_SHEAR.solve(convolution, task)
        if self.fault == "writes":
            task.offset[...] *= 0.5
        if self.fault == "frozen":
            return attrs.evolve(found, shear=found.shear[::-1])
        if self.fault == "light":
            return attrs.evolve(found, shear=(1 - 1e-10) * found.shear)
        if self.fault == "stubborn" and task.start is not None:
            return attrs.evolve(found, shear=task.start)
        if self.fault == "leans":
            return attrs.evolve(found, shear=np.abs(found.shear))
        if self.fault == "moody":
            return attrs.evolve(found, shear=found.shear * (1 + 1e-15 * np.random.default_rng().random()))
        return attrs.evolve(found, status=rc.Status.CONVERGED)


@attrs.frozen
class Doubling(rc.Material):
    """A material that changes its field after the converters."""

    compliance = 1e-9
    pressure_limit = 1e9
    young: float = attrs.field(metadata={"unit": "Pa"})

    def __attrs_post_init__(self):
        object.__setattr__(self, "young", 2.0 * self.young)


BROKEN = [
    (Slippery("sticky"), "limits"),
    (Slippery("falls"), "not falling with the pressure"),
    (Slippery("mean"), "local"),
    (Slippery("writes"), "input unchanged"),
    (Slippery("moody"), "repeatable"),
    (Loose("frozen"), "stick and slip"),
    (Loose("light"), "limits and forces to rounding"),
    (Loose("stubborn"), "any start"),
    (Loose("leans"), "opposite directions"),
    (Loose("writes"), "input unchanged"),
    (Loose("moody"), "repeatable"),
    (Loose("moody"), "powers of two change no bit"),
    (Loose("infinite"), "stops at non-finite values"),
    (Misattracts("repels"), "attracts"),
    (Misattracts("energy"), "tension is the derivative of the energy"),
    (Misattracts("slope"), "slope is the derivative of the tension"),
    (Misattracts("lasting"), "ends at its reach"),
    (Misattracts("flat"), "shape"),
    (Misattracts("moody"), "contact"),
    (Answers("mute"), "serves a rough contact"),
    (Answers("words"), "valid numbers and warnings"),
    (Answers("moody"), "repeatable"),
    (Answers("corner"), "mirrored and shifted contacts"),
    (Answers("metres"), "scales with units"),
    (Nothing(), "coefficients or spectrum"),
    (Crooked("shape"), "shapes and types"),
    (Crooked("nan"), "finite"),
    (Shares(), "repeatable"),
    (Crooked("writes"), "input unchanged"),
    (Crooked("lopsided"), "even in x and y"),
    (Crooked("shrunk"), "offsets and waves independent"),
    (Crooked("negative"), "positive energy"),
    (Crooked("stiffer"), "grows with compliance"),
    (Crooked("rounded"), "powers of two change no bit"),
    (Crooked("near"), "far field of the half-space"),
    (Crooked("near"), "coefficients agree with spectrum"),
    (Crooked("rows"), "rows of coefficients"),
    (Crooked("modulus"), "effective modulus agrees with spectrum"),
    (Crooked("directions"), "directional modulus agrees with spectrum"),
    (CrookedShear("shape"), "shear: shapes and types"),
    (CrookedShear("moody"), "shear: repeatable"),
    (CrookedShear("rounded"), "shear: powers of two change no bit"),
    (CrookedShear("even"), "shear: odd and even"),
    (CrookedShear("large"), "shear: positive energy"),
    (CrookedShear("soft"), "shear: without constants each axis is as the normal one"),
    (CrookedShear("turned"), "shear: signs"),
    (CrookedShear("near"), "shear: coefficients agree with spectrum"),
    (Faulty("drift"), "shear: sum over all cells"),
    (Faulty("drift"), "shear: reciprocal, positive energy"),
    (Faulty("double"), "shear: float32 and float64, input unchanged"),
    (Faulty("pulls"), "shear: own displacement and approximate inverse"),
    (Faulty(""), "boundaries"),
    (Faulty(""), "setup"),
    (Faulty("square"), "linear"),
    (Faulty("square"), "powers of two change no bit"),
    (Faulty("drift"), "sum over all cells"),
    (Faulty("drift"), "reciprocal (Betti)"),
    (Faulty("pulls"), "positive energy"),
    (Faulty("writes"), "input unchanged"),
    (Faulty("remembers"), "repeatable"),
    (Faulty("double"), "float32 and float64"),
    (Liar("mute"), "solves, or raises InputError"),
    (Liar("", tolerance=0.0), "tolerance"),
    (Liar("uniform"), "confirmed status"),
    (Liar("uniform"), "conditions of contact"),
    (Liar("gives up"), "conditions of contact"),
    (Liar("light"), "load"),
    (Liar("below"), "bounds"),
    (Liar("writes"), "input unchanged"),
    (Liar("moody"), "repeatable"),
    (Liar("moody"), "powers of two change no bit"),
    (Liar("stubborn"), "any initial guess"),
    (Liar("infinite"), "stops at non-finite values"),
    (Careless("falls"), "monotone in the load"),
    (Careless("falls"), "full contact"),
    (Careless("more"), "no contact"),
    (Careless("certain"), "uncertainty covers Hertz"),
    (Careless("negative"), "valid areas and uncertainties"),
    (Careless("patches"), "areas of patches"),
    (Careless("corner"), "mirror images"),
    (Careless("corner"), "shifted contacts"),
    (Careless("metres"), "scales with units"),
    (Careless("moody"), "repeatable"),
    (Careless("large"), "grids of few cells"),
    (Soft(), "immutable"),
    (Soft(compliance=-1.0), "compliance"),
    (Soft(pressure_limit=0.0), "pressure limit"),
    (Soft(compliance=-1.0), "contact"),
    (Hidden(1e-9), "same values after pickling"),
    (Sinks("short"), "shapes and types"),
    (Sinks("sinks"), "no loss in elastic contact"),
    (Sinks("grows"), "volume not increased"),
    (Sinks("leans"), "mirrored and shifted contacts"),
    (Sinks("moody"), "repeatable"),
    (Restless(), "repeatable"),
    (Restless(), "shapes and types"),
    (Wrapper(WAVY, "words"), "shapes and types"),
    (Wrapper(WAVY, "grid"), "own grid"),
    (Wrapper(WAVY, "loses"), "parts"),
    (Wrapper(WAVY, "loses"), "resampled"),
    (Wrapper(WAVY, "grows"), "shifted by half a cell"),
    (Wrapper(WAVY, "same"), "reseeded"),
    (Scribbles("picture"), "subject"),
    (Scribbles("solution", "fails"), "draws or refuses"),
    (Scribbles("solution", "nothing"), "draws or refuses"),
    (Scribbles("surface", "refuses"), "draws or refuses"),
    (Scribbles("sweep", "moody"), "repeatable"),
    (Credulous(), "file endings"),
    (Credulous(), "damaged files refused"),
    (Forgetful("uncertain"), "certified states"),
    (Forgetful("moody"), "the same from a file"),
    (Forgetful("moody"), "the same twice"),
    (Forgetful("writes"), "arrays unchanged"),
    (Forgetful("forgets"), "memory of the loads before"),
    # What all kinds share.
    (Doubling(1e9), "takes texts with units"),
    (Hidden(1e-9), "survives pickling"),
    (Hidden(1e-9), "can be saved"),
    (Unhashable(1e-9), "hash agrees with equality"),
]
SHARED = {"takes texts with units", "survives pickling", "can be saved", "hash agrees with equality"}


@pytest.mark.parametrize(("part", "claim"), BROKEN, ids=[f"{kit.kind_of(part)}-{claim}" for part, claim in BROKEN])
def test_what_is_broken_is_caught_by_the_name_of_the_claim(part, claim):
    named = next(one for one in kit.claims(kit.kind_of(part)) if str(one) == claim)
    with pytest.raises(AssertionError, match=f"breaks the claim {re.escape(repr(claim))}: (?!.*raised)"):
        named.check(part)


class Singular(rc.InfluenceKernel):
    """A point load, which is infinite at its own place."""

    def coefficients(self, shape, spacing, compliance):
        x, y = (np.arange(n) * step for n, step in zip(shape, spacing, strict=True))
        return compliance * spacing[0] * spacing[1] / (np.pi * np.hypot(x[:, None], y))


def test_warnings_of_numpy_are_findings_and_not_printed(recwarn):
    report = kit.check(Singular())
    assert "finite" in {finding.claim for finding in report.failures}
    assert not recwarn.list


def test_a_panel_is_checked_on_the_command_line(run):
    status, out, _ = run("check", "pressure-histogram")
    assert status == 0
    assert out.startswith("panel ")
    assert "draws or refuses" in out


def test_every_claim_is_broken_by_something():
    caught = {(kit.kind_of(part), claim) for part, claim in BROKEN}
    claims = {(kind, str(claim)) for kind in kit.KINDS for claim in kit.claims(kind)}
    assert {(kind, claim) for kind, claim in claims if claim not in SHARED} | {
        ("material", claim) for claim in SHARED
    } == caught


def test_a_report_lists_all_failures():
    report = kit.check(Careless("falls"))
    assert {"monotone in the load", "full contact"} <= {finding.claim for finding in report.failures}
    with pytest.raises(AssertionError, match=r"(?s)claims hold.*\n.*  BROKEN  monotone in the load: .* falls"):
        report.raise_for_failures()


def test_the_strategies_alone_need_hypothesis():
    script = """
import sys
sys.modules["hypothesis"] = None
import roughcontact as rc
import roughcontact.testing
try:
    import roughcontact.testing.strategies
except rc.MissingPackage as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "pip install hypothesis" in done.stdout


@pytest.mark.parametrize(
    ("part", "claim", "reason"),
    [
        (Bare(), "linear", "must return a PreparedConvolution whose `setup` is a ConvolutionSetup"),
        (Liar("raises"), "stops at non-finite values", r"raised RuntimeError\('lost'\): a solver must return Status"),
        (Liar("array"), "solves, or raises InputError", "at a given load: .* must return an Outcome"),
    ],
)
def test_the_reason_says_what_to_do(part, claim, reason):
    named = next(one for one in kit.claims(kit.kind_of(part)) if str(one) == claim)
    assert re.search(reason, named.evaluate(part).detail)


@pytest.mark.slow
def test_a_report_reads_well():
    text = str(kit.check(rc.Love()))
    assert text.startswith("kernel Love(): 26 of 26 claims hold, 1 does not apply\n")
    assert re.search(r"^holds +even in x and y +to", text, re.M)
    assert "23 of 23 claims hold, 4 do not apply\n" in str(kit.check(rc.FourierHalfSpace()))
    text = str(kit.check(Nothing()))
    assert re.search(r"^BROKEN +coefficients or spectrum", text, re.M)
    assert "does not apply: the kernel has no spectrum" in text


def test_a_claim_names_the_part_and_what_was_found():
    with pytest.raises(AssertionError, match=r"Nothing object at .* breaks the claim 'coeff.*': it defines neither"):
        kit.claims("kernel")[0].check(Nothing())


def test_what_is_no_part_is_refused_in_words():
    with pytest.raises(rc.InputError, match="Pass an instance, not the class"):
        kit.check(rc.Love)
    with pytest.raises(rc.InputError, match="one of 'area estimator', "):
        kit.claims("colour")


class TestCommand:
    @pytest.mark.slow
    def test_a_name_that_conforms(self, capsys):
        assert main(["check", "love"]) == 0
        assert "26 of 26 claims hold" in capsys.readouterr().out

    def test_a_name_that_does_not(self, capsys, monkeypatch):
        monkeypatch.setitem(rc.areas._classes, "careless", Careless)
        assert main(["check", "careless", "--kind", "area estimator", "--with", "fault=falls"]) == 1
        assert re.search(r"^BROKEN +monotone in the load", capsys.readouterr().out, re.M)

    def test_a_name_that_needs_fields(self, capsys):
        assert main(["check", "elastic", "--with", "young=200e9", "poisson=0.3"]) == 0
        assert main(["check", "elastic"]) == 2
        said = capsys.readouterr().err
        assert "'young'" in said
        assert "--with FIELD=VALUE" in said

    def test_an_unknown_name(self, capsys):
        assert main(["check", "lov"]) == 2
        assert "Did you mean 'love'?" in capsys.readouterr().err
        assert main(["check", "love", "--kind", "area estimator"]) == 2
        assert "no area estimator named 'love'" in capsys.readouterr().err
        assert main(["check", "elastic", "--with", "young"]) == 2


SOURCES = sorted(path for path in (EXAMPLE / "src" / "roughcontact_example").glob("*.py") if path.name != "__init__.py")


class TestInstalledPlugIn:
    """Parts that an entry point of an installed distribution registers."""

    @pytest.fixture(autouse=True)
    def installed(self):
        found = entry_points(group="roughcontact.areas", name="between")
        if not found:
            pytest.skip("roughcontact-example is not installed")

    def test_the_command_knows_it_as_registered(self, run):
        status, out, _ = run("check", "between")
        assert status == 0
        assert re.search(r"^holds +can be saved", out, re.M)
        assert "not registered" not in out

    def test_a_file_names_each_part(self):
        groups = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
        names = {"between", "springs", "signal", "capacitance", "springback", "accelerated-gradient"}
        for registry in (rc.areas, rc.kernels, rc.convolvers, rc.responses, rc.flattening_models, rc.solvers):
            for name in names & set(groups[registry.group]):
                described = describe(registry.create(name), {})
                assert (described["kind"], described["name"]) == (registry.kind, name)
                names.remove(name)
        assert not names


def test_the_page_includes_every_file_of_the_example_plug_in():
    page = ROOT / "docs" / "extend" / "plugins.md"
    included = re.findall(r"^```\{literalinclude\} (\S+)$", page.read_text(encoding="utf-8"), re.M)
    files = {(page.parent / path).resolve() for path in included}
    assert all(path.is_file() for path in files)
    # Each file of the example runs in `test_the_example_plug_in_passes_its_tests`.
    example = {*SOURCES, *(EXAMPLE / "tests").glob("*.py"), EXAMPLE / "pyproject.toml"}
    assert {path for path in files if path.is_relative_to(EXAMPLE)} == example


def test_the_example_plug_in_has_a_part_of_each_kind_that_its_entry_points_name(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLE / "src")
    groups = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    registries = [*kit.KINDS.values()]
    assert set(groups) == {registry.group for registry in registries}
    files = set()
    for registry in registries:
        for path in groups[registry.group].values():
            module, _, name = path.partition(":")
            files.add(module.rpartition(".")[2])
            assert issubclass(getattr(importlib.import_module(module), name), registry.base)
    assert files == {path.stem for path in SOURCES}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_the_example_plug_in_uses_public_names_only(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
        names += [node.attr] if isinstance(node, ast.Attribute) else []
        assert not [name for name in names if any(part.startswith("_") for part in name.split("."))]


# Bases of parts, and what else a class of them must define.
BASES = {
    rc.Material: ("compliance", "pressure_limit"),
    rc.InfluenceKernel: (),
    rc.Convolver: ("boundaries", "prepare"),
    rc.Solver: ("tolerance", "solve"),
    rc.AreaEstimator: ("estimate",),
    rc.Response: ("respond",),
    rc.FlatteningModel: ("height_loss",),
    rc.Surface: ("heights",),
    rc.Panel: ("draw",),
    rc.Interaction: ("tension", "slope", "energy"),
    rc.FrictionLaw: ("limit",),
    rc.Law: ("change_gap",),
    ShearSolver: ("tolerance", "solve"),
    rc.SurfaceReader: ("suffixes", "read"),
}


@pytest.mark.parametrize("base", BASES, ids=lambda base: base.__name__)
@pytest.mark.parametrize("decorator", [attrs.frozen, attrs.define(slots=False)], ids=["frozen", "without slots"])
def test_fields_with_a_unit_take_texts_whatever_the_kind(base, decorator):
    """As the docs of plug-ins promise: also without a converter, beside one, in pairs, and with a unit omitted."""
    members = dict.fromkeys(BASES[base])

    class Plain(base):
        vars().update(members)
        young: float = attrs.field(metadata={"unit": "Pa"})
        size: tuple[float, float] = attrs.field(default=(1.0, 1.0), converter=tuple, metadata={"unit": "m"})
        friction: float = attrs.field(default=0.1, converter=float, metadata={"unit": ""})
        conductivity: float | None = attrs.field(default=None, metadata={"plain_unit": "W/(m K) or S/m"})
        depth: float | str = attrs.field(default="auto", converter=lambda value: value, metadata={"unit": "m"})
        name: str = "1 mm"

    cls = decorator(Plain)
    part = cls("210GPa", ["1mm", 2.0], "30%", "45", "2um")
    assert attrs.astuple(part, recurse=False) == (210e9, (1e-3, 2.0), 0.3, 45.0, 2e-6, "1 mm")
    assert cls(1.0).depth == "auto"
    for wrong in (
        {"young": "210"},
        {"young": "stiff"},
        {"young": 1.0, "friction": "3N"},
        {"young": 1.0, "size": ["1", 2]},
    ):
        with pytest.raises(rc.InputError, match=r"The field (young|friction|size) of Plain: '.*; write it like"):
            cls(**wrong)


@attrs.frozen
class Cork(rc.Material):
    """A material with units and without converters."""

    young: float = attrs.field(metadata={"unit": "Pa"})
    strength: float = attrs.field(default=1e6, metadata={"unit": "Pa"})

    @property
    def compliance(self):
        return 1.0 / self.young

    @property
    def pressure_limit(self):
        return self.strength


def test_a_plug_in_with_units_is_solved():
    kit.check(Cork("20MPa")).raise_for_failures()
    grid = rc.Grid((9, 15), (60e-6, "20um"))
    found, expected = (
        rc.ContactProblem(rc.Body(rc.SphereSurface("1mm"), cork), grid=grid).solve(force="1uN").pressure
        for cork in (Cork("20MPa", "2MPa"), Cork(20e6, 2e6))
    )
    np.testing.assert_array_equal(found, expected)
