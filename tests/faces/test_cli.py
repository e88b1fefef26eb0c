from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import commands, main
from roughcontact.typing import quantity

PNG = b"\x89PNG"
SHIPPED = ("check", "completion", "info", "plot", "report", "run", "solve", "stability", "surface")


@pytest.fixture
def height_map(tmp_path):
    path = tmp_path / "map.npz"
    surface = rc.ParaboloidSurface(radius=100e-6)
    np.savez(path, heights=surface.heights(rc.Grid((20, 24), (20e-6, 24e-6))), size=(20e-6, 24e-6))
    return path


def test_solve_writes_summary_fields_and_picture(height_map, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["solve", str(height_map), "--pressure", "10MPa", "--young", "210GPa", "--explain", "-o", str(out)]
    assert main(arguments) == 0
    text = " ".join(capsys.readouterr().out.split())
    for words in ("converged", "mean pressure 10 MPa", "contact area", "omitted", "solution.npz"):
        assert words in text
    with np.load(out / "solution.npz") as data:
        assert data["pressure"].mean() == pytest.approx(1e7)
    assert (out / "solution.png").read_bytes()[:4] == PNG


def test_solve_takes_a_pair_with_every_option(height_map, tmp_path, capsys):
    np.savetxt(tmp_path / "other.txt", 1e-7 * np.random.default_rng(1).random((20, 24)))
    np.save(tmp_path / "one.npy", 1e-7 * np.random.default_rng(0).random((20, 24)))
    options = (
        "--force 5mN --young 210GPa --poisson 0.25 --hardness 6GPa --counterbody-young 3.2e5MPa "
        "--counterbody-poisson 0.2 --counterbody-hardness 10GPa --size 20um 24um --detrend 2 "
        "--resample 32 32 --boundary free --area cell-count --threads 1"
    ).split()
    paths = [str(tmp_path / name) for name in ("one.npy", "other.txt")]
    # Noise from cell to cell is doubtful.
    assert main(["solve", *paths, *options, "--explain", "-o", str(tmp_path / "out")]) == 3
    text = " ".join(capsys.readouterr().out.split())
    assert "force 5 mN" in text
    assert "[cell-count]" in text
    assert "pressure limit 6 GPa" in text
    assert "threads 1: as given" in text
    assert "rigid" not in text


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (
            ["--young", "210GPa"],
            "one of the arguments --pressure --force --approach --loads --solve-for --cycle is required",
        ),
        (["--pressure", "1MPa"], "one of the arguments --material --young --viscoelastic is required"),
        (["--pressure", "1MPa", "--force", "1N", "--young", "1GPa"], "not allowed with"),
        (["--pressure", "1kg", "--young", "1GPa"], "'1kg' is not a quantity in units of Pa"),
        (["--pressure", "lots", "--young", "1GPa"], "'lots' is not one number with a decimal point and one unit"),
        (["--pressure", "", "--young", "1GPa"], "'' is not one number"),
        (["--pressure", "1MPa", "--young", "210"], "'210' has no unit (Pa, MPa or GPa?); write it like 100MPa"),
        (["--pressure", "1MPa", "--young", "1GPa", "--size", "1", "mm"], "write it like 250um"),
        (["--pressure", "1MPa", "--young", "1GPa", "--threads", "all"], "'all' is not a whole number"),
    ],
)
def test_a_wrong_command_line_is_explained(height_map, extra, words, capsys):
    with pytest.raises(SystemExit) as caught:
        main(["solve", str(height_map), *extra])
    assert caught.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["--young", "0GPa"], "Young's modulus must be"),
        (["--young", "1GPa", "--size", "1um"], "leave --size out"),
        (["--young", "1GPa", "--size", "1um", "2um", "3um"], "one value or two"),
        (["--young", "1GPa", "--kernel", "lave"], "Did you mean 'love'"),
        (["--young", "1GPa", "--counterbody-hardness", "1GPa"], "needs --counterbody-young"),
        (["--young", "1GPa", "--hardness", "1kPa"], "at most 1 kPa"),
        (["--young", "1GPa", "--area", "guess"], "no area estimator named 'guess'"),
        (["--young", "1GPa", "--solver", "polonsky-keer", "--hardness", "1GPa"], "use --solver auto"),
        (["--young", "1GPa", "--threads", "0"], "'auto' or a whole number of at least 1, but got 0"),
    ],
)
def test_wrong_input_is_one_sentence_and_status_2(height_map, extra, words, capsys, tmp_path):
    command = ["solve", str(height_map), "--pressure", "1MPa", *extra, "-o", str(tmp_path / "out")]
    assert main(command) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.startswith("roughcontact: ")
    assert message.count("\n") == 1


