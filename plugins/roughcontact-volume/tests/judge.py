"""Whether a body that yields is in the state that is returned of it: from its fields alone, sharing no code with them.

Stresses by an eigenstrain are those of waves along the surface, of which the displacement over the depth is found by
finite elements of order ten from the virtual work alone; those of a pressure on a free half-space, and the
displacements by it, are Love's terms, integrated over the depth by Gauss points.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import solveh_banded
from scipy.signal import convolve

Array = np.ndarray

# Of xx, yy, zz, yz, xz, xy: a shear counts twice in the work.
WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
ORDER = 10
# Elements are at most so many radians long, and so many reach below the last layer, where all has decayed.
LENGTH, BELOW = 4.0, 9
# Points over the depth of a layer, at which Love's terms are evaluated.
POINTS = 24
# Aliases of a wave that are summed up, of which two sums are extrapolated.
ALIASES = 64
# Images along an axis that repeats beside one that is free, of which three sums are extrapolated.
IMAGES = (5, 10, 20)
# Two periods of a body that is free beyond its cells, over these cells or the depth of its layers, by its free axes:
# images act with the third power of their distance, lines of them with the second.
LONG_PERIODS = {1: (9, 15), 2: (3, 5)}


def _lobatto() -> tuple[Array, Array, Array]:
    """Return values and derivatives of Lagrange's polynomials at Gauss points, and the weights, on 0 .. 1."""
    series = np.zeros(ORDER + 1)
    series[-1] = 1.0
    nodes = np.concatenate(([-1.0], np.sort(legendre.legroots(legendre.legder(series)).real), [1.0]))
    at, weight = legendre.leggauss(ORDER + 2)
    inverse = np.linalg.inv(legendre.legvander(nodes, ORDER))
    unit = np.eye(ORDER + 1)
    slope = np.stack([legendre.legval(at, legendre.legder(one)) for one in unit], axis=1)
    return legendre.legvander(at, ORDER) @ inverse, 2 * slope @ inverse, weight / 2


VALUES, SLOPES, QUADRATURE = _lobatto()


def respond_to_wave(qx: float, qy: float, thicknesses: tuple[float, ...], poisson: float) -> Array:
    """Return stress and surface displacement by strain and pressure of a wave, for a shear modulus of one.

    Rows and columns are the components of the first layer, of the second, ..., at last the displacement and the
    pressure.
    """
    q = math.hypot(qx, qy)
    pieces = [max(1, math.ceil(q * t / LENGTH)) for t in thicknesses]
    lengths = [t / count for t, count in zip(thicknesses, pieces, strict=True) for _ in range(count)]
    layers = [layer for layer, count in enumerate(pieces) for _ in range(count)]
    lengths += [LENGTH / q if q > 0 else sum(thicknesses)] * BELOW
    stiffness = 2.0 * np.eye(6)
    stiffness[:3, :3] += 2 * poisson / (1 - 2 * poisson)
    work = WEIGHTS[:, None] * stiffness
    size = 3 * ORDER * len(lengths) + 3
    block = 3 * ORDER + 3
    band = np.zeros((block, size))
    right = np.zeros((size, 6 * len(thicknesses) + 1))
    row, column = np.tril_indices(block)
    for number, length in enumerate(lengths):
        strain = _strain_of(qx, qy, length)
        start = 3 * ORDER * number
        weighted = length * QUADRATURE[:, None, None] * np.swapaxes(strain, 1, 2) @ work
        local = np.tensordot(weighted, strain, axes=((0, 2), (0, 1)))
        band[row - column, start + column] += local[row, column]
        if number < len(layers):
            right[start : start + block, 6 * layers[number] :][:, :6] += weighted.sum(axis=0)
    right[2, -1] = 1.0
    # It is held below.
    solved = np.zeros_like(right)
    solved[:-3] = solveh_banded(band[:, :-3], right[:-3], lower=True)
    response = right.T @ solved
    for layer, thickness in enumerate(thicknesses):
        rows = slice(6 * layer, 6 * layer + 6)
        response[rows] /= (WEIGHTS * thickness)[:, None]
        response[rows, rows] -= stiffness
    phase = np.array([1, 1, 1, 1j, 1j, 1] * len(thicknesses) + [1])
    return response * phase[:, None] / phase


