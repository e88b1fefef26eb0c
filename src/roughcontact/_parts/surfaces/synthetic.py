"""Surfaces from formulas: the plane, spheres, paraboloids, waves and random self-affine roughness."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import ClassVar

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, IntArray, Pair, Waves
from roughcontact._base.checks import integer, number, pair
from roughcontact._base.machine import require_memory
from roughcontact._base.units import PlainText, Quantity, si
from roughcontact._parts.grid import Grid
from roughcontact._parts.surfaces.base import Surface
from roughcontact.errors import InputError

# Relative distance of a wavelength outside its limits that counts as rounding.
_WAVELENGTH_TOLERANCE = 1e-9
# Peak memory of the heights in float64 numbers per wave, and per cell; measured.
_NUMBERS_PER_WAVE = 9.1
_NUMBERS_PER_CELL = 5.1


def _center(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The centre", "m")


def _radius(value: Quantity) -> float:
    return number(value, "The radius of the sphere", "m", above=0.0)


def _radii(value: Quantity | Sequence[Quantity]) -> Pair:
    name = "The radius of curvature"
    if not isinstance(value, (tuple, list)) or len(value) != 2 or [_is_infinite(one) for one in value].count(True) != 1:
        return pair(value, name, "m", above=0.0)
    x, y = (math.inf if _is_infinite(one) else number(one, name, "m", above=0.0) for one in value)
    return x, y


def _is_infinite(value: object) -> bool:
    return isinstance(value, float) and value == math.inf


def _amplitude(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The amplitude of the wave", "m", at_least=0.0)


def _check_wavelengths(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The wavelength", "m", above=0.0)


def _phase(value: Quantity | Sequence[Quantity]) -> Pair:
    return pair(value, "The phase of the wave", "rad")


def _require_memory(grid: Grid, what: str, arrays: int) -> None:
    """Refuse a grid on which so many arrays do not fit into memory."""
    nx, ny = grid.shape
    require_memory(8.0 * arrays * grid.cells, f"{what} on {nx} x {ny} cells", "choose fewer cells")


@attrs.frozen
class FlatSurface(Surface):
    """A plane: zero everywhere.

    Examples
    --------
    >>> import roughcontact as rc
    >>> print(rc.FlatSurface().heights(rc.Grid((2, 2), 1e-6)).tolist())
    [[0.0, 0.0], [0.0, 0.0]]
    """

    def heights(self, grid: Grid) -> Array:
        """Return zeros, shape `grid.shape`, m."""
        _require_memory(grid, "A plane", 1)
        return np.zeros(grid.shape)


@attrs.frozen
class SphereSurface(Surface):
    """A true sphere, z = sqrt(R^2 - r^2) - R (`ParaboloidSurface` is Hertz's approximation of it).

    Parameters
    ----------
    radius
        Radius R of the sphere, m.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.SphereSurface(radius=1e-3)
    >>> heights = ball.heights(rc.Grid((3, 3), 30e-6))
    >>> print(f"{1e9 * (heights[1, 1] - heights[0, 1]):.1f} nm")
    50.0 nm
    """

    radius: float = attrs.field(converter=_radius, metadata={"unit": "m"})
    center: Pair = attrs.field(converter=_center, default=(0.0, 0.0), metadata={"unit": "m"})

    @property
    def provenance(self) -> tuple[str, ...]:
        """The radius in words."""
        return (f"a sphere of radius {si(self.radius, 'm')}",)

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit."""
        _require_memory(grid, "A sphere", 3)
        x = (grid.x - self.center[0]) / self.radius
        y = (grid.y - self.center[1]) / self.radius
        square = x**2 + y**2
        if square.max() > 1.0:
            raise InputError(
                f"The sphere of radius {si(self.radius, 'm')} does not cover the domain of {si(grid.size[0], 'm')} x "
                f"{si(grid.size[1], 'm')}: choose a smaller domain, a larger radius or a paraboloid."
            )
        # R - sqrt(R^2 - r^2) cancels near the summit; this form does not.
        return np.asarray(-self.radius * (square / (1.0 + np.sqrt(1.0 - square))), dtype=np.float64)


@attrs.frozen
class ParaboloidSurface(Surface):
    """Paraboloid z = -(x^2 / (2 R1) + y^2 / (2 R2)), the shape of Hertz's theory: a ball, a barrel or a cylinder.

    Parameters
    ----------
    radius
        Radii of curvature along x and y, or of both, m; one of them is infinite, ``"inf"``, for a cylinder.
    center
        Position (x, y) of the summit relative to the centre of the domain, m.

    Examples
    --------
    >>> import roughcontact as rc
    >>> barrel = rc.ParaboloidSurface(radius=(1e-3, 2e-3))
    >>> heights = barrel.heights(rc.Grid((3, 3), 30e-6))
    >>> print(f"{1e9 * (heights[1, 1] - heights[1, 0]):.1f} nm")
    25.0 nm
    """

    radius: Pair = attrs.field(converter=_radii, metadata={"unit": "m", "infinite": True})
    center: Pair = attrs.field(converter=_center, default=(0.0, 0.0), metadata={"unit": "m"})

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, zero at the summit."""
        _require_memory(grid, "A paraboloid", 1)
        x = grid.x - self.center[0]
        y = grid.y - self.center[1]
        return np.asarray(-(x * (x / (2 * self.radius[0])) + y * (y / (2 * self.radius[1]))), dtype=np.float64)


@attrs.frozen
class WavySurface(Surface):
    r"""Sum of two crossed cosine waves, one along each axis.

    .. math:: z(x, y) = \Delta_1 \cos(2\pi x/\lambda_1 + \varphi_1)
                      + \Delta_2 \cos(2\pi y/\lambda_2 + \varphi_2)

    with a summit in the centre of the domain when the phases are zero. An amplitude of zero along
    one axis makes a one-dimensional wave.

    Parameters
    ----------
    amplitude
        Amplitude along x and y, or of both, m.
    wavelength
        Wavelength along x and y, or of both, m.
    phase
        Phase along x and y, or of both, rad.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> heights = wave.heights(rc.Grid((64, 64), 100e-6))
    >>> print(f"{1e6 * heights.max():.2f} µm")
    1.99 µm
    """

    amplitude: Pair = attrs.field(converter=_amplitude, metadata={"unit": "m"})
    wavelength: Pair = attrs.field(converter=_check_wavelengths, metadata={"unit": "m"})
    phase: Pair = attrs.field(converter=_phase, default=(0.0, 0.0), metadata={"unit": "rad"})

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m."""
        _require_memory(grid, "A wave", 1)
        along_x = self.amplitude[0] * np.cos(2 * np.pi * (grid.x / self.wavelength[0]) + self.phase[0])
        along_y = self.amplitude[1] * np.cos(2 * np.pi * (grid.y / self.wavelength[1]) + self.phase[1])
        return np.asarray(along_x + along_y, dtype=np.float64)


def _hurst(value: Quantity) -> float:
    return number(value, "The Hurst exponent", at_least=0.0, at_most=1.0)


def _check_wavelength(value: Quantity) -> float:
    return number(value, "A limiting wavelength of the roughness", "m", above=0.0)


def _rms(value: Quantity | None) -> float | None:
    return None if value is None else number(value, "The rms height or slope", above=0.0)


def _peklenik(value: Quantity) -> float:
    return number(value, "Peklenik's number", at_least=1.0)


def _lay(value: Quantity) -> float:
    unit = "rad, np.deg2rad turns degrees into it"
    return number(value, "The direction of the lay", unit, at_least=-math.tau, at_most=math.tau)


def _seed(value: int) -> int:
    return integer(value, "The seed", at_least=0)


@attrs.frozen(kw_only=True)
class SpectralSurface(Surface):
    """A periodic random surface with a self-affine power spectrum: what `SelfAffineSurface` says of its fields."""

    is_random: ClassVar[bool] = True

    hurst: float = attrs.field(converter=_hurst)
    shortest: float = attrs.field(converter=_check_wavelength, metadata={"unit": "m"})
    longest: float = attrs.field(converter=_check_wavelength, metadata={"unit": "m"})
    rms_height: float | None = attrs.field(converter=_rms, default=None, metadata={"unit": "m"})
    rms_slope: float | None = attrs.field(converter=_rms, default=None)
    rolloff: float = attrs.field(
        converter=_check_wavelength, default=attrs.Factory(lambda self: self.longest, True), metadata={"unit": "m"}
    )
    peklenik: float = attrs.field(converter=_peklenik, default=1.0)
    lay: float = attrs.field(converter=_lay, default=0.0, metadata={"unit": "rad"})
    seed: int = attrs.field(converter=_seed, default=0)

    def __attrs_post_init__(self) -> None:
        if not self.shortest <= self.rolloff <= self.longest:
            allowed = f"between shortest ({self.shortest:g} m) and longest ({self.longest:g} m)"
            raise InputError.about("The roll-off wavelength", self.rolloff, allowed)

    @property
    def periodic(self) -> bool:
        """True: all waves fit into the domain, whatever its size."""
        return True


@attrs.frozen(kw_only=True)
class SelfAffineSurface(SpectralSurface):
    r"""Periodic Gaussian roughness with a self-affine power spectrum, isotropic or with a lay.

    The power spectral density is constant from the longest wave to the roll-off, falls as q^(-2 - 2 Hurst) to the
    shortest wave and is zero outside. The same seed gives the same surface at every resolution: the order in which
    waves get their random numbers does not depend on the grid.

    With a lay, as grinding leaves it, all lengths along the lay are Peklenik's number times those
    across it: the spectrum depends on :math:`q = \sqrt{q_\perp^2 + \gamma^2 q_\parallel^2}`.

    Parameters
    ----------
    hurst
        Hurst exponent, 0 to 1.
    shortest, longest
        Shortest and longest wavelength, across the lay if there is one, m.
    rms_height
        Root mean square of the height, m; exactly one of this and the slope.
    rms_slope
        Root mean square of the gradient's magnitude.
    rolloff
        Wavelength of the roll-off, across the lay, m; by default the longest wavelength.
    peklenik
        Ratio of the lengths along the lay to those across it, at least 1 (isotropic).
    lay
        Direction of the lay, counter-clockwise from the x axis, rad.
    seed
        Seed of the random numbers.
    rms_cutoff
        Shortest wavelength that counts in the rms value, across the lay, m; by default the shortest. With it, each wave
        keeps its amplitude and phase whatever the shortest wavelength, so that shorter waves only add: a study of
        magnification.

    References
    ----------
    Jacobs, Junge, Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001, https://doi.org/10.1088/2051-672X/aa51f8

    Peklenik, Proc. Inst. Mech. Eng. 182(3K) (1967) 108 (the number gamma)

    Examples
    --------
    >>> import roughcontact as rc
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=4e-6, longest=32e-6, seed=1)
    >>> heights = rough.heights(rc.Grid((64, 64), 64e-6))
    >>> heights.shape
    (64, 64)
    """

    rms_cutoff: float = attrs.field(
        converter=_check_wavelength, default=attrs.Factory(lambda self: self.shortest, True), metadata={"unit": "m"}
    )

    def __attrs_post_init__(self) -> None:
        if (self.rms_height is None) == (self.rms_slope is None):
            raise InputError("Give exactly one of rms_height= and rms_slope= for a self-affine surface.")
        super().__attrs_post_init__()
        if self.rms_cutoff > self.longest:
            allowed = f"at most the longest wavelength ({self.longest:g} m)"
            raise InputError.about("The cut-off of the rms value", self.rms_cutoff, allowed)

    def heights(self, grid: Grid) -> Array:
        """Return the heights at the cell centres, shape `grid.shape`, m, of mean zero."""
        self.require_grid(grid)
        kx, ky = (np.arange(-m, m + 1) for m in self._boxes(grid)[1])
        modes = self._waves(grid, ky)
        spectrum = np.zeros(grid.shape, dtype=np.complex128)
        np.add.at(spectrum, np.ix_(kx % grid.shape[0], ky % grid.shape[1]), modes)
        return np.ascontiguousarray(scipy.fft.ifft2(spectrum, norm="forward").real)

    def half_spectrum(self, grid: Grid, columns: slice, across: Callable[[np.ufunc, float], float]) -> Waves:
        """Return columns of the waves of the heights, shape (nx, n), for transforms whose parts lie apart.

        The heights are `scipy.fft.irfft2` of all columns, with ``norm="forward"``, but for rounding.

        Parameters
        ----------
        grid
            The grid.
        columns
            The columns, of the ny // 2 + 1 waves along y from zero up.
        across
            Function of a ufunc, `np.add` or `np.maximum`, and a number of this part that returns the sum or the maximum
            over all parts, which together have each column once.
        """
        nx, ny = grid.shape
        mx, my = self._boxes(grid)[1]
        kx = np.arange(-mx, mx + 1)
        waves = np.arange(my + 1)
        # Waves that count in the rms value alone may be shorter than two cells.
        places = np.minimum(waves % ny, -waves % ny)
        ky = waves[(columns.start <= places) & (places < columns.stop)]
        self._require_grid(grid, ky.size / waves.size)
        modes = self._waves(grid, ky, across)
        spectrum = np.zeros((nx, columns.stop - columns.start), dtype=np.complex128)
        resolved = 2 * ky <= ny
        np.add.at(spectrum, np.ix_(kx % nx, ky[resolved] - columns.start), modes[:, resolved])
        # At half the sampling wave number a wave and the opposite one are the same.
        limit = 2 * ky == ny
        np.add.at(spectrum, np.ix_(-kx % nx, ky[limit] - columns.start), np.conj(modes[:, limit]))
        return spectrum

    def require_grid(self, grid: Grid) -> None:
        """Refuse a grid that is too coarse, or on which the heights do not fit into memory."""
        self._require_grid(grid, 1.0)

    def _require_grid(self, grid: Grid, part: float) -> None:
        nyquist = max(2.0 * step for step in grid.spacing)
        if self.shortest < nyquist * (1 - _WAVELENGTH_TOLERANCE):
            allowed = f"at least two cells ({si(nyquist, 'm')}) on this grid"
            hint = "Refine the grid or choose a longer wave."
            raise InputError.about("The shortest wavelength", PlainText(si(self.shortest, "m")), allowed, hint)
        nx, ny = (2 * m + 1 for m in self._boxes(grid)[1])
        numbers = part * max(_NUMBERS_PER_WAVE * nx * ny, _NUMBERS_PER_CELL * grid.cells)
        require_memory(8.0 * numbers, f"A self-affine surface of {nx} x {ny} waves", "choose fewer cells")

    def count_waves(self, grid: Grid) -> int:
        """Return the number of waves on a grid, including waves that only count in the rms value."""
        kx, ky = self._boxes(grid)[1]
        return (2 * kx + 1) * (2 * ky + 1)

    def _boxes(self, grid: Grid) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return the largest numbers of waves per side, for the waves in the rms value and for all."""
        inner, shown = (
            tuple(int(side / wave * (1 + _WAVELENGTH_TOLERANCE)) for side in grid.size)
            for wave in (self.rms_cutoff, self.shortest)
        )
        return inner, tuple(map(max, inner, shown))

    def _waves(
        self, grid: Grid, ky: IntArray, across: Callable[[np.ufunc, float], float] = lambda _, value: value
    ) -> Waves:
        """Return the Fourier coefficients of the heights, whose origin the FFT has in the first cell.

        Those of all numbers of waves along y, or of some from zero up, in ascending order; see `half_spectrum`.
        """
        mx = self._boxes(grid)[1][0]
        qx, qy = (
            np.asarray(2 * np.pi * k / side, dtype=np.float64)
            for k, side in ((np.arange(-mx, mx + 1)[:, None], grid.size[0]), (ky[None, :], grid.size[1]))
        )
        modes = self._modes(grid, qx, qy, ky, across)
        return np.asarray(modes * np.exp(1j * (qx * grid.x[0, 0] + qy * grid.y[0, 0])))

    def _modes(
        self, grid: Grid, qx: Array, qy: Array, ky: IntArray, across: Callable[[np.ufunc, float], float]
    ) -> Waves:
        """Return the Fourier coefficients of a real surface with exactly the given rms height or slope."""
        inner, outer = self._boxes(grid)
        cos = math.cos(self.lay)
        sin = math.sin(self.lay)
        q = np.hypot(self.peklenik * (cos * qx + sin * qy), cos * qy - sin * qx)
        inside = q * self.longest >= 2 * np.pi * (1 - _WAVELENGTH_TOLERANCE)
        shown, counted = (
            inside & (q * wave <= 2 * np.pi * (1 + _WAVELENGTH_TOLERANCE)) for wave in (self.shortest, self.rms_cutoff)
        )
        if not all(across(np.maximum, float(waves.any())) for waves in (shown, counted)):
            raise InputError("No wave between shortest and longest fits into the domain: enlarge it.")
        flat = np.maximum(q, 2 * np.pi / self.rolloff)
        amplitude = np.where(inside, flat ** (-1.0 - self.hurst), 0.0)
        amplitude /= across(np.maximum, float(amplitude.max(initial=0.0)))
        modes = self._draw(amplitude, inner, outer, ky)
        box = (
            slice(outer[0] - inner[0], outer[0] + inner[0] + 1),
            slice(int(np.searchsorted(ky, -inner[1])), int(np.searchsorted(ky, inner[1], side="right"))),
        )
        magnitude = np.where(counted[box], np.abs(modes[box]), 0.0)
        rms = self.rms_height
        if rms is None:
            rms = self.rms_slope
            magnitude = np.hypot(qx, qy)[box] * magnitude
        squares = magnitude**2
        if not _has_opposites(ky):
            squares[:, ky[box[1]] > 0] *= 2.0
        scale = rms / np.sqrt(across(np.add, float(np.sum(squares))))
        return np.asarray(np.where(shown, modes * scale, 0.0))

    def _draw(self, amplitude: Array, inner: tuple[int, ...], outer: tuple[int, ...], ky: IntArray) -> Waves:
        """Return random coefficients of the given amplitudes: of opposite waves conjugates."""
        whole = _has_opposites(ky)
        noise = self._noise(inner, outer, ky if whole else np.concatenate((ky, -ky)))
        modes = amplitude * (noise[0, :, : ky.size] + 1j * noise[1, :, : ky.size])
        if whole:
            return np.asarray(modes + np.conj(modes[::-1, ::-1]))
        opposite = amplitude * (noise[0, ::-1, ky.size :] + 1j * noise[1, ::-1, ky.size :])
        return np.asarray(modes + np.conj(opposite))

    def _noise(self, inner: tuple[int, ...], outer: tuple[int, ...], ky: IntArray) -> Array:
        """Return two normal numbers for each wave, shape (2, 2 outer + 1, n); they do not depend on `outer`."""
        mx, my = inner
        nx, ny = outer
        noise = np.empty((2, 2 * nx + 1, ky.size))
        if inner != outer:
            # Each row has its own random stream, with the long waves first.
            order = np.argsort(np.abs(np.arange(-ny, ny + 1)), kind="stable")
            places = np.argsort(order)[ky + ny]
            for row in range(2 * nx + 1):
                key = np.random.SeedSequence(self.seed, spawn_key=(2 * abs(row - nx) + (row < nx),))
                noise[:, row] = np.random.default_rng(key).standard_normal((order.size, 2))[places].T
        near = np.abs(ky) <= my
        columns = ky[near] + my
        random = np.random.default_rng(self.seed)
        for part, row in itertools.product(range(2), range(nx - mx, nx + mx + 1)):
            noise[part, row, near] = random.standard_normal(2 * my + 1)[columns]
        return noise


def _has_opposites(ky: IntArray) -> bool:
    """Return whether numbers of waves along y include those below zero."""
    return bool((ky < 0).any())
