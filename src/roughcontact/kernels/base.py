"""The kernel interface: real-space coefficients, a spectrum, or both."""

from __future__ import annotations

import abc
from typing import ClassVar, Protocol, runtime_checkable

import attrs
import numpy as np

from roughcontact.checks import Array, Pair
from roughcontact.errors import InputError


class InfluenceKernel(abc.ABC):  # noqa: B024 - a kernel offers either method below, or both
    """Linear response of the surfaces to pressure.

    A subclass defines `OffersCoefficients.coefficients`, or `OffersSpectrum.spectrum`, or both; a
    convolver asks for the one it needs. The response must be even in x and in y, as that of any
    isotropic body is.

    Attributes
    ----------
    edge_shift
        How far inside the true edge of a contact the kernel's discrete solutions put it, in cells; as
        measured on spheres for a pressure that is constant on each cell, unless the kernel says otherwise.
    """

    edge_shift: ClassVar[float] = 0.018


@runtime_checkable
class OffersCoefficients(Protocol):
    """A kernel that is known in real space (needed for the boundaries 'free' and 'wrapped')."""

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
            Displacement at the centre of the cell (i, j) caused by a unit uniform pressure on the
            cell (0, 0), shape (nx, ny), m/Pa.
        """


@runtime_checkable
class OffersSpectrum(Protocol):
    """A kernel that is known in Fourier space (needed for the boundary 'periodic')."""

    def spectrum(self, qx: Array, qy: Array, spacing: Pair, compliance: float) -> Array:
        """Return the displacement amplitude caused by a pressure wave of unit amplitude.

        Parameters
        ----------
        qx, qy
            Angular wave numbers along x, shape (m, 1), and along y, shape (1, n), rad/m, within
            half a sampling wave number of zero. The value at qx = qy = 0 is not used.
        spacing
            Sides of a cell (dx, dy), m, for kernels that take the pressure as constant on a cell.
        compliance
            1/E* of the two half-spaces together, 1/Pa.

        Returns
        -------
        Array
            Amplitudes at the cell centres, real, shape (m, n), m/Pa.
        """


@runtime_checkable
class OffersModulus(Protocol):
    """A kernel whose modulus depends on the length of the waves; that of all others is 1/compliance."""

    def modulus_at(self, length: Array, compliance: float) -> Array:
        """Return the contact modulus E* that waves of the lengths 2 pi `length` meet.

        The estimators of the area need it: at the edge of a contact, and for contacts of a size.

        Parameters
        ----------
        length
            Inverse wave numbers, shape (n,), m, above zero.
        compliance
            1/E* of the two half-spaces together, 1/Pa.

        Returns
        -------
        Array
            2 / (q u(q)) for a pressure wave of amplitude one, q = 1 / length, shape (n,), Pa.
        """


@attrs.frozen
class BoundKernel:
    """A kernel with the bodies' compliance put in: what a convolver plans.

    Parameters
    ----------
    kernel
        The kernel.
    compliance
        1/E*, 1/Pa.
    unit
        The displacement per pressure, m/Pa, that counts as one.
    """

    kernel: InfluenceKernel
    compliance: float = 1.0
    unit: float = 1.0

    def coefficients(self, shape: tuple[int, int], spacing: Pair) -> Array:
        """Return the influence coefficients in the chosen unit; see `OffersCoefficients`.

        Raises
        ------
        InputError
            If the kernel has none, or they are not finite.
        """
        if not isinstance(self.kernel, OffersCoefficients):
            raise InputError(
                f"The kernel {self.kernel!r} offers no real-space coefficients, which this boundary needs: "
                "use boundary='periodic' or another kernel."
            )
        values = self.kernel.coefficients(shape, spacing, self.compliance)
        return self._checked(values, shape)

    def spectrum(self, qx: Array, qy: Array, spacing: Pair) -> Array:
        """Return the spectrum in the chosen unit, zero at q = 0; see `OffersSpectrum`.

        The mean of the pressure moves a periodic surface by any amount, so it is left out.

        Raises
        ------
        InputError
            If the kernel has none, or it is not finite.
        """
        if not isinstance(self.kernel, OffersSpectrum):
            raise InputError(
                f"The kernel {self.kernel!r} offers no spectrum, which the periodic boundary needs: "
                "use boundary='wrapped' or 'free', or another kernel."
            )
        with np.errstate(divide="ignore", invalid="ignore"):
            values = np.array(self.kernel.spectrum(qx, qy, spacing, self.compliance), dtype=np.float64)
        shape = (qx.shape[0], qy.shape[1])
        if values.shape == shape:
            values[np.broadcast_to((qx == 0.0) & (qy == 0.0), shape)] = 0.0
        return self._checked(values, shape)

    def _checked(self, values: Array, shape: tuple[int, int]) -> Array:
        values = np.asarray(values)
        if values.shape != shape or values.dtype.kind != "f":
            raise InputError(
                f"The kernel {self.kernel!r} returned an array of shape {values.shape} and type {values.dtype}, "
                f"where real numbers of shape {shape} are needed."
            )
        scaled = values / self.unit
        if not np.isfinite(scaled).all() or not scaled.max() > 0.0:
            raise InputError(f"The kernel {self.kernel!r} returned values that are not finite, or none above zero.")
        return scaled
