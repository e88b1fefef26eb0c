"""The help of the command line: short, with the rest by topics, and what stands in place of a sentence without end."""

from __future__ import annotations

import os
import re
import sys
import warnings

import pytest

import roughcontact as rc
from roughcontact.__main__ import commands, main

# Options that the short help of a command has at most.
MAX_OPTIONS = 21
OPTION = re.compile(r"^  (?:-\w[^-]*, )?(--[\w-]+)", re.MULTILINE)


@pytest.fixture(autouse=True)
def narrow(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")


def list_options(text):
    """Return the options that a help describes, without those that ask for help."""
    shown = text.partition("more options:")[0].partition("examples:")[0]
    return [one for one in OPTION.findall(shown) if not one.startswith("--help")]


@pytest.mark.parametrize("name", sorted(commands))
def test_the_short_help_has_about_twenty_options_and_topics_the_rest(run, name):
    _, short, _ = run(name, "--help")
    found = list_options(short)
    assert len(found) < MAX_OPTIONS
    _, everything, _ = run(name, "--help-all" if "--help-all" in short else "--help")
    topics = re.findall(r"^  --help (\w+)", short, re.M)
    told = {*found, *(option for topic in topics for option in list_options(run(name, "--help", topic)[1]))}
    assert told == set(list_options(everything))
    assert bool(topics) == (told != set(found))


def test_the_short_help_of_solve_has_what_people_use(run):
    _, short, _ = run("solve", "--help")
    usual = {"--force", "--pressure", "--young", "--material", "--size", "--unit", "--boundary", "--csv", "--report"}
    assert usual <= set(list_options(short))
    assert not {"--layer", "--cycle", "--adhesion", "--kernel", "--quiet"} & set(list_options(short))
    # A text that names no topic, such as a map, gets the short help.
    assert run("solve", "--help", "map.npz")[1] == short


def test_a_command_without_the_arguments_that_it_needs_shows_its_help(run):
    for name in ("solve", "law", "run", "check", "surface", "info"):
        status, out, err = run(name)
        assert (status, err) == (2, "")
        assert out == run(name, "--help")[1]
    assert run("solve", "map.npz")[0] == 2
    assert "usage:" in run("solve", "map.npz")[2]


def test_a_word_of_several_materials_names_them(run):
    status, _, err = run("solve", "map.npz", "--force", "1N", "--material", "steel")
    assert status == 2
    assert "there is no 'steel'. Did you mean " in err
    assert all(f"{one} steel" in err.partition("Known:")[0] for one in ("bearing", "stainless", "structural"))
    assert "Did you mean 'PTFE'?" in run("solve", "map.npz", "--force", "1N", "--material", "ptfe")[2]


def test_a_part_that_is_not_known_is_answered_in_a_few_names(run):
    status, _, err = run("check", "NONSENSE")
    assert status == 2
    assert len(err) < 250
    assert "others ('roughcontact check --help' lists them)" in " ".join(err.split())
    listed = run("check", "--help")[1]
    assert all(name in listed for registry in (rc.kernels, rc.areas, rc.laws) for name in registry)


def test_a_length_is_explained_by_an_example(run):
    _, text, _ = run("surface", "sphere", "--help")
    assert "Radius R of the sphere, such as 250um." in text
    for kind in rc.surfaces:
        assert not re.search(r", (m|Pa|rad)[.;,]", " ".join(run("surface", kind, "--help")[1].split()))


def test_versions_of_packages_are_told_on_request(run):
    assert run("--version") == (0, f"roughcontact {rc.__version__}\n", "")
    status, out, _ = run("--version", "--verbose")
    assert status == 0
    assert re.search(r"^numpy +\d", out, re.M)
    assert run("--verbose")[0] == 2


def test_sentences_break_at_blanks_at_the_width_of_the_terminal_that_shows_them(capfd, monkeypatch):
    """Standard output goes to a file, so that its width says nothing."""

    def measure(descriptor):
        if descriptor == sys.__stdout__.fileno():
            raise OSError("no terminal")
        return os.terminal_size((50, 24))

    monkeypatch.delenv("COLUMNS")
    monkeypatch.setattr(os, "get_terminal_size", measure)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(["solve", "none.npz", "--force", "1N", "--young", "1GPa", "--pull-off"]) == 2
    told = capfd.readouterr().err
    warned = warnings.formatwarning(
        "A sentence of many words that no terminal of 50 columns shows in a line.", None, "", 1
    )
    for text in (told, warned):
        lines = text.splitlines()
        assert lines[0].startswith("roughcontact: ")
        assert 40 < max(map(len, lines)) < 50
