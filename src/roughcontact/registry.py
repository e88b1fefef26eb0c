"""Registries: names for what can be plugged in, with one table behind two doors.

The doors are the decorator ``roughcontact.kernels.register("name")`` and the entry-point groups
``roughcontact.kernels``, ``roughcontact.convolvers``, ... of installed distributions. What ships
with the package comes through its own entry points, like anyone else's.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from roughcontact.errors import InputError

T = TypeVar("T", bound=type)


class Registry:
    """The names of one kind of plug-in.

    Parameters
    ----------
    kind
        What is registered, singular, for the error sentences.
    group
        Entry-point group that installed distributions use.

    Examples
    --------
    >>> import roughcontact as rc
    >>> "blend" in rc.areas.names()
    True
    >>> rc.areas.create("blend")
    Blend()
    >>> rc.areas.get("blnd")
    Traceback (most recent call last):
        ...
    roughcontact.errors.InputError: There is no area estimator named 'blnd'. Did you mean 'blend'? Known: ...
    """

    def __init__(self, kind: str, group: str) -> None:
        self.kind = kind
        self.group = group
        self._classes: dict[str, type] = {}
        self._installed: dict[str, list[EntryPoint]] | None = None

    def register(self, name: str) -> Callable[[T], T]:
        """Return a class decorator that enters the class under `name`.

        Raises
        ------
        InputError
            If the name is no non-empty string or is taken by another class.
        """
        if not isinstance(name, str) or not name:
            raise InputError.about(f"The name of a {self.kind}", name, "a non-empty string")

        def enter(cls: T) -> T:
            if not isinstance(cls, type):
                raise InputError.about(f"What is registered as a {self.kind}", cls, "a class")
            # A class defined again (a notebook cell run twice) replaces itself.
            owners = {entry.value for entry in self._entries().get(name, [])}
            if name in self._classes:
                owners.add(_path(self._classes[name]))
            if owners - {_path(cls)}:
                raise InputError(f"The name {name!r} of a {self.kind} is taken already by {', '.join(sorted(owners))}.")
            self._classes[name] = cls
            return cls

        return enter

    def names(self) -> tuple[str, ...]:
        """Return every name that `get` knows, sorted."""
        return tuple(sorted({*self._classes, *self._entries()}))

    def get(self, name: str) -> type:
        """Return the class registered under `name`.

        Raises
        ------
        InputError
            If nobody registered the name, two distributions claim it, or its plug-in cannot be loaded.
        """
        if name not in self._classes:
            self._classes[name] = self._load(name)
        return self._classes[name]

    def create(self, name: str) -> Any:
        """Return an instance of the class registered under `name`, made without arguments.

        Raises
        ------
        InputError
            If it cannot be made so.
        """
        cls = self.get(name)
        try:
            return cls()
        except InputError:
            raise
        except Exception as error:
            raise InputError(
                f"The {self.kind} {name!r} cannot be made without arguments ({error}): "
                f"pass an instance of {_path(cls)}."
            ) from error

    def resolve(self, choice: object, base: type) -> Any:
        """Return `choice` if it is an instance of `base`, or make one from the registered name.

        Raises
        ------
        InputError
            If it is neither.
        """
        made = self.create(choice) if isinstance(choice, str) else choice
        if isinstance(made, type) or not isinstance(made, base):
            hint = "Pass an instance, not the class." if isinstance(made, type) else ""
            raise InputError.about(f"The {self.kind}", choice, f"a registered name or {self.kind} object", hint)
        return made

    def _entries(self) -> dict[str, list[EntryPoint]]:
        if self._installed is None:
            found: dict[str, list[EntryPoint]] = {}
            for entry in entry_points(group=self.group):
                same = found.setdefault(entry.name, [])
                # One distribution may stand on the path twice, as source and as installed.
                if entry.value not in {other.value for other in same}:
                    same.append(entry)
            self._installed = found
        return self._installed

    def _load(self, name: str) -> type:
        claims = self._entries().get(name, [])
        if not claims:
            raise InputError(self._unknown(name))
        if len(claims) > 1:
            values = " and ".join(entry.value for entry in claims)
            raise InputError(f"The {self.kind} {name!r} is claimed by {values}; uninstall one of them.")
        try:
            loaded: type = claims[0].load()
        except Exception as error:
            raise InputError(
                f"The {self.kind} {name!r} is installed as {claims[0].value}, but cannot be loaded: "
                f"{type(error).__name__}: {error}"
            ) from error
        return loaded

    def _unknown(self, name: str) -> str:
        names = self.names()
        close = difflib.get_close_matches(name.lower(), names, n=1, cutoff=0.5)
        guess = f" Did you mean {close[0]!r}?" if close else ""
        return f"There is no {self.kind} named {name!r}.{guess} Known: {', '.join(names) or 'none'}."


def _path(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"


kernels = Registry("kernel", "roughcontact.kernels")
convolvers = Registry("convolver", "roughcontact.convolvers")
solvers = Registry("solver", "roughcontact.solvers")
areas = Registry("area estimator", "roughcontact.areas")
readers = Registry("surface reader", "roughcontact.readers")
sets = Registry("permanent set", "roughcontact.sets")
surfaces = Registry("surface", "roughcontact.surfaces")
materials = Registry("material", "roughcontact.materials")
