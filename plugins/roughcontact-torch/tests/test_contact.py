"""The default solver on tensors: certified, and the same contact as on numpy's arrays."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import roughcontact as rc
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from roughcontact.typing import Task
from torch.utils._python_dispatch import TorchDispatchMode

from roughcontact_torch import TorchFFT

DEVICES = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]
ROUGH = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4.0, longest=32.0, seed=5)
STEEL = rc.Elastic(1e9, 0.3)


def problem(surface=ROUGH, n=64, material=STEEL, boundary="periodic", **parts):
    grid = rc.Grid((n, n), (float(n), float(n)))
    return rc.ContactProblem(rc.Body(surface, material), grid=grid, boundary=boundary, **parts)


def assert_same_contact(parts, load, device="cpu"):
    """The certificate is once more that of numpy's transforms: `verify` recomputes it."""
    reference, ours = problem(**parts), problem(**parts, convolver=TorchFFT(device))
    expected, found = (one.solve(**load, tolerance=1e-8) for one in (reference, ours))
    assert found.status is rc.Status.CONVERGED
    reference.verify(found)
    assert type(found.pressure) is type(found.gap) is np.ndarray
    assert found.pressure.dtype == np.float64
    assert np.abs(found.pressure - expected.pressure).max() < 1e-5 * expected.pressure.max()
    assert found.approach == pytest.approx(expected.approach, rel=1e-6)
    return found


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("boundary", ["periodic", "free", "wrapped"])
@pytest.mark.parametrize("hardness", [None, 8e7])
def test_load_and_approach_control(device, boundary, hardness):
    material = STEEL if hardness is None else rc.ElasticPerfectlyPlastic(1e9, 0.3, hardness)
    parts = {"boundary": boundary, "material": material}
    found = assert_same_contact(parts, {"pressure": 1e7}, device)
    assert found.saturated.any() == (hardness is not None)
    assert_same_contact(parts, {"approach": 0.7 * found.approach}, device)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize(("pressure", "fraction"), [(1.4e8, 0.97), (4e8, 1.0)])
def test_near_full_and_full_contact(device, pressure, fraction):
    found = assert_same_contact({"n": 128}, {"pressure": pressure}, device)
    assert found.contact.mean() == pytest.approx(fraction, abs=0.029)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("counterbody", [STEEL, rc.Rigid()], ids=["like", "unlike"])
def test_a_path_with_friction(device, boundary, counterbody):
    parts = {"boundary": boundary, "counterbody": rc.Body(rc.FlatSurface(), counterbody)}
    force = 5e6 * 64.0**2
    loads = {"force": force, "friction": 0.3, "tangential_force": [(0.1 * force, 0.0), (-0.1 * force, 0.0)]}
    expected, found = (
        problem(**parts, **convolver).path(**loads, substeps=1) for convolver in ({}, {"convolver": TorchFFT(device)})
    )
    found.verify()
    for one, other in zip(expected, found, strict=True):
        assert type(other.shear) is np.ndarray
        moved = one.tangential_displacement
        assert other.tangential_displacement == pytest.approx(moved, rel=1e-4, abs=1e-6 * abs(moved[0]))
    with pytest.raises(rc.InputError, match="A wrapped boundary has no response to shear"):
        problem(boundary="wrapped", convolver=TorchFFT(device)).slide(force=force, friction=0.3)


@pytest.mark.parametrize("device", DEVICES)
def test_a_sphere_in_a_window_of_a_free_domain(device):
    sphere = rc.ParaboloidSurface(radius=2000.0)
    found = assert_same_contact({"surface": sphere, "n": 160, "boundary": "free"}, {"force": 2e8}, device)
    assert found.area().value == pytest.approx(np.pi * (0.75 * 2e8 * 2000.0 / found.modulus) ** (2 / 3), rel=5e-3)


SMALL_PROBLEMS = (
    st.integers(0, 10**6),
    st.tuples(st.integers(3, 70), st.integers(3, 70)),
    st.sampled_from(list(rc.Boundary)),
    st.floats(-3.0, 0.7),
    st.booleans(),
)


def assert_same_small_contact(seed, shape, boundary, load, limited, **parts):
    heights = np.random.default_rng(seed).normal(size=shape)
    material = rc.ElasticPerfectlyPlastic(1.0, 0.0, 1.5 * 10.0**load) if limited else rc.Elastic(1.0, 0.0)
    body = rc.Body(rc.HeightMap(heights, size=tuple(map(float, shape)), periodic=True), material)
    problems = (rc.ContactProblem(body, boundary=boundary, **ours) for ours in ({}, parts))
    expected, found = (one.solve(pressure=10.0**load, tolerance=1e-8, throw=False) for one in problems)
    assert found.status.success == expected.status.success
    if found.status.success:
        assert np.abs(found.pressure - expected.pressure).max() < 1e-5 * expected.pressure.max()


