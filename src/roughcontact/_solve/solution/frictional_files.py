"""Contacts with friction in files: one state, or the states of a path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from roughcontact._base.archive import digest_of, read_archive, write_archive
from roughcontact._base.archive.plain import describe, rebuild
from roughcontact._base.arrays import RealArray
from roughcontact._base.units import Estimate
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.solution import storage
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.frictional_state import FrictionalResiduals, FrictionalState, TangentialLoad
from roughcontact._solve.solution.results import Residuals, Status
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact._solve.solution.frictional import FrictionalSolution

_STATE_KIND = "frictional solution"
_PATH_KIND = "frictional path"
_COUNTS = ("passes", "iterations", "increments")


def write_frictional(path: Path, solution: FrictionalSolution) -> None:
    """Write one state; see `FrictionalSolution.save`."""
    _write(path, {"kind": _STATE_KIND}, [solution])


def read_frictional(path: Path, kind: type[FrictionalSolution], *, verify: bool) -> FrictionalSolution:
    """Return the state in a file; see `FrictionalSolution.load`."""
    return _read(path, _STATE_KIND, kind, verify=verify)[0][0]


def write_path(
    path: Path, states: Sequence[FrictionalSolution], pressed: FrictionalSolution | None, notes: Mapping[str, Any]
) -> None:
    """Write the states of a path, that under the normal load alone, and notes for JSON."""
    header = {"kind": _PATH_KIND, "pressed": pressed is not None, "notes": describe(notes, {})}
    _write(path, header, [*([] if pressed is None else [pressed]), *states])


def read_path(
    path: Path, kind: type[FrictionalSolution], *, verify: bool, law: FrictionLaw | None = None
) -> tuple[tuple[FrictionalSolution, ...], FrictionalSolution | None, dict[str, Any]]:
    """Return what `write_path` has written, with a friction law instead of the one in the file if it is given."""
    states, header = _read(path, _PATH_KIND, kind, verify=verify, law=law)
    pressed = states[0] if header["pressed"] else None
    with storage.usable(path, "its header is wrong"):
        notes = rebuild(header["notes"], {})
    return tuple(states[1 if header["pressed"] else 0 :]), pressed, notes


def _require_suffix(path: Path) -> None:
    if path.suffix != ".npz":
        raise InputError.about("The name of the file of a contact with friction", path.name, "one ending in .npz")


def read_estimate(stored: Mapping[str, Any]) -> Estimate:
    """Return an estimate from its fields in a file."""
    warnings = tuple(str(text) for text in stored["warnings"])
    return Estimate(float(stored["value"]), float(stored["uncertainty"]), str(stored["unit"]), warnings)


def _write(path: Path, header: Mapping[str, Any], states: Sequence[FrictionalSolution]) -> None:
    _require_suffix(path)
    arrays: dict[str, RealArray] = {}

    def keep(values: Any) -> str:
        array = np.asarray(values)
        name = digest_of(array)
        arrays[name] = array
        return name

    described = [_describe(state, keep) for state in states]
    write_archive(path, arrays, {**header, "states": described})


def _describe(state: FrictionalSolution, keep: Any) -> dict[str, Any]:
    fields, contact = storage.disassemble(state.contact)
    parts: dict[str, RealArray] = {}
    law = describe(state.friction, parts)
    before = state.before
    numbers = ("displacement", "given", "pair", "dissipated", "elastic_energy", "seconds", *_COUNTS)
    return {
        "contact": {"header": contact, "arrays": {name: keep(values) for name, values in fields.items()}},
        "arrays": {"shear": keep(state.shear), "slip": keep(state.slip)},
        "friction": law,
        "parts": {name: keep(values) for name, values in parts.items()},
        "status": state.status.name,
        "residuals": describe(attrs.asdict(state.residuals), {}),
        **{name: describe(_plain(getattr(state, name)), {}) for name in numbers},
        "digest": state.state.digest,
        "before": {
            "digest": before.digest,
            "pressure": keep(before.pressure),
            "shear": keep(before.shear),
            "displacement": describe(before.displacement, {}),
            "approach": before.approach,
        },
    }


def _plain(value: Any) -> Any:
    return attrs.asdict(value) if attrs.has(type(value)) else value


def _read(
    path: Path, expected: str, kind: type[FrictionalSolution], *, verify: bool, law: FrictionLaw | None = None
) -> tuple[list[FrictionalSolution], dict[str, Any]]:
    _require_suffix(path)
    arrays, header = read_archive(path)
    if header.get("kind") != expected:
        raise InputError(f"The file {path.name} does not hold a {expected}.")
    with storage.usable(path, "its header is wrong"):
        if any(digest_of(values) != name for name, values in arrays.items()):
            raise InputError("An array is not the one that it is named after.")
        states = [_assemble(one, arrays, kind, law) for one in header["states"]]
        if not states:
            raise InputError("It has no state.")
        _require_row(header["states"])
    if verify:
        storage.verify_states(path, states[0].contact, states)
    return states, header


def _require_row(described: Sequence[Mapping[str, Any]]) -> None:
    """Raise `InputError` unless each step of one increment begins with the state before."""
    for before, after in pairwise(described):
        if after["increments"] == 1 and after["before"]["digest"] != before["digest"]:
            raise InputError("The states do not follow each other.")


def _assemble(
    described: Mapping[str, Any],
    arrays: Mapping[str, RealArray],
    kind: type[FrictionalSolution],
    law: FrictionLaw | None,
) -> FrictionalSolution:
    def named(names: Mapping[str, str]) -> dict[str, RealArray]:
        return {name: arrays[digest] for name, digest in names.items()}

    def numbers(name: str) -> Any:
        return rebuild(described[name], {})

    fields = named(described["contact"]["arrays"])
    stated = storage.assemble(fields, described["contact"]["header"])
    storage.require_sound(stated, fields)
    contact = ContactSolution(**stated)
    shape = contact.grid.shape
    own = named(described["arrays"])
    before = described["before"]
    x, y = (float(value) for value in rebuild(before["displacement"], {}))
    state = FrictionalState(
        pressure=_field(arrays[before["pressure"]], shape),
        shear=_field(arrays[before["shear"]], (2, *shape)),
        displacement=(x, y),
        approach=float(before["approach"]),
    )
    residuals = rebuild(described["residuals"], {})
    dx, dy = (float(value) for value in numbers("displacement"))
    given = numbers("given")
    solution = kind(
        contact=contact,
        shear=_field(own["shear"], (2, *shape)),
        slip=_field(own["slip"], (2, *shape)),
        displacement=(dx, dy),
        friction=law or rebuild(described["friction"], named(described["parts"]), (FrictionLaw,)),
        given=TangentialLoad(str(given["kind"]), (float(given["values"][0]), float(given["values"][1]))),
        pair=PairConstants(**numbers("pair")),
        before=state,
        dissipated=read_estimate(numbers("dissipated")),
        elastic_energy=float(numbers("elastic_energy")),
        residuals=FrictionalResiduals(**{**residuals, "normal": Residuals(**residuals["normal"])}),
        status=Status[described["status"]],
        seconds=float(numbers("seconds")),
        **{name: int(numbers(name)) for name in _COUNTS},
    )
    if state.digest != before["digest"] or solution.state.digest != described["digest"]:
        raise InputError("A state is not the one that it is named after.")
    return solution


def _field(values: RealArray, shape: tuple[int, ...]) -> RealArray:
    if values.shape != shape or values.dtype != np.float64 or not np.isfinite(values).all():
        raise InputError(f"It has an array of shape {values.shape}, where finite numbers of shape {shape} are needed.")
    return values
