"""The records of a study on disk: a line a record while it runs, and one sealed list when it has ended.

Each process appends to a file of its own, so that nothing is lost when processes are killed and none waits for another;
the list of a study, or of one share, gathers these lines at the end of a run.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from roughcontact._base.archive import append_line, is_left_over, name_process, replacing, short_digest
from roughcontact._base.archive.plain import describe, rebuild
from roughcontact._work.studies.record import PASSED_UNITS, PATH_UNITS, Place, Record
from roughcontact._work.studies.shares import Share

_FORMAT = "roughcontact study, format 1"
# Most characters of the list of records, and of one record (about 500 and its warnings); the end of the list.
_MAX_LIST_CHARACTERS = 2**28
_MAX_RECORD_CHARACTERS = 2**16
_LIST_END = "\n]}\n"
# What a line has in place of the content of its study if that is not known, because a function builds the problems.
_UNKNOWN = "-"


@attrs.frozen(eq=False)
class Known:
    """Records that are on disk.

    Attributes
    ----------
    records
        All of them, by key.
    keys
        The keys of those that this very study has made, with these versions, by place: they need not be computed.
    """

    records: Mapping[str, Record] = attrs.Factory(dict)
    keys: Mapping[Place, str] = attrs.Factory(dict)


@attrs.frozen
class Journal:
    """Appends records to a file of this process, a line each.

    Attributes
    ----------
    stem
        The beginning of the file's path, the same for all processes of a run.
    content
        The key of the content of the study, by which its places determine the keys; empty if it is not known.
    """

    stem: Path
    content: str

    def append(self, record: Record) -> None:
        """Append a record; `NotWritten` if the system refuses, and then nothing is appended."""
        body = f"{self.content or _UNKNOWN} {_to_text(record)}"
        path = self.stem.with_name(f"{self.stem.name}.{name_process()}.jsonl")
        append_line(path, f"{short_digest(body)} {body}")


@attrs.frozen(eq=False)
class RecordList:
    """The records of a study, or of one share, in a folder.

    Attributes
    ----------
    folder
        The folder.
    study
        The key of the study.
    share
        Which of n shares it is; None for all. Each has its own list, because writers would overwrite each other's.
    content
        See `Journal`.
    """

    folder: Path
    study: str
    share: Share | None
    content: str
    _run: str = attrs.field(init=False, factory=lambda: uuid.uuid4().hex[:12])

    @property
    def journal(self) -> Journal:
        """What the processes of this run append to."""
        return Journal(self.folder / f"{self._name}.{self._run}", self.content)

    @property
    def path(self) -> Path:
        """The file of the list."""
        return self.folder / f"{self._name}.json"

    @property
    def _name(self) -> str:
        part = "" if self.share is None else f"-{self.share.number}-of-{self.share.count}"
        return f"study-{self.study}{part}"

    def read(self) -> Known:
        """Return the records that all studies have left in the folder."""
        whole = self.folder / f"study-{self.study}.json"
        # The list of the whole may know more areas than those that the shares were asked for.
        lists = [*sorted(set(self.folder.glob("study-*.json")) - {whole}), whole]
        found = [pair for path in lists for pair in read_list(path)]
        found += [pair for path in sorted(self.folder.glob("study-*.jsonl")) for pair in read_journal(path)]
        records: dict[str, Record] = {}
        for _, record in found:
            known = records.get(record.key)
            if known is None or _count_answers(record) >= _count_answers(known):
                records[record.key] = record
        own = [record for content, record in found if content == self.content != ""]
        return Known(records, {record.place: record.key for record in own})

    def close(self, records: Sequence[Record], *, ended: bool) -> None:
        """Write the list: the records of this run in its order, then earlier ones.

        Parameters
        ----------
        records
            The records of this run.
        ended
            Whether its processes append nothing any more.
        """
        own = set(self._journals(self._run)) if ended else set()
        left = {path for path in self._journals("*") if _is_left_over(path)} - own
        earlier = [record for _, record in read_list(self.path)]
        earlier += [record for path in sorted(left) for _, record in read_journal(path)]
        keys = {record.key for record in records}
        others = {record.key: record for record in earlier if record.key not in keys}
        write_list(self.path, [*records, *others.values()], self.content, len(records))
        for path in own | left:
            with contextlib.suppress(OSError):
                path.unlink()

    def is_scattered(self) -> bool:
        """Return whether there are lines of processes that have ended, so that the list is to be written."""
        return any(map(_is_left_over, self._journals("*")))

    def _journals(self, run: str) -> list[Path]:
        return list(self.folder.glob(f"{self._name}.{run}.*.jsonl"))


def _is_left_over(journal: Path) -> bool:
    return is_left_over(journal, journal.name.split(".")[-2])


def _count_answers(record: Record) -> int:
    return record.has_solution + len(record.areas) + len(record.answers)


def read_list(path: Path) -> list[tuple[str, Record]]:
    """Return the records of a file of `write_list`, each with the content of its study; none if it is damaged."""
    try:
        text = _read_text(path)
        head, _, rest = text.partition("\n")
        lines = rest.removesuffix(_LIST_END)
        stated = json.loads(f"{head}]}}")
        content = stated.get("study", "")
        count = stated.get("current", 0)
        # Checked before any of the content is used.
        if _seal(lines, content, count) != text:
            return []
        texts = lines.split(",\n") if lines else []
        return [(content if index < count else "", _from_text(one)) for index, one in enumerate(texts)]
    # The list only saves time: it is made again if it is damaged in any way.
    except Exception:
        return []


def write_list(path: Path, records: Sequence[Record], content: str = "", current: int = 0) -> None:
    """Write records with a checksum, completely or not at all; the first ones are `current`, of a study's content."""
    with replacing(path) as partial:
        partial.write_text(_seal(",\n".join(map(_to_text, records)), content, current), encoding="utf-8")


