"""Diagnostics: how an answer depends on rounding, grid and tolerance, and a gallery of extreme contacts."""

from roughcontact.diagnostics.check import Check, Verdict
from roughcontact.diagnostics.gallery import Gallery, GalleryRow, stability_gallery
from roughcontact.diagnostics.run import StabilityReport, stability

__all__ = ["Check", "Gallery", "GalleryRow", "StabilityReport", "Verdict", "stability", "stability_gallery"]
