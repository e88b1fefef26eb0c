"""Errors of a problem against run time, over grids, parts and area estimators."""

from roughcontact._work.reports.error.reference import UNITS, KnownAnswer
from roughcontact._work.reports.error.result import ErrorReport, ReportRow, Timing
from roughcontact._work.reports.error.run import error_vs_time

__all__ = ["UNITS", "ErrorReport", "KnownAnswer", "ReportRow", "Timing", "error_vs_time"]
