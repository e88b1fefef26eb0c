"""The fields of a solved contact, and what follows from them cell by cell."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact._base.checks import Array, Mask, numbers, read_only
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.solution.accuracy import Accuracy
from roughcontact._solve.solution.origin import Origin
from roughcontact._solve.solution.patches import ContactPatches, find_patches
from roughcontact._solve.solution.results import GridLevel, Residuals, Status
from roughcontact.errors import InputError


@attrs.frozen(eq=False, kw_only=True)
class ContactFields:
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
        Contact pressure, shape `grid.shape`, Pa.
    displacement
        Sum of the elastic displacements of both surfaces, shape `grid.shape`, m, positive into the
        bodies; its mean is zero on a periodic boundary.
    initial_gap
        Gap before deformation when the summits just touch, shape `grid.shape`, m.
    approach
        Approach of the bodies since first touch, m.
    status, iterations, convolutions, seconds
        How the solve ended, and its cost; wall time in s.
    residuals
        Residuals of the contact conditions, verified in float64: the certificate.
    errors
        The solver's error before each iteration.
    levels
        The work on each grid, from coarse to fine; empty where the solver does not report it.
    edge_shift
        Distance by which the edge of the discrete contact lies inside that of the continuous one, in cells.
    moduli
        Inverse wave numbers, m, ascending, and the effective contact modulus at each, Pa; None where it is
        `modulus` at all wave numbers.
    origin
        The problem and its load; None where they are not known.
    accuracy
        The accuracy that was asked of the solve and its cost; None where none was, and in files.
    non_measured
        Points that were not measured on one of the bodies and carry nothing, shape `grid.shape`; None without any.
    """

    grid: Grid
    boundary: Boundary
    modulus: float
    pressure_limit: Array = attrs.field(converter=read_only)
    pressure: Array = attrs.field(converter=read_only)
    displacement: Array = attrs.field(converter=read_only)
    initial_gap: Array = attrs.field(converter=read_only)
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
    origin: Origin | None = None
    accuracy: Accuracy | None = None
    non_measured: Mask | None = attrs.field(default=None, converter=attrs.converters.optional(read_only))

    def __reduce__(self) -> tuple[Any, ...]:
        # Arrays come back writable from pickles and deep copies: they are made read-only as those of any solution.
        return _restore, (type(self), attrs.asdict(self, recurse=False))

    def effective_modulus(self, wavenumber: float | Array) -> Array:
        """Return the effective contact modulus E*, Pa, of pressure waves with these wave numbers, rad/m."""
        allowed = "a number or an array of numbers above 0 (rad/m)"
        given = wavenumber
        wavenumber = numbers(wavenumber, "The wave number", allowed)
        if not (wavenumber > 0.0).all():
            raise InputError.about("The wave number", given, allowed)
        if self.moduli is None:
            return np.full(wavenumber.shape, self.modulus)
        lengths, moduli = (np.log(values) for values in self.moduli)
        return np.asarray(np.exp(np.interp(-np.log(wavenumber), lengths, moduli)))

    @cached_property
    def patches(self) -> ContactPatches:
        """The connected patches of the contact."""
        return find_patches(self.contact, self.pressure, self.grid, self.boundary)

    @cached_property
    def gap(self) -> Array:
        """Gap, shape `grid.shape`, m: zero in contact up to the residual, negative where saturated cells overlap."""
        gap = self.initial_gap + self.displacement
        gap -= self.approach
        return read_only(gap)

    @cached_property
    def contact(self) -> Mask:
        """Cells in contact, p > 0, shape `grid.shape`."""
        return read_only(self.pressure > 0.0)

    @property
    def capped(self) -> bool:
        """Whether the pressure is limited anywhere."""
        return bool(np.isfinite(self.pressure_limit).any())

    @property
    def saturated(self) -> Mask:
        """Saturated cells, whose pressure has reached the limit, shape `grid.shape`."""
        return read_only(self.pressure >= self.pressure_limit)

    @property
    def force(self) -> float:
        """Normal force, N."""
        return float(np.add.reduce(self.pressure, axis=None)) * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa."""
        return self.force / self.grid.area


def _restore(cls: type[ContactFields], fields: dict[str, Any]) -> ContactFields:
    return cls(**fields)
