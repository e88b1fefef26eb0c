"""Claims about parts of every kind."""

from __future__ import annotations

import pickle

from roughcontact.checks import RealArray
from roughcontact.description import describe, key_of, rebuild
from roughcontact.testing.claim import Claim, require


def _pickles(part: object) -> str:
    """Send it as process pools do."""
    copy = pickle.loads(pickle.dumps(part))
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
    copy = pickle.loads(pickle.dumps(part))
    require(hash(part) == hash(part) and part == part, "it is not equal to itself")
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
