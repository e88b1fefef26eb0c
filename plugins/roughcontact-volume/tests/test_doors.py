"""Materials and laws below a surface by study files, by the command line, in reports, and in files of killed paths."""

from __future__ import annotations

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.faces import build_problem
from roughcontact.responses import FirstYield

from roughcontact_volume import (
    Cuboid,
    Inclusion,
    Inclusions,
    LudwikHardening,
    Plastic,
    PlasticZonePanel,
    ResidualStress,
    ResidualStressPanel,
    Sphere,
    StrainedRegion,
    SwiftHardening,
    TotalStressPanel,
    VoceHardening,
)

GRID = rc.Grid((11, 9), ("90um", "110um"))
BALL = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
STEEL = Plastic("210GPa", 0.3, "1GPa", SwiftHardening(strain=0.005, power=0.2), accuracy=0.5)
HARDENING = "hardening.type=swift-hardening hardening.strain=0.005 hardening.power=0.2"
FIELDS = f"young=210GPa poisson=0.3 yield=1GPa {HARDENING} accuracy=0.5"
LOADS = ("3N", "0N", "4N")
STUDY = """
[problems.dent]
grid = {shape = [11, 9], size = ["90um", "110um"]}
[problems.dent.body]
surface = {type = "paraboloid", radius = "1mm"}
material = "rigid"
[problems.dent.counterbody]
surface = "flat"
[problems.dent.counterbody.material]
type = "plastic"
young = "210GPa"
poisson = 0.3
yield_stress = "1GPa"
hardening = {type = "swift-hardening", strain = 0.005, power = 0.2}
accuracy = 0.5
[study]
force = ["3N", "0N", "4N"]
"""


def make_problem():
    return rc.ContactProblem(BALL, rc.Body(rc.FlatSurface(), STEEL), grid=GRID)


def digest(path):
    """The bits of pressure and all that is remembered at each load."""
    found = hashlib.sha256()
    for state in path:
        for values in (state.pressure, *(one for _, one in sorted(state.added[0].memory[0].items()))):
            found.update(np.ascontiguousarray(values).tobytes())
    return found.hexdigest()


@pytest.fixture(scope="module")
def path():
    return make_problem().path(force=LOADS)


@pytest.fixture
def ball(tmp_path):
    file = tmp_path / "ball.npz"
    np.savez(file, heights=BALL.heights(GRID), size=GRID.size)
    return file


def solve(capsys, *arguments):
    status = main(["solve", *map(str, arguments)])
    found = capsys.readouterr()
    return status, found.out, found.err


def test_a_study_file_leads_to_the_states_of_a_script(tmp_path, path, capsys):
    (tmp_path / "dent.toml").write_text(STUDY)
    assert main(["run", str(tmp_path / "dent.toml"), "-o", str(tmp_path / "out"), "--json"]) in (0, 3)
    records = json.loads(capsys.readouterr().out)["records"]
    assert [one["p_max"] for one in records] == pytest.approx([state.pressure.max() for state in path], rel=1e-12)
    found = [one["plastic_work"] for one in records]
    assert found == pytest.approx(path.table().columns["plastic_work"], rel=1e-12)
    assert 0.0 < found[0] == found[1] < found[2]


def test_a_command_follows_a_path_and_reports_it(ball, path, capsys, tmp_path):
    page, file = tmp_path / "path.html", tmp_path / "path.npz"
    material = ("--material", "rigid", "--counterbody-material", "plastic", "--counterbody-fields", *FIELDS.split())
    _, out, err = solve(capsys, ball, "--loads", *LOADS, "--path", *material, "-o", file, "--report", page)
    assert "plastic work" in out, err
    # Heights of a map are those of the ball.
    assert digest(rc.load(file)) == digest(path)
    text = page.read_text(encoding="utf-8")
    words = (
        "Plastic work",
        "Imprint depth",
        "Plastic flow",
        "von Mises stress beyond the yield stress",
        "SwiftHardening",
    )
    assert all(word in text for word in words)
    assert main(["info", str(file)]) == 0
    assert "residual stress" in capsys.readouterr().out


