"""States of random paths, judged by code that shares nothing with the plug-in; see `judged_paths.py`."""

import pytest

from judged_paths import judge_path


# 201: it yields in the uppermost layer alone.
@pytest.mark.parametrize("seed", [1, 4, 201])
def test_no_state_of_a_path_is_false(seed):
    faults, states, flowing = judge_path(seed)
    assert faults == []
    assert states == 5
    assert flowing > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 120))
def test_no_state_of_more_paths_is_false(seed):
    assert judge_path(seed)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("boundary", ["free-periodic", "periodic-free"])
def test_no_state_on_a_mixed_boundary_is_false(boundary):
    faults, states, flowing = judge_path(70003, boundary)
    assert faults == []
    assert states == 5
    assert flowing > 0
