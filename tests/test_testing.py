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
            "pulls": lambda: -moved,
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


@attrs.frozen
class Liar(rc.Solver):
    """The uniform pressure, or somebody else's with a flaw, said to be converged."""

    fault: str
    tolerance: float = 1e-8

    def solve(self, convolution, task):
        if self.fault == "mute":
            raise rc.InputError("no")
        if self.fault == "writes":
            task.undeformed[...] *= 0.5
        if self.fault == "uniform":
            pressure = np.full(task.undeformed.shape, 0.1 if task.mean_pressure is None else task.mean_pressure)
            return rc.Outcome(pressure=pressure, status=rc.Status.CONVERGED, iterations=0, convolutions=0, history=())
        found = rc.ProjectedConjugateGradient().solve(convolution, task)
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
            "corner": count - 0.25 * solution.contact[:1, : cells // 3].sum(),
            "metres": count * (1.0 - min(0.5, solution.grid.spacing[0])),
            "moody": count * (1.0 - 1e-9 * np.random.default_rng().random()),
            "large": count if cells > 9 else np.nan,
            "more": count + 1,
        }.get(self.fault, count)
        value = counted * solution.grid.cell_area
        bar = {"certain": 0.0, "negative": -value}.get(self.fault, 0.5 * value)
        clusters = np.full(solution.clusters.count, 0.5 * value) if self.fault == "clusters" else None
        return rc.Area(value, counted / cells, bar, "careless", clusters=clusters)


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
class Sinks(rc.PermanentSet):
    fault: str

    def lowering(self, solution):
        lower = rc.Overlap().lowering(solution)
        if self.fault == "mutates" and solution.undeformed.flags.writeable:
            solution.undeformed[...] += 1e-9
        ramp = np.linspace(0, 1, lower.shape[1])
        faults = {"short": lower[1:], "sinks": lower + 1e-9, "grows": -lower, "leans": lower * ramp}
        return faults.get(self.fault, lower)


class Restless(rc.Surface):
    def heights(self, grid):
        return np.random.default_rng().integers(0, 9, grid.shape)


class Credulous(rc.SurfaceReader):
    suffixes = frozenset({"TXT"})

    def read(self, path):
        return rc.RawMap(np.zeros((2, 2)))


BROKEN = [
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
    (Faulty(""), "boundaries declared"),
    (Faulty(""), "tells its scene"),
    (Faulty("square"), "linear"),
    (Faulty("square"), "units"),
    (Faulty("drift"), "the sum over all cells"),
    (Faulty("drift"), "reciprocal"),
    (Faulty("pulls"), "positive work"),
    (Faulty("writes"), "input left as it was"),
    (Faulty("remembers"), "repeatable"),
    (Faulty("double"), "float32 and float64"),
    (Liar("mute"), "serves, or refuses in words"),
    (Liar("", tolerance=0.0), "tolerance above zero"),
    (Liar("uniform"), "honest status"),
    (Liar("uniform"), "conditions of contact"),
    (Liar("gives up"), "conditions of contact"),
    (Liar("light"), "exact load"),
    (Liar("below"), "bounds bit for bit"),
    (Liar("writes"), "input left as it was"),
    (Liar("moody"), "repeatable"),
    (Liar("moody"), "units"),
    (Liar("stubborn"), "any start"),
    (Liar("infinite"), "notices infinity"),
    (Careless("falls"), "monotone in the load"),
    (Careless("falls"), "full contact"),
    (Careless("more"), "no contact"),
    (Careless("certain"), "bars hold Hertz"),
    (Careless("negative"), "sound areas and bars"),
    (Careless("clusters"), "areas of clusters"),
    (Careless("corner"), "mirror images"),
    (Careless("corner"), "moved contacts"),
    (Careless("metres"), "units"),
    (Careless("mutates"), "solution left as it was"),
    (Careless("moody"), "repeatable"),
    (Careless("large"), "few cells"),
    (Soft(), "frozen"),
    (Soft(compliance=-1.0), "compliance"),
    (Soft(pressure_limit=0.0), "pressure limit"),
    (Soft(compliance=-1.0), "bears a contact"),
    (Hidden(1e-9), "same after a journey"),
    (Sinks("short"), "shapes and types"),
    (Sinks("sinks"), "elastic contacts leave nothing"),
    (Sinks("grows"), "no volume out of nothing"),
    (Sinks("leans"), "mirrored and moved contacts"),
    (Sinks("mutates"), "solution left as it was"),
    (Restless(), "repeatable"),
    (Restless(), "shapes and types"),
    (Credulous(), "endings"),
    (Credulous(), "damaged files are refused"),
    # What all kinds share.
    (Hidden(1e-9), "pickles"),
    (Hidden(1e-9), "can be kept in files"),
    (Unhashable(1e-9), "hashes as it compares"),
]
SHARED = {"pickles", "can be kept in files", "hashes as it compares"}


@pytest.mark.parametrize(("part", "claim"), BROKEN, ids=[f"{kit.kind_of(part)}-{claim}" for part, claim in BROKEN])
def test_what_is_broken_is_caught_by_the_name_of_the_claim(part, claim):
    named = next(one for one in kit.claims(kit.kind_of(part)) if str(one) == claim)
    with pytest.raises(AssertionError, match=f"breaks the claim {claim!r}: (?!raised)"):
        named.check(part)


def test_every_claim_is_broken_by_something():
    caught = {(kit.kind_of(part), claim) for part, claim in BROKEN}
    claims = {(kind, str(claim)) for kind in kit.KINDS for claim in kit.claims(kind)}
    assert {(kind, claim) for kind, claim in claims if claim not in SHARED} | {
        ("material", claim) for claim in SHARED
    } == caught


def test_a_report_lists_all_failures():
    report = kit.check(Careless("falls"))
    assert {"monotone in the load", "full contact"} <= {finding.claim for finding in report.failures}
    with pytest.raises(AssertionError, match=r"(?s)claims hold\n.*  BROKEN  monotone in the load: .* falls"):
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
        monkeypatch.setitem(rc.areas._classes, "careless", Careless)
        assert main(["check", "careless", "--kind", "area", "--with", "fault=falls"]) == 1
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
