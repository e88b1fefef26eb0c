"""Studies: many problems, many loads, on any executor, and on disk as they go."""

from roughcontact._work.studies.answers import name_of
from roughcontact._work.studies.asking import (
    Answers,
    ResponseField,
    ResponseForm,
    add_answers,
    ask_states,
    build_layer,
    build_part,
    build_response,
    describe_answers_elsewhere,
    describe_response,
    list_answer_warnings,
    tabulate_answers,
    write_report,
)
from roughcontact._work.studies.coatings import LAYERED, find_layer_class
from roughcontact._work.studies.form import Form, build_problem
from roughcontact._work.studies.record import Record
from roughcontact._work.studies.result import StudyNames, StudyResult
from roughcontact._work.studies.shares import Share
from roughcontact._work.studies.study import Study

__all__ = [
    "LAYERED",
    "Answers",
    "Form",
    "Record",
    "ResponseField",
    "ResponseForm",
    "Share",
    "Study",
    "StudyNames",
    "StudyResult",
    "add_answers",
    "ask_states",
    "build_layer",
    "build_part",
    "build_problem",
    "build_response",
    "describe_answers_elsewhere",
    "describe_response",
    "find_layer_class",
    "list_answer_warnings",
    "name_of",
    "tabulate_answers",
    "write_report",
]
