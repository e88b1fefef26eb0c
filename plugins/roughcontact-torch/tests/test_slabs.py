"""One contact on slabs of several processes is that of one: they talk by gloo, started by torchrun."""

import functools
import json
import re
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc
import torch
from roughcontact.errors import NotEnoughMemory

import torchrun
from roughcontact_torch import (
    MaskedConjugateGradient,
    Processes,
    SlabTensor,
    make_heights,
    slab_contact,
    solve_on_slabs,
)
from slab_cases import PLASTIC, STEEL, make_case, solve_alone

SCRIPT = Path(__file__).with_name("slab_cases.py")
CASES = (
    *(f"square_periodic_{load}_0" for load in ("light", "heavy", "nearly-full", "approach", "hard", "hard-approach")),
    *(f"odd_{boundary}_light_1" for boundary in ("periodic", "free", "free-periodic", "periodic-free")),
    "odd_free_hard_1",
    "odd_free-periodic_approach_1",
    "wide_periodic_heavy_2",
    "wide_free_hard-approach_2",
    "nested_periodic_light_3",
    "nested_free_heavy_3",
    "nested_periodic_approach_3",
    "nested_periodic_hard_3",
)
OF_TWO = (*CASES, "low_periodic_light_0")
# More processes than processors wait for each other, so that three have some.
OF_THREE = (
    "square_periodic_heavy_0",
    "square_periodic_hard_0",
    "odd_periodic_light_1",
    "odd_free_hard_1",
    "odd_free-periodic_approach_1",
    "nested_periodic_approach_3",
    "nested_periodic_hard_3",
)
LARGE = ("large_periodic_light_0", "large_periodic_hard_0")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder in which two and three processes have solved all cases, once."""
    place = tmp_path_factory.mktemp("slabs")
    for count, cases in ((2, OF_TWO), (3, OF_THREE)):
        done = torchrun.run(count, SCRIPT, place, *cases)
        assert done.returncode == 0, done.stderr
        assert "done" in done.stdout
    return place


@functools.cache
def of_one(name):
    return solve_alone(name)


def assert_same_contact(folder, name, count):
    alone = of_one(name)
    numbers = json.loads((folder / f"{name}-{count}.json").read_text())
    pressure = np.load(folder / f"{name}-{count}.npy")
    assert numbers["status"] == alone.status.name == "CONVERGED"
    assert (numbers["iterations"], numbers["convolutions"]) == (alone.iterations, alone.convolutions)
    assert numbers["steps"][-1] == alone.iterations
    assert np.array_equal(pressure > 0.0, alone.contact)
    assert numbers["contact"] == np.count_nonzero(alone.contact)
    assert np.abs(pressure - alone.pressure).max() < 2e-6 * alone.pressure.max()
    assert numbers["approach"] == pytest.approx(alone.approach, rel=1e-8)
    assert numbers["force"] == pytest.approx(alone.force, rel=1e-12 if "approach" not in name else 1e-7)
    assert numbers["mean"] == pytest.approx(float(pressure.mean()), rel=1e-12)
    assert numbers["gap"] == pytest.approx(float(alone.gap.min()), abs=1e-5 * alone.residuals.scale)
    # The certificate by sums over the processes is the one of the gathered solution.
    assert numbers["residuals"] == pytest.approx(numbers["gathered"], abs=1e-12)
    assert max(numbers["residuals"]) <= 1e-5
    assert numbers["rows"] < alone.grid.shape[0]


@pytest.mark.parametrize(("count", "name"), [(2, name) for name in OF_TWO] + [(3, name) for name in OF_THREE])
def test_contact_and_work_are_those_of_one_process(folder, name, count):
    assert_same_contact(folder, name, count)


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_large_grids_are_in_slabs_on_two_levels(tmp_path, count):
    done = torchrun.run(count, SCRIPT, tmp_path, *LARGE)
    assert done.returncode == 0, done.stderr
    for name in LARGE:
        assert_same_contact(tmp_path, name, count)


FAILING = """
import numpy as np
import roughcontact as rc
from roughcontact_torch import Processes, SlabTensor, ending_all, solve_on_slabs

processes = Processes()
with ending_all(processes):
    heights = np.random.default_rng(0).normal(size=(64, 64))
    part = heights[processes.own_rows(64)]
    if processes.rank == 1:
        {failure}
    slab = SlabTensor.field(part, processes, 64)
    for _ in range(100):
        solve_on_slabs(slab, 64.0, rc.Elastic(1e9, 0.0), pressure=1e7, boundary="periodic")
