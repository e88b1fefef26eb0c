"""``roughcontact law`` and ``roughcontact solve --solve-for``: the numbers of the API, and files read back."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc

SIZE = (96e-6, 32e-6)
SHAPE = (48, 48)
STEEL = ["--young", "210GPa"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Rough maps of cells 3 : 1 in the working folder: one that repeats, and a part of it that does not."""
    monkeypatch.chdir(tmp_path)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=50e-9, shortest=9e-6, longest=32e-6, seed=3)
    heights = rough.heights(rc.Grid(SHAPE, SIZE))
    np.savez("map.npz", heights=heights, size=SIZE, periodic=True)
    np.savez("part.npz", heights=heights[:21], size=(42e-6, 32e-6))


def problem(name="map.npz", boundary="periodic", mirrored=False):
    surface = rc.read_surface(name)
    body = rc.Body(surface.mirror_borders() if mirrored else surface, rc.Elastic(210e9, 0.3))
    return rc.ContactProblem(body, boundary=boundary)


def read_table(path):
    """Return the columns of a table of COMSOL: rows of numbers between blanks, comments behind a percent sign."""
    lines = Path(path).read_text(encoding="ascii").splitlines()
    rows = np.array([line.split() for line in lines if not line.startswith("%")], dtype=float)
    assert rows.shape[1] == 2
    assert (np.diff(rows[:, 0]) > 0.0).all()
    return rows[:, 0], rows[:, 1], [line for line in lines if line.startswith("%")]


class TestFilm:
    def test_rows_and_files_are_those_of_the_api(self, run):
        call = ["film", "map.npz", *STEEL, "--separation", "1..1.6", "4", "--no-sampling", "--csv"]
        _, output, _ = run(
            *call, "--comsol", "film.txt", "--units", "mm", "-o", "film.csv", "-o", "film.json", "-o", "f.png"
        )
        law = rc.film_law(problem(), [1.0, 1.25, 1.5, 1.6, 4.0], sampling=False)
        rows = list(csv.DictReader(output.splitlines()))
        assert [float(row["separation_over_sq"]) for row in rows] == law.separations.tolist()
        for name in ("phi_xx", "phi_s_xy", "area"):
            assert [float(row[f"{name} [1]"]) for row in rows] == pytest.approx(law[name].values.tolist(), rel=1e-9)
        assert Path("film.csv").read_text().splitlines()[0] == output.splitlines()[0]
        assert Path("f.png").stat().st_size > 10_000
        content = json.loads(Path("film.json").read_text())
        assert content["columns"][0]["values"] == pytest.approx(law["asperity_pressure"].values.tolist(), rel=1e-9)
        table = np.loadtxt("film.txt", comments="%")
        assert table[:, 0] == pytest.approx(1e3 * law.rms_height * law.separations)
        assert table[:, 1] == pytest.approx(1e-6 * law["asperity_pressure"].values, rel=1e-8)

    def test_two_rough_walls_that_touch_have_no_shear_flow_factors_and_a_sentence_why(self, run):
        call = ["film", "map.npz", "map.npz", *STEEL, "--separation", "1", "8", "--no-sampling"]
        status, output, _ = run(*call, "-o", "film.csv", "-o", "film.html")
        assert status == 3
        assert "The columns phi_s are omitted: at some of these separations" in " ".join(output.split())
        assert "phi_s" not in Path("film.csv").read_text().splitlines()[0]
        page = " ".join(Path("film.html").read_text(encoding="utf-8").split())
        assert "The columns phi_s are omitted: at some of these separations" in page

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (["--separation", "4..1"], "is not a range"),
            (["--separation", "1", "1um"], "1um"),
            (["--separation", "1"], "two or more"),
            (["--separation", "1", "2", "-o", "film.txt"], "ends in .csv, .html, .json"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, run, change, words):
        status, _, error = run("film", "map.npz", *STEEL, *change)
        assert status == 2
        assert words in error


