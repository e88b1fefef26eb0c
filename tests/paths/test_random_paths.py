"""Random paths of contacts that are flattened, wear and relax: no state that is called a success is wrong."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from path_cases import Judge, draw_case, judge_path


@pytest.mark.slow
@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_no_state_of_a_random_path_is_wrong(number):
    """By a dense matrix, from the pressures alone; `docs/studies/random_paths.py` follows a thousand."""
    case = draw_case(number)
    status, judge = judge_path(case)
    assert judge.fault is None, str(case)
    assert status == "followed", str(case)


def test_the_judge_notices_a_state_that_forgets():
    """The second half of the states, judged as if it were the whole path, is not one of fresh surfaces."""
    cases = map(draw_case, range(100))
    case = next(one for one in cases if one.wear and not any(times for _, times in one.bodies))
    states = []
    case.problem.path(**case.arguments, on_increment=states.append)
    judge = Judge(case)
    for state in states[len(states) // 2 :]:
        judge(state)
    assert "gap" in judge.fault
    assert "memory" in judge.fault