"""


@pytest.mark.parametrize(
    ("failure", "sentence"),
    [
        (
            "part = part[1:]",
            r"The part of process 1 must be .* 32 rows, 32 to 63 of 64, but got .* \(process 1 of 2\)",
        ),
        ("raise ZeroDivisionError('an error of the script')", r"an error of the script \(process 1 of 2\)"),
    ],
)
def test_a_process_that_fails_ends_all_with_its_sentence(tmp_path, failure, sentence):
    script = tmp_path / "failing.py"
    script.write_text(FAILING.format(failure=failure))
    done = torchrun.run(2, script, timeout=60)
    assert done.returncode == 1
    assert re.search(f"roughcontact_torch: {sentence}", done.stderr), done.stderr


def test_an_error_of_all_processes_is_said_once(tmp_path):
    script = tmp_path / "refused.py"
    solve = "solve_on_slabs(slab, 64.0, rc.ElasticPerfectlyPlastic(1e9, 0.0, 1e6), pressure=1e7)"
    script.write_text(FAILING.format(failure="pass").replace("for _ in range(100):", f"{solve}\n    if False:"))
    done = torchrun.run(2, script, timeout=60)
    assert done.returncode == 1
    assert done.stderr.count("roughcontact_torch: The mean pressure of 10 MPa is more than the bodies can carry") == 1


def test_the_example_of_the_readme_runs_on_two_processes(tmp_path):
    text = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    (example,) = (one for one in re.findall(r"```python\n(.*?)```", text, re.S) if "solve_on_slabs" in one)
    script = tmp_path / "script.py"
    script.write_text(example)
    done = torchrun.run(2, script)
    assert done.returncode == 0, done.stderr
    assert "converged" in done.stdout
    # Two processes may write on one line.
    assert sorted(re.findall(r"rows (\d+) to (\d+) of 256", done.stdout)) == [("0", "127"), ("128", "255")]


def slab(heights):
    return SlabTensor.field(heights, Processes("cpu"), len(heights))


ROUGH = np.random.default_rng(0).normal(size=(32, 32))


@pytest.mark.parametrize(
    ("heights", "material", "given", "words"),
    [
        (
            ROUGH,
            STEEL,
            {"pressure": 1e7},
            "The heights must be a SlabTensor, an array in slabs as of read_heights, or a SelfAffineSurface",
        ),
        (slab(ROUGH), STEEL, {"pressure": 1e7, "boundary": "wrapped"}, "The boundary on slabs must be 'free'"),
        (slab(ROUGH), STEEL, {}, "exactly one"),
        (slab(np.zeros((32, 32))), STEEL, {"pressure": 1e7}, "The heights are all the same"),
        (slab(np.where(ROUGH > 2.0, np.nan, ROUGH)), STEEL, {"pressure": 1e7}, "The heights are not all finite"),
        (slab(ROUGH), PLASTIC, {"pressure": 1e8}, "more than the bodies can carry"),
        (slab(ROUGH), STEEL, {"approach": 100.0, "boundary": "periodic"}, "below that of full contact"),
        (rc.WavySurface(1.0, 8.0), STEEL, {"pressure": 1e7}, "The surface on slabs must be a SelfAffineSurface"),
    ],
)
def test_what_slabs_do_not_have_is_refused_in_words(heights, material, given, words):
    with pytest.raises(rc.InputError, match=words):
        solve_on_slabs(heights, 32.0, material, **given)


def test_a_hardness_that_varies_and_too_many_processes_are_refused_in_words(monkeypatch):
    limit = np.where(ROUGH[:8, :8] > 0.0, 8e7, 6e7)
    with pytest.raises(rc.InputError, match="the hardness must be one number"):
        solve_on_slabs(slab(ROUGH), 32.0, rc.ElasticPerfectlyPlastic(1e9, 0.3, limit), pressure=1e7)
    many = Processes("cpu")
    monkeypatch.setattr(many, "count", 18)
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=32.0, seed=1)
    with pytest.raises(rc.InputError, match="The processes for 32 x 32 cells must be at most 17, but got 18"):
        make_heights(surface, rc.Grid((32, 32), 32.0), many)


def test_the_default_solver_continues_on_the_first_process(tmp_path):
    heights, grid, material, given = make_case("square_periodic_hard_0")
    alone = rc.ContactProblem(rc.Body(rc.HeightMap(heights, grid.size), material), boundary=given.pop("boundary"))
    expected = alone.solve(**given, tolerance=1e-10).contact_pressure
    script = tmp_path / "continued.py"
    script.write_text(CONTINUED.format(tests=str(SCRIPT.parent), place=str(tmp_path)))
    done = torchrun.run(2, script)
    assert done.returncode == 0, done.stderr
    numbers = [json.loads((tmp_path / f"{rank}.json").read_text()) for rank in range(2)]
    assert numbers[0] == numbers[1]
    assert numbers[0]["status"] == "RESCUED"
    assert numbers[0]["errors"] > 1
    assert max(numbers[0]["residuals"]) <= 1e-10
    pressure = np.concatenate([np.load(tmp_path / f"{rank}.npy") for rank in range(2)])
    assert np.abs(pressure - expected).max() < 1e-8 * expected.max()


CONTINUED = """
import functools, json, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
import numpy as np
from roughcontact_torch import MaskedConjugateGradient, Processes, SlabTensor, ending_all, slab_contact
from slab_cases import make_case

