"""Hypothesis strategies: the one home of random grids, surfaces and problems."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

import roughcontact as rc

lengths = st.floats(1e-9, 1e3)
moduli = st.floats(1e3, 1e14)
aspects = st.floats(0.2, 5.0)
powers_of_two = st.integers(-60, 60).map(lambda k: 2.0**k)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def shapes(draw, largest=24):
    """Grid shapes of at least two cells, odd and even, thin and square."""
    return draw(st.tuples(st.integers(1, largest), st.integers(1, largest)).filter(lambda s: s[0] * s[1] >= 2))


@st.composite
def grids(draw, largest=24):
    """Rectangular grids with rectangular cells."""
    nx, ny = draw(shapes(largest))
    dx = draw(lengths)
    return rc.Grid((nx, ny), (nx * dx, ny * dx * draw(aspects)))


@st.composite
def pressures(draw, shape):
    """Random pressures between 0 and 1 on a given shape, some cells without."""
    rng = np.random.default_rng(draw(seeds))
    return rng.random(shape) * (rng.random(shape) < draw(st.floats(0.1, 1.0)))


@st.composite
def height_maps(draw, largest=20):
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
    # A map without relief has no contact problem; one cell a little lower gives it one.
    if np.ptp(heights) == 0.0:
        heights = heights - np.eye(1, heights.size).reshape(heights.shape)
    return rc.HeightMap(heights * draw(st.floats(1e-3, 1e3)) * min(grid.spacing), size=grid.size)


@st.composite
def problems(draw, *, limited=None, solver="auto"):
    """A contact problem and a mean pressure that it can carry."""
    surface = draw(height_maps())
    young = draw(moduli)
    relief = np.ptp(surface.values)
    mean = draw(st.floats(1e-4, 10.0)) * young * relief / max(surface.size)
    if draw(st.booleans()) if limited is None else limited:
        material = rc.ElasticPerfectlyPlastic(young, 0.3, hardness=mean / draw(st.floats(0.01, 1.0)))
    else:
        material = rc.Elastic(young, 0.3)
    boundary = draw(st.sampled_from(["free", "periodic", "wrapped"]))
    return rc.ContactProblem(rc.Body(surface, material), boundary=boundary, solver=solver), mean


@st.composite
def measured_pairs(draw):
    """Two height maps of different cells and sides, and how the second lies on the first."""
    maps = []
    for _ in range(2):
        shape = draw(st.tuples(st.integers(8, 24), st.integers(8, 24)))
        size = (draw(st.floats(0.5, 2.0)) * 1e-4, draw(st.floats(0.5, 2.0)) * 1e-4)
        rng = np.random.default_rng(draw(seeds))
        maps.append(rc.HeightMap(1e-8 * rng.standard_normal(shape), size))
    near = 0.3 * min(min(one.size) for one in maps)
    offset = draw(st.floats(-1, 1)) * near, draw(st.floats(-1, 1)) * near
    placing = {"offset": offset, "rotation": draw(st.floats(-6.28, 6.28)), "mirrored": draw(st.booleans())}
    return maps[0], maps[1], placing


def _magnitude(low, high):
    """Powers of ten between two exponents; evenly, where floats() would mostly draw a few simple ones."""
    return seeds.map(lambda seed: 10.0 ** float(np.random.default_rng(seed).uniform(low, high)))


@st.composite
def wild_problems(draw, largest=14):
    """A contact problem of any magnitude, and a load, bearable or not, as a dictionary of one entry.

    Lengths of cells, heights and moduli lie between 1e-9 and 1e9, cells have aspects of up to 1000,
    limits are numbers, arrays or none, loads reach from a touch to beyond what can be carried.
    """
    shape = draw(st.one_of(shapes(largest), st.tuples(st.integers(4, largest), st.integers(4, largest))))
    dx, height, young = (draw(_magnitude(-9, 9)) for _ in range(3))
    aspect = draw(st.one_of(st.just(1.0), _magnitude(-0.5, 0.5), _magnitude(-3, 3)))
    size = (shape[0] * dx, shape[1] * dx * aspect)
    noise = np.random.default_rng(draw(seeds)).standard_normal(shape)
    x, y = (np.linspace(-1, 1, n) for n in shape)
    kind = draw(st.sampled_from(["noise", "ties", "step", "needle", "bowl", "lognormal", "two scales"]))
    heights = {
        "noise": noise,
        "ties": np.round(noise),
        "step": (noise > 0.3).astype(float),
        "needle": (noise == noise.max()).astype(float),
        "bowl": -(x[:, None] ** 2 + y**2) + 1e-3 * noise,
        "lognormal": np.exp(noise),
        "two scales": np.sin(3 * x[:, None] + 2 * y) + 1e-6 * noise,
    }[kind]
    # Half of all surfaces are such as a half-space allows; the others have any heights at all.
    relief = draw(st.one_of(_magnitude(-4, -1).map(lambda slope: slope * min(size)), st.just(height)))
    if np.ptp(heights) == 0.0:
        heights = heights - np.eye(1, heights.size).reshape(shape)
    surface = rc.HeightMap(relief * heights, size=size, periodic=True)
    boundary = draw(st.sampled_from(["free", "periodic", "wrapped"]))
    kernel = draw(st.sampled_from(["love", "love", "fourier"])) if boundary == "periodic" else "love"
    scale = young * float(np.ptp(surface.values)) / max(size)
    cap = draw(st.sampled_from(["none", "number", "array"]))
    hardness = scale * draw(_magnitude(-3, 3))
    limits = {"none": np.inf, "number": hardness, "array": hardness * np.exp(0.5 * noise.T.reshape(shape))}[cap]
    material = rc.Elastic(young, 0.3) if cap == "none" else rc.ElasticPerfectlyPlastic(young, 0.3, limits)
    problem = rc.ContactProblem(rc.Body(surface, material), boundary=boundary, kernel=kernel)
    if draw(st.booleans()):
        return problem, {"approach": float(problem.undeformed.max()) * draw(_magnitude(-6, 1))}
    if cap != "none":
        share = draw(st.one_of(_magnitude(-6, 0), st.sampled_from([0.999, 1.0, float(np.nextafter(1.0, 2.0)), 1.1])))
        return problem, {"pressure": float(np.mean(limits)) * share}
    # A load that knows nothing of the relief may dwarf it.
    scale = draw(st.sampled_from([scale, scale, young]))
    return problem, {"pressure": scale * draw(_magnitude(-6, 3))}