def test_a_typical_metal_and_the_plan_of_a_command(ball, capsys, tmp_path):
    material = ("--material", "rigid", "--counterbody-material", "4340-steel", "--dry-run")
    for path in ((), ("--path",)):
        status, out, err = solve(capsys, ball, "--loads", *LOADS[::2], *path, *material)
        assert status == 0, err
        assert "layers to" in out
        assert "at force 4 N" in " ".join(out.split())
    body = {"surface": "flat", "material": "4340-steel"}
    sphere = {"surface": {"type": "sphere", "radius": "1mm"}, "material": "rigid"}
    found = build_problem({"body": sphere, "counterbody": body, "grid": GRID}).counterbody.material
    assert found == Plastic("210GPa", 0.3, "792MPa", LudwikHardening("510MPa", 0.26))
    # Below a layer its flow is not solved: it is refused, not forgotten.
    layered = {**body, "layers": {"young": "400GPa", "poisson": 0.2, "thickness": "2um"}}
    with pytest.raises(rc.InputError, match="homogeneous half-space"):
        build_problem({"body": sphere, "counterbody": layered, "grid": GRID}).solve(force="3N")


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ("young=210GPa poisson=0.3", "required field 'yield_stress' is missing"),
        (f"{FIELDS} hardening.powers=1", "unknown field 'powers'"),
        (f"{FIELDS} hardening=4GPa", "has hardening twice"),
        (FIELDS.replace("swift-", "swif-"), "Did you mean 'swift-hardening'?"),
        (FIELDS.replace("type=swift-hardening", "type=sphere"), "A Hardening must be the registered name of one"),
        (FIELDS.replace("hardening.type=swift-hardening ", ""), "The hardening of a material must be None"),
        (FIELDS.replace("yield=1GPa", "yield=1m"), "yield_stress"),
    ],
)
def test_wrong_fields_of_a_command_are_named(ball, capsys, fields, sentence):
    material = ("--material", "rigid", "--counterbody-material", "plastic", "--counterbody-fields", *fields.split())
    status, _, err = solve(capsys, ball, "--force", "3N", *material)
    assert status == 2
    assert sentence in " ".join(err.split())


class TestPanels:
    """What is drawn in a plane below a surface that has flowed."""

    def draw(self, state, panel, dark=False):
        """Return the axes, and the values that they show, NaN where there are none."""
        pyplot = pytest.importorskip("matplotlib.pyplot")
        axes = state.plot(panel, dark=dark)
        pyplot.close(axes.figure)
        return axes, np.ma.filled(axes.collections[0].get_array().astype(float), np.nan)

    @pytest.mark.parametrize("axis", [0, 1])
    def test_the_plane_goes_through_the_deepest_point(self, path, axis):
        zone = path[2].response("plastic-zone")
        axes, shown = self.draw(path[2], PlasticZonePanel(axis=axis))
        strain = zone.accumulated_strain
        deepest = np.flatnonzero(strain.any(axis=(1, 2)))[-1]
        _, i, j = np.unravel_index(strain[deepest].argmax(), (1, *GRID.shape))
        expected = strain[:, :, j] if axis == 0 else strain[:, i]
        count = min(len(shown), len(expected))
        np.testing.assert_array_equal(np.nan_to_num(shown)[:count], expected[:count])
        assert not np.nan_to_num(shown[deepest + 1 :]).any()
        assert axes.get_xlim() == pytest.approx([-0.5e6 * GRID.size[axis], 0.5e6 * GRID.size[axis]])
        low, high = axes.get_ylim()
        assert high == 0.0
        assert low > 1e6 * zone.depth.value

    def test_of_a_turned_domain_the_other_plane_is_the_same(self, path):
        body = attrs.evolve(path[2].origin.scene, grid=rc.Grid(GRID.shape[::-1], GRID.size[::-1]))
        turned = body.path(force=LOADS)
        states = path[2], turned[2]
        one, other = (self.draw(state, TotalStressPanel(axis=axis))[1] for axis, state in enumerate(states))
        np.testing.assert_allclose(other, one, rtol=0.02)

    def test_stress_is_that_of_the_responses_at_a_place(self, path):
        row = 3
        place = float(GRID.y[0, row])
        for name, cls in (("residual-stress", ResidualStressPanel), ("total-stress", TotalStressPanel)):
            axes, shown = self.draw(path[2], cls(position=place), dark=True)
            stress = path[2].response(name).von_mises[:, :, row]
            np.testing.assert_allclose(shown * {"MPa": 1e6, "GPa": 1e9}[axes.child_axes[0].get_ylabel()[-3:]], stress)
        with pytest.raises(rc.InputError, match="within 55 µm of the centre"):
            self.draw(path[2], TotalStressPanel(position="60um"))

    def test_where_nothing_has_flowed_there_is_no_strain(self):
        state = make_problem().solve(force="0.1N")
        axes, shown = self.draw(state, "plastic-zone")
        assert np.isnan(shown).all()
        assert "nothing has flowed" in [text.get_text() for text in axes.get_legend().get_texts()][-1]
        assert np.nanmax(self.draw(state, "total-stress")[1]) > 0.0

    def test_other_contacts_have_none(self, path):
        flat = rc.Body(rc.FlatSurface(), rc.Elastic("210GPa", 0.3))
        elastic = rc.ContactProblem(BALL, flat, grid=GRID).solve(force=1.0)
        for name in ("plastic-zone", "residual-stress", "total-stress"):
            assert rc.panels[name].fits(path[0])
            assert not rc.panels[name].fits(elastic)
            with pytest.raises(rc.InputError, match="Neither body flows"):
                elastic.plot(name)


