"""The states of a path in one file, whose fields are stored once though two states share them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from roughcontact._base.archive import digest_of, read_archive, write_archive
from roughcontact._base.archive.plain import describe, rebuild
from roughcontact._base.arrays import RealArray
from roughcontact._solve.solution import storage
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.governed import Governed
from roughcontact.errors import InputError


def write_states(path: Path, kind: str, states: Sequence[ContactSolution], notes: Mapping[str, Any]) -> None:
    """Write the states of a path of a kind, and notes for JSON."""
    _require_suffix(path)
    arrays: dict[str, RealArray] = {}
    described = []
    for state in states:
        fields, header = storage.disassemble(state)
        named = {name: np.asarray(values) for name, values in fields.items()}
        names = {name: digest_of(values) for name, values in named.items()}
        arrays |= {names[name]: values for name, values in named.items()}
        described.append({"header": header, "arrays": names})
    write_archive(path, arrays, {"kind": kind, "notes": describe(notes, {}), "states": described})


def read_states(
    path: Path, kind: str, *, verify: bool, given: Mapping[str, Any] = MappingProxyType({})
) -> tuple[tuple[ContactSolution, ...], dict[str, Any]]:
    """Return what `write_states` has written; `given` has parts in place of those in the file, by kind of addition."""
    _require_suffix(path)
    arrays, header = read_archive(path)
    if header.get("kind") != kind:
        raise InputError(f"The file {path.name} does not hold a {kind}.")
    with storage.usable(path, "its header is wrong"):
        if any(digest_of(values) != name for name, values in arrays.items()):
            raise InputError("An array is not the one that it is named after.")
        states = [_assemble(one, arrays, given) for one in header["states"]]
        if not states:
            raise InputError("It has no state.")
        _require_row(states)
        # Former files of paths with friction have it beside their notes.
        notes = {"pressed": header.get("pressed"), **rebuild(header["notes"], {})}
    if verify:
        states = storage.verify_states(path, states)
    return tuple(states), notes


def _require_suffix(path: Path) -> None:
    if path.suffix != ".npz":
        raise InputError.about("The name of the file of a path", path.name, "one ending in .npz")


def _require_row(states: Sequence[ContactSolution]) -> None:
    """Raise `InputError` unless each step of one increment begins with the state before."""
    for before, after in pairwise(states):
        # Steady sliding follows by what its laws remember alone.
        if after.shear is None or after.is_steady or after.sheared.increments > 1:
            continue
        governed = after._find_added(Governed)
        earlier = before._find_added(Governed)
        if governed is not None and earlier is not None and governed.cycle != earlier.cycle:
            # Cycles that are not kept lie between them.
            continue
        follows = governed is None or earlier is None or governed.begins_with(earlier.memory)
        if not follows or after.sheared.before.digest != before.end.digest:
            raise InputError("The states do not follow each other.")


def _assemble(
    described: Mapping[str, Any], arrays: Mapping[str, RealArray], given: Mapping[str, Any]
) -> ContactSolution:
    if "contact" in described:
        fields, header = storage.translate_frictional(described, arrays)
    else:
        fields = {name: arrays[digest] for name, digest in described["arrays"].items()}
        header = described["header"]
    stated = storage.assemble(fields, header, given)
    storage.require_sound(stated, fields)
    return ContactSolution(**stated)
