"""The fields of a solved contact, and its patches: connected cells in contact."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Self, TypeVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, IntArray, Mask, read_only, read_only_field
from roughcontact._base.checks import numbers
from roughcontact._base.units import Estimate, ShownAsPrinted, outlined
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.solution.additions import Addition, Certificate
from roughcontact._solve.solution.origin import Accuracy, Origin
from roughcontact._solve.solution.results import GridLevel, Residuals, Status
from roughcontact._solve.solution.whole import Whole
from roughcontact.errors import InputError, NoSuchField
from roughcontact.errors.door import guarded
from roughcontact.errors.warning import AskedOf

T = TypeVar("T")
A = TypeVar("A", bound=Addition)
# Minimum cells of a patch with a point that is surrounded by contact; the area of smaller ones is hardly known.
_SMALL_PATCH_CELLS = 4
# Names in `ContactFields._found` of what loads before have done to the surfaces.
_OF_SURFACES = ("default area", "offset", "shift")


@attrs.frozen(eq=False)
class ContactPatches(ShownAsPrinted):
    """Patches of the contact: cells that share a side or a corner, also across a periodic or wrapped border.

    Attributes
    ----------
    grid, boundary
        The grid, and what lies beyond its border.
    pressure
        Contact pressure, shape `grid.shape`, Pa.
    labels
        Number of the patch at each cell, from 1, and zero at open cells, shape `grid.shape`.
    count
        Number of patches.
    members
        Flat indices of the cells in contact, ascending.
    """

    grid: Grid
    boundary: Boundary
    pressure: Array = attrs.field(converter=read_only, repr=outlined)
    labels: IntArray = attrs.field(converter=read_only, repr=outlined)
    count: int
    members: IntArray = attrs.field(converter=read_only, repr=outlined)

    @cached_property
    def cells(self) -> IntArray:
        """Number of cells of each patch, shape (count,)."""
        return read_only(np.bincount(self.member_labels, minlength=self.count + 1)[1:])

    @cached_property
    def member_labels(self) -> IntArray:
        """Number of the patch of each cell in contact, from 1, in the order of `members`."""
        return read_only(self.labels.ravel()[self.members])

    @property
    def areas(self) -> Array:
        """Counted area of each patch, shape (count,), m2: usually too large, see `CellCount`."""
        return np.asarray(self.cells * self.grid.cell_area, dtype=np.float64)

    @cached_property
    def forces(self) -> Array:
        """Normal force on each patch, shape (count,), N."""
        return read_only(self._sum(self.pressure) * self.grid.cell_area)

    def sum(self, field: Array) -> Array:
        """Return the sum of a field of shape `grid.shape` over each patch, shape (count,)."""
        allowed = f"an array of finite numbers of shape {self.labels.shape}"
        values = numbers(field, "The field", allowed)
        if values.shape != self.labels.shape or not np.isfinite(values).all():
            raise InputError.about("The field", field, allowed)
        return self._sum(values)

    def _sum(self, field: Array) -> Array:
        values = field.ravel()[self.members]
        return np.bincount(self.member_labels, weights=values, minlength=self.count + 1)[1:].astype(np.float64)

    @cached_property
    def perimeters(self) -> Array:
        """Length of the cell sides between each patch and open cells, shape (count,), m."""
        lengths = np.zeros(self.count + 1)
        for axis, side in ((0, self.grid.spacing[1]), (1, self.grid.spacing[0])):
            for step in (-1, 1):
                beyond = np.roll(self.labels, step, axis=axis)
                open_ = (self.labels > 0) & (beyond == 0)
                if self.boundary.free_axes[axis]:
                    np.moveaxis(open_, axis, 0)[0 if step == 1 else -1] = False
                lengths += side * np.bincount(self.labels[open_], minlength=self.count + 1)
        return read_only(lengths[1:])

    @property
    def mean_pressures(self) -> Array:
        """Force over counted area of each patch, shape (count,), Pa."""
        return np.asarray(self.forces / self.areas)

    @property
    def small_fraction(self) -> float:
        """Fraction of the counted area in patches of fewer than four cells."""
        total = int(self.cells.sum())
        return float(self.cells[self.cells < _SMALL_PATCH_CELLS].sum() / total) if total else 0.0

    def __str__(self) -> str:
        if self.count == 0:
            return "no patches"
        return (
            f"{self.count} patches of {self.cells.mean():.3g} cells on average, {int(self.cells.max())} at most; "
            f"the largest carries {100 * self.forces.max() / self.forces.sum():.3g} % of the load; "
            f"{100 * self.small_fraction:.3g} % of the counted area is in patches of fewer than "
            f"{_SMALL_PATCH_CELLS} cells"
        )


@guarded
def find_patches(contact: Mask, pressure: Array, grid: Grid, boundary: Boundary) -> ContactPatches:
    """Return the patches of the cells in contact, and the pressure on them, Pa; both of shape (nx, ny)."""
    nx, ny = contact.shape
    labels = np.zeros(contact.shape, dtype=np.intp)
    # Runs of cells in contact along y, with an open cell behind each row.
    padded = np.zeros(nx * (ny + 1) + 1, dtype=bool)
    padded[1:].reshape(nx, ny + 1)[:, :ny] = contact
    starts, stops = np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2).T
    numbers, count = _join_runs(starts, stops, contact.shape, boundary)
    lengths = stops - starts
    # The n-th cell of all runs: its number in its run, and the start of that run, without the open cells behind rows.
    members = np.arange(lengths.sum()) + np.repeat(starts - starts // (ny + 1) - (lengths.cumsum() - lengths), lengths)
    labels.ravel()[members] = np.repeat(numbers + 1, lengths)
    return ContactPatches(grid, boundary, pressure, labels, count, members)


def _join_runs(starts: IntArray, stops: IntArray, shape: tuple[int, int], boundary: Boundary) -> tuple[IntArray, int]:
    """Return the patch of each run, from 0, and the number of patches; the runs are of rows with one more cell."""
    nx, ny = shape
    width = shape[1] + 1
    pairs = []
    free_x, free_y = boundary.free_axes
    steps = (width,) if free_x else (width, (1 - nx) * width)
    for step in steps:
        # Runs of the next row that begin at most one cell behind a run and end at most one cell before it.
        first = np.searchsorted(stops, starts + step)
        counts = np.maximum(np.searchsorted(starts, stops + step, side="right") - first, 0)
        one = np.repeat(np.arange(starts.size), counts)
        pairs.append((one, np.arange(one.size) + np.repeat(first - (counts.cumsum() - counts), counts)))
    if not free_y:
        first = np.flatnonzero(starts % width == 0)
        last = np.flatnonzero(stops % width == ny)
        rows = np.full(nx, -1)
        rows[starts[first] // width] = first
        for step in (-1, 0, 1):
            row = starts[last] // width + step
            beyond = np.where((row >= 0) & (row < nx) | (not free_x), rows[row % nx], -1)
            pairs.append((last[beyond >= 0], beyond[beyond >= 0]))
    one, other = np.concatenate(pairs, axis=1)
    return _number_pieces(one, other, starts.size)


def _number_pieces(one: IntArray, other: IntArray, count: int) -> tuple[IntArray, int]:
    """Return the piece of each of so many things of which pairs are joined, from 0, and the number of pieces.

    On contacts of some thousand runs this takes a third of the time of `scipy.sparse.csgraph`.
    """
    first = np.arange(count)
    while True:
        here = first[one]
        there = first[other]
        apart = np.flatnonzero(here != there)
        if apart.size == 0:
            break
        one = one[apart]
        other = other[apart]
        here = here[apart]
        there = there[apart]
        np.minimum.at(first, np.maximum(here, there), np.minimum(here, there))
        # All of a piece lead to its first.
        while True:
            further = first[first]
            if np.array_equal(further, first):
                break
            first = further
    is_first = first == np.arange(count)
    return (np.cumsum(is_first) - 1)[first], int(np.count_nonzero(is_first))


# Sum of pressures and tensions over that of their magnitudes, below which they balance: rounding.
_BALANCED = 1e-13


@attrs.frozen(eq=False, kw_only=True)
class ContactFields(AskedOf):
    """The fields of a solved contact.

    Attributes
    ----------
    grid, boundary
        The cells, and what lies beyond the border.
    modulus
        Contact modulus E*, Pa.
    pressure_limit
        Maximum contact pressure, shape () or (nx, ny), Pa; `inf` where there is none.
    pressure
        Pressure, shape `grid.shape`, Pa: of surfaces that attract each other the contact pressure minus the tension.
    displacement
        Sum of the elastic displacements of both surfaces, shape `grid.shape`, m, positive into the
        bodies; its mean is zero on a periodic boundary.
    initial_gap
        Gap before deformation when the summits just touch, shape `grid.shape`, m.
    approach
        Approach of the bodies since first touch, m.
    status, iterations, convolutions, seconds
        End of the solve, and its cost; wall time in s.
    residuals
        Residuals of the conditions of contact, verified in float64: the certificate.
    errors
        The solver's error before each iteration.
    levels
        The work on each grid, from coarse to fine; empty if the solver does not report it.
    edge_shift
        Distance by which the edge of the discrete contact lies inside the true edge, in cells.
    moduli
        Inverse wave numbers, m, ascending, and the effective contact modulus at each, Pa; None if it is `modulus` at
        all wave numbers.
    directional_moduli
        Contact modulus, Pa, of waves at equal angles from the x axis over half a turn; None if it is the same in all
        directions.
    origin
        The problem and its load; None if they are not known.
    accuracy
        The accuracy that was requested, and its cost; None if none was, and in files.
    non_measured
        Points that were not measured on one of the bodies, shape `grid.shape`: they carry no load. None: no such point.
    tension
        Attraction of the surfaces, shape `grid.shape`, Pa, at least zero; None without adhesion.
    added
        What friction adds; empty without.
    parts
        Of a contact that is divided among processes, what holds its parts together.
    uncertainty
        What the uncertainties of its answers are found from, unless they state it; see `ContactSolution.area`.
    """

    grid: Grid
    boundary: Boundary
    modulus: float
    pressure_limit: Array = attrs.field(converter=read_only_field)
    pressure: Array = attrs.field(converter=read_only_field)
    displacement: Array = attrs.field(converter=read_only_field)
    initial_gap: Array = attrs.field(converter=read_only_field)
    approach: float
    status: Status
    iterations: int
    convolutions: int
    seconds: float
    residuals: Residuals
    errors: tuple[float, ...]
    levels: tuple[GridLevel, ...] = ()
    edge_shift: float = 0.0
    moduli: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    directional_moduli: tuple[float, ...] | None = None
    origin: Origin | None = None
    accuracy: Accuracy | None = None
    non_measured: Mask | None = attrs.field(default=None, converter=attrs.converters.optional(read_only_field))
    tension: Array | None = attrs.field(default=None, converter=attrs.converters.optional(read_only_field))
    added: tuple[Addition, ...] = ()
    parts: Whole = attrs.field(default=Whole(), repr=False)
    uncertainty: str = attrs.field(default="auto", repr=False)

    def _find_added(self, kind: type[A]) -> A | None:
        """Return what a physics has added, by its class; None if it has added nothing."""
        return next((one for one in self.added if isinstance(one, kind)), None)

    def __reduce__(self) -> tuple[Any, ...]:
        # Arrays in pickles and deep copies are writable: the constructor makes them read-only again.
        return _restore, (type(self), attrs.asdict(self, recurse=False))

    @property
    def surface_modulus(self) -> float:
        """Contact modulus of the shortest waves, Pa: that of a layer on the body where the cells are finer than it."""
        return float(self.effective_modulus(1.0 / max(self.grid.resolved.spacing)))

    def effective_modulus(self, wavenumber: float | Array) -> Array:
        """Return the effective contact modulus E*, Pa, of pressure waves with these wave numbers, rad/m."""
        allowed = "a number or an array of numbers above 0 (rad/m)"
        given = wavenumber
        wavenumber = numbers(wavenumber, "The wave number", allowed, "rad/m")
        if not (wavenumber > 0.0).all():
            raise InputError.about("The wave number", given, allowed)
        if self.moduli is None:
            return np.full(wavenumber.shape, self.modulus)
        lengths, moduli = (np.log(values) for values in self.moduli)
        return np.asarray(np.exp(np.interp(-np.log(wavenumber), lengths, moduli)))

    @property
    def certificate(self) -> Certificate:
        """The conditions of contact, and of friction, each with its residual."""
        return Certificate((*self.residuals.conditions, *(one for added in self.added for one in added.conditions)))

    @property
    def friction_coefficient(self) -> Estimate:
        """Friction over normal force of viscoelastic bodies that slide at a speed, by the energy that they lose."""
        for one in self.added:
            found = one.list_numbers(self).get("friction_coefficient")
            if isinstance(found, Estimate):
                return found
        raise NoSuchField("The contact does not slide at a speed: call problem.slide(..., speed=...).")

    @property
    def _laws(self) -> frozenset[str]:
        """What laws add to the pressure, by name: ``"tension"``, ``"shear"`` or another; empty for pressure alone."""
        added = frozenset().union(*(one.marks for one in self.added))
        return added if self.tension is None else added | {"tension"}

    @property
    def _limits(self) -> dict[str, str]:
        """Why some responses do not hold, by what they do not know; see `Response.fails_with`."""
        return {unknown: reason for one in reversed(self.added) for unknown, reason in one.limits.items()}

    @cached_property
    def _found(self) -> dict[str, Any]:
        """What was computed of the solution and is asked for again, by name."""
        return {}

    def _is_first_answer(self) -> bool:
        is_first = "answered" not in self._found
        self._found["answered"] = True
        return is_first

    def _keep(self, name: str, find: Callable[[], T]) -> T:
        """Return what a function finds of the solution; it is called once for each name."""
        if name not in self._found:
            self._found[name] = find()
        found: T = self._found[name]
        return found

    @property
    def _shift(self) -> tuple[int, int]:
        """Cells by which the counterbody is displaced, (x, y)."""
        known: tuple[int, int] | None = self._found.get("shift")
        return known or next((one.shift for one in self.added if hasattr(one, "shift")), (0, 0))

    @property
    def _offset(self) -> Array | None:
        """What loads before have added to the gap before deformation, shape `grid.shape`, m; None: nothing."""
        added = (one.offset for one in self.added)
        known: Array | None = self._found.get("offset")
        return known if known is not None else next((one for one in added if one is not None and one.any()), None)

    @property
    def _fresh_gap(self) -> Array:
        """The gap before deformation of the surfaces before any load has changed them, shape `grid.shape`, m."""
        offset = self._offset
        return self.initial_gap if offset is None else self.initial_gap - offset

    @property
    def _is_changed(self) -> bool:
        """Whether loads before have changed the surfaces."""
        return self._offset is not None

    def _evolve(self, **changes: Any) -> Self:
        """Return the solution with changes, which still knows how loads before have changed its surfaces."""
        evolved = attrs.evolve(self, **changes)
        evolved._found.update((name, self._found[name]) for name in _OF_SURFACES if name in self._found)
        return evolved

    @cached_property
    def patches(self) -> ContactPatches:
        """The connected patches of the contact."""
        known: ContactPatches | None = self.parts.patches(self)
        return known or find_patches(self.contact, self.contact_pressure, self.grid, self.boundary)

    @cached_property
    def gap(self) -> Array:
        """Gap, shape `grid.shape`, m: zero in contact up to the residual, negative where saturated cells overlap."""
        gap = self.initial_gap + self.displacement
        gap -= self.approach
        return read_only_field(gap)

    @cached_property
    def contact_pressure(self) -> Array:
        """Pressure of the contact alone, shape `grid.shape`, Pa, at least zero: without adhesion `pressure` itself."""
        return self.pressure if self.tension is None else read_only_field(np.maximum(self.pressure + self.tension, 0.0))

    @cached_property
    def contact(self) -> Mask:
        """Cells in contact, whose contact pressure is above zero, shape `grid.shape`."""
        return read_only_field(self.contact_pressure > 0.0)

    @property
    def capped(self) -> bool:
        """Whether the pressure is limited anywhere."""
        return bool(np.isfinite(self.pressure_limit).any())

    @property
    def saturated(self) -> Mask:
        """Saturated cells, whose pressure has reached the limit, shape `grid.shape`."""
        return read_only_field(self.pressure >= self.pressure_limit)

    @property
    def force(self) -> float:
        """Normal force, N; of surfaces that attract each other negative where it pulls."""
        force = self.parts.sum(self.pressure)
        if self.tension is not None and abs(force) <= _BALANCED * float(
            np.add.reduce(np.abs(self.pressure), axis=None)
        ):
            force = 0.0
        return force * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa."""
        return self.force / self.grid.area


def _restore(cls: type[ContactFields], fields: dict[str, Any]) -> ContactFields:
    return cls(**fields)
