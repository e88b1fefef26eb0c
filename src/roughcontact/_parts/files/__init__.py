"""Files: height maps from numpy, text and instruments' files."""

from roughcontact._parts.files.base import RawMap as RawMap
from roughcontact._parts.files.base import SurfaceReader as SurfaceReader
from roughcontact._parts.files.base import readers as readers
from roughcontact._parts.files.line_scans import LineScans as LineScans
from roughcontact._parts.files.line_scans import read_profile as read_profile
from roughcontact._parts.files.reading import list_reader_options as list_reader_options
from roughcontact._parts.files.reading import read_raw as read_raw
from roughcontact._parts.files.reading import read_surface as read_surface
