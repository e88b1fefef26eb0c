"""Claims about parts, the claims about parts of every kind, and the report on one part."""

from __future__ import annotations

import contextlib
import pickle
import textwrap
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeAlias, TypeVar

import attrs
import numpy as np

from roughcontact._base.archive.plain import describe, key_of, missing_classes, rebuild
from roughcontact._base.arrays import RealArray
from roughcontact._base.checks import choice
from roughcontact._base.registry import Registry, registries
from roughcontact._base.tables import Table
from roughcontact._base.units import parse_quantity
from roughcontact.errors import InputError
from roughcontact.plotting import panels

T = TypeVar("T")
Test: TypeAlias = Callable[..., str | float | None]
Cases: TypeAlias = Callable[[Any], Iterable[tuple[Any, ...]]]
_CLAIMS: dict[str, list[Claim]] = {}


class DoesNotApply(Exception):
    """The claim does not apply to this part."""


def require(condition: object, detail: str) -> None:
    """Raise `AssertionError` with a text unless the condition is true."""
    if not condition:
        raise AssertionError(detail)


def require_equal(values: object, expected: object, detail: str) -> None:
    """Raise `AssertionError` with a text unless two arrays are the same bits."""
    require(np.array_equal(values, expected, equal_nan=True), detail)  # type: ignore[arg-type]


def require_close(values: RealArray, expected: RealArray, tolerance: float, detail: str) -> float:
    """Return the difference of two arrays over the maximum of the second, which must be at most the tolerance."""
    error = float(np.abs(values - expected).max() / max(float(np.abs(expected).max()), 1e-300))
    require(error <= tolerance, f"{detail}, by {error:.1e}")
    return error


@attrs.frozen
class Finding:
    """The result of one claim about one part."""

    claim: str
    verdict: str
    """``"holds"``, ``"BROKEN"``, or ``"-"`` where it does not apply."""
    detail: str
    """The measured values, or why it is broken or does not apply; may be empty."""

    @property
    def passed(self) -> bool:
        """Whether the claim is not broken."""
        return self.verdict != "BROKEN"

    def __str__(self) -> str:
        return f"{self.verdict}  {self.claim}: {self.detail}"


@attrs.frozen
class Claim:
    """A property that every part of one kind must have; `str` of it is its name."""

    kind: str
    name: str
    test: Test = attrs.field(repr=False)
    """Function that takes a part and returns the measured values in words, if any, or raises `AssertionError`."""

    def evaluate(self, part: object) -> Finding:
        """Return the result for a part; nothing is raised."""
        try:
            # The findings name values that are not finite; numpy need not print warnings of them.
            with np.errstate(all="ignore"):
                return Finding(self.name, "holds", str(self.test(part) or ""))
        except DoesNotApply as reason:
            return Finding(self.name, "-", f"does not apply: {reason}")
        # A plug-in may fail with any error; the report continues with the next claim.
        except Exception as error:
            return Finding(self.name, "BROKEN", _reason(error))

    def check(self, part: object) -> None:
        """Raise `AssertionError` with the measured values if the claim is broken."""
        finding = self.evaluate(part)
        require(finding.passed, f"{part!r} breaks the claim {self.name!r}: {finding.detail}")

    def __str__(self) -> str:
        return self.name


@attrs.frozen
class Report:
    """The results of all claims about one part; `str` of it is a table."""

    part: str
    kind: str
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> bool:
        """Whether no claim is broken."""
        return not self.failures

    @property
    def failures(self) -> tuple[Finding, ...]:
        """The broken claims."""
        return tuple(finding for finding in self.findings if not finding.passed)

    def raise_for_failures(self) -> None:
        """Raise `AssertionError` that lists the broken claims, if there are any."""
        require(self.passed, "\n".join((self._headline(), *(f"  {finding}" for finding in self.failures))))

    def _headline(self) -> str:
        others = sum(finding.verdict == "-" for finding in self.findings)
        applied = len(self.findings) - others
        rest = f", {others} {'does' if others == 1 else 'do'} not apply" if others else ""
        return f"{self.kind} {self.part}: {applied - len(self.failures)} of {applied} claims hold{rest}"

    def __str__(self) -> str:
        names = ("verdict", "claim", "detail")
        rows = [(one.verdict, one.claim, one.detail) for one in self.findings]
        return "\n".join((self._headline(), Table.from_rows(names, rows, left=names).to_text(width=None)))


def claim(kind: str, name: str, cases: Cases | None = None) -> Callable[[Test], Test]:
    """Return a decorator that adds a function to the claims about a kind of part.

    With `cases` it is called for each case that these give for a part, a label and further arguments.
    """

    def add(test: Test) -> Test:
        _CLAIMS.setdefault(kind, []).append(Claim(kind, name, test if cases is None else _over_cases(test, cases)))
        return test

    return add


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, (AssertionError, InputError)) else f"raised {type(error).__name__}: {error}"


