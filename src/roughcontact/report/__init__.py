"""Errors of one's own problem against run time, over grids, parts and area estimators."""

from roughcontact.report.reference import Reference
from roughcontact.report.result import ErrorReport
from roughcontact.report.row import ReportRow, Timing
from roughcontact.report.run import error_vs_time

__all__ = ["ErrorReport", "Reference", "ReportRow", "Timing", "error_vs_time"]
