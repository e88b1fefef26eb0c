"""Heights and certificates made on the device: those of the host, and only numbers come back."""

import attrs
import numpy as np
import pytest
import roughcontact as rc
import torch
from roughcontact.solving import confirm, make_task
from roughcontact.typing import Load, Outcome

from roughcontact_torch import MaskedConjugateGradient, TorchFFT, solve_on_device
from test_contact import STEEL, problem
from test_masked import DEVICES, FREE_PERIODIC, PLASTIC, tensors


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("boundary", ["periodic", "free", "wrapped", FREE_PERIODIC, FREE_PERIODIC[::-1]], ids=str)
@pytest.mark.parametrize("material", [STEEL, PLASTIC], ids=["elastic", "plastic"])
@pytest.mark.parametrize("control", ["pressure", "approach"])
def test_the_certificate_is_that_of_the_host(device, boundary, material, control):
    host = problem(boundary=boundary, material=material)
    ours = TorchFFT(device).prepare(*attrs.astuple(host.convolution.setup, recurse=False)[1:])
    solved = host.solve(pressure=1e7)
    load = Load.of(**{control: getattr(solved, {"pressure": "mean_pressure"}.get(control, control))})
    task = make_task(host.plan, host.initial_gap, load, solved.pressure)
    # Not quite the solution, so that each condition is violated.
    pressure = np.minimum(task.start * (1.0 + 0.01 * np.cos(np.arange(64.0))), task.pressure_limit)
    outcome = Outcome(pressure=pressure, status=rc.Status.CONVERGED, iterations=1, convolutions=1, errors=())
    expected = confirm(host.plan, host.convolution, task, outcome)
    placed = attrs.evolve(outcome, pressure=ours.from_numpy(pressure))
    found = confirm(host.plan, ours, task.convert(ours.from_numpy), placed)
    assert found.status is expected.status is rc.Status.UNCONFIRMED
    for name in ("complementarity", "penetration", "load", "scale"):
        one, other = (getattr(certificate.residuals, name) for certificate in (found, expected))
        assert one == pytest.approx(other, rel=1e-11, abs=1e-13)
    assert expected.residuals.complementarity > 1e-4
    assert found.approach == pytest.approx(expected.approach, rel=1e-13)
    for one, other in zip(
        (found.pressure, found.displacement), (expected.pressure, expected.displacement), strict=True
    ):
        assert np.abs(ours.to_numpy(one) - other).max() <= 1e-13 * np.abs(other).max()
    assert np.array_equal(ours.to_numpy(found.pressure) == 8e7, expected.pressure == 8e7)


@pytest.mark.parametrize("parts", [{}, {"boundary": "free"}, {"material": PLASTIC}], ids=str)
@pytest.mark.parametrize("control", ["pressure", "approach"])
def test_only_numbers_reach_the_host_until_the_fields_are_asked_for(parts, control, monkeypatch):
    ours = problem(n=256, **parts, **tensors())
    expected = ours.solve(pressure=1e7)
    load = {"pressure": 1e7} if control == "pressure" else {"approach": expected.approach}
    expected = ours.solve(**load)
    brought = []
    for name in ("numpy", "tolist", "cpu", "item"):
        monkeypatch.setattr(torch.Tensor, name, _recording(getattr(torch.Tensor, name), brought))
    found = solve_on_device(ours, **load)
    # No list has more numbers than a verification reads; on a coarse grid the host finds what can touch.
    estimated = "boundary" in parts and control == "pressure"
    assert [count for count in brought if count > 8] == [128 * 128] * estimated
    assert found.pressure.shape == found.gap.shape == (256, 256)
    assert found.status is rc.Status.CONVERGED
    brought.clear()
    host = found.gather()
    assert brought == [256 * 256] * 2
    assert type(host.pressure) is np.ndarray
    assert np.array_equal(host.pressure, expected.pressure)
    assert host.residuals == found.residuals == expected.residuals
    assert host.convolutions == expected.convolutions
    assert host.origin.load == load
    assert np.abs(host.gap - found.gap.tensor.numpy()).max() <= 1e-14 * host.gap.max()
    assert found.mean_pressure == pytest.approx(host.mean_pressure, rel=1e-12)
    ours.verify(host)


def _recording(method, brought):
    def record(tensor, *args, **options):
        brought.append(tensor.numel())
        return method(tensor, *args, **options)

    return record


def test_a_wrong_pressure_is_not_certified(monkeypatch):
    ours = problem(**tensors())
    solve = MaskedConjugateGradient.solve_on_device

    def err(solver, convolution, tasks):
        return [attrs.evolve(one, pressure=one.pressure * 1.001) for one in solve(solver, convolution, tasks)]

    monkeypatch.setattr(MaskedConjugateGradient, "solve_on_device", err)
    with pytest.raises(rc.NotConverged, match=r"load 1\.0e-03"):
        solve_on_device(ours, pressure=1e7)
    assert solve_on_device(ours, pressure=1e7, throw=False).status is rc.Status.UNCONFIRMED


def test_what_is_not_solved_on_the_device_is_refused_in_words():
    with pytest.raises(rc.InputError, match="masked solver on tensors"):
        solve_on_device(problem(), pressure=1e7)
    heights = np.random.default_rng(0).normal(size=(64, 64))
    heights[3, 4] = np.nan
    holed = rc.HeightMap(heights, size=(64.0, 64.0), periodic=True)
    with pytest.raises(rc.InputError, match=r"not measured: solve this contact by problem\.solve"):
        solve_on_device(problem(holed, **tensors()), pressure=1e7)
    with pytest.raises(rc.InputError, match="exactly one of"):
        solve_on_device(problem(**tensors()), pressure=1e7, force=1.0)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("shape", [(64, 64), (45, 64), (64, 45), (33, 63)])
@pytest.mark.parametrize("parts", [{}, {"rms_cutoff": 0.7}, {"peklenik": 3.0, "lay": 0.4}], ids=str)
def test_random_heights_are_those_of_numpy(device, shape, parts):
    grid = rc.Grid(shape, tuple(map(float, shape)))
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=2.0, longest=30.0, seed=7, **parts)
    expected = surface.heights(grid)
    found = TorchFFT(device).heights(surface, grid)
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_a_problem_takes_the_heights_of_its_convolver():
    ours = problem(convolver=TorchFFT("cpu"))
    heights = TorchFFT("cpu").heights(ours.body.surface, ours.grid)
    assert np.array_equal(ours.initial_gap, heights.max() - heights)


class _Steps(rc.SelfAffineSurface):
    """A random surface that is not the transform of its waves."""

    def heights(self, grid):
        return np.round(super().heights(grid), 1)


def test_other_surfaces_make_their_own_heights():
    grid = rc.Grid((32, 32), (32.0, 32.0))
    stepped = _Steps(hurst=0.8, rms_height=1.0, shortest=4.0, longest=32.0)
    assert np.array_equal(TorchFFT("cpu").heights(stepped, grid), stepped.heights(grid))
