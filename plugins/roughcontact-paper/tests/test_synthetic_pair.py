"""The synthetic pair that replaces the paper's unpublished height maps."""

from __future__ import annotations

import numpy as np
import pytest

from roughcontact_paper import synthetic_pair


def test_it_has_the_steel_domain_and_ball_of_the_paper():
    pair = synthetic_pair.new_pair(512)
    assert pair.plan.grid.size == (264.2e-6, 264.2e-6)
    assert pair.plan.pressure_limit == 6e9
    assert pair.plan.modulus == pytest.approx(210e9 / (2 * (1 - 0.3**2)))
    assert pair.body.surface.separate("sphere").radius == pytest.approx(5e-3, rel=0.02)


def test_the_ring_has_its_lay_along_y():
    heights = synthetic_pair.new_pair(512).counterbody.surface.values
    across, along = (np.abs(np.diff(heights, axis=axis)).mean() for axis in (0, 1))
    assert across > 5 * along
    assert heights.std() == pytest.approx(0.2e-6, rel=1e-6)


def test_coarse_maps_are_scaled_bilinearly():
    """On half as many cells along a side, each is the mean of two by two."""
    pair = synthetic_pair.new_pair(512)
    fine, coarse = pair.counterbody.surface.values, synthetic_pair.coarsen(pair, 256).counterbody.surface.values
    np.testing.assert_allclose(coarse, fine.reshape(256, 2, 256, 2).mean(axis=(1, 3)), atol=1e-20)


@pytest.mark.slow
def test_running_in_is_continued_where_it_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(synthetic_pair, "PLACES", 2)
    pair, cycles = synthetic_pair.new_pair(512), []
    complete = synthetic_pair.run_in_pair(pair, tmp_path / "complete.npz", cycles.append)

    class Stopped(Exception):
        pass

    def stop(result):
        cycles.append(result)
        if len(cycles) == count + 3:
            raise Stopped

    count = len(cycles)
    with pytest.raises(Stopped):
        synthetic_pair.run_in_pair(pair, tmp_path / "maps.npz", stop)
    # The first round of two is kept, the third cycle is repeated.
    rest = []
    again = synthetic_pair.run_in_pair(pair, tmp_path / "maps.npz", rest.append)
    assert len(rest) == count - 2
    for one, other in ((complete.body, again.body), (complete.counterbody, again.counterbody)):
        np.testing.assert_array_equal(one.surface.values, other.surface.values)
    synthetic_pair.run_in_pair(pair, tmp_path / "maps.npz", lambda _: pytest.fail("repeated"))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut short", b"\x93NUMPY"])
def test_damaged_maps_are_replaced(tmp_path, monkeypatch, content):
    monkeypatch.setattr(synthetic_pair, "PLACES", 1)
    monkeypatch.setattr(synthetic_pair, "TOLERANCE", 1.0)
    (tmp_path / "maps.npz").write_bytes(content)
    cycles = []
    synthetic_pair.run_in_pair(synthetic_pair.new_pair(512), tmp_path / "maps.npz", cycles.append)
    assert cycles
    # The file serves no other pair and no other way of running in.
    monkeypatch.setattr(synthetic_pair, "RUN_IN_FORCE", 9.0)
    count = len(cycles)
    synthetic_pair.run_in_pair(synthetic_pair.new_pair(512), tmp_path / "maps.npz", cycles.append)
    assert len(cycles) > count
