"""Numbers with units and uncertainties, and warnings, written for people."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias, final

import attrs
import numpy as np

from roughcontact._base.units.quantities import EXAMPLES as EXAMPLES
from roughcontact._base.units.quantities import HasUnit as HasUnit
from roughcontact._base.units.quantities import has_unit as has_unit
from roughcontact._base.units.quantities import parse_quantity as parse_quantity
from roughcontact._base.units.quantities import quantity as quantity
from roughcontact._base.units.quantities import read_unit as read_unit
from roughcontact.errors import InputError, requiring
from roughcontact.errors.door import guarded
from roughcontact.errors.warning import Answer

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T", 15: "P"}
# Areas and volumes, whose prefix is raised to the power behind it; and units with another power or an inverse.
_AREA_OR_VOLUME = re.compile(r"m([23])\b(.*)")
_UNIT_WITH_POWER = re.compile(r"[^\W\d]+\d|1/")

# Decimals beyond which a number is written with an exponent.
_MAX_DECIMALS = 9
_SUPERSCRIPTS = {1: "", 2: "²", 3: "³"}
# A number, and the prefix of its unit.
_NUMBER_WITH_PREFIX = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?(?: [fpnµmkMGT]?(?=Pa|m|N))?")
# Width of what is printed, characters: that of a terminal as it opens, and of a page of mail or of a log.
WIDTH = 80
# Control characters, those that turn the direction of writing among them.
_CONTROL_CHARACTER = re.compile(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
# What stands before the text of a line: blanks, and a label with two blanks or more behind it.
_LINE_LABEL = re.compile(r"\s*(?:\S(?:\S| (?! ))*\s{2,})?")
# A blank behind a number, before a unit, and behind the sign of an uncertainty; and the blank that is not broken.
_UNBREAKABLE_BLANK = re.compile(r"(?<=\d) (?=%|[fpnµmkMGT]?(?:m[23]?|Pa|N|s)\b|\+- )|(?<=\+-) ")
_NO_BREAK = "\N{NO-BREAK SPACE}"
# A number in SI units, a text with a unit such as "210GPa", or a quantity of pint; the name says of what.
Quantity: TypeAlias = float | str | HasUnit
Length: TypeAlias = Quantity
Pressure: TypeAlias = Quantity
Force: TypeAlias = Quantity


@guarded
def si(value: float, unit: str, digits: int = 4) -> str:
    """Return a value with its unit, such as ``12.5 µm`` or ``360 µm2``, with `digits` significant digits."""
    if value == 0.0 or not math.isfinite(value) or not unit:
        return f"{value:.{digits}g} {unit}".rstrip()
    raised = _AREA_OR_VOLUME.match(unit)
    order = int(raised[1]) if raised else 1
    # Areas have 0.01 to 10000 of their unit and volumes 0.001 to a million, as people write them.
    shift = order if raised else 0
    power = 3 * math.floor((math.log10(abs(value)) + shift) / (3 * order) + 1e-9)
    if power not in _PREFIXES or (raised and power > 0) or (has_power(unit) and not raised):
        return f"{value:.{digits}g} {unit}"
    rounded = float(f"{value / 10.0 ** (order * power):.{digits}g}")
    return f"{rounded:.{max(digits, 3 * order)}g} {_PREFIXES[power]}{unit}"


def percent(fraction: float) -> str:
    """Return a fraction in percent to two digits, such as ``1.6 %``, from 100 on to all of them: no ``1e+02 %``."""
    return f"{100.0 * fraction:{'.0f' if 0.995 <= abs(fraction) < math.inf else '.2g'}} %"


def has_power(unit: str) -> bool:
    """Return whether a unit begins with a power or an inverse, such as ``m3/s``: a prefix would be misread."""
    return _UNIT_WITH_POWER.match(unit) is not None


def with_spread(value: float, uncertainty: float) -> str:
    """Return a number and its uncertainty, of two digits, such as ``(1.142 +- 0.012)``."""
    if not (uncertainty > 0.0 and math.isfinite(value) and math.isfinite(uncertainty)):
        return f"{value:.5g}"
    decimals = 1 - math.floor(math.log10(uncertainty))
    if abs(decimals) > _MAX_DECIMALS:
        digits = decimals + 1 + math.floor(math.log10(abs(value))) if value else 1
        return f"({value:.{max(1, digits)}g} +- {uncertainty:.2g})"
    # Zero has no sign.
    texts = (f"{round(number, decimals) + 0.0:.{max(0, decimals)}f}" for number in (value, uncertainty))
    return f"({' +- '.join(texts)})"


class PlainText(str):
    """A text that a notebook and the interpreter show as it prints, line by line."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class ShownAsPrinted:
    """A result that a notebook shows as it prints; its `repr` stays an expression with all digits."""

    __slots__ = ()

    def __init_subclass__(cls) -> None:
        # IPython takes the `repr` that a class defines itself before what it inherits.
        cls._repr_pretty_ = ShownAsPrinted._repr_pretty_  # type: ignore[method-assign]

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        for number, line in enumerate(str(self).split("\n")):
            if number:
                printer.break_()
            printer.text(line)


