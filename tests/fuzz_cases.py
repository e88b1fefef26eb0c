"""Random contact problems as plain numbers: `case_of` draws a `Case`, `build` makes the problem from it.

A case that was wrong once is listed, whatever `case_of` draws later.
"""

from __future__ import annotations

import attrs
import numpy as np

import roughcontact as rc

# Iterations after which a solver gives up, so that hopeless problems do not fill the time.
ITERATIONS = 300

KINDS = ["noise", "ties", "steps", "step", "needle", "twins", "bowl", "tilt", "lognormal", "two scales", "nearly flat"]
LIMITS = ["none", "number", "array", "some"]
STARTS = ["none", "none", "zeros", "ones", "random", "large", "negative", "own"]
# Kinds of load, and powers of ten between which their values lie.
LOADS = {"pressure": (-7, 7), "force": (-7, 7), "approach": (-13, 1), "share": (-14, 0), "nearly full": (-16, -1)}


@attrs.frozen
class Case:
    """A problem and its load; magnitudes are powers of ten of a natural unit.

    `load` is of kind "pressure", "force", "approach", "share" (of the admissible load) or "nearly full" (1 - 10^load of
    it); `holes` is the fraction of non-measured points.
    """

    shape: tuple[int, int]
    seed: int
    kind: str = "noise"
    cell: float = 0.0
    aspect: float = 0.0
    height: float = -2.0
    young: float = 9.0
    boundary: str = "free"
    kernel: str = "love"
    solver: str = "auto"
    limited: str = "none"
    limit: float = 0.0
    holes: float = 0.0
    start: str = "none"
    load: tuple[str, float] = ("pressure", 0.0)


# Cases that were wrong once, with the fault: each must stay right.
# fmt: off
FAILED = [
    # Zero pressure was the answer to a very small approach.
    Case((13, 10), 11297, "tilt", height=-2.494, boundary="periodic", kernel="fourier",
         load=("approach", -11.809)),
    Case((11, 7), 25348, "step", aspect=0.503, young=10.883, holes=0.5, start="own", load=("approach", -12.388)),
    Case((3, 14), 20050, "bowl", cell=4.56, aspect=-7.848, young=-8.989, boundary="wrapped",
         solver="spectral-gradient", limited="number", limit=1.605, load=("approach", -10.558)),
    # The depth given to non-measured points was the scale.
    Case((14, 4), 48836, "bowl", cell=-6.0, height=7.634, young=-2.02, boundary="wrapped", solver="polonsky-keer",
         holes=0.5, load=("pressure", 6.815)),
    Case((2, 12), 6376, "ties", cell=-4.397, aspect=0.432, height=2.908, young=-6.947, boundary="wrapped",
         holes=0.5, load=("pressure", 5.221)),
    Case((7, 16), 24187, "tilt", cell=8.774, height=-6.411, young=-6.049, boundary="periodic", kernel="fourier",
         limited="array", limit=2.502, holes=0.5, load=("approach", 0.703)),
    Case((2, 3), 2055, "needle", cell=-6.0, height=5.205, young=1.912, boundary="periodic", limited="some",
         limit=2.35, holes=0.1, load=("nearly full", -3.475)),
    Case((5, 11), 59771, "needle", cell=-6.0, height=-11.76, young=-7.919, holes=0.5, load=("approach", 0.864)),
    # That depth overflowed while a solve failed again and again.
    Case((8, 15), 7977, "steps", cell=-6.0, aspect=-0.401, height=-1.041, young=1.769, boundary="wrapped",
         solver="spectral-gradient", limited="number", limit=-1.189, holes=0.1, start="large",
         load=("force", -5.973)),
    Case((9, 4), 55408, "lognormal", cell=-6.0, aspect=-0.321, height=-2.361, young=3.665, boundary="periodic",
         kernel="fourier", limited="number", limit=-1.169, holes=0.5, load=("pressure", -1.194)),
    Case((16, 8), 32905, "tilt", cell=-6.0, aspect=-5.063, height=-13.5, young=-0.66, solver="spectral-gradient",
         holes=0.5, start="large", load=("force", -3.843)),
    # A gradient of zero was divided by.
    Case((2, 9), 46275, "ties", cell=-6.0, aspect=5.972, height=-2.086, young=-0.219, boundary="wrapped",
         start="large", load=("approach", -1.383)),
    # Rounding was above the tolerance.
    Case((10, 6), 23656, "lognormal", cell=8.824, aspect=0.5, height=-1.272, young=-0.896, boundary="wrapped",
         limited="number", limit=-1.743, load=("nearly full", -9.139)),
    Case((8, 11), 19099, cell=-6.0, aspect=0.995, height=-1.215, young=11.128, boundary="wrapped",
         limited="number", limit=-0.587, load=("nearly full", -12.478)),
    Case((2, 10), 45625, "nearly flat", cell=-6.0, aspect=1.627, height=-3.719, young=10.099, boundary="periodic",
         limited="number", limit=-1.565, load=("nearly full", -9.224)),
]
# fmt: on


