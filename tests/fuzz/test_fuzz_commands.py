"""Command lines with bad values: each ends in results or in one sentence, with the documented exit status.

They are made from the options that the commands declare. A part of them also runs studies whose TOML files are changed
at one place.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import test_fuzz_calls
from roughcontact.__main__ import commands, main
from systems import linux, posix

# Command lines of the long run, of one block of it, and of the ordinary run.
COMMANDS, BLOCK, FEW = 500, 100, 15
# Characters of what stands on stderr, the usage that argparse prints not counted.
LONGEST = 1_500

# Good values by the destination of an option.
GOOD = {
    "surface": ["map.npz"], "counterbody": ["map.npz", "map.txt"],
    "size": ["20um"], "unit": ["1um"], "tip_radius": ["2um"], "detrend": ["plane", "1"],
    "resample": ["8", "8"], "counterbody_size": ["20um"], "counterbody_unit": ["1nm"], "counterbody_detrend": ["mean"],
    "counterbody_tip_radius": ["1um"], "shortest": ["5um"], "longest": ["10um"],
    "ball": ["1mm"], "offset": ["1um,0um"], "rotation": ["10deg"], "domain": ["10um"], "pressure": ["10MPa"],
    "force": ["5mN"], "approach": ["10nm"], "young": ["210GPa"], "poisson": ["0.3"], "hardness": ["6GPa"],
    "counterbody_young": ["1GPa"], "counterbody_poisson": ["0.2"], "counterbody_hardness": ["1GPa"],
    "kernel": ["love"],
    "solver": ["auto"], "area": ["blend"], "cells": ["4", "8"], "areas": ["blend"], "kernels": ["love"],
    "solvers": ["polonsky-keer"], "tolerances": ["1e-6"], "repeats": ["1"], "output": ["out"], "name": ["elastic",
    "blend"],
    "fields": ["young=1e9", "poisson=0.3"], "study": ["study.toml"], "workers": ["1"],
    "threads": ["auto", "1", "2"], "loads": ["5mN", "9mN"], "refine": ["2"], "panel": ["pressure"],
    "report": ["a.html"],
}  # fmt: skip
BAD = [
    "", " ", "-", "--", "0", "-1", "1e400", "nan", "inf", "1", "2,5N", "1,5mm", "2 500mN", "5 MPa 3", "9**9**9**9N",
    "1e-320m",
    "1e300Pa", "1e30GPa", "-5um", "0um", "5", "5s", "5 kg", "1e9999N", "0x10", "1_000", "10^17", "100000000000000000",
    "99999999999999999999", "1/0", "a\0b", "\udcff", "x" * 3_000, "(" * 3_000, "9" * 5_000, "/", "/dev/null",
    "/dev/null/x",
    ".", "nope.npz", "text.npz", "empty.npz", "empty.txt", "ragged.txt", "mark.txt", "comma.csv", "nan.txt",
    "large.npz",
    "plane", "deg", "µm", "1µm", "ｘ", "１", "None", "True", "[]", "young=", "=", "young=1e9", "young=(1", "1um,2um",
    "1um,,", "-1um,nan", "%s", "{}", "young=" + "[" * 3_000, "young=" + "-" * 20_000 + "1",
    "love", "fourier", "polonsky-keer", "periodic", "~", "*", "\n", "a b",
]  # fmt: skip
STUDY = """\
[problems.steel]
boundary = "periodic"
grid = {shape = [8, 8], size = 1e-3}
body.surface = {type = "wavy", amplitude = 1e-6, wavelength = 1e-3}
body.material = {type = "elastic", young = 1e9, poisson = 0.3}