slab_contact.MaskedConjugateGradient = functools.partial(MaskedConjugateGradient, max_iterations=1)
processes = Processes("cpu")
with ending_all(processes):
    heights, grid, material, given = make_case("square_periodic_hard_0")
    part = SlabTensor.field(heights[processes.own_rows(64)], processes, 64)
    found = slab_contact.Contacts.solve(part, grid, material, tolerance=1e-10, **given)
    residuals = found.residuals
    numbers = {{"status": found.status.name, "iterations": found.iterations, "errors": len(found.errors)}}
    numbers["residuals"] = [residuals.complementarity, residuals.penetration, residuals.load]
    Path({place!r}, f"{{processes.rank}}.json").write_text(json.dumps(numbers))
    np.save(Path({place!r}, f"{{processes.rank}}.npy"), found.pressure.tensor.numpy())
"""


def test_what_is_not_certified_is_raised_or_returned(monkeypatch):
    """Where the default solver does not fit into memory it does not continue."""

    def refuse(grid, boundary):
        raise NotEnoughMemory("That is too much.")

    monkeypatch.setattr(slab_contact, "require_memory_of_solve", refuse)
    hasty = functools.partial(MaskedConjugateGradient, max_iterations=1)
    monkeypatch.setattr(slab_contact, "MaskedConjugateGradient", hasty)
    heights, grid, material, given = make_case("square_periodic_hard_0")
    with pytest.raises(rc.NotConverged, match="iterations") as caught:
        solve_on_slabs(slab(heights), grid, material, tolerance=1e-10, **given)
    assert caught.value.solution.pressure.shape == (64, 64)
    found = solve_on_slabs(slab(heights), grid, material, tolerance=1e-10, throw=False, **given)
    assert found.status is rc.Status.STALLED


def test_a_slab_that_does_not_fit_on_its_device_is_refused(monkeypatch):
    monkeypatch.setattr("roughcontact_torch.processes.available_memory", lambda: 2**16)
    with pytest.raises(rc.InputError, match=r"32 x 32 cells, boundary free, needs .* KiB of memory for the slab"):
        solve_on_slabs(slab(ROUGH), 32.0, STEEL, pressure=1e7)


@pytest.mark.parametrize("call", [np.fft.rfft2, np.cumsum, np.diff, np.std, lambda values: values[3]])
def test_functions_that_would_need_other_rows_are_refused_in_words(call):
    with pytest.raises(rc.InputError, match="Fields on slabs have no numpy"):
        call(slab(ROUGH))


@pytest.mark.parametrize(
    "part", ["map.npy", ROUGH[:5], ROUGH[0], 1j * ROUGH, torch.zeros(32, 2, dtype=torch.complex64)]
)
def test_a_part_that_is_not_of_this_process_is_refused_in_words(part):
    with pytest.raises(rc.InputError, match="The part of process 0 must be an array of real numbers of 32 rows"):
        SlabTensor.field(part, Processes("cpu"), 32)


def test_a_part_may_be_of_a_file_of_integers_or_a_tensor(tmp_path):
    np.save(tmp_path / "map.npy", (1e3 * ROUGH).astype(np.int16))
    stored = np.load(tmp_path / "map.npy", mmap_mode="r")
    found = solve_on_slabs(slab(stored), 32.0, STEEL, pressure=1e9, boundary="periodic")
    again = solve_on_slabs(
        slab(torch.tensor(stored.astype(np.float32))), 32.0, STEEL, pressure=1e9, boundary="periodic"
    )
    assert torch.equal(found.pressure.tensor, again.pressure.tensor)
    assert found.gather().status.success


def test_reductions_are_those_of_numpy():
    field = slab(ROUGH)
    assert float(field.sum()) == pytest.approx(ROUGH.sum(), rel=1e-12)
    assert float(field.mean()) == pytest.approx(ROUGH.mean(), rel=1e-12)
    assert (float(field.min()), float(field.max())) == (ROUGH.min(), ROUGH.max())
    assert bool((field > 0.0).any()) is True
    assert bool((field > 0.0).all()) is False
    assert int(np.count_nonzero(field > 1.0)) == np.count_nonzero(ROUGH > 1.0)
    assert float(np.einsum("i,i->", field.ravel(), field.ravel())) == pytest.approx((ROUGH**2).sum(), rel=1e-12)
    assert field.tensor.dtype is torch.float64
    assert len(field) == 32
    assert field.size == 1024


def test_a_single_row_is_shared_as_it_is():
    """The rows are those of the coarsest grid, which a row of one cell has too."""
    assert Processes("cpu").rows(1) == (0, 1)
    assert Processes("cpu").own_rows(96) == slice(0, 96)
