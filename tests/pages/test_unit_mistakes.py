"""The sentences of first-day mistakes, in the words of the command line."""

from __future__ import annotations

import pytest

from roughcontact._faces.cli.options import spell_options
from roughcontact.errors import Sentence
from test_mistakes import ROWS, study

ARGUMENTS = ("size", "cell", "unit", "decimal")


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    study.write_maps(folder)
    return folder


@pytest.mark.parametrize("mistake", study.MISTAKES, ids=lambda mistake: mistake.name)
def test_every_mistake_gets_its_sentence(mistake, maps):
    sentences = study.list_sentences(mistake, maps)
    if mistake.command:
        status, printed = study.run(mistake, maps)
        assert status == (2 if printed.startswith("roughcontact: ") else 0 if "modulus E*" in sentences[0] else 3)
        for sentence in sentences:
            # The page has them as scripts read them: warnings have advice, refusals name arguments.
            assert sentence in printed or Sentence(sentence).spell(spell_options(ARGUMENTS), scripts=True) in printed
        assert printed.endswith("see its warnings.") == (status == 3)
    assert (study.write_row(mistake, sentences) in ROWS) == mistake.on_page
