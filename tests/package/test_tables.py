"""Tables of answers, as people read them on a terminal, on a pipe and on pages, and as programs read them."""

from __future__ import annotations

import ast
import csv
import html
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.typing import Table

AREAS = [rc.Estimate(2.13e-10, 4e-12, "m2"), rc.Estimate(1.058e-9, 1.5e-11, "m2")]
PREFIXES = {"f": 1e-15, "p": 1e-12, "n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
WORDS = st.text("abcdefghij0123456789.-", min_size=1, max_size=24)
NUMBERS = st.floats(1e-30, 1e30)


@st.composite
def text_tables(draw):
    count, rows = draw(st.integers(2, 12)), draw(st.integers(1, 6))
    columns = {f"c{place}": draw(st.lists(WORDS, min_size=rows, max_size=rows)) for place in range(count)}
    # A row is found again by its key.
    columns["c0"] = [f"row{place}" for place in range(rows)]
    return Table(columns, left=["c0"])


class TestText:
    @given(text_tables(), st.integers(52, 120))
    def test_a_wide_table_is_folded_into_whole_columns(self, table, width):
        blocks = [block.splitlines() for block in table.to_text(width).split("\n\n")]
        assert max(len(line) for block in blocks for line in block) <= width
        assert [line.split()[0] for line in blocks[0]] == ["c0", *table.columns["c0"]]
        joined = [[cell for block in blocks for cell in block[place].split()[1:]] for place in range(len(blocks[0]))]
        cells = [[name, *column] for name, column in table.columns.items()]
        assert joined == [list(row) for row in zip(*cells[1:], strict=True)]

    @given(text_tables())
    def test_on_a_pipe_each_row_is_one_line(self, table):
        lines = table.to_text(width=None).splitlines()
        assert [line.split() for line in lines[1:]] == [list(row) for row in zip(*table.columns.values(), strict=True)]

    def test_the_middle_of_a_long_table_is_counted(self):
        lines = Table({"load": [float(load) for load in range(100)]}, {"load": "N"}).to_text(max_rows=10).splitlines()
        assert [line.strip() for line in lines[4:8]] == ["3 N", "4 N", "... 90 more", "95 N"]

    @given(
        st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=4),
        st.floats(1e-4, 0.3),
        st.sampled_from(["m", "Pa", "N/m", "m2", "W/K"]),
    )
    def test_estimates_have_the_digits_that_their_uncertainty_allows(self, values, relative, unit):
        """In the unit of the heading each number is its value, to a tenth of its uncertainty."""
        column = [rc.Estimate(value, relative * value, unit) for value in values]
        head, *cells = Table({"q": column}).to_text().splitlines()
        symbol = head.strip().removeprefix("q, ")
        assert symbol.endswith(unit)
        factor = PREFIXES.get(symbol.removesuffix(unit), 1e15) ** (2 if unit == "m2" else 1)
        for value, cell in zip(values, cells, strict=True):
            number, uncertainty = (float(text) for text in cell.split(" +- "))
            assert number * factor == pytest.approx(value, abs=0.1 * relative * value)
            assert uncertainty * factor == pytest.approx(relative * value, rel=0.06)

    def test_a_prefix_is_one_inside_a_power(self):
        """200 mm3/s are 200e-9 m3/s; before an inverse there is none."""
        text = Table({"leakage": [rc.Estimate(2e-7, 1e-8, "m3/s")]}).to_text()
        assert text.splitlines()[0].strip() == "leakage, mm3/s"
        assert float(text.splitlines()[1].split()[0]) == pytest.approx(200.0)
        assert Table({"curvature": [rc.Estimate(2e5, 1e3, "1/m")]}).to_text().split()[:2] == ["curvature,", "1/m"]

    def test_answers_of_several_units_have_theirs_beside_them(self):
        answers = {"contact area": AREAS[0], "maximum pressure": rc.Estimate(1.2e9, 3e7, "Pa")}
        table = Table({"answer": list(answers), "value": list(answers.values())}, left=["answer"])
        assert table.to_text().splitlines()[1:] == [
            "contact area        213.0 +- 4.0 µm2",
            "maximum pressure  1.200 +- 0.030 GPa",
        ]


