"""Problems built by a function, one for each combination of its parameters."""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, final

import attrs
import numpy as np

from roughcontact._base.checks import number
from roughcontact._solve.problem import ContactProblem
from roughcontact._work.studies.record import Record
from roughcontact.errors import InputError, RoughContactError, shorten
from roughcontact.errors.door import outside

# Columns of the tables of a study, which are not axes.
_COLUMNS = {*(one.name for one in attrs.fields(Record)), "area", "area_uncertainty", "estimator", "saturated_area"} - {
    "seed"
}
# Most values of an axis, and most problems of a study.
_MAX_VALUES = 100_000
# Most characters of an exception that a sentence repeats.
MAX_REASON_CHARACTERS = 300


@final
@attrs.frozen(eq=False)
class BuiltProblems(Mapping[str, ContactProblem]):
    """The problems that a function builds, by names such as ``"hurst=0.8, seed=3"``; each is built when it is taken.

    Attributes
    ----------
    build
        Returns the problem for one value of each parameter, given by name.
    axes
        The values of each parameter.
    """

    build: Callable[..., ContactProblem]
    axes: Mapping[str, tuple[Any, ...]]
    _points: Mapping[str, Mapping[str, Any]]

    @classmethod
    def over(
        cls, build: Callable[..., ContactProblem], axes: Mapping[str, object], arguments: Iterable[str]
    ) -> BuiltProblems:
        """Return the problems at all combinations of the values on the axes.

        Raises
        ------
        InputError
            If an axis is not a parameter of the function, has a reserved name or no list of different values, or a
            parameter without a default has no axis.
        """
        _require_parameters(build, axes, arguments)
        checked = {name: _axis(name, values) for name, values in axes.items()}
        count = math.prod(map(len, checked.values()))
        if count > _MAX_VALUES:
            raise InputError.about("The number of problems of a study", count, f"at most {_MAX_VALUES}")
        points = [dict(zip(checked, values, strict=True)) for values in itertools.product(*checked.values())]
        return cls(build, checked, {_name(point): point for point in points})

    @property
    def name(self) -> str:
        """Module and qualified name of the function, or of the class of a callable object."""
        own = getattr(self.build, "__qualname__", type(self.build).__qualname__)
        return f"{getattr(self.build, '__module__', '')}:{own}"

    def parameters(self, name: str) -> Mapping[str, Any]:
        """Return the value of each parameter of a problem."""
        return self._points[name]

    def __getitem__(self, name: str) -> ContactProblem:
        point = self.parameters(name)
        try:
            problem = outside(self.build)(**point)
        # A function of the user's may fail in any way.
        except Exception as error:
            own = str(error) if isinstance(error, RoughContactError) else f"{type(error).__name__}: {error}"
            reason = shorten(" ".join(own.split()).rstrip("."), MAX_REASON_CHARACTERS)
            raise InputError(f"The problem with {name} cannot be built: {reason}.") from error
        if not isinstance(problem, ContactProblem):
            raise InputError.about(f"What the function builds for {name}", problem, "a ContactProblem")
        return problem

    def __iter__(self) -> Iterator[str]:
        return iter(self._points)

    def __len__(self) -> int:
        return len(self._points)


def _name(point: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value}" for name, value in point.items()) or "problem"


def _require_parameters(build: Callable[..., object], axes: Mapping[str, object], arguments: Iterable[str]) -> None:
    """Raise `InputError` unless the function can be called with the axes by name."""
    try:
        parameters = inspect.signature(build).parameters
    # Functions written in C have no signature.
    except (ValueError, TypeError):
        return
    if taken := {*arguments, *_COLUMNS} & {*axes, *parameters}:
        name = min(taken)
        raise InputError(f"A study uses the name {name!r} itself: give the parameter of the function another one.")
    by_name = {
        name: one for name, one in parameters.items() if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
    }
    anything = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    for name in axes:
        if name not in by_name and not anything:
            raise InputError.unknown("parameter of the function, nor argument of Study,", name, {*by_name, *arguments})
    for name, one in parameters.items():
        if one.default is one.empty and name not in axes and one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD):
            raise InputError(f"The function needs a value of {name!r}: give a list of them, {name}=[...].")


def _axis(name: str, values: object) -> tuple[Any, ...]:
    what = f"The axis {name}= of a study"
    allowed = "a list of different numbers or texts"
    if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
        raise InputError.about(what, values, allowed, f"One value is {name}=[value].")
    try:
        items = list(itertools.islice(values, _MAX_VALUES + 1))
    except Exception:
        raise InputError.about(what, values, allowed) from None
    if not items or len(items) > _MAX_VALUES:
        raise InputError(f"{what} must have from 1 to {_MAX_VALUES} values.")
    checked = tuple(_value(item, f"A value of the axis {name}=") for item in items)
    if len({str(value) for value in checked}) < len(checked):
        raise InputError.about(what, values, allowed, "A value is given twice.")
    return checked


def _value(value: object, what: str) -> Any:
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, (bool, str)):
        return plain
    if isinstance(plain, float):
        return number(plain, what)
    if isinstance(plain, int):
        return plain
    raise InputError.about(what, value, "a number, a text, True or False", "Let the function make what else it needs.")
