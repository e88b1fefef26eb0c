"""What the README and the docs show runs as it stands."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import commands

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Pages whose blocks run with every change; those of the others are for the slow tests.
FIRST = ("README",)
# Commands that take more than some ten seconds.
SLOW = ("roughcontact paper", "roughcontact report")
# Waits until it is ended; tests/test_app*.py drive it.
SERVES = ("roughcontact app",)
# Pages that show numbers with a warning of contact mechanics; any other warning is a fault.
WARNED = ("maps", "tutorial_map", "compare", "edges")
ALLOW = "import warnings\nimport roughcontact\nwarnings.simplefilter('default', roughcontact.ContactWarning)\n"


def blocks_of(page, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.S | re.M)


def commands_of(block):
    """The lines of a shell block that call roughcontact; a backslash continues a line."""
    lines = [line.strip() for line in re.sub(r"\\\n\s*", "", block).splitlines()]
    return [line for line in lines if line.startswith("roughcontact ") and not line.startswith(SERVES)]


def is_installed(package):
    """Its entry points count, which its source on the path does not have."""
    try:
        importlib.metadata.distribution(package.replace("_", "-"))
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def needs(line):
    """Why a line cannot run here, if it cannot."""
    if re.search(r"\.(x3p|opd|plux|sur|datx)\b", line) and "ROUGHCONTACT_MAPS" not in os.environ:
        return "measured maps are in the folder ROUGHCONTACT_MAPS"
    plugins = {"roughcontact paper": "roughcontact_paper", "check ": "roughcontact_example"}
    for word, package in plugins.items():
        if word in line and not is_installed(package):
            return f"{package} is not installed"
    return None


SCRIPTS = [
    pytest.param(page, id=page.stem, marks=[] if page.stem in FIRST else [pytest.mark.slow])
    for page in PAGES
    if blocks_of(page, "python")
]
COMMANDS = [
    pytest.param(
        lines,
        id=f"{page.stem}-{number}",
        marks=[] if page.stem in FIRST and not any(line.startswith(SLOW) for line in lines) else [pytest.mark.slow],
    )
    for page in PAGES
    for number, lines in enumerate(filter(None, map(commands_of, blocks_of(page, "sh"))))
]


@pytest.fixture(scope="session")
def examples(tmp_path_factory):
    """A folder of what the pages mention: maps that the package makes, study files of the pages, and line scans."""
    folder = tmp_path_factory.mktemp("examples")
    rc.examples.write(folder)
    heights = rc.read_surface(folder / "map.npz").values
    for name, lines in {"lines": heights[:, ::24], "one": heights[:, :1], "two": heights[:, 40:80:20]}.items():
        rows = np.column_stack((1e-3 * np.arange(len(lines)), 1e6 * lines))
        names = ["x (mm)", *(f"z{k} (um)" for k in range(lines.shape[1]))]
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=",".join(names), comments="")
    shutil.copy(folder / "two.csv", folder / "other.csv")
    study, friction, wear = blocks_of(ROOT / "docs" / "use" / "studies.md", "toml")
    for name in ("study.toml", "scenes.toml"):
        (folder / name).write_text(study, encoding="utf-8")
    problems = study.partition("[study]")[0]
    (folder / "friction.toml").write_text(problems + friction, encoding="utf-8")
    ball = problems.replace("problems.ball", "problems.pin")
    laws = wear.partition("laws =")[2].partition("\n")[0]
    worn = ball.replace("[problems.pin]", f"[problems.pin]\nlaws ={laws}", 1) + "[study]" + wear.partition("[study]")[2]
    (folder / "wear.toml").write_text(worn, encoding="utf-8")
    return folder


@pytest.fixture
def place(examples, tmp_path):
    """A folder of its own with these files."""
    shutil.copytree(examples, tmp_path, dirs_exist_ok=True)
    for path in Path(os.environ.get("ROUGHCONTACT_MAPS", "nowhere")).glob("*"):
        (tmp_path / path.name).symlink_to(path)
    return tmp_path


def run(command, place):
    paths = [str(path) for path in (ROOT / "plugins").glob("*/src")]
    scripts = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PATH": scripts, "MPLBACKEND": "agg"}
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=place, env=environment)


@pytest.mark.parametrize("page", SCRIPTS)
def test_scripts_of_the_pages_run(page, place):
    """The python blocks of a page, one after the other, as a reader would run them."""
    script = "\n".join(blocks_of(page, "python"))
    done = run([sys.executable, "-W", "error", "-c", (ALLOW if page.stem in WARNED else "") + script], place)
    assert done.returncode == 0, done.stderr
    assert ("ContactWarning" in done.stderr) == (page.stem in WARNED)
    if page.stem == "README":
        assert [done.stdout] == blocks_of(page, "text")
    if page.stem == "tutorial_conductance":
        assert (place / "ground_on_aluminium.inp").read_text("ascii").count("*GAP CONDUCTANCE, PRESSURE") == 1


def examples_of(name):
    """The commands in the help of a command."""
    text = re.sub(r"\\\n\s*", "", commands.create(name).epilog)
    lines = re.findall(r"^  (roughcontact .*)$", text, re.M)
    return [line for line in lines if not line.startswith(SERVES)]


OURS = [name for name in commands if commands[name].__module__.startswith("roughcontact.")]


@pytest.mark.slow
@pytest.mark.parametrize("name", OURS)
def test_examples_of_the_help_run(name, place):
    """One after the other, in a folder with the files that they mention."""
    lines = examples_of(name)
    if any("contact.npz" in line.split(" -o ")[0] for line in lines):
        lines = ["roughcontact solve map.npz --force 1N --young 210GPa -o contact.npz", *lines]
    for line in lines:
        done = run(["bash", "-c", line.replace("~/", "").partition(" | ")[0]], place)
        assert done.returncode in (0, 1, 3), line + done.stdout + done.stderr


@pytest.mark.parametrize("lines", COMMANDS)
def test_command_lines_of_the_pages_run(lines, place):
    """Those of a block one after the other, as a reader would type them."""
    absent = {line: reason for line in lines if (reason := needs(line))}
    if len(absent) == len(lines):
        pytest.skip("; ".join(set(absent.values())))
    for line in lines:
        if line in absent:
            continue
        done = run(["bash", "-c", line], place)
        # A solve with warnings ends in 3, a check that finds something in 1: both have answered.
        allowed = (0, 1) if line.startswith("roughcontact stability") else (0, 3)
        assert done.returncode in allowed, line + done.stdout + done.stderr
        assert "Traceback" not in done.stderr


def test_what_does_not_run_says_so():
    """Every block is of a kind that is run or written out: a python block with another name has a test of its own."""
    kinds = {kind for page in PAGES for kind in re.findall(r"^```(\w[^\n]*)$", page.read_text("utf-8"), re.M)}
    assert kinds <= {"python", "python maps", "python jax", "python torch", "sh", "text", "toml", "md", "py"}
    assert [page.stem for page in PAGES if "```bash" in page.read_text("utf-8")] == []


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


@pytest.mark.slow
def test_overview(monkeypatch, tmp_path):
    overview = study("overview", monkeypatch)
    overview.main(128, 256, tmp_path)
    assert (tmp_path / "overview.png").stat().st_size > 10_000
    # The errors are those of the contact that the other panels show.
    counted = overview.draw(64, 128).axes[2].lines[0]
    error = overview.press(64).area("cell-count").value / overview.press(128).area().value - 1.0
    assert counted.get_xydata().tolist() == [[64.0, pytest.approx(100.0 * error)]]


@pytest.mark.slow
def test_gradients(monkeypatch, tmp_path):
    module = study("gradients", monkeypatch)
    assert [row[0] for row in module.make_rows(1, (1,))][1:3] == ["ball, radius of 3 cells", "ball, radius of 6 cells"]
    module.main(32, 1, 2, tmp_path)
    assert (tmp_path / "gradients.png").stat().st_size > 10_000


@pytest.mark.slow
def test_partial_slip(monkeypatch, tmp_path):
    module = study("partial_slip", monkeypatch)
    head, *rows = module.make_rows((3,), 2)
    assert head[:2] == ["contact radius, cells", "Q / (µ P)"]
    assert [row[:2] for row in rows] == [["3", "0.2"], ["3", "0.5"], ["3", "0.9"]]
    module.main(64, 2, tmp_path)
    assert (tmp_path / "partial_slip.png").stat().st_size > 10_000


@pytest.mark.slow
def test_which_estimator(monkeypatch, tmp_path):
    module = study("which_estimator", monkeypatch)
    wave = module.make_table(module.measure_wave((64, 128), 1))
    assert [row[0] for row in wave] == ["N", "64", "128"]
    module.main(wave, module.make_table(module.measure_rough((64, 128), 256, 1)), tmp_path)
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


@pytest.mark.slow
def test_random_problems(monkeypatch, capsys):
    counts, wrong = study("random_problems", monkeypatch).main(30)
    assert sum(counts.values()) == 30
    assert not wrong
    assert "30 problems" in capsys.readouterr().out


@pytest.mark.slow
def test_capped_ball(monkeypatch, tmp_path):
    capped = study("capped_ball", monkeypatch)
    assert [row[0] for row in capped.make_rows(64, 300)[1:]] == ["1.1", "1.5", "2", "3", "5", "8", "12"]
    capped.main(64, 300, tmp_path)
    assert (tmp_path / "capped_ball.png").stat().st_size > 10_000


@pytest.mark.slow
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
    """Peak resident memory of a process of its own, and at most a quarter more, of which an allocator keeps some."""
    memory = study("memory", monkeypatch)
    for cells, *case in (
        (1024, "periodic", 0.0, 0.05),
        (2048, "periodic", 0.0, 0.5),
        (1024, "free", 0.0, 0.05),
        (1024, "free", 0.0, 0.5),
    ):
        _, measured, stated = memory.measure_in_process(cells, *case)
        assert measured <= stated <= 1.25 * measured, case


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
    for page in [*PAGES, ROOT / "plugins" / "README.md", *ROOT.glob("plugins/*/README.md")]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.slow
def test_the_studies_of_paths_are_read(place):
    """Its counterbody is rigid, and its map has the non-measured points filled."""
    for name, said in (("friction", "tangential force (100 mN, 0 N)"), ("wear", "sliding")):
        done = run(["roughcontact", "run", f"{name}.toml", "--dry-run"], place)
        assert done.returncode == 0, done.stderr
        assert said in " ".join(done.stdout.split())