def test_hardenings_have_a_form():
    voce = {"type": "voce-hardening", "saturation": "2GPa", "strain": 0.05}
    table = {"type": "tabulated-hardening", "strain": [0.01, 0.1], "stress": ["1.1GPa", "1.4GPa"]}
    sphere = {"surface": {"type": "sphere", "radius": "1mm"}, "material": "rigid"}
    for given, expected in ((voce, VoceHardening("2GPa", 0.05)), ("4GPa", "4GPa"), (4e9, 4e9), (table, None)):
        material = {"type": "plastic", "young": "210GPa", "poisson": 0.3, "yield_stress": "1GPa", "hardening": given}
        body = {"surface": "flat", "material": material}
        found = build_problem({"body": sphere, "counterbody": body, "grid": GRID}).counterbody.material
        if expected is None:
            assert found.find_yield_stress(0.055) == pytest.approx(1.25e9)
        else:
            assert found == Plastic("210GPa", 0.3, "1GPa", expected)


def test_laws_have_a_form(ball, capsys):
    sphere = {"type": "sphere", "radius": "20um"}
    inclusion = {"shape": sphere, "young": "390GPa", "poisson": 0.2, "centre": ["0um", 0.0, "35um"]}
    cuboid = {"type": "inclusion", **inclusion, "shape": {"type": "cuboid", "lengths": ["9um", "9um", "8um"]}}
    region = {"type": "strained-region", "shape": sphere, "strain": 1e-3, "centre": ["0um", "0um", "35um"]}
    body = {"surface": {"type": "sphere", "radius": "1mm"}, "material": {"young": "210GPa", "poisson": 0.3}}
    expected = StrainedRegion(Sphere("20um"), 1e-3, centre=(0.0, 0.0, "35um"))
    place = (0.0, 0.0, "35um")
    shapes = Sphere("20um"), Cuboid(["9um", "9um", "8um"])
    several = Inclusions([Inclusion(shape, "390GPa", 0.2, place) for shape in shapes])
    for given, law in ((region, expected), ({"type": "inclusions", "inclusions": [inclusion, cuboid]}, several)):
        assert build_problem({"body": body, "grid": GRID, "laws": [given]}).laws == (law,)
    given = "shape.type=sphere shape.radius=20um strain=1e-3 centre=0um,0um,35um"
    _, out, _ = solve(capsys, ball, "--force", "3N", "--young", "210GPa", "--law", "strained-region", *given.split())
    assert "strain=(0.001, 0.001, 0.001, 0.0, 0.0, 0.0)" in " ".join(out.split())