@given(*SMALL_PROBLEMS)
@settings(max_examples=60, deadline=None)
def test_any_small_problem(seed, shape, boundary, load, limited):
    assert_same_small_contact(seed, shape, boundary, load, limited, convolver="torch")


@pytest.mark.parametrize("solver", [rc.PolonskyKeer(), rc.SpectralGradient()])
def test_other_solvers_keep_numpys_arrays_and_take_the_products(solver):
    parts = {"solver": solver, "n": 32}
    assert_same_contact(parts, {"pressure": 1e7})


def test_a_start_is_converted_too():
    first = problem(convolver="torch").solve(pressure=1e7)
    second = problem(convolver="torch").solve(pressure=1.1e7, start=first.pressure)
    assert second.status is rc.Status.CONVERGED
    assert second.convolutions < first.convolutions


@pytest.mark.parametrize("control", [{"mean_pressure": 0.02}, {"approach": 0.3}])
def test_the_slower_rescue_works_on_tensors(control):
    plan = problem(n=32, convolver="torch")
    gap = plan.initial_gap / plan.initial_gap.max()
    task = Task(initial_gap=gap, pressure_limit=0.2, **control)
    solver, convolution = rc.SpectralGradient(tolerance=1e-8), plan.convolution
    expected = solver.solve(convolution, task)
    found = solver.solve(convolution, task.convert(convolution.from_numpy))
    np.testing.assert_allclose(convolution.to_numpy(found.pressure), expected.pressure, atol=1e-6)


def test_a_solution_is_saved_with_its_convolver(tmp_path):
    solution = problem(n=32, convolver="torch").solve(pressure=1e7)
    solution.save(tmp_path / "tensors.npz")
    again = rc.ContactSolution.load(tmp_path / "tensors.npz")
    assert np.array_equal(again.pressure, solution.pressure)
    assert again.origin.problem["convolver"] in ("torch", TorchFFT())
    # Without torch the fields are there, and the problem says what is missing.
    script = (
        "import sys; sys.modules['torch'] = None\n"
        "import roughcontact as rc\n"
        f"solution = rc.ContactSolution.load({str(tmp_path / 'tensors.npz')!r}, verify=False)\n"
        "print(solution.force)\n"
        "try: rc.convolvers.create('torch')\n"
        "except rc.InputError as error: print(error)"
    )
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    force, missing = output.splitlines()
    assert float(force) == solution.force
    assert "torch" in missing
    assert "cannot be loaded" in missing


def test_the_examples_of_the_readme_run(capsys):
    text = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    names = {}
    for example in re.findall(r"```python\n(.*?)```", text, re.S):
        exec(example, names)
    assert "converged" in capsys.readouterr().out
    assert names["low"].status is names["high"].status is rc.Status.CONVERGED


def test_the_explanation_names_the_device():
    text = problem(convolver=TorchFFT("cpu")).explain()
    assert f"TorchFFT(device='cpu'): tensors of torch {torch.__version__} on cpu on 64 x 64 cells" in text


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_a_missing_device_is_refused_in_words():
    with pytest.raises(rc.InputError, match="no CUDA device"):
        problem(convolver=TorchFFT("cuda"))


def test_an_unknown_device_is_refused_in_words():
    with pytest.raises(rc.InputError, match="'auto' or 'cpu' or 'cuda'"):
        TorchFFT("gpu")


class _Waits(TorchDispatchMode):
    """Counts what makes the host wait for a device: numbers that are read, and lists whose length must be known."""

    names = ("_local_scalar_dense", "nonzero", "equal", "repeat_interleave.Tensor", "masked_select")

    def __init__(self):
        super().__init__()
        self.count = 0

    def __torch_dispatch__(self, function, types, args=(), kwargs=None):
        masks = function is torch.ops.aten.index.Tensor and any(
            index is not None and index.dtype == torch.bool for index in args[1]
        )
        self.count += masks or any(f"aten.{name}" in str(function) for name in self.names)
        return function(*args, **(kwargs or {}))


def test_the_host_waits_for_few_numbers():
    ours = problem(n=128, convolver="torch")
    ours.solve(pressure=1e7)
    with _Waits() as waits:
        solution = ours.solve(pressure=1e7)
    assert waits.count <= 100 * sum(level.iterations for level in solution.levels)
