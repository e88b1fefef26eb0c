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
    *(
        ROOT / "docs" / f"{name}.md"
        for name in (
            "area",
            "bridges",
            "gradients",
            "interface_laws",
            "maps",
            "mistakes",
            "pairs",
            "partial_slip",
            "plugins",
            "responses",
            "stability",
            "studies",
            "theory_beside",
        )
    ),
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


def test_the_tutorial_runs_block_after_block(tmp_path):
    text = (ROOT / "docs" / "tutorial_conductance.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    test_scripts_of_the_pages_run("\n".join(blocks), tmp_path)
    assert (tmp_path / "ground_on_aluminium.inp").read_text(encoding="ascii").count("*GAP CONDUCTANCE, PRESSURE") == 1


def study(name, monkeypatch):
    """Import a study; the paper's values come from its plug-in, installed or not."""
    for folder in (ROOT / "plugins" / "roughcontact-paper" / "src", ROOT / "docs" / "studies"):
        monkeypatch.syspath_prepend(str(folder))
    return __import__(name)


def test_error_against_run_time(monkeypatch, tmp_path):
    module = study("error_vs_time", monkeypatch)
    assert [row[0] for row in module.make_rows((64, 128), 1)] == ["N", "64", "128"]
    module.main((64, 128), 1, tmp_path)
    assert (tmp_path / "error_vs_time.png").stat().st_size > 10_000


@pytest.mark.slow
def test_theory_and_laws(monkeypatch, tmp_path):
    persson, laws = study("persson", monkeypatch), study("interface_law", monkeypatch)
    area, ratio, gap, stiffness = persson.measure(0.8, 1, (0.05,), 256)[0]
    assert 0.09 < area < 0.13
    assert 0.7 < ratio < 0.8
    assert abs(gap) < 0.1
    assert 0.8 < stiffness < 1.1
    persson.draw(tmp_path, 64)
    laws.draw(tmp_path, 128)
    for name in ("theory_beside.png", "interface_law.png"):
        assert (tmp_path / name).stat().st_size > 10_000


def test_overview(monkeypatch, tmp_path):
    study("overview", monkeypatch).main(128, 128, tmp_path)
    assert (tmp_path / "overview.png").stat().st_size > 10_000


@pytest.mark.slow
def test_gradients(monkeypatch, tmp_path):
    module = study("gradients", monkeypatch)
    assert [row[0] for row in module.make_rows(1, (1,))][1:3] == ["ball, radius of 3 cells", "ball, radius of 6 cells"]
    module.main(32, 1, 2, tmp_path)
    assert (tmp_path / "gradients.png").stat().st_size > 10_000


def test_partial_slip(monkeypatch, tmp_path):
    module = study("partial_slip", monkeypatch)
    assert [row[0] for row in module.make_rows((3,), 2)] == ["contact radius, cells", "3"]
    module.main(64, 2, tmp_path)
    assert (tmp_path / "partial_slip.png").stat().st_size > 10_000


def test_which_estimator(monkeypatch, tmp_path):
    module = study("which_estimator", monkeypatch)
    module.main((64, 128), (64, 128), 256, 1, tmp_path)
    assert [row[0] for row in module.make_table(module.measure_wave((64, 128), 1))] == ["N", "64", "128"]
    for name in ("one_summit.png", "estimator_errors.png"):
        assert (tmp_path / name).stat().st_size > 10_000


@pytest.mark.slow
def test_lost_heights(monkeypatch, tmp_path):
    module = study("lost_heights", monkeypatch)
    monkeypatch.setattr("roughcontact_paper.synthetic_pair.PLACES", 1)
    rows = module.make_rows(finest=512, coarsest=256, maps=tmp_path)
    assert [row[1] for row in rows] == ["N"] + 4 * ["256", "512"]
    module.main(rows, tmp_path)
    assert (tmp_path / "lost_heights.png").stat().st_size > 10_000


def test_random_problems(monkeypatch, capsys):
    counts, wrong = study("random_problems", monkeypatch).main(30)
    assert sum(counts.values()) == 30
    assert not wrong
    assert "30 problems" in capsys.readouterr().out


def test_capped_ball(monkeypatch, tmp_path):
    capped = study("capped_ball", monkeypatch)
    assert [row[0] for row in capped.make_rows(64, 300)[1:]] == ["1.1", "1.5", "2", "3", "5", "8", "12"]
    capped.main(64, 300, tmp_path)
    assert (tmp_path / "capped_ball.png").stat().st_size > 10_000


def test_finite_elements(monkeypatch):
    fits = study("finite_elements", monkeypatch)
    stored = __import__("doc_tables").read("finite-elements")
    monkeypatch.setattr(fits, "INTERFERENCES", (10.0,))
    table = fits.TABLES["finite-elements"]
    assert __import__("doc_tables").compare(fits.make_rows(), [stored[0], stored[4]], table) == []
    # Both fits join their elastic branch, and each other at the interference where they change.
    assert fits.kogut_etsion(6.0) == pytest.approx(fits.kogut_etsion(6.0 + 1e-9), rel=0.03)
    assert fits.jackson_green(1.9, 1e-3)[:2] == pytest.approx((1.9**1.5, 1.9), rel=0.01)


@pytest.mark.slow
def test_the_plan_states_the_memory_of_a_solve(monkeypatch):
    """Peak resident memory of a process of its own, to a tenth; less if others hold up its second thread."""
    memory = study("memory", monkeypatch)
    for case in (("periodic", 0.0, 0.05), ("periodic", 0.0, 0.5), ("free", 0.0, 0.05), ("free", 0.0, 0.5)):
        _, measured, stated = memory.measure_in_process(2048, *case)
        assert 0.9 * measured <= stated <= 1.25 * measured, case


def test_omitted(monkeypatch, capsys):
    study("omitted", monkeypatch).main(64, 1)
    assert capsys.readouterr().out.count("|") > 25


def test_comparison_judges_ours_by_its_own_function(monkeypatch):
    compare = study("compare_codes", monkeypatch)
    for boundary, hardness in (("periodic", None), ("free", None), ("periodic", 0.03)):
        case = compare.Case("small", compare.make_rough(64), 0.005, boundary, hardness)
        pressure = compare.solve_ours(case, 1e-9)
        gap, load = compare.measure_violation(pressure, case)
        assert gap < 3e-9
        assert load < 1e-12
        gap, load = compare.measure_violation(2 * pressure, case)
        assert gap > 1e-2
        assert load == pytest.approx(1.0)


def test_comparison_takes_the_loosest_tolerance_that_is_good_enough(monkeypatch):
    compare = study("compare_codes", monkeypatch)
    case = compare.Case("small", compare.make_rough(64), 0.005)
    tried = []

    def solve(case, tolerance):
        tried.append(tolerance)
        return compare.solve_ours(case, tolerance)

    found = compare.match_run(compare.Peer("ours", solve, 1e-2), case, 1e-5)
    assert found.tolerance == tried[-1] == min(tried)
    assert found.violation <= 1e-5
    assert compare.measure_run(lambda case: compare.solve_ours(case, tried[-2]), case).violation > 1e-5
    assert compare.match_run(compare.Peer("none", lambda case, tolerance: None, 1e-2), case, 1e-5) is None


def test_links_of_the_pages_lead_somewhere():
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "plugins").rglob("README.md")]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
