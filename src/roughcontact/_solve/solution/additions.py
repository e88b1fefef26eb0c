"""What a physics adds to the state of a contact: arrays, numbers and conditions of the certificate."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import attrs

from roughcontact._base.archive.plain import Described, describe, rebuild
from roughcontact._base.arrays import Array, RealArray
from roughcontact._base.registry import Registry
from roughcontact._base.units import Estimate, ShownAsPrinted, si
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError


@attrs.frozen
class Condition(ShownAsPrinted):
    """One condition that a solved contact fulfils, and its residual, recomputed from the returned fields.

    Attributes
    ----------
    name
        Its name, such as ``"penetration"``.
    residual
        Its violation over a scale.
    meaning
        What the residual is, and over which scale, in words.
    judges
        Whether the residual is one of the `Certificate.error`.
    tolerance
        Of a condition that a law adds, the largest residual with which a state counts as solved; None: any.
    """

    name: str
    residual: float = attrs.field(converter=float)
    meaning: str
    judges: bool = True
    tolerance: float | None = None

    @property
    def holds(self) -> bool:
        """Whether the residual is within the tolerance."""
        return self.tolerance is None or self.residual <= self.tolerance

    def __str__(self) -> str:
        return f"{self.name} {self.residual:.1e}"


@attrs.frozen
class Certificate(ShownAsPrinted):
    """The conditions that a solved contact fulfils, each with its residual.

    Attributes
    ----------
    conditions
        Those of the normal contact, and those that friction adds.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> solution = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6)).solve(force=1.0)
    >>> [one.name for one in solution.certificate.conditions]
    ['complementarity', 'penetration', 'load']
    >>> solution.certificate.error < 1e-5
    True
    """

    conditions: tuple[Condition, ...]

    @property
    def error(self) -> float:
        """The maximum residual of the conditions that judge."""
        return max(one.residual for one in self.conditions if one.judges)

    def __getitem__(self, name: str) -> Condition:
        known = {one.name: one for one in self.conditions}
        if name not in known:
            raise InputError.unknown("condition of this contact", name, known)
        return known[name]

    def __str__(self) -> str:
        return ", ".join(map(str, self.conditions))


class Addition(abc.ABC):
    """What a physics adds to the state of a contact; the state prints, saves and judges it.

    A subclass is a frozen class of attrs whose fields are numbers, texts and arrays, or describes itself. It names its
    kind in files, which build the classes of the entry points ``roughcontact.additions`` alone.
    """

    kind: ClassVar[str]
    # Whether the problem of the state names what has added it.
    of_problem: ClassVar[bool] = False

    @property
    @abc.abstractmethod
    def conditions(self) -> tuple[Condition, ...]:
        """Its conditions of the certificate."""

    # What it has added to the gap before deformation, shape (nx, ny), m; None: nothing.
    offset: Array | None = None

    @property
    def marks(self) -> frozenset[str]:
        """What answers must hold with, `Response.holds_with`: by default its kind."""
        return frozenset({self.kind})

    @property
    def limits(self) -> Mapping[str, str]:
        """Why some responses do not hold, by what they do not know of it; see `Response.fails_with`."""
        return {}

    def list_errors(self, state: Any) -> dict[str, float]:
        """Return what it adds to the uncertainty of ``"area"`` and of responses, by registered name, in their unit."""
        return {}

    @property
    def default_area(self) -> str:
        """Registered name of the area estimator of the state, if the usual one does not hold; empty: it does."""
        return ""

    @property
    def follows(self) -> bool:
        """Whether the state follows from others, so that its load alone does not tell it."""
        return False

    def describe(self, arrays: dict[str, RealArray]) -> Described:
        """Return its fields as data for JSON, and put arrays into `arrays` under the digest of their content."""
        own: Any = self
        return describe(attrs.asdict(own, recurse=False), arrays)

    @classmethod
    def rebuild(cls, described: Mapping[str, Any], arrays: Mapping[str, RealArray], grid: Grid, given: Any) -> Addition:
        """Return what `describe` has described, on a grid; `given` is a part that a file need not name, or None."""
        return cls(**rebuild(described, arrays))

    def list_numbers(self, state: Any) -> dict[str, Estimate | tuple[Any, str]]:
        """Return its numbers by name, for data of a state: estimates, or a number or a list of them with its unit."""
        return {}

    def list_rows(self, state: Any) -> dict[str, str]:
        """Return its numbers in words by name, for texts and pages of a state."""
        pairs = self.list_numbers(state).items()
        return {
            name.replace("_", " "): str(one) if isinstance(one, Estimate) else si(one[0], one[1], 5)
            for name, one in pairs
        }

    def list_columns(self, state: Any) -> dict[str, Estimate | tuple[float, str]]:
        """Return its numbers by name, for a row of a table: estimates, or a number with its unit."""
        return self.list_numbers(state)

    def list_fields(self) -> dict[str, tuple[RealArray, str, str]]:
        """Return its fields of shape (nx, ny) by name, each with its meaning and unit."""
        return {}


additions: Registry[Addition] = Registry(Addition, "addition to a state", "roughcontact.additions")


def describe_additions(added: Sequence[Addition], arrays: dict[str, RealArray]) -> Described:
    """Return what physics have added to a state as data for JSON; see `Addition.describe`."""
    return {"mapping": {one.kind: one.describe(arrays) for one in added}}


def rebuild_additions(
    described: Mapping[str, Any], arrays: Mapping[str, RealArray], grid: Grid, given: Mapping[str, Any]
) -> tuple[Addition, ...]:
    """Return what `describe_additions` has described; `InputError` for a kind that is not registered."""
    stated = described["mapping"]
    return tuple(additions[kind].rebuild(one, arrays, grid, given.get(kind)) for kind, one in stated.items())
