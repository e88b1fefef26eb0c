"""The gallery of stiff and extreme scenes, run and judged."""

from __future__ import annotations

import math
import textwrap

import attrs

from roughcontact.errors import InputError
from roughcontact.solution import Status
from roughcontact.stability.report import Verdict, worst
from roughcontact.stability.scenes import Scene, scenes
from roughcontact.stability.summation import recomputed

# What a converged solution shows to plain sums: twice the tolerance; to rounding; its load.
_CONFIRMED = 2e-8
_ROUNDED = 1e-5
_LOAD = 1e-12


@attrs.frozen
class GalleryRow:
    """One scene and what became of it.

    Attributes
    ----------
    scene
        What is extreme about it.
    status
        The solver's status, or the sentence of the refusal.
    iterations, convolutions
        What it took; zero where it was refused.
    gap, load
        Residuals recomputed by plain sums: of the gap, over the scale, and of the load; nan where refused.
    verdict
        Pass: converged and confirmed, or refused in a sentence. Attention: the status says that it is
        not converged. Fail: called converged, and is not.
    """

    scene: str
    status: str
    iterations: int
    convolutions: int
    gap: float
    load: float
    verdict: Verdict


@attrs.frozen
class Gallery:
    """All scenes; `str` of it is a table."""

    rows: tuple[GalleryRow, ...]

    @property
    def verdict(self) -> Verdict:
        """The worst verdict."""
        return worst(row.verdict for row in self.rows)

    def __str__(self) -> str:
        lines = [
            "| scene | status | iterations | convolutions | gap | load | verdict |",
            "|---|---|---|---|---|---|---|",
        ]
        for row in self.rows:
            work = f"{row.iterations} | {row.convolutions} | {row.gap:.1e} | {row.load:.1e}"
            refused, converged = math.isnan(row.gap), row.status.startswith("converged")
            short = row.status.split(":")[0] if converged else textwrap.shorten(row.status, 100, placeholder=" ...")
            lines.append(f"| {row.scene} | {short} | {'| | |' if refused else work} | {row.verdict} |")
        counts = [(verdict, sum(row.verdict is verdict for row in self.rows)) for verdict in Verdict]
        said = ", ".join(f"{count} {verdict}" for verdict, count in counts if count)
        return "\n".join([*lines, "", f"overall: {self.verdict} ({said})"])


def stability_gallery() -> Gallery:
    """Solve all scenes of the gallery; each converges and is confirmed, or is refused, or says that it did not.

    Residuals are recomputed by plain sums, which share no transform with the solver.
    """
    return Gallery(tuple(_row(scene) for scene in scenes()))


def _row(scene: Scene) -> GalleryRow:
    try:
        problem = scene.problem()
        solution = problem.solve(pressure=scene.pressure, throw=False)
    except InputError as refusal:
        return GalleryRow(scene.name, f"refused: {refusal}", 0, 0, math.nan, math.nan, Verdict.PASS)
    found = recomputed(problem, solution, scene.pressure)
    verdict = Verdict.ATTENTION
    if solution.status.success:
        allowed = _ROUNDED if solution.status is Status.CONVERGED_TO_ROUNDING else _CONFIRMED
        verdict = Verdict.PASS if found.gap <= allowed and found.load <= _LOAD else Verdict.FAIL
    return GalleryRow(
        scene=scene.name,
        status=str(solution.status),
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        gap=found.gap,
        load=found.load,
        verdict=verdict,
    )
