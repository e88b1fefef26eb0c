"""Claims about parts, those of several or all kinds, each written once, and the report on one part."""

from __future__ import annotations

import contextlib
import pickle
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
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
from roughcontact.testing.problems import ChangedContact

T = TypeVar("T")
Test: TypeAlias = Callable[..., str | float | None]
Cases: TypeAlias = Callable[[Any], Iterable[tuple[Any, ...]]]
_CLAIMS: dict[str, list[Claim]] = {}
# A function of the part and the arguments of a case that returns arrays or numbers.
Ask: TypeAlias = Callable[..., Iterable[Any]]


class DoesNotApply(Exception):
    """The claim does not apply to this part.

    Examples
    --------
    >>> from roughcontact import testing
    >>> def first(surface):
    ...     if not surface.parts:
    ...         raise testing.DoesNotApply("it has no parts")
    >>> import roughcontact as rc
    >>> print(testing.Claim("surface", "has parts", first).evaluate(rc.FlatSurface()))
    -  has parts: does not apply: it has no parts
    """


def require(condition: object, detail: str) -> None:
    """Raise `AssertionError` with a text unless the condition is true.

    Examples
    --------
    >>> from roughcontact import testing
    >>> testing.require(1 + 1 == 2, "one and one are not two")
    """
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
    """The result of one claim about one part.

    Examples
    --------
    >>> from roughcontact import testing
    >>> found = testing.Finding("symmetric", "holds", "to 1e-16")
    >>> print(found.passed, found)
    True holds  symmetric: to 1e-16
    """

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
    """A property that every part of one kind must have; `str` of it is its name.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact import testing
    >>> def lowest(surface):
    ...     heights = surface.heights(rc.Grid((8, 8), 1e-3))
    ...     testing.require(heights.min() >= 0.0, f"a height of {heights.min():.2g} m")
    >>> claim = testing.Claim("surface", "above the datum", lowest)
    >>> claim.evaluate(rc.FlatSurface()).verdict
    'holds'
    >>> print(claim.evaluate(rc.WavySurface(amplitude=1e-6, wavelength=1e-3)))
    BROKEN  above the datum: a height of -1.8e-06 m
    """

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
    """The results of all claims about one part; `str` of it is a table.

    Examples
    --------
    >>> from roughcontact import testing
    >>> found = testing.Finding("symmetric", "holds", "to 1e-16"), testing.Finding("finite", "BROKEN", "one is not")
    >>> report = testing.Report("mine", "kernel", found)
    >>> print(report.passed, report.failures[0])
    False BROKEN  finite: one is not
    """

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
    """Return the kind of a part, by its base class (see `claims`); `InputError` if it has none of them.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.testing import kind_of
    >>> kind_of(rc.Love())
    'kernel'
    """
    bases = {kind: registry.base for kind, registry in known_kinds().items()}
    for kind, base in bases.items():
        if isinstance(part, base):
            return kind
    allowed = f"an instance of one of {', '.join(base.__name__ for base in bases.values())}"
    hint = "Pass an instance, not the class." if isinstance(part, type) else ""
    raise InputError.about("The part to be checked", part, allowed, hint)


def check(part: object, kind: str | None = None) -> Report:
    """Return the results of all claims about a part, of the kind of its base class unless `kind` is given.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.testing import check
    >>> report = check(rc.Elastic(young=210e9, poisson=0.3))
    >>> report.raise_for_failures()
    """
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