def _over_cases(test: Test, cases: Cases) -> Test:
    def repeated(part: object) -> str | None:
        measured = []
        for label, *arguments in cases(part):
            try:
                measured.append(test(part, *arguments))
            except DoesNotApply:
                raise
            except Exception as error:
                raise AssertionError(f"{label}: {_reason(error)}") from error
        numbers = [value for value in measured if isinstance(value, float)]
        return f"to {max(numbers):.0e}" if numbers else None

    return repeated


def known_kinds() -> dict[str, Registry[Any]]:
    """Return the registries of the kinds of parts about which there are claims."""
    found = {**registries(), panels.kind: panels}
    return {kind: found[kind] for kind in _CLAIMS}


def claims(kind: str) -> tuple[Claim, ...]:
    """Return the claims about every part of a kind, one of `KINDS`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> import roughcontact.testing as kit
    >>> [str(claim) for claim in kit.claims("kernel")][4:7]
    ['input unchanged', 'even in x and y', 'offsets and waves independent']
    >>> kit.claims("kernel")[5].check(rc.Love())
    """
    found = _CLAIMS[choice(kind, "The kind of part", tuple(_CLAIMS))]
    # A file may name no panel.
    shared = {name: test for name, test in _SHARED.items() if kind in registries() or test is not _can_be_saved}
    return (*found, *(Claim(kind, name, test) for name, test in shared.items()))


def kind_of(part: object) -> str:
    """Return the kind of a part, by its base class (see `claims`); `InputError` if it has none of them."""
    bases = {kind: registry.base for kind, registry in known_kinds().items()}
    for kind, base in bases.items():
        if isinstance(part, base):
            return kind
    allowed = f"an instance of one of {', '.join(base.__name__ for base in bases.values())}"
    hint = "Pass an instance, not the class." if isinstance(part, type) else ""
    raise InputError.about("The part to be checked", part, allowed, hint)


def check(part: object, kind: str | None = None) -> Report:
    """Return the results of all claims about a part, of the kind of its base class unless `kind` is given."""
    known = kind_of(part) if kind is None else kind
    name = textwrap.shorten(repr(part), 100, placeholder=" ...")
    return Report(name, known, tuple(claim.evaluate(part) for claim in claims(known)))


def pickled(part: T) -> T:
    """Return the copy of a part that a process pool would work with."""
    try:
        copy: T = pickle.loads(pickle.dumps(part))
    # Pickling fails with errors of many types.
    except Exception as error:
        raise AssertionError(f"it cannot be pickled: {error}") from error
    return copy


def _survives_pickling(part: object) -> None:
    copy = pickled(part)
    require(type(copy) is type(part), f"the pickle holds a {type(copy).__name__}")


def _can_be_saved(part: object) -> None:
    arrays: dict[str, RealArray] = {}
    described = describe(part, arrays)
    require("fields" in described, missing_classes(described))
    if missing_classes(described):
        raise DoesNotApply("its class is not registered, so that a file keeps the values of its fields alone")
    copy = rebuild(described, arrays)
    require(key_of(copy) == key_of(part), f"from a file it returns as {copy!r}")


def _hash_agrees(part: object) -> None:
    copy = pickled(part)
    require(part == part, "it is not equal to itself")
    try:
        hash(part)
    except TypeError as error:
        raise AssertionError(f"{error}: use attrs.frozen, or compare by identity") from error
    require(copy != part or hash(copy) == hash(part), "its copy is equal, but has another hash")


def _takes_texts(part: Any) -> None:
    """Claim that a number with a unit in the metadata of its field may be given as a text."""
    texts = {} if not attrs.has(type(part)) else dict(_list_texts(part))
    if not texts:
        raise DoesNotApply("none of its fields has a number with a unit in its metadata")
    for field, text in texts.items():
        copy = attrs.evolve(part, **{str(field.alias): text})
        found = getattr(copy, field.name)
        require(found == getattr(part, field.name), f"{field.alias}={text!r} becomes {found!r}")


def _list_texts(part: Any) -> Iterator[tuple[attrs.Attribute[Any], str]]:
    """Yield the fields that are numbers of a known unit, with their texts."""
    for field in attrs.fields(type(part)):
        unit = field.metadata.get("unit", field.metadata.get("plain_unit"))
        value = getattr(part, field.name)
        if field.init and unit is not None and isinstance(value, float):
            text = f"{value!r} {unit.partition(' or ')[0]}".rstrip()
            with contextlib.suppress(ValueError):
                parse_quantity(text, unit)
                yield field, text


_SHARED = {
    "takes texts with units": _takes_texts,
    "survives pickling": _survives_pickling,
    "can be saved": _can_be_saved,
    "hash agrees with equality": _hash_agrees,
}
