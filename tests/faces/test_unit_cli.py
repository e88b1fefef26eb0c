"""Parts of the command line: words, numbers, progress, and what a command asks and ends with."""

from __future__ import annotations

import argparse
import contextlib
import csv
import functools
import io
import pickle
import re
import sys

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from roughcontact._answers.linear import stiffness
from roughcontact._base.machine import progress
from roughcontact._base.units import fit
from roughcontact._faces.cli import paths as path_command
from roughcontact._faces.cli.options import spell_options, whole_number
from roughcontact._faces.cli.progress import count_grids
from roughcontact._solve.problem import find_required_load
from roughcontact._solve.solution.plausibility import PLAUSIBILITY_RULES
from roughcontact._work.reports.stability_report import RULES
from roughcontact.errors import argument, either
from roughcontact.typing import Step
from test_adhesion_faces import BODY, write_ball
from test_cli_answers import STEEL, write_maps
from test_cli_words import PYTHON

CYCLE = ["--cycle", "-300nm", "300nm", "--states", "5", "--adhesion", "exponential", "work=50mJ/m2", "range=200nm"]
SLIDE = ["--friction", "0.3", "--slide"]
STICKY = ["--young", "5MPa", "--poisson", "0.5", "--adhesion", "exponential", "work=50mJ/m2", "range=2um"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_maps()


@pytest.mark.parametrize("doubtful", [True, False])
def test_a_cycle_ends_with_three_where_an_answer_alone_is_doubtful(tmp_path, run, monkeypatch, doubtful):
    monkeypatch.setattr(path_command, "is_doubtful", lambda *_: doubtful)
    status, _, errors = run("solve", write_ball(tmp_path), *CYCLE, *BODY, "--stiffness")
    assert status == (3 if doubtful else 0)
    assert ("doubtful: see its warnings" in errors) == doubtful


def test_several_loads_share_their_pull_off(tmp_path, run, monkeypatch):
    calls = []
    follow = stiffness.find_pull_off
    monkeypatch.setattr(stiffness, "find_pull_off", lambda *given: calls.append(given) or follow(*given))
    law = ["--adhesion", "exponential", "work=51mJ/m2", "range=200nm"]
    status, out, _ = run("solve", write_ball(tmp_path), "--loads", "1nN", "0N", *BODY, *law, "--pull-off", "--csv")
    assert status in (0, 3)
    rows = list(csv.DictReader(io.StringIO(out)))
    assert len({row["pull-off [N]"] for row in rows}) == len(calls) == 1
    assert -2.0 < float(rows[0]["pull-off [N]"]) / (np.pi * 0.051 * 2e-6) < -1.5


class TestText:
    def test_finer_grids_of_a_periodic_map(self, run):
        options = ["--pressure", "20MPa", *STEEL, "--boundary", "periodic", "--refine", "2"]
        _, out, _ = run("solve", "periodic.npz", *options)
        problem = rc.ContactProblem(
            rc.Body(rc.read_surface("periodic.npz"), rc.Elastic(210e9, 0.3)), boundary="periodic"
        )
        ladder = rc.extrapolate(problem, pressure=20e6, levels=2)
        assert str(ladder) in out
        assert fit(str(ladder.states[-1])).splitlines()[0] in out


def test_long_lines_are_continued_under_their_text():
    text = "label   " + "word " * 30 + "9.8 % (1 +- 2) 3 µm"
    lines = fit(text).splitlines()
    assert all(line.startswith(8 * " ") for line in lines[1:])
    assert max(map(len, lines)) <= 80
    assert "9.8 %" in fit("x" * 75 + " 9.8 %").splitlines()[1]
    assert fit("a\n\nb") == "a\n\nb"


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["solve", "rough.npz", "--loads", "10mN", "12mN", "14mN", *STEEL], "load 3 of 3, force 10 mN: 48 x 48 cells"),
        (["solve", "rough.npz", "--solve-for", "area=10%", *STEEL], "load 2 of about "),
        (["solve", "wave.npz", "--pressure", "50MPa", "--refine", "2", *STEEL], "solving: 96 x 96 cells"),
        (["solve", "rough.npz", "--pressure", "50MPa", "--area-within", "5%", *STEEL], "solving: 48 x 48 cells"),
        (["solve", "wave.npz", "--pressure", "50MPa", "--area-within", "0.1%", *STEEL], r"solving: (\d{3}) x \1 cells"),
        (["solve", "rough.npz", "--pressure", "50MPa", *SLIDE, *STEEL], "sliding: 48 x 48 cells, iteration 2"),
        (["law", "wave.npz", "--loads", "1MPa..2MPa", *STEEL], "load 3 of 3"),
        (["solve", "rough.npz", "--cycle", "-2um", "1um", "--states", "3", *STICKY], "state 5 of 5"),
        (["solve", "rough.npz", "--loads", "20uN", "0N", "-20uN", *STICKY], "load 3 of 3, force -20 µN: 48 x 48 cells"),
        (["solve", "ball.npz", "--force", "0N", "--pull-off", *STICKY], r"pull-off, state (\d+) of about \1, force -"),
        (["solve", "rough.npz", "--force", "10mN", "--stiffness", "--peak-pressure", *STEEL], "answer 2 of 2"),
        (["stability", "wave.npz", "--pressure", "50MPa", *STEEL], "tighter tolerance"),
    ],
)
def test_progress_says_what_is_solved_and_how_long_it_takes(monkeypatch, capsys, arguments, words):
    tqdm = pytest.importorskip("tqdm")
    rough = rc.read_surface("rough.npz")
    np.savez("wave.npz", heights=rough.values, size=rough.size, periodic=True)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    # Each change is drawn.
    monkeypatch.setattr(progress, "_import_tqdm", lambda: functools.partial(tqdm.tqdm, mininterval=0.0))
    monkeypatch.setenv("COLUMNS", "200")
    with contextlib.suppress(SystemExit):
        main([str(one) for one in arguments])
    drawn = terminal.getvalue().split("\r")
    assert any(re.search(words, text) for text in drawn), drawn
    assert any(re.match(r" *\d+ % \|.{10}\| \d\d:\d\d < (\d\d:\d\d|\?)  ", text) for text in drawn), drawn


