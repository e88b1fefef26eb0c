"""Random contact problems of any magnitude, each judged by dense matrices in extended precision.

    python docs/studies/random_problems.py [PROBLEMS]

Prints how many ended with which status, and the worst residuals of those that were called converged.
Run it from a checkout: problems and judge are those of the tests.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

import attrs
from hypothesis import HealthCheck, Phase, given, settings

import roughcontact as rc

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from independent import violations
from strategies import wild_problems


@attrs.define
class Tally:
    """Counts by status, the worst error over what was allowed, and what was silently wrong."""

    counts: Counter[str] = attrs.Factory(Counter)
    errors: list[float] = attrs.Factory(list)
    loads: list[float] = attrs.Factory(list)
    shares: list[float] = attrs.Factory(list)
    wrong: list[str] = attrs.Factory(list)

    def add(self, problem: rc.ContactProblem, load: dict[str, float]) -> None:
        """Solve one problem and judge it."""
        try:
            solution = problem.solve(**load, throw=False)
        except rc.InputError as error:
            self.counts["refused: " + " ".join(str(error).split()[:4]) + " ..."] += 1
            return
        self.counts[str(solution.status)] += 1
        if not solution.status.success:
            return
        found = violations(problem, load, solution)
        self.errors.append(found.error)
        self.loads.append(found.load)
        self.shares.append(found.error / found.allowed(solution.status))
        if not found.holds(solution.status):
            self.wrong.append(f"{problem.plan.grid} {problem.boundary} {load}: {solution.status}: {found}")


def main(problems: int) -> Tally:
    """Draw, solve, judge, print."""
    tally, started = Tally(), time.process_time()

    @settings(
        max_examples=problems,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(wild_problems())
    def each(case: tuple[rc.ContactProblem, dict[str, float]]) -> None:
        tally.add(*case)

    each()
    print("| status | problems |\n|---|---|")
    for status, count in tally.counts.most_common():
        print(f"| {status} | {count} |")
    print(f"\n{sum(tally.counts.values())} problems, {time.process_time() - started:.0f} s of CPU time.")
    print(
        f"Of the {len(tally.errors)} called converged, {len(tally.wrong)} are not; worst error {max(tally.errors):.1e},"
    )
    print(f"worst share of what its status allows {max(tally.shares):.2f}, worst load {max(tally.loads):.1e}.")
    for text in tally.wrong:
        print(text)
    return tally


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
