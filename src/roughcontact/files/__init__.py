"""Files: height maps in, results out."""

from roughcontact.files.base import RawMap, SurfaceReader
from roughcontact.files.reading import read_surface

__all__ = ["RawMap", "SurfaceReader", "read_surface"]
