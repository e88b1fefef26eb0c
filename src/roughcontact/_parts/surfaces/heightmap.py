"""Height maps: measured or computed heights on a grid of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from roughcontact._base.arrays import Array, Mask, Pair, frozen_array, read_only, restore_state
from roughcontact._base.checks import choice, instance_of, integer, measured_heights, pair, without_unit
from roughcontact._base.registry import find_view
from roughcontact._base.units import Quantity, fit, printable, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces import statistics as forms
from roughcontact._parts.surfaces.filling import TREATMENTS, complete, describe_filling, fill, was_filled
from roughcontact._parts.surfaces.quality import find_period, list_facts, list_map_warnings, write_facts
from roughcontact._parts.surfaces.resampling import (
    check_interpolation,
    resample,
    resample_mask,
    shift_by_half_cell,
)
from roughcontact._parts.surfaces.statistics import repeats
from roughcontact._parts.surfaces.stylus import list_tip_warnings
from roughcontact._parts.surfaces.topography import make_topography, read_topography
from roughcontact._parts.surfaces.treatment import TreatedMap
from roughcontact.errors import InputError, argument

# Maximum degree of a form: higher ones follow the roughness, and their normal equations lose their digits.
_MAX_DEGREE = 30
# Word that asks to fill the non-measured points.
_FILL = "fill"
_KEEP = "keep"
# Degree of the polynomial of each form that has a name of its own.
_DEGREE_OF_FORM = {"mean": 0, "plane": 1}


def _size(value: Quantity | Sequence[Quantity], height_map: Any) -> Pair:
    what = "The size of the height map"
    given: Any = without_unit(value, what, "m")
    sides = pair(given, what, "m", above=0.0)
    nx, ny = height_map.values.shape
    if nx != ny and np.size(given) == 1:
        raise InputError(
            f"A height map of {nx} x {ny} points needs both sides, {argument('size', 'x', 'y', unit='m')}, "
            f"but got one: with square cells it is {si(sides[0], 'm')} x {si(sides[0] * ny / nx, 'm')} large."
        )
    return sides


def _mask(value: npt.ArrayLike, what: str, more: str = "") -> Mask:
    """Return booleans for the points of a map, or raise `InputError`; `more` says what else is allowed."""
    try:
        mask = np.array(value)
    except ValueError:
        raise InputError(f"{what} must be a rectangular array, but their rows differ.") from None
    if mask.dtype.kind != "b" or mask.ndim != 2:
        allowed = f"an array of booleans of the map's shape{more}"
        raise InputError.about(what, mask if mask.ndim else value, allowed)
    return mask


def _uncertain(value: npt.ArrayLike | None) -> Any:
    return None if value is None else read_only(_mask(value, "The uncertain points of a height map"))


def _non_measured(value: npt.ArrayLike | None) -> Any:
    """Return a mask, or None without non-measured points; the word that asks to fill them stays."""
    if isinstance(value, str) and value in (_KEEP, _FILL):
        return value if value == _FILL else None
    if value is None:
        return None
    more = f", {_KEEP!r}, or {_FILL!r} to take them from their neighbours"
    mask = _mask(value, "The non-measured points of a height map", more)
    if mask.all():
        raise InputError("No point of the height map was measured: at least one is needed.")
    return read_only(mask) if mask.any() else None


def check_history(value: Sequence[str]) -> tuple[str, ...]:
    """Return the history of a map as printable texts, or raise `InputError`."""
    if not isinstance(value, (tuple, list)) or not all(isinstance(text, str) for text in value):
        raise InputError.about("The history of a height map", value, "a tuple of texts")
    return tuple(map(printable, value))


@attrs.frozen(eq=False)
class HeightMap(TreatedMap):
    """Heights given as an array, one value for each cell.

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), indexed [x, y], m, positive outward, NaN or masked where not measured. They are copied,
        except float64 mapped from a file for reading, ``np.load(path, mmap_mode="r")``, which must not change.
    size
        Sides of the measured domain (x, y), m; one number if the map has as many points along x as along y.
    periodic
        Whether the map repeats beyond its border.
    non_measured
        Mask of points that were not measured, shape (nx, ny), in addition to points without a height: they never touch,
        and their heights, given or filled from their neighbours, only serve to interpolate nearby points. ``"keep"``:
        the points without a height. ``"fill"`` takes the filled heights as measured, as `fill` does.
    history
        Processing of the heights so far, in words; ``explain()`` of a problem prints it.
    uncertain
        Mask of the points that the tip of a stylus has not surely touched, shape (nx, ny), as `restored` finds it: the
        surface may be lower there. None where no tip is known.

    Raises
    ------
    InputError
        If the heights are not a two-dimensional array of at least two numbers, one is infinite, no point was measured,
        or a mask has another shape.

    Examples
    --------
    >>> import roughcontact as rc
    >>> import numpy as np
    >>> heights = 1e-6 * np.random.default_rng(0).standard_normal((32, 32))
    >>> surface = rc.HeightMap(heights, size=32e-6)
    >>> print(surface.grid)
    32 x 32 cells on 32 µm x 32 µm
    """

    is_random: ClassVar[bool] = True

    _heights: Array = attrs.field(converter=measured_heights, alias="heights")
    # mypy does not know converters that take self.
    size: Pair = attrs.field(converter=attrs.Converter(_size, takes_self=True))  # type: ignore[misc]
    periodic: bool = attrs.field(
        default=False, kw_only=True, validator=instance_of(bool, "Whether a map repeats", "True or False")
    )
    non_measured: Mask | None = attrs.field(default=None, kw_only=True, converter=_non_measured)
    history: tuple[str, ...] = attrs.field(default=(), kw_only=True, converter=check_history)
    uncertain: Mask | None = attrs.field(default=None, kw_only=True, converter=_uncertain)

    def __attrs_post_init__(self) -> None:
        takes_filled = isinstance(self.non_measured, str)
        if takes_filled:
            object.__setattr__(self, "non_measured", None)
        for mask, name in ((self.non_measured, "non-measured"), (self.uncertain, "uncertain")):
            if mask is not None and mask.shape != self._heights.shape:
                raise InputError(
                    f"The mask of {name} points has shape {mask.shape}, but the heights {self._heights.shape}."
                )
        if math.isnan(float(self._heights.min())):
            lost = _non_measured(np.isnan(self._heights) | (False if self.non_measured is None else self.non_measured))
            object.__setattr__(self, "non_measured", None if takes_filled else lost)
            object.__setattr__(self, "_heights", frozen_array(fill(self._heights)))
            if takes_filled:
                object.__setattr__(self, "history", (*self.history, describe_filling(lost)))

    __setstate__ = restore_state

    @property
    def grid(self) -> Grid:
        """The grid on which the map is given."""
        return Grid(self._heights.shape, self.size)

    own_grid = grid

    @property
    def provenance(self) -> tuple[str, ...]:
        """The history of the map."""
        return self.history

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Signs of blur, interpolation, noise, steps or filled points in a map that is not periodic, in sentences.

        And that a map was `restored` below a tip that cannot have traced it.
        """
        tip = list_tip_warnings(self.history)
        if self.periodic:
            return tip
        filled = was_filled(self.history)
        return (*tip, *list_map_warnings(self._heights, self.grid, self.non_measured, was_filled=filled))

    @cached_property
    def period(self) -> float:
        """Distance of the points between which the map seems interpolated, cells; zero if it does not."""
        return find_period(self._heights, self.non_measured)

    @property
    def values(self) -> Array:
        """The heights as given, shape (nx, ny), m, read-only."""
        return self._heights

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Return the heights, shape (nx, ny), m, NaN where they were not measured."""
        heights = self._heights if self.non_measured is None else np.where(self.non_measured, np.nan, self._heights)
        return np.array(heights, dtype=dtype, copy=copy)

    def __repr__(self) -> str:
        periodic = ", periodic" if self.periodic else ""
        lost = "" if self.non_measured is None else f", {int(self.non_measured.sum())} points non-measured"
        return f"<HeightMap {self.grid}{periodic}{lost}>"

    def __str__(self) -> str:
        return fit("\n".join(write_facts(list_facts(self._sample(None), self.history, self.warnings))))

    def _repr_html_(self) -> str:
        page: str = find_view("map")(self)
        return page

    @classmethod
    def from_topography(cls, topography: Any, *, non_measured: str = "refuse") -> HeightMap:
        """Return the map of a two-dimensional `SurfaceTopography.Topography`, its unit converted to m.

        Parameters
        ----------
        topography
            With its unit, size and periodicity.
        non_measured
            As for `read_surface`: ``"refuse"``, ``"fill"`` or ``"keep"``.

        Raises
        ------
        InputError
            If it is not a topography, has no unit, or has non-measured points that are refused.
        """
        choice(non_measured, "The treatment of non-measured points", TREATMENTS)
        try:
            heights, size, periodic = read_topography(topography)
        except InputError as error:
            raise InputError(f"The topography cannot be used: {str(error).rstrip('.')}.") from error
        heights, mask, done = complete(heights, "the topography", non_measured)
        history = (f"from a topography of SurfaceTopography{done}",)
        return cls(heights, size, periodic=periodic, non_measured=mask, history=history)

    def to_topography(self) -> Any:
        """Return the map as a `SurfaceTopography.Topography` in m, masked at non-measured points."""
        return make_topography(self.values, self.size, periodic=self.periodic, non_measured=self.non_measured)

    def heights(self, grid: Grid) -> Array:
        """Return the heights on the map's own grid, shape `grid.shape`, m: a map is resampled only on request."""
        if not self.grid.matches(grid):
            raise InputError(
                f"The height map is given on {self.grid}, but was asked for on {grid}. "
                f"Call .resample({grid.shape}) first, bring maps of two domains together with match(), or use the "
                "map's own grid."
            )
        return self._heights

    def non_measured_on(self, grid: Grid) -> Mask | None:
        """Return the non-measured points on the map's own grid, shape (nx, ny); None if there are none."""
        return self.non_measured

    def uncertain_on(self, grid: Grid) -> Mask | None:
        """Return the uncertain points on the map's own grid, shape (nx, ny); None where no tip is known."""
        return self.uncertain

    def resample(self, shape: Sequence[int], interpolation: str = "bilinear") -> HeightMap:
        """Return the map on another number of cells over the same domain.

        Parameters
        ----------
        shape
            Number of cells (nx, ny) of the new map.
        interpolation
            ``"bilinear"``: between cell centres, as in image scaling and in the paper; it aliases when coarsening.
            ``"cubic"``: by cubic splines, smooth but with the same aliasing. ``"fourier"``: exact for band-limited
            periodic maps. ``"mean"``: mean over blocks of cells.

        Raises
        ------
        InputError
            If the interpolation is unknown, is ``"fourier"`` on a map that is not periodic, or is
            ``"mean"`` and the new cell counts do not divide the old ones.
        """
        target = Grid(shape, self.size).shape
        check_interpolation(interpolation)
        if interpolation == "fourier" and not self.periodic:
            raise InputError("Fourier resampling needs a periodic map: use 'bilinear', or periodic=True if it is one.")
        if interpolation == "mean" and any(old % new for old, new in zip(self._heights.shape, target, strict=True)):
            raise InputError(
                f"Block means need cell counts that divide {self._heights.shape}, but got {target}; use 'bilinear'."
            )
        near = "mean" if interpolation == "mean" else "bilinear"
        pitch = " x ".join(si(step, "m") for step in Grid(target, self.size).spacing)
        return attrs.evolve(
            self,
            heights=resample(self._heights, target, interpolation, periodic=self.periodic),
            non_measured=resample_mask(self.non_measured, target, near, periodic=self.periodic),
            uncertain=resample_mask(self.uncertain, target, near, periodic=self.periodic),
            history=(*self.history, f"resampled ({interpolation}) to {target[0]} x {target[1]} cells of {pitch}"),
        )

    def resample_to(self, grid: Grid, interpolation: str | None = None) -> HeightMap:
        """Return the map on the cells of another grid over the same domain; see `Surface.resample_to`."""
        check_interpolation(interpolation)
        if self.grid.matches(grid):
            return self
        if interpolation is None and not self.periodic:
            raise InputError(
                "A height map that is not periodic is not known between its points: say interpolation='bilinear' to "
                "take it as linear there, or periodic=True if the map is."
            )
        return self.resample(grid.shape, interpolation or "fourier")

    def shift_half_cell(self, grid: Grid, *, periodic: bool) -> HeightMap:
        """Return the periodic map moved by half a cell along both axes; see `Surface.shift_half_cell`."""
        if not (self.periodic or (periodic and repeats(self._heights))):
            raise InputError("A height map is not known between its points, unless it is periodic.")
        if self.non_measured is not None:
            raise InputError("A height map with non-measured points cannot be shifted by half a cell.")
        return attrs.evolve(self, heights=shift_by_half_cell(self.heights(grid), self.grid))

    def _change(self, **changes: Any) -> HeightMap:
        return attrs.evolve(self, **changes)

    def separate(self, form: str | int = "plane") -> Separated:
        """Return form and roughness of the map, separated by least squares over the measured points.

        Parameters
        ----------
        form
            ``"mean"``, ``"plane"``, ``"sphere"``, or the total degree of a polynomial: 0 for the mean, 1 for the plane,
            2 for curvature and twist as well, ...

        Raises
        ------
        InputError
            If the form is unknown, or the map does not determine it.
        """
        degree = _DEGREE_OF_FORM.get(form, form) if isinstance(form, str) else form
        curvature = 0.0
        if isinstance(degree, str) and degree == "sphere":
            if min(self._heights.shape) < 3:
                raise InputError("A sphere needs at least three cells along each axis.")
            fitted, curvature = forms.sphere(self._heights, self.grid.x, self.grid.y, self.non_measured)
            text = f"the best sphere subtracted, of radius {si(1 / curvature if curvature else math.inf, 'm', 4)}"
        else:
            if isinstance(degree, str):
                raise InputError.about("The form", form, "'mean', 'plane', 'sphere' or the degree of a polynomial")
            degree = integer(degree, "The degree of the form", at_least=0)
            if degree > _MAX_DEGREE:
                raise InputError.about("The degree of the form", degree, f"at most {_MAX_DEGREE}")
            if min(self._heights.shape) <= degree:
                raise InputError(f"A form of degree {degree} needs more than {degree} cells along each axis.")
            fitted = forms.polynomial(self._heights, degree, self.non_measured)
            text = f"the best {({0: 'mean', 1: 'plane'}).get(degree, f'polynomial of degree {degree}')} subtracted"
        only_form = (*self.history, "form only")
        return Separated(
            form=attrs.evolve(
                self, heights=fitted, non_measured=None, uncertain=None, periodic=False, history=only_form
            ),
            roughness=attrs.evolve(self, heights=self._heights - fitted, history=(*self.history, text)),
            radius=1.0 / curvature if curvature else math.inf,
        )

    def detrend(self, form: str | int = 1) -> HeightMap:
        """Return the map less its form; see `separate`."""
        return self.separate(form).roughness


@attrs.frozen(eq=False, kw_only=True)
class Separated:
    """Form and roughness of a height map; their sum is the map.

    Attributes
    ----------
    form
        The fitted form on the map's grid.
    roughness
        The heights less the form, with the non-measured points of the map.
    radius
        Radius of the sphere, m, negative for a bowl; infinite for other forms.
    """

    form: HeightMap
    roughness: HeightMap
    radius: float
