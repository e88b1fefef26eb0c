"""What a solve returns: the fields, the certificate and the answers derived from them."""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from roughcontact.checks import Array, Mask
from roughcontact.clusters import Clusters, clusters_of
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid
from roughcontact.registry import areas
from roughcontact.solution import storage
from roughcontact.solution.figures import DEFAULT_AREA, Area, EstimatesArea, Level, Residuals, Status
from roughcontact.solution.origin import Origin
from roughcontact.units import si

# Pressures and gaps that are this close to their bounds, relative to limit and scale, are at them.
_CLOSE = 1e-4
# Cells above this share of the limit may hide points at it.
_NEAR = 0.95


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution:
    """A solved contact.

    Attributes
    ----------
    grid, boundary
        Where the fields live, and what lies beyond.
    modulus
        Contact modulus E*, Pa.
    limit
        Greatest contact pressure, Pa, a number or an array of shape (nx, ny); `inf` where there is none.
    pressure
        Contact pressure, shape `grid.shape`, Pa.
    displacement
        Sum of the elastic displacements of both surfaces, shape `grid.shape`, m, positive into the
        bodies; its mean is zero on a periodic boundary.
    undeformed
        Gap before deformation when the summits just touch, shape `grid.shape`, m.
    approach
        Approach of the bodies since first touch, m.
    status, iterations, convolutions, seconds
        How the solve ended and what it took (wall time).
    residuals
        The certificate.
    history
        The solver's error before each iteration.
    levels
        The work on each grid, from coarse to fine, where the solver tells.
    edge_shift
        How far inside the true edge the kernel's discrete solutions put it, in cells.
    moduli
        Inverse wave numbers, m, ascending, and the contact modulus E* that such waves meet, Pa; None where
        all meet `modulus`.
    origin
        What was solved; None where it is not known.
    """

    grid: Grid
    boundary: Boundary
    modulus: float
    limit: float | Array
    pressure: Array
    displacement: Array
    undeformed: Array
    approach: float
    status: Status
    iterations: int
    convolutions: int
    seconds: float
    residuals: Residuals
    history: tuple[float, ...]
    levels: tuple[Level, ...] = ()
    edge_shift: float = 0.0
    moduli: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    origin: Origin | None = None

    def modulus_at(self, length: float | Array) -> Array:
        """Return the contact modulus E* that waves of inverse wave number `length`, m, meet, Pa."""
        if self.moduli is None:
            return np.full(np.shape(length), self.modulus)
        lengths, moduli = (np.log(values) for values in self.moduli)
        return np.asarray(np.exp(np.interp(np.log(length), lengths, moduli)))

    @cached_property
    def clusters(self) -> Clusters:
        """The contact, told apart into cells that hang together."""
        return clusters_of(self.contact, self.pressure, self.grid, self.boundary)

    @cached_property
    def gap(self) -> Array:
        """Gap, shape `grid.shape`, m: zero in contact up to the residual, negative where saturated cells overlap."""
        gap = self.undeformed + self.displacement
        gap -= self.approach
        gap.flags.writeable = False
        return gap

    @cached_property
    def contact(self) -> Mask:
        """Cells in contact, p > 0, shape `grid.shape`."""
        return self.pressure > 0.0

    @property
    def saturated(self) -> Mask:
        """Cells whose pressure has reached the limit, shape `grid.shape`."""
        return self.pressure >= self.limit

    @property
    def force(self) -> float:
        """Normal force, N."""
        return float(np.add.reduce(self.pressure, axis=None)) * self.grid.cell_area

    @property
    def mean_pressure(self) -> float:
        """Nominal mean pressure, Pa."""
        return self.force / self.grid.area

    def area(self, estimator: str | EstimatesArea = DEFAULT_AREA) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator; the default if left out.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        chosen = areas.resolve(estimator, EstimatesArea)
        area = chosen.estimate(self)
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(f"The area estimator {chosen!r} returned {area!r}, which is no Area of finite numbers.")
        return area

    def saturated_area(self, estimator: str | EstimatesArea = "level-set") -> Area:
        """Return the part of the contact area where the pressure has reached the limit; zero without a limit.

        Where the pressure is below the limit, limit - p and -gap satisfy the conditions of a contact:
        what carries there is exactly what is not saturated. So the estimators of the contact's edge
        find the edge of the saturated area as well.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        name = str(estimator) if isinstance(estimator, str) else type(estimator).__name__
        areas.resolve(estimator, EstimatesArea)
        if not self.saturated.any():
            # A cell whose mean pressure comes near the limit may hide a point that has reached it.
            near = int(np.count_nonzero(self.pressure > _NEAR * self.limit)) * self.grid.cell_area
            return Area(0.0, 0.0, near, name, perimeter=0.0)
        complement = attrs.evolve(
            self,
            pressure=self.limit - self.pressure,
            displacement=-self.displacement,
            undeformed=-self.undeformed,
            approach=-self.approach,
            # What is not saturated goes on beyond the border: that is no edge.
            boundary=Boundary.PERIODIC if self.boundary is Boundary.FREE else self.boundary,
        )
        rest = complement.area(estimator)
        # A larger one would carry more than the load.
        bearable = float(np.sum(self.pressure / self.limit)) * self.grid.cell_area
        value = min(self.grid.area - rest.value, bearable)
        undecided = self._undecided()
        doubts = rest.doubts
        if undecided > 0.05 * value:
            doubts = (
                *doubts,
                "cells at the limit barely overlap, as flattened ones do: how many flow is not determined",
            )
        bar = float(np.hypot(rest.uncertainty, undecided))
        fraction = value / self.grid.area
        return attrs.evolve(rest, value=value, fraction=fraction, uncertainty=bar, doubts=doubts, clusters=None)

    def _undecided(self) -> float:
        """Return the area of the cells at the limit whose gap is zero, up to the residual, m2: either may be meant."""
        at_limit = self.pressure > (1.0 - _CLOSE) * self.limit
        flat = np.abs(self.gap) <= _CLOSE * self.residuals.scale
        return int(np.count_nonzero(at_limit & flat)) * self.grid.cell_area

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file, which appears whole or not at all.

        Parameters
        ----------
        path
            Ending in ``.npz``, or in ``.nc`` for netCDF with units (extra ``store``); an existing file is
            replaced. Fields, shape (nx, ny), stand under their own names, pressure, displacement,
            undeformed and gap, beside force, approach, area and their like; the header holds the
            versions of all that took part, and the problem itself.

        Raises
        ------
        InputError
            If there is no such folder, or the problem has parts that no file can hold.
        MissingPackage
            If netCDF is asked for without its packages.
        """
        storage.write(Path(path), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ContactSolution:
        """Return the solution in a file that `save` has written.

        Its problem can be solved again with ``ContactProblem(**solution.origin.problem)``. The classes of
        plug-ins that took part are imported by name: load files only from whom you would run code from.

        Raises
        ------
        InputError
            If there is no such file, it is damaged or of another kind, or a plug-in is not installed.
        """
        return cls(**storage.read(Path(path)))

    def to_xarray(self) -> Any:
        """Return the solution as an `xarray.Dataset` over x and y, m, with units (extra ``store``)."""
        return storage.to_xarray(self)

    def __str__(self) -> str:
        saturated = f"\n  saturated      {self.saturated_area()}" if np.isfinite(self.limit).any() else ""
        return (
            f"{self.status}\n"
            f"  after {self.iterations} iterations, {self.convolutions} convolutions, {self.seconds:.2g} s\n"
            f"  residuals      {self.residuals}\n"
            f"  force          {si(self.force, 'N', 6)}\n"
            f"  mean pressure  {si(self.mean_pressure, 'Pa', 6)}\n"
            f"  max pressure   {si(float(self.pressure.max()), 'Pa', 6)}\n"
            f"  approach       {si(self.approach, 'm', 6)}\n"
            f"  contact area   {self.area()}{saturated}"
        )
