"""Random adhesive contacts: how many converge, at what cost, and whether what counts as converged is.

    python benchmarks/adhesion_problems.py [first seed] [last seed]

Laws, loads, boundaries, hardness, shapes of domains and of cells, and 0.3 to 20 cells of the cohesive length. The judge
shares no code with the solver: it sums the displacement by another transform, in extended precision, and compares.
"""

from __future__ import annotations

import collections
import math
import sys
import time
from typing import Any

import numpy as np
import scipy.fft

import roughcontact as rc
from roughcontact._parts.interactions import BoundInteraction, Dugdale, Exponential, Interaction, VanDerWaals
from roughcontact._parts.kernels import BoundKernel, FourierHalfSpace, InfluenceKernel, Love
from roughcontact._solve.convolvers import DCFFT, CircularFFT, PreparedConvolution
from roughcontact._solve.solvers import Outcome, Task
from roughcontact._solve.solvers.adhesive import GapDescent

# Errors of the gap over the scale, of the load over that of the contact, and of the law over its strength times the
# range over the scale, above which an outcome is not what it states; multiples of the tolerance of 1e-5.
ALLOWED = 5e-5
LOAD = 1e-10


def make_surface(random: np.random.Generator, grid: rc.Grid) -> np.ndarray:
    """Return the initial gap of a random surface, in cells, at least zero, of a slope of 0.01 to 3."""
    side = min(grid.size)
    kind = random.integers(4)
    if kind == 0:
        x, y = (axis - random.uniform(-0.5, 0.5) for axis in (grid.x, grid.y))
        heights = -0.5 * (x**2 + y**2) / (side * random.uniform(0.5, 4.0))
    elif kind == 1:
        waves = random.integers(1, 4, 2)
        heights = sum(
            np.cos(2.0 * np.pi * count * axis / length)
            for count, axis, length in zip(waves, (grid.x, grid.y), grid.size, strict=True)
        )
    else:
        longest = max(grid.size) * random.uniform(0.5, 1.0)
        shortest = min(max(grid.spacing) * random.uniform(2.5, 8.0), 0.3 * longest)
        hurst = random.uniform(0.2, 1.0)
        surface = rc.SelfAffineSurface(
            hurst=hurst, rms_height=1.0, shortest=shortest, longest=longest, seed=int(random.integers(2**31))
        )
        heights = surface.heights(grid)
    heights = np.broadcast_to(heights, grid.shape)
    slope = math.sqrt(
        sum(float(np.mean(np.diff(heights, axis=axis) ** 2)) / grid.spacing[axis] ** 2 for axis in (0, 1))
    )
    heights = heights * (10.0 ** random.uniform(-2.0, 0.5) / slope)
    return np.asarray(heights.max() - heights)


def make_law(random: np.random.Generator, gap: np.ndarray, cell: float, slope: float) -> tuple[Interaction, float]:
    """Return a random law, in units of the cell and of E*, and the number of cells of its cohesive length."""
    cells = 10.0 ** random.uniform(math.log10(0.3), math.log10(20.0))
    work: Any = slope**2 * 10.0 ** random.uniform(-2.5, 0.7)
    if random.random() < 0.1:
        work = work * (1.0 + 0.5 * np.sin(np.arange(gap.size).reshape(gap.shape) * random.uniform(0.01, 1.0)))
    steepest = 1.0 / (cells * cell)
    largest = float(np.max(work))
    kind = random.integers(3)
    if kind == 0:
        return Exponential(work, math.sqrt(largest / steepest)), cells
    if kind == 1:
        smoothing = random.uniform(0.2, 1.0)
        return Dugdale(work, math.sqrt(4.0 * smoothing * float(np.min(work)) * steepest / math.pi), smoothing), cells
    return VanDerWaals(work, math.sqrt(6.0 * largest / steepest)), cells


def make_problem(seed: int) -> tuple[PreparedConvolution, Task, dict[str, Any]]:
    """Return a random problem and what describes it."""
    random = np.random.default_rng(seed)
    shape = tuple(int(n) for n in random.integers(17, 97, 2))
    if random.random() < 0.2:
        shape = (96, 12) if random.random() < 0.5 else (12, 96)
    spacing = (1.0, float(random.choice([1.0, 1.0, 1.0, 0.5, 2.0, 3.0, 1.0 / 3.0])))
    grid = rc.Grid(shape, (shape[0] * spacing[0], shape[1] * spacing[1]))
    boundary = rc.Boundary(str(random.choice(["periodic", "periodic", "free", "wrapped"])))
    kernel: InfluenceKernel = (
        FourierHalfSpace() if boundary is rc.Boundary.PERIODIC and random.random() < 0.3 else Love()
    )
    convolver = DCFFT() if boundary is rc.Boundary.FREE else CircularFFT()
    convolution = convolver.prepare(BoundKernel(kernel), grid, boundary)
    gap = make_surface(random, grid)
    slope = math.sqrt(sum(float(np.mean(np.diff(gap, axis=axis) ** 2)) / spacing[axis] ** 2 for axis in (0, 1)))
    law, cells = make_law(random, gap, max(spacing), slope)
    limit = slope * 10.0 ** random.uniform(-0.7, 0.7) if random.random() < 0.3 else math.inf
    given: dict[str, Any] = {}
    if random.random() < 0.6:
        mean = slope * 10.0 ** random.uniform(-4.0, 0.0)
        mean = float(random.choice([mean, mean, mean, 0.0, -0.01 * mean]))
        given["mean_pressure"] = min(mean, 0.9 * limit)
    else:
        given["approach"] = float(gap.mean()) * float(random.choice([-0.05, 0.1, 0.3, 0.6, 0.9, 0.99]))
    task = Task(initial_gap=gap, interaction=BoundInteraction(law), pressure_limit=limit, **given)
    about = {
        "law": type(law).__name__,
        "boundary": str(boundary),
        "control": next(iter(given)),
        "capped": math.isfinite(limit),
    }
    return convolution, task, {**about, "cells": cells, "seed": seed}


