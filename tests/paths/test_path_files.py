"""The file of a path: what is killed goes on to the same bits, what is damaged is refused."""

import itertools
import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from unit_files import PathFile, digest_of, read_archive, write_archive

SOFT = rc.ElasticPerfectlyPlastic(young=1e9, poisson=0.0, hardness=30e6)
RUBBER = rc.Viscoelastic(moduli=[2e8, 8e8], times=[1.0], poisson=0.3)
# The problem and the places of a path of each kind.
PATHS = {
    "hardness": ({"material": SOFT}, {"pressure": [2e6, 4e6, 1e6, 0.0, 3e6, 5e6]}),
    "wear and hardness": (
        {"material": SOFT, "laws": rc.Archard(1e-13), "boundary": "periodic"},
        {"pressure": [2e6, 3e6, 1e6], "sliding": [0.1, 0.2, 0.2]},
    ),
    "wear of long cells": (
        {"material": SOFT, "laws": rc.Archard(1e-13, of="counterbody"), "shape": (12, 25), "size": (2e-3, 1e-3)},
        {"force": 2.0, "sliding": [0.0, 0.1, 0.4], "accuracy": 0.01},
    ),
    "relaxation": (
        {"material": RUBBER, "counterbody": RUBBER},
        {"approach": [2e-6, 4e-6, 4e-6, 1e-6], "time": [0.5, 1.0, 2.0, 3.0], "accuracy": 0.02},
    ),
    "adhesion": (
        {"material": SOFT, "adhesion": rc.Exponential(work=50.0, range=1e-6)},
        {"approach": [0.0, 2e-6, 0.0, -1e-6]},
    ),
}


def make_problem(material, shape=(16, 16), size=(1e-3, 1e-3), boundary="free", counterbody=None, **others):
    wave = 4.0 * max(side / n for side, n in zip(size, shape, strict=True))
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=wave, longest=max(size), seed=3)
    bodies = {"body": rc.Body(rough, material)}
    if counterbody is not None:
        bodies["counterbody"] = rc.Body(rc.FlatSurface(), counterbody)
    return rc.ContactProblem(**bodies, grid=rc.Grid(shape, size), boundary=boundary, **others)


def start(kind, **more):
    parts, places = PATHS[kind]
    return make_problem(**parts).path(**places, **more)


def digest(path):
    """Return what tells the states of two paths apart: all their bits."""
    fields = [one for state in path for one in (state.pressure, state.gap)]
    fields += [
        memory[name] for state in path for one in state.added for memory in one.memory for name in sorted(memory)
    ]
    numbers = np.array([*path.force, *path.approach, *path.time, *path.sliding, *path.increments])
    return digest_of(np.array([digest_of(one) for one in (numbers, *fields)]))


class Interrupted(Exception):
    """Raised by `interrupt_after`."""


def interrupt_after(increments):
    """Return a function of a state that raises at the last of so many calls."""
    count = itertools.count(1)

    def tell(state):
        if next(count) == increments:
            raise Interrupted

    return tell