class TestSolveFor:
    @pytest.mark.parametrize(
        ("asked", "answer", "wanted"),
        [
            (["area=10%"], rc.areas.create("blend"), "10%"),
            (["area=200um2", "estimator=cell-count"], rc.areas.create("cell-count"), 200e-12),
            (["stiffness=2MN/m"], rc.responses.create("stiffness"), 2e6),
            (["peak_pressure=5GPa"], rc.responses.create("peak-pressure"), 5e9),
            (["conductance=1e-3", "conductivity=45"], rc.responses.create("conductance", 45.0), 1e-3),
            (
                ["leakage=2e-5mm3/s", "viscosity=1mPa.s", "pressure_drop=1bar", "axis=1"],
                rc.responses.create("leakage", axis=1, viscosity=1e-3, pressure_drop=1e5),
                2e-14,
            ),
        ],
    )
    def test_json_has_the_load(self, run, asked, answer, wanted):
        call = ["solve", "map.npz", "--boundary", "periodic", *STEEL, "--solve-for", *asked]
        status, output, _ = run(*call, "--json")
        assert status in (0, 3)
        found = problem().solve_for(answer, value=wanted)
        load = json.loads(output)["responses"]["required-load"]
        for name, estimate in (("force", found.force), ("mean_pressure", found.pressure)):
            assert load[name]["value"] == pytest.approx(estimate.value, rel=1e-9)
            assert load[name]["uncertainty"] == pytest.approx(estimate.uncertainty, rel=1e-6)
        assert json.loads(output)["force"]["value"] == pytest.approx(found.solution.force, rel=1e-9)

    def test_text_csv_and_files(self, run):
        call = ["solve", "map.npz", "--boundary", "periodic", *STEEL, "--solve-for", "area=10%"]
        _, output, _ = run(*call, "-o", "contact.npz", "--stiffness")
        assert "required-load     area of 307.2 µm2 at " in output
        assert "stiffness " in output
        saved = rc.ContactSolution.load("contact.npz")
        _, output, _ = run(*call, "--csv")
        (row,) = csv.DictReader(output.splitlines())
        assert float(row["required-load force [N]"]) == saved.force == float(row["force [N]"])
        assert float(row["required-load force_uncertainty [N]"]) > 0.0

    @pytest.mark.parametrize(
        ("asked", "words"),
        [
            (["area"], "NAME=VALUE"),
            (["wear=3"], "no answer named 'wear'"),
            (["area=10%", "axis=1"], "estimator=NAME"),
            (["area=10%", "--adhesion", "exponential", "work=1mJ/m2", "range=1nm"], "--adhesion needs a load"),
            (["area=10%", "--refine", "2"], "--refine needs a load"),
            (["area=10%", "--area-within", "1%"], "--area-within needs a load"),
            (["area=100%"], "below the nominal area"),
            (["area=3"], "wanted area"),
            (["stiffness=3"], "has no unit"),
            (["leakage=1mm3/s"], "viscosity"),
            (["leakage=1m3/s", "viscosity=1mPa.s", "pressure_drop=1bar"], "No load gives a leakage of 1 m3/s"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, run, asked, words):
        status, output, errors = run("solve", "map.npz", "--boundary", "periodic", *STEEL, "--solve-for", *asked)
        assert (status, output) == (2, "")
        assert words in errors
        assert errors.count("\n") == 1

    def test_another_load_is_refused(self, run):
        status, _, errors = run("solve", "map.npz", *STEEL, "--solve-for", "area=10%", "--force", "1N")
        assert status == 2
        assert "not allowed with" in errors

    def test_a_dry_run_solves_nothing(self, run):
        status, output, _ = run("solve", "map.npz", *STEEL, "--solve-for", "area=10%", "--dry-run")
        assert status == 0
        assert "48 x 48" in output


class TestLaw:
    def test_all_forms_have_the_numbers_of_the_api(self, run):
        loads = ["--loads", "4MPa..10MPa"]
        law = rc.interface_law(problem(), np.geomspace(4e6, 10e6, 3), ["stiffness"])
        status, output, _ = run("law", "map.npz", *STEEL, *loads, "--json", "-o", "law.csv", "-o", "law.json")
        assert status == (3 if law.warnings else 0)
        described = json.loads(output)
        assert described["pressures"]["values"] == pytest.approx(law.pressures)
        for name, column in law.columns.items():
            assert described["columns"][name]["values"] == pytest.approx(column.values, rel=1e-9)
            assert described["columns"][name]["uncertainties"] == pytest.approx(column.uncertainties, rel=1e-6)
            assert described["columns"][name]["unit"] == column.unit
        assert described["warnings"] == list(law.warnings)
        assert json.loads(Path("law.json").read_text(encoding="utf-8"))["columns"] == described["columns"]
        _, output, _ = run("law", "map.npz", *STEEL, *loads, "--csv")
        assert output == Path("law.csv").read_text(encoding="utf-8")
        rows = [*csv.DictReader(output.splitlines())]
        assert [float(row["mean_gap [m]"]) for row in rows] == pytest.approx(law["mean_gap"].values, rel=1e-9)

    def test_a_range_has_ratios_of_at_most_1_6(self, run):
        _, output, _ = run("law", "map.npz", *STEEL, "--loads", "4MPa..40MPa", "80MPa", "--json")
        pressures = json.loads(output)["pressures"]["values"]
        assert len(pressures) == 7
        assert pressures[:6] == pytest.approx(np.geomspace(4e6, 40e6, 6))

    def test_files_of_other_programs(self, run):
        files = ["--abaqus", "a.inp", "--calculix", "c.inp", "--moose", "m.csv", "--comsol", "t.txt", "-o", "law.png"]
        files += ["--ansys", "s.inp"]
        call = ["law", "map.npz", *STEEL, "--loads", "4MPa..10MPa", "--conductance", "45"]
        _, output, _ = run(*call, *files, "--units", "mm", "--name", "JOINT")
        heat = rc.responses.create("conductance", 45.0)
        law = rc.interface_law(problem(), np.geomspace(4e6, 10e6, 3), {"stiffness": "stiffness", "conductance": heat})
        law.to_abaqus("a2.inp", units="mm", name="JOINT")
        law.to_calculix("c2.inp", units="mm", name="JOINT")
        law.to_moose("m2.csv", units="mm", name="JOINT")
        law.to_ansys("s2.inp", units="mm", name="JOINT")
        for one, other in (("a.inp", "a2.inp"), ("c.inp", "c2.inp"), ("m.csv", "m2.csv"), ("s.inp", "s2.inp")):
            assert Path(one).read_text(encoding="ascii") == Path(other).read_text(encoding="ascii")
        assert Path("m.i").exists()
        assert Path("law.png").read_bytes().startswith(b"\x89PNG")
        pressures, values, _ = read_table("t.txt")
        assert pressures == pytest.approx([0.0, *(1e-6 * law.pressures)], rel=1e-8)
        assert values == pytest.approx([0.0, *(1e-3 * law["conductance"].values)], rel=1e-8)
        assert read_table("t-closure.txt")[1] == pytest.approx(pressures)
        assert "t-closure.txt" in output

    def test_a_map_mirrored_at_its_borders_repeats(self, run):
        call = ["law", "part.npz", *STEEL, "--loads", "20MPa", "--csv"]
        _, output, _ = run(*call, "--mirror-borders")
        law = rc.interface_law(problem("part.npz", mirrored=True), [20e6])
        (row,) = csv.DictReader(output.splitlines())
        assert float(row["area [1]"]) == pytest.approx(law["area"].values[0], rel=1e-9)
        assert not any("jump across the border" in text for text in law.warnings)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (["--loads", "40MPa..4MPa"], "is not a range"),
            (["--loads", "1Pa..1e60Pa"], "more than 200 loads"),
            (["--loads", "4MPa..5mm"], "not a quantity in units of Pa"),
            (["--loads", "4MPa", "4MPa"], "given twice"),
            (["--loads", "4MPa", "-o", "law.txt"], "a file that ends in"),
            (["--loads", "4MPa", "-o", "there/law.csv"], "no folder"),
            (["--loads", "4MPa", "--moose", "law.csv"], "give --conductance too"),
            (["--loads", "4MPa", "--ansys", "s.inp"], "--ansys writes a conductance: give --conductance too"),
            (["--loads", "4MPa", "--stress"], "not a number with an uncertainty"),
            (["--loads", "4MPa", "--comsol", "map.npz", "--conductance", "45"], "a height map that is read"),
            (["--loads", "4MPa", "--abaqus", "a.inp", "--name", "1 2"], "The name"),
            (["--loads", "4MPa", "--mirror"], "--mirror-borders repeats maps that do not repeat"),
        ],
    )
    def test_bad_input_gets_a_sentence(self, run, change, words):
        status, output, errors = run("law", "map.npz", *STEEL, *change)
        assert (status, output) == (2, "")
        assert words in errors


def test_maps_are_mirrored_with_their_points():
    heights = np.arange(12.0).reshape(4, 3)
    heights[1, 2] = np.nan
    surface = rc.HeightMap(heights, (4e-6, 9e-6))
    found = surface.mirror_borders()
    assert found.periodic
    assert found.size == (8e-6, 18e-6)
    for changed in (found.values[::-1], found.values[:, ::-1]):
        assert (changed == found.values).all()
    assert (found.values[:4, :3] == surface.values).all()
    assert found.non_measured.sum() == 4
    assert found.non_measured[1, 2]
    assert found.mirror_borders() is found
