"""The conditions of contact on small grids by dense matrices in extended precision.

Nothing is the package's own but the periodic spectrum of Love's kernel, which test_kernels judges.
"""

from __future__ import annotations

import attrs
import numpy as np

# The package's documented promises: the gate, its margin, and what rounding may hide.
TOLERANCE = 1e-8
UNRESOLVED = 1e-5
LOAD = 1e-12
# Rounding of fields that were computed in float64, in units of the last place of the largest.
PLACES = 64.0


@attrs.frozen
class Violations:
    """What is left of a solution's promises, lengths in units of the documented scale."""

    complementarity: float
    penetration: float
    load: float
    bounds: bool
    floor: float

    @property
    def error(self):
        return max(self.complementarity, self.penetration)

    def allowed(self, status):
        """The greatest error that the status allows."""
        margin = 2.0 * TOLERANCE + self.floor
        return max(margin, 2.0 * UNRESOLVED) if "rounding" in str(status) else margin

    def holds(self, status):
        return self.bounds and self.load <= LOAD and self.error <= self.allowed(status)


def love(i, j, aspect):
    """The corner sum for cells (1, aspect) at offsets in cells, E* = 1; it cancels, hence extended precision."""

    def corner(x, y):
        with np.errstate(divide="ignore", invalid="ignore"):
            one = np.where(x == 0, 0, x * np.arcsinh(y / np.abs(x)))
            other = np.where(y == 0, 0, y * np.arcsinh(x / np.abs(y)))
        return one + other

    x, y, a = (np.asarray(value, dtype=np.longdouble) for value in (i, j, aspect))
    half = np.longdouble(0.5)
    total = sum(s * t * corner(x + s * half, (y + t * half) * a) for s in (-1, 1) for t in (-1, 1))
    return total / np.longdouble(np.pi)


def waves(problem):
    """Amplitudes of all waves of a periodic grid in cells along x and E* = 1; the mean has none."""
    (nx, ny), (dx, dy) = problem.plan.grid.shape, problem.plan.grid.spacing
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, step) for n, step in ((nx, 1.0), (ny, dy / dx)))
    with np.errstate(divide="ignore"):
        if problem.kernel == "fourier":
            found = 2.0 / np.hypot(qx[:, None], qy)
        else:
            found = problem.plan.kernel.spectrum(qx[:, None], qy[None, :], (1.0, dy / dx), 1.0)
    found[0, 0] = 0.0
    return found


def matrix(problem):
    """Displacement over pressure, cells (nx ny) by cells, in cells along x and E* = 1."""
    nx, ny = problem.plan.grid.shape
    dx, dy = problem.plan.grid.spacing
    offsets = [np.arange(n)[:, None] - np.arange(n) for n in (nx, ny)]
    if str(problem.boundary) == "periodic":
        x, y = (
            np.exp(2j * np.pi * np.fft.fftfreq(n)[None, :] * np.arange(n)[:, None]).astype(np.clongdouble)
            for n in (nx, ny)
        )
        table = (x @ waves(problem) @ y.T).real / (nx * ny)
        i, j = offsets[0] % nx, offsets[1] % ny
        return table[i[:, None, :, None], j[None, :, None, :]].reshape(nx * ny, nx * ny)
    i, j = np.abs(offsets[0]), np.abs(offsets[1])
    if str(problem.boundary) == "wrapped":
        i, j = np.minimum(i, nx - i), np.minimum(j, ny - j)
    table = love(np.arange(nx)[:, None], np.arange(ny)[None, :], dy / dx)
    return table[i[:, None, :, None], j[None, :, None, :]].reshape(nx * ny, nx * ny)


def violations(problem, load, solution):
    """Judge a solution by its pressure alone."""
    dx = problem.plan.grid.spacing[0]
    modulus, limit = problem.plan.modulus, np.broadcast_to(problem.plan.limit, solution.pressure.shape).ravel()
    pressure = solution.pressure.ravel()
    total = problem.body.surface.values + np.zeros(problem.plan.grid.shape)
    undeformed = (total.max() - total).ravel().astype(np.longdouble)
    moved = matrix(problem) @ pressure.astype(np.longdouble) * np.longdouble(dx / modulus)
    level = moved + undeformed
    capped = pressure >= limit
    bearing = np.where(capped, 0.0, pressure)
    if "approach" in load:
        datum, off = np.longdouble(load["approach"]), 0.0
    else:
        off = abs(float(np.mean(pressure.astype(np.longdouble)) / np.longdouble(load["pressure"])) - 1.0)
        if bearing.any():
            datum = np.sum(bearing * level) / np.sum(bearing)
        else:
            datum = level[capped].max() if capped.all() else min(level[capped].max(), level[pressure <= 0].min())
    gap = level - datum
    bend = np.ptp(moved) if np.ptp(moved) > 1e-12 * pressure.max() * dx / modulus else 0.0
    relief = np.std(undeformed)
    scale = min(relief, bend) or max(relief, bend)
    wrong = np.where(capped, np.maximum(gap, 0), np.abs(gap))
    opened = float(np.sum(pressure * wrong) / pressure.sum() / scale) if pressure.any() else 0.0
    closed = float(max(0.0, -gap[~capped].min(initial=np.inf)) / scale)
    largest = np.abs(moved).max() + undeformed.max() + abs(datum)
    return Violations(
        complementarity=opened,
        penetration=closed,
        load=off,
        bounds=bool((pressure >= 0).all() and (pressure <= limit).all()),
        floor=float(PLACES * np.finfo(float).eps * largest / scale),
    )
