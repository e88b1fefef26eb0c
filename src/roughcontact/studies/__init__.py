"""Studies: many problems, many loads, on any executor, and on disk as they go."""

from roughcontact.studies.record import Record
from roughcontact.studies.result import StudyResult
from roughcontact.studies.study import Study

__all__ = ["Record", "Study", "StudyResult"]