@pytest.mark.slow
@pytest.mark.parametrize("kind", PATHS)
def test_a_path_that_is_interrupted_goes_on_to_the_same_bits(kind, tmp_path):
    file = tmp_path / "path.npz"
    whole = start(kind)
    path = None
    interrupted = 0
    while path is None:
        try:
            path = start(kind, file=file, on_increment=interrupt_after(2 + sum(whole.increments) // 3))
        except Interrupted:
            interrupted += 1
            assert interrupted < 100
    assert interrupted
    assert digest(path) == digest(whole)
    assert digest(rc.load(file)) == digest(whole)


def test_a_path_that_is_finished_is_read(tmp_path):
    first = start("wear and hardness", file=tmp_path / "path.npz")
    told = []
    again = start("wear and hardness", file=tmp_path / "path.npz", on_increment=told.append)
    assert not told
    assert digest(again) == digest(first)
    # It goes on, and may be asked, as one that was followed now.
    assert again[-1].origin.source is not None
    assert len(again.extend(pressure=1e6, sliding=[0.3])) == len(first) + 1


@pytest.mark.slow
def test_an_unfinished_path_has_its_places_so_far(tmp_path, monkeypatch):
    # Each increment is written, however little time that leaves for them.
    monkeypatch.setattr("roughcontact._solve.problem.path_file._PATIENCE", 0.0)
    file = tmp_path / "path.npz"
    whole = start("wear and hardness")
    with pytest.raises(Interrupted):
        start("wear and hardness", file=file, on_increment=interrupt_after(sum(whole.increments[:2]) + 1))
    found = rc.load(file)
    assert 1 <= len(found) < len(whole)
    np.testing.assert_array_equal(found[0].pressure, whole[0].pressure)
    assert found.increments == whole.increments[: len(found)]


@pytest.mark.parametrize("changed", ["loads", "accuracy", "problem", "another kind", "no file of contacts"])
def test_a_file_of_something_else_is_kept(changed, tmp_path):
    parts, places = PATHS["wear and hardness"]
    file = tmp_path / "path.npz"
    problem = make_problem(**parts)
    if changed == "another kind":
        problem.sweep(pressure=[1e6, 2e6]).save(file)
    elif changed == "no file of contacts":
        file.write_bytes(b"heights")
    else:
        problem.path(**places, file=file)
    kept = file.read_bytes()
    if changed == "problem":
        problem = make_problem(**parts | {"shape": (18, 18)})
    others = {"loads": {"sliding": [0.1, 0.2, 0.3]}, "accuracy": {"accuracy": 2e-3}}.get(changed, {})
    with pytest.raises(rc.InputError, match=r"path\.npz"):
        problem.path(**places | others, file=file)
    assert file.read_bytes() == kept


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"file": "path.nc"}, r"\.npz"),
        ({"file": "nowhere/path.npz"}, "no folder"),
        ({"file": "path.npz", "friction": 0.3, "tangential_force": [(1.0, 0.0)]}, "where bodies slide"),
    ],
)
def test_what_no_file_can_be_gets_a_sentence(more, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    problem = make_problem(rc.Elastic(young=1e9, poisson=0.0))
    with pytest.raises(rc.InputError, match=said):
        problem.path(force=[1.0], **more)
    assert not list(tmp_path.iterdir())


def test_the_accuracy_is_kept(tmp_path):
    parts, places = PATHS["wear and hardness"]
    path = make_problem(**parts).path(**places, accuracy=0.02)
    path.save(tmp_path / "path.npz")
    again = rc.load(tmp_path / "path.npz")
    assert again.accuracy == 0.02
    assert again.list_arguments()["accuracy"] == 0.02
    more = again.extend(pressure=2e6, sliding=[1.0])
    assert more.accuracy == 0.02
    # It is that by which the path goes on.
    assert more.increments == path.extend(pressure=2e6, sliding=[1.0], accuracy=0.02).increments
    assert more.increments[-1] < path.extend(pressure=2e6, sliding=[1.0], accuracy=1e-3).increments[-1]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["whole", "unfinished"])
def test_a_flipped_bit_is_noticed(kind, tmp_path):
    """Any bit, wherever it stands: the file is refused, whoever reads it."""
    file = tmp_path / "path.npz"
    if kind == "whole":
        start("hardness", file=file)
    else:
        with pytest.raises(Interrupted):
            start("hardness", file=file, on_increment=interrupt_after(4))
    content = file.read_bytes()
    rng = random.Random(4)
    for _ in range(150):
        changed = bytearray(content)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        file.write_bytes(changed)
        with pytest.raises(rc.InputError):
            rc.load(file, verify=False)
        with pytest.raises(rc.InputError):
            start("hardness", file=file)
    file.write_bytes(content)
    start("hardness", file=file)


@pytest.mark.slow
@pytest.mark.parametrize("verify", [True, False])
@pytest.mark.parametrize("place", [0, 1, -1])
def test_states_of_another_path_do_not_follow_each_other(verify, place, tmp_path):
    """Many increments lie between the places, and each state alone is certified: only their row is wrong."""
    parts, places = PATHS["wear and hardness"]
    content = {}
    for name, accuracy in (("one", 1e-3), ("other", 2e-3)):
        file = tmp_path / f"{name}.npz"
        make_problem(**parts).path(**places, accuracy=accuracy).save(file)
        content[name] = read_archive(file)
    arrays, header = content["one"]
    arrays |= content["other"][0]
    header["states"][place] = content["other"][1]["states"][place]
    named = {name for state in header["states"] for name in state["arrays"].values()}
    write_archive(tmp_path / "mixed.npz", {name: arrays[name] for name in named}, header)
    with pytest.raises(rc.InputError, match="follow each other"):
        rc.load(tmp_path / "mixed.npz", verify=verify)