def test_missing_files_are_named(capsys):
    assert main(["solve", "nowhere.npz", "--pressure", "1MPa", "--young", "1GPa"]) == 2
    assert "There is no file 'nowhere.npz'" in capsys.readouterr().err


def test_an_output_folder_that_cannot_be_made_is_named(height_map, capsys, tmp_path):
    (tmp_path / "taken").write_text("")
    command = ["solve", str(height_map), "--pressure", "1MPa", "--young", "1GPa", "-o", str(tmp_path / "taken")]
    assert main(command) == 2
    assert "taken" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("100MPa", "Pa", 1e8),
        ("100 MPa", "Pa", 1e8),
        ("2.5e3Pa", "Pa", 2500.0),
        ("1 bar", "Pa", 1e5),
        ("250um", "m", 250e-6),
        ("250 µm", "m", 250e-6),
        ("0.1 mN", "N", 1e-4),
        ("30 %", "", 0.3),
    ],
)
def test_quantities(text, unit, value):
    assert quantity(unit)(text) == pytest.approx(value, rel=1e-14)


def test_the_module_runs_as_a_command():
    done = subprocess.run(
        [sys.executable, "-m", "roughcontact", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("roughcontact ")
    failed = subprocess.run([sys.executable, "-m", "roughcontact"], capture_output=True, text=True, check=False)
    assert failed.returncode == 2
    assert "COMMAND" in failed.stdout
    assert "Traceback" not in failed.stderr


@pytest.fixture
def two_maps(tmp_path):
    """A ball of 200 um in micrometres of height, and a map of another grid."""
    rng = np.random.default_rng(1)
    grid = rc.Grid((40, 40), 40e-6)
    ball = rc.SphereSurface(2e-4).heights(grid)
    np.savetxt(tmp_path / "ball.txt", 1e6 * ball)
    np.savez(tmp_path / "ring.npz", heights=1e-8 * rng.standard_normal((30, 50)), size=(45e-6, 50e-6))
    return [str(tmp_path / name) for name in ("ball.txt", "ring.npz")]


LOAD = "--force 0.05N --young 210GPa --hardness 6GPa --counterbody-young 210GPa".split()


def test_two_maps_are_matched(two_maps, tmp_path, capsys):
    options = "--size 40um --counterbody-size 45um 50um --unit 1um --match cubic --rotation 10deg".split()
    more = "--offset 1um,-2um --mirror --counterbody-detrend plane --domain 25um 20um --resample 50 40".split()
    assert main(["solve", *two_maps, *LOAD, *options, *more, "--explain", "-o", str(tmp_path / "out")]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for words in (
        "grid 50 x 40 cells on 25 µm x 20 µm",
        "heights 1 read from ball.txt: 40 x 40",
        "best plane subtracted; turned over, x to -x; rotated by 10 degrees; its centre at (",
        "converged",
        "saturated ",
    ):
        assert words in text


def test_a_ball_gets_its_radius_back(two_maps, tmp_path, capsys):
    """Form taken away, and the nominal ball put in its place: the same as the ball itself."""
    common = [*LOAD, "--size", "40um", "--unit", "1um"]
    forces = []
    for more in ([], ["--detrend", "sphere", "--ball", "200um"]):
        assert main(["solve", two_maps[0], *common, *more, "--explain", "-o", str(tmp_path)]) == 0
        with np.load(tmp_path / "solution.npz") as data:
            forces.append(data["pressure"])
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-6 * forces[0].max())
    assert "of radius 200 µm; a sphere of radius 200 µm" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--size", "40um"], "give --match bilinear, which interpolates both"),
        (["--size", "40um", "--counterbody-size", "40um"], "which is not the size given"),
        (["--size", "40um", "--counterbody-unit", "1um"], "states its own unit"),
        (["--size", "40um", "--match", "bilinear", "--domain", "1m"], "was asked for"),
        (["--size", "40um", "--counterbody-size", "45um", "50um", "--offset", "1um,1um"], "--match bilinear"),
        (["--size", "40um", "--counterbody-size", "45um", "50um", "--mirror"], "--match bilinear"),
        (["--size", "40um", "--counterbody-size", "45um", "50um", "--match", "fourier"], "needs a periodic map"),
        (["--size", "40um", "--detrend", "cone"], "The form must be"),
    ],
)
def test_pairs_that_do_not_fit_get_a_sentence(two_maps, tmp_path, capsys, options, words):
    assert main(["solve", *two_maps, *LOAD, *options, "-o", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err


def test_what_is_for_two_maps_is_refused_for_one(two_maps, tmp_path, capsys):
    for option in (["--match", "cubic"], ["--counterbody-detrend", "1"], ["--counterbody-unit", "1um"]):
        assert main(["solve", two_maps[0], *LOAD, "--size", "40um", *option, "-o", str(tmp_path)]) == 2
        assert f"{option[0]} is for the second of two height maps" in capsys.readouterr().err


def test_an_angle_needs_its_unit(two_maps, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["solve", *two_maps, *LOAD, "--match", "cubic", "--rotation", "20", "-o", str(tmp_path)])
    assert "write it like 30deg" in capsys.readouterr().err


PLUG_IN = """
import sys
from roughcontact._faces.cli import Command


class Hello(Command):
    \"\"\"Greet 100 % of the users.

    More about it.
    \"\"\"

    def declare(self, parser):
        parser.add_argument("name")

    def run(self, options):
        print("hello", options.name)
        return 3


class Clumsy(Command):
    \"\"\"Declare an argument twice.\"\"\"

    def declare(self, parser):
        parser.add_argument("--help")

    def run(self, options):
        return 0


class Thief(Hello):
    \"\"\"Steal a name.\"\"\"


class Unfinished(Command):
    pass


number = 7
"""


def install(folder, targets):
    """Lay down a distribution as an installer does: modules, and metadata with the entry points of commands."""
    (folder / "plug_in_commands.py").write_text(PLUG_IN)
    (folder / "plug_in_that_exits.py").write_text("import sys\nsys.exit('gone')")
    (folder / "plug_in_that_fails.py").write_text("1 / 0")
    metadata = folder / "somebody_elses-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: somebody-elses\nVersion: 1.0\n")
    lines = [f"{name} = plug_in_{target}" for name, target in targets.items()]
    (metadata / "entry_points.txt").write_text("\n".join(["[roughcontact.commands]", *lines]))


@pytest.fixture
def plug_in(tmp_path, monkeypatch):
    """Good and bad commands of somebody else."""
    targets = {
        "hello": "commands:Hello",
        "clumsy": "commands:Clumsy",
        "unfinished": "commands:Unfinished",
        "number": "commands:number",
        "absent": "commands:Absent",
        "exits": "that_exits:Command",
        "fails": "that_fails:Command",
    }
    install(tmp_path, targets)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "plug_in_commands", raising=False)
    # What is installed is looked up once.
    monkeypatch.setattr(commands, "_installed", None)
    monkeypatch.setattr(commands, "_classes", {})


