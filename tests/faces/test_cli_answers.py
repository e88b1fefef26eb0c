"""What the command line prints and writes: the same numbers as the API's, in 80 columns, with core packages alone."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import commands
from scenes import read_problem
from systems import posix

GRID = rc.Grid((48, 48), 48e-6)
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_height=50e-9, shortest=8e-6, longest=48e-6, seed=3)
STEEL = ["--young", "210GPa"]


def write_maps():
    """Write a rough map, a periodic one and a ball into the working folder."""
    heights = ROUGH.heights(GRID)
    np.savez("rough.npz", heights=heights, size=GRID.size)
    np.savez("periodic.npz", heights=heights, size=GRID.size, periodic=True)
    np.savez("ball.npz", heights=rc.SphereSurface(1e-3).heights(GRID), size=GRID.size)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_maps()
    return tmp_path


def solve(name="rough.npz", boundary="free", **load):
    return read_problem(name, boundary).solve(**load)


def too_wide(text):
    return [line for line in text.splitlines() if len(line) > 80]


def test_uncertainties_are_found_from_what_is_asked(run):
    heights = np.where(np.hypot(GRID.x - 1.3e-6, GRID.y + 0.4e-6) < 1e-5, 0.0, -1e-6)
    np.savez("punch.npz", heights=heights, size=GRID.size)
    solution = solve("punch.npz", pressure=50e6)
    found = {}
    for kind in ("auto", "model", "two grids"):
        _, out, _ = run("solve", "punch.npz", "--pressure", "50MPa", *STEEL, "--json", "--uncertainty", kind)
        found[kind] = json.loads(out)["area"]["uncertainty"]
        assert found[kind] == solution.area(uncertainty=kind).uncertainty
    assert found["auto"] == found["two grids"] != found["model"]
    status, _, err = run("solve", "punch.npz", *STEEL, "--solve-for", "area=10%", "--uncertainty", "model")
    assert status != 0
    assert "--uncertainty needs a load that is given" in err


class TestJson:
    def test_it_states_the_numbers_of_the_api(self, run):
        status, out, _ = run("solve", "rough.npz", "--pressure", "50MPa", *STEEL, "--json", "--area", "cell-count")
        found, solution = json.loads(out), solve(pressure=50e6)
        assert status == (3 if solution.warnings else 0)
        for name, area in (("area", solution.area()), ("other_area", solution.area("cell-count"))):
            for key in ("value", "uncertainty", "fraction", "estimator"):
                assert found[name][key] == getattr(area, key)
            assert found[name]["warnings"] == list(area.warnings)
            assert found[name]["unit"] == "m2"
        peak = solution.peak_pressure()
        assert found["peak_pressure"]["value"] == peak.value
        assert found["peak_pressure"]["uncertainty"] == peak.uncertainty
        for name, unit in (("force", "N"), ("mean_pressure", "Pa"), ("approach", "m")):
            assert found[name] == {"value": getattr(solution, name), "unit": unit}
        assert found["contact_modulus"]["value"] == solution.modulus
        assert found["status"] == solution.status.name
        assert found["converged"] is True
        assert found["warnings"] == list(solution.warnings)
        assert found["residuals"]["penetration"] == solution.residuals.penetration
        assert found["grid"] == {"shape": [48, 48], "size": {"value": [48e-6, 48e-6], "unit": "m"}}
        assert found["boundary"] == "free"
        assert found["inputs"]["load"] == {"kind": "pressure", "value": 50e6, "unit": "Pa"}
        assert found["inputs"]["body"]["material"] == "rc.Elastic(young=210e9, poisson=0.3)"
        assert found["inputs"]["body"]["provenance"] == list(rc.read_surface("rough.npz").provenance)
        assert found["inputs"]["counterbody"] == {"surface": "rc.FlatSurface()", "material": "rc.Rigid()"}
        assert found["inputs"]["solver"] == "rc.ProjectedConjugateGradient()"
        assert found["accuracy"] is None
        for name, estimate in (("contact area", solution.area()), ("maximum pressure", peak)):
            assert f"{name} +- {100.0 * estimate.sampling / estimate.value:.2g} %" in found["other_places"]
        assert found["saturated_area"] is None
        assert found["cost"]["convolutions"] == solution.convolutions
        assert found["versions"]["roughcontact"] == rc.__version__

    def test_several_loads_are_a_list(self, run):
        _, out, _ = run("solve", "rough.npz", "--loads", "10mN", "30mN", *STEEL, "--hardness", "2GPa", "--json")
        found = json.loads(out)
        assert [one["force"]["value"] for one in found["solutions"]] == pytest.approx([0.01, 0.03])
        assert all(one["saturated_area"]["unit"] == "m2" for one in found["solutions"])
        assert "versions" in found

    def test_nothing_else_is_on_standard_output(self, run):
        options = ["--pressure", "50MPa", *STEEL, "--json", "--explain", "-o", "x.npz"]
        _, out, err = run("solve", "rough.npz", *options)
        assert json.loads(out)
        assert "omitted" in err

    def test_an_answer_that_is_not_certified_is_printed_and_fails(self, run):
        options = ["--pressure", "50MPa", *STEEL, "--json", "--area-within", "1e-6"]
        status, out, err = run("solve", "rough.npz", *options)
        assert status == 1
        assert json.loads(out)["accuracy"]["met"] is False
        assert "is not reached" in err


class TestCsv:
    def test_each_load_is_a_row_as_in_the_table_of_a_sweep(self, run):
        _, out, _ = run("solve", "rough.npz", "--loads", "20MPa", "50MPa", *STEEL, "--csv")
        rows = list(csv.DictReader(io.StringIO(out)))
        sweep = rc.ContactProblem(rc.Body(rc.read_surface("rough.npz"), rc.Elastic(210e9, 0.3))).sweep(
            pressure=[20e6, 50e6]
        )
        sweep.to_csv("sweep.csv")
        with open("sweep.csv", newline="") as file:
            expected = list(csv.DictReader(file))
        assert len(rows) == len(expected) == 2
        for row, wanted in zip(rows, expected, strict=True):
            assert {name: float(row[name]) for name in wanted} == pytest.approx(
                {name: float(value) for name, value in wanted.items()}, rel=1e-12
            )
            assert row["status"] == "CONVERGED"

    def test_one_load_is_one_row(self, run):
        _, out, _ = run("solve", "rough.npz", "--force", "20mN", *STEEL, "--csv", "--area", "cell-count")
        (row,) = csv.DictReader(io.StringIO(out))
        solution = solve(force=0.02)
        assert float(row["area [m2]"]) == solution.area().value
        assert float(row["other_area [m2]"]) == solution.area("cell-count").value
        assert row["secant_stiffness [N/m]"] == "nan"
        assert json.loads(json.dumps(row))["warnings"] == " ".join(
            dict.fromkeys((*solution.warnings, *solution.area().warnings))
        )


class TestOutputs:
    @pytest.mark.slow
    def test_each_ending_is_written_in_its_format(self, run):
        files = ["one.npz", "one.png", "one.svg", "one.html"]
        options = [part for name in files for part in ("-o", name)]
        _, out, _ = run("solve", "rough.npz", "--force", "20mN", *STEEL, *options, "--report", "report.html")
        assert "Written: one.npz, one.png, one.svg, one.html, report.html" in " ".join(out.split())
        loaded = rc.ContactSolution.load("one.npz")
        assert (loaded.pressure == solve(force=0.02).pressure).all()
        assert Path("one.png").read_bytes()[:4] == b"\x89PNG"
        assert "<svg" in Path("one.svg").read_text(encoding="utf-8")
        for name in ("one.html", "report.html"):
            assert Path(name).read_text(encoding="utf-8").lower().startswith("<!doctype html>")

    @pytest.mark.usefixtures("no_pictures")
    def test_several_loads_have_one_report(self, run):
        _, out, _ = run("solve", "rough.npz", "--loads", "20mN", "50mN", *STEEL, "--report", "report.html")
        assert out.rstrip().endswith("Written: report.html")
        page = Path("report.html").read_text(encoding="utf-8")
        assert "2 loads, force 20 mN to 50 mN" in page
        assert "The largest load, 50 mN" in page

    def test_netcdf_is_read_by_xarray(self, run):
        xarray = pytest.importorskip("xarray")
        run("solve", "rough.npz", "--force", "20mN", *STEEL, "-o", "one.nc")
        with xarray.open_dataset("one.nc", engine="h5netcdf") as data:
            assert data.attrs or data.sizes
            assert data["pressure"].mean().item() * GRID.area == pytest.approx(0.02)

    def test_a_name_without_an_ending_is_a_folder(self, run):
        run("solve", "rough.npz", "--force", "20mN", *STEEL, "-o", "results")
        assert sorted(os.listdir("results")) == ["solution.npz", "solution.png"]

    def test_several_loads_are_numbered_and_drawn_together(self, run):
        run("solve", "rough.npz", "--loads", "10mN", "20mN", *STEEL, "-o", "s.npz", "-o", "s.png")
        assert sorted(name for name in os.listdir() if name.startswith("s")) == ["s-1.npz", "s-2.npz", "s.png"]
        assert rc.ContactSolution.load("s-2.npz").force == pytest.approx(0.02)

    def test_nothing_is_written_unasked(self, run):
        before = sorted(os.listdir())
        run("solve", "rough.npz", "--force", "20mN", *STEEL)
        assert sorted(os.listdir()) == before

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["-o", "x.xyz"], "a file that ends in .html"),
            (["-o", "nowhere/x.npz"], "There is no folder 'nowhere'"),
            (["-o", "rough.npz"], "is a height map that is read"),
            (["--report", "x.pdf"], "a file that ends in .html"),
            (["--refine"], "add no heights to a map that is not periodic"),
            (["--area-within", "0.01", "--refine"], "--area-within chooses the grid"),
        ],
    )
    def test_what_cannot_be_written_or_refined_is_refused_before_the_solve(self, run, options, words):
        before = Path("rough.npz").read_bytes()
        status, out, err = run("solve", "rough.npz", "--force", "20mN", *STEEL, *options)
        assert (status, out) == (2, "")
        assert words in err
        assert err.count("\n") == 1
        assert Path("rough.npz").read_bytes() == before

    def test_loads_of_several_kinds_are_refused(self, run):
        status, _, err = run("solve", "rough.npz", "--loads", "1N", "1MPa", *STEEL)
        assert status == 2
        assert "of one kind, but they are of force and pressure" in err


class TestText:
    def test_the_answer_comes_first_and_the_plan_when_asked(self, run):
        _, out, _ = run("solve", "rough.npz", "--force", "20mN", *STEEL)
        assert "contact area" in out.splitlines()[0]
        assert "omitted" not in out
        _, out, _ = run("solve", "rough.npz", "--force", "20mN", *STEEL, "--explain")
        assert out.index("omitted") < out.index("contact area")
        status, out, _ = run("solve", "rough.npz", "--force", "20mN", *STEEL, "--dry-run")
        assert status == 0
        assert "omitted" in out
        assert "contact area" not in out

    def test_quiet_says_nothing_but_errors(self, run):
        status, out, err = run("solve", "rough.npz", "--force", "20mN", *STEEL, "-q", "-o", "x.npz")
        assert (out, err) == ("", "")
        assert status in (0, 3)
        assert Path("x.npz").exists()

    def test_a_dry_run_refuses_what_a_solve_would(self, run):
        status, _, err = run("solve", "rough.npz", "--pressure", "3GPa", *STEEL, "--hardness", "2GPa", "--dry-run")
        assert status == 2
        assert "at most 2 GPa" in err

    @pytest.mark.parametrize(
        "arguments",
        [
            ["solve", "rough.npz", "--force", "20mN", *STEEL, "--explain", "-o", "x.npz", "-o", "x.png"],
            ["solve", "rough.npz", "--loads", "10mN", "20mN", *STEEL, "--area", "cell-count"],
            ["solve", "rough.npz", "ball.npz", "--match", "bilinear", "--force", "20mN", *STEEL, "--explain"],
            ["report", "rough.npz", "--force", "20mN", *STEEL, "--cells", "12", "24", "--repeats", "1",
             "--solvers", "projected-cg", "polonsky-keer", "--tolerances", "1e-4", "1e-6"],
            ["stability", "rough.npz", "--force", "20mN", *STEEL],
            ["check", "elastic", "--with", "young=1e9", "poisson=0.3"],
            ["surface", "self-affine", "--hurst", "0.8", "--rms-slope", "0.1", "--shortest", "2um", "--longest",
             "20um", "--shape", "32", "32", "--size", "20um"],
            ["info", "rough.npz"],
        ],
        ids=lambda arguments: " ".join(arguments[:2]),
    )  # fmt: skip
    def test_nothing_is_wider_than_80_columns(self, run, arguments):
        _, out, _ = run(*arguments)
        assert out
        assert not too_wide(out)

    @pytest.mark.parametrize("name", sorted(commands))
    def test_help_is_not_wider_than_80_columns_and_has_examples(self, run, name, monkeypatch):
        monkeypatch.setenv("COLUMNS", "80")
        status, out, _ = run(name, "--help")
        assert status == 0
        assert not too_wide(out)
        if type(commands.create(name)).__module__.startswith("roughcontact."):
            assert f"  roughcontact {name}" in out

    def test_the_overview_has_examples_and_exit_statuses(self, run, monkeypatch):
        monkeypatch.setenv("COLUMNS", "80")
        _, out, _ = run("--help")
        assert not too_wide(out)
        assert "  roughcontact solve map.npz --pressure 10MPa --young 210GPa" in out
        assert re.findall(r"^  (\d+) ", out, re.MULTILINE) == ["0", "1", "2", "3", "130", "141"]

    def test_the_verdict_comes_first(self, run):
        _, out, _ = run("stability", "rough.npz", "--force", "20mN", *STEEL)
        assert out.splitlines()[0].startswith("overall: ")
        verdicts = re.findall(r"^(fail|attention|pass|skipped) ", out, re.MULTILINE)
        assert verdicts == sorted(verdicts, key=("fail", "attention", "pass", "skipped").index)
        _, out, _ = run("report", "rough.npz", "--force", "20mN", *STEEL, "--cells", "24", "48", "--repeats", "1")
        assert re.match("(For an area error|The reference area)", out)


class TestSurface:
    def test_it_is_that_of_the_api(self, run):
        options = "--hurst 0.7 --rms-height 50nm --shortest 8um --longest 48um --seed 3 --lay 30deg --peklenik 2"
        status, out, _ = run(
            "surface", "self-affine", *options.split(), "--shape", 48, 48, "--size", "48um", "--periodic", "-o", "a.npz"
        )
        made, wanted = (
            rc.read_surface("a.npz"),
            rc.SelfAffineSurface(
                hurst=0.7, rms_height=50e-9, shortest=8e-6, longest=48e-6, seed=3, lay=np.deg2rad(30), peklenik=2.0
            ),
        )
        assert status == 0
        assert made.periodic
        assert made.size == (48e-6, 48e-6)
        np.testing.assert_array_equal(made.values, wanted.heights(GRID))
        assert "root of m0              50 nm" in out
        assert "Sq            50 nm about the mean" in out

    @pytest.mark.parametrize("size", [("64um",), ("16um", "128um")])
    def test_a_periodic_surface_is_periodic_in_its_file(self, run, size):
        """A cut-out of long waves looks tilted; this one repeats, so that a plane would be no tilt of it."""
        options = "--hurst 0.8 --rms-height 20nm --shortest 8um --longest 128um --seed 2".split()
        status, out, _ = run("surface", "self-affine", *options, "--shape", 32, 63, "--size", *size, "-o", "s.npz")
        assert status == 0
        assert rc.read_surface("s.npz").periodic
        assert "tilt" not in out
        status, out, _ = run("info", "s.npz")
        assert status == 0
        assert "periodic" in out
        assert "tilt" not in out
        solved = run("solve", "s.npz", "--boundary", "periodic", "--pressure", "5MPa", "--young", "210GPa")
        assert solved[0] == 0

    def test_pairs_pictures_and_sides(self, run):
        options = [
            "--amplitude",
            "0.1um",
            "0um",
            "--wavelength",
            "10um",
            "--shape",
            "20",
            "40",
            "--size",
            "10um",
            "20um",
        ]
        status, _, _ = run("surface", "wavy", *options, "-o", "w.npz", "-o", "w.png")
        assert status == 0
        made = rc.read_surface("w.npz")
        wanted = rc.WavySurface(amplitude=(1e-7, 0.0), wavelength=1e-5).heights(rc.Grid((20, 40), (1e-5, 2e-5)))
        np.testing.assert_array_equal(made.values, wanted)
        assert Path("w.png").read_bytes()[:4] == b"\x89PNG"

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (["sphere", "--radius", "5", "--shape", "8", "8", "--size", "1um"], "'5' has no unit (mm, um or nm?)"),
            (["sphere", "--radius", "1um", "--shape", "8", "8", "--size", "1mm"], "does not cover the domain"),
            (["sphere", "--shape", "8", "8", "--size", "1um"], "required: --radius"),
            (["sphere", "--radius", "1mm", "--shape", "8", "8", "--size", "1um", "-o", "x.txt"], ".npz, .pdf, .png"),
            (["cone"], "there is no 'cone'. Known: flat, "),
        ],
    )
    def test_refusals(self, run, arguments, words):
        status, _, err = run("surface", *arguments)
        assert status == 2
        assert words in err


class TestShow:
    def test_info_of_a_map_and_of_a_solution(self, run):
        status, out, _ = run("info", "rough.npz")
        assert status == 0
        assert "48 x 48 cells on 48 µm x 48 µm, cells of 1 µm x 1 µm" in " ".join(out.split())
        solve(force=0.02).save("one.npz")
        assert json.loads(run("info", "one.npz", "--json")[1])["area"]["value"] == solve(force=0.02).area().value
        assert "contact area" in run("info", "one.npz")[1]
        status, _, err = run("info", "rough.npz", "--json")
        assert status == 2
        assert "--json is for solutions" in err

    def test_a_text_file_is_read_as_its_options_say(self, run):
        np.savetxt("map.txt", np.random.default_rng(0).random((24, 24)))
        _, out, _ = run("info", "map.txt", "--size", "1mm", "--unit", "1um", "--detrend", "plane")
        assert "24 x 24 cells on 1 mm x 1 mm" in " ".join(out.split())
        assert "best plane subtracted" in " ".join(out.split())

    @pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml")])
    def test_plot(self, run, name, start):
        solve(force=0.02).save("one.npz")
        assert run("plot", "one.npz", "--panel", "pressure", "--dark", "-o", name)[0] == 0
        assert Path(name).read_bytes().startswith(start)

    def test_plot_of_a_map_and_its_refusals(self, run):
        assert run("plot", "rough.npz", "--panel", "map", "-o", "m.png")[0] == 0
        for arguments, words in (
            (["rough.npz", "-o", "m.txt"], "a file that ends in .gif, .pdf, .png, .svg"),
            (["rough.npz", "--panel", "pressure", "-o", "m.png"], "draws a solution, not a surface"),
            (["none.npz", "-o", "m.png"], "There is no file 'none.npz'"),
        ):
            status, _, err = run("plot", *arguments)
            assert status == 2
            assert words in err


def test_a_shell_completes_commands_and_options(run, tmp_path):
    pytest.importorskip("shtab")
    _, script, _ = run("completion", "bash")
    Path("complete.sh").write_text(script)
    ask = 'source complete.sh; COMP_WORDS=({words}); COMP_CWORD={at}; _shtab_roughcontact; echo "${{COMPREPLY[@]}}"'

    def complete(words, at):
        return subprocess.run(
            ["bash", "-c", ask.format(words=words, at=at)], capture_output=True, text=True, check=True
        ).stdout.split()

    assert complete("roughcontact so", 1) == ["solve"]
    assert complete("roughcontact solve --area", 2) == ["--area-within", "--area"]
    assert set(complete("roughcontact solve --help", 2)) == {"--help", "--help-all"}
    assert "self-affine" in complete("roughcontact surface s", 2)


def test_fish_completes_commands_and_options(run):
    pytest.importorskip("shtab")
    _, script, _ = run("completion", "fish")
    Path("complete.fish").write_text(script, encoding="utf-8")
    if shutil.which("fish") is None:
        assert "complete -c roughcontact" in script
        assert {"-l stiffness", "-l area-within", "-l hurst"} <= set(re.findall(r"-l [\w-]+", script))
        return

    def complete(words):
        ask = f"source complete.fish; complete -C '{words}'"
        found = subprocess.run(["fish", "-c", ask], capture_output=True, text=True, check=True).stdout
        return {line.partition("\t")[0] for line in found.splitlines()}

    assert complete("roughcontact so") == {"solve"}
    assert complete("roughcontact solve map.npz --area") == {"--area-within", "--area"}
    assert {"free", "periodic", "wrapped"} <= complete("roughcontact solve map.npz --boundary ")
    assert "self-affine" in complete("roughcontact surface s")
    assert "--hurst" in complete("roughcontact surface self-affine --h")


BLOCKED = ("matplotlib", "jinja2", "pint", "rich", "pandas", "xarray", "h5py", "h5netcdf", "shtab", "pyamg", "tqdm")
CORE = f"""
import sys


