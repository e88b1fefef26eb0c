"""Diagnostics: how an answer depends on rounding, grid and tolerance."""

from roughcontact._work.reports.stability.check import Check, Verdict
from roughcontact._work.reports.stability.run import StabilityReport, stability

__all__ = ["Check", "StabilityReport", "Verdict", "stability"]