[study]
pressure = [1e4, 2e4]
areas = ["blend"]
seeds = []
"""
LITERALS = [
    "5", "-1", "nan", "inf", "-inf", "1e400", "1e-320", "true", '""', '"x"', '"love"', "[]", "[[]]", "[1]",
    "[-1, 5]", "{}",
    "{type = 5}", '{type = "elastic"}', '{type = "nope"}', "1979-05-27", "07:32:00", "9" * 5_000, "[" * 3_000, "x",
    '"\\u0000"', "[1e-3, 1e-3, 1e-3]", '["blend", "nope"]', "[nan]", '"1 mm"', "{a = {b = {c = 1}}}", "0.5",
    "[1e308, 1e308]",
    '{type = "file", path = "map.npz"}', '{type = "file", path = "../x.npz"}', "[true]", "[[1, 2], [3]]", '["5"]',
]  # fmt: skip


def prepare_files():
    rng = np.random.default_rng(0)
    heights = 1e-7 * rng.random((8, 8))
    np.savez("map.npz", heights=heights, size=(20e-6, 20e-6))
    np.savez("large.npz", heights=1e70 * heights, size=(1e-90, 1.0))
    np.savetxt("map.txt", heights)
    Path("study.toml").write_text(STUDY)
    for name, text in {
        "text.npz": "no archive", "empty.npz": "", "empty.txt": "", "ragged.txt": "1 2\n3\n",
        "mark.txt": "\ufeff1 2\n3 4\n",
        "comma.csv": "1,2,\n3,4,\n", "nan.txt": "nan nan\nnan nan\n",
    }.items():  # fmt: skip
        Path(name).write_text(text, encoding="utf-8")


def declared():
    """Return the arguments of each command."""
    found = {}
    for name in commands:
        parser = argparse.ArgumentParser(prog=name)
        commands.create(name).declare(parser)
        found[name] = [action for action in parser._actions if action.dest != "help"]
    return found


DECLARED = declared()
OURS = ("check", "info", "plot", "report", "run", "solve", "stability")


def make_command(seed):
    """Return a command line, and write the study that it runs."""
    rng = random.Random(seed)
    name = rng.choice(["solve", "solve", *OURS, *DECLARED, "nope"])
    if name not in OURS:
        # Commands of plug-ins may take long: theirs are wrong from the start.
        return [name, rng.choice(["--no-such-option", "--output"]), *rng.choice([[], ["--no-such-option"]])]
    if name == "run":
        Path("study.toml").write_text(change_study(rng))
    actions = {action.dest: action for action in DECLARED[name]}
    load = rng.choice(("pressure", "force", "approach"))
    chosen = [
        dest
        for dest, action in actions.items()
        if action.required or not (action.option_strings or action.nargs == "?")
    ]
    chosen += [load, "repeats", "output"] if name in ("solve", "report", "stability") else []
    chosen += rng.sample(sorted(actions), min(len(actions), rng.choice((0, 1, 1, 2))))
    chosen = [dest for dest in dict.fromkeys(chosen) if dest in actions]
    wrong = set(rng.sample(chosen, min(len(chosen), rng.choice((0, 1, 1, 2)))))
    words, options = [], []
    for dest in chosen:
        action = actions[dest]
        values = list(GOOD.get(dest, action.choices or ["x"]))
        if action.nargs in (None, "?"):
            values = [rng.choice(values)]
        if dest in wrong:
            values[rng.randrange(len(values))] = rng.choice(BAD)
        if action.option_strings:
            options += [action.option_strings[-1], *([] if action.nargs == 0 else values)]
        else:
            words += values
    return [name, *words, *options]


def change_study(rng):
    """Return the text of a study with one value, key or line changed."""
    lines = STUDY.splitlines()
    place = rng.randrange(len(lines))
    key, equals, _ = lines[place].partition("=")
    match rng.randrange(5):
        case 0 if equals:
            lines[place] = f"{key}= {rng.choice(LITERALS)}"
        case 1:
            word = rng.choice("amplitude wavelength type young poisson shape size material surface".split())
            at = next(i for i, line in enumerate(lines) if f"{word} =" in line)
            before, _, after = lines[at].partition(f"{word} = ")
            ends = [i for i in map(after.find, ",}") if i >= 0] or [len(after)]
            lines[at] = f"{before}{word} = {rng.choice(LITERALS)}{after[min(ends) :]}"
        case 2:
            lines[place] = lines[place].replace("e", "é", 1)
        case 3:
            lines[place] = f"{rng.choice(['', 'problems', 'study', 'x', 'problems.a'])} = {rng.choice(LITERALS)}"
        case _:
            del lines[place]
    return "\n".join(lines)


def fault(arguments):
    """Return what is wrong with how a command line ends; None if nothing is."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with test_fuzz_calls.bounded(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(arguments)
    except SystemExit as error:
        status = error.code
    except BaseException as error:
        return f"{type(error).__name__}: {error!s:.300}"
    said = err.getvalue().split("\nroughcontact")[-1]
    banned = (
        "Traceback",
        "object has no attribute",
        "array(",
        "broadcast",
        "please report",
        "not subscriptable",
        "Warning:",
    )
    found = [word for word in banned if word in err.getvalue()]
    if found or len(said) > LONGEST:
        return f"no sentence ({found}): {said[:600]}"
    if status not in (0, 1, 2, 3) or (status == 2 and not said.strip()):
        return f"status {status}: {said[:300]}"
    if status in (0, 3) and any(word in out.getvalue().split() for word in ("nan", "inf")):
        return f"not finite: {out.getvalue()[:600]}"
    return None


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    prepare_files()


