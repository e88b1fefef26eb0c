"""The kit for plug-in authors: what ships passes it, and what is broken on purpose does not, by name of the claim."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

import roughcontact as rc
import roughcontact.testing as kit
from roughcontact.__main__ import main

ROOT = Path(__file__).parent.parent
EXAMPLE = ROOT / "plugins" / "roughcontact-example"
HARDNESS = np.linspace(1e8, 1e9, 120).reshape(12, 10)
# Registered classes that cannot be made without arguments.
MADE = {
    "elastic": [rc.Elastic(200e9, 0.3)],
    "elastic-perfectly-plastic": [rc.ElasticPerfectlyPlastic(2e11, 0.3, h) for h in (1e9, 1e5, HARDNESS)],
    "paraboloid": [rc.ParaboloidSurface((1e-2, 2e-2))],
    "self-affine": [rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, longest=20e-6, shortest=3e-6, seed=1)],
    "sphere": [rc.SphereSurface(1e-2)],
    "wavy": [rc.WavySurface(1e-6, 1e-5)],
}


def shipped():
    for kind, registry in kit.KINDS.items():
        for name in registry.names():
            if registry.get(name).__module__.startswith("roughcontact."):
                for number, part in enumerate(MADE.get(name) or [registry.create(name)]):
                    yield pytest.param(kind, part, id=f"{kind}-{name}" + (f"-{number}" if number else ""))


@pytest.mark.parametrize(("kind", "part"), list(shipped()))
def test_what_ships_conforms(kind, part):
    report = kit.check(part)
    assert report.kind == kind
    assert len(report.findings) == len(kit.claims(kind)) >= 5
    report.raise_for_failures()


def test_maps_and_sums_conform():
    noise = rc.HeightMap(np.random.default_rng(0).random((9, 8)), size=1e-4)
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

    def spectrum(self, qx, qy, spacing, compliance):
        if self.fault == "writes":
            qx += 0.0 * qx + 1e-3
        values = super().spectrum(qx, qy, spacing, compliance)
        return values * (1.0 + 0.1 * np.sign(qx)) if self.fault == "lopsided" else values


CACHE = np.ones((40, 40))


class Shares(rc.InfluenceKernel):
    """Hands out its own memory."""

    def coefficients(self, shape, spacing, compliance):
        return CACHE[: shape[0], : shape[1]]


class Nothing(rc.InfluenceKernel):
    pass


@pytest.mark.parametrize(
    ("kernel", "claim"),
    [
        (Nothing(), "offers coefficients or a spectrum"),
        (Crooked("shape"), "shapes and types"),
        (Crooked("nan"), "finite"),
        (Shares(), "repeatable"),
        (Crooked("writes"), "input left as it was"),
        (Crooked("lopsided"), "even in x and y"),
        (Crooked("shrunk"), "each offset and wave alone"),
        (Crooked("negative"), "positive work"),
        (Crooked("stiffer"), "softer bodies yield more"),
        (Crooked("rounded"), "units"),
        (Crooked("near"), "far field of the half-space"),
        (Crooked("near"), "coefficients agree with the spectrum"),
    ],
)
def test_broken_kernels_are_caught(kernel, claim):
    assert claim in broken(kernel)


def broken(part):
    report = kit.check(part)
    with pytest.raises(AssertionError, match="claims hold"):
        report.raise_for_failures()
    return {finding.claim for finding in report.failures}


@attrs.frozen(eq=False)
class Planned(rc.PlannedConvolution):
    plan: rc.PlannedConvolution
    fault: str
    memory: list = attrs.Factory(list)

    @property
    def scene(self):
        return self.plan.scene

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
            "double": lambda: np.asarray(moved, dtype=np.float64),
        }
        return faults.get(self.fault, lambda: moved)()


@attrs.frozen
class Faulty(rc.Convolver):
    fault: str

    @property
    def boundaries(self):
        return frozenset({rc.Boundary.FREE})

    def transform_shape(self, grid, boundary):
        return grid.shape

    def plan(self, kernel, grid, boundary):
        return Planned(rc.DCFFT().plan(kernel, grid, rc.Boundary.FREE), self.fault)


@pytest.mark.parametrize(
    ("fault", "claim"),
    [
        ("", "boundaries declared"),
        ("", "tells its scene"),
        ("square", "linear"),
        ("square", "units"),
        ("drift", "the sum over all cells"),
        ("drift", "reciprocal"),
        ("writes", "input left as it was"),
        ("remembers", "repeatable"),
        ("double", "float32 and float64"),
    ],
)
def test_broken_convolvers_are_caught(fault, claim):
    assert claim in broken(Faulty(fault))


@attrs.frozen
class Liar(rc.Solver):
    """The uniform pressure, or somebody else's with a flaw, said to be converged."""

    fault: str
    tolerance = 1e-8

    def solve(self, convolution, task):
        if self.fault == "mute":
            raise rc.InputError("no")
        if self.fault == "writes":
            task.undeformed.flags.writeable = True
            task.undeformed *= 0.5
        if self.fault == "uniform":
            pressure = np.full(task.undeformed.shape, 0.1 if task.mean_pressure is None else task.mean_pressure)
            return rc.Outcome(pressure=pressure, status=rc.Status.CONVERGED, iterations=0, convolutions=0, history=())
        found = rc.ProjectedConjugateGradient().solve(convolution, task)
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


