"""A report: rows, and what they tell."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

import attrs

from roughcontact.archive import replacing
from roughcontact.checks import choice
from roughcontact.report import tables
from roughcontact.report.advice import advised
from roughcontact.report.row import ReportRow
from roughcontact.report.truth import QUANTITIES, Truth

# An error this many times another one is not yet nearer to the truth.
_NEARER = 0.99


@attrs.frozen(eq=False, kw_only=True)
class ErrorReport:
    """Errors against run time; `str` of it is a table.

    Attributes
    ----------
    rows
        Each case with each estimator, the grids of one setup from coarse to fine.
    truth
        What the errors are measured against.
    nominal
        Nominal area of the domain, m2.
    scene
        What was solved, in words.
    repeats
        How often each case was timed.
    """

    rows: tuple[ReportRow, ...]
    truth: Truth
    nominal: float
    scene: str
    repeats: int

    def front(self, quantity: str = "area") -> tuple[ReportRow, ...]:
        """Return the Pareto front, from cheap to exact: no other row is both cheaper and nearer to the truth.

        Errors below the truth's own count as that one, and errors within a hundredth of each other as
        equal, so that chance does not decide among them.

        Parameters
        ----------
        quantity
            ``"area"``, ``"p_max"`` or ``"approach"``.

        Raises
        ------
        InputError
            If there is no such quantity.
        """
        choice(quantity, "The quantity", QUANTITIES)
        blur = self.truth.blur(quantity)
        known = [row for row in self.rows if math.isfinite(row.error(quantity))]
        best, found = math.inf, []
        for row in sorted(known, key=lambda row: (row.cost(quantity), row.error(quantity))):
            error = max(row.error(quantity), blur)
            if error < _NEARER * best:
                best = error
                found.append(row)
        return tuple(found)

    def advice(self, area: float = 0.005) -> str:
        """Return in a sentence what reaches an error of the area most cheaply, and what the other estimators need.

        A case is enough if its error is small enough and stays so on all finer grids of the report: a
        coarse grid that is right by chance is no advice.

        Parameters
        ----------
        area
            Relative error that is allowed.

        Raises
        ------
        InputError
            If the error is not above 0 and at most 1, or the true area is not known.
        """
        return advised(self.rows, self.truth, area)

    def __str__(self) -> str:
        return tables.text(self)

    def to_markdown(self) -> str:
        """Return the table and its notes as Markdown."""
        return tables.markdown(self)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write all rows to a CSV file: SI units, relative errors with sign, every digit.

        Parameters
        ----------
        path
            Where to; an existing file is replaced.

        Raises
        ------
        InputError
            If the folder does not exist.
        """
        with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(tables.records(self))

    def draw(self, path: str | os.PathLike[str]) -> None:
        """Draw errors against CPU time into a picture file, the Pareto front marked.

        Errors below the truth's own are shown hollow.

        Parameters
        ----------
        path
            Where to; the ending says the format.

        Raises
        ------
        InputError
            If the folder does not exist or the format is unknown.
        MissingPackage
            If matplotlib is not installed.
        """
        # Imported here: a report is made and read without matplotlib.
        from roughcontact.report.picture import draw_report

        with replacing(path) as partial:
            draw_report(self, partial, Path(path).suffix)
