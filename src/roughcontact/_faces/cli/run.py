"""``roughcontact run``: a study described by a TOML file."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from roughcontact._base.units import counted, fit, kind_of
from roughcontact._faces.cli import DOUBTFUL, Command
from roughcontact._faces.cli.answers import describe_rows, describe_study, write_json
from roughcontact._faces.cli.options import whole_number
from roughcontact._faces.cli.progress import show_progress
from roughcontact._work.studies import Record, Share, StudyResult
from roughcontact.errors import InputError


class Run(Command):
    """Run a study from its TOML file, or continue it."""

    epilog = """
examples:
  roughcontact run study.toml --dry-run
  roughcontact run study.toml --workers 8 -o night
  roughcontact run study.toml --share 3/64
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("study", metavar="STUDY.toml", help="problems, loads, seeds and area estimators")
        parser.add_argument("--dry-run", action="store_true", help="print the plan of every solve, and solve nothing")
        parser.add_argument("--workers", type=whole_number, default=1, metavar="N", help="processes (1)")
        share = "solve only the k-th of n shares, as a job of an array: 3/64 (all)"
        parser.add_argument("--share", metavar="K/N", help=share)
        parser.add_argument("-o", "--output", metavar="FOLDER", help="output folder (the name of the study)")
        parser.add_argument(
            "--json", action="store_true", help="print one JSON object, in SI units: inputs and records"
        )

    def run(self, options: argparse.Namespace) -> int:
        """Return 0, 1 if a solve has no certified solution, or 3 if a solution has warnings."""
        from roughcontact._work.studies.toml import read_study

        share = None if options.share is None else Share.of(options.share)
        if options.dry_run and options.json:
            raise InputError("--dry-run prints the plan, which is text: omit --json.")
        study = read_study(options.study)
        tasks = len(study.problems) * max(1, len(study.seeds))
        own = tasks if share is None else share.size(tasks)
        total = own * len(study.loads)
        if options.dry_run:
            print(fit(study.explain()))
        if share is not None:
            there = f"{counted(tasks, 'task')}, each a problem with a seed"
            what = f"Share {share} has {own} of {there}: {counted(total, 'solve') if own else 'nothing to do'}."
            print(fit(what), file=sys.stderr if options.json else None)
        if options.dry_run or own == 0:
            if options.json:
                print(write_json({"inputs": describe_study(study), "records": []}))
            return 0
        if options.workers < 1:
            raise InputError.about("The number of workers", options.workers, "a whole number of at least 1")
        folder = Path(options.output or Path(options.study).with_suffix(""))
        done: list[Record] = []
        with _start_workers(options.workers) as executor, show_progress(f"0 of {total} solves") as change:

            def count(records: Sequence[Record]) -> None:
                done.extend(records)
                change(f"{len(done)} of {total} solves", len(done) / total)

            result = study.run(folder, executor=executor, share=options.share, on_records=count)
        # Shares would overwrite each other's table.
        if share is None:
            result.to_csv(folder / "records.csv")
        if options.json:
            table = result.table()
            content = {"inputs": describe_study(study), "records": describe_rows(table), "units": dict(table.units)}
            print(write_json(content))
        else:
            print(_to_text(result))
        doubtful = DOUBTFUL if any(record.doubtful for record in result) else 0
        return 1 if result.failed else doubtful


def _to_text(result: StudyResult) -> str:
    """Return the answers of a study, why solves failed, and the warnings, in lines of at most 80 columns."""
    failed = [
        f"  {record.problem}, seed {record.seed}, {record.control} {record.load:g}: {record.message}"
        for record in result.failed
    ]
    return "\n".join(map(fit, [str(result), *failed, *list_warnings(result)]))


def list_warnings(result: StudyResult) -> list[str]:
    """Return each warning once, whatever numbers it has, with the number of solves that have it."""
    found: dict[str, list[str]] = {}
    for record in result:
        kinds = {kind_of(text): text for text in record.warnings}
        for kind, text in kinds.items():
            found.setdefault(kind, []).append(text)
    lines = []
    for texts in found.values():
        numbers = "" if len(set(texts)) == 1 else ", with other numbers"
        lines.append(f"warning  {texts[0]} [{len(texts)} of {counted(len(result), 'solve')}{numbers}]")
    return lines


@contextmanager
def _start_workers(count: int) -> Iterator[ProcessPoolExecutor | None]:
    """Yield a pool of workers, or None for one; they end with the block."""
    if count == 1:
        yield None
        return
    # Spawned, because forked workers would inherit the threads of the FFT.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_end_with_parent)
    try:
        yield pool
    finally:
        # A worker that was killed while it waited for a task has left a lock behind: the others would never end.
        for worker in multiprocessing.active_children():
            worker.terminate()
        pool.shutdown(cancel_futures=True)


def _end_with_parent() -> None:
    """Let this worker end with the process that started it, for whose tasks it would wait for ever."""
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
