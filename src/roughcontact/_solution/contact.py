"""What a solve returns: the fields, the certificate and the quantities derived from them."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact import checks
from roughcontact._materials import Material
from roughcontact._solution import storage
from roughcontact._solution.accuracy import Accuracy
from roughcontact._solution.origin import Origin
from roughcontact._solution.patches import ContactPatches, find_patches
from roughcontact._solution.plausibility import list_warnings
from roughcontact._solution.results import (
    DEFAULT_AREA,
    Area,
    AreaEstimator,
    Estimate,
    GridLevel,
    QuantityEstimator,
    Residuals,
    Status,
    areas,
    judge_maps,
    quantities,
    require_estimate,
)
from roughcontact._solution.saturation import estimate_saturated_area
from roughcontact._solution.summary import summarize
from roughcontact._surfaces import HeightMap
from roughcontact.checks import Array, Mask, numbers, read_only
from roughcontact.errors import InputError
from roughcontact.grid import Boundary, Grid


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution:
    """A solved contact.

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
    history
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
    history: tuple[float, ...]
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
        wavenumber = numbers(wavenumber, "The wave number", "a number or an array of numbers (rad/m)")
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

    def area(self, estimator: str | AreaEstimator = DEFAULT_AREA) -> Area:
        """Return the real contact area.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        chosen = areas.resolve(estimator)
        area = chosen.estimate(self)
        if not isinstance(area, Area) or not np.isfinite([area.value, area.uncertainty]).all():
            raise InputError(
                f"The area estimator {chosen!r} returned {area!r}, which is not an Area of finite numbers."
            )
        return judge_maps(area, self._maps, self.grid.cell_area)

    @cached_property
    def _maps(self) -> tuple[HeightMap, ...]:
        return () if self.origin is None else self.origin.maps

    def peak_pressure(self) -> Estimate:
        """Return the maximum contact pressure between the cells, Pa; see `estimate`."""
        return self.estimate("peak-pressure")

    def estimate(self, quantity: str | QuantityEstimator, area: str | AreaEstimator = DEFAULT_AREA) -> Estimate:
        """Return a number of the contact with its uncertainty, given an area estimator.

        The names are ``"peak-pressure"``, ``"perimeter"``, ``"patches"``, ``"mean-gap"`` and ``"approach"``, since the
        first touch of the summits between the cells.
        """
        chosen = quantities.resolve(quantity)
        return require_estimate(chosen, chosen.estimate(self, self.area(area)))

    def saturated_area(self, estimator: str | AreaEstimator = "level-set") -> Area:
        """Return the part of the contact area where the pressure has reached the limit; zero without a limit.

        limit - p and -gap satisfy the contact conditions, and the contact of that complementary problem is
        the area that is not saturated; so the estimators of the contact's edge find this edge as well.

        Parameters
        ----------
        estimator
            Registered name or instance of an area estimator.

        Raises
        ------
        InputError
            If there is no such estimator.
        """
        return estimate_saturated_area(self, estimator)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Likely mistakes, and why the model or the grid does not suit the contact, in sentences; empty if none.

        They do not include those of the `area`.
        """
        return list_warnings(self, self._materials.values())

    @property
    def _materials(self) -> dict[str, Material]:
        return {} if self.origin is None else self.origin.materials

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file, completely or not at all.

        Parameters
        ----------
        path
            Ending in ``.npz``, or in ``.nc`` for netCDF with units (extra ``store``); an existing file is
            replaced. It holds the fields, shape (nx, ny), under their own names, the force, approach and area,
            the versions of the packages, and the problem: each part by its registered name and fields. Python
            warns of a part whose class is not registered.

        Raises
        ------
        InputError
            If there is no such folder.
        MissingPackage
            If netCDF is asked for without its packages.
        """
        storage.write(checks.path(path, "The file"), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> ContactSolution:
        """Return the solution in a file that `save` has written.

        Its problem can be solved again with ``ContactProblem(**solution.origin.problem)``, once the classes
        that ``solution.origin.missing`` names are registered. A file cannot run code: only registered
        classes and public ones of this package are built.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute displacement and residuals from the pressure: the time of
            one convolution. False takes them as the file gives them.

        Raises
        ------
        InputError
            If there is no such file, or it is damaged, of another kind or of another format; if its content
            contradicts itself, or cannot be verified because a class of the problem is not registered.
        """
        file = checks.path(path, "The file")
        solution = cls(**storage.read(file))
        if checks.flag(verify, "verify="):
            storage.verify(file, solution)
        return solution

    def to_xarray(self) -> Any:
        """Return the solution as an `xarray.Dataset` over x and y, m, with units (extra ``store``)."""
        return storage.to_xarray(self)

    def __str__(self) -> str:
        measured = [one for one in self._maps if not one.periodic]
        return summarize(self, measured, self._materials)


def _restore(cls: type[ContactSolution], fields: dict[str, Any]) -> ContactSolution:
    return cls(**fields)
