"""The files of the package by its own hands, as tests need them: study files, records, paths, archives and their seals.

Tests that use these functions as tools, and find no public name for them, take them from here.
"""

from __future__ import annotations

from roughcontact._base import archive as archive
from roughcontact._base.archive import SEAL as SEAL
from roughcontact._base.archive import digest_of as digest_of
from roughcontact._base.archive import pack as pack
from roughcontact._base.archive import read_archive as read_archive
from roughcontact._base.archive import remove_stale as remove_stale
from roughcontact._base.archive import seal as seal
from roughcontact._base.archive import write_archive as write_archive
from roughcontact._base.archive.plain import describe as describe
from roughcontact._base.archive.plain import key_of as key_of
from roughcontact._base.archive.plain import key_of_description as key_of_description
from roughcontact._base.archive.plain import rebuild as rebuild
from roughcontact._base.registry import registries as registries
from roughcontact._solve.problem import read_frictional_path as read_frictional_path
from roughcontact._solve.problem import save_path as save_path
from roughcontact._solve.problem.path_file import PathFile as PathFile
from roughcontact._work.studies.lists import RecordList
from roughcontact._work.studies.lists import read_journal as read_journal
from roughcontact._work.studies.lists import read_list as read_list
from roughcontact._work.studies.lists import write_list as write_list
from roughcontact._work.studies.toml import read_study as read_study


def read_index(path):
    """Return the records of a list by key."""
    return {record.key: record for _, record in read_list(path)}


def read_records(folder):
    """Return the records of all studies in a folder by key: those of their lists, and those that are in none yet."""
    return dict(RecordList(folder, "", None, "").read().records)
