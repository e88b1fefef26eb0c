"""One of n shares, for processes that know nothing of each other, as those of a job array."""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs

from roughcontact._base.archive.plain import key_of
from roughcontact._base.checks import integer
from roughcontact.errors import InputError

_WHAT = "One of n shares"
_ALLOWED = "k/n or (k, n), such as 3/64, with whole numbers 1 <= k <= n"


@attrs.frozen
class Share:
    """The k-th of n shares, into which the problems and seeds of a study are dealt.

    Attributes
    ----------
    number, count
        k, from 1 on, and n.
    """

    number: int
    count: int

    @classmethod
    def of(cls, value: object) -> Share:
        """Return what two numbers or a text such as ``"3/64"`` mean, or raise `InputError`."""
        try:
            number, count = (integer(one, _WHAT, at_least=1) for one in _numbers(value))
        except ValueError:
            raise InputError.about(_WHAT, value, _ALLOWED) from None
        if number > count:
            raise InputError.about(_WHAT, value, _ALLOWED)
        return cls(number, count)

    def size(self, total: int) -> int:
        """Return how many of `total` problems and seeds it has; shares differ by one at most."""
        return len(range(self.number - 1, total, self.count))

    def pick(self, places: Sequence[tuple[str, int | None]]) -> list[tuple[str, int | None]]:
        """Return its own problems and seeds, in the order in which they are given.

        They are dealt one by one in the order of their keys. The key of a name and a seed is a hash: so each share
        gets problems from all over the study, where dealing in the order of the study would give it the large or the
        small ones.
        """
        dealt = sorted(range(len(places)), key=lambda position: key_of(list(places[position])))
        return [places[position] for position in sorted(dealt[self.number - 1 :: self.count])]

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def _numbers(value: object) -> Sequence[object]:
    if isinstance(value, str):
        # Of a number with thousands of digits Python makes no int.
        found = re.fullmatch("([0-9]{1,9})/([0-9]{1,9})", value)
        return [int(text) for text in found.groups()] if found else []
    return value if isinstance(value, (tuple, list)) else []