@pytest.mark.parametrize(
    ("fault", "claim"),
    [
        ("mute", "serves, or refuses in words"),
        ("uniform", "honest status"),
        ("uniform", "conditions of contact"),
        ("light", "exact load"),
        ("below", "bounds bit for bit"),
        ("writes", "input left as it was"),
        ("moody", "repeatable"),
        ("stubborn", "any start"),
        ("infinite", "notices infinity"),
    ],
)
def test_broken_solvers_are_caught(fault, claim):
    named = next(one for one in kit.claims("solver") if one.name == claim)
    with pytest.raises(AssertionError, match=claim):
        named.check(Liar(fault))


@attrs.frozen
class Careless(rc.AreaEstimator):
    """Counts cells, wrongly."""

    fault: str

    def estimate(self, solution):
        count, cells = int(solution.contact.sum()), solution.contact.size
        if self.fault == "mutates" and solution.pressure.flags.writeable:
            solution.pressure[...] = 0.0
        counted = {
            "falls": cells - count,
            "corner": count - 0.25 * bool(solution.contact[0, 0]) - 0.25 * bool(solution.contact[3, 5]),
            "micrometres": count * (1.0 + solution.grid.spacing[0]),
            "more": count + 1,
        }.get(self.fault, count)
        value = counted * solution.grid.cell_area
        bar = {"certain": 0.0, "negative": -value}.get(self.fault, 0.5 * value)
        return rc.Area(value, counted / cells, bar, "careless")


@pytest.mark.parametrize(
    ("fault", "claim"),
    [
        ("falls", "monotone in the load"),
        ("falls", "full contact"),
        ("more", "no contact"),
        ("certain", "bars hold Hertz"),
        ("negative", "sound areas and bars"),
        ("corner", "mirror images"),
        ("corner", "moved contacts"),
        ("micrometres", "units"),
        ("mutates", "solution left as it was"),
    ],
)
def test_broken_estimators_are_caught(fault, claim):
    assert claim in broken(Careless(fault))


@attrs.define(eq=False)
class Soft(rc.Material):
    compliance: float = 1e-9
    pressure_limit: float = 1e9


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


def test_broken_materials_are_caught():
    assert {"frozen"} <= broken(Soft())
    assert {"compliance", "bears a contact"} <= broken(Soft(compliance=-1.0))
    assert {"pressure limit"} <= broken(Soft(pressure_limit=0.0))
    assert {"pickles", "can be kept in files", "same after a journey"} == broken(Hidden(1e-9)) - {
        "hashes as it compares"
    }