class TestPrograms:
    @given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=5))
    def test_a_csv_file_and_a_data_frame_have_all_digits(self, tmp_path_factory, pairs):
        pandas = pytest.importorskip("pandas")
        areas = [rc.Estimate(*pair, "m2") for pair in pairs]
        table = Table({"load": np.arange(len(pairs)), "area": areas}, {"load": "N"})
        path = tmp_path_factory.getbasetemp() / "table.csv"
        table.to_csv(path)
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        assert head == ["load [N]", "area [m2]", "area_uncertainty [m2]"]
        assert [(float(area), float(uncertainty)) for _, area, uncertainty in rows] == pairs
        frame = table.to_pandas()
        assert isinstance(frame, pandas.DataFrame)
        assert list(zip(frame["area"], frame["area_uncertainty"], strict=True)) == pairs
        assert frame.attrs["units"] == {"load": "N", "area": "m2", "area_uncertainty": "m2"}

    def test_units_that_differ_are_a_column(self, tmp_path):
        Table({"value": [AREAS[0], None, rc.Estimate(1e9, 0.0, "Pa")]}).to_csv(tmp_path / "a.csv")
        with (tmp_path / "a.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        assert rows == [
            ["value", "value_uncertainty", "value_unit"],
            ["2.13e-10", "4e-12", "m2"],
            ["", "", ""],
            ["1000000000.0", "0.0", "Pa"],
        ]


def test_pages_have_the_signs_of_print():
    table = Table({"load": [1.0, math.nan], "area": AREAS}, {"load": "N"}, left=["load"])
    assert table.to_markdown().splitlines() == [
        "| load | area, µm² |",
        "|---|---:|",
        "| 1 N | 213.0 ± 4.0 |",
        "| - | 1058 ± 15 |",
    ]
    assert "<th>area, µm²</th></tr><tr><td>1 N</td><td>213.0 ± 4.0</td>" in table.to_html()
    assert Table({"case": ["a|b"]}).to_markdown().endswith(r"| a\|b |")


@pytest.mark.parametrize(
    "make", [lambda: Table({"a": [1.0], "b": [1.0, 2.0]}), lambda: Table.from_rows(["a", "a"], [(1.0, 2.0)])]
)
def test_columns_that_do_not_fit_each_other_are_refused(make):
    with pytest.raises(rc.InputError, match="columns must"):
        make()


def describe_classes():
    """Yield each class of the package with the names that it defines itself."""
    root = Path(rc.__file__).parent
    for path in root.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                yield node.name, {one.name for one in node.body if isinstance(one, ast.FunctionDef)}


@pytest.mark.slow
def test_tables_files_and_pages_of_results_are_written_once():
    written = {"to_csv", "to_pandas", "to_html", "_repr_html_"}
    own = {name: names & written for name, names in describe_classes() if names & written}
    # The picture of a map is a view.
    assert set(own) == {"Table", "Result", "TableResult", "HeightMap"}
    assert own["HeightMap"] == {"_repr_html_"}


WAVE = rc.Body(rc.WavySurface(1e-6, 50e-6), rc.Elastic(210e9, 0.3))


def make_results(tmp_path):
    """Return a result of each kind on few cells."""
    problem = rc.ContactProblem(WAVE, grid=rc.Grid((16, 24), (100e-6, 50e-6)), boundary="periodic")
    loads = [50e6, 100e6]
    return [
        problem.sweep(pressure=loads),
        rc.interface_law(problem, loads),
        rc.film_law(problem, [1.0, 3.0], sampling=False),
        rc.Study({"wave": problem}, pressure=loads).run(tmp_path),
        rc.error_vs_time(problem, pressure=50e6, cells=[16], repeats=1),
        rc.stability(problem, pressure=50e6),
        problem.path(pressure=50e6, tangential_force=[(0.02, 0.0)], friction=0.3),
    ]


@pytest.mark.slow
def test_each_result_has_table_file_text_and_page(tmp_path):
    html5lib = pytest.importorskip("html5lib")
    for result in make_results(tmp_path / "study"):
        table = result.table()
        result.to_csv(tmp_path / "rows.csv")
        with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
            _, *rows = csv.reader(file)
        assert len(rows) == len(next(iter(table.columns.values())))
        headings, shown = result.short_table().to_cells()
        words = " ".join(str(result).split())
        assert all(" ".join(row[0].split()) in words for row in shown)
        result.to_html(tmp_path / "page.html")
        page = (tmp_path / "page.html").read_text(encoding="utf-8")
        tree = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False).parse(page)
        texts = " ".join("".join(tree.itertext()).split())
        assert all(" ".join(text.split()) in texts for text in getattr(result, "warnings", ()))
        if not isinstance(result, rc.results.Sweep):
            # The page of a sweep states the numbers at each load with their uncertainties instead.
            assert all(" ".join(heading.split()) in texts for heading in headings)
        if isinstance(result, (rc.results.InterfaceLaw, rc.results.FilmLaw)):
            assert len(list(tree.iter("img"))) == len(set(result.columns) & set(result.short_table().columns)) > 1
        found = result._repr_html_()
        assert all(f"<th>{html.escape(heading)}</th>" in found for heading in headings)
