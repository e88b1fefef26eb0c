"""``roughcontact report``: height maps in, error against run time out."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from roughcontact.archive import replacing
from roughcontact.cli.solve import problem_of
from roughcontact.report import ErrorReport, error_vs_time
from roughcontact.solution import DEFAULT_AREA


def run(options: argparse.Namespace) -> None:
    """Read, solve all cases, print the table and the advice, write CSV, Markdown and picture."""
    folder = Path(options.output)
    folder.mkdir(parents=True, exist_ok=True)
    report = _made(options, Console())
    advice = report.advice()
    print(f"{report}\n\n{advice}")
    report.to_csv(folder / "report.csv")
    with replacing(folder / "report.md") as partial:
        partial.write_text(f"{report.to_markdown()}\n{advice}\n", encoding="utf-8")
    report.draw(folder / "report.png")
    print(f"\nWritten to {folder}: report.csv, report.md, report.png")


def _made(options: argparse.Namespace, console: Console) -> ErrorReport:
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        bar = progress.add_task("solving", total=1.0)
        return error_vs_time(
            problem_of(options),
            pressure=options.pressure,
            force=options.force,
            approach=options.approach,
            cells=options.cells,
            areas=options.areas or (DEFAULT_AREA, "cell-count"),
            kernels=options.kernels,
            solvers=options.solvers,
            tolerances=options.tolerances,
            between=options.between,
            repeats=options.repeats,
            on_case=lambda what, share: progress.update(bar, description=what, completed=share),
        )
