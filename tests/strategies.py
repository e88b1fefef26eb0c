"""Hypothesis strategies: those that plug-ins have too, and those for this package alone."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.testing.strategies import (
    aspects,
    grids,
    height_maps,
    moduli,
    powers_of_two,
    pressures,
    problems,
    seeds,
    shapes,
)

__all__ = [
    "STRICT",
    "aspects",
    "grids",
    "height_maps",
    "measured_pairs",
    "moduli",
    "powers_of_two",
    "pressures",
    "problems",
    "seeds",
    "shapes",
    "strict",
    "wild_problems",
]


def strict(solver: str) -> rc.Solver:
    """Return a registered solver with a tolerance that leaves pressures equal to a millionth of their maximum."""
    return rc.solvers.resolve(solver).with_tolerance(1e-8)


STRICT = strict("projected-cg")


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
    """A contact problem of any magnitude, and a load, admissible or not, as a dictionary of one entry.

    Lengths of cells, heights and moduli lie between 1e-9 and 1e9, cells have aspects of up to 1000,
    limits are numbers, arrays or none, loads reach from first touch to beyond the maximum.
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
    # Half of the surfaces have slopes below 0.1, as half-space theory assumes; the others any heights.
    peak_to_valley = draw(st.one_of(_magnitude(-4, -1).map(lambda slope: slope * min(size)), st.just(height)))
    if np.ptp(heights) == 0.0:
        heights = heights - np.eye(1, heights.size).reshape(shape)
    surface = rc.HeightMap(peak_to_valley * heights, size=size, periodic=True)
    boundary = draw(st.sampled_from(["free", "periodic", "free-periodic", "periodic-free", "wrapped"]))
    kernel = draw(st.sampled_from(["love", "love", "fourier"])) if boundary == "periodic" else "love"
    scale = young * float(np.ptp(surface.values)) / max(size)
    limited = draw(st.sampled_from(["none", "number", "array"]))
    hardness = scale * draw(_magnitude(-3, 3))
    limits = {"none": np.inf, "number": hardness, "array": hardness * np.exp(0.5 * noise.T.reshape(shape))}[limited]
    material = rc.Elastic(young, 0.3) if limited == "none" else rc.ElasticPerfectlyPlastic(young, 0.3, limits)
    problem = rc.ContactProblem(rc.Body(surface, material), boundary=boundary, kernel=kernel)
    if draw(st.booleans()):
        return problem, {"approach": float(problem.initial_gap.max()) * draw(_magnitude(-6, 1))}
    if limited != "none":
        fraction = draw(st.one_of(_magnitude(-6, 0), st.sampled_from([0.999, 1.0, float(np.nextafter(1.0, 2.0)), 1.1])))
        return problem, {"pressure": float(np.mean(limits)) * fraction}
    # A load that does not scale with the heights may flatten them.
    scale = draw(st.sampled_from([scale, scale, young]))
    return problem, {"pressure": scale * draw(_magnitude(-6, 3))}
