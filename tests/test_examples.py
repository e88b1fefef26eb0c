"""What the README and the docs show runs as it stands."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [
    ROOT / "README.md",
    *(ROOT / "docs" / f"{name}.md" for name in ("plugins", "area", "pairs", "stability", "studies")),
]
BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in PAGES
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S))
]


@pytest.mark.parametrize("block", BLOCKS)
def test_scripts_of_the_pages_run(block, tmp_path):
    command = [sys.executable, "-W", "error", "-c", block]
    plugins = os.pathsep.join(str(path) for path in (ROOT / "plugins").glob("*/src"))
    environment = {**os.environ, "PYTHONPATH": plugins}
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr


def study(name, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "studies"))
    return __import__(name)


def test_error_against_run_time(monkeypatch, tmp_path, capsys):
    study("error_vs_time", monkeypatch).main((64, 128), 1, tmp_path)
    assert "| 128 |" in capsys.readouterr().out
    assert (tmp_path / "error_vs_time.png").stat().st_size > 10_000


def test_overview(monkeypatch, tmp_path):
    study("overview", monkeypatch).main(128, 128, tmp_path)
    assert (tmp_path / "overview.png").stat().st_size > 10_000


def test_which_estimator(monkeypatch, tmp_path, capsys):
    study("which_estimator", monkeypatch).main((64, 128), (64, 128), 256, 1, tmp_path)
    assert capsys.readouterr().out.count("| 128 |") == 2
    for name in ("one_summit.png", "estimator_errors.png"):
        assert (tmp_path / name).stat().st_size > 10_000


def test_lost_heights(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("roughcontact.paper.stand_in.PLACES", 1)
    study("lost_heights", monkeypatch).main(512, 256, tmp_path, tmp_path)
    assert capsys.readouterr().out.count("| 512 |") == 4
    assert (tmp_path / "lost_heights.png").stat().st_size > 10_000


def test_random_problems(monkeypatch, capsys):
    found = study("random_problems", monkeypatch).main(30)
    assert sum(found.counts.values()) == 30
    assert not found.wrong
    assert "30 problems" in capsys.readouterr().out


def test_capped_ball(monkeypatch, tmp_path, capsys):
    study("capped_ball", monkeypatch).main(64, 300, tmp_path)
    assert "| 12 |" in capsys.readouterr().out
    assert (tmp_path / "capped_ball.png").stat().st_size > 10_000


@pytest.mark.slow
def test_the_plan_states_the_memory_of_a_solve(monkeypatch):
    """Peak resident memory of a process of its own, to a tenth."""
    memory = study("memory", monkeypatch)
    for case in (("periodic", 0.0, 0.05), ("periodic", 0.0, 0.5), ("free", 0.0, 0.05), ("free", 0.0, 0.5)):
        _, measured, stated = memory.in_process(2048, *case)
        assert stated == pytest.approx(measured, rel=0.1), case


def test_left_out(monkeypatch, capsys):
    study("left_out", monkeypatch).main(64, 1)
    assert capsys.readouterr().out.count("|") > 25


def test_comparison_judges_ours_by_its_own_function(monkeypatch):
    compare = study("compare_codes", monkeypatch)
    for boundary, hardness in (("periodic", None), ("free", None), ("periodic", 0.03)):
        case = compare.Case("small", compare.rough(64), 0.005, boundary, hardness)
        pressure = compare.ours(case, 1e-9)
        gap, load = compare.violation(pressure, case)
        assert gap < 3e-9
        assert load < 1e-12
        gap, load = compare.violation(2 * pressure, case)
        assert gap > 1e-2
        assert load == pytest.approx(1.0)


def test_links_of_the_pages_lead_somewhere():
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "plugins").rglob("README.md")]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