@attrs.frozen
class Sinks(rc.PermanentSet):
    fault: str

    def lowering(self, solution):
        lower = rc.Overlap().lowering(solution)
        if self.fault == "mutates":
            solution.undeformed.flags.writeable = True
            solution.undeformed[...] += lower
        return {"sinks": lower + 1e-9, "grows": -lower, "leans": lower * np.linspace(0, 1, lower.shape[1])}.get(
            self.fault, lower
        )


@pytest.mark.parametrize(
    ("fault", "claim"),
    [
        ("sinks", "elastic contacts leave nothing"),
        ("grows", "no volume out of nothing"),
        ("leans", "mirrored and moved contacts"),
    ],
)
def test_broken_permanent_sets_are_caught(fault, claim):
    assert claim in broken(Sinks(fault))


class Restless(rc.Surface):
    def heights(self, grid):
        return np.random.default_rng().random(grid.shape)


class Credulous(rc.SurfaceReader):
    suffixes = frozenset({"TXT"})

    def read(self, path):
        return rc.RawMap(np.zeros((2, 2)))


def test_broken_surfaces_and_readers_are_caught():
    assert broken(Restless()) == {"repeatable"}
    assert broken(Credulous()) == {"endings", "damaged files are refused"}


def test_a_report_reads_well():
    text = str(kit.check(rc.Love()))
    assert text.startswith("kernel Love(): 15 of 15 claims hold\n")
    assert re.search(r"^  holds   even in x and y +even in x and y to", text, re.M)
    assert "14 of 14 claims hold, 1 does not apply\n" in str(kit.check(rc.FourierHalfSpace()))
    text = str(kit.check(Nothing()))
    assert "BROKEN  offers coefficients or a spectrum" in text
    assert "does not apply: it offers no spectrum" in text


def test_a_claim_names_the_part_and_what_was_found():
    with pytest.raises(AssertionError, match=r"Nothing object at .* breaks the claim 'offers .*': it offers neither"):
        kit.claims("kernel")[0].check(Nothing())


def test_what_is_no_part_is_refused_in_words():
    with pytest.raises(rc.InputError, match="Pass an instance, not the class"):
        kit.check(rc.Love)
    with pytest.raises(rc.InputError, match="one of 'kernel', 'convolver'"):
        kit.claims("colour")


class TestCommand:
    def test_a_name_that_conforms(self, capsys):
        assert main(["check", "love"]) == 0
        assert "15 of 15 claims hold" in capsys.readouterr().out

    def test_a_name_that_does_not(self, capsys, monkeypatch):
        monkeypatch.setitem(rc.areas._classes, "careless", lambda: Careless("falls"))
        assert main(["check", "careless", "--kind", "area"]) == 1
        assert "BROKEN  monotone in the load" in capsys.readouterr().out

    def test_a_name_that_needs_fields(self, capsys):
        assert main(["check", "elastic", "--with", "young=200e9", "poisson=0.3"]) == 0
        assert main(["check", "elastic"]) == 2
        assert "'young' and 'poisson'" in capsys.readouterr().err

    def test_an_unknown_name(self, capsys):
        assert main(["check", "lov"]) == 2
        assert "Did you mean 'love'?" in capsys.readouterr().err
        assert main(["check", "love", "--kind", "area"]) == 2
        assert "no area estimator named 'love'" in capsys.readouterr().err
        assert main(["check", "elastic", "--with", "young"]) == 2


def test_the_example_plug_in_passes_its_tests():
    paths = [str(EXAMPLE / "src"), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLE],
        capture_output=True,
        text=True,
        check=False,
        cwd=EXAMPLE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_page_shows_the_example_plug_in_as_it_is():
    page = (ROOT / "docs" / "plugins.md").read_text(encoding="utf-8")
    package = EXAMPLE / "src" / "roughcontact_example"
    sources = [path for path in sorted(package.glob("*.py")) if path.name != "__init__.py"]
    assert len(sources) >= 4
    for path in (*sources, *(EXAMPLE / "tests").glob("*.py")):
        assert f"```python\n{path.read_text(encoding='utf-8')}```" in page, path.name
    entries = (EXAMPLE / "pyproject.toml").read_text(encoding="utf-8")
    assert re.search(r"```toml\n(.*?)```", page, re.S)[1] in entries
