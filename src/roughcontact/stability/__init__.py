"""Stability: how far a solution hangs on digits, cells and tolerances, and the gallery of extreme scenes."""

from roughcontact.stability.examine import stability
from roughcontact.stability.gallery import Gallery, GalleryRow, stability_gallery
from roughcontact.stability.report import Check, StabilityReport, Verdict

__all__ = ["Check", "Gallery", "GalleryRow", "StabilityReport", "Verdict", "stability", "stability_gallery"]
