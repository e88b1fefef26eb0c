"""Errors of a problem against run time, over grids, parts and area estimators."""

from roughcontact._work.reports.error.reference import UNITS as UNITS
from roughcontact._work.reports.error.reference import KnownAnswer as KnownAnswer
from roughcontact._work.reports.error.result import ErrorReport as ErrorReport
from roughcontact._work.reports.error.result import ReportRow as ReportRow
from roughcontact._work.reports.error.result import Timing as Timing
from roughcontact._work.reports.error.run import error_vs_time as error_vs_time