class TestFractions:
    """The fraction of all work that is done, from which the time left follows."""

    @staticmethod
    def follow(find_fraction, *shapes):
        """Return the fractions along solves on some grids, at an error that has fallen half way, and at the end."""
        return [find_fraction(Step((n, n), 3, error)) for n in shapes for error in (1e-2, 1e-4)]

    def test_known_grids_count_by_their_cells(self):
        found = self.follow(count_grids((8, 8), 1e-4, doublings=1), 4, 8, 16)
        assert found == sorted(found)
        assert found[:2] == [0.0, 0.0]
        assert found[3] == pytest.approx(64 / 320)
        assert found[5] == pytest.approx(1.0)

    def test_of_unknown_grids_each_may_be_the_last_but_the_first(self):
        found = self.follow(count_grids((8, 8), 1e-4, doublings=None), 8, 12, 24)
        assert found[:2] == [None, None]
        assert 64 / 208 < found[2] < found[3] == 1.0
        assert 208 / 784 < found[4] < found[5] == 1.0
        assert self.follow(count_grids((8, 8), 1e-4, doublings=None, refined=False), 8)[1] == 1.0

    def test_the_solves_of_a_search_are_foreseen(self):
        grid = rc.Grid((48, 48), 48e-6)
        body = rc.Body(rc.read_surface("rough.npz"), rc.Elastic(210e9, 0.3))
        problem = rc.ContactProblem(body, grid=grid)
        left = []
        found = find_required_load(
            problem, lambda load, start: problem.solve(**load.arguments, start=start),
            rc.responses.create("stiffness"), "1MN/m", {}, left.append,
        )  # fmt: skip
        # One call after each solve but the last, and never more than twice the solves that came.
        assert len(left) >= found.solves - 2 > 0
        assert all(count >= 1 for count in left)
        assert left[0] <= 2 * found.solves


class TestOptionsInSentences:
    @pytest.mark.parametrize(
        ("written", "python", "words"),
        [
            (argument("size", "x", "y", unit="m"), "size=(x, y), m", "--size X Y"),
            (argument("non_measured", "keep"), "non_measured='keep'", "--non-measured keep"),
            (argument("unit", 1e-9, unit="m"), "unit=1e-09", "--unit 1nm"),
            (argument("size", 6.4e-5, 4.8e-5, unit="m"), "size=(6.4e-05, 4.8e-05)", "--size 64um 48um"),
            (argument("decimal", ","), "decimal=','", "--decimal ','"),
            (argument("skip_rows"), "skip_rows=", "--skip-rows"),
            (argument("no_data", -9999.0), "no_data=-9999", "--no-data -9999"),
            (argument("slide", call="problem.slide(...)"), "problem.slide(...)", "--slide"),
            (argument("displacement"), "displacement=", "displacements to --tangential"),
            (argument("convolver", "auto"), "convolver='auto'", "convolver='auto'"),
            (either(argument("skip_rows"), "the file"), "skip_rows=", "--skip-rows"),
            (either(argument("convolver"), "the file"), "convolver=", "the file"),
            (either(", as by numpy"), ", as by numpy", ", as by numpy"),
            (
                "numpy.savez(path, size=(lx, ly))",
                "numpy.savez(path, size=(lx, ly))",
                "numpy.savez(path, size=(lx, ly))",
            ),
        ],
    )
    def test_take_the_place_of_arguments(self, written, python, words):
        known = ["size", "unit", "non_measured", "decimal", "skip_rows", "no_data", "slide", "tangential"]
        error = pickle.loads(pickle.dumps(rc.InputError(f"Give {written}.")))
        assert str(error) == f"Give {python}."
        assert (
            rc.InputError(f"--map: {error.marked}").spell(spell_options(known), scripts=True) == f"--map: Give {words}."
        )

    def test_what_only_looks_like_a_mark_is_a_text(self):
        for text in ("\ue000[1]\ue001", "\ue000x\ue001 \ue002", argument("size", None), argument("size", ["x"])):
            assert rc.InputError(text).spell(spell_options(["size"])) == text


class TestAdvice:
    def test_no_advice_is_in_python_or_an_option(self):
        for rule in (*RULES.values(), *PLAUSIBILITY_RULES.values()):
            assert not PYTHON.search(rule.advice), rule.advice
            assert "--" not in rule.advice


def test_whole_numbers():
    assert whole_number("256") == 256
    assert whole_number("-1") == -1
    for text in ("2,5", "2.0", "1_000", "\uff12", " 2", "1e3", "0x10", "", "nan", "9" * 5000):
        with pytest.raises(argparse.ArgumentTypeError, match="is not a whole number; write it like 256"):
            whole_number(text)
