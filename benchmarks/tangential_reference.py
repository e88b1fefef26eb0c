"""Tangential tractions of like bodies in both directions, by minimizing the energy: answers for `response_classes.py`.

E* = 1 Pa, and the bodies stick or slide as Coulomb has it: nothing here is shared with the package.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

Array = np.ndarray


class TangentialKernel:
    """Displacement by traction along an axis and across it, for two bodies of one Poisson's ratio."""

    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float], poisson: float, axis: int, periodic: bool):
        self.shape, self.padded = shape, shape if periodic else (2 * shape[0], 2 * shape[1])
        parts = self._periodic(spacing) if periodic else self._free(spacing)
        # Normal pressure, waves along x and along y, and the product of both.
        self.normal, along_x, along_y, self.mixed = parts
        first, second = (along_x, along_y) if axis == 0 else (along_y, along_x)
        stiff, soft = 1.0 / (1.0 - poisson), poisson / (1.0 - poisson)
        self.symbols = (
            stiff * self.normal - soft * first,
            -soft * self.mixed,
            stiff * self.normal - soft * second,
        )

    def _periodic(self, spacing: tuple[float, float]) -> tuple[Array, ...]:
        qx = 2 * np.pi * np.fft.fftfreq(self.shape[0], spacing[0])[:, None]
        qy = 2 * np.pi * np.fft.rfftfreq(self.shape[1], spacing[1])[None]
        length = np.hypot(qx, qy)
        length[0, 0] = 1.0
        normal = 2.0 / length
        normal[0, 0] = 0.0
        mixed = normal * qx * qy / length**2
        if self.shape[0] % 2 == 0:
            mixed[self.shape[0] // 2] = 0.0
        if self.shape[1] % 2 == 0:
            mixed[:, -1] = 0.0
        return normal, normal * qx**2 / length**2, normal * qy**2 / length**2, mixed

    def _free(self, spacing: tuple[float, float]) -> tuple[Array, ...]:
        x, y = ((np.arange(n + 1) - 0.5) * d for n, d in zip(self.shape, spacing, strict=True))
        x, y = x[:, None], y[None]
        tables = x * np.arcsinh(y / np.abs(x)), y * np.arcsinh(x / np.abs(y)), np.hypot(x, y)
        along_x, along_y, mixed = (np.diff(np.diff(table, axis=0), axis=1) / np.pi for table in tables)
        extended = [self._extend(along_x, 1.0), self._extend(along_y, 1.0), self._extend(mixed, -1.0)]
        return extended[0] + extended[1], *extended

    def _extend(self, table: Array, sign: float) -> Array:
        n, m = self.shape
        whole = np.zeros(self.padded)
        whole[:n, :m], whole[n + 1 :, :m] = table, sign * table[:0:-1]
        whole[:n, m + 1 :], whole[n + 1 :, m + 1 :] = sign * table[:, :0:-1], table[:0:-1, :0:-1]
        return np.fft.rfft2(whole).real

    def convolve(self, symbol: Array, field: Array) -> Array:
        """Return the field multiplied by a symbol wave by wave."""
        return np.fft.irfft2(symbol * np.fft.rfft2(field, self.padded), self.padded)[: self.shape[0], : self.shape[1]]

    def apply(self, traction: Array) -> Array:
        """Return the displacement along and across, shape (2, nx, ny)."""
        first, second = (np.fft.rfft2(part, self.padded) for part in traction)
        xx, xy, yy = self.symbols
        waves = xx * first + xy * second, xy * first + yy * second
        return np.array([np.fft.irfft2(part, self.padded)[: self.shape[0], : self.shape[1]] for part in waves])


def _conjugate_gradients(apply: Callable, condition: Callable, right: Array) -> tuple[Array, Array]:
    """Return the solution of a linear system, and its residual."""
    found, residual = np.zeros_like(right), right
    image = direction = condition(residual)
    product = np.vdot(image, residual)
    goal = 1e-6 * math.sqrt(np.vdot(right, right))
    for _ in range(500):
        response = apply(direction)
        step = product / np.vdot(direction, response)
        found, residual = found + step * direction, residual - step * response
        if math.sqrt(np.vdot(residual, residual)) < goal:
            break
        image = condition(residual)
        previous, product = product, np.vdot(image, residual)
        direction = image + product / previous * direction
    return found, residual


def tangential_ratio(cells: Array, spacing: tuple[float, float], poisson: float, axis: int, periodic: bool) -> float:
    """Return the tangential over the normal stiffness of cells without slip, under no force across the axis."""
    kernel = TangentialKernel(cells.shape, spacing, poisson, axis, periodic)
    positive = np.maximum(kernel.normal, 1e-9 * kernel.normal.max())
    inverse = 1.0 / positive
    inverse[0, 0] = 0.0 if periodic else inverse[0, 0]

    def condition(field: Array) -> Array:
        return np.array([kernel.convolve(inverse, part) * cells for part in field])

    def press(field: Array) -> Array:
        return np.array([kernel.convolve(kernel.normal, field[0]) * cells])

    normal, rest = _conjugate_gradients(press, condition, np.array([1.0 * cells]))
    pressed = float(np.sum(normal[0] * (1.0 + rest[0])))
    stiffness = np.zeros((2, 2))
    for column in (0, 1):
        right = np.zeros((2, *cells.shape))
        right[column] = cells
        found, rest = _conjugate_gradients(lambda field: kernel.apply(field) * cells, condition, right)
        stiffness[column, column] = float(np.sum(found * (right + rest)))
        stiffness[1 - column, column] = float(np.sum(found[1 - column]))
    return 1.0 / float(np.linalg.inv(stiffness)[0, 0]) / pressed


def slide(kernel: TangentialKernel, limit: Array, displacement: float, start: Array) -> Array:
    """Return the tractions by a displacement along the axis, under no force across it, shape (2, nx, ny).

    Spectral projected gradients: each traction is at most the limit, and against the slip where it reaches it.
    """
    traction, rigid = np.array([start, 0.0 * start]), np.array([displacement, 0.0])
    for _ in range(3):
        traction = _project_gradients(kernel, limit, rigid, traction)
        forces = traction.sum(axis=(1, 2))
        rigid = rigid - np.array([0.0, forces[1] / forces[0] * displacement])
    return traction


def _project_gradients(kernel: TangentialKernel, limit: Array, rigid: Array, traction: Array) -> Array:
    def project(field: Array) -> Array:
        size = np.hypot(*field)
        return field * np.where(size > limit, limit / np.maximum(size, 1e-300), 1.0)

    traction = project(traction)
    gradient = kernel.apply(traction) - rigid[:, None, None]
    length = 1e-2 * limit.max() / abs(rigid[0])
    for _ in range(2000):
        step = project(traction - length * gradient) - traction
        response = kernel.apply(step)
        curvature = np.vdot(step, response)
        size = min(1.0, -np.vdot(gradient, step) / curvature) if curvature > 0.0 else 1.0
        traction, gradient = traction + size * step, gradient + size * response
        length = np.vdot(step, step) / max(curvature, 1e-300)
        if np.abs(project(traction - length * gradient) - traction).max() < 1e-5 * limit.max():
            break
    return traction