def read_journal(path: Path) -> list[tuple[str, Record]]:
    """Return the records of the whole lines of a file of `Journal`, each with the content of its study."""
    try:
        return list(_read_lines(_read_text(path).split("\n")))
    except Exception:
        return []


def _read_lines(lines: Iterable[str]) -> Iterator[tuple[str, Record]]:
    for line in lines:
        digest, _, body = line.partition(" ")
        content, _, text = body.partition(" ")
        # The last line of a process that was killed may be torn.
        if digest == short_digest(body):
            with contextlib.suppress(Exception):
                yield "" if content == _UNKNOWN else content, _from_text(text)


def _read_text(path: Path) -> str:
    if path.is_symlink() or not path.is_file() or path.stat().st_size > _MAX_LIST_CHARACTERS:
        return ""
    return path.read_text(encoding="utf-8", errors="replace")


def _from_text(text: str) -> Record:
    if len(text) > _MAX_RECORD_CHARACTERS:
        raise ValueError("a record has too many characters")
    return Record(**rebuild(json.loads(text), {}))


def _to_text(record: Record) -> str:
    return json.dumps(describe(_stated(record), {}))


def _stated(record: Record) -> dict[str, Any]:
    """Return the fields of a record, without those that it does not have, as in the lists of older versions."""
    absent = [] if record.parameters else ["parameters"]
    absent += [name for name in (*PATH_UNITS, *PASSED_UNITS) if name not in record.list_path_figures()]
    absent += [] if record.numbers else ["numbers"]
    absent += [] if record.answers else ["answers"]
    return {name: value for name, value in attrs.asdict(record).items() if name not in absent}


def _seal(lines: str, content: str, current: int) -> str:
    """Return the text of the list of records, with the checksum of its lines and the number of those of a content."""
    digest = hashlib.sha256(f"{content}{current}{lines}".encode() if content else lines.encode()).hexdigest()
    # Lists of older versions do not say which of their records are of the study as it is.
    own = f'"study": "{content}", "current": {current}, ' if content else ""
    return f'{{"format": "{_FORMAT}", {own}"sha256": "{digest}", "records": [\n{lines}{_LIST_END}'
