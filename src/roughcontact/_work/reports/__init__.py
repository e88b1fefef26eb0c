"""Reports: errors against run time, how far an answer depends on rounding, grid and tolerance, and what to cite."""

from roughcontact._work.reports.citation import cite as cite
from roughcontact._work.reports.citation import list_references as list_references
from roughcontact._work.reports.citation import write_bibtex as write_bibtex
from roughcontact._work.reports.error_report import ErrorReport as ErrorReport
from roughcontact._work.reports.error_report import ReportRow as ReportRow
from roughcontact._work.reports.error_report import Timing as Timing
from roughcontact._work.reports.error_report import find_varying_parts as find_varying_parts
from roughcontact._work.reports.error_report import group_by_setup as group_by_setup
from roughcontact._work.reports.error_runs import error_vs_time as error_vs_time
from roughcontact._work.reports.reference import UNITS as UNITS
from roughcontact._work.reports.reference import KnownAnswer as KnownAnswer
from roughcontact._work.reports.stability_checks import stability as stability
from roughcontact._work.reports.stability_report import Check as Check
from roughcontact._work.reports.stability_report import StabilityReport as StabilityReport
from roughcontact._work.reports.stability_report import Verdict as Verdict
