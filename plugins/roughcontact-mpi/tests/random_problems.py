"""Random contacts on small grids: all boundaries, loads, with and without a hardness, shapes that nothing divides."""

import numpy as np
import roughcontact as rc

BOUNDARIES = [str(one) for one in rc.Boundary if one is not rc.Boundary.WRAPPED]


def _shape_of(random):
    """Return the cells and the sides of the domain; of some one side is eight times the other."""
    shape = random.integers(3, 72, 2)
    if random.random() < 0.2:
        few = int(random.integers(3, 14))
        shape = np.array([few, 8 * few] if random.random() < 0.5 else [8 * few, few])
    cell = np.array([1.0, random.choice([1.0, 1.0, 1.0 / 3.0, 3.0])]) / 48.0
    return tuple(int(n) for n in shape), tuple(float(side) for side in shape * cell)


def _heights_of(random, shape):
    """Return white noise, or smoother heights."""
    heights = random.normal(size=shape)
    for _ in range(int(random.integers(0, 4))):
        heights = sum(np.roll(heights, step, axis) for axis in (0, 1) for step in (-1, 0, 1)) / 6.0
    return 0.01 * heights / heights.std()


def make_problem(seed):
    """Return the heights, and the arguments of the solve on a modulus of 1 GPa."""
    random = np.random.default_rng([28, seed])
    shape, size = _shape_of(random)
    heights = _heights_of(random, shape)
    pressure = float(10.0 ** random.uniform(5.0, 8.3))
    load = [
        {"pressure": pressure},
        {"force": pressure * size[0] * size[1]},
        {"approach": float(random.uniform(0.05, 0.9) * (heights.max() - heights.mean()))},
    ][int(random.integers(3))]
    hardness = float(random.choice([5e7, 2e8, 1e9])) if random.random() < 0.4 else None
    return heights, {"size": size, "boundary": str(random.choice(BOUNDARIES)), "load": load, "hardness": hardness}
