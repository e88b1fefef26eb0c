"""What friction adds to the state of a contact: tractions, stick and slip, the energy lost, and their certificate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, final

import attrs
import numpy as np

from roughcontact._base.archive import digest_of
from roughcontact._base.archive.plain import Described, describe, rebuild
from roughcontact._base.arrays import Array, Mask, Pair, RealArray, read_only
from roughcontact._base.units import Estimate, si
from roughcontact._parts.grid import Grid, extend
from roughcontact._parts.interactions import FrictionLaw, shear_limit
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.solution.additions import Addition, Condition
from roughcontact._solve.solution.fields import ContactFields
from roughcontact.errors import InputError, NoSuchField

# Traction over the shear strength from which a cell counts as slipping: it moves the edge of the stick zone by less
# than a cell, as the uncertainty of its area does.
_SLIPPING_FRACTION = 1.0 - 1e-3
# Area that slips of a ball under a small tangential force, over that of its contact and the force over that of sliding:
# its stick zone is (1 - Q / mu P)^(2/3) of the contact (Cattaneo, Mindlin).
_SLIP_OF_BALL = 2.0 / 3.0
# Component over the larger one that is printed as zero.
_ROUNDING = 1e-8
# Digits of an angle in degrees that rounding leaves.
_ANGLE_DIGITS = 10
_COUNTS = ("passes", "iterations", "increments")
_RESIDUALS = {
    "shear_load": ("tangential load", "error of the tangential force over the force of sliding, or of a displacement"),
    "cone": ("cone", "largest excess of the traction over the shear strength, over its maximum"),
    "slip": ("slip", "largest traction by which a cell breaks the law of friction, over the maximum strength"),
    "dissipation": ("dissipation", "energy gained by slip, over that which the strengths could lose"),
    "energy": ("energy", "error of the balance of elastic energy and work, over its largest term"),
}
# Conditions that a certificate states and that do not judge it: they follow from the others.
_FOLLOWING = ("shear_load", "dissipation", "energy")


@attrs.frozen(eq=False, kw_only=True)
class FrictionalState:
    """What the next step of a path knows of the one before: no slip is stored, it follows.

    Attributes
    ----------
    pressure
        Contact pressure, shape (nx, ny), Pa.
    shear
        Traction on the body, shape (2, nx, ny), Pa.
    displacement
        Tangential displacement of the counterbody (x, y), m.
    approach
        Approach since first touch, m.
    """

    pressure: Array = attrs.field(converter=read_only)
    shear: Array = attrs.field(converter=read_only)
    displacement: Pair
    approach: float

    @classmethod
    def unloaded(cls, shape: tuple[int, int]) -> FrictionalState:
        """Return the state of bodies that just touch."""
        return cls(pressure=np.zeros(shape), shear=np.zeros((2, *shape)), displacement=(0.0, 0.0), approach=0.0)

    @cached_property
    def digest(self) -> str:
        """Hexadecimal digits that identify the state by its values."""
        numbers = np.array([*self.displacement, self.approach])
        names = [digest_of(one) for one in (self.pressure, self.shear, numbers)]
        return digest_of(np.array(names))


@attrs.frozen
class TangentialLoad:
    """What is given along the surface in one step.

    Attributes
    ----------
    kind
        ``"tangential_force"``, N; ``"displacement"``, m; or ``"direction"`` of steady sliding, a unit vector.
    values
        Components along x and y.
    """

    kind: str
    values: Pair

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return {"tangential_force": "N", "displacement": "m"}.get(self.kind, "")

    @property
    def is_steady(self) -> bool:
        """Whether the bodies slide steadily."""
        return self.kind == "direction"

    @property
    def angle(self) -> float:
        """Direction from x towards y, degrees."""
        x, y = self.values
        return round(math.degrees(math.atan2(y, x)), _ANGLE_DIGITS)

    def __str__(self) -> str:
        return f"({', '.join(si(value, self.unit) for value in self.values)})"


@attrs.frozen
class FrictionalResiduals:
    """The violations of the conditions of friction, recomputed in float64 from two states in a row.

    Attributes
    ----------
    shear_load
        Error of the tangential force over the sum of the shear strengths, or of a given displacement over the range of
        the initial gap.
    cone
        Maximum excess of the traction over the shear strength, over the maximum of the strength.
    slip
        Maximum over all cells of :math:`|q - P_s(q + w/k)|`, over the maximum of the strength s: zero if and only if
        cells below their strength do not slip, and the others slip along their traction. The slip is w, k the
        displacement of a cell by its own traction, and P the nearest traction within the strength.
    dissipation
        Energy gained by slip, which must lose energy, over k times the maximum times the sum of the strengths.
    energy
        Error of the balance of elastic energy and work in the last increment, over the largest of its terms.
    """

    shear_load: float = attrs.field(converter=float)
    cone: float = attrs.field(converter=float)
    slip: float = attrs.field(converter=float)
    dissipation: float = attrs.field(converter=float)
    energy: float = attrs.field(converter=float)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Them as conditions of a certificate."""
        return tuple(
            Condition(name, getattr(self, field), meaning, judges=field not in _FOLLOWING)
            for field, (name, meaning) in _RESIDUALS.items()
        )


