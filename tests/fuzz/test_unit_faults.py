"""Files of figures and lists when the disk is full or the folder is read-only."""

from __future__ import annotations

import os

import numpy as np
import pytest
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.__main__ import main as command
from roughcontact._faces.panels.figures import save_figure
from roughcontact.errors import NotWritten
from roughcontact.typing import Table
from scenes import ELASTIC, SMALL_GRID, SMALL_ROUGH, list_unfinished, small_problem, small_study
from test_faults import full_disk, without_privileges
from unit_files import write_list

# Ways to write a file of each format, by its name.
FORMATS = {
    "solution.npz": lambda path, made: made["solution"].save(path),
    "solution.nc": lambda path, made: made["solution"].save(path),
    "records.csv": lambda path, made: made["result"].to_csv(path),
    "report.csv": lambda path, made: made["report"].to_csv(path),
    **{f"report.{ending}": lambda path, made: made["report"].draw(path) for ending in ("png", "svg", "pdf")},
    "solution.png": lambda path, made: save_figure(made["solution"].plot(), path),
    "study.json": lambda path, made: write_list(path, made["result"].records),
    "table.csv": lambda path, made: paper_output().write_results([made["table"]], {}, path.parent),
    "figure.png": lambda path, made: paper_output().write_results([], {"figure": Figure()}, path.parent),
    "maps.npz": lambda path, made: paper_maps()._write(path, "key", (made["maps"], 0.0, True)),
}


def paper_output():
    return pytest.importorskip("roughcontact_paper.output")


def paper_maps():
    return pytest.importorskip("roughcontact_paper.synthetic_pair")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """What there is to write, and whole files of it."""
    folder = tmp_path_factory.mktemp("whole")
    pytest.importorskip("h5netcdf")
    cells = Table.from_rows([f"column {place}" for place in range(80)], [tuple("1234" * 20)] * 9)
    table = paper_output().PaperTable("table", "title", cells)
    rough = rc.HeightMap(SMALL_ROUGH.heights(SMALL_GRID), 264.2e-6)
    found = {
        "solution": small_problem().solve(force=0.1),
        "result": small_study(seeds=[0]).run(folder / "study"),
        "report": rc.error_vs_time(small_problem(), force=0.1, reference={"area": 1e-9}, cells=[12, 24], repeats=1),
        "table": table,
        "maps": rc.ContactProblem(rc.Body(rough, ELASTIC), rc.Body(rough, ELASTIC)),
    }
    for name, write in FORMATS.items():
        write(folder / name, found)
    return {**found, "folder": folder}


class TestDisk:
    @pytest.mark.slow
    @pytest.mark.parametrize("name", FORMATS)
    def test_full(self, tmp_path, made, name):
        (tmp_path / name).write_text("what was there")
        size = (made["folder"] / name).stat().st_size
        for part in (0.0, 0.5, 0.99) if name.endswith(("npz", "csv")) else (0.5,):
            # The size of a file may change by a few digits of a time.
            with (
                full_disk(int(part * size)),
                pytest.raises(NotWritten, match=f"{name}' cannot be written: File too large"),
            ):
                FORMATS[name](tmp_path / name, made)
            assert (tmp_path / name).read_text() == "what was there"
            assert not list_unfinished(tmp_path)

    @pytest.mark.parametrize("name", [name for name in FORMATS if not name.endswith(("png", "svg", "pdf"))])
    def test_read_only(self, tmp_path, made, name):
        (tmp_path / name).write_text("what was there")
        tmp_path.chmod(0o555)
        with without_privileges(), pytest.raises(NotWritten, match=f"{name}' cannot be written: Permission denied"):
            FORMATS[name](tmp_path / name, made)
        assert os.listdir(tmp_path) == [name]
        assert (tmp_path / name).read_text() == "what was there"

    def test_the_command(self, tmp_path, made, capsys, monkeypatch):
        monkeypatch.chdir(tmp_path)
        np.savez(tmp_path / "map.npz", heights=SMALL_ROUGH.heights(SMALL_GRID), size=1e-4)
        solve = ["solve", "map.npz", "--force", "0.1N", "--young", "200GPa", "-o", "out"]
        with full_disk(500):
            assert command(solve) == 2
        assert "cannot be written: File too large" in capsys.readouterr().err
        assert os.listdir(tmp_path / "out") == []
        with full_disk((made["folder"] / "solution.npz").stat().st_size + 5000):
            assert command(solve) == 2
        assert "solution.png' cannot be written" in capsys.readouterr().err
        assert os.listdir(tmp_path / "out") == ["solution.npz"]
