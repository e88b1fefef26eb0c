"""Paths on which the surfaces change, through the doors of those who do not script: command line, files, pages."""

from __future__ import annotations

import csv
import html
import io
import json
import re
import runpy

import numpy as np
import pytest
from matplotlib import pyplot
from PIL import Image

import roughcontact as rc
from roughcontact.__main__ import main

STEEL = ["--young", "210GPa"]
HARD = [*STEEL, "--hardness", "2GPa"]
LOADS = ["--loads", "2N", "4N", "1N", "0N", "4N", "--path"]
WEAR = ["--law", "archard", "coefficient=1e-16m2/N"]
SLIDING = [*WEAR, "--sliding", "0m", "10cm", "1m"]
SLIP = ["--force", "1N", "--counterbody-young", "210GPa", "--friction", "0.5", "--tangential", "1um", "-1um"]
ENERGY = ["--law", "energy-wear", "coefficient=2e-14m3/J"]
FRETTING = [*STEEL, *SLIP, *ENERGY]
RUBBER = ["moduli=1MPa,3MPa", "times=10ms", "poisson=0.5"]
ROAD = ["--young", "50GPa", "--counterbody-viscoelastic", *RUBBER, "--boundary", "periodic", "--slide"]


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A ball in a domain that is longer than wide, with an odd number of cells."""
    grid = rc.Grid((33, 24), (110e-6, 80e-6))
    path = tmp_path_factory.mktemp("maps") / "ball.npz"
    np.savez(path, heights=rc.ParaboloidSurface(1e-3).heights(grid), size=grid.size)
    return path


@pytest.fixture(scope="module")
def flattened(ball):
    steel = rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9)
    return rc.ContactProblem(rc.Body(rc.read_surface(ball), steel)).path(force=[2.0, 4.0, 1.0, 0.0, 4.0])


@pytest.fixture(scope="module")
def worn(ball):
    problem = rc.ContactProblem(rc.Body(rc.read_surface(ball), rc.Elastic(210e9, 0.3)), laws=rc.Archard("1e-16m2/N"))
    return problem.path(force=1.0, sliding=["0m", "10cm", "1m"])


def run(capsys, *arguments):
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ended:
        status = ended.code
    return status, capsys.readouterr()


def words_of(text):
    return " ".join(text.split())


def script_of(page):
    """Return the script of a report."""
    return html.unescape(re.search(r"<h2>Run it again</h2>\s*<pre><code>(.*?)</code>", page, re.DOTALL)[1])


class TestCommand:
    def test_follows_loads_as_a_script_does(self, ball, capsys, flattened):
        status, printed = run(capsys, "solve", ball, *LOADS, *HARD)
        assert status == 0
        assert words_of(str(flattened)) in words_of(printed.out)
        found = json.loads(run(capsys, "solve", ball, *LOADS, *HARD, "--json")[1].out)
        assert [state["force"] for state in found["states"]] == pytest.approx([2.0, 4.0, 1.0, 0.0, 4.0], rel=1e-9)
        assert [state["plastic_work"] for state in found["states"]] == flattened.table().columns["plastic_work"]
        assert found["states"][2]["approach"] == flattened[2].approach
        # Reloading is elastic: nothing is flattened beyond the load that was carried before.
        first, again = (found["states"][place]["flattened_volume"] for place in (1, 4))
        assert again == pytest.approx(first, rel=1e-6)

    def test_wears_over_a_sliding_distance(self, ball, capsys, worn):
        rows = list(
            csv.DictReader(io.StringIO(run(capsys, "solve", ball, "--force", "1N", *STEEL, *SLIDING, "--csv")[1].out))
        )
        assert [float(row["sliding [m]"]) for row in rows] == pytest.approx([0.0, 0.1, 1.0], rel=1e-12)
        # Archard: the volume is k F s.
        assert [float(row["worn_volume [m3]"]) for row in rows] == pytest.approx([0.0, 1e-17, 1e-16], rel=1e-9)
        assert [float(row["wear_depth [m]"]) for row in rows] == worn.table().columns["wear_depth"]
        found = json.loads(run(capsys, "solve", ball, "--force", "1N", *STEEL, *SLIDING, "--json")[1].out)
        assert found["inputs"]["sliding"] == pytest.approx([0.0, 0.1, 1.0], rel=1e-12)
        assert found["inputs"]["laws"] == ["rc.Archard(coefficient=100e-18)"]

    def test_loads_may_change_while_it_slides(self, ball, capsys):
        given = ["--loads", "1N", "0.5N", *WEAR, "--sliding", "0m", "20cm"]
        rows = list(csv.DictReader(io.StringIO(run(capsys, "solve", ball, *given, *STEEL, "--csv")[1].out)))
        assert [float(row["force [N]"]) for row in rows] == pytest.approx([1.0, 0.5], rel=1e-9)
        # The force falls in proportion to the distance: its mean is 0.75 N.
        assert float(rows[1]["worn_volume [m3]"]) == pytest.approx(1e-16 * 0.75 * 0.2, rel=1e-9)

    def test_writes_files_that_other_commands_read(self, ball, capsys, flattened, tmp_path):
        saved, picture, page = (tmp_path / f"path.{ending}" for ending in ("npz", "png", "html"))
        outputs = ("-o", saved, "-o", picture, "--report", page)
        status, printed = run(capsys, "solve", ball, *LOADS, *HARD, *outputs)
        assert status == 0
        assert "Written:" in printed.out
        assert picture.read_bytes()[:4] == b"\x89PNG"
        np.testing.assert_array_equal(rc.load(saved)[2].pressure, flattened[2].pressure)
        status, shown = run(capsys, "info", saved)
        assert status == 0
        assert shown.out.strip() in printed.out
        found = json.loads(run(capsys, "info", saved, "--json")[1].out)
        assert [state["approach"] for state in found["states"]] == flattened.approach.tolist()
        assert run(capsys, "plot", saved, "-o", tmp_path / "again.png")[0] == 0
        assert "Flattened volume" in page.read_text(encoding="utf-8")

    def test_asks_each_state(self, ball, capsys):
        status, printed = run(capsys, "solve", ball, "--loads", "1N", "0.5N", "--path", *STEEL, "--stiffness", "--csv")
        assert status == 0
        first, last = csv.DictReader(io.StringIO(printed.out))
        assert float(first["stiffness [N/m]"]) > float(last["stiffness [N/m]"]) > 0.0

    def test_its_plan_remembers(self, ball, capsys):
        plan = words_of(run(capsys, "solve", ball, *LOADS, *HARD, "--dry-run")[1].out)
        assert "law Flattening(model=Overlap()): remembers" in plan
        assert "first loading" not in plan
        several = ("--loads", "2N", "4N", *HARD, "--dry-run")
        assert "first loading" in words_of(run(capsys, "solve", ball, *several)[1].out)

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (("--force", "1N", "--path"), "--path is for several loads: give them to --loads"),
            (("--force", "1N", "--sliding", "0m", "1m"), "give --law archard coefficient=1e-16m2/N, for example"),
            (("--force", "1N", "--sliding", "0", "1m", *WEAR), "'0' has no unit (mm, um or nm?)"),
            (("--force", "1N", "--time", "0m"), "is not a quantity in units of s; write it like 10s"),
            (("--force", "1N", "--time", "0s", "1h"), "Nothing changes with the time"),
            (("--force", "1N", "--sliding", "1m", "0m", *WEAR), "that do not fall"),
            (("--loads", "1N", "2N", "--sliding", "0m", "1m", "2m", *WEAR), "one value for each place"),
            (("--loads", "0N", "1N", "--path"), "above 0 (N), but got 0.0"),
            (("--loads", "1N", "-2N", "--path"), "at least 0 (N), but got -2"),
            (("--loads", "1N", "2N", "--path", "--area", "cell-count"), "--area is not for a path"),
            (("--force", "1N", *SLIDING, "--area-within", "1%"), "--area-within is not for a path: omit it"),
            (("--force", "1N", *SLIDING, "--refine"), "--refine is not for a path"),
            (("--solve-for", "area=10%", "--path"), "--solve-for is not for a path"),
            (("--cycle", "0nm", "1nm", "--path"), "--cycle is not for a path"),
            (
                ("--loads", "1N", "2N", "--path", "--friction", "0.3", "--tangential", "0.1N"),
                "--path is for loads without friction: omit it with --tangential",
            ),
            (("--force", "1N", *SLIDING, "-o", "path.vti"), "must be a file that ends in .npz"),
        ],
    )  # fmt: skip
    def test_refuses_in_a_sentence(self, ball, capsys, arguments, sentence):
        status, printed = run(capsys, "solve", ball, *STEEL, *arguments)
        assert status == 2
        assert sentence in words_of(printed.err)
        assert printed.out == ""


class TestCyclesSpeedAndShift:
    """What passes beside loads: many cycles of them, a speed, the places of a counterbody."""

    @pytest.fixture(scope="class")
    @staticmethod
    def rough(tmp_path_factory):
        """Rough heights that repeat, longer than wide, an odd number of cells."""
        grid = rc.Grid((33, 16), (1e-3, 0.5e-3))
        surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=0.25e-3, longest=1e-3, seed=3)
        path = tmp_path_factory.mktemp("maps") / "rough.npz"
        np.savez(path, heights=surface.heights(grid), size=grid.size, periodic=True)
        return path

    @pytest.mark.slow
    def test_cycles_wear_as_in_a_script(self, ball, capsys, tmp_path):
        saved, page, moving = (tmp_path / f"cycles.{ending}" for ending in ("npz", "html", "gif"))
        given = [*FRETTING, "--cycles", "1", "10", "1e3", "--accuracy", "0.01"]
        status, printed = run(capsys, "solve", ball, *given, "-o", saved, "-o", moving, "--report", page)
        assert status in (0, 3)
        steel = rc.Elastic(210e9, 0.3)
        bodies = rc.Body(rc.read_surface(ball), steel), rc.Body(rc.FlatSurface(), steel)
        problem = rc.ContactProblem(*bodies, laws=rc.EnergyWear("2e-14m3/J"))
        turns = {"displacement": [(1e-6, 0.0), (-1e-6, 0.0)], "friction": 0.5}
        path = problem.path(force=1.0, **turns, cycles=[1, 10, 1000], accuracy=0.01)
        assert words_of(str(path)) in words_of(printed.out)
        np.testing.assert_array_equal(rc.load(saved)[-1].pressure, path[-1].pressure)
        with Image.open(moving) as file:
            assert file.n_frames == 6
        assert "cycles=[1.0, 10.0, 1e3]" in script_of(page.read_text(encoding="utf-8"))
        rows = list(csv.DictReader(io.StringIO(run(capsys, "solve", ball, *given, "--csv")[1].out)))
        assert [float(row["cycle"]) for row in rows] == [1, 1, 10, 10, 1000, 1000]
        assert [float(row["worn_volume [m3]"]) for row in rows] == path.table().columns["worn_volume"]
        found = json.loads(run(capsys, "solve", ball, *given, "--json")[1].out)
        assert found["inputs"]["cycles"] == [1.0, 10.0, 1000.0]
        assert found["inputs"]["accuracy"] == 0.01

    def test_rubber_slides_at_a_speed(self, rough, capsys, tmp_path):
        saved, fields, page, picture = (tmp_path / f"sliding.{ending}" for ending in ("npz", "nc", "html", "png"))
        files = ("-o", saved, "-o", fields, "-o", picture, "--report", page)
        status, printed = run(capsys, "solve", rough, "--pressure", "20kPa", *ROAD, "--speed", "10mm/s", *files)
        assert status in (0, 3)
        assert "friction coefficient" in printed.out
        rubber = rc.Viscoelastic(moduli=["1MPa", "3MPa"], times=["10ms"], poisson=0.5)
        road = rc.Body(rc.read_surface(rough), rc.Elastic(50e9, 0.3))
        problem = rc.ContactProblem(road, rc.Body(rc.FlatSurface(), rubber), boundary="periodic")
        state = problem.slide(pressure=20e3, speed="10mm/s", direction=0.0)
        for name in ("npz", "nc"):
            loaded = rc.load(tmp_path / f"sliding.{name}") if name == "npz" else rc.ContactSolution.load(fields)
            np.testing.assert_allclose(loaded.pressure, state.pressure, rtol=0.0, atol=1e-4 * state.pressure.max())
        assert "SteadySliding" in page.read_text(encoding="utf-8")
        assert picture.read_bytes()[:4] == b"\x89PNG"
        # Several loads, and another direction.
        several = ("--loads", "10kPa", "20kPa", *ROAD, "90deg", "--speed", "10mm/s")
        found = json.loads(run(capsys, "solve", rough, *several, "--json")[1].out)["solutions"]
        across = problem.slide(pressure=20e3, speed="10mm/s", direction=90.0).friction_coefficient.value
        assert found[1]["friction_coefficient"]["value"] == pytest.approx(across, rel=1e-4)
        assert across != pytest.approx(state.friction_coefficient.value, rel=1e-2)

    def test_rubber_creeps(self, ball, capsys):
        rubber = ["--viscoelastic", *RUBBER]
        given = ("--approach", "1um", *rubber, "--time", "0s", "10ms", "10s", "--json")
        states = json.loads(run(capsys, "solve", ball, *given)[1].out)["states"]
        assert states[0]["force"] / states[2]["force"] == pytest.approx(4.0, rel=1e-4)
        # A scenario: as many loads as times.
        given = ("--loads", "1mN", "2mN", "0mN", *rubber, "--time", "1ms", "20ms", "30ms", "--json")
        found = json.loads(run(capsys, "solve", ball, *given)[1].out)
        body = rc.Body(rc.read_surface(ball), rc.Viscoelastic(["1MPa", "3MPa"], ["10ms"], 0.5))
        path = rc.ContactProblem(body).path(force=[1e-3, 2e-3, 0.0], time=[1e-3, 20e-3, 30e-3])
        assert [state["approach"] for state in found["states"]] == path.approach.tolist()
        assert found["inputs"]["time"] == path.time.tolist()

    def test_the_counterbody_moves(self, rough, capsys, tmp_path):
        saved, moving = tmp_path / "shifts.npz", tmp_path / "shifts.gif"
        given = ["--pressure", "1MPa", "--young", "1GPa", "--boundary", "periodic", "--law", "archard"]
        given += ["coefficient=3e-11m2/N", "--shift", "0", "2", "4", "4,-2", "-2,0"]
        status, printed = run(capsys, "solve", rough, *given, "-o", saved, "-o", moving)
        assert status in (0, 3)
        body = rc.Body(rc.read_surface(rough), rc.Elastic(1e9, 0.3))
        problem = rc.ContactProblem(body, boundary="periodic", laws=rc.Archard("3e-11m2/N"))
        path = problem.path(pressure=1e6, shift=[(0, 0), (2, 0), (4, 0), (4, -2), (-2, 0)])
        assert words_of(str(path)) in words_of(printed.out)
        np.testing.assert_array_equal(rc.load(saved)[-1].pressure, path[-1].pressure)
        assert rc.load(saved).shift.tolist() == path.shift.tolist()
        found = json.loads(run(capsys, "solve", rough, *given, "--json")[1].out)
        assert found["inputs"]["shift"] == path.shift.tolist()

    def test_bodies_that_slide_with_friction_wear_as_in_a_script(self, rough, capsys, tmp_path):
        saved = tmp_path / "worn.npz"
        given = ("--young", "1GPa", "--poisson", "0.2", "--force", "0.02N", "--boundary", "periodic")
        wear = ("--law", "archard", "coefficient=1e-12m2/N", "--sliding", "0m", "1m", "--accuracy", "0.05")
        status, printed = run(
            capsys, "solve", rough, *given, *wear, "--friction", "0.5", "--slide", "90deg", "-o", saved
        )
        assert status in (0, 3)
        body = rc.Body(rc.read_surface(rough), rc.Elastic("1GPa", 0.2))
        problem = rc.ContactProblem(body, boundary="periodic", laws=rc.Archard("1e-12m2/N"))
        path = problem.path(force=0.02, sliding=[0.0, 1.0], friction=0.5, direction=90, accuracy=0.05)
        assert words_of(str(path)) in words_of(printed.out)
        np.testing.assert_array_equal(rc.load(saved)[-1].pressure, path[-1].pressure)
        assert run(capsys, "solve", rough, *given, *wear, "--slide")[0] == 2
        beside = ("--friction", "0.5", "--slide", "--shift", "0", "1")
        assert "only without friction" in run(capsys, "solve", rough, *given, *wear, *beside)[1].err

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (("--force", "1N", "--cycles", "1", "10"), "--cycles is for loads along the surface that return"),
            ((*SLIP, "--cycles", "1", "10"), "--cycles needs a law by which slip wears: give --law energy-wear"),
            ((*SLIP, *ENERGY, "--cycles", "10", "1"), "whole numbers from one on that rise"),
            ((*SLIP, *ENERGY, "--cycles", "1.5", "--dry-run"), "whole numbers from one on that rise"),
            ((*SLIP, *ENERGY, "--accuracy", "0.01"), "--accuracy is for increments of --time, --sliding or --cycles"),
            ((*SLIP, *ENERGY, "--time", "1s", "--accuracy", "0.01"), "--time is for loads without friction"),
            (("--force", "1N", *ENERGY), "--law energy-wear changes nothing without --tangential: give that too"),
            (
                ("--force", "1N", "--counterbody-young", "210GPa", "--friction", "0.3", "--slide", *ENERGY),
                "--law energy-wear changes nothing without --tangential: give that too, or omit the law.",
            ),
            (("--force", "1N", *WEAR), "--law archard changes nothing without --sliding or --shift: give that too"),
            (("--loads", "1N", "2N", "--path", *WEAR), "--law archard changes nothing without --sliding or --shift"),
            (("--force", "1N", "--speed", "1m/s"), "--speed is for steady sliding: give --slide too"),
            (("--force", "1N", "--slide", "--speed", "1m/s"), "--speed is for viscoelastic bodies: give"),
            (("--force", "1N", "--slide"), "give --friction 0.3, for example, or --speed of viscoelastic bodies"),
            (("--force", "1N", "--slide", "--speed", "1"), "'1' has no unit"),
            (
                ("--force", "1N", "--slide", "--speed", "1m/s", "--friction", "0.3"),
                "--friction is not for bodies that slide at a speed: omit it with --speed.",
            ),
            (
                ("--loads", "1N", "2N", "--slide", "--speed", "1m/s", "--path"),
                "--path is not for bodies that slide at a speed",
            ),
            (("--force", "1N", "--shift", "0", "1.5", *WEAR), "'1.5' is not a whole number"),
            (("--force", "1N", "--shift", "0", "1,2,3", *WEAR), "'2,3' is not a whole number"),
            (("--force", "1N", "--shift", "0", "1", "--boundary", "periodic"), "Nothing remembers where"),
            (("--force", "1N", "--shift", "0", "1", *WEAR, "--dry-run"), "needs a boundary that is periodic there"),
            (("--force", "1N", "--shift", "0", "1", *WEAR, "--accuracy", "0.1"), "--accuracy is for increments of"),
            (("--loads", "1N", "2N", "--shift", "0", "1", "2", *WEAR), "one value for each place"),
            (("--force", "1N", "--time", "0s", "1s", "--dry-run"), "Nothing changes with the time"),
        ],
    )  # fmt: skip
    def test_refuses_what_does_not_fit(self, ball, capsys, arguments, sentence):
        status, printed = run(capsys, "solve", ball, *STEEL, *arguments)
        assert status == 2
        assert sentence in words_of(printed.err)
        assert printed.out == ""

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (("--young", "1MPa"), "not allowed with argument"),
            (("--hardness", "1MPa"), "--hardness is for a Young's modulus: omit it with --viscoelastic."),
            (("--poisson", "0.5"), "--poisson is for a Young's modulus: omit it with --viscoelastic."),
            (("--counterbody-viscoelastic", "moduli=1MPa"), "required field 'times' is missing"),
            (("--slide", "--speed", "1mm/s"), "periodic along its direction"),
        ],
    )  # fmt: skip
    def test_refuses_what_rubber_does_not_have(self, ball, capsys, arguments, sentence):
        rubber = ["--viscoelastic", *RUBBER]
        status, printed = run(capsys, "solve", ball, "--force", "1mN", *rubber, *arguments)
        assert status == 2
        assert sentence in words_of(printed.err)


class TestFile:
    def test_holds_the_path(self, flattened, worn, tmp_path):
        for path in (flattened, worn):
            path.save(tmp_path / "path.npz")
            loaded = rc.load(tmp_path / "path.npz")
            assert isinstance(loaded, rc.results.LoadPath)
            assert loaded.increments == path.increments
            assert loaded.list_arguments() == path.list_arguments()
            for one, other in zip(loaded, path, strict=True):
                np.testing.assert_array_equal(one.pressure, other.pressure)
            assert list(loaded.table().columns) == list(path.table().columns)
            with pytest.raises(rc.InputError, match="does not hold"):
                rc.ContactSolution.load(tmp_path / "path.npz")

    def test_tables_have_what_passes(self, worn):
        frame = worn.to_pandas()
        assert list(frame.columns[:2]) == ["sliding", "increments"]
        assert frame["worn_volume"].to_numpy()[-1] == pytest.approx(1e-16, rel=1e-9)


class TestPage:
    @pytest.fixture(scope="class")
    @staticmethod
    def pages(flattened, worn):
        return {"flattened": flattened.to_html(), "worn": worn.to_html()}

    @pytest.mark.parametrize("name", ["flattened", "worn"])
    def test_its_script_follows_the_path_again(self, name, pages, request, tmp_path):
        path = request.getfixturevalue(name)
        script = script_of(pages[name])
        assert "path = problem.path(force=[" in script
        path.save(tmp_path / "path.npz")
        (tmp_path / "again.py").write_text(script.replace('"path.npz"', repr(str(tmp_path / "path.npz"))))
        again = runpy.run_path(str(tmp_path / "again.py"))["path"]
        assert len(again) == len(path)
        for one, other in zip(again, path, strict=True):
            np.testing.assert_allclose(one.pressure, other.pressure, rtol=0.0, atol=1e-4 * other.pressure.max())
            assert one.force == pytest.approx(other.force, rel=1e-5)

    def test_says_what_is_remembered(self, pages):
        flattened, worn = (re.sub(r"<[^>]*>", " ", page) for page in pages.values())
        assert all(name in flattened for name in ("Flattened volume", "Plastic work"))
        assert all(name in worn for name in ("Worn volume", "Wear depth", "sliding"))
        assert "first loading" not in flattened


class TestPicture:
    def test_marks_unloading(self, flattened):
        axes = flattened.plot()
        lines = {line.get_label(): line for line in axes.lines}
        assert {"loading", "unloading"} <= set(lines)
        factor = lines["unloading"].get_xdata()[0] / flattened.approach[1]
        # From the first touch up to 4 N, down to zero, and up again.
        np.testing.assert_allclose(lines["loading"].get_ydata(), [0.0, 2.0, 4.0], rtol=1e-5)
        np.testing.assert_allclose(lines["unloading"].get_ydata(), [4.0, 1.0, 0.0], rtol=1e-5, atol=1e-9)
        np.testing.assert_allclose(lines["unloading"].get_xdata(), factor * flattened.approach[1:4], rtol=1e-9)
        assert axes.get_legend() is not None

    def test_draws_the_area_over_the_distance(self, worn):
        axes = worn.plot(dark=True)
        (line,) = axes.lines
        assert axes.get_xscale() == "linear"
        np.testing.assert_allclose(line.get_xdata(), worn.sliding)
        np.testing.assert_allclose(line.get_ydata(), [100.0 * state.area().fraction for state in worn])

    def test_decades_have_a_logarithmic_axis_beside_the_start(self, ball):
        body = rc.Body(rc.read_surface(ball), rc.Elastic(210e9, 0.3))
        path = rc.ContactProblem(body, laws=rc.Archard(1e-16)).path(force=1.0, sliding=[0.0, 1e-4, 1e-3, 0.1])
        axes = path.plot()
        assert axes.get_xscale() == "log"
        curve, start = axes.lines
        assert len(curve.get_xdata()) == 3
        assert start.get_ydata()[0] == pytest.approx(100.0 * path[0].area().fraction)

    def test_the_course_has_what_changes(self, worn, flattened):
        figure = rc.plotting.draw_course(worn, dark=True)
        drawn = {axes.get_ylabel().partition(",")[0]: axes for axes in figure.axes}
        # A force that stays is not drawn.
        assert list(drawn) == ["contact area", "approach", "peak pressure", "worn volume", "wear depth"]
        (line,) = drawn["worn volume"].lines
        assert drawn["worn volume"].get_ylabel() == "worn volume, µm³"
        np.testing.assert_allclose(line.get_xdata(), worn.sliding)
        np.testing.assert_allclose(line.get_ydata(), [1e18 * volume for volume in worn.table().columns["worn_volume"]])
        assert figure.get_facecolor()[:3] < (0.2, 0.2, 0.2)
        pyplot.close(figure)
        # Nothing passes: over the number of the state.
        figure = rc.plotting.draw_course(flattened)
        curve, area, *_ = figure.axes
        assert (curve.get_ylabel(), area.get_ylabel(), area.get_xlabel()) == ("force, N", "area, µm²", "state")
        np.testing.assert_allclose(area.lines[0].get_ydata(), [1e12 * state.area().value for state in flattened])
        pyplot.close(figure)

    def test_the_colours_of_the_pressure_may_be_those_of_several_states(self, flattened):
        highest = float(flattened[1].pressure.max())
        for state in (flattened[1], flattened[2]):
            axes = state.plot(rc.panels.create("pressure", highest=highest))
            assert axes.images[0].norm.vmax == pytest.approx(highest / 1e9)
            pyplot.close(axes.figure)
        with pytest.raises(rc.InputError, match="The highest pressure that is drawn"):
            rc.panels.create("pressure", highest=-1.0)


def test_pages_are_told_what_a_path_is_along():
    soft = rc.Body(rc.SphereSurface(1e-3), rc.Viscoelastic([1e6, 1e6], [1.0], 0.5))
    problem = rc.ContactProblem(soft, grid=rc.Grid((9, 8), 1e-4))
    problem, places = rc.faces.prepare_path(problem, {"force": 1.0}, time=["0s", "1min"])
    assert [type(law) for law in problem.laws] == [rc.laws["relaxation"]]
    assert [(str(place.load), place.time) for place in places] == [("force 1 N", 0.0), ("force 1 N", 60.0)]


class TestAnimation:
    def test_shows_each_state_with_the_same_colours(self, flattened, tmp_path):
        for dark in (False, True):
            flattened.animate(tmp_path / "path.gif", dark=dark)
            with Image.open(tmp_path / "path.gif") as file:
                assert file.n_frames == len(flattened)
                shown = []
                for number in range(file.n_frames):
                    file.seek(number)
                    shown.append(np.array(file.convert("RGB"), dtype=np.int16))
                durations = [_duration_of(file, number) for number in range(file.n_frames)]
            # The last state is looked at for longer.
            assert len(set(durations[:-1])) == 1 < durations[-1] / durations[0]
            assert (shown[0][0, 0].mean() < 128) == dark
            # Of the state without a load the contact differs and the title, and by a part of a pixel what is beside.
            height, width = shown[0].shape[:2]
            moved = (np.abs(shown[1] - shown[3]).max(axis=2) > 64)[int(0.3 * height) :]
            assert moved.mean() > 0.05
            assert moved[:, int(0.86 * width) :].mean() < 0.01

    def test_other_paths_have_it_too(self, ball, tmp_path):
        problem = rc.ContactProblem(rc.Body(rc.read_surface(ball), rc.Elastic(210e9, 0.3)))
        paths = {
            "sweep": problem.sweep(force=[1.0, 2.0]),
            "slip": problem.path(force=1.0, tangential_force=[(0.1, 0.0), (0.0, 0.0)], friction=0.3, substeps=1),
        }
        for name, path in paths.items():
            path.animate(tmp_path / f"{name}.gif")
            with Image.open(tmp_path / f"{name}.gif") as file:
                assert file.n_frames == len(path)

    @pytest.mark.parametrize(
        ("name", "sentence"),
        [("path.mp4", "a file that ends in .gif, but got"), ("path", "ends in .gif"), (3, "a str or a path")],
    )
    def test_refuses_other_files(self, worn, name, sentence):
        with pytest.raises(rc.InputError, match=re.escape(sentence)):
            worn.animate(name)

    def test_from_the_command_line(self, ball, capsys, tmp_path):
        saved, moving, again = tmp_path / "path.npz", tmp_path / "path.gif", tmp_path / "again.gif"
        outputs = ("-o", saved, "-o", moving)
        status, printed = run(capsys, "solve", ball, "--force", "1N", *STEEL, *SLIDING, *outputs)
        assert status == 0
        assert str(moving) in printed.out.replace("\n", "")
        assert run(capsys, "plot", saved, "-o", again)[0] == 0
        assert again.read_bytes() == moving.read_bytes()

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (("solve", "--force", "1N", *STEEL), "that ends in"),
            (("solve", "--force", "1N", *STEEL, "--friction", "0.3", "--slide", "0deg"), "that ends in .npz, .pdf"),
            (("plot",), ".gif is for paths, which have several states: write a .png, .svg or .pdf."),
        ],
    )
    def test_what_is_not_a_path_is_refused(self, ball, capsys, tmp_path, arguments, sentence):
        command, *options = arguments
        status, printed = run(capsys, command, ball, *options, "-o", tmp_path / "contact.gif")
        assert status == 2
        assert sentence in words_of(printed.err)
        assert not (tmp_path / "contact.gif").exists()


def _duration_of(file, number):
    file.seek(number)
    return file.info["duration"]
