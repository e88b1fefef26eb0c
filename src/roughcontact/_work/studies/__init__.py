"""Studies: many problems, many loads, on any executor, and on disk as they go."""

from roughcontact._work.studies.record import Record, StudyResult
from roughcontact._work.studies.shares import Share
from roughcontact._work.studies.study import Study

__all__ = ["Record", "Share", "Study", "StudyResult"]
