"""Files: height maps in, results out."""

from roughcontact.files.base import RawMap, SurfaceReader
from roughcontact.files.reading import read_surface
from roughcontact.files.results import write_solution

__all__ = ["RawMap", "SurfaceReader", "read_surface", "write_solution"]
