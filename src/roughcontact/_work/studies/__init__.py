"""Studies: many problems, many loads, on any executor, and on disk as they go."""

from roughcontact._work.studies.answers import name_of as name_of
from roughcontact._work.studies.asking import Answers as Answers
from roughcontact._work.studies.asking import ResponseForm as ResponseForm
from roughcontact._work.studies.asking import add_answers as add_answers
from roughcontact._work.studies.asking import ask_states as ask_states
from roughcontact._work.studies.asking import build_layer as build_layer
from roughcontact._work.studies.asking import build_part as build_part
from roughcontact._work.studies.asking import build_response as build_response
from roughcontact._work.studies.asking import describe_answers_elsewhere as describe_answers_elsewhere
from roughcontact._work.studies.asking import describe_response as describe_response
from roughcontact._work.studies.asking import list_answer_warnings as list_answer_warnings
from roughcontact._work.studies.asking import tabulate_answers as tabulate_answers
from roughcontact._work.studies.asking import write_report as write_report
from roughcontact._work.studies.coatings import LAYERED as LAYERED
from roughcontact._work.studies.coatings import find_layer_class as find_layer_class
from roughcontact._work.studies.form import Form as Form
from roughcontact._work.studies.form import build_problem as build_problem
from roughcontact._work.studies.form import find_parts as find_parts
from roughcontact._work.studies.record import Record as Record
from roughcontact._work.studies.result import StudyNames as StudyNames
from roughcontact._work.studies.result import StudyResult as StudyResult
from roughcontact._work.studies.shares import Share as Share
from roughcontact._work.studies.study import Study as Study