def prefixed(largest: float, unit: str, power: int = 1) -> tuple[float, str]:
    """Return the factor and the prefixed unit in which numbers up to `largest`, in ``unit**power``, are written.

    An area has the unit ``"m"`` and the power 2.
    """
    thousands = 0
    if 0.0 < largest < math.inf:
        # As `si` has them: an area of 0.5 µm² is not 500000 nm².
        shift = power if power > 1 else 0
        thousands = 3 * math.floor((math.log10(largest) + shift) / (3 * power) + 1e-9)
    exponent = min(max(thousands, min(_PREFIXES)), max(_PREFIXES) if power == 1 else 0)
    return 10.0 ** (-exponent * power), f"{_PREFIXES[exponent]}{unit}{_SUPERSCRIPTS[power]}"


@guarded
def binary(size: float) -> str:
    """Return a number of bytes as text, such as ``1.5 GiB``."""
    power = min(max(0, int(size).bit_length() - 1) // 10, 4)
    return f"{size / 2 ** (10 * power):.4g} {('bytes', 'KiB', 'MiB', 'GiB', 'TiB')[power]}"


def counted(count: int, what: str) -> str:
    """Return a number of things as text: ``1 load``, ``2 loads``."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def outlined(value: Any) -> str:
    """Return a field of a result for its `repr`: an array as ``<8 x 8 float64>``."""
    if isinstance(value, np.ndarray):
        return f"<{' x '.join(map(str, value.shape))} {value.dtype}>" if value.ndim else repr(value.item())
    return repr(value)


class WarningText(str):
    """Why a number or a contact must not be trusted, in a sentence that suits every reader.

    Parameters
    ----------
    text
        What was found, and what to do about it.
    rule
        Name of the rule that found it, such as ``"resolution"`` or ``"tilt"``.
    value
        The number that broke it, in the unit of the rule; nan where there is none.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights = rc.SphereSurface(radius=1e-3).heights(rc.Grid((32, 32), 100e-6))
    >>> problem = rc.ContactProblem(rc.Body(rc.HeightMap(heights, size=100e-6), rc.Elastic(210e9, 0.3)))
    >>> for warning in problem.solve(force=60.0).warnings:
    ...     print(warning.rule, f"{warning.value:.2f}")
    edge contact 1.00
    """

    rule: str
    value: float

    def __new__(cls, text: str, rule: str = "", value: float = math.nan) -> WarningText:
        made = super().__new__(cls, text)
        made.rule = rule
        made.value = value
        return made

    def __getnewargs__(self) -> tuple[str, str, float]:  # type: ignore[override]
        return str(self), self.rule, self.value


class WorkText(PlainText):
    """What a part of a solve takes, in words: a text that knows its memory and its time.

    Attributes
    ----------
    memory
        Bytes beside those of the contact; nan where that is not known.
    seconds
        Time beside that of the contact, s; nan where that is not known.
    """

    memory: float
    seconds: float

    def __new__(cls, text: str, memory: float = math.nan, seconds: float = math.nan) -> WorkText:
        made = super().__new__(cls, text)
        made.memory = memory
        made.seconds = seconds
        return made

    def __getnewargs__(self) -> tuple[str, float, float]:  # type: ignore[override]
        return str(self), self.memory, self.seconds


def warn_about(name: str, warning: str) -> WarningText:
    """Return the warning of an estimate with the name of the quantity, such as the contact area."""
    value: float = getattr(warning, "value", math.nan)
    return WarningText(f"The {name} is uncertain: {warning}", f"{name}: {kind_of(warning)}", value)


def kind_of(warning: str) -> str:
    """Return the rule of a warning; of a plain text, from a file or a plug-in, the text without its numbers."""
    return getattr(warning, "rule", "") or _NUMBER_WITH_PREFIX.sub("#", warning)


@final
class Deferred:
    """A number, or None, that is found when it is first read, and in pickles and copies."""

    __slots__ = ("_find", "_found")

    def __init__(self, find: Callable[[], float | None]) -> None:
        self._find: Callable[[], float | None] | None = find
        self._found: float | None = None

    def read(self) -> float | None:
        """Return the number."""
        find = self._find
        if find is not None:
            self._found = find()
            # What the number is found from is not held any longer.
            self._find = None
        return self._found

    def __reduce__(self) -> tuple[Callable[[float | None], Deferred], tuple[float | None]]:
        return _hold, (self.read(),)


def _hold(found: float | None) -> Deferred:
    return Deferred(lambda: found)


@attrs.frozen
class Estimate(ShownAsPrinted, Answer):
    """A number with its uncertainty.

    It is scaled by numbers, and added to and subtracted from numbers in its unit, which are taken as exact, and others
    of its unit. How the errors of two answers are correlated is not known: those of one solution, or of solutions on
    one grid, have the same cells and heights. The uncertainty of a sum or a difference is therefore the sum of the
    uncertainties, which bounds it whatever the correlation: the standard deviation of a sum is at most the sum of the
    standard deviations, and exactly that where both errors grow together. Products and quotients of two are refused;
    for errors that are known to be independent use `to_ufloat`.

    A format is that of a number, for value and uncertainty in the SI unit: ``f"{estimate:.3e}"``.

    Attributes
    ----------
    value
        The number, in the unit.
    uncertainty
        One standard deviation: the true value should lie within two of them.
    unit
        SI unit; empty for a count.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    sampling
        Standard deviation between places of the same rough surface, of this size: the mean of many places should lie
        within two of them, another place within three. Changes over lengths beyond the side of the map do not show in
        it. None where there is no such surface, or it is not known. It is found when it is first read; until then the
        answer of a contact of at most 65,536 cells holds its heights and pressures.

    Examples
    --------
    >>> import roughcontact as rc
    >>> stiffness = rc.Estimate(12.3e6, 0.2e6, "N/m")
    >>> print(stiffness)
    12.3 MN/m +- 1.6 %
    >>> print(2 * stiffness, stiffness + stiffness, f"{stiffness:.2e}", sep="; ")
    24.6 MN/m +- 1.6 %; 24.6 MN/m +- 1.6 %; (1.23e+07 +- 2.00e+05) N/m
    """

    # Numbers of numpy leave the operations to this class.
    __array_ufunc__ = None

    value: float
    uncertainty: float
    unit: str
    warnings: tuple[str, ...] = ()
    # Over the value.
    _relative_sampling: float | Deferred | None = attrs.field(default=None, kw_only=True, eq=False, repr=False)

    @property
    def sampling(self) -> float | None:
        """Standard deviation between places, in the unit of the value."""
        relative = self._relative_sampling
        if isinstance(relative, Deferred):
            relative = relative.read()
        return None if relative is None else abs(self.value) * relative

    @property
    def _reasons(self) -> str:
        """Why the value must not be trusted, at the end of a line."""
        return "".join(f"; uncertain: {warning}" for warning in self.warnings)

    def __mul__(self, factor: float) -> Estimate:
        factor = self._read_number(factor, "multiplied by", "a number")
        return Estimate(
            self.value * factor,
            self.uncertainty * abs(factor),
            self.unit,
            self.warnings,
            relative_sampling=self._relative_sampling,
        )

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Estimate:
        divisor = self._read_number(divisor, "divided by", "a number other than 0")
        if divisor == 0.0:
            raise InputError.about("What an estimate is divided by", divisor, "a number other than 0")
        return Estimate(
            self.value / divisor,
            self.uncertainty / abs(divisor),
            self.unit,
            self.warnings,
            relative_sampling=self._relative_sampling,
        )

    def __neg__(self) -> Estimate:
        return self * -1.0

    def __add__(self, other: float | Estimate) -> Estimate:
        if not isinstance(other, Estimate):
            exact = self._read_number(other, "added to", f"a number or an estimate ({self.unit or 'no unit'})")
            other = Estimate(exact, 0.0, self.unit, relative_sampling=0.0)
        if other.unit != self.unit:
            units = " and ".join(repr(one) if one else "no unit" for one in (self.unit, other.unit))
            raise InputError(f"Estimates of different units cannot be added: {units}.")
        total = self.value + other.value
        parts = (self, other)

        def find_sampling() -> float | None:
            spreads = [one.sampling for one in parts]
            known = [spread for spread in spreads if spread is not None]
            return sum(known) / abs(total) if len(known) == len(parts) and total else None

        return Estimate(
            total,
            self.uncertainty + other.uncertainty,
            self.unit,
            tuple(dict.fromkeys((*self.warnings, *other.warnings))),
            relative_sampling=Deferred(find_sampling),
        )

    __radd__ = __add__

    def __sub__(self, other: float | Estimate) -> Estimate:
        return self + (-other)

    def __rsub__(self, other: float) -> Estimate:
        return -self + other

    def _read_number(self, value: object, how: str, allowed: str) -> float:
        if isinstance(value, Estimate):
            raise InputError(
                f"An estimate cannot be {how} another one: how their errors are correlated is not known. If they are "
                "independent, to_ufloat() of each gives numbers of the package uncertainties."
            )
        is_number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value):  # type: ignore[arg-type]
            raise InputError.about(f"What an estimate is {how}", value, allowed)
        return float(value)  # type: ignore[arg-type]

    def to_ufloat(self) -> Any:
        """Return a number of the package uncertainties, in the SI unit: independent of all others.

        Raises
        ------
        MissingPackage
            If the package is not installed.

        Examples
        --------
        >>> import roughcontact as rc
        >>> rc.Estimate(12.0, 0.5, "N").to_ufloat()  # doctest: +SKIP
        12.0+/-0.5
        """
        with requiring("Numbers of uncertainties need that package: pip install 'roughcontact[uncertainties]'."):
            import uncertainties
        return uncertainties.ufloat(self.value, self.uncertainty)

    def __format__(self, spec: str) -> str:
        if not spec:
            return str(self)
        try:
            texts = [format(number, spec) for number in (self.value, self.uncertainty)]
        except ValueError as error:
            raise InputError.about("The format of an estimate", spec, "that of a number, such as '.3g'") from error
        return f"({' +- '.join(texts)}) {self.unit}".rstrip()

    def __str__(self) -> str:
        if not self.unit:
            return f"{self.value:.{self._count_digits(6)}g} +- {self.uncertainty:.2g}{self._reasons}"
        if math.isinf(self.value):
            return f"{si(self.value, self.unit)}{self._reasons}"
        spread = percent(self.uncertainty / abs(self.value)) if self.value else si(self.uncertainty, self.unit)
        return f"{si(self.value, self.unit, self._count_digits(5))} +- {spread}{self._reasons}"

    def _count_digits(self, most: int) -> int:
        """Return the significant digits that the first two of the uncertainty allow, from two to so many."""
        if not (self.value and math.isfinite(self.value) and 0.0 < self.uncertainty < math.inf):
            return most
        digits = math.floor(math.log10(abs(self.value))) - math.floor(math.log10(self.uncertainty)) + 2
        return min(most, max(2, digits))


def without_reasons(text: str, estimates: Iterable[Estimate]) -> str:
    """Return a text that holds estimates without their warnings, which are said elsewhere."""
    for one in estimates:
        text = text.replace(one._reasons, "")
    return text


@guarded
def write_column(column: Sequence[Estimate]) -> list[str]:
    """Return the texts of values of one quantity, all in the unit that suits the middle of their range."""
    numbers, unit = scale_column(column)
    return [f"{number} {unit}".strip() for number in numbers]


def scale_column(column: Sequence[Estimate]) -> tuple[list[str], str]:
    """Return the numbers of `write_column` without their unit, and the unit."""
    unit = column[0].unit
    raised = _AREA_OR_VOLUME.fullmatch(unit)
    base, power, rest = ("m", int(raised[1]), raised[2]) if raised else (unit, 1, "")
    sizes = [size for one in column if 0.0 < (size := max(abs(one.value), one.uncertainty)) < math.inf]
    middle = math.sqrt(min(sizes)) * math.sqrt(max(sizes)) if sizes else 0.0
    # A prefix before 1/m would be read as one inside the power.
    factor, unit = (1.0, base) if not base or has_power(base) else prefixed(middle, base, power)
    return [_write(one, factor) for one in column], f"{unit}{rest}"


def _write(one: Estimate, factor: float) -> str:
    if math.isnan(one.value):
        return "-"
    if not one.uncertainty:
        return f"{one.value * factor:.6g}"
    return with_spread(one.value * factor, one.uncertainty * factor).strip("()").replace("+-", "±")


def printable(text: str) -> str:
    """Return a text with its control characters, such as escape, written as in Python's source."""
    return _CONTROL_CHARACTER.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def fit(text: str) -> str:
    """Return a text with long lines wrapped, and continued below their own text."""
    lines = []
    for line in text.split("\n"):
        if len(line) <= WIDTH:
            lines.append(line)
            continue
        label = _LINE_LABEL.match(line)
        indent = " " * min(label.end() if label else 0, WIDTH // 2)
        # Neither a path nor the name of an option is broken, nor a number from its unit or its uncertainty.
        kept = _UNBREAKABLE_BLANK.sub(_NO_BREAK, line)
        lines += textwrap.wrap(kept, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines).replace(_NO_BREAK, " ")
