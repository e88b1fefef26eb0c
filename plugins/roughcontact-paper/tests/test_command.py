"""The command, from its arguments to its files, and that it uses public names only."""

from __future__ import annotations

import ast
import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest
import roughcontact
from roughcontact.__main__ import main

import roughcontact_paper
from roughcontact_paper import published, sections, synthetic_pair

PNG = b"\x89PNG"
MODULES = sorted(Path(roughcontact_paper.__file__).parent.glob("*.py"))


def test_it_writes_tables_and_figures(tmp_path, capsys, monkeypatch, case_of):
    monkeypatch.setattr(sections, "solve_wave", case_of)
    assert main(["paper", "-o", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    assert "Errors in the print" in text
    assert "--full" in text
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {f"table{n}.csv" for n in (1, 2, 3)} | {f"figure{n}.png" for n in (3, 4, 5, 6)}
    for name in names:
        if name.endswith("png"):
            assert (tmp_path / "out" / name).read_bytes()[:4] == PNG
    with (tmp_path / "out" / "table2.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:5] == ["load MPa", "N", "analytic %", "SAM %", "SAM error %"]
    assert rows[0][-2:] == ["iter.", "CPU s"]
    assert rows[1][:5] == ["50", "64", "0.713", "2.734", "283.7"]
    for name in ("table1", "table2", "table3"):
        require_whole(tmp_path / "out" / f"{name}.csv", text)


def require_whole(path, text):
    """Require that no two columns of a table have one name, and that every row stands in one line, as on a pipe."""
    with path.open(newline="") as file:
        columns, *rows = csv.reader(file)
    assert len(set(columns)) == len(columns)
    printed = [line.split() for line in text.splitlines()]
    for row in (columns, *rows):
        assert " ".join(row).split() in printed


@pytest.mark.parametrize("width", [40, 80, 200])
def test_tables_are_folded_to_a_terminal_of_any_width_and_lose_no_column(tmp_path, capsys, monkeypatch, case_of, width):
    monkeypatch.setattr(sections, "solve_wave", case_of)
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert main(["paper", "-o", str(tmp_path)]) == 0
    lines = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out).splitlines()
    assert max(len(line) for line in lines if line.split()[:1] in (["load"], ["50"], ["100"], ["200"])) <= width
    for number, keys in ((1, 2), (2, 2), (3, 1)):
        with (tmp_path / f"table{number}.csv").open(newline="") as file:
            columns, *rows = csv.reader(file)
        headings = [line for line in lines if line.split()[:2] == ["load", "MPa"]]
        assert all(any(name in heading for heading in headings) for name in columns)
        for row in rows:
            found = {cell for line in lines if (cells := line.split())[:keys] == row[:keys] for cell in cells}
            assert found.issuperset(row)


@pytest.mark.slow
def test_pairs_writes_tables_figures_and_maps(tmp_path, capsys, monkeypatch):
    """On grids that take seconds."""
    monkeypatch.setattr(published, "GRIDS", (256, 512, 1024))
    monkeypatch.setattr(synthetic_pair, "PLACES", 1)
    out = tmp_path / "out"
    assert main(["paper", "--pairs", "-o", str(out)]) == 0
    first = capsys.readouterr().out
    assert "running in, cycle 1 of a round:" in first
    assert "Table 5: areas on 512 x 512 cells" in first
    figures = {f"figure{number}.png" for number in range(8, 14)}
    assert {path.name for path in out.iterdir()} == {
        "table4.csv",
        "pairs.csv",
        "table5.csv",
        "run-in-512.npz",
        *figures,
    }
    for name in figures:
        assert (out / name).read_bytes()[:4] == PNG
    with (out / "table5.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    for name in ("table5", "pairs"):
        require_whole(out / f"{name}.csv", first)
    assert [row[:2] for row in rows[1:3]] == [["before 2.5", "540/510"], ["before 5", "1126/1063"]]
    # Running in is not repeated, and the results are the same.
    assert main(["paper", "--pairs", "-o", str(out)]) == 0
    again = [line for line in capsys.readouterr().out.splitlines() if "solves took" not in line]
    assert again == [
        line for line in first.splitlines() if "running in, cycle" not in line and "solves took" not in line
    ]


def test_an_output_folder_that_cannot_be_made_is_named(tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    assert main(["paper", "-o", str(tmp_path / "taken")]) == 2
    assert "taken" in capsys.readouterr().err


def test_its_help_waits_for_nothing_heavy():
    script = "import sys, roughcontact_paper.command; print({'matplotlib', 'rich', 'scipy.ndimage'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_it_uses_public_names_only(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "roughcontact":
            assert "._" not in node.module
            assert not any(alias.name.startswith("_") for alias in node.names)
        if isinstance(node, ast.Attribute):
            assert not node.attr.startswith("_")
            if isinstance(node.value, ast.Name) and node.value.id == "rc":
                assert node.attr in roughcontact.__all__
