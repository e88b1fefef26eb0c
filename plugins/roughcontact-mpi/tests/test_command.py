"""The command, and the end of all processes when one fails."""

import json

import numpy as np
import pytest
import roughcontact as rc

import mpi

pytestmark = pytest.mark.skipif(bool(mpi.missing()), reason=mpi.missing() or "MPI is there")

ONE_FAILS = """
import roughcontact as rc
from roughcontact_mpi import Processes, ending_all
processes = Processes()
with ending_all(processes):
    if processes.rank == 1:
        raise rc.InputError("This one has failed.")
    processes.total(1.0)
"""

SOLVES = """
import os, signal, time
import roughcontact as rc
from roughcontact_mpi import Processes, ending_all, make_heights, solve
processes = Processes(patience=1.0)
with ending_all(processes):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=64.0, seed=1)
    heights = make_heights(surface, rc.Grid((64, 64), 64.0), processes)
    def on_step(step):
        {step}
    {before}
    solve(heights, 64.0, rc.Elastic(1e9, 0.0), pressure=1e7, boundary="periodic", on_step=on_step)
"""


@pytest.fixture(scope="module")
def heights(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "map.npy"
    values = np.random.default_rng(0).normal(size=(48, 36)).astype(np.float32)
    np.save(path, values)
    return path, values


def run_command(count, *arguments):
    return mpi.run(count, "-m", "roughcontact", "slabs", *arguments)


def test_the_command_writes_fields_and_numbers(heights, tmp_path):
    path, values = heights
    out = tmp_path / "out"
    load = ("--force", "2mN", "--young", "2GPa", "--poisson", "0.25", "--hardness", "1GPa", "--tolerance", "1e-11")
    load = (*load, "--stiffness")
    done = run_command(3, path, "--size", "96um", "72um", "--unit", "um", *load, "-o", out)
    assert done.returncode == 0, done.stderr
    assert "3 processes" in done.stdout
    assert sorted(file.name for file in out.iterdir()) == [
        "displacement.npy",
        "gap.npy",
        "numbers.json",
        "pressure.npy",
    ]
    surface = rc.HeightMap(values.astype(np.float64) * 1e-6, (96e-6, 72e-6))
    body = rc.Body(surface, rc.ElasticPerfectlyPlastic(2e9, 0.25, 1e9))
    alone = rc.ContactProblem(body).solve(force=2e-3, tolerance=1e-11)
    for name, field in (("pressure", alone.contact_pressure), ("gap", alone.gap), ("displacement", alone.displacement)):
        assert np.abs(np.load(out / f"{name}.npy") - field).max() < 1e-9 * np.abs(field).max()
    numbers = json.loads((out / "numbers.json").read_text())
    assert numbers["force"] == pytest.approx(2e-3, rel=1e-12)
    assert numbers["contact_modulus"] == pytest.approx(alone.modulus, rel=1e-12)
    answers = {"area": alone.area(), "peak_pressure": alone.peak_pressure(), "stiffness": alone.stiffness()}
    for name, answer in answers.items():
        assert numbers[name] == pytest.approx(answer.value, rel=1e-6)
        assert numbers[f"{name}_uncertainty"] == pytest.approx(answer.uncertainty, rel=1e-6)
    assert numbers["counted_area"] == pytest.approx(alone.area("cell-count").value, rel=1e-12)
    assert numbers["patches"] == alone.patches.count
    assert numbers["processes"] == 3
    area = next(line for line in str(alone).splitlines() if line.startswith("contact area"))
    assert area in done.stdout
    stiffness = str(alone.stiffness()).partition(";")[0]
    assert f"stiffness         {stiffness}" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--size", "1mm", "--pressure", "5", "--young", "1GPa"), "has no unit"),
        (("--size", "1mm", "--pressure", "5MPa", "--young", "1GPa", "-o", "out.npz"), "must be a folder"),
        (("--size", "1mm", "--pressure", "5MPa", "--young", "1GPa", "--self-affine", "hurst=1"), "either the file"),
        (("--size", "1mm", "2mm", "3mm", "--force", "1N", "--young", "1GPa"), "one length or two"),
        (("--size", "1mm", "--pressure", "2GPa", "--young", "1GPa", "--hardness", "1GPa"), "more than the bodies can"),
    ],
)
def test_wrong_input_gets_one_sentence(heights, arguments, sentence):
    done = run_command(2, heights[0], *arguments)
    assert done.returncode != 0
    assert done.stderr.count(sentence) == 1
    assert "Traceback" not in done.stderr


def test_random_heights_go_into_a_store(tmp_path):
    pytest.importorskip("zarr")
    xarray = pytest.importorskip("xarray")
    fields = ("hurst=0.8", "rms_slope=0.1", "shortest=4um", "longest=48um", "seed=3")
    load = ("--pressure", "20MPa", "--young", "2GPa", "--boundary", "free-periodic", "--tolerance", "1e-11")
    domain = ("--shape", "48", "36", "--size", "48um", "36um")
    for _ in range(2):
        done = run_command(2, "--self-affine", *fields, *domain, *load, "-o", tmp_path / "out.zarr")
        assert done.returncode == 0, done.stderr
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=48e-6, seed=3)
    problem = rc.ContactProblem(
        rc.Body(rough, rc.Elastic(2e9, 0.3)), grid=rc.Grid((48, 36), (48e-6, 36e-6)), boundary="free-periodic"
    )
    expected = problem.solve(pressure=20e6, tolerance=1e-11).to_xarray()
    with xarray.open_zarr(tmp_path / "out.zarr", chunks=None) as found:
        for name in ("pressure", "displacement", "gap", "initial_gap"):
            assert found[name].dims == expected[name].dims
            assert found[name].attrs == expected[name].attrs
            assert np.abs(found[name] - expected[name]).max() < 1e-9 * np.abs(expected[name]).max()
        for axis in ("x", "y"):
            assert np.array_equal(found[axis], expected[axis])
        assert found.attrs["mean_pressure"] == pytest.approx(20e6, rel=1e-12)
    assert [file.name for file in tmp_path.iterdir()] == ["out.zarr"]


def test_the_failure_of_one_ends_all():
    done = mpi.run(3, "-c", ONE_FAILS, timeout=60)
    assert done.returncode != 0
    assert "This one has failed. (process 1 of 3)" in done.stderr


@pytest.mark.parametrize(("count", "rank"), [(2, 0), (2, 1), (3, 2)])
def test_a_killed_process_ends_all(count, rank):
    """The launcher ends them, in its own words: MPICH has "Killed (signal 9)", Open MPI "exited on signal 9"."""
    kill = f"processes.rank == {rank} and os.kill(os.getpid(), signal.SIGKILL)"
    done = mpi.run(count, "-c", SOLVES.format(step=kill, before=""), timeout=60)
    assert done.returncode != 0
    assert "signal 9" in done.stdout + done.stderr


@pytest.mark.parametrize("instead", ["processes.total(1.0)", "time.sleep(1000)", "raise SystemExit(0)"])
def test_who_waits_for_a_process_in_vain_says_so(instead):
    done = mpi.run(2, "-c", SOLVES.format(step="pass", before=f"if processes.rank: {instead}"), timeout=60)
    assert done.returncode != 0
    assert "Only some of 2 processes have called solve within 1 s: all must make the same calls" in done.stderr
