"""Errors of a user's own problem against run time, over grids, parts and area estimators."""

from roughcontact.report.result import ErrorReport
from roughcontact.report.row import ReportRow, Timing
from roughcontact.report.run import error_vs_time
from roughcontact.report.truth import Truth

__all__ = ["ErrorReport", "ReportRow", "Timing", "Truth", "error_vs_time"]
