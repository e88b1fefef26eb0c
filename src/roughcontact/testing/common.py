"""Claims about parts of every kind."""

from __future__ import annotations

import pickle
from typing import TypeVar

from roughcontact.checks import RealArray
from roughcontact.description import describe, key_of, rebuild
from roughcontact.testing.claim import Claim, require

T = TypeVar("T")


def pickled(part: T) -> T:
    """Return what comes back from a pickle of a part, as process pools send it."""
    try:
        copy: T = pickle.loads(pickle.dumps(part))
    # Pickling fails with errors of many types.
    except Exception as error:
        raise AssertionError(f"it cannot be pickled: {error}") from error
    return copy


def _pickles(part: object) -> str:
    copy = pickled(part)
    require(type(copy) is type(part), f"the pickle holds a {type(copy).__name__}")
    return "comes back from a pickle, as process pools need"


def _kept_in_files(part: object) -> str:
    """Describe and rebuild it, as saved solutions and studies do."""
    arrays: dict[str, RealArray] = {}
    copy = rebuild(describe(part, arrays), arrays)
    require(key_of(copy) == key_of(part), f"what comes back is {copy!r}")
    return "comes back from a file with the same fields"


def _equality(part: object) -> str:
    """Compare it with its copy: what is equal has one hash, so that it can be a key."""
    copy = pickled(part)
    require(part == part, "it is not equal to itself")
    try:
        hash(part)
    except TypeError as error:
        raise AssertionError(f"{error}: freeze it, or let it be equal to itself only") from error
    if copy == part:
        require(hash(copy) == hash(part), "its copy is equal, but has another hash")
        return "equal where its fields are equal"
    return "equal to itself only"


def common(kind: str) -> tuple[Claim, ...]:
    """Return the claims about parts of any kind."""
    return (
        Claim(kind, "pickles", _pickles),
        Claim(kind, "can be kept in files", _kept_in_files),
        Claim(kind, "hashes as it compares", _equality),
    )
