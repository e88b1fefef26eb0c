from __future__ import annotations

import csv
import subprocess
import sys

import numpy as np
import pytest

from roughcontact.__main__ import main
from roughcontact.cli import paper
from roughcontact.cli.units import quantity

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