def _strain_of(qx: float, qy: float, length: float) -> Array:
    """Return the strains of displacements at the nodes of an element, shape (points, 6, nodes x 3).

    Displacements along the surface, and shears with z, are a quarter of a wave ahead: all is real.
    """
    strain = np.zeros((len(QUADRATURE), 6, ORDER + 1, 3))
    slopes = SLOPES / length
    strain[:, 0, :, 0] = -qx * VALUES
    strain[:, 1, :, 1] = -qy * VALUES
    strain[:, 2, :, 2] = slopes
    strain[:, 3, :, 1], strain[:, 3, :, 2] = slopes / 2, qy / 2 * VALUES
    strain[:, 4, :, 0], strain[:, 4, :, 2] = slopes / 2, qx / 2 * VALUES
    strain[:, 5, :, 0], strain[:, 5, :, 1] = -qy / 2 * VALUES, -qx / 2 * VALUES
    return strain.reshape(len(QUADRATURE), 6, -1)


@lru_cache(maxsize=8)
def respond_to_waves(
    period: tuple[int, int], spacing: tuple[float, float], thicknesses: tuple[float, ...], poisson: float
) -> Array:
    """Return the responses of all waves of a period, shape (mx, my // 2 + 1, rows, columns).

    A wave of two cells is seen at its crests alone: the mean over both of its signs.
    """
    mx, my = period
    along = np.fft.fftfreq(mx, spacing[0]) * 2 * np.pi
    across = np.fft.rfftfreq(my, spacing[1]) * 2 * np.pi
    # Signs of the components, and of displacement and pressure, in a mirror across x, and across y.
    mirror_x, mirror_y = (
        np.array([*signs * len(thicknesses), 1]) for signs in ([1, 1, 1, 1, -1, -1], [1, 1, 1, -1, 1, -1])
    )
    found = np.zeros((mx, my // 2 + 1, mirror_x.size, mirror_x.size), complex)
    for i in range(mx // 2 + 1):
        for j, qy in enumerate(across):
            response = respond_to_wave(along[i], qy, thicknesses, poisson)
            mirrored = response * np.outer(mirror_x, mirror_x)
            response = (response + mirrored) / 2 if 2 * i == mx else response
            if 2 * j == my:
                response, mirrored = (one * (1 + np.outer(mirror_y, mirror_y)) / 2 for one in (response, mirrored))
            found[-i, j], found[i, j] = mirrored, response
    # The mean displacement is measured from where the body is not strained, and a mean pressure moves all of it.
    found[0, 0, -1, -1] = 0.0
    return found


def stress_below_cell(x: Array, y: Array, z: Array, spacing: tuple[float, float], poisson: float) -> Array:
    """Return the stress by a unit pressure on a cell around the origin, shape (6, ...).

    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009: derivatives of the
    integrals over the cell of 1/r and of ln(r + z).
    """
    found = np.zeros((6, *np.broadcast_shapes(x.shape, y.shape, z.shape)))
    for sign, a, b in ((1, 1, 1), (-1, 1, -1), (-1, -1, 1), (1, -1, -1)):
        along, across = x - a * spacing[0] / 2, y - b * spacing[1] / 2
        r = np.sqrt(along**2 + across**2 + z**2)
        down = -np.arctan2(along * across, z * r)
        v_xx, v_yy = along / r / (r + across), across / r / (r + along)
        c_xx = np.arctan(across / along) - np.arctan(z * across / along / r)
        c_yy = np.arctan(along / across) - np.arctan(z * along / across / r)
        free = 1 - 2 * poisson
        terms = (
            2 * poisson * down - free * c_xx - z * v_xx,
            2 * poisson * down - free * c_yy - z * v_yy,
            down + z * (v_xx + v_yy),
            -z * z / r / (r + along),
            -z * z / r / (r + across),
            -free * np.log(z + r) - z / r,
        )
        found += sign * np.array(np.broadcast_arrays(*terms))
    return found / 2 / math.pi


@lru_cache(maxsize=8)
def stress_below_cells(
    shape: tuple[int, int], spacing: tuple[float, float], thicknesses: tuple[float, ...], poisson: float
) -> Array:
    """Return the mean stress over each layer by a unit pressure, by the distance, (6, nz, 2 nx - 1, 2 ny - 1)."""
    x, y = (np.arange(1 - n, n) * side for n, side in zip(shape, spacing, strict=True))
    at, weight = legendre.leggauss(POINTS)
    edges = np.concatenate(([0.0], np.cumsum(thicknesses)))
    layers = []
    for top, bottom in itertools.pairwise(edges):
        z = top + (bottom - top) * (at + 1) / 2
        stress = stress_below_cell(x[:, None, None], y[:, None], z, spacing, poisson)
        layers.append(stress @ (weight / 2))
    return np.stack(layers, axis=1)


@lru_cache(maxsize=8)
def stress_below_repeated_cells(
    shape: tuple[int, int], spacing: tuple[float, float], thicknesses: tuple[float, ...], poisson: float, axis: int
) -> Array:
    """Return the same where the cells repeat along an axis: of three numbers of images, extrapolated.

    Stresses fall with the square of the distance, so that those of farther images fall with their number, and its
    square.
    """
    n = shape[axis]
    sums = []
    for images in IMAGES:
        wide = (shape[0] * (images + 1), shape[1]) if axis == 0 else (shape[0], shape[1] * (images + 1))
        table = np.moveaxis(stress_below_cells(wide, spacing, thicknesses, poisson), 2 + axis, -1)
        start = n * images
        total = sum(table[..., start + m * n :][..., : 2 * n - 1] for m in range(-images, images + 1))
        sums.append(np.moveaxis(total, -1, 2 + axis))
    counts = np.array([images + 0.5 for images in IMAGES])
    weights = np.linalg.solve([counts**0, 1 / counts, 1 / counts**2], [1, 0, 0])
    return np.tensordot(weights, sums, axes=1)


def displacement_of_cells(shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return the displacement by a unit pressure on a cell, times E*, by the distance, (2 nx - 1, 2 ny - 1)."""
    x, y = (np.arange(1 - n, n) * side for n, side in zip(shape, spacing, strict=True))
    found = np.zeros((x.size, y.size))
    for sign, a, b in ((1, 1, 1), (-1, 1, -1), (-1, -1, 1), (1, -1, -1)):
        along, across = (x - a * spacing[0] / 2)[:, None], y - b * spacing[1] / 2
        found += sign * (along * np.arcsinh(across / np.abs(along)) + across * np.arcsinh(along / np.abs(across)))
    return found / math.pi


def displacement_of_waves(shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return the displacement by a wave of cell pressures, times E*, of all aliases, shape (nx, ny // 2 + 1)."""
    qx = np.fft.fftfreq(shape[0])[:, None, None] * 2 * np.pi / spacing[0]
    qy = np.fft.rfftfreq(shape[1])[:, None] * 2 * np.pi / spacing[1]

    def sum_up(count: int) -> Array:
        total = np.zeros((shape[0], shape[1] // 2 + 1))
        aliases = np.arange(-count, count + 1)
        across = qy + aliases * 2 * np.pi / spacing[1]
        for m in aliases:
            along = qx + m * 2 * np.pi / spacing[0]
            q = np.hypot(along, across)
            q[q == 0.0] = np.inf
            smooth = np.sinc(along * spacing[0] / 2 / np.pi) * np.sinc(across * spacing[1] / 2 / np.pi)
            total += np.sum(2 * smooth / q, axis=-1)
        return total

    # The remainder falls with the reciprocal of the number, and with its square.
    first, second, third = (sum_up(count) for count in (ALIASES // 4, ALIASES // 2, ALIASES))
    return first / 3 - 2 * second + 8 / 3 * third


class HalfSpace(NamedTuple):
    """A half-space in layers below cells, which repeat along x and along y or not, in any units."""

    shape: tuple[int, int]
    spacing: tuple[float, float]
    thicknesses: tuple[float, ...]
    repeats: tuple[bool, bool]
    young: float
    poisson: float

    def _in_sides(self) -> tuple[tuple[float, float], tuple[float, ...], float]:
        unit = self.spacing[0]
        return (1.0, self.spacing[1] / unit), tuple(t / unit for t in self.thicknesses), self.poisson

    def _extrapolate(self, find: Callable[[tuple[int, int]], Array]) -> Array:
        """Return what a function gives of a period: of two long ones, extrapolated, along axes that do not repeat."""
        free = self.repeats.count(False)
        if not free:
            return find(self.shape)
        depth = sum(self.thicknesses)
        reach = [max(n, math.ceil(depth / side)) for n, side in zip(self.shape, self.spacing, strict=True)]
        odd = [n + 1 - n % 2 for n in reach]
        shorter, longer = (
            find((self.shape[0] if self.repeats[0] else m * odd[0], self.shape[1] if self.repeats[1] else m * odd[1]))
            for m in LONG_PERIODS[free]
        )
        first, second = LONG_PERIODS[free]
        return longer + (longer - shorter) / ((second / first) ** (free + 1) - 1)

    def _transfer(self, fields: Array, columns: slice, rows: slice) -> Array:
        """Return the rows of the response by columns of fields, in units of the shear modulus and of a cell's side."""

        def find(period: tuple[int, int]) -> Array:
            matrices = respond_to_waves(period, *self._in_sides())[..., rows, columns]
            waves = np.moveaxis(np.fft.rfft2(fields, period), 0, -1)[..., None]
            waves = np.moveaxis((matrices @ waves)[..., 0], -1, 0)
            return np.fft.irfft2(waves, period)[:, : self.shape[0], : self.shape[1]]

        return self._extrapolate(find)

    def _love(self) -> Array:
        if any(self.repeats):
            return stress_below_repeated_cells(self.shape, *self._in_sides(), self.repeats.index(True))
        return stress_below_cells(self.shape, *self._in_sides())

    def find_stress(self, strain: Array) -> Array:
        """Return the stress of an eigenstrain, mean over each layer, shape (6, nz, nx, ny)."""
        rows = np.swapaxes(strain, 0, 1).reshape(-1, *self.shape)
        found = self._transfer(rows, slice(-1), slice(-1))
        shear = self.young / 2 / (1 + self.poisson)
        return shear * np.swapaxes(found.reshape(-1, 6, *self.shape), 0, 1)

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface by an eigenstrain, into the body, shape (nx, ny)."""
        unit = self.spacing[0]
        if all(self.repeats):
            rows = np.swapaxes(strain, 0, 1).reshape(-1, *self.shape)
            return unit * self._transfer(rows, slice(-1), slice(-1, None))[0]
        total = np.zeros(self.shape)
        for component, table in enumerate(self._love()):
            for layer, thickness in enumerate(self.thicknesses):
                weight = WEIGHTS[component] * thickness
                total += weight * convolve(table[layer, ::-1, ::-1], strain[component, layer], "valid", "direct")
        return total

    def press(self, pressure: Array) -> Array:
        """Return the stress by a pressure, mean over each layer, shape (6, nz, nx, ny)."""
        if all(self.repeats):
            # The pressure is a load, and the work of unit strains is by stresses over the shear modulus.
            found = self._transfer(pressure[None], slice(-1, None), slice(-1))
            return np.swapaxes(found.reshape(-1, 6, *self.shape), 0, 1)
        layers = [[convolve(table, pressure, "valid", "direct") for table in tables] for tables in self._love()]
        return np.array(layers)

    def sink(self, pressure: Array, modulus: float) -> Array:
        """Return the elastic displacement by a pressure, of both bodies, shape (nx, ny).

        Where one axis is free it is but for a constant.
        """
        if any(self.repeats):

            def find(period: tuple[int, int]) -> Array:
                symbol = displacement_of_waves(period, self.spacing)
                found = np.fft.irfft2(symbol * np.fft.rfft2(pressure, period), period)
                return found[: self.shape[0], : self.shape[1]]

            return self._extrapolate(lambda period: find(period) - find(period).mean()) / modulus
        return convolve(displacement_of_cells(self.shape, self.spacing), pressure, "valid", "direct") / modulus


class State(NamedTuple):
    """What is returned of one step: pressure and gap before contact, plastic strain and its accumulated size.

    Beside the plastic strain a stress may act that was given, shape (6, nz).
    """

    pressure: Array
    heights: Array
    modulus: float
    strain_before: Array
    strain: Array
    accumulated_before: Array
    accumulated: Array
    yield_stress: Callable[[Array], Array]
    given_stress: Array | None = None


class Verdict(NamedTuple):
    """By how much each condition is violated: over the yield stress, over the approach, over the largest pressure."""

    beyond_yield: float
    below_yield: float
    direction: float
    accumulation: float
    volume: float
    recovery: float
    tension: float
    penetration: float
    opening: float

    def find_faults(self, flow: float, contact: float) -> list[str]:
        """Return what is violated by more than allowed."""
        names = self._fields
        limits = [flow] * names.index("tension") + [contact] * (len(names) - names.index("tension"))
        return [
            f"{name} {value:.3g} > {limit:g}"
            for name, value, limit in zip(names, self, limits, strict=True)
            if not value <= limit
        ]


def judge(body: HalfSpace, state: State) -> Verdict:
    """Return by how much a state violates the yield function, the rule of flow, and the conditions of contact."""
    stress = body.press(state.pressure) + body.find_stress(state.strain)
    if state.given_stress is not None:
        stress += state.given_stress[:, :, None, None]
    deviator = stress.copy()
    deviator[:3] -= stress[:3].mean(axis=0)
    mises = np.sqrt(1.5 * np.einsum("c,cijk->ijk", WEIGHTS, deviator**2))
    limit = state.yield_stress(state.accumulated)
    flow = state.strain - state.strain_before
    grown = state.accumulated - state.accumulated_before
    flows = grown > 0
    # Strains as the stresses that they would need.
    stiff = body.young / (1 + body.poisson) / limit
    size = np.sqrt(2 / 3 * np.einsum("c,cijk->ijk", WEIGHTS, flow**2))
    along = 1.5 * grown * deviator / np.where(mises > 0, mises, 1.0)
    sunk = body.sink(state.pressure, state.modulus) + body.displace(state.strain)
    apart = state.heights + sunk
    touches = state.pressure > 0
    approach = float(apart[touches].mean()) if touches.any() else float(apart.min())
    scale = np.ptp(sunk) if np.ptp(sunk) > 0 else 1.0
    largest = max(float(state.pressure.max()), 1e-300)
    return Verdict(
        beyond_yield=float(((mises - limit) / limit).max()),
        below_yield=float((np.abs(mises - limit) / limit)[flows].max(initial=0.0)),
        direction=float((np.sqrt(np.einsum("c,cijk->ijk", WEIGHTS, (flow - along) ** 2)) * stiff).max()),
        accumulation=float((np.abs(size - grown) * stiff).max()),
        volume=float((np.abs(state.strain[:3].sum(axis=0)) * stiff).max()),
        recovery=float((-grown * stiff).max()),
        tension=float(-state.pressure.min() / largest),
        penetration=float((approach - apart).max() / scale),
        opening=float(np.abs(apart - approach)[touches].max(initial=0.0) / scale),
    )
