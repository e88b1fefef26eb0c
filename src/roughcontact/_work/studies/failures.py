"""What went wrong in a study, in words."""

from __future__ import annotations

import traceback
from pathlib import Path

from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._parts.materials import Material
from roughcontact._parts.surfaces import Surface
from roughcontact._solve.convolvers import Convolver
from roughcontact._solve.solvers import Solver
from roughcontact.errors import InputError, NotConverged, NotWritten, RoughContactError

_KINDS = {Surface: "surface", Material: "material", InfluenceKernel: "kernel", Convolver: "convolver", Solver: "solver"}
# Characters of an exception that a record repeats.
_LONGEST = 300


def name_full_disk(folder: Path, error: NotWritten) -> str:
    """Return in words why nothing can be written into a folder."""
    return f"The folder {folder} cannot be written to ({error.strerror})"


def name_exception(what: str, error: Exception) -> str:
    """Return in a sentence what failed, and by which exception."""
    reason = " ".join(traceback.format_exception_only(_met(error))[-1].split())
    return f"{what} failed ({reason[:_LONGEST]})."


def _met(error: BaseException) -> BaseException:
    """Return the exception that was met, where the public call of a worker has translated it."""
    return error.__cause__ if isinstance(error, RoughContactError) and error.__cause__ is not None else error


def status_of(error: Exception) -> tuple[str, str]:
    """Return the status and the message of a load that has no solution."""
    if isinstance(error, NotConverged):
        return error.solution.status.name, error.reason
    if isinstance(error, InputError):
        return "REFUSED", str(error)
    # The innermost part of the problem in whose method it was raised.
    for frame, _ in reversed(list(traceback.walk_tb(_met(error).__traceback__))):
        owner = frame.f_locals.get("self")
        for base, kind in _KINDS.items():
            if isinstance(owner, base):
                return "FAILED", name_exception(f"The {kind} {type(owner).__name__}", error)
    return "FAILED", name_exception("The solve", error)
