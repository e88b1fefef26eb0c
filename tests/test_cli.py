from __future__ import annotations

import csv
import subprocess
import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact.cli import paper
from roughcontact.cli.units import quantity
from roughcontact.paper import printed, stand_in

PNG = b"\x89PNG"


@pytest.fixture
def height_map(tmp_path):
    path = tmp_path / "map.npz"
    rng = np.random.default_rng(0)
    np.savez(path, heights=1e-7 * rng.random((20, 24)), size=(20e-6, 24e-6))
    return path


def test_paper_writes_tables_and_figures(tmp_path, capsys, monkeypatch, case_of):
    monkeypatch.setattr(paper, "run_case", case_of)
    assert main(["paper", "-o", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert "Where the print is wrong" in text
    assert "--full" in text
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"table1.csv", "table2.csv", "table3.csv", "figure4.png", "figure5.png", "figure6.png"}
    for name in names:
        if name.endswith("png"):
            assert (tmp_path / "out" / name).read_bytes()[:4] == PNG
    with (tmp_path / "out" / "table2.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:3] == ["load MPa", "N", "cells"]
    assert rows[1][:3] == ["50", "64", "112"]


@pytest.fixture
def small_pairs(monkeypatch):
    """The second half of the paper on grids that take seconds."""
    monkeypatch.setattr(printed, "GRIDS", (256, 512, 1024))
    monkeypatch.setattr(stand_in, "PLACES", 1)


@pytest.mark.slow
def test_paper_pairs_writes_tables_figures_and_maps(small_pairs, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["paper", "--pairs", "-o", str(out)]) == 0
    first = capsys.readouterr().out
    assert "running in, place 1:" in first
    assert "Table 5: areas on 512 x 512 cells" in first
    figures = {f"figure{number}.png" for number in range(8, 14)}
    assert {path.name for path in out.iterdir()} == {"pairs.csv", "table5.csv", "run-in-512.npz", *figures}
    for name in figures:
        assert (out / name).read_bytes()[:4] == PNG
    with (out / "table5.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert [row[:2] for row in rows[1:3]] == [["before 2.5", "540/510"], ["before 5", "1126/1063"]]
    # What was run in is not run in again, and gives the same.
    assert main(["paper", "--pairs", "-o", str(out)]) == 0
    again = [line for line in capsys.readouterr().out.splitlines() if "solves took" not in line]
    assert again == [
        line for line in first.splitlines() if "running in, place" not in line and "solves took" not in line
    ]


def test_solve_writes_summary_fields_and_picture(height_map, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["solve", str(height_map), "--pressure", "10MPa", "--young", "210GPa", "-o", str(out)]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    for words in ("converged", "mean pressure  10 MPa", "contact area", "left out", "solution.npz"):
        assert words in text
    with np.load(out / "solution.npz") as data:
        assert data["pressure"].mean() == pytest.approx(1e7)
    assert (out / "solution.png").read_bytes()[:4] == PNG


def test_solve_takes_a_pair_with_every_option(height_map, tmp_path, capsys):
    np.savetxt(tmp_path / "other.txt", 1e-7 * np.random.default_rng(1).random((20, 24)))
    np.save(tmp_path / "one.npy", 1e-7 * np.random.default_rng(0).random((20, 24)))
    options = (
        "--force 5mN --young 210GPa --poisson 0.25 --hardness 6GPa --counter-young 3.2e5MPa --counter-poisson 0.2 "
        "--counter-hardness 10GPa --size 20um 24um --detrend 2 --resample 32 32 --boundary free --area cell-count"
    ).split()
    paths = [str(tmp_path / name) for name in ("one.npy", "other.txt")]
    assert main(["solve", *paths, *options, "-o", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert "force          5 mN" in text
    assert "[cell-count]" in text
    assert "pressure limit 6 GPa" in text
    assert "rigid" not in text


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["--young", "210GPa"], "one of the arguments --pressure --approach --force is required"),
        (["--pressure", "1MPa"], "required: --young"),
        (["--pressure", "1MPa", "--force", "1N", "--young", "1GPa"], "not allowed with"),
        (["--pressure", "1kg", "--young", "1GPa"], "'1kg' has not the unit it needs"),
        (["--pressure", "lots", "--young", "1GPa"], "'lots' is no"),
        (["--pressure", "", "--young", "1GPa"], "is no"),
        (["--pressure", "1MPa", "--young", "210"], "'210' has not the unit it needs"),
        (["--pressure", "1MPa", "--young", "1GPa", "--size", "1", "mm"], "write it like 250um"),
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
        (["--young", "1GPa", "--size", "1um"], "leave size= out"),
        (["--young", "1GPa", "--size", "1um", "2um", "3um"], "one length or two"),
        (["--young", "1GPa", "--kernel", "lave"], "Did you mean 'love'"),
        (["--young", "1GPa", "--counter-hardness", "1GPa"], "give --counter-young"),
        (["--young", "1GPa", "--hardness", "1kPa"], "at most 1 kPa"),
        (["--young", "1GPa", "--area", "guess"], "no area estimator named 'guess'"),
        (["--young", "1GPa", "--solver", "polonsky-keer", "--hardness", "1GPa"], "solver='auto'"),
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
        ("30 %", "dimensionless", 0.3),
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
    assert "Traceback" not in failed.stderr


def test_without_the_extra_the_sentence_says_what_to_install(monkeypatch, capsys):
    for name in [name for name in sys.modules if name.startswith(("rich", "roughcontact.cli"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rich", None)
    assert main(["paper"]) == 2
    assert "pip install 'roughcontact[cli]'" in capsys.readouterr().err


@pytest.fixture
def two_maps(tmp_path):
    """A ball of 200 um in micrometres of height, and a map of another grid."""
    rng = np.random.default_rng(1)
    grid = rc.Grid((40, 40), 40e-6)
    ball = rc.SphereSurface(2e-4).heights(grid)
    np.savetxt(tmp_path / "ball.txt", 1e6 * ball)
    np.savez(tmp_path / "ring.npz", heights=1e-8 * rng.standard_normal((30, 50)), size=(45e-6, 50e-6))
    return [str(tmp_path / name) for name in ("ball.txt", "ring.npz")]


LOAD = "--force 0.05N --young 210GPa --hardness 6GPa --counter-young 210GPa".split()


def test_two_maps_are_matched(two_maps, tmp_path, capsys):
    options = "--size 40um --counter-size 45um 50um --unit 1um --match cubic --rotation 10deg".split()
    more = "--offset 1um,-2um --mirror --counter-detrend plane --domain 25um 20um --resample 50 40".split()
    assert main(["solve", *two_maps, *LOAD, *options, *more, "-o", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    for words in (
        "grid       50 x 40 cells on 25 µm x 20 µm",
        "heights 1  read from ball.txt: 40 x 40",
        "best plane taken away; turned over, x to -x; rotated by 10 degrees; its centre at (",
        "converged",
        "saturated  ",
    ):
        assert words in text


def test_a_ball_gets_its_radius_back(two_maps, tmp_path, capsys):
    """Form taken away, and the nominal ball put in its place: the same as the ball itself."""
    common = [*LOAD, "--size", "40um", "--unit", "1um"]
    forces = []
    for more in ([], ["--detrend", "sphere", "--ball", "200um"]):
        assert main(["solve", two_maps[0], *common, *more, "-o", str(tmp_path)]) == 0
        with np.load(tmp_path / "solution.npz") as data:
            forces.append(data["pressure"])
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-6 * forces[0].max())
    assert "of radius 200 µm; a sphere of radius 200 µm" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--size", "40um"], "bring maps of two domains together"),
        (["--size", "40um", "--counter-size", "40um"], "which is not the size given"),
        (["--size", "40um", "--counter-unit", "1um"], "tells its own unit"),
        (["--size", "40um", "--match", "bilinear", "--domain", "1m"], "was asked for"),
        (["--size", "40um", "--counter-size", "45um", "50um", "--offset", "1um,1um"], "--match bilinear"),
        (["--size", "40um", "--counter-size", "45um", "50um", "--mirror"], "--match bilinear"),
        (["--size", "40um", "--counter-size", "45um", "50um", "--match", "fourier"], "needs a periodic map"),
        (["--size", "40um", "--detrend", "cone"], "The form must be"),
    ],
)
def test_pairs_that_do_not_fit_get_a_sentence(two_maps, tmp_path, capsys, options, words):
    assert main(["solve", *two_maps, *LOAD, *options, "-o", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err


def test_what_is_for_two_maps_is_refused_for_one(two_maps, tmp_path, capsys):
    for option in (["--match", "cubic"], ["--counter-detrend", "1"], ["--counter-unit", "1um"]):
        assert main(["solve", two_maps[0], *LOAD, "--size", "40um", *option, "-o", str(tmp_path)]) == 2
        assert f"{option[0]} is for the second of two height maps" in capsys.readouterr().err


def test_an_angle_needs_its_unit(two_maps, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["solve", *two_maps, *LOAD, "--match", "cubic", "--rotation", "20", "-o", str(tmp_path)])
    assert "write it like 30deg" in capsys.readouterr().err
