"""The kernel interface: real-space coefficients, a spectrum, or both."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, Protocol, runtime_checkable

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Mask, Pair, matrix_product
from roughcontact._base.checks import Part, returned_array
from roughcontact._base.registry import Registry
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._parts.kernels.mixed import Spectrum, mixed_coefficients
from roughcontact._parts.materials import PairConstants
from roughcontact.errors import InputError, argument

# Wave number times cell side, small enough for the spectrum of the body without the cells, and the relative change of
# the modulus below which a body is homogeneous.
_FINE_CELL_PHASE = 1e-3
_HOMOGENEITY_TOLERANCE = 1e-3
# Directions of waves in a quarter turn over which 1/E* is averaged.
_DIRECTIONS = 16
# Phase per cell, rad, of half the sampling wave number, less rounding.
_NYQUIST_PHASE = np.pi * (1.0 - 1e-12)


class InfluenceKernel(Part, abc.ABC):
    """Linear elastic response of the surfaces to pressure.

    A subclass defines `SupportsCoefficients.coefficients`, or `SupportsSpectrum.spectrum`, or both; a
    convolver uses the one it needs. The response is even in x and in y, as for any isotropic body.

    Attributes
    ----------
    edge_shift
        Distance, in cells, by which the edge of a discrete contact lies inside the true edge: 0.018 for
        pressure that is constant on each cell, measured on Hertz's spheres (docs/understand/area.md).

    Examples
    --------
    Springs of 1 µm under the cells:

    >>> import numpy as np
    >>> import roughcontact as rc
    >>> class Springs(rc.InfluenceKernel):
    ...     def spectrum(self, qx, qy, spacing, compliance):
    ...         return np.full((qx.shape[0], qy.shape[1]), 1e-6 * compliance)
    >>> body = rc.Body(rc.WavySurface(1e-9, 50e-6), rc.Elastic(210e9, 0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic", kernel=Springs())
    >>> problem.solve(pressure=10e6).status.success
    True
    """

    edge_shift: ClassVar[float] = 0.018

    def effective_modulus(self, wavenumber: Array, compliance: float) -> Array | None:
        """Return the contact modulus E*(q) = 2 / (q u(q)), u(q) the displacement by a unit pressure wave.

        The area estimators need it at the edge of a contact and at the size of a contact patch. By default it follows
        from the spectrum, on cells much smaller than each wave, as the inverse of the mean of 1/E* over the directions;
        a kernel without a spectrum defines it if it depends on the wave.

        Parameters
        ----------
        wavenumber
            Wave numbers q, shape (n,), rad/m, above zero.
        compliance
            1/E* of the two half-spaces together, 1/Pa.

        Returns
        -------
        Array or None
            Moduli, shape (n,), Pa; None if all waves have E* = 1/compliance.
        """
        if not isinstance(self, SupportsSpectrum):
            return None
        angles = 0.5 * np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
        along = np.cos(angles)[:, np.newaxis]
        across = np.sin(angles)[np.newaxis, :]
        cells = _FINE_CELL_PHASE / wavenumber
        waves = zip(wavenumber, cells, strict=True)
        spectra = [self.spectrum(q * along, q * across, (cell, cell), compliance) for q, cell in waves]
        amplitudes = [np.diagonal(spectrum).mean() for spectrum in spectra]
        with np.errstate(divide="ignore"):
            moduli = 2.0 / (wavenumber * np.array(amplitudes))
        even = bool(np.all(np.abs(moduli * compliance - 1.0) < _HOMOGENEITY_TOLERANCE))
        return None if even else np.asarray(moduli)

    def directional_modulus(self, angle: Array, compliance: float) -> Array | None:
        """Return the contact modulus of waves by their direction, which an anisotropic body changes.

        The area estimators need it at an edge of a contact, which meets the modulus of the waves at right angles to it,
        and for the ellipse of a summit. A kernel that defines it defines `effective_modulus` as the inverse of the mean
        of 1/E* over the directions.

        Parameters
        ----------
        angle
            Angles of the wave vectors from the x axis, shape (n,), rad.
        compliance
            1/E* of the two half-spaces together, 1/Pa.

        Returns
        -------
        Array or None
            Moduli, shape (n,), Pa; None, the default, if it is the same in all directions.
        """
        return None

    def part_of(self, body: str) -> InfluenceKernel | None:
        """Return the kernel that describes one of the bodies alone, for the stress below its surface.

        Parameters
        ----------
        body
            ``"body"`` or ``"counterbody"``.

        Returns
        -------
        InfluenceKernel or None
            The kernel, `Love` for a homogeneous half-space; None, the default, if this one does not tell the bodies
            apart.
        """
        return None


kernels = Registry(InfluenceKernel, "kernel", "roughcontact.kernels")


@runtime_checkable
class SupportsCoefficients(Protocol):
    """A kernel known in real space: needed on a free and on a wrapped boundary."""

    def coefficients(self, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients.

        Parameters
        ----------
        shape
            Number of offsets (nx, ny): 0 .. nx-1 cells along x, 0 .. ny-1 along y.
        spacing
            Sides of a cell (dx, dy), m.
        compliance
            1/E* of the two half-spaces together, 1/Pa.

        Returns
        -------
        Array
            Displacement at the centre of the cell (i, j) by unit pressure on the cell (0, 0), shape
            (nx, ny), m/Pa.
        """


@runtime_checkable
class SupportsRows(Protocol):
    """A kernel that knows its coefficients from any row on: an optional ability, which saves memory on slabs."""

    def coefficients_from(self, first: int, shape: tuple[int, int], spacing: Pair, compliance: float) -> Array:
        """Return the influence coefficients of the rows from the first one on.

        Parameters
        ----------
        first
            Offset of the first row along x, in cells.
        shape, spacing, compliance
            As for `SupportsCoefficients.coefficients`: of the offsets first .. first + nx - 1 along x.

        Returns
        -------
        Array
            Shape (nx, ny), m/Pa.
        """


def knows_own_rows(kernel: SupportsRows) -> bool:
    """Return whether `coefficients_from` is that of the kernel, and not of a class whose coefficients it replaces."""
    for kind in type(kernel).__mro__:
        if "coefficients_from" in vars(kind):
            return True
        if "coefficients" in vars(kind):
            return False
    return True


@runtime_checkable
class SupportsSpectrum(Protocol):
    """A kernel known in Fourier space: needed on a periodic boundary."""

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        """Return the amplitude of the displacement by a pressure wave of unit amplitude.

        Parameters
        ----------
        qx, qy
            Angular wave numbers along x, shape (m, 1), and along y, shape (1, n), rad/m, at most
            half the sampling wave number. The value at qx = qy = 0 is not used.
        spacing, compliance
            As for `SupportsCoefficients.coefficients`.

        Returns
        -------
        Array
            Amplitudes at the cell centres, real, shape (m, n), m/Pa.
        """


@runtime_checkable
class SupportsShear(Protocol):
    """A kernel that knows the response to shear too: an optional ability, needed for friction.

    A component such as ``"zx"`` is the displacement along its first letter by a unit shear along its second: ``"xx"``,
    ``"yy"``, ``"xy"``, ``"zx"`` and ``"zy"``. It is odd in x, or in y, if the letter occurs an odd number of times.
    The others follow: yx is xy, and xz and yz, the tangential displacements by pressure, are -zx and -zy. For the signs
    see `PairConstants`.
    """

    def shear_coefficients(
        self, component: str, shape: tuple[int, int], spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return the influence coefficients of a component.

        Parameters
        ----------
        component
            The letters of displacement and shear.
        shape, spacing, compliance
            As for `SupportsCoefficients.coefficients`.
        pair
            The constants of the two materials.

        Returns
        -------
        Array
            Displacement at the centre of the cell (i, j) by unit shear on the cell (0, 0), shape (nx, ny), m/Pa;
            zero at offset zero along an axis in which the component is odd.
        """

    def shear_spectrum(
        self, component: str, qx: Array, qy: Array, spacing: Pair, compliance: float, pair: PairConstants
    ) -> Array:
        """Return the amplitude of a component for a wave of unit shear.

        Parameters
        ----------
        component, pair
            As for `shear_coefficients`.
        qx, qy, spacing, compliance
            As for `SupportsSpectrum.spectrum`. At half the sampling wave number along an axis in which the component is
            odd the value is not used.

        Returns
        -------
        Array
            Amplitudes at the cell centres, of the odd components zx and zy their imaginary parts, shape (m, n), m/Pa.
        """


def odd_axes(component: str) -> tuple[bool, bool]:
    """Return whether a component is odd in x, and in y."""
    return component.count("x") % 2 == 1, component.count("y") % 2 == 1


def is_at_nyquist(wavenumber: Array, step: float) -> Mask:
    """Return whether waves, rad/m, are at half the sampling wave number of cells with a side."""
    return np.asarray(np.abs(wavenumber) * step >= _NYQUIST_PHASE)


_MISSING_FORMS: dict[type, str] = {
    SupportsCoefficients: f"real-space coefficients, which this boundary needs: use {argument('boundary', 'periodic')}",
    SupportsSpectrum: f"spectrum, which the periodic boundary needs: use {argument('boundary', 'wrapped')} or 'free',",
    SupportsShear: f"response to shear, which friction needs: use {argument('kernel', 'love')}",
}


def require_form(kernel: InfluenceKernel, form: type) -> InfluenceKernel:
    """Return the kernel if it has the form, such as `SupportsCoefficients`, or raise `InputError`."""
    if not isinstance(kernel, form):
        raise missing_form(kernel, form)
    return kernel


def missing_form(kernel: InfluenceKernel, form: type) -> InputError:
    """Return the error of a kernel without a form."""
    return InputError(f"The kernel {kernel!r} has no {_MISSING_FORMS[form]} or another kernel.")


def _exchange_axes(spectrum: Spectrum) -> Spectrum:
    return lambda qx, qy, spacing: spectrum(qy.T, qx.T, spacing[::-1]).T


def _sum_mixed(coefficients: Array, grid: Grid, boundary: Boundary, odd: tuple[bool, bool]) -> Array:
    """Return the field of which coefficients along the free axis have the amplitudes along the periodic one."""
    free = boundary.free_axis
    values = coefficients if free == 0 else coefficients.T
    n = grid.shape[1 - free]
    phases = 2.0 * np.pi * np.outer(np.arange(n // 2 + 1) / n, np.arange(n))
    # Half of the waves are stored; each counts twice, except the first and, if even, the last.
    weights = np.full((n // 2 + 1, 1), 2.0 / n)
    weights[0] = 1.0 / n
    if n % 2 == 0:
        weights[-1] = 1.0 / n
    total = matrix_product(values, weights * (np.sin(phases) if odd[1 - free] else np.cos(phases)))
    if odd[1 - free] and not odd[free]:
        total = -total
    return total if free == 0 else np.ascontiguousarray(total.T)


def _sum_waves(spectrum: Callable[[Array, Array, Pair], Array], grid: Grid, odd: tuple[bool, bool]) -> Array:
    """Return the field of which a spectrum has the amplitudes, shape (nx, ny)."""
    waves = [2.0 * np.pi * np.asarray(np.fft.fftfreq(n), dtype=np.float64) for n in grid.shape]
    qx, qy = (wave / step for wave, step in zip(waves, grid.spacing, strict=True))
    amplitudes = spectrum(qx[:, np.newaxis], qy[np.newaxis, :], grid.spacing)
    # An even response has no sines, an odd one has them alone: in both axes times i, or with an imaginary amplitude.
    phases = [np.outer(np.arange(wave.size), wave) for wave in waves]
    x, y = (np.sin(phase) if is_odd else np.cos(phase) for phase, is_odd in zip(phases, odd, strict=True))
    total = matrix_product(matrix_product(x, amplitudes), y.T) / grid.cells
    return -total if any(odd) else total


@attrs.frozen
class BoundKernel:
    """A kernel with the compliance of the two bodies; `InputError` if the kernel lacks the form that is needed.

    Parameters
    ----------
    kernel
        The kernel.
    compliance
        1/E*, 1/Pa.
    unit
        Unit of the returned values, m/Pa.
    pair
        The constants of the two materials that the response to shear needs.
    datum
        Distance, m, at which the displacement by a line load is zero, on a domain that is free along one axis and
        periodic along the other; by default the length of the domain along the free one.
    """

    kernel: InfluenceKernel
    compliance: float = 1.0
    unit: float = 1.0
    pair: PairConstants = attrs.field(factory=PairConstants)
    datum: float | None = None

    def coefficients(self, shape: tuple[int, int], spacing: Pair, first: int = 0) -> Array:
        """Return the influence coefficients from a row on, finite, shape (nx, ny); see `SupportsCoefficients`."""
        kernel: Any = require_form(self.kernel, SupportsCoefficients)
        if first and isinstance(kernel, SupportsRows) and knows_own_rows(kernel):
            return self._check(kernel.coefficients_from(first, shape, spacing, self.compliance), shape)
        whole = first + shape[0], shape[1]
        return self._check(kernel.coefficients(whole, spacing, self.compliance), whole)[first:]

    def spectrum(self, qx: Array, qy: Array, spacing: Pair) -> Array:
        """Return the spectrum, finite, shape (m, n), zero at q = 0; see `SupportsSpectrum`.

        A uniform pressure moves a periodic half-space by an arbitrary amount, here zero.
        """
        kernel: Any = require_form(self.kernel, SupportsSpectrum)
        with np.errstate(divide="ignore", invalid="ignore"):
            values = kernel.spectrum(qx, qy, spacing, self.compliance)
        mean = np.ix_(np.flatnonzero(qx == 0.0), np.flatnonzero(qy == 0.0))
        return self._check(values, (qx.shape[0], qy.shape[1]), unused=mean)

    def shear_coefficients(self, component: str, shape: tuple[int, int], spacing: Pair) -> Array:
        """Return the coefficients of a component, finite, shape (nx, ny); see `SupportsShear`."""
        kernel: Any = require_form(self.kernel, SupportsShear)
        values = kernel.shear_coefficients(component, shape, spacing, self.compliance, self.pair)
        return self._check(values, shape, component)

    def shear_spectrum(self, component: str, qx: Array, qy: Array, spacing: Pair) -> Array:
        """Return the amplitudes of a component, finite, shape (m, n), zero at q = 0; see `SupportsShear`.

        Those odd along an axis are zero at half the sampling wave number there, where a wave vanishes between the
        cell centres.
        """
        kernel: Any = require_form(self.kernel, SupportsShear)
        with np.errstate(divide="ignore", invalid="ignore"):
            given = kernel.shear_spectrum(component, qx, qy, spacing, self.compliance, self.pair)
        unused = (qx == 0.0) & (qy == 0.0)
        for wave, step, odd in zip((qx, qy), spacing, odd_axes(component), strict=True):
            unused = unused | (odd & is_at_nyquist(wave, step))
        return self._check(given, (qx.shape[0], qy.shape[1]), component, unused=unused)

    def responses(self, grid: Grid, boundary: Boundary) -> Array:
        """Return the displacement by unit pressure at each offset within a grid, shape (nx, ny).

        On a periodic axis it is a sum of cosines, without the transforms of a convolver, which can be compared with it.
        """
        if boundary.mixed:
            return _sum_mixed(self.mixed_coefficients(grid, boundary), grid, boundary, (False, False))
        if boundary is not Boundary.PERIODIC:
            return self.coefficients(grid.shape, grid.spacing)
        return _sum_waves(self.spectrum, grid, (False, False))

    def shear_responses(self, component: str, grid: Grid, boundary: Boundary) -> Array:
        """Return a component of the response to shear at each offset within a grid, shape (nx, ny); see `responses`."""
        odd = odd_axes(component)
        if boundary.mixed:
            return _sum_mixed(self.mixed_coefficients(grid, boundary, component), grid, boundary, odd)
        if boundary is not Boundary.PERIODIC:
            return self.shear_coefficients(component, grid.shape, grid.spacing)
        return _sum_waves(partial(self.shear_spectrum, component), grid, odd)

    def mixed_coefficients(
        self,
        grid: Grid,
        boundary: Boundary,
        component: str = "zz",
        offsets: int | None = None,
        part: slice = slice(None),
    ) -> Array:
        """Return the response at each offset along the free axis to the waves along the periodic one.

        Shape (nx, ny // 2 + 1), or (nx // 2 + 1, ny) if y is the free axis, m/Pa.

        Parameters
        ----------
        grid, boundary
            The grid, and its boundary, free along one axis and periodic along the other.
        component
            The letters of displacement and traction.
        offsets
            Number of offsets along the free axis, by default those within the grid.
        part
            The waves, by default all.
        """
        free = boundary.free_axis
        spectrum = self.spectrum if component == "zz" else partial(self.shear_spectrum, component)
        waves = 2.0 * np.pi / grid.spacing[1 - free] * np.asarray(np.fft.rfftfreq(grid.shape[1 - free]))
        values = mixed_coefficients(
            spectrum if free == 0 else _exchange_axes(spectrum),
            offsets or grid.shape[free],
            waves,
            grid.spacing if free == 0 else grid.spacing[::-1],
            self.datum or grid.size[free],
            odd=odd_axes(component)[free],
            part=part,
        )
        return values if free == 0 else np.ascontiguousarray(values.T)

    def _check(self, given: Array, shape: tuple[int, int], component: str = "zz", unused: Any = None) -> Array:
        """Return a copy of values in the unit, zero where they are unused; `InputError` unless it is finite."""
        values = returned_array(given, shape, f"The kernel {self.kernel!r}")
        scaled = np.divide(values, self.unit, dtype=np.float64)
        if unused is not None:
            scaled[unused] = 0.0
        # Only a displacement along the load is above zero somewhere.
        along = component[0] == component[1]
        low = float(scaled.min(initial=0.0))
        high = float(scaled.max(initial=0.0))
        if not (math.isfinite(low) and math.isfinite(high)) or (along and not high > 0.0):
            raise InputError(f"The kernel {self.kernel!r} returned values that are not finite, or none above zero.")
        return scaled
