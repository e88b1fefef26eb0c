"""The tables of the pages are those that their scripts write."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "studies"))

import doc_tables

# CPU time up to which a table is computed again, s.
LONGEST = 60.0
FOUND = doc_tables.find_tables()


@pytest.mark.parametrize("name", sorted(FOUND))
def test_the_page_holds_what_the_script_wrote(name):
    wanted = doc_tables.format_rows(doc_tables.load_table(name).shown(doc_tables.read(name)))
    for page in FOUND[name][1]:
        text = page.read_text(encoding="utf-8")
        held = [match["text"].strip() for match in doc_tables.MARKED.finditer(text) if match["name"] == name]
        assert held == [wanted], f"{page.name}: python docs/studies/doc_tables.py {name}"


def test_the_picture_of_the_uncertainties_shows_the_stored_tables():
    pytest.importorskip("matplotlib")
    image = importlib.import_module("PIL.Image")
    plus_minus = importlib.import_module("plus_minus")
    dots = plus_minus.find_dots()
    assert {dot.answer for dot in dots} == set(plus_minus.ROWS)
    with image.open(plus_minus.PICTURE) as picture:
        assert picture.text["Comment"] == plus_minus.list_numbers(dots), "python docs/studies/plus_minus.py"


def test_every_stored_table_is_in_a_page():
    assert {path.stem for path in doc_tables.STORE.glob("*.csv")} == set(FOUND)
    marks = sum(page.read_text(encoding="utf-8").count("<!-- table:") for page in doc_tables.PAGES)
    assert marks == sum(len(pages) for _, pages in FOUND.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in sorted(FOUND) if doc_tables.load_table(name).seconds <= LONGEST])
def test_the_script_still_finds_it(name):
    table = doc_tables.load_table(name)
    with doc_tables.computing_some():
        rows = table.rows()
    assert doc_tables.compare_some(rows, doc_tables.read(name), table) == []


def test_cells_are_compared_by_their_last_digit():
    table = doc_tables.DocTable(list, 1.0, timed=("CPU, s",))
    stored = [["N", "area", "CPU, s"], ["64", "90.2 ± 10.0", "0.1"], ["128", "-3.3e-06", "0.4"]]
    assert doc_tables.compare([stored[0], ["64", "90.3 ± 9.9", "7"], ["128", "-3.2e-06", "9"]], stored, table) == []
    (sentence,) = doc_tables.compare([stored[0], ["64", "90.2 ± 10.2", "7"], stored[2]], stored, table)
    assert "'90.2 ± 10.2', stored is '90.2 ± 10.0'" in sentence
    assert doc_tables.compare([stored[0], ["64", "105.5", "7"], stored[2]], stored, table)
    assert doc_tables.compare(stored[:2], stored, table)


def test_some_lines_and_columns_are_compared_with_those_they_stand_for():
    table = doc_tables.DocTable(list, 1.0)
    stored = [["N", "64", "128"], ["a", "1.0", "2.0"], ["b", "1.0", "3.0"], ["c", "4.0", "5.0"]]
    cases = ["a", "b", "c"]
    assert doc_tables.some_of(cases, 0, 2) == cases
    with doc_tables.computing_some():
        assert doc_tables.some_of(cases, 0, 2) == ["a", "c"]
    assert doc_tables.some_of(cases, 0, 2) == cases
    for rows in (stored, [stored[0], *stored[2:]], [["N", "128"], ["a", "2.0"], ["c", "5.0"]]):
        assert doc_tables.compare_some(rows, stored, table) == []
    wrong = [["N", "128"], ["a", "2.0"], ["c", "5.2"]]
    assert doc_tables.compare_some(wrong, stored, table) == ["line 1, '128': '5.2', stored is '5.0'"]
    for rows in (
        stored[:1],
        [stored[0], stored[3], stored[1]],
        [stored[0], stored[1], stored[1]],
        [*stored, stored[3]],
        [["n", "64", "128"], stored[1]],
        [["N", "64", "256"], stored[1]],
    ):
        assert doc_tables.compare_some(rows, stored, table)


def test_a_table_is_written_between_its_marks(monkeypatch, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- table: one, by docs/studies/x.py -->\nold\n<!-- end of table -->\nb\n", encoding="utf-8")
    monkeypatch.setattr(doc_tables, "PAGES", [page])
    monkeypatch.setattr(doc_tables, "STORE", tmp_path / "tables")
    doc_tables.write("one", [["N"], ["64"]], quiet=True)
    text = page.read_text(encoding="utf-8")
    assert text.startswith("a\n<!-- table: one, by docs/studies/x.py -->\n\n| N |\n|---|\n| 64 |\n\n<!-- end")
    assert text.endswith("-->\nb\n")
    assert doc_tables.read("one") == [["N"], ["64"]]
    doc_tables.write("one", [["N", "error"], ["64", "2"]], quiet=True, shown=doc_tables.pick(["error"]))
    assert "| error |\n|---|\n| 2 |\n" in page.read_text(encoding="utf-8")
    assert doc_tables.read("one") == [["N", "error"], ["64", "2"]]
    with pytest.raises(SystemExit, match="no page has a table 'two'"):
        doc_tables.write("two", [["N"]])


def test_a_figure_may_stand_for_a_table(monkeypatch, tmp_path):
    page = tmp_path / "page.md"
    mark = "<!-- table: one, by docs/studies/x.py -->\n<!-- end of table -->\n"
    page.write_text(mark.replace("-->\n<", "-->\n\n| N |\n|---|\n| 64 |\n\n<"), encoding="utf-8")
    monkeypatch.setattr(doc_tables, "PAGES", [page])
    monkeypatch.setattr(doc_tables, "STORE", tmp_path / "tables")
    doc_tables.write("one", [["N"], ["64"]], quiet=True, shown=doc_tables.show_none)
    assert page.read_text(encoding="utf-8") == mark
    assert doc_tables.read("one") == [["N"], ["64"]]


def test_a_page_may_show_a_part_of_a_table():
    rows = [["class", "cases", "error, %"], ["wave", "3", "0.2"], ["wave, turned", "4", "1.5"], ["ball", "5", "0.1"]]
    assert doc_tables.pick(["error, %"], ["wave"])(rows) == [["error, %"], ["0.2"]]
    assert doc_tables.pick(lines=["ball; 5"])(rows) == [rows[0], rows[3]]
    show = doc_tables.gather(
        {"waves": ["wave", "wave, turned"], "balls": ["ball"]}, {"class": "contact", "error, %": "%"}
    )
    assert show(rows) == [["contact", "%"], ["waves", "0.2 to 1.5"], ["balls", "0.1"]]
    assert doc_tables.span(["96 %", "", "100 %"]) == "96 to 100 %"
