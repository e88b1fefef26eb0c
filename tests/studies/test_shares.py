"""A study in shares by the shell command: any number of them, at once or killed, is one run bit for bit."""

from __future__ import annotations

import contextlib
import csv
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import roughcontact as rc
from scenes import list_unfinished, rather_slow, without_seconds
from systems import posix
from unit_files import read_archive, read_study

# Two contacts in domains twice and three times as long as wide, with cells 1:3 and odd numbers of them.
STUDY = """
[problems.flat]
boundary = "periodic"
grid = {shape = [45, 45], size = [300e-6, 100e-6]}
[problems.flat.body]
surface = {type = "self-affine", hurst = 0.8, rms_height = 1e-7, longest = 1e-4, shortest = 2e-5, seed = 5}
material = {type = "elastic-perfectly-plastic", young = 210e9, poisson = 0.3, hardness = 6e9}
[problems.ball]
grid = {shape = [63, 93], size = [200e-6, 100e-6]}
[problems.ball.body]
material = {type = "elastic", young = 210e9, poisson = 0.3}
[problems.ball.body.surface]
type = "sum"
parts = [
  {type = "sphere", radius = "5mm"},
  {type = "self-affine", hurst = 0.8, rms_height = 5e-8, longest = 1e-4, shortest = 2e-5, seed = 1},
]
[study]
force = [0.1, 0.5, 1.0]
seeds = [0, 1, 2, 3, 4]
areas = ["blend", "cell-count"]
fields = true
"""
SOLVES = 2 * 5 * 3
TABLES = Path(__file__).parents[2] / "docs" / "tables"


def shell(folder, *options):
    """Begin the command in a process of its own, in the folder of the study file."""
    command = [sys.executable, "-m", "roughcontact", "run", "study.toml", *options]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process):
    """Return what a command has printed, in one line."""
    out, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    return " ".join(out.split())


def count_new(printed):
    """How many solves a command states that it did now."""
    return int(re.search(r"solves, (\d+) of them now, in", printed)[1])


def begin(folder, text=STUDY):
    folder.mkdir(exist_ok=True)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return folder


def rows_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        return [{name: text for name, text in row.items() if name != "seconds [s]"} for row in csv.DictReader(file)]