def claim_repeatable(
    kind: str,
    cases: Cases | None,
    ask: Ask,
    disturb: Callable[..., object] = lambda *_: None,
    copy: Callable[[Any], Any] = lambda part: part,
    name: str = "repeatable",
) -> None:
    """Claim that a part gives the same bits a second time.

    `disturb` makes another call in between; `copy` returns the part that is called the second time.
    """

    @claim(kind, name, cases)
    def test(part: object, *case: Any) -> None:
        first = [np.asarray(values) for values in ask(part, *case)]
        kept = [values.copy() for values in first]
        disturb(part, *case)
        for values, before in zip(first, kept, strict=True):
            require_equal(values, before, "a later call changes the result of an earlier one")
            # A caller may write into the arrays; the part must not hand out its own memory.
            if values.flags.writeable:
                values[...] = 7.0
        second = list(ask(copy(part), *case))
        require(len(second) == len(kept), "a second call gives results of another kind")
        for values, before in zip(second, kept, strict=True):
            require_equal(values, before, "a second call gives another result")


def claim_input_unchanged(
    kind: str, cases: Cases, prepare: Callable[..., tuple[Mapping[str, Any], Callable[[], object]]]
) -> None:
    """Claim that a part does not write into its arguments: arrays by name, prepared with the call that takes them."""

    @claim(kind, "input unchanged", cases)
    def test(part: object, *case: Any) -> None:
        given, call = prepare(part, *case)
        kept = {name: values.copy() for name, values in given.items()}
        call()
        for name, values in given.items():
            require_equal(values, kept[name], f"it writes into the {name}")


def claim_powers_of_two(
    kind: str,
    cases: Cases,
    scale: Callable[..., Iterable[tuple[RealArray, RealArray]]],
    factors: Iterable[tuple[float, ...]],
    words: str,
    name: str = "powers of two change no bit",
) -> None:
    """Claim that powers of two as units change no bit: `scale` gives results in other units, and the expected ones."""

    @claim(kind, name, cases)
    def test(part: object, *case: Any) -> None:
        for chosen in factors:
            for found, expected in scale(part, *case, *chosen):
                require_equal(found, expected, words.format(*chosen))


def claim_invariant(
    kind: str,
    name: str,
    cases: Cases,
    ask: Ask,
    changes: Callable[..., Iterable[ChangedContact]],
    tolerance: float,
    detail: str,
) -> None:
    """Claim that the answer to a moved or scaled contact, moved or scaled back, is the answer to the contact."""

    @claim(kind, name, cases)
    def test(part: object, *case: Any) -> float | None:
        expected = np.asarray(ask(part, *case))
        return max(
            (
                require_close(changed.restore(np.asarray(ask(part, changed.solution))), expected, tolerance, detail)
                for changed in changes(part, *case)
            ),
            default=None,
        )


def read_numbers(result: object) -> list[RealArray]:
    """Return the numbers and arrays that a result is or holds as fields."""
    values = [result] if isinstance(result, (int, float, np.ndarray)) else read_fields(result)
    return [np.asarray(value) for value in values if isinstance(value, (int, float, np.ndarray))]


def read_fields(part: object) -> list[Any]:
    """Return the values of the fields of an object of attrs; none of others."""
    return [getattr(part, field.name) for field in getattr(type(part), "__attrs_attrs__", ())]


def require_array(values: RealArray, shape: tuple[int, ...]) -> None:
    """Raise `AssertionError` unless an array has the shape and float64 numbers."""
    require(values.shape == shape, f"an array of shape {values.shape} where {shape} is needed")
    require(values.dtype == np.float64, f"numbers of type {values.dtype} where float64 is needed")


def require_valid(result: Any) -> None:
    """Raise `AssertionError` unless numbers, uncertainty, warnings and text of a result are valid."""
    uncertainty = getattr(result, "uncertainty", 0.0)
    warnings = getattr(result, "warnings", ())
    require(np.all(np.asarray(uncertainty) >= 0.0), f"an uncertainty of {uncertainty}")
    valid = isinstance(warnings, tuple) and all(isinstance(text, str) and text for text in warnings)
    require(valid, f"`warnings` must be a tuple of sentences, not {warnings!r}")
    require(not any(np.isnan(values).any() for values in read_numbers(result)), "a number that is not a number")
    require(str(result).strip(), "its text is empty")
