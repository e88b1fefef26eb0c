"""The report of a solution: one page that opens anywhere, prints on two pages, and can be repeated and cited."""

from __future__ import annotations

import base64
import contextlib
import io
import re
import shutil
import subprocess
import sys
from datetime import date
from pathlib import Path
from xml.etree import ElementTree

import attrs
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.faces import gather_warnings, list_quantities
from unit_files import digest_of, read_archive

STEEL = rc.Elastic(young=200e9, poisson=0.3)
HOSTILE = "<script>alert(1)</script>.npz & \"'\x00\ud800"
ROOT = Path(__file__).parents[2]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
WAVE = rc.WavySurface(amplitude=0.5e-6, wavelength=12.5e-6)
ROUGH = rc.SelfAffineSurface(hurst=0.7, rms_slope=0.1, shortest=8e-6, longest=64e-6, seed=2)


def solve(surface=WAVE, material=STEEL, counterbody=rc.RIGID_FLAT, shape=(32, 32), **parts):
    grid = None if surface.own_grid is not None else rc.Grid(shape, 64e-6)
    problem = rc.ContactProblem(rc.Body(surface, material), counterbody, grid=grid, **parts)
    return problem.solve(pressure=100e6, throw=False)


def make_map(history=()):
    return rc.HeightMap(ROUGH.heights(rc.Grid((32, 32), 64e-6)), size=64e-6, history=history)


def read(text):
    """Return the tree of a page that is HTML5 without any error."""
    html5lib = pytest.importorskip("html5lib")
    return html5lib.HTMLParser(strict=True, namespaceHTMLElements=False).parse(text)


def text_of(tree):
    body = tree.find("body")
    return " ".join(" ".join((tree if body is None else body).itertext()).split())