def require_same(folder, whole):
    """Compare the records, the table and every bit of the saved files of two studies, but for times of the clock."""
    study = read_study(folder / "study.toml")
    found, wanted = (study.run(one / "study") for one in (folder, whole))
    assert found.computed == wanted.computed == 0
    assert without_seconds(found.records) == without_seconds(wanted.records)
    assert rows_of(folder / "study" / "records.csv") == rows_of(whole / "study" / "records.csv")
    names, others = ({path.name for path in (one / "study").glob("*.npz")} for one in (folder, whole))
    assert names == others
    for name in names:
        arrays, header = read_archive(folder / "study" / name)
        other_arrays, other_header = read_archive(whole / "study" / name)
        assert {**header, "seconds": 0.0} == {**other_header, "seconds": 0.0}
        assert {key: value.tobytes() for key, value in arrays.items()} == {
            key: value.tobytes() for key, value in other_arrays.items()
        }
    assert not list_unfinished(folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a study that one process has solved, and what it has printed."""
    folder = begin(tmp_path_factory.mktemp("whole"))
    printed = finish(shell(folder))
    assert count_new(printed) == SOLVES
    return folder, printed


@pytest.mark.slow
def test_four_shares_two_of_them_at_once_are_one_run(tmp_path, whole):
    folder = begin(tmp_path)
    together = [shell(folder, "--share", share) for share in ("1/4", "2/4")]
    printed = [finish(process) for process in together]
    printed += [finish(shell(folder, "--share", "3/4")), finish(shell(folder, "--share", "4/4", "--workers", "2"))]
    # Ten problems with a seed each, at three loads.
    assert [text.partition(":")[0] for text in printed] == [
        f"Share {share}/4 has {own} of 10 tasks, each a problem with a seed"
        for share, own in enumerate((3, 3, 2, 2), start=1)
    ]
    assert list(map(count_new, printed)) == [9, 9, 6, 6]
    # A table of one share alone would be taken for that of the study.
    assert not (folder / "study" / "records.csv").exists()
    end = finish(shell(folder))
    assert end == whole[1].replace(f"{SOLVES} of them now", "0 of them now")
    require_same(folder, whole[0])


@posix
@pytest.mark.slow
def test_a_killed_share_goes_on(tmp_path, whole):
    folder = begin(tmp_path)
    process = shell(folder, "--share", "2/2")
    deadline = time.monotonic() + 60
    while len(list((folder / "study").glob("*.npz"))) < 1 and time.monotonic() < deadline:
        time.sleep(0.005)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    finished = len(list((folder / "study").glob("*.npz")))
    assert 1 <= finished < SOLVES // 2
    assert count_new(finish(shell(folder, "--share", "1/2"))) == SOLVES // 2
    assert count_new(finish(shell(folder, "--share", "2/2"))) == SOLVES // 2 - finished
    assert count_new(finish(shell(folder))) == 0
    require_same(folder, whole[0])


@pytest.mark.slow
def test_the_whole_solves_what_no_share_has_solved(tmp_path, whole):
    folder = begin(tmp_path)
    finish(shell(folder, "--share", "1/3"))
    assert count_new(finish(shell(folder))) == SOLVES - 4 * 3
    require_same(folder, whole[0])


@pytest.mark.slow
def test_a_study_that_grew_solves_only_what_is_new(tmp_path):
    folder = begin(tmp_path)
    for share in ("1/2", "2/2"):
        finish(shell(folder, "--share", share))
    begin(tmp_path, STUDY.replace("seeds = [0, ", "seeds = [7, 0, "))
    # One more seed of both problems moves others to other shares; whoever solved them, they are there.
    printed = [finish(shell(folder, "--share", share)) for share in ("1/2", "2/2")]
    assert sum(map(count_new, printed)) == 2 * 3
    assert count_new(finish(shell(folder))) == 0


@pytest.mark.parametrize("share", ["0/4", "5/4", "a/b", "", "3", "-1/4", "1/0", "1/4/2", "1.5/4", "1/" + 5000 * "9"])
def test_a_bad_share_gets_a_sentence(tmp_path, run, share):
    folder = begin(tmp_path)
    status, out, errors = run("run", folder / "study.toml", f"--share={share}")
    assert (status, out) == (2, "")
    assert errors.startswith("roughcontact: One of n shares must be k/n or (k, n), such as 3/64")
    assert not (folder / "study").exists()


def test_a_share_beyond_the_tasks_has_nothing_to_do(tmp_path, run):
    folder = begin(tmp_path)
    status, out, errors = run("run", folder / "study.toml", "--share", "11/64")
    assert (status, errors) == (0, "")
    assert out == "Share 11/64 has 0 of 10 tasks, each a problem with a seed: nothing to do.\n"
    assert not (folder / "study").exists()


def test_the_plan_of_a_share_is_stated(tmp_path, run):
    folder = begin(tmp_path)
    status, out, _ = run("run", folder / "study.toml", "--share", "3/4", "--dry-run")
    assert status == 0
    assert out.splitlines()[-1] == "Share 3/4 has 2 of 10 tasks, each a problem with a seed: 6 solves."
    assert not (folder / "study").exists()


def make_ball(radius, seed=0):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-8, longest=3e-5, shortest=1.2e-5, seed=seed)
    body = rc.Body(rc.SphereSurface(radius=radius) + rough, rc.Elastic(young=210e9, poisson=0.3))
    return rc.ContactProblem(body, grid=rc.Grid((15, 15), (9e-5, 3e-5)))


def small_study(**changes):
    problems = {name: make_ball(radius) for name, radius in (("a", 1e-3), ("b", 2e-3), ("c", 3e-3))}
    return rc.Study(**{"problems": problems, "force": [0.01, 0.02], "seeds": range(7), "fields": True, **changes})


def places(records):
    return {(record.problem, record.seed) for record in records}


@pytest.mark.parametrize("count", rather_slow([2, 5, 30], [2, 30]))
def test_shares_are_disjoint_even_and_the_whole(tmp_path, count):
    results = [small_study().run(tmp_path, share=(number, count)) for number in range(1, count + 1)]
    sizes = [len(result) // 2 for result in results]
    assert max(sizes) - min(sizes) <= 1
    together = [record for result in results for record in result]
    assert len(together) == len({record.key for record in together}) == 3 * 7 * 2
    assert places(together) == places(small_study().run(tmp_path))


@pytest.mark.slow
def test_a_share_does_not_hang_on_the_order_of_the_study(tmp_path):
    turned = dict(reversed(small_study().problems.items()))
    for number in (1, 2, 3):
        one = small_study().run(tmp_path, share=(number, 3))
        other = small_study(problems=turned, seeds=range(6, -1, -1)).run(tmp_path, share=f"{number}/3")
        assert other.computed == 0
        assert places(one) == places(other)
        # In the order of the study, which has seven seeds, it would have one problem alone, or the same seeds of all.
        assert {problem for problem, _ in places(one)} == {"a", "b", "c"}
        assert len({seed for _, seed in places(one)}) > 3


def test_a_share_builds_only_its_own_problems(tmp_path):
    built = []

    def build(radius, seed):
        built.append((radius, seed))
        return make_ball(radius, seed)

    study = rc.Study(build, radius=[1e-3, 2e-3], seed=range(5), force=[0.01])
    built.clear()
    result = study.run(tmp_path, share=(2, 4))
    assert built == [(record.parameters["radius"], record.parameters["seed"]) for record in result]
    assert len(result) == 3


@pytest.mark.slow
def test_shares_at_once_keep_what_each_has_measured(tmp_path, monkeypatch):
    """Neither solves nor areas are computed again for the whole, although each share began before the other ended."""
    other = []

    def run_other(_):
        if not other:
            other.append(small_study().run(tmp_path, share=(2, 2)))

    first = small_study().run(tmp_path, share=(1, 2), on_records=run_other)
    assert first.computed + other[0].computed == 3 * 7 * 2
    estimators = ["blend", "cell-count"]
    with forbidden(monkeypatch):
        assert not small_study().run(tmp_path).failed
    assert not small_study(areas=estimators).run(tmp_path).failed
    with forbidden(monkeypatch):
        assert all(set(record.areas) == set(estimators) for record in small_study(areas=estimators).run(tmp_path))


@contextlib.contextmanager
def forbidden(monkeypatch):
    """No solve, and no area of a solution."""
    with monkeypatch.context() as context:
        for cls, name in ((rc.ContactProblem, "solve"), (rc.ContactSolution, "area")):
            context.setattr(cls, name, lambda *_, **__: pytest.fail("computed again"))
        yield


@pytest.mark.parametrize("share", [(0, 4), (5, 4), (1, 2, 3), (True, 2), (1.0, 2), 3, b"1/2", {1: 2}])
def test_a_bad_share_of_a_call_gets_a_sentence(tmp_path, share):
    with pytest.raises(rc.InputError, match="One of n shares must be k/n or"):
        small_study().run(tmp_path / "study", share=share)
    assert not (tmp_path / "study").exists()


@pytest.mark.slow
def test_dask_gives_the_same(tmp_path, whole, dask_cluster):
    """One share on an executor, and the rest in one run on it."""
    dask_cluster.start(2)
    executor = dask_cluster.client.get_executor()
    study = read_study(begin(tmp_path) / "study.toml")
    first = study.run(tmp_path / "study", executor=executor, share=(1, 3))
    assert first.computed == len(first) == 4 * 3
    assert study.run(tmp_path / "study", executor=executor).computed == SOLVES - 4 * 3
    assert count_new(finish(shell(tmp_path))) == 0
    require_same(tmp_path, whole[0])


@pytest.mark.slow
def test_executorlib_gives_the_same(tmp_path, whole):
    """By the lines of the page; `pip install executorlib` for them."""
    pytest.importorskip("executorlib")
    (lines,) = (block for block in blocks_of_page("text") if block.startswith("from executorlib"))
    lines = lines.replace("/shared/night", "study").replace("max_workers=64", "max_workers=2")
    reading = "from roughcontact._work.studies.toml import read_study\nstudy = read_study('study.toml')\n"
    script = begin(tmp_path) / "night.py"
    script.write_text(reading + lines, encoding="utf-8")
    subprocess.run([sys.executable, script], cwd=tmp_path, check=True, timeout=300)
    assert count_new(finish(shell(tmp_path))) == 0
    require_same(tmp_path, whole[0])


def blocks_of_page(kind):
    page = Path(__file__).parents[2] / "docs" / "use" / "cluster.md"
    return re.findall(rf"^```{kind}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.S | re.M)


# What sbatch does with a job file: an array all at once, and after --parsable nothing is printed but a number.
SBATCH = """#!/bin/bash
file="${@: -1}"
last=$(sed -n "s/^#SBATCH --array=1-//p" "$file")
for task in $(seq 1 ${last:-1}); do
  SLURM_ARRAY_TASK_ID=${last:+$task} bash -e "$file" > "$file-$task.out" &
done
wait
echo 4711
"""


def run_as_slurm(folder, command):
    """Run a shell command in a folder whose `sbatch` and `roughcontact` are found first."""
    programs = {"sbatch": SBATCH, "roughcontact": f'#!/bin/bash\nexec {sys.executable} -m roughcontact "$@"\n'}
    for name, text in programs.items():
        (folder / name).write_text(text, encoding="utf-8")
        (folder / name).chmod(0o755)
    environment = {**os.environ, "PATH": os.pathsep.join((str(folder), os.environ["PATH"]))}
    subprocess.run(["bash", "-e", "-c", command], cwd=folder, env=environment, check=True, timeout=300)


@pytest.mark.slow
def test_the_job_files_of_the_page_are_one_run(tmp_path, whole):
    folder = begin(tmp_path)
    jobs = [block for block in blocks_of_page("text") if block.startswith("#!/bin/bash")]
    # The shares that a task asks for are as many as the array has tasks.
    assert re.search(r"--array=1-64\n", jobs[0])
    assert re.search(r"--share \$SLURM_ARRAY_TASK_ID/64\n", jobs[0])
    for name, text in zip(("shares.sh", "table.sh"), jobs, strict=False):
        (folder / name).write_text(text.replace("64", "4"), encoding="utf-8")
    (submit,) = (block for block in blocks_of_page("text") if block.startswith("sbatch "))
    run_as_slurm(folder, submit)
    shares = [(folder / f"shares.sh-{task}.out").read_text(encoding="utf-8") for task in (1, 2, 3, 4)]
    assert sum(map(count_new, (" ".join(text.split()) for text in shares))) == SOLVES
    end = " ".join((folder / "table.sh-1.out").read_text(encoding="utf-8").split())
    assert end == whole[1].replace(f"{SOLVES} of them now", "0 of them now")
    require_same(folder, whole[0])


@pytest.mark.slow
def test_the_job_of_a_large_solve_runs(tmp_path):
    surface = "self-affine --hurst 0.8 --rms-height 20nm --shortest 8um --longest 45um --shape 63 45 --size 189um 45um"
    job = [block for block in blocks_of_page("text") if block.startswith("#!/bin/bash")][2]
    run_as_slurm(tmp_path, f"roughcontact surface {surface} -o large.npz\n{job}")
    assert rc.ContactSolution.load(tmp_path / "solved.npz").status is rc.Status.CONVERGED


def test_the_page_states_what_its_table_does():
    rows = {row["N"]: row for row in rows_of(TABLES / "cluster.csv")}
    ratio = {side: float(row["core, measured, s"] or 0) / float(row["core, model, s"]) for side, row in rows.items()}
    text = " ".join((TABLES.parent / "use" / "cluster.md").read_text(encoding="utf-8").split())
    measured = "The measured time is half of the model's at 512 and 1024, and 1.4 times it at 8192"
    assert f"{measured}, where a solve takes 39 products." in text
    assert [ratio["512"], ratio["1024"]] == pytest.approx([0.5, 0.5], abs=0.05)
    assert ratio["8192"] == pytest.approx(1.4, abs=0.05)
    scale = {row["N"]: row for row in rows_of(TABLES / "scale.csv") if row["boundary"] == "periodic"}
    assert scale["8192"]["products"] == "39"
    assert "took 0.72 of the time of one at 4096 x 4096" in text
    one, two = (float(scale["4096"][name]) for name in ("wall, s", "wall on two threads, s"))
    assert two / one == pytest.approx(0.72, abs=0.005)
    cost = [float(row["CPU"]) / 20 for row in rows_of(TABLES / "sweeps.csv") if row["20 loads"].startswith("rough")]
    assert "takes [0.5 to 0.9](" in text
    assert [min(cost), max(cost)] == pytest.approx([0.5, 0.9], abs=0.05)