def test_a_residual_stress_has_a_form(ball, capsys):
    given = "yield=1GPa residual.type=residual-stress residual.depth=0um,50um residual.stress=-400MPa,0MPa"
    _, out, _ = solve(capsys, ball, "--force", "3N", "--young", "210GPa", "--json", "--first-yield", *given.split())
    found = json.loads(out)["responses"]["first-yield"]
    steel = rc.Body(rc.read_surface(ball), rc.Elastic("210GPa", 0.3))
    residual = ResidualStress(["0um", "50um"], ["-400MPa", "0MPa"])
    expected = rc.ContactProblem(steel).solve(force="3N").response(FirstYield("1GPa", residual=residual))
    assert found["force"]["value"] == pytest.approx(expected.force.value)


def test_a_material_that_has_a_residual_stress_has_a_form(ball, capsys, tmp_path):
    residual = {"depth": ["0um", "50um"], "stress": ["-400MPa", "0MPa"]}
    material = {"type": "plastic", "young": "210GPa", "poisson": 0.3, "yield_stress": "1GPa", "residual": residual}
    body = {"surface": {"type": "sphere", "radius": "1mm"}, "material": material}
    found = build_problem({"body": body, "grid": GRID}).body.material
    assert found == Plastic("210GPa", 0.3, "1GPa", residual=ResidualStress(["0um", "50um"], ["-400MPa", "0MPa"]))
    given = f"{FIELDS} residual.type=residual-stress residual.depth=0um,50um residual.stress=-400MPa,0MPa"
    material = ("--material", "rigid", "--counterbody-material", "plastic", "--counterbody-fields", *given.split())
    file = tmp_path / "state.npz"
    status, _, err = solve(capsys, ball, "--force", "0.1N", *material, "-o", file)
    assert status in (0, 3), err
    assert rc.load(file).origin.scene.counterbody.material == attrs.evolve(STEEL, residual=found.residual)


def test_a_command_asks_one_of_two_bodies_that_flow(ball, capsys):
    sides = ("", "counterbody-")
    both = [word for one in sides for word in (f"--{one}material", "plastic", f"--{one}fields", *FIELDS.split())]
    status, out, err = solve(capsys, ball, "--force", "3N", *both, "--plastic-zone", "body=counterbody", "--json")
    assert status in (0, 3), err
    zone = json.loads(out)["responses"]["plastic-zone"]
    assert zone["largest_strain"]["value"] > 1e-4
    _, _, err = solve(capsys, ball, "--force", "3N", *both, "--plastic-zone")
    assert "say which with body='body' or 'counterbody'" in " ".join(err.split())


SCRIPT = """
import sys
sys.path[:0] = {folders!r}
import test_doors
problem = test_doors.make_problem()
path = problem.path(force={loads!r}, file={file!r}, on_increment=lambda state: print("increment", flush=True))
print(test_doors.digest(path))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="processes are killed by a signal of POSIX")
def test_twenty_kills_lose_nothing(tmp_path):
    """At random moments, wherever the path is; the last run ends with the digest of one that was left alone."""
    loads = ["1N", "2N", "0.5N", "3N", "0N", "4N"]
    whole = digest(make_problem().path(force=loads))
    file = tmp_path / "path.npz"
    tests = Path(__file__).parent
    script = SCRIPT.format(folders=[str(tests), str(tests.parent / "src")], loads=loads, file=str(file))
    command = [sys.executable, "-c", script]
    rng = random.Random(48)
    kills, contents = 0, set()
    while kills < 20:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        lines = [process.stdout.readline() for _ in range(rng.randint(0, 2))]
        time.sleep(rng.uniform(0.0, 1.0))
        process.send_signal(signal.SIGKILL)
        out, _ = process.communicate(timeout=120)
        if process.returncode == 0:
            # It was finished: begin anew.
            assert "".join([*lines, out]).split()[-1] == whole
            file.unlink()
            continue
        kills += 1
        if file.exists():
            contents.add(hashlib.sha256(file.read_bytes()).hexdigest())
    # They found it at several places.
    assert len(contents) > 3
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=300)
    assert done.stdout.split()[-1] == whole