@final
@attrs.frozen(eq=False, kw_only=True)
class Sheared(Addition):
    """What friction adds to a contact at the end of one step of a path, or in steady sliding.

    All signs are those of the traction on the body: the counterbody is pushed over the body along the tangential
    force, and moves by the displacement; slip is that of the counterbody's surface relative to the body's.

    Attributes
    ----------
    traction
        Traction on the body, shape (2, nx, ny), Pa.
    displacement
        Displacement (x, y) of the counterbody relative to the body since the first touch, far from the contact, m: on
        a periodic boundary what the contact adds. In steady sliding it is not determined, and nan.
    slip
        Slip in this step, shape (2, nx, ny), m, of cells that do not touch too; in steady sliding per distance.
    friction
        The friction law.
    given
        The tangential load.
    pair
        The pair of materials.
    before
        The state at the begin of the last increment of the step.
    dissipated
        Energy that friction has lost in this step, J; in steady sliding per distance, J/m. Its uncertainty is that of
        the increments and of the cells.
    elastic_energy
        Energy stored in both bodies, J.
    residuals
        Violations of the conditions of friction.
    passes, iterations, increments
        Alternations of normal and tangential solves, iterations of the tangential ones, increments of the step.
    """

    kind = "shear"

    traction: Array = attrs.field(converter=read_only)
    displacement: Pair
    slip: Array = attrs.field(converter=read_only)
    friction: FrictionLaw
    given: TangentialLoad
    pair: PairConstants
    before: FrictionalState
    dissipated: Estimate
    elastic_energy: float
    residuals: FrictionalResiduals
    passes: int
    iterations: int
    increments: int = 1

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The conditions of friction."""
        return self.residuals.conditions

    @property
    def follows(self) -> bool:
        """Whether it is a state of a path."""
        return not self.given.is_steady

    def list_rows(self, state: Any) -> dict[str, str]:
        """Return tangential force, displacement, areas and energy in words, by their names."""
        pushed = _write_pair(state.tangential_force, "N")
        moved = _write_pair(self.displacement, "m")
        areas = (
            f"{si(one.value, 'm2', 5)} +- {si(one.uncertainty, 'm2', 2)}" for one in (state.stick_area, state.slip_area)
        )
        return {
            "tangential force": f"{pushed} (x, y)",
            "displacement": "steady sliding" if self.given.is_steady else f"{moved} (x, y)",
            **dict(zip(("area that sticks", "area that slips"), areas, strict=True)),
            "energy lost": str(self.dissipated),
            "friction": repr(self.friction),
        }

    def list_numbers(self, state: Any) -> dict[str, Estimate | tuple[Any, str]]:
        """Return force, displacement, areas and energies."""
        return {
            "tangential_force": (list(state.tangential_force), "N"),
            "tangential_displacement": (list(self.displacement), "m"),
            "stick_area": state.stick_area,
            "slip_area": state.slip_area,
            "dissipated": self.dissipated,
            "elastic_energy": (self.elastic_energy, "J"),
        }

    def list_columns(self, state: Any) -> dict[str, Estimate | tuple[float, str]]:
        """Return the components of the force, and the energy lost."""
        x, y = state.tangential_force
        return {"tangential_x": (x, "N"), "tangential_y": (y, "N"), "dissipated": self.dissipated}

    def list_fields(self) -> dict[str, tuple[RealArray, str, str]]:
        """Return the components of traction and slip."""
        distance = "" if self.given.is_steady else "m"
        found: dict[str, tuple[RealArray, str, str]] = {}
        for k, axis in enumerate("xy"):
            found[f"shear_{axis}"] = self.traction[k], f"traction on the body along {axis}", "Pa"
            found[f"slip_{axis}"] = self.slip[k], f"slip along {axis}", distance
        return found

    def describe(self, arrays: dict[str, RealArray]) -> Described:
        """Return it as data for JSON; see `Addition.describe`."""
        plain = ("displacement", "elastic_energy", *_COUNTS)
        tables = ("given", "pair", "dissipated", "residuals")
        return {
            **{name: describe(getattr(self, name), arrays) for name in ("traction", "slip", "friction", *plain)},
            **{name: describe(attrs.asdict(getattr(self, name)), arrays) for name in tables},
            "before": {
                **describe(attrs.asdict(self.before), arrays)["mapping"],
                "digest": self.before.digest,
            },
        }

    def __reduce__(self) -> tuple[Any, ...]:
        # Arrays in pickles and deep copies are writable: the constructor makes them read-only again.
        return _restore, (attrs.asdict(self, recurse=False),)

    @classmethod
    def rebuild(cls, described: Mapping[str, Any], arrays: Mapping[str, RealArray], grid: Grid, given: Any) -> Sheared:
        """Return what `describe` has described, with a friction law instead of the one in the file if it is given."""
        known = {name: rebuild(one, arrays) for name, one in described.items() if name not in ("friction", "before")}
        start = {name: rebuild(one, arrays) for name, one in described["before"].items()}
        before = FrictionalState(
            pressure=_field(start["pressure"], grid.shape),
            shear=_field(start["shear"], (2, *grid.shape)),
            displacement=_pair(start["displacement"]),
            approach=float(start["approach"]),
        )
        if before.digest != start["digest"]:
            raise InputError("A state is not the one that it is named after.")
        return cls(
            traction=_field(known["traction"], (2, *grid.shape)),
            slip=_field(known["slip"], (2, *grid.shape)),
            displacement=_pair(known["displacement"]),
            friction=given or rebuild(described["friction"], arrays, (FrictionLaw,)),
            given=TangentialLoad(str(known["given"]["kind"]), _pair(known["given"]["values"])),
            pair=PairConstants(**known["pair"]),
            before=before,
            dissipated=read_estimate(known["dissipated"]),
            elastic_energy=float(known["elastic_energy"]),
            residuals=FrictionalResiduals(**known["residuals"]),
            **{name: int(known[name]) for name in _COUNTS},
        )


def _restore(fields: dict[str, Any]) -> Sheared:
    return Sheared(**fields)


def _write_pair(values: Pair, unit: str) -> str:
    largest = max(map(abs, values))
    return " and ".join(si(value if abs(value) > _ROUNDING * largest else 0.0, unit, 5) for value in values)


def read_estimate(stored: Mapping[str, Any]) -> Estimate:
    """Return an estimate from its fields in a file."""
    warnings = tuple(str(text) for text in stored["warnings"])
    return Estimate(float(stored["value"]), float(stored["uncertainty"]), str(stored["unit"]), warnings)


def _pair(values: Any) -> Pair:
    x, y = (float(value) for value in values)
    return x, y


def _field(values: Any, shape: tuple[int, ...]) -> RealArray:
    if not isinstance(values, np.ndarray) or values.shape != shape or values.dtype != np.float64:
        raise InputError(f"It has no array of numbers of shape {shape} where one is needed.")
    if not np.isfinite(values).all():
        raise InputError(f"It has an array of shape {shape} with values that are not finite.")
    return values


@attrs.frozen(eq=False, kw_only=True)
class ShearFields(ContactFields):
    """The fields that friction adds to a solved contact; `NoSuchField` where it was solved without."""

    _public_name: ClassVar[str] = "ContactSolution"

    @cached_property
    def _sheared(self) -> Sheared | None:
        return self._find_added(Sheared)

    @property
    def sheared(self) -> Sheared:
        """What friction adds: law, tangential load, residuals, cost, and the state before."""
        if self._sheared is None:
            raise NoSuchField("The contact was solved without friction: call problem.path(...) or problem.slide(...).")
        return self._sheared

    @property
    def shear(self) -> Array | None:
        """Traction on the body, shape (2, nx, ny), Pa; None without friction."""
        return None if self._sheared is None else self._sheared.traction

    @property
    def slip(self) -> Array:
        """Slip in this step, shape (2, nx, ny), m; in steady sliding per distance."""
        return self.sheared.slip

    @property
    def friction(self) -> FrictionLaw:
        """The friction law."""
        return self.sheared.friction

    @property
    def tangential_load(self) -> TangentialLoad:
        """What is given along the surface."""
        return self.sheared.given

    @property
    def tangential_displacement(self) -> Pair:
        """Displacement (x, y) of the counterbody relative to the body, far from the contact, m; nan in sliding."""
        return self.sheared.displacement

    @property
    def tangential_force(self) -> Pair:
        """Force (x, y) by which the counterbody is pushed over the body, N."""
        x, y = (float(part.sum()) * self.grid.cell_area for part in self.sheared.traction)
        return x, y

    @property
    def dissipated(self) -> Estimate:
        """Energy that friction has lost in this step, J; in steady sliding per distance, J/m."""
        return self.sheared.dissipated

    @property
    def elastic_energy(self) -> float:
        """Energy stored in both bodies, J."""
        return self.sheared.elastic_energy

    @cached_property
    def shear_strength(self) -> Array:
        """Shear strength of each cell by the friction law, shape (nx, ny), Pa."""
        return read_only(shear_limit(self.friction, self.pressure))

    @cached_property
    def stick(self) -> Mask:
        """Cells in contact that stick, whose traction is below 99.9 % of the strength, shape (nx, ny)."""
        size = np.hypot(*self.sheared.traction)
        return read_only(self.contact & (size < _SLIPPING_FRACTION * self.shear_strength))

    @property
    def slipping(self) -> Mask:
        """Cells in contact that slip, shape (nx, ny)."""
        return read_only(self.contact & ~self.stick)

    @property
    def stick_area(self) -> Estimate:
        """Area that sticks, m2: its uncertainty is half a ring of cells along the edge between stick and slip.

        Where the edge of the contact sticks it is that of the real contact area, and of slip that no cell sees.
        """
        return self._keep("stick area", lambda: _find_stick_area(self))

    @property
    def slip_area(self) -> Estimate:
        """Area that slips, m2: the real contact area less that which sticks, with the uncertainties of both."""
        return self._keep("slip area", lambda: _find_slip_area(self))

    @property
    def is_steady(self) -> bool:
        """Whether the bodies slide steadily."""
        return self._sheared is not None and self._sheared.given.is_steady

    @property
    def end(self) -> FrictionalState:
        """What the next step of a path knows of this one."""
        return FrictionalState(
            pressure=self.pressure,
            shear=self.sheared.traction,
            displacement=self.tangential_displacement,
            approach=self.approach,
        )


def _find_stick_area(state: Any) -> Estimate:
    edges = sum(int(np.count_nonzero(np.diff(state.stick, axis=axis) & _both_touch(state, axis))) for axis in (0, 1))
    part, correction = _find_stick_of_edge(state)
    value = max(int(np.count_nonzero(state.stick)) * state.grid.cell_area + part * correction, 0.0)
    rings = 0.5 * edges * state.grid.cell_area
    spread = math.hypot(rings, part * state.area(uncertainty="model").uncertainty, _find_hidden_slip(state))
    return Estimate(value, spread, "m2")


def _find_slip_area(state: Any) -> Estimate:
    area = state.area(uncertainty="model")
    part, correction = _find_stick_of_edge(state)
    value = int(np.count_nonzero(state.slipping)) * state.grid.cell_area + (1.0 - part) * correction
    uncertainty = math.hypot(state.stick_area.uncertainty, area.uncertainty)
    return Estimate(max(value, 0.0), uncertainty, "m2", area.warnings)


def _find_hidden_slip(state: Any) -> float:
    """Return the area of slip that is narrower than half a cell along an edge that sticks, m2."""
    half_ring = 0.5 * find_sides(state)[1] * math.sqrt(state.grid.cell_area)
    strength = float(state.shear_strength.sum())
    if strength == 0.0:
        return 0.0
    part = float(np.hypot(*state.shear.sum(axis=(1, 2)))) / strength
    area = float(state.area(uncertainty="model").value)
    return min(half_ring, _SLIP_OF_BALL * part * _find_stick_of_edge(state)[0] * area)


def _find_stick_of_edge(state: Any) -> Pair:
    """Return the part of the edge of the contact that sticks, and the contact area beyond that of its cells, m2."""
    whole, sticking = find_sides(state)
    cells = int(np.count_nonzero(state.contact)) * state.grid.cell_area
    return sticking / whole if whole else 0.0, state.area(uncertainty="model").value - cells


def find_sides(state: ShearFields) -> Pair:
    """Return the length of the sides of cells along the edge of the contact, m, and of those whose cell sticks."""
    return state._keep("sides", lambda: _measure_sides(state))


def _measure_sides(state: ShearFields) -> Pair:
    masks = [extend(mask, 1, state.boundary) for mask in (state.contact, state.stick)]
    whole = 0.0
    sticking = 0.0
    for axis, side in enumerate(state.grid.spacing[::-1]):
        edge, held = (np.diff(np.moveaxis(mask, axis, 0)[:, 1:-1], axis=0) for mask in masks)
        whole += int(np.count_nonzero(edge)) * side
        sticking += int(np.count_nonzero(edge & held)) * side
    return whole, sticking


def _both_touch(state: ShearFields, axis: int) -> Mask:
    touching = np.moveaxis(state.contact, axis, 0)
    return np.moveaxis(touching[1:] & touching[:-1], 0, axis)
