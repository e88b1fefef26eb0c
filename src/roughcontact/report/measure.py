"""A case, run, timed and compared with the truth."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from typing import Any, TypeVar

import attrs

from roughcontact.errors import NotConverged, RoughContactError
from roughcontact.load import Load
from roughcontact.problem import ContactProblem
from roughcontact.report.cases import Case, worded
from roughcontact.report.row import ReportRow, Timing
from roughcontact.report.truth import Truth
from roughcontact.solution import Area, ContactSolution, EstimatesArea

T = TypeVar("T")


@attrs.frozen(eq=False, kw_only=True)
class Bench:
    """What all cases of a report have in common.

    Attributes
    ----------
    problem, load, between
        What is solved, and how height maps go on between their points.
    estimators
        The area estimators.
    repeats
        How often a case is timed, after a warm-up.
    truth
        What the answers are compared with.
    """

    problem: ContactProblem
    load: Load
    between: str | None
    estimators: tuple[str | EstimatesArea, ...]
    repeats: int
    truth: Truth

    def rows(self, case: Case) -> tuple[ReportRow, ...]:
        """Return a row for each estimator; a case that fails says so in each."""
        blanks = self._blanks(case)
        try:
            dressed = case.dressed(self.problem)

            def solve() -> ContactSolution:
                return self.load.solve(case.gridded(dressed, self.between))

            solution = solve()
            # Times come before memory: watching every allocation is slow.
            found: list[Area | str] = [_attempt(solution, estimator) for estimator in self.estimators]
            works = [not isinstance(area, str) for area in found]
            samples = [self._timed(solve, works) for _ in range(self.repeats)]
            peaks = self._peaks(solve, works)
        # What a plug-in raises, whatever it is, ends its own case and not the report.
        except Exception as error:
            return tuple(attrs.evolve(blank, failure=_sentence(error)) for blank in blanks)
        rows = []
        for number, (blank, area) in enumerate(zip(blanks, found, strict=True)):
            if isinstance(area, str):
                rows.append(attrs.evolve(blank, failure=area))
            else:
                spent = [(times[0], times[1 + number]) for times in samples]
                rows.append(self._filled(blank, solution, area, spent, peaks[number]))
        return tuple(rows)

    def _blanks(self, case: Case) -> list[ReportRow]:
        return [
            ReportRow(
                shape=case.shape,
                kernel=worded(case.kernel),
                convolver=case.convolver_name,
                solver=case.solver_name,
                tolerance=case.solver.tolerance,
                estimator=worded(estimator),
            )
            for estimator in self.estimators
        ]

    def _timed(self, solve: Callable[[], ContactSolution], works: list[bool]) -> list[tuple[float, float]]:
        """Return CPU and wall time of one solve, then those of each estimator."""
        solution, spent = _clocked(solve)
        times = [spent]
        for estimator, usable in zip(self.estimators, works, strict=True):
            # A copy: what one estimator finds out, such as the clusters, would make the next one look cheap.
            copy = attrs.evolve(solution)
            times.append(_clocked(lambda copy=copy, by=estimator: copy.area(by))[1] if usable else (0.0, 0.0))  # type: ignore[misc]
        return times

    def _peaks(self, solve: Callable[[], ContactSolution], works: list[bool]) -> list[int]:
        """Return the greatest memory of the solve with each estimator, bytes."""
        watched = tracemalloc.is_tracing()
        if not watched:
            tracemalloc.start()
        try:
            before = tracemalloc.get_traced_memory()[0]
            tracemalloc.reset_peak()
            solution = solve()
            solved = tracemalloc.get_traced_memory()[1] - before
            peaks = []
            for estimator, usable in zip(self.estimators, works, strict=True):
                tracemalloc.reset_peak()
                if usable:
                    attrs.evolve(solution).area(estimator)
                peaks.append(max(solved, tracemalloc.get_traced_memory()[1] - before))
        finally:
            if not watched:
                tracemalloc.stop()
        return peaks

    def _filled(
        self,
        blank: ReportRow,
        solution: ContactSolution,
        area: Area,
        samples: list[tuple[tuple[float, float], tuple[float, float]]],
        peak: int,
    ) -> ReportRow:
        values = {"area": area.value, "p_max": float(solution.pressure.max()), "approach": solution.approach}
        errors = {name: self.truth.error(name, value) for name, value in values.items()}
        answers: dict[str, Any] = {**values, **{f"{name}_error": error for name, error in errors.items()}}
        return attrs.evolve(
            blank,
            **answers,
            area_uncertainty=area.uncertainty,
            unresolved=frozenset(name for name, error in errors.items() if abs(error) < self.truth.blur(name)),
            cpu=Timing.of([solve[0] + estimate[0] for solve, estimate in samples]),
            wall=Timing.of([solve[1] + estimate[1] for solve, estimate in samples]),
            solve_cpu=Timing.of([solve[0] for solve, _ in samples]),
            area_cpu=Timing.of([estimate[0] for _, estimate in samples]),
            iterations=solution.iterations,
            convolutions=solution.convolutions,
            single=sum(level.single for level in solution.levels),
            peak=peak,
        )


def _attempt(solution: ContactSolution, estimator: str | EstimatesArea) -> Area | str:
    try:
        return solution.area(estimator)
    except Exception as error:
        return _sentence(error)


def _clocked(work: Callable[[], T]) -> tuple[T, tuple[float, float]]:
    """Return what the work gives, and its CPU and wall time, s."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = work()
    return result, (time.process_time() - cpu, time.perf_counter() - wall)


def _sentence(error: Exception) -> str:
    if isinstance(error, NotConverged):
        return f"{error.solution.status} ({error.solution.iterations} iterations)"
    words = " ".join(str(error).split())
    return words if isinstance(error, RoughContactError) else f"{type(error).__name__}: {words}"
