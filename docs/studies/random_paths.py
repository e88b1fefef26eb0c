"""Random paths of contacts that are flattened, wear and relax, each state judged by a dense matrix.

    python docs/studies/random_paths.py [PATHS]

Prints how many paths were followed, their states, the largest errors, and the paths of which a state is wrong. Run it
from a checkout: paths and judge are those of the tests (tests/paths/test_random_paths.py).
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from path_cases import draw_case, judge_path


def main(paths: int = 1000) -> list[str]:
    """Follow and judge random paths; print the counts and errors, and return the wrong ones."""
    counts = Counter[str]()
    errors: dict[str, float] = {}
    states = 0
    wrong = []
    started = time.process_time()
    for number in range(paths):
        case = draw_case(number)
        status, judge = judge_path(case)
        counts[status] += 1
        states += judge.states
        for name, error in judge.errors.items():
            errors[name] = max(error, errors.get(name, 0.0))
        if judge.fault is not None or judge.states == 0:
            wrong.append(f"{number}: {status}: {judge.fault}: {case}")
    print("| status | paths |\n|---|---|")
    for status, count in counts.most_common():
        print(f"| {status} | {count} |")
    print("\n| largest error | |\n|---|---|")
    for name, error in errors.items():
        print(f"| {name} | {error:.1e} |")
    print(f"\n{states} states, {time.process_time() - started:.0f} s of CPU time, {len(wrong)} paths wrong.")
    for text in wrong:
        print(text)
    return wrong


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
