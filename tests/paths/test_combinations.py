"""Viscoelastic bodies with all that may stand beside them: each contact is certified, or refused with a sentence."""

import itertools

import numpy as np
import pytest

import roughcontact as rc

# Cells of 1 : 3.
GRID = rc.Grid((24, 16), (1e-3, 2e-3))
PRESSURE = 3e4
SPEED = 0.05
RUBBER = rc.Viscoelastic([1e6, 4e6], [1e-2], 0.5)
OTHER = rc.Viscoelastic([2e6, 3e6, 2e6], [1e-3, 1e-1], 0.4)
HARD = rc.ElasticPerfectlyPlastic(20e6, 0.3, 1.5e5)
RIGID = rc.Rigid()


def make_map(seed=3, non_measured=None):
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.05, shortest=0.5e-3, longest=2e-3, seed=seed)
    return rc.HeightMap(surface.heights(GRID), GRID.size, periodic=True, non_measured=non_measured)


LOST = np.zeros(GRID.shape, dtype=bool)
LOST[3:6, 4:7] = True
FLAT = rc.FlatSurface()
PAIRS = {
    "rubber below rigid heights": ((FLAT, RUBBER), (make_map(), RIGID)),
    "two series": ((FLAT, RUBBER), (make_map(), OTHER)),
    "rubber below hard heights": ((FLAT, RUBBER), (make_map(), HARD)),
    "hard heights on rubber": ((make_map(), HARD), (FLAT, RUBBER)),
    "rubber heights on a hard flat": ((FLAT, HARD), (make_map(), RUBBER)),
    "two rough bodies": ((make_map(), RUBBER), (make_map(4), HARD)),
    "lost points": ((FLAT, RUBBER), (make_map(non_measured=LOST), HARD)),
    "lost points of rubber": ((make_map(non_measured=LOST), RUBBER), (FLAT, HARD)),
}
STEADY = rc.SteadySliding(SPEED)
PARTS = {
    "nothing": {},
    "wear": {"laws": rc.Archard(1e-12, of="counterbody")},
    "adhesion": {"adhesion": rc.Exponential(work=1e-2, range=5e-6)},
    "sliding": {"laws": STEADY},
    "sliding, wear": {"laws": (STEADY, rc.Archard(1e-12))},
    "sliding, flattening": {"laws": (rc.Flattening(), STEADY)},
    "sliding, relaxation": {"laws": (rc.Relaxation(RUBBER), STEADY)},
}
SHEARED = [(0.0, 0.0), (1e-3, 0.0)]
WAYS = {
    "loads": {"pressure": [PRESSURE, 0.5 * PRESSURE]},
    "time": {"pressure": [PRESSURE, 0.5 * PRESSURE], "time": [0.0, 0.01], "accuracy": 0.1},
    "time, shift": {"pressure": PRESSURE, "time": [0.0, 0.01], "shift": [(0, 0), (1, 2)], "accuracy": 0.1},
    "time, sliding": {"pressure": PRESSURE, "time": [0.0, 0.01], "sliding": [0.0, 1.0], "accuracy": 0.1},
    "friction": {"pressure": [PRESSURE, PRESSURE], "tangential_force": SHEARED, "friction": 0.3},
}


def find_reason(pair, part, way, boundary):
    """Return words of the sentence by which a contact is refused; None: it is certified."""
    slides = way == "speed" or part.startswith("sliding")
    has_wear = "wear" in part
    rules = [
        (way == "speed" and part.startswith("sliding"), "omit"),
        (way == "friction" and part == "adhesion", "Friction with adhesion"),
        (way == "friction" and part != "nothing", "neither time nor a sliding distance"),
        (part == "sliding, relaxation" and way == "time, sliding", "Nothing changes with the sliding distance"),
        (part == "sliding, relaxation" and way == "time, shift", "does not follow bodies that move"),
        (slides and "time" in way and part != "sliding, relaxation", "Nothing changes with the time"),
        ("shift" in way and part == "adhesion", "moves without adhesion"),
        ("shift" in way and boundary != "periodic", "needs a boundary that is periodic"),
        ("sliding" in way and not has_wear, "Nothing changes with the sliding distance"),
        (slides and pair == "two rough bodies", "both have heights"),
        (part == "sliding, relaxation", "have relaxed"),
        (way == "speed" and part == "adhesion", "slide without adhesion"),
        (slides and boundary == "free", "periodic along its direction"),
    ]
    return next((words for holds, words in rules if holds), None)


def follow(problem, way):
    return [problem.slide(pressure=PRESSURE, speed=SPEED)] if way == "speed" else list(problem.path(**WAYS[way]))


@pytest.mark.slow
@pytest.mark.parametrize(("pair", "part"), list(itertools.product(PAIRS, PARTS)))
def test_each_is_certified_or_refused_with_a_sentence(pair, part):
    one, other = (rc.Body(*side) for side in PAIRS[pair])
    boundaries = ["periodic", "free", ("periodic", "free")] if part == "nothing" else ["periodic"]
    for boundary, way in itertools.product(boundaries, [*WAYS, "speed"]):
        problem = rc.ContactProblem(one, other, grid=GRID, boundary=boundary, **PARTS[part])
        words = find_reason(pair, part, way, boundary)
        if words is not None:
            with pytest.raises(rc.InputError, match=words):
                follow(problem, way)
            continue
        for state in follow(problem, way):
            state.verify()
            assert state.certificate.error < 2e-5
            if state.non_measured is not None:
                assert state.pressure[state.non_measured].max() <= 0.0


@pytest.mark.parametrize("is_counterbody", [False, True])
def test_heights_that_slide_at_a_speed_have_their_hardness(is_counterbody):
    """Slow, they are those on relaxed rubber; a flat body at its hardness would be flattened all along."""
    heights, flat = rc.Body(make_map(), HARD), rc.Body(FLAT, RUBBER)
    relaxed = rc.Body(FLAT, rc.Elastic(1e6, 0.5))
    load = {"pressure": 9e4}

    def pair(one, other):
        bodies = (other, one) if is_counterbody else (one, other)
        return rc.ContactProblem(*bodies, grid=GRID, boundary="periodic")

    state = pair(heights, flat).slide(**load, speed=1e-9)
    elastic = pair(heights, relaxed).solve(**load)
    assert state.saturated.any()
    np.testing.assert_allclose(state.pressure, elastic.pressure, atol=1e-3 * HARD.hardness)
    fast = pair(heights, flat).slide(**load, speed=SPEED)
    assert fast.pressure.max() == HARD.hardness
    assert fast.friction_coefficient.value > 0.0
    with pytest.raises(rc.InputError, match="hardness of the flat body"):
        pair(rc.Body(make_map(), RUBBER), rc.Body(FLAT, HARD)).slide(**load, speed=SPEED)
