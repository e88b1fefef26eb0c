"""The index of a study: its records in one file, a convenience that can always be made again from the solutions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs

from roughcontact.archive import replacing
from roughcontact.studies.record import Record


def read_index(path: Path) -> dict[str, Record]:
    """Return the records by key; none where there is no index, or one that is damaged."""
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return {entry["key"]: _record(entry) for entry in entries}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def write_index(path: Path, records: Sequence[Record]) -> None:
    """Write the records, whole or not at all."""
    text = json.dumps([attrs.asdict(record) for record in records], indent=1)
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _record(entry: Mapping[str, object]) -> Record:
    areas = {str(name): (float(pair[0]), float(pair[1])) for name, pair in entry["areas"].items()}  # type: ignore[attr-defined]
    return Record(**{**entry, "areas": areas})  # type: ignore[arg-type]
