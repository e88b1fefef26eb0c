"""Random contact problems of any magnitude, each judged in extended precision.

    python docs/studies/random_problems.py [PROBLEMS]

Prints how many problems ended with which status, and those wrongly called a success. Run it from a checkout:
problems and judge are those of the tests (tests/fuzz/test_fuzz_problems.py).
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "fuzz"))
from fuzz_cases import case_of
from test_fuzz_problems import PROBLEMS, fault_of


def main(problems: int = PROBLEMS) -> tuple[Counter[str], list[str]]:
    """Solve and judge random problems; print and return the counts and the wrong ones."""
    counts, wrong, started = Counter[str](), [], time.process_time()
    for number in range(problems):
        status, fault = fault_of(case_of(number))
        counts[" ".join(status.split()[:4])] += 1
        if fault is not None:
            wrong.append(f"{number}: {case_of(number)}: {status}: {fault}")
    print("| status | problems |\n|---|---|")
    for status, count in counts.most_common():
        print(f"| {status} | {count} |")
    print(f"\n{problems} problems, {time.process_time() - started:.0f} s of CPU time, {len(wrong)} wrong.")
    for text in wrong:
        print(text)
    return counts, wrong


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
