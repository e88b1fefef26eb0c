"""The lint of phrases finds what it bans, across lines and in names, and lets plain English pass."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / ".ci" / "phrases.py"


@pytest.fixture(scope="module")
def find():
    return runpy.run_path(str(SCRIPT))["find"]


@pytest.mark.parametrize(
    ("sentence", "phrase"),
    [
        ("Such a file is no map.", "is no map"),
        ("The surface goes on there\nwith its own copy.", "goes on there"),
        ("# Here is what\n    # it took.", "what # it took"),
        ("a stand-in for the maps", "stand-in"),
        ("problem.left_out", "left_out"),
        ("the undeformed gap", "undeformed"),
        ("its greatest pressure", "greatest"),
        ("where the gap is least", "least"),
        ("each whole, and its area", "each whole"),
        ("one share of the cells", "share of"),
        ("Doubts are printed.", "Doubts"),
    ],
)
def test_a_banned_phrase_is_found(find, sentence, phrase):
    assert [(line, found) for line, found, _ in find(f"\n{sentence}\n")] == [(2, phrase)]


@pytest.mark.parametrize(
    "sentence",
    [
        "There is no contact.",
        "The gap is no longer positive.",
        "at least squares_of(least_squares)",
        "the body moves as a whole.",
        "cells that share a side",
        "The whole domain is in contact.",
        "scan the barometer and the landscape",
    ],
)
def test_plain_english_passes(find, sentence):
    assert list(find(sentence)) == []


def test_the_command_names_file_line_and_word(tmp_path, capsys):
    main = runpy.run_path(str(SCRIPT))["main"]
    path = tmp_path / "text.md"
    path.write_text("All well.\nThe undeformed gap.\n", encoding="utf-8")
    assert main([str(path)]) == 1
    assert capsys.readouterr().out == f"{path}:2: 'undeformed': initial gap\n"
    path.write_text("The initial gap.\n", encoding="utf-8")
    assert main([str(path)]) == 0