class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {BLOCKED}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)


sys.meta_path.insert(0, Absent())
from roughcontact.__main__ import main

for line in sys.stdin.read().splitlines():
    try:
        status = main(line.split())
    except SystemExit as ended:
        status = ended.code
    print("STATUS", status, flush=True)
"""


def with_core_packages(*lines):
    done = subprocess.run(
        [sys.executable, "-c", CORE], input="\n".join(lines), capture_output=True, text=True, check=True
    )
    return [int(status) for status in re.findall(r"^STATUS (\d+)$", done.stdout, re.MULTILINE)], done


STUDY = """
[problems.rough.body]
surface = {type = "file", path = "rough.npz"}
material = {young = "210GPa", poisson = 0.3}
[study]
force = ["20mN"]
"""


def test_help_a_solve_and_a_study_need_core_packages_only():
    ours = [name for name in commands if type(commands.create(name)).__module__.startswith("roughcontact.")]
    statuses, done = with_core_packages("--help", *(f"{name} --help" for name in ours))
    assert statuses == [0] * (1 + len(ours)), done.stderr
    assert not [line for line in done.stdout.splitlines() if "cannot be loaded" in line and "paper" not in line]
    Path("study.toml").write_text(STUDY)
    statuses, done = with_core_packages(
        "solve rough.npz --force 20mN --young 210GPa --json",
        "solve rough.npz --force 20mN --young 210GPa -o one.npz",
        "surface sphere --radius 1mm --shape 8 8 --size 1um -o s.npz",
        "stability rough.npz --force 20mN --young 210GPa",
        "run study.toml",
    )
    assert {*statuses} <= {0, 1, 3}, done.stderr
    assert Path("one.npz").exists()
    assert Path("study/records.csv").exists()


def test_a_missing_extra_is_named_where_it_is_used_before_the_solve():
    statuses, done = with_core_packages(
        "solve rough.npz --force 20mN --young 210GPa -o one.html", "plot rough.npz -o m.png", "completion bash"
    )
    assert statuses == [2] * 3
    first, second, third = done.stderr.splitlines()
    assert "pip install 'roughcontact[plot]'" in first
    assert "pip install 'roughcontact[plot]'" in second
    assert "pip install 'roughcontact[cli]'" in third
    assert "contact area" not in done.stdout


# A solve that never ends by itself.
ENDLESS = """
import sys
from roughcontact.__main__ import main
import roughcontact as rc
real = rc.ContactProblem.solve
def solve(problem, on_step=None, **options):
    while True:
        real(problem, on_step=on_step, **options)