@pytest.fixture
def plain(monkeypatch):
    """Let reports be made without figures, as without matplotlib."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)


@pytest.fixture(scope="module")
def page():
    solution = solve(shape=(64, 64), boundary="periodic")
    return solution, solution.to_html()


class TestPage:
    def test_it_is_html5_and_fetches_nothing(self, page):
        solution, text = page
        tree = read(text)
        assert tree.find("head/meta[@http-equiv]").get("content").startswith("default-src 'none'; img-src data:;")
        for name in ("script", "link", "iframe", "object", "base", "form"):
            assert not tree.findall(f".//{name}")
        assert all(one.get("src").startswith("data:image/png;base64,") for one in tree.iter("img"))
        assert not re.search(r"url\(|@import|srcset", text)
        assert ElementTree.tostring(read(solution.to_html())).startswith(b"<html")

    def test_the_answer_comes_first_and_the_plan_last(self, page):
        solution, text = page
        tree = read(text)
        headings = [one.text for name in ("h1", "h2") for one in tree.iter(name)]
        expected = ["Contact report", "Figures", "Inputs", "Certificate", "Versions", "Run it again", "Cite", "Plan"]
        assert headings == expected
        words = text_of(tree)
        area, peak = solution.area(), solution.peak_pressure()
        assert words.index("Converged:") < words.index("% of nominal") < words.index("Figures")
        value, std = re.search(r"\(([\d.]+) ± ([\d.]+)\) % of nominal", words).groups()
        assert float(value) == pytest.approx(100.0 * area.fraction, abs=float(std))
        assert float(std) == pytest.approx(100.0 * area.uncertainty / solution.grid.area, rel=0.06)
        assert float(re.search(r"([\d.]+) µm²", words)[1]) == pytest.approx(1e12 * area.value, rel=1e-3)
        value, std = re.search(r"Maximum pressure \(([\d.]+) ± ([\d.]+)\) GPa", words).groups()
        assert float(value) == pytest.approx(1e-9 * peak.value, abs=float(std))
        assert float(std) == pytest.approx(1e-9 * peak.uncertainty, rel=0.06)
        plan = rc.ContactProblem(**solution.origin.problem).explain()
        assert text_of(tree.findall(".//pre")[-1]) == " ".join(plan.split())

    def test_figures_are_all_panels_of_solutions_with_the_answer_in_words(self, page):
        solution, text = page
        shown = read(text).findall(".//figure")
        assert len(shown) == sum(
            rc.panels[name].subject == "solution" and rc.panels[name].fits(solution) for name in rc.panels
        )
        for figure in shown:
            image = figure.find("img")
            content = base64.b64decode(image.get("src").partition(",")[2])
            assert content.startswith(b"\x89PNG")
            assert "% of nominal" in image.get("alt")
            assert figure.find("figcaption").text

    def test_tables_have_captions_and_heads(self, page):
        for table in read(page[1]).iter("table"):
            assert table.find("caption").text
            assert [row.find("th").get("scope") for row in table.iter("tr")] == ["row"] * len(list(table.iter("tr")))

    @pytest.mark.skipif(CHROMIUM is None, reason="no chromium")
    def test_it_prints_on_two_pages(self, page, tmp_path, monkeypatch):
        registry = type(rc.panels)
        list_all = registry.__iter__

        def list_own(parts):
            return (name for name in list_all(parts) if parts[name].__module__.startswith("roughcontact."))

        # Plug-ins that happen to be installed add panels, and answers to the plan.
        monkeypatch.setattr(registry, "__iter__", list_own)
        page[0].to_html(tmp_path / "report.html")
        options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
        command = [CHROMIUM, *options, f"--print-to-pdf={tmp_path / 'report.pdf'}", str(tmp_path / "report.html")]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        assert len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "report.pdf").read_bytes())) == 2

    def test_a_panel_that_fails_leaves_a_sentence(self, monkeypatch):
        def refuse(kind, subject, name):
            raise ZeroDivisionError("<b>by zero</b>")

        monkeypatch.setattr("roughcontact._faces.html.parts.draw_panel", refuse)
        words = text_of(read(solve().to_html()))
        assert "The panel pressure is not drawn: <b>by zero</b>" in words


@pytest.mark.usefixtures("plain")
class TestContent:
    def test_without_matplotlib_it_says_what_brings_the_figures(self, tmp_path):
        path = tmp_path / "report.html"
        solve().save(path)
        tree = read(path.read_text(encoding="utf-8"))
        assert not list(tree.iter("img"))
        assert "pip install 'roughcontact[plot]'" in text_of(tree)

    def test_without_jinja_the_extra_is_named_and_a_notebook_shows_the_answer(self, tmp_path, monkeypatch):
        solution = solve()
        monkeypatch.setitem(sys.modules, "jinja2", None)
        for write in (solution.save, solution.to_html):
            with pytest.raises(rc.MissingPackage, match=r"pip install 'roughcontact\[report\]'"):
                write(tmp_path / "report.html")
        assert not list(tmp_path.iterdir())
        assert "contact area" in solution._repr_html_()

    def test_the_scene_has_the_file_the_date_and_materials_in_words(self):
        height_map = make_map(("read from my ring: 2.x3p: 32 x 32 cells on 64 µm x 64 µm", "the best plane subtracted"))
        tree = read(solve(height_map, rc.ElasticPerfectlyPlastic(200e9, 0.3, 2e9)).to_html())
        scene = tree.find(".//p[@class='scene']").text
        assert scene.startswith("my ring: 2.x3p on a rigid flat, 32 x 32 cells on 64 µm x 64 µm, boundary free, ")
        assert scene.endswith(f"; written on {date.today().isoformat()}")
        words = text_of(tree)
        assert "elastic perfectly plastic: Young's modulus 200 GPa, Poisson's ratio 0.3, hardness 2 GPa" in words
        assert "rc.Elastic" not in words
        assert "'Fields (.npz)' on the page" in words
        assert "self affine surface + sphere surface on flat surface" in text_of(
            read(solve(ROUGH + rc.SphereSurface(3e-3), counterbody=rc.Body(rc.FlatSurface(), STEEL)).to_html())
        )

    def test_a_page_in_a_file_is_not_returned_too(self, tmp_path):
        path = tmp_path / "report.html"
        assert solve().to_html(path) is None
        assert path.read_text(encoding="utf-8").startswith("<!doctype html>")

    def test_what_did_not_converge_is_said_first(self):
        solution = solve(solver=rc.ProjectedConjugateGradient(tolerance=1e-8, max_iterations=1))
        assert not solution.status.success
        words = text_of(read(solution.to_html()))
        assert words.index("Not converged:") < words.index("Do not use these numbers") < words.index("Contact area")

    def test_fields_that_are_not_finite_still_give_a_page(self):
        solution = solve()
        broken = attrs.evolve(solution, pressure=np.nan * solution.pressure, status=rc.Status.NOT_FINITE)
        assert "not determined" in text_of(read(broken.to_html()))

    def test_without_an_origin_it_says_so(self):
        words = text_of(read(attrs.evolve(solve(), origin=None).to_html()))
        assert "does not say which problem it solves" in words
        assert "Run it again" not in words
        assert "10.1080/17515831.2020.1720382" in words

    def test_warnings_of_the_solution_and_of_the_area_stand_before_the_figures(self):
        steep = rc.HeightMap(300.0 * make_map().values, size=64e-6)
        solution = solve(steep)
        words = text_of(read(solution.to_html()))
        assert solution.warnings
        assert solution.area().warnings
        for text in (*solution.warnings, *solution.area().warnings):
            assert words.index("Warnings") < words.index(" ".join(text.split())) < words.index("Figures")

    def test_saturated_cells_and_kernels_of_layers(self):
        words = text_of(read(solve(ROUGH, rc.ElasticPerfectlyPlastic(200e9, 0.3, 2e9)).to_html()))
        assert re.search(r"Saturated \(?[\d.]+", words)
        layered = attrs.evolve(solve(), moduli=((1e-6, 1e-3), (1e11, 2e11)))
        assert "another for each wavelength" in text_of(read(layered.to_html()))

    def test_the_heights_of_a_map_are_identified(self):
        height_map = make_map(("read from ring.x3p", "the best plane subtracted"))
        words = text_of(read(solve(height_map).to_html()))
        assert digest_of(height_map.values) in words
        assert "read from ring.x3p; the best plane subtracted" in words
        assert "roughness shorter than 4 µm is not included" in words

    def test_a_tip_that_is_taken_away_is_among_the_inputs(self):
        height_map = make_map().traced("20um").restored("20um")
        words = text_of(read(solve(height_map).to_html()))
        restored = height_map.history[-1]
        assert restored.startswith("restored below a tip of radius 20 µm, certain at ")
        assert restored in words.partition("Inputs")[2]

    def test_hostile_texts_stay_texts(self):
        named = type("<img src=x onerror=alert(1)>", (rc.FlatSurface,), {"__repr__": lambda self: HOSTILE})
        solution = solve(make_map((HOSTILE, "]]></style><!--")), counterbody=rc.Body(named(), rc.Rigid()))
        tree = read(solution.to_html())
        assert not list(tree.iter("script"))
        assert not list(tree.iter("img"))
        assert "<script>alert(1)</script>.npz & \"'??" in text_of(tree)
        fragment = solution._repr_html_()
        assert "<script" not in fragment

    def test_a_loaded_solution_states_the_versions_that_made_it(self, tmp_path, monkeypatch):
        solution = solve()
        solution.save(tmp_path / "a.npz")
        later = {**solution.origin.versions, "roughcontact": "9.9.9"}
        monkeypatch.setattr("roughcontact._solve.solution.origin.versions", lambda chosen=(): later)
        monkeypatch.setattr("roughcontact._solve.solution.storage.versions", lambda: later)
        loaded = rc.ContactSolution.load(tmp_path / "a.npz")
        assert loaded.origin.versions == solution.origin.versions
        words = text_of(read(loaded.to_html()))
        assert f"roughcontact {rc.__version__}, numpy {np.__version__}" in words
        key = read_archive(tmp_path / "a.npz")[1]["key"]
        assert key in words
        loaded.save(tmp_path / "b.npz")
        assert read_archive(tmp_path / "b.npz")[1]["key"] == key


@pytest.fixture(scope="module")
def sweep():
    body = rc.Body(ROUGH, rc.ElasticPerfectlyPlastic(200e9, 0.3, 6e9))
    return rc.ContactProblem(body, grid=rc.Grid((64, 64), 64e-6), boundary="periodic").sweep(pressure=[2e7, 2e8, 1e8])


class TestSweep:
    def test_all_loads_have_a_table_and_curves_before_the_largest(self, sweep, tmp_path):
        assert sweep.to_html(tmp_path / "sweep.html") is None
        tree = read((tmp_path / "sweep.html").read_text(encoding="utf-8"))
        table = next(tree.iter("table"))
        head, *rows = ([cell.text for cell in row] for row in table.iter("tr"))
        assert head[:4] == ["load", "contact area, µm²", "% of nominal", "saturated area, µm²"]
        assert not [name for name in head if name.startswith("mean pressure")]
        assert [row[0] for row in rows] == ["20 MPa", "200 MPa", "100 MPa"]
        for row, solution in zip(rows, sweep, strict=True):
            area = solution.area()
            assert float(row[1].partition(" ")[0]) == pytest.approx(1e12 * area.value, abs=1e12 * area.uncertainty)
            assert "(" not in row[1]
        words = text_of(tree)
        assert "3 loads, pressure 20 MPa to 200 MPa" in words
        places = [words.index(text) for text in ("Converged:", "% of nominal", "Curves", "The largest load, 200 MPa")]
        assert places == sorted(places)
        assert words.index("The largest load") < words.index("Figures") < words.index("problem.solve(pressure=200e6)")
        assert len(list(tree.iter("img"))) == sum(
            rc.panels[name].subject in ("solution", "sweep") and rc.panels[name].fits(sweep[0]) for name in rc.panels
        )

    @pytest.mark.usefixtures("plain")
    def test_warnings_and_failures_name_their_loads(self, sweep):
        failed = attrs.evolve(sweep[1], status=rc.Status.STALLED)
        broken = attrs.evolve(sweep, states=(sweep[0], failed, sweep[2]))
        words = text_of(read(broken.to_html()))
        assert "Not converged at 200 MPa: " in words
        assert "Do not use these numbers" in words
        texts = [
            (load, list_quantities(one)[1]) for load, one in zip(("20 MPa", "200 MPa", "100 MPa"), broken, strict=True)
        ]
        warned = gather_warnings(texts)
        assert warned
        assert all(" ".join(text.split()) in words for text in warned)


def test_the_legend_of_the_pressures_has_the_saturated_area_of_the_table(sweep):
    solution = sweep[1]
    (label,) = (
        text.get_text()
        for text in solution.plot("pressure-histogram").get_legend().get_texts()
        if "saturated" in text.get_text()
    )
    shown = re.search(r"Saturated \(?([\d.]+)", text_of(read(solution.to_html())))[1]
    assert label == f"saturated: {shown} % of nominal"
    assert float(shown) != pytest.approx(100.0 * solution.saturated.mean(), rel=0.01)


def run_script(solution):
    """Run the script on the page of a solution, and return its solution and the last line that it prints."""
    tree = read(solution.to_html())
    script = "".join(tree.find(".//pre/code").itertext())
    printed, names = io.StringIO(), {}
    with contextlib.redirect_stdout(printed):
        exec(compile(script, "script", "exec"), names)
    assert printed.getvalue().splitlines()[-1] in script
    return names["solution"]


SCENES = {
    "waves": lambda: solve(boundary="periodic"),
    "odd numbers": lambda: solve(rc.WavySurface((1 / 3e7, 0.1 + 0.2e-6), (64e-6 / 3, 64e-6 / 7)), boundary="wrapped"),
    "a sum, a hardness": lambda: solve(
        ROUGH + rc.SphereSurface(3e-3) + rc.FlatSurface(), rc.ElasticPerfectlyPlastic(70e9, 0.33, 3e9)
    ),
    "sums of sums": lambda: solve(rc.surfaces["sum"]((ROUGH, WAVE + rc.SphereSurface(1e-3, center=(1e-6, -2e-6))))),
    "two bodies": lambda: solve(counterbody=rc.Body(ROUGH, rc.Elastic(3e9, 0.4)), shape=(32, 16)),
    "parts by instance": lambda: solve(
        kernel=rc.FourierHalfSpace(), boundary="periodic", solver=rc.PolonskyKeer(tolerance=1e-7)
    ),
}


@pytest.mark.usefixtures("plain")
class TestScript:
    @pytest.mark.parametrize("name", SCENES)
    def test_it_finds_the_same_pressure_to_the_last_bit(self, name):
        solution = SCENES[name]()
        np.testing.assert_array_equal(run_script(solution).pressure, solution.pressure)

    def test_that_of_a_map_reads_the_saved_solution(self, tmp_path, monkeypatch):
        solution = solve(make_map())
        monkeypatch.chdir(tmp_path)
        solution.save("solution.npz")
        np.testing.assert_array_equal(run_script(solution).pressure, solution.pressure)
