"""What to cite: the repository's own citation, and the references of docstrings as text and BibTeX."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import roughcontact as rc
from roughcontact._base.registry import registries
from roughcontact._work.reports import citation

ROOT = Path(__file__).parents[2]


def test_it_is_that_of_the_repository():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    for value in (citation.TITLE, citation.AUTHORS, citation.ADDRESS, citation.PAPER, citation.JOURNAL):
        assert f": {value}\n" in text
    assert f"doi: {citation.PAPER_DOI}\n" in text
    assert f"year: {citation.PAPER_YEAR}\n" in text
    assert f"(c) {citation.YEAR}," in (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_methods_are_cited_by_the_dois_of_their_docstrings():
    found = citation.list_references("1.2.3", [rc.Love(), rc.PolonskyKeer(), rc.Perimeter(), rc.Blend()])
    addresses = [one.address for one in found]
    assert "1.2.3" in found[0].text
    assert len(set(addresses)) == len(addresses)
    for doi in ("10.1098/rsta.1929.0009", "10.1016/S0043-1648(99)00113-1", "10.1016/j.triboint.2017.04.023"):
        assert f"https://doi.org/{doi}" in addresses
    assert all(re.search(r"\(\d{4}\)", one.text) for one in found)


def test_every_registered_part_has_references_that_bibtex_can_hold():
    names = sorted({name for registry in registries().values() for name in registry})
    text = rc.cite(*names, style="bibtex")
    entries = text.split("\n\n")
    keys = [re.match(r"@\w+\{([\w-]+),", entry)[1] for entry in entries]
    assert len(set(keys)) == len(keys) == len(rc.cite(*names).splitlines())
    assert "@misc" not in text
    assert not re.search(r"(?<!\\)[&%#]", text)
    assert text.count("{") == text.count("}")
    # The program is by its developers, and the paper's authors are those at its DOI.
    assert all("author = " in entry for entry in [entries[0], *entries[2:]])


def test_what_a_solution_used_is_cited_and_what_it_did_not_is_not():
    ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(5e6, 0.5))
    grid = rc.Grid((16, 16), 0.4e-3)
    plain = rc.ContactProblem(ball, grid=grid)
    sticky = rc.ContactProblem(ball, grid=grid, adhesion=rc.ShortRange(work=0.05))
    assert "Liu, Wang, Liu" in rc.cite(plain)
    assert "Kendall" not in rc.cite(plain)
    assert "Johnson, Kendall, Roberts" in rc.cite(sticky)
    solution = plain.solve(force=1e-4)
    assert rc.cite(solution) == rc.cite(plain) == rc.cite(plain.sweep(force=[1e-4]))
    assert rc.cite(solution, "leakage").startswith(rc.cite(solution))


@pytest.mark.parametrize("wrong", ["no such name", 3, None, rc.Grid, [rc.Love()]])
def test_what_cannot_be_cited_is_refused(wrong):
    with pytest.raises(rc.InputError):
        rc.cite(wrong)
    with pytest.raises(rc.InputError, match="The style of references must be"):
        rc.cite(style=wrong)


def test_versions_are_printed_a_line_each(capsys, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    rc.show_versions()
    rows = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert rows["roughcontact"] == rc.__version__
    assert {"python", "system", "threads", "memory", "numpy", "scipy", "attrs"} <= set(rows)
    assert rows["OMP_NUM_THREADS"] == "7"