def run(capsys, *arguments):
    try:
        status = main(arguments)
    except SystemExit as ended:
        status = ended.code
    return status, *capsys.readouterr()


def test_a_command_comes_by_entry_point(plug_in, capsys):
    assert run(capsys, "hello", "world") == (3, "hello world\n", "")
    assert "Greet 100 % of the users." in run(capsys, "hello", "--help")[1]
    assert run(capsys, "hello")[0] == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("clumsy", "conflicting option string"),
        ("unfinished", "cannot be made without arguments"),
        ("number", "must be a class derived from Command, but got 7"),
        ("absent", "cannot be loaded: AttributeError"),
        ("exits", "cannot be loaded: its module exits"),
        ("fails", "cannot be loaded: ZeroDivisionError"),
        ("helo", "Did you mean 'hello'?"),
    ],
)
def test_a_broken_command_gets_one_sentence(plug_in, capsys, name, words):
    status, out, error = run(capsys, name)
    assert (status, out) == (2, "")
    assert words in error
    assert error.startswith("roughcontact: ")
    assert error.count("\n") == 1


def test_broken_commands_leave_the_others_alone(plug_in, capsys):
    _, text, _ = run(capsys, "--help")
    assert re.search(r"^  hello +Greet 100 % of the users\.$", text, re.M)
    assert re.search(r"^  report +\w", text, re.M)
    for name in ("unfinished", "number", "absent", "exits", "fails"):
        assert re.search(rf"^  {name} +\(cannot be loaded", text, re.M)
    status, _, error = run(capsys, "check", "elastic", "--with", "young=1e9", "poisson=0.3")
    assert (status, error) == (0, "")