rc.ContactProblem.solve = solve
sys.exit(main(sys.argv[1:]))
"""


@posix
def test_progress_is_shown_on_a_terminal_and_an_interrupt_is_clean(tmp_path):
    import pty

    terminal, slave = pty.openpty()
    command = [sys.executable, "-c", ENDLESS, "solve", "rough.npz", "--force", "20mN", *STEEL]
    process = subprocess.Popen(
        command,
        stderr=slave,
        stdout=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    os.close(slave)
    shown = b""
    line = rb"\r *\d+ % \|.*\| \d\d:\d\d < .*  solving: 48 x 48 cells, iteration \d+"
    while not re.search(line, shown):
        shown += os.read(terminal, 4096)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    with contextlib.suppress(OSError):
        while more := os.read(terminal, 4096):
            shown += more
    os.close(terminal)
    text = shown.decode()
    assert text.endswith("\rroughcontact: interrupted\r\n")
    assert "Traceback" not in text
    assert "\x1b" not in text
    assert process.returncode == 130
    assert out == b""


def test_no_progress_where_standard_error_is_not_a_terminal(run):
    _, _, err = run("solve", "rough.npz", "--force", "20mN", *STEEL)
    assert "\r" not in err


@pytest.mark.slow
@posix
def test_a_reader_that_has_enough_ends_it_quietly():
    command = f"{sys.executable} -m roughcontact check love | head -c 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["solve", "rough.npz", "--force", "1N", *STEEL, "--stifness"],
            "no option --stifness; did you mean --stiffness?",
        ),
        (["solve", "rough.npz", "--preasure=10MPa", *STEEL], "no option --preasure; did you mean --pressure?"),
        (["surface", "self-affine", "--hrust", "0.8"], "no option --hrust; did you mean --hurst?"),
        (["run", "study.toml", "--worker=2", "--shares", "1/2"], "no option --shares; did you mean --share?"),
        (["solve", "rough.npz", "--xyzzy"], "is required"),
    ],
)
def test_a_wrong_option_is_told_which_one_is_meant(run, arguments, words):
    status, out, err = run(*arguments)
    assert status == 2
    assert words in err
    assert out == ""


def test_equal_warnings_of_several_loads_are_one_sentence(run):
    grid = rc.Grid((32, 32), 100e-6)
    np.savez("ball.npz", heights=rc.SphereSurface(radius=1e-3).heights(grid), size=grid.size)
    loads = ["50N", "60N", "70N", "80N"]
    status, out, _ = run("solve", "ball.npz", "--loads", *loads, *STEEL, "--stiffness")
    assert status == 3
    warnings = re.findall(r"^warning  (.*(?:\n         .*)*)", out, re.MULTILINE)
    assert len(warnings) == len({re.sub(r"\d[\d.]*", "#", " ".join(text.split())) for text in warnings})
    assert "At all 4 loads" in out
    assert max(map(len, out.splitlines())) <= 80


def test_the_help_of_a_response_has_units_and_defaults(run):
    _, out, _ = run("solve", "--help", "responses")
    words = " ".join(out.split())
    assert "viscosity=1mPa.s pressure_drop=100MPa [axis=0]" in words
    assert "yield_stress=100MPa [body=body]" in words
    assert "conductivity=45W/m/K (W/(m K) or S/m) [film_resistance=0 (m2 K/W or Ohm m2)]" in words
    assert max(map(len, out.splitlines())) <= 80
