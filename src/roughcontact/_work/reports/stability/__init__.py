"""Diagnostics: how an answer depends on rounding, grid and tolerance, and a gallery of extreme contacts."""

from roughcontact._work.reports.stability.check import Check, Verdict
from roughcontact._work.reports.stability.gallery import Gallery, GalleryRow, stability_gallery
from roughcontact._work.reports.stability.run import StabilityReport, stability

__all__ = ["Check", "Gallery", "GalleryRow", "StabilityReport", "Verdict", "stability", "stability_gallery"]
