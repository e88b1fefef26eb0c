"""Files: height maps from numpy, text and instruments' files."""

from roughcontact._parts.files.base import RawMap, SurfaceReader, readers
from roughcontact._parts.files.reading import read_raw, read_surface

__all__ = ["RawMap", "SurfaceReader", "read_raw", "read_surface", "readers"]
