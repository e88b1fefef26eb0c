"""Hypothesis strategies: random grids, surfaces, pressures and problems."""

from __future__ import annotations

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._parts.grid import Grid
from roughcontact._parts.materials import Elastic, ElasticPerfectlyPlastic, Material
from roughcontact._parts.surfaces import HeightMap
from roughcontact._solve.problem import Body, ContactProblem
from roughcontact._solve.solvers import Solver
from roughcontact.errors import MissingPackage

try:
    from hypothesis import strategies as st
except ImportError as error:
    raise MissingPackage("The strategies need the package hypothesis: pip install hypothesis.") from error

lengths = st.floats(1e-9, 1e3)
moduli = st.floats(1e3, 1e14)
aspects = st.floats(0.2, 5.0)
powers_of_two = st.integers(-60, 60).map(lambda k: 2.0**k)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def shapes(draw: st.DrawFn, largest: int = 24) -> tuple[int, int]:
    """Grid shapes of at least two cells, odd and even, thin and square."""
    return draw(st.tuples(st.integers(1, largest), st.integers(1, largest)).filter(lambda s: s[0] * s[1] >= 2))


@st.composite
def grids(draw: st.DrawFn, largest: int = 24) -> Grid:
    """Rectangular grids with rectangular cells."""
    nx, ny = draw(shapes(largest))
    dx = draw(lengths)
    return Grid((nx, ny), (nx * dx, ny * dx * draw(aspects)))


@st.composite
def pressures(draw: st.DrawFn, shape: tuple[int, int]) -> Array:
    """Random pressures between 0 and 1 on a given shape, some cells without."""
    rng = np.random.default_rng(draw(seeds))
    return np.asarray(rng.random(shape) * (rng.random(shape) < draw(st.floats(0.1, 1.0))))


@st.composite
def height_maps(draw: st.DrawFn, largest: int = 20) -> HeightMap:
    """Height maps of very different character: noise, ties, steps, spikes, bowls."""
    grid = draw(grids(largest))
    rng = np.random.default_rng(draw(seeds))
    noise = rng.standard_normal(grid.shape)
    kind = draw(st.sampled_from(["noise", "ties", "steps", "spikes", "bowl", "lognormal"]))
    heights = {
        "noise": noise,
        "ties": np.round(noise),
        "steps": (noise > 0.3).astype(float),
        "spikes": (noise == noise.max()) + 1e-3 * noise,
        "bowl": -(grid.x**2 + grid.y**2) / max(grid.size) ** 2 + 1e-2 * noise,
        "lognormal": np.exp(noise),
    }[kind]
    # A flat map has no contact problem; one lower cell gives it one.
    if np.ptp(heights) == 0.0:
        heights = heights - np.eye(1, heights.size).reshape(heights.shape)
    return HeightMap(heights * draw(st.floats(1e-3, 1e3)) * min(grid.spacing), size=grid.size)


@st.composite
def problems(
    draw: st.DrawFn, *, limited: bool | None = None, solver: str | Solver = "auto"
) -> tuple[ContactProblem, float]:
    """Contact problems, with or without a pressure limit, each with an admissible mean pressure."""
    surface = draw(height_maps())
    young = draw(moduli)
    peak_to_valley = np.ptp(surface.values)
    mean = float(draw(st.floats(1e-4, 10.0)) * young * peak_to_valley / max(surface.size))
    material: Material = Elastic(young, 0.3)
    if draw(st.booleans()) if limited is None else limited:
        material = ElasticPerfectlyPlastic(young, 0.3, hardness=mean / draw(st.floats(0.01, 1.0)))
    boundary = draw(st.sampled_from(["free", "periodic", "wrapped"]))
    return ContactProblem(Body(surface, material), boundary=boundary, solver=solver), mean
