"""``roughcontact stability``: height maps in, a report of what the answer hangs on out."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from roughcontact.cli.solve import problem_of
from roughcontact.registry import areas
from roughcontact.solution import EstimatesArea
from roughcontact.stability import Verdict, stability, stability_gallery


def run(options: argparse.Namespace) -> int:
    """Print the report; return the exit status, 1 where a check fails."""
    estimator = None if options.area is None else areas.resolve(options.area, EstimatesArea)
    problem = problem_of(options)
    report = stability(problem, pressure=options.pressure, force=options.force, approach=options.approach)
    print(report)
    if estimator is not None:
        print(f"area: {report.solution.area(estimator)}")
    return _status(report.verdict)


class ShowGallery(argparse.Action):
    """Run the gallery, which needs no other argument, and end."""

    def __init__(self, option_strings: Sequence[str], dest: str, **others: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **others)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Print the table and end with its exit status."""
        gallery = stability_gallery()
        print(gallery)
        parser.exit(_status(gallery.verdict))


def _status(verdict: Verdict) -> int:
    return 1 if verdict is Verdict.FAIL else 0
