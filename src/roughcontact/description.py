"""Frozen objects as plain data and arrays, and back: what files keep and what keys are made from."""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Mapping
from enum import Enum
from typing import Any, TypeAlias

import attrs
import numpy as np

from roughcontact.checks import RealArray
from roughcontact.errors import InputError

Described: TypeAlias = Any
_PLAIN = (bool, int, float, str, type(None))


def describe(value: object, arrays: dict[str, RealArray]) -> Described:
    """Return a value as data that JSON can hold; arrays go into `arrays` under the digest of their content.

    Parameters
    ----------
    value
        Plain values, enumerations, arrays, lists, mappings, and instances of attrs classes made of them.
    arrays
        Receives the arrays.

    Raises
    ------
    InputError
        If it holds an object of another kind.
    """
    if isinstance(value, Enum):
        return describe(value.value, arrays)
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, _PLAIN):
        return value
    if isinstance(value, np.ndarray):
        name = _digest(value)
        arrays[name] = value
        return {"array": name}
    if isinstance(value, (list, tuple)):
        return [describe(item, arrays) for item in value]
    if isinstance(value, Mapping):
        return {"mapping": {str(key): describe(item, arrays) for key, item in value.items()}}
    fields = _fields(value)
    return {"class": _path(type(value)), "fields": {name: describe(item, arrays) for name, item in fields.items()}}


def rebuild(described: Described, arrays: Mapping[str, RealArray]) -> Any:
    """Return the value that `describe` described.

    Raises
    ------
    InputError
        If a class is not installed any more, or does not take what was kept.
    """
    if isinstance(described, list):
        return tuple(rebuild(item, arrays) for item in described)
    if not isinstance(described, dict):
        return described
    if "array" in described:
        if described["array"] not in arrays:
            raise InputError("An array that the description names is missing: it was cut short or changed by hand.")
        return arrays[described["array"]]
    if "mapping" in described:
        return {key: rebuild(item, arrays) for key, item in described["mapping"].items()}
    cls = _class(described["class"])
    fields = {name: rebuild(item, arrays) for name, item in described["fields"].items()}
    try:
        return cls(**fields)
    except TypeError as error:
        raise InputError(f"{described['class']} does not take what was kept for it: {error}.") from error


def key_of(value: object, *more: str) -> str:
    """Return a key that is the same for equal content, whoever computes it and whenever."""
    text = json.dumps([describe(value, {}), *more], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _fields(value: object) -> dict[str, object]:
    cls = type(value)
    if attrs.has(cls):
        return {str(field.alias): getattr(value, field.name) for field in attrs.fields(cls) if field.init}
    if not getattr(value, "__dict__", {"": 0}) and "<locals>" not in cls.__qualname__:
        # Without state the class is all there is.
        return {}
    raise InputError(
        f"{cls.__module__}.{cls.__qualname__} cannot be kept in a file: make it an attrs class at the top level of "
        "a module, so that its fields are known."
    )


def _path(cls: type) -> str:
    if "<locals>" in cls.__qualname__:
        raise InputError(f"{cls.__qualname__} cannot be kept in a file: define it at the top level of a module.")
    return f"{cls.__module__}:{cls.__qualname__}"


def _class(path: str) -> type:
    module, _, name = path.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError) as error:
        raise InputError(f"{path} is not installed here, or has moved: {error}.") from error
    if not isinstance(found, type):
        raise InputError(f"{path} is no class.")
    return found


def _digest(array: RealArray) -> str:
    head = f"{array.dtype.str}{array.shape}".encode()
    return hashlib.sha256(head + np.ascontiguousarray(array).tobytes()).hexdigest()[:32]