def test_the_command_goes_on(tmp_path, capsys, monkeypatch):
    """From the file that a killed command has left; one that has ended is replaced."""
    grid = rc.Grid((16, 16), 1e-4)
    np.savez(tmp_path / "ball.npz", heights=rc.ParaboloidSurface(1e-3).heights(grid), size=grid.size)
    output = tmp_path / "path.npz"
    command = ["solve", str(tmp_path / "ball.npz"), "--force", "1N", "--young", "210GPa", "-o", str(output)]
    command += ["--law", "archard", "coefficient=1e-16m2/N", "--sliding", "0m", "1m", "--accuracy", "0.01", "-q"]
    assert main(command) == 0
    whole = rc.load(output)
    assert whole.accuracy == 0.01
    assert main(command) == 0
    assert digest(rc.load(output)) == digest(whole)
    output.unlink()
    ball = rc.Body(rc.read_surface(tmp_path / "ball.npz"), rc.Elastic(210e9, 0.3))
    same = rc.ContactProblem(ball, laws=rc.Archard("1e-16m2/N"))
    with pytest.raises(Interrupted):
        same.path(force=1.0, sliding=[0.0, 1.0], accuracy=0.01, file=output, on_increment=interrupt_after(5))
    assert main([*command[:-2], "0.02", "-q"]) == 2
    assert "another problem or along other places" in " ".join(capsys.readouterr().err.split())
    reads = []
    read = sys.modules[PathFile.__module__].read_states
    with monkeypatch.context() as patch:
        patch.setattr(
            f"{PathFile.__module__}.read_states", lambda *given, **more: reads.append(0) or read(*given, **more)
        )
        assert main(command) == 0
    assert len(reads) == 1
    assert digest(rc.load(output)) == digest(whole)
    # What is not the begin of a path stays until the whole one is there.
    output.write_bytes(b"heights")
    with monkeypatch.context() as patch:
        patch.setattr(PathFile, "finish", None)
        assert main(command) != 0
    assert output.read_bytes() == b"heights"
    assert main(command) == 0
    assert digest(rc.load(output)) == digest(whole)
    assert main(["solve", str(tmp_path / "ball.npz"), "--force", "1N", "--young", "210GPa", "--accuracy", "0.1"]) == 2
    assert "--accuracy is for increments" in " ".join(capsys.readouterr().err.split())


SCRIPT = """
import sys
sys.path[:0] = {folders!r}
import test_path_files
path = test_path_files.start_long({file!r}, on_increment=lambda state: print("increment", flush=True))
print(test_path_files.digest(path))
"""


def start_long(file=None, on_increment=None):
    """Return a path of some seconds, by wear, flattening and relaxation together."""
    hard = rc.ElasticPerfectlyPlastic(young=1e9, poisson=0.3, hardness=30e6)
    problem = make_problem(RUBBER, (36, 30), counterbody=hard, laws=rc.Archard(2e-14))
    loads = [1.0, 2.0, 0.5, 0.5, 3.0, 3.0]
    times = [0.0, 1.0, 1.5, 5.0, 6.0, 60.0]
    sliding = [value / 3.0 for value in times]
    return problem.path(force=loads, time=times, sliding=sliding, file=file, on_increment=on_increment)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="processes are killed by a signal of POSIX")
def test_thirty_kills_lose_nothing(tmp_path):
    """At random moments, wherever the path is; the last run ends with the digest of one that was left alone."""
    whole = digest(start_long())
    file = tmp_path / "path.npz"
    folders = [os.path.dirname(__file__), os.path.dirname(os.path.dirname(__file__))]
    command = [sys.executable, "-c", SCRIPT.format(folders=folders, file=str(file))]
    rng = random.Random(7)
    kills = 0
    contents = set()
    while kills < 30:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        lines = [process.stdout.readline() for _ in range(rng.randint(0, 60))]
        time.sleep(rng.uniform(0.0, 0.05))
        process.send_signal(signal.SIGKILL)
        out, _ = process.communicate(timeout=120)
        if process.returncode == 0:
            # It was finished: begin anew.
            assert "".join([*lines, out]).split()[-1] == whole
            file.unlink()
            continue
        kills += 1
        if file.exists():
            contents.add(digest_of(np.frombuffer(file.read_bytes(), np.uint8)))
    # They found it at several places.
    assert len(contents) > 5
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=300)
    assert done.stdout.split()[-1] == whole
