"""States of random paths, judged by code that shares nothing with the plug-in; see `judged_paths.py`."""

import pytest

from judged_paths import KINDS, judge_path


# 201: it yields in the uppermost layer alone.
@pytest.mark.parametrize(
    ("seed", "kind"), [(1, "plain"), (4, "plain"), (201, "plain"), (302, "stressed"), (302, "both")]
)
def test_no_state_of_a_path_is_false(seed, kind):
    faults, states, flowing = judge_path(seed, kind)
    assert faults == []
    assert states == 5
    assert flowing > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 120))
def test_no_state_of_more_paths_is_false(seed):
    assert judge_path(seed, KINDS[seed % 3])[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free-periodic", "periodic-free"])
def test_no_state_on_a_mixed_boundary_is_false(boundary):
    faults, states, flowing = judge_path(70003, boundary=boundary)
    assert faults == []
    assert states == 5
    assert flowing > 0
