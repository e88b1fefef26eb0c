"""Parts of a report: what to cite, numbers of a script, and texts that are escaped."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact._faces.html import report
from roughcontact._faces.html.elements import escape, quantity
from roughcontact._solve.problem import write_number

ROOT = Path(__file__).parents[2]


def test_numbers_are_exact_and_short():
    for value, text in ((200e9, "200e9"), (12.5e-6, "12.5e-6"), (5e-7, "500e-9"), (0.3, "0.3"), (-0.0, "-0.0")):
        assert write_number(value) == text
    rng = np.random.default_rng(1)
    for value in rng.standard_normal(300) * 10.0 ** rng.integers(-300, 300, 300):
        assert float(write_number(value)) == value
    assert eval(write_number(np.inf)) == np.inf


class TestCitation:
    def test_it_is_that_of_the_repository(self):
        text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
        for value in (report.TITLE, report.AUTHORS, report.ADDRESS, report.PAPER, report.JOURNAL):
            assert f": {value}\n" in text
        assert f"doi: {report.PAPER_DOI}\n" in text
        assert f"year: {report.PAPER_YEAR}\n" in text
        assert f"(c) {report.YEAR}," in (ROOT / "LICENSE").read_text(encoding="utf-8")

    def test_methods_are_cited_by_the_dois_of_their_docstrings(self):
        found = report.list_references("1.2.3", [rc.Love(), rc.PolonskyKeer(), rc.Perimeter(), rc.Blend()])
        addresses = [one.address for one in found]
        assert "1.2.3" in found[0].text
        assert len(set(addresses)) == len(addresses)
        for doi in ("10.1098/rsta.1929.0009", "10.1016/S0043-1648(99)00113-1", "10.1016/j.triboint.2017.04.023"):
            assert f"https://doi.org/{doi}" in addresses
        assert all(re.search(r"\(\d{4}\)", one.text) for one in found)

    def test_bibtex_has_title_version_and_year(self):
        entry = report.write_bibtex("1.2.3")
        for line in ("title = {roughcontact}", "version = {1.2.3}", f"year = {{{report.YEAR}}}"):
            assert line in entry


def test_units_are_raised_and_texts_escaped():
    assert quantity("(1.0 +- 0.1) % of nominal, 360 µm2 [a<b]") == "(1.0 ± 0.1) % of nominal, 360 µm² [a&lt;b]"
    assert quantity("2 mm3/s, 5 W/(m2 K)") == "2 mm³/s, 5 W/(m² K)"
    assert escape("a\x00\x1b\ufffe\udc80b\n") == "a????b\n"