def check_commands(seeds):
    faults = []
    for seed in seeds:
        arguments = make_command(seed)
        if found := fault(arguments):
            faults.append(f"seed {seed}: {arguments!r:.300}: {found}")
    assert not faults, f"{len(faults)} faults\n" + "\n".join(faults)


def test_a_few_commands_end_in_results_or_a_sentence(folder):
    check_commands(range(FEW))


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, COMMANDS, BLOCK))
def test_commands_end_in_results_or_a_sentence(start, folder):
    check_commands(range(start, start + BLOCK))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["solve", "map.npz", "--young", "1GPa", "--pressure", "1MPa", "-o", "a\0b"], "without the character NUL"),
        (["solve", "a\0b", "--young", "1GPa", "--pressure", "1MPa"], "NUL"),
        (
            ["solve", "map.npz", "--young", "1GPa", "--pressure", "1MPa", "-o", "map.npz"],
            "is a height map that is read",
        ),
        (["check", "elastic", "--with", "poisson=0.3", "young=" + "-" * 20_000 + "1"], "Young's modulus"),
        (["stability", "map.npz", "--young", "1GPa", "--pressure", "1MPa", "--match", "9" * 5_000], "there is no"),
        (["run", "keys.toml"], "A Body must be a table of its fields, but got 5"),
        (["run", "deep.toml"], "is not TOML"),
    ],
)
def test_what_failed_once_ends_in_a_sentence(arguments, words, folder, capsys):
    Path("keys.toml").write_text("[problems.a]\nbody = 5\n[study]\npressure = [1e6]\n")
    Path("deep.toml").write_text("x = " + "[" * 100_000)
    assert fault(arguments) is None
    with contextlib.suppress(SystemExit):
        assert main(arguments) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    "raised", [MemoryError(), RecursionError("too deep"), KeyboardInterrupt(), OSError(28, "No space left")]
)
def test_what_no_command_foresees_is_a_sentence(raised, folder, monkeypatch, capsys):
    def fail(*_, **__):
        raise raised

    monkeypatch.setattr("roughcontact._faces.cli.solve.problem_of", fail)
    status = main(["solve", "map.npz", "--young", "1GPa", "--pressure", "1MPa"])
    assert status == {MemoryError: 2, RecursionError: 1, KeyboardInterrupt: 130, OSError: 2}[type(raised)]
    assert capsys.readouterr().err.startswith("roughcontact: ")


@pytest.mark.slow
@linux
def test_a_process_without_memory_ends_in_a_sentence(folder):
    """The limit leaves room for the packages, and none for a solve."""
    script = (
        "import resource, sys; from roughcontact.__main__ import main; import matplotlib.figure, roughcontact as rc\n"
        "held = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "resource.setrlimit(resource.RLIMIT_AS, (held + 2**25, held + 2**25))\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    line = ["solve", "map.npz", "--young", "1GPa", "--pressure", "1MPa", "--resample", "1500", "1500"]
    done = subprocess.run([sys.executable, "-c", script, *line], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("roughcontact: ")


@posix
@pytest.mark.parametrize("command", [["-m", "roughcontact"], [str(Path(sys.executable).with_name("roughcontact"))]])
def test_an_interrupt_of_the_imports_is_a_sentence(command, tmp_path):
    """A package of the name of one that is needed interrupts its own import."""
    (tmp_path / "attrs.py").write_text("import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(60)\n")
    done = subprocess.run(
        [sys.executable, *command, "--version"],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        # A shell that starts the tests in the background may let them ignore the signal.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert done.returncode in (130, -signal.SIGINT)
    assert done.stderr == "roughcontact: interrupted\n"