def displace(convolution: PreparedConvolution, pressure: np.ndarray) -> np.ndarray:
    """Return the displacement in extended precision, by a transform of the whole response."""
    setup = convolution.setup
    nx, ny = pressure.shape
    free = setup.boundary is rc.Boundary.FREE
    mx, my = (2 * nx, 2 * ny) if free else (nx, ny)
    if setup.boundary is rc.Boundary.PERIODIC:
        qx = 2.0 * np.pi * np.fft.fftfreq(nx) / setup.grid.spacing[0]
        qy = 2.0 * np.pi * np.fft.fftfreq(ny) / setup.grid.spacing[1]
        symbol = setup.kernel.spectrum(qx[:, None], qy[None, :], setup.grid.spacing).astype(np.longdouble)
    else:
        i, j = (np.minimum(np.arange(m), m - np.arange(m)) for m in (mx, my))
        response = setup.kernel.coefficients((mx // 2 + 1, my // 2 + 1), setup.grid.spacing)[np.ix_(i, j)]
        symbol = scipy.fft.fft2(response.astype(np.longdouble)).real
    padded = np.zeros((mx, my), dtype=np.longdouble)
    padded[:nx, :ny] = pressure
    return np.asarray(scipy.fft.ifft2(scipy.fft.fft2(padded) * symbol).real[:nx, :ny])


def judge(convolution: PreparedConvolution, task: Task, outcome: Outcome) -> dict[str, float]:
    """Return the errors of an outcome: of the gap over the scale, of the tension, of the load and of the bounds."""
    assert task.interaction is not None
    assert outcome.tension is not None
    pressure = outcome.pressure
    tension = outcome.tension
    gap = displace(convolution, pressure) + task.initial_gap
    contact = np.maximum(pressure + tension, 0.0)
    touching = (contact > 0.0) & (pressure < task.pressure_limit)
    if task.approach is not None:
        approach = task.approach
    elif touching.any():
        approach = float((contact * gap)[touching].sum() / contact[touching].sum())
    else:
        approach = float(gap.min())
    moved = gap - task.initial_gap
    gap = gap - approach
    scale = float(task.initial_gap.std())
    if contact.any():
        scale = min(scale, float(moved.max() - moved.min())) or scale or 1.0
    saturated = pressure >= task.pressure_limit
    opened = contact <= 0.0
    strength = float(np.max(task.interaction.strength))
    law = task.interaction.tension(np.where(opened, np.maximum(gap, 0.0), 0.0).astype(np.float64))
    off = float(np.abs(law - tension).max()) / (task.interaction.steepest * scale)
    weighted = float((contact * np.abs(gap))[touching].sum() / max(float(contact.sum()), 1e-300)) / scale
    overlap = float(np.maximum(-gap, 0.0)[~saturated].max(initial=0.0)) / scale
    lifted = float((contact * np.maximum(gap, 0.0))[saturated].sum() / max(float(contact.sum()), 1e-300)) / scale
    load = 0.0
    if task.mean_pressure is not None:
        load = abs(float(pressure.mean()) - task.mean_pressure) / max(float(np.abs(pressure).mean()), 1e-300)
    bounds = max(float((-tension - pressure).max()), float((pressure - task.pressure_limit).max()), 0.0)
    return {"gap": max(off, weighted, overlap, lifted), "load": load, "bounds": bounds / strength}


def main() -> None:
    """Print a line for each problem that does not converge, or not truly, and the costs."""
    first, last = (int(word) for word in (*sys.argv[1:3], "0", "2000")[:2]) if len(sys.argv) > 2 else (0, 2000)
    statuses: collections.Counter[str] = collections.Counter()
    products: list[int] = []
    wrong = 0
    started = time.process_time()
    for seed in range(first, last):
        convolution, task, about = make_problem(seed)
        outcome = GapDescent().solve(convolution, task)
        statuses[outcome.status.name] += 1
        text = ", ".join(f"{value:.3g}" if isinstance(value, float) else f"{value}" for value in about.values())
        if outcome.status.success:
            products.append(outcome.convolutions)
            errors = judge(convolution, task, outcome)
            if errors["gap"] > ALLOWED or errors["load"] > LOAD or errors["bounds"] > 0.0:
                wrong += 1
                print(f"not as stated: {text}: {errors}", flush=True)
            if outcome.convolutions > 1000:
                print(f"{outcome.convolutions} products: {text}", flush=True)
        elif outcome.status.name != "SEPARATED":
            print(f"{outcome.status.name}, {outcome.convolutions} products: {text}", flush=True)
    seconds = time.process_time() - started
    quantiles = np.quantile(products, (0.5, 0.9, 0.99, 1.0)).round().astype(int)
    print(f"{last - first} problems, {dict(statuses)}, {wrong} not as stated, {seconds:.0f} s")
    print("products: median {}, 90 % {}, 99 % {}, most {}".format(*quantiles))


if __name__ == "__main__":
    main()