def test_a_shipped_command_cannot_be_replaced(tmp_path):
    install(tmp_path, {"solve": "commands:Thief"})
    command = [sys.executable, "-m", "roughcontact", "solve", "none.npz", "--pressure", "1MPa", "--young", "1GPa"]
    environment = {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
    first, second = done.stderr.splitlines()
    assert first.startswith("roughcontact: ")
    assert first.endswith("ships with roughcontact: plug_in_commands:Thief is ignored.")
    assert "There is no file 'none.npz'" in second


def test_the_shipped_commands_come_by_entry_points_and_load_nothing_heavy(capsys):
    script = "import sys; from roughcontact.__main__ import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    script += "import json; print(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    *text, modules = done.stdout.splitlines()
    for name in SHIPPED:
        assert any(line.startswith(f"  {name} ") for line in text)
    assert not {"matplotlib", "pint", "rich", "hypothesis", "scipy.ndimage"} & set(json.loads(modules))


@pytest.mark.parametrize("name", SHIPPED)
def test_every_command_has_help(name, capsys):
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: roughcontact {name}")


def test_a_unit_alone_is_one_of_it(tmp_path, capsys):
    np.savetxt(tmp_path / "map.txt", np.random.default_rng(1).random((16, 16)))
    printed = []
    for unit in ("um", "1um"):
        assert main(["info", str(tmp_path / "map.txt"), "--unit", unit, "--size", "16um"]) in (0, 3)
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
    with pytest.raises(SystemExit):
        main(["info", str(tmp_path / "map.txt"), "--unit", "2", "--size", "16um"])


def test_the_page_is_a_plugin_that_is_asked_for_where_it_is_not_installed(monkeypatch, capsys):
    installed = {name: found for name, found in commands._entries().items() if name != "app"}
    monkeypatch.setattr(commands, "_installed", installed)
    monkeypatch.setattr(commands, "_classes", {})
    assert main(["app"]) == 2
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "needs the package roughcontact-app: pip install 'roughcontact[app]'" in sentence
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "\n  app " not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("radius", "along", "text"), [((10e-3, np.inf), 1, "10mm inf"), ((np.inf, 10e-3), 0, "inf 10mm")]
)
def test_a_cylinder_is_straight_along_an_infinite_radius(tmp_path, capsys, radius, along, text):
    out = tmp_path / "cylinder.npz"
    arguments = f"surface paraboloid --radius {text} --shape 15 9 --size 90um 18um".split()
    assert main([*arguments, "-o", str(out)]) == 0
    with np.load(out) as data:
        assert (np.ptp(data["heights"], axis=along) == 0.0).all()
        expected = rc.ParaboloidSurface(radius).heights(rc.Grid((15, 9), (90e-6, 18e-6)))
        np.testing.assert_array_equal(data["heights"], expected)
    assert rc.ParaboloidSurface(tuple(text.split())) == rc.ParaboloidSurface(radius)
    table = {"radius": text.split()}
    assert rc.faces.build_part(rc.surfaces, "paraboloid", table, "it") == rc.ParaboloidSurface(radius)


@pytest.mark.parametrize("wrong", ["sphere --radius inf", "paraboloid --radius inf", "paraboloid --radius inf inf"])
def test_what_cannot_be_infinite_is_refused(capsys, wrong):
    status = None
    try:
        status = main([*f"surface {wrong}".split(), "--shape", "8", "8", "--size", "1mm"])
    except SystemExit as ended:
        status = ended.code
    assert status == 2
    assert "inf" in capsys.readouterr().err


def test_without_a_command_the_help_is_shown(capsys):
    assert main([]) == 2
    printed = capsys.readouterr()
    assert printed.out.startswith("usage: roughcontact")
    assert "solve" in printed.out
    assert printed.err == ""


def test_a_long_error_breaks_at_blanks_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["solve", "none.npz", "--force", "1N", "--young", "1GPa", "--pull-off"]) == 2
    wrapped = capsys.readouterr().err
    assert max(map(len, wrapped.splitlines())) < 40
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False)
    assert main(["solve", "none.npz", "--force", "1N", "--young", "1GPa", "--pull-off"]) == 2
    assert capsys.readouterr().err.split() == wrapped.split()
