"""The linear maps between pressure, eigenstrain, stress and the displacement of the surface of a half-space."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.solving import require_memory
from roughcontact.typing import STRESS_COMPONENTS, Array

from roughcontact_volume.images import FreePlane
from roughcontact_volume.spectra import Period, PressureWaves
from roughcontact_volume.tables import PressureTables

# Bytes of tables that do not grow with the number of layers.
_BYTES_BESIDE = 2**22
_PRECISIONS = ("float64", "float32")


def _as_thicknesses(value: object) -> Array:
    what = "The thicknesses of the layers"
    allowed = "a list of finite numbers above 0 (m), from the surface down"
    try:
        thicknesses = np.array(value, dtype=np.float64, ndmin=1)
    except (TypeError, ValueError):
        raise rc.InputError.about(what, value, allowed) from None
    if thicknesses.ndim != 1 or not thicknesses.size or not np.all(np.isfinite(thicknesses) & (thicknesses > 0.0)):
        raise rc.InputError.about(what, value, allowed)
    thicknesses.flags.writeable = False
    return thicknesses


def _as_boundary(value: object) -> rc.Boundary:
    allowed = "free, periodic, free-periodic or periodic-free"
    try:
        boundary = rc.Boundary(value)  # type: ignore[arg-type]
    except ValueError:
        raise rc.InputError.about("The boundary", value, allowed) from None
    if boundary is rc.Boundary.WRAPPED:
        raise rc.InputError.about(
            "The boundary of a body with strain below its surface",
            str(boundary),
            allowed,
            "The waves of strain in layers have all images, not the nearest ones alone.",
        )
    return boundary


def _require_range(what: str, unit: str, value: Any, low: float, high: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not low < number < high:
        raise rc.InputError.about(
            what,
            value,
            f"a number above {low:g}" + (f" and below {high:g}" if math.isfinite(high) else f", finite ({unit})"),
        )
    return number


def _as_young(value: Any) -> float:
    return _require_range("Young's modulus", "Pa", value, 0.0, math.inf)


def _as_poisson(value: Any) -> float:
    return _require_range("Poisson's ratio", "", value, -1.0, 0.5)


def _as_precision(value: Any) -> str:
    if value not in _PRECISIONS:
        raise rc.InputError.about("The precision", value, "'float64' or 'float32'")
    return str(value)


def _as_grid(value: Any) -> rc.Grid:
    if not isinstance(value, rc.Grid):
        raise rc.InputError.about("The grid", value, "a Grid")
    return value


@attrs.frozen(eq=False)
class VolumeOperators:
    r"""A half-space in layers below a grid: stress by a pressure and by an eigenstrain, and displacement by the latter.

    All fields are constant in each cell of each layer; stresses are means over the thickness of a layer. Of S, the
    stress by a pressure, T, the residual stress of an eigenstrain, and U, the displacement of the surface by it,

    .. math:: \langle f, T e \rangle = \langle e, T f \rangle, \quad U = S^T,

    where the product of two fields weighs a layer with its thickness and a shear twice. Components come in the order
    xx, yy, zz, yz, xz, xy, shears of a strain are those of its tensor (not twice as large), tension is positive, and z
    points into the body.

    A periodic body has all images, its sides are held (no mean strain along x and y), and its maps are exact in depth
    for waves that the grid resolves: the mean of both signs is taken of waves of two cells, which have none. Along a
    free axis there are no images: S and U are by Love's cells, in closed form; T is that of a period twice as long,
    less the field of its images, to about a thousandth of its maximum.

    Parameters
    ----------
    grid
        The cells.
    boundary
        What lies beyond them: free, periodic, free-periodic or periodic-free.
    thicknesses
        Thicknesses of the layers from the surface down, shape (nz,), m.
    young, poisson
        The elastic constants, Pa and 1.
    precision
        Precision inside the residual stress: ``"float64"`` or ``"float32"``.

    References
    ----------
    Frerot, Bonnet, Molinari, Anciaux, Comput. Methods Appl. Mech. Eng. 351 (2019) 951-976,
    https://doi.org/10.1016/j.cma.2019.04.006

    Examples
    --------
    A layer that would swell by 0.1 % if it were free, its sides held:

    >>> import numpy as np
    >>> import roughcontact as rc
    >>> operators = VolumeOperators(rc.Grid((4, 4), 4e-6), rc.Boundary.PERIODIC, [1e-6, 1e-6], 200e9, 0.3)
    >>> strain = np.zeros((6, 2, 4, 4))
    >>> strain[:3, 0] = 1e-3
    >>> stress = operators.find_stress(strain)
    >>> print((stress[:, 0, 0, 0] / 1e6).round(1) + 0.0)
    [-285.7 -285.7    0.     0.     0.     0. ]
    >>> print(f"{operators.displace(strain)[0, 0] * 1e9:.3f} nm")
    -1.857 nm
    """

    grid: rc.Grid = attrs.field(converter=_as_grid)
    boundary: rc.Boundary = attrs.field(converter=_as_boundary)
    thicknesses: Array = attrs.field(converter=_as_thicknesses)
    young: float = attrs.field(converter=_as_young)
    poisson: float = attrs.field(converter=_as_poisson)
    precision: str = attrs.field(default="float64", converter=_as_precision)

    def press(self, pressure: Array) -> Array:
        """Return the stress by a pressure, mean over each layer, shape (6, nz, nx, ny), Pa.

        Parameters
        ----------
        pressure
            Pressure of each cell, shape (nx, ny), Pa.
        """
        given = self._check(pressure, "The pressure", self.grid.shape)
        return self._pressed.press(given)

    def find_stress(self, strain: Array) -> Array:
        """Return the residual stress of an eigenstrain, mean over each layer, shape (6, nz, nx, ny), Pa.

        Parameters
        ----------
        strain
            Eigenstrain of each cell, tensor shears, shape (6, nz, nx, ny).
        """
        given = self._check(strain, "The strain", self.shape)
        stress = self._strained.find_stress(given)
        stress *= self.young / (1.0 + self.poisson)
        return stress

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface by an eigenstrain, positive into the body, shape (nx, ny), m.

        Parameters
        ----------
        strain
            Eigenstrain of each cell, tensor shears, shape (6, nz, nx, ny).
        """
        given = self._check(strain, "The strain", self.shape)
        return self._pressed.displace(given)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Shape of a strain or a stress, (6, nz, nx, ny)."""
        return (len(STRESS_COMPONENTS), self.thicknesses.size, *self.grid.shape)

    @property
    def depths(self) -> Array:
        """Depths of the middles of the layers, shape (nz,), m."""
        return np.asarray(np.cumsum(self.thicknesses) - 0.5 * self.thicknesses)

    @cached_property
    def _pressed(self) -> PressureWaves | PressureTables:
        self._require_memory()
        return self._prepare_pressed()

    def _prepare_pressed(self) -> PressureWaves | PressureTables:
        grid, repeats = self.grid, self.boundary.repeats
        if all(repeats):
            return PressureWaves(grid.shape, grid.spacing, self.thicknesses, self.poisson)
        return PressureTables(grid.shape, grid.spacing, self.thicknesses, self.poisson, repeats)

    @cached_property
    def _strained(self) -> Period | FreePlane:
        self._require_memory()
        return self._prepare_strained()

    def _prepare_strained(self) -> Period | FreePlane:
        grid, repeats = self.grid, self.boundary.repeats
        dtype = np.dtype(self.precision).type
        if all(repeats):
            return Period(grid.shape, grid.spacing, self.thicknesses, self.poisson, dtype)
        return FreePlane(grid.shape, grid.spacing, self.thicknesses, self.poisson, dtype, repeats)

    @property
    def bytes_needed(self) -> int:
        """Bytes that these maps take at most, on one thread, beside the field that is given."""
        pressed, strained = self._prepare_pressed(), self._prepare_strained()
        period = strained.period if isinstance(strained, FreePlane) else strained
        tables = pressed.kept_bytes if isinstance(pressed, PressureTables) else 0
        return 8 * math.prod(self.shape) + period.bytes_for(self.grid.shape[0]) + tables + _BYTES_BESIDE

    def _require_memory(self) -> None:
        nz, nx, ny = self.shape[1:]
        require_memory(
            self.bytes_needed,
            f"The stress in {nz} layers of {nx} x {ny} cells",
            "take fewer layers, growing with the depth, or fewer cells",
        )

    @staticmethod
    def _check(values: Any, what: str, shape: tuple[int, ...]) -> Array:
        try:
            given = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            given = np.full(1, math.nan)
        if given.shape != shape:
            raise rc.InputError(f"{what} must be an array of shape {shape}, but its shape is {np.shape(values)}.")
        if not np.isfinite(given).all():
            raise rc.InputError(f"{what} must be finite in all cells.")
        return given