def case_of(number):
    """Return the case of a number; numbers that follow each other give unrelated cases."""
    rng = np.random.default_rng(number)

    def one_of(values):
        return values[rng.integers(len(values))]

    def power(*ranges):
        return round(float(rng.uniform(*one_of(ranges))), 3)

    boundary, kind = one_of(["free", "periodic", "wrapped"]), one_of(list(LOADS))
    limited = one_of(LIMITS)
    alone = ["polonsky-keer"] if limited == "none" and kind != "approach" else []
    return Case(
        shape=(int(rng.integers(2, 17)), int(rng.integers(2, 17))),
        seed=int(rng.integers(2**16)),
        kind=one_of(KINDS),
        cell=power((-9, 9), (-6, -6)),
        aspect=power((0, 0), (-0.5, 0.5), (-3, 3), (-8, 8)),
        height=power((-4, -1), (-14, 9)),
        young=power((9, 12), (-9, 15)),
        boundary=boundary,
        kernel=one_of(["love", "love", "fourier"]) if boundary == "periodic" else "love",
        solver=one_of(["auto", "projected-cg", "spectral-gradient", *alone]),
        limited=limited,
        limit=power((-6, 4), (-2, 1)),
        holes=one_of([0.0, 0.0, 0.0, 0.1, 0.5]),
        start=one_of(STARTS),
        load=(kind, power(LOADS[kind])),
    )


def heights_of(case, rng):
    """Heights between about -1 and 1, of very different character."""
    noise = rng.standard_normal(case.shape)
    x, y = (np.linspace(-1, 1, n) for n in case.shape)
    highest = np.sort(noise.ravel())[-2:]
    return {
        "noise": noise,
        "ties": np.round(noise),
        "steps": (noise > 0.3) * 1.0,
        "step": np.broadcast_to((x[:, None] > 0.1) * 1.0, case.shape),
        "needle": (noise == highest[-1]) * 1.0,
        "twins": (noise >= highest[0]) * 1.0 - (noise == highest[0]) * 1e-13,
        "bowl": -(x[:, None] ** 2 + y**2) + 1e-3 * noise,
        "tilt": x[:, None] + 0.3 * y,
        "lognormal": np.exp(noise),
        "two scales": np.sin(3 * x[:, None] + 2 * y) + 1e-6 * noise,
        "nearly flat": 1.0 + 1e-13 * noise,
    }[case.kind]


def build(case):
    """Return the problem of a case, its load and the pressure to start from."""
    rng = np.random.default_rng(case.seed)
    heights = heights_of(case, rng)
    dx = 10.0**case.cell
    size = (case.shape[0] * dx, case.shape[1] * dx * 10.0**case.aspect)
    heights = heights * (10.0**case.height * min(size))
    mask = rng.random(case.shape) < case.holes
    surface = rc.HeightMap(heights, size=size, periodic=True, non_measured=mask if mask.any() else None)
    young = 10.0**case.young
    unit = young * float(np.ptp(heights)) / max(size) or young
    noise, spread = rng.standard_normal(case.shape), rng.random(case.shape)
    hardness = unit * 10.0**case.limit
    limits = {
        "none": None,
        "number": hardness,
        "array": hardness * np.exp(0.5 * noise),
        "some": hardness * np.where(spread < 0.5, 1.0, 1e3),
    }[case.limited]
    material = rc.Elastic(young, 0.3) if limits is None else rc.ElasticPerfectlyPlastic(young, 0.3, limits)
    solver = rc.solvers.resolve("projected-cg" if case.solver == "auto" else case.solver)
    solver = attrs.evolve(solver, max_iterations=ITERATIONS, tolerance=1e-8)
    body = rc.Body(surface, material)
    problem = rc.ContactProblem(body, boundary=case.boundary, kernel=case.kernel, solver=solver)
    kind, value = case.load[0], 10.0 ** case.load[1]
    admissible = float(np.mean(np.where(mask, 0.0, unit if limits is None else limits)))
    reach = float(np.ptp(heights[~mask])) or 10.0**case.height * min(size)
    load = {
        "pressure": {"pressure": unit * value},
        "force": {"force": unit * value * size[0] * size[1]},
        "approach": {"approach": reach * value},
        "share": {"pressure": admissible * value},
        "nearly full": {"pressure": admissible * (1.0 - value)},
    }[kind]
    starts = {
        "none": None,
        "zeros": np.zeros(case.shape),
        "ones": np.full(case.shape, unit),
        "random": unit * 10.0 ** (3 * noise) * (spread < 0.5),
        "large": np.full(case.shape, 1e30 * unit),
        "negative": -unit * spread,
    }
    if case.start != "own":
        return problem, load, starts[case.start]
    return problem, load, problem.solve(**{key: 0.9 * value for key, value in load.items()}, throw=False).pressure
