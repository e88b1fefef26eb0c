"""``roughcontact run``: a study from its file."""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from roughcontact.errors import InputError, RoughContactError
from roughcontact.studies import Record, Study, StudyResult
from roughcontact.studies.toml import read_study


def run(options: argparse.Namespace) -> None:
    """Read a study, run what is missing, write its table."""
    study = read_study(options.study)
    if options.dry_run:
        print(study.explain())
        return
    if options.workers < 1:
        raise InputError.about("The number of workers", options.workers, "a whole number of at least 1")
    folder = Path(options.output or Path(options.study).with_suffix(""))
    # Forked workers would inherit the threads of the FFT.
    pool = ProcessPoolExecutor(options.workers, mp_context=multiprocessing.get_context("spawn"))
    with pool if options.workers > 1 else nullcontext() as executor:
        result = _run(study, folder, executor)
    result.to_csv(folder / "records.csv")
    print(result)
    for record in result.failed:
        print(f"  {record.problem}, seed {record.seed}, {record.control} {record.load:g}: {record.message}")
    if result.failed:
        raise RoughContactError(f"{len(result.failed)} of {len(result.records)} solves have no certified solution.")


def _run(study: Study, folder: Path, executor: ProcessPoolExecutor | None) -> StudyResult:
    console = Console()
    total = len(study.problems) * max(1, len(study.seeds)) * len(study.loads)
    columns = (TextColumn("solving"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        bar = progress.add_task("solving", total=total)

        def advance(records: Sequence[Record]) -> None:
            progress.advance(bar, len(records))

        return study.run(folder, executor=executor, on_records=advance)
