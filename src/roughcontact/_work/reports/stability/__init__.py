"""Diagnostics: how an answer depends on rounding, grid and tolerance."""

from roughcontact._work.reports.stability.check import Check as Check
from roughcontact._work.reports.stability.check import Verdict as Verdict
from roughcontact._work.reports.stability.run import StabilityReport as StabilityReport
from roughcontact._work.reports.stability.run import stability as stability
