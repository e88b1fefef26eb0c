"""One load of a contact: a mean pressure, a force or an approach."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import attrs

from roughcontact._base.checks import number
from roughcontact._base.units import si
from roughcontact.errors import InputError

_LOAD_KINDS = {"pressure": ("The mean pressure", "Pa"), "force": ("The force", "N"), "approach": ("The approach", "m")}
# Note on several loads where the pressure has a limit.
FIRST_LOADING = "Each load is a first loading, of surfaces not flattened yet (see running in)."
_LOAD_ARGUMENTS = "pressure= (Pa), force= (N) and approach= (m)"


@attrs.frozen
class Load:
    """One load, as ``problem.solve(**load.arguments)`` takes it.

    Attributes
    ----------
    kind
        ``"pressure"``, the nominal mean pressure; ``"force"``, the normal force; or ``"approach"``, the
        approach since first touch.
    value
        Its value, Pa, N or m, above zero.
    """

    kind: str
    value: float

    @classmethod
    def of(cls, **given: object) -> Load:
        """Return the one load that is given by `pressure`, Pa, `force`, N, or `approach`, m; the others are None.

        Raises
        ------
        InputError
            If not exactly one is given, or it is not a number above zero.
        """
        kind, value = _the_one(given, f"Give exactly one of {_LOAD_ARGUMENTS}")
        name, unit = _LOAD_KINDS[kind]
        return cls(kind, number(value, name, unit, above=0.0))

    @classmethod
    def sequence(cls, **given: object) -> tuple[Load, ...]:
        """Return the loads of the one list that is given; see `Load.of`.

        Raises
        ------
        InputError
            If not exactly one list is given, it is empty, or a load in it is not a number above zero.
        """
        kind, values = _the_one(given, f"Give exactly one list of loads: {_LOAD_ARGUMENTS}")
        try:
            items = None if isinstance(values, (str, bytes)) or not isinstance(values, Iterable) else tuple(values)
        except Exception:
            items = None
        if items is None:
            raise InputError.about("The loads", values, f"a list, {kind}=[...]", "For one load call solve().")
        unit = _LOAD_KINDS[kind][1]
        loads = tuple(cls(kind, number(value, f"A load of {kind}=[...]", unit, above=0.0)) for value in items)
        if not loads:
            raise InputError(f"The list of loads, {kind}=, is empty: give at least one load.")
        return loads

    @property
    def arguments(self) -> dict[str, Any]:
        """The load as the keyword argument of `ContactProblem.solve`."""
        return {self.kind: self.value}

    def __str__(self) -> str:
        return f"{self.kind} {si(self.value, _LOAD_KINDS[self.kind][1])}"


def _the_one(given: dict[str, object], request: str) -> tuple[str, object]:
    named = {kind: value for kind, value in given.items() if value is not None}
    if len(named) != 1:
        raise InputError(f"{request}, but got {' and '.join(f'{kind}=' for kind in named) or 'none of them'}.")
    return next(iter(named.items()))
