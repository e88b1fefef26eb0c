"""Each compiled pass gives what numpy's gives, on random fields."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from roughcontact.solving import NumpyPasses
from roughcontact.typing import LastStep

from roughcontact_numba import CompiledPasses

SIZES = st.integers(2, 300)
SEEDS = st.integers(0, 2**31)
LIMITS = st.sampled_from(["none", "one", "each"])


class Fields:
    """A pressure within its bounds with released cells, a gap, a direction and a load, all random."""

    def __init__(self, cells, seed, kind, by_load):
        rng = np.random.default_rng(seed)
        pressure = np.maximum(rng.normal(rng.uniform(-1.5, 1.5), 1.0, cells), 0.0)
        limit = {"none": None, "one": np.array([1.0]), "each": rng.uniform(0.5, 1.5, cells)}[kind]
        self.pressure = pressure if limit is None else np.minimum(pressure, limit)
        self.limit = limit
        self.gap = rng.normal(size=cells).astype(np.float32)
        self.step = rng.normal(size=cells).astype(np.float32)
        self.change = rng.normal(size=cells).astype(np.float32)
        self.load = float(self.pressure.sum()) if by_load else None
        self.numpy = NumpyPasses(limit, self.load)
        self.compiled = CompiledPasses(limit, self.load)
        self.residual, self.active, self.count = self.numpy.release(self.pressure, self.gap)


fields = st.builds(Fields, SIZES, SEEDS, LIMITS, st.booleans())


@given(fields)
def test_the_error_is_the_same(given):
    level, error = given.numpy.measure(given.pressure, given.gap)
    assert given.compiled.measure(given.pressure, given.gap) == pytest.approx((level, error), rel=1e-4, abs=1e-5)


@given(fields)
def test_the_same_cells_are_released(given):
    residual, active, count = given.compiled.release(given.pressure, given.gap)
    assert count == given.count == active.sum()
    assert np.array_equal(active, given.active)
    assert residual == pytest.approx(given.residual, abs=1e-5)


@given(fields, st.floats(0.1, 10.0))
def test_the_direction_is_conjugate(given, curvature):
    images = [given.residual.copy(), given.residual.copy()]
    found, known = (
        passes.conjugate(image, given.residual, given.active, LastStep(given.step, given.change, curvature))
        for passes, image in zip((given.compiled, given.numpy), images, strict=True)
    )
    assert found[0] == pytest.approx(known[0], rel=1e-3, abs=1e-4)
    assert found[1] == pytest.approx(known[1], rel=1e-3, abs=1e-4)
    assert not found[0][~given.active].any()
    first, _ = given.compiled.conjugate(images[0], given.residual, given.active, None)
    assert np.array_equal(first, images[0])


@given(fields)
def test_no_released_cell_leaves_its_bounds(given):
    if given.count == 0:
        return
    direction = given.step * given.active
    admitted, slope = given.compiled.admit(direction, given.residual, given.active, given.pressure)
    assert (admitted[given.pressure <= 0.0] >= 0.0).all()
    if given.limit is not None:
        assert (admitted[given.pressure >= given.limit] <= 0.0).all()
    if given.load is not None:
        assert abs(admitted.sum()) < 1e-4 * (1.0 + np.abs(direction).sum())
    assert slope == pytest.approx(float(np.dot(given.residual, admitted)), rel=1e-3, abs=1e-4)


@given(fields, st.floats(0.01, 3.0))
def test_a_step_keeps_bounds_and_load(given, length):
    if given.count == 0:
        return
    direction, _ = given.numpy.admit(given.step * given.active, given.residual, given.active, given.pressure)
    given_to = given.pressure, direction, length, given.active
    trial, step, clipped = given.compiled.advance(*given_to)
    known, _, met = given.numpy.advance(*given_to)
    assert clipped == met
    assert (trial >= 0.0).all()
    assert given.limit is None or (trial <= given.limit).all()
    assert step == pytest.approx(trial - given.pressure, abs=1e-6)
    if given.load is not None:
        allowed = 1e-4 * length * float(np.abs(direction).sum()) + 1e-9
        assert trial.sum() == pytest.approx(given.load, abs=allowed)
    else:
        assert trial == pytest.approx(known, abs=1e-6)


@given(fields, st.floats(0.0, 3.0))
def test_parts_of_steps(given, part):
    trial = np.abs(given.step.astype(np.float64))
    moved, inside = given.compiled.move(given.pressure, trial, part)
    known, met = given.numpy.move(given.pressure, trial, part)
    assert moved == pytest.approx(known, abs=1e-9)
    assert inside == met
    assert given.compiled.slopes(given.residual, given.step, given.change) == pytest.approx(
        given.numpy.slopes(given.residual, given.step, given.change), rel=1e-3, abs=1e-3
    )
    gap = given.gap.copy()
    change = given.change.copy()
    given.compiled.add(gap, change, part)
    assert change == pytest.approx(part * given.change, rel=1e-6)
    assert gap == pytest.approx(given.gap + part * given.change, rel=1e-4, abs=1e-5)
