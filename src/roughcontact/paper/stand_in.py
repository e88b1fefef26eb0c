"""A stand-in for the paper's measured pairs, which are not published: a ball on a ground ring.

The domain, the ball, the steel and the loads are the paper's (section 3.2, Table 4). The roughness is
chosen from what is usual for such surfaces; `PARAMETERS` says from where.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from roughcontact.archive import read_archive, write_archive
from roughcontact.body import Body
from roughcontact.description import key_of
from roughcontact.errors import InputError
from roughcontact.grid import Grid
from roughcontact.materials import ElasticPerfectlyPlastic
from roughcontact.problem import ContactProblem
from roughcontact.running_in import RunIn, run_in
from roughcontact.surfaces import HeightMap, SelfAffineSurface, SphereSurface

SIZE = 264.2e-6
# Table 4: 52100 steel; the pressure cap is the hardness.
STEEL = ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
BALL_RADIUS = 5e-3
FINEST = 2048
# Eight cells of the finest grid: a confocal microscope resolves about half of it, and the sub-grid area is
# right to 0.3 % there, so that the true area is known.
SHORTEST = 8 * SIZE / FINEST
# A ground steel ring: rms heights of 0.1 to 0.4 um are usual, lengths along the lay ten times those across.
RING = SelfAffineSurface(
    hurst=0.8,
    rms_height=0.2e-6,
    longest=SIZE,
    rolloff=20e-6,
    shortest=SHORTEST,
    peklenik=10.0,
    lay=math.pi / 2,
    seed=52,
)
# A finished ball of grade 10: ISO 3290-1 allows Ra = 0.02 um, that is 0.025 um rms.
BALL = SelfAffineSurface(hurst=0.8, rms_height=0.025e-6, longest=SIZE, rolloff=20e-6, shortest=SHORTEST, seed=100)
RUN_IN_FORCE = 10.0
# The ring comes under the ball at four places along the lay, until a round flattens less than a hundredth.
PLACES = 4
TOLERANCE = 1e-2
MODEL = "overlap"


def fresh(cells: int) -> ContactProblem:
    """Return the pair before running in, on `cells` x `cells` cells."""
    grid = Grid((cells, cells), SIZE)
    ball = (SphereSurface(BALL_RADIUS) + BALL).heights(grid)
    return _with_maps([HeightMap(ball, SIZE), HeightMap(RING.heights(grid), SIZE)])


def worn(pair: ContactProblem, path: Path, on_cycle: Callable[[RunIn], None] | None = None) -> ContactProblem:
    """Return a pair run in at 10 N, by rounds of cycles until one flattens next to nothing.

    The maps are kept in a file after each round: what was interrupted goes on from the last, and what
    was finished is not done again. The file is used only for the same pair and the same running in.
    """
    cells = pair.plan.grid.shape[1]
    shifts = [(0, cells * place // PLACES) for place in range(PLACES)]
    key = key_of([pair.parts, RUN_IN_FORCE, shifts, TOLERANCE, MODEL])
    worn_pair, volume, finished = _kept(path, key) or (pair, 0.0, False)
    while not finished:
        result = run_in(
            worn_pair, force=RUN_IN_FORCE, shifts=shifts, model=MODEL, rounds=1, tolerance=0.0, on_cycle=on_cycle
        )
        volume += result.volume
        worn_pair, finished = result.problem, result.volume <= TOLERANCE * volume
        arrays = {f"map_{side}": one.values for side, one in enumerate(_maps(worn_pair))}
        write_archive(path, arrays, {"key": key, "volume": volume, "finished": finished})
    return worn_pair


def _kept(path: Path, key: str) -> tuple[ContactProblem, float, bool] | None:
    try:
        arrays, header = read_archive(path)
    except InputError:
        # No such file, or one that is damaged: made again.
        return None
    if header.get("key") != key:
        return None
    pair = _with_maps([HeightMap(arrays[f"map_{side}"], SIZE) for side in (0, 1)])
    return pair, float(header["volume"]), bool(header["finished"])


def scaled(pair: ContactProblem, cells: int) -> ContactProblem:
    """Return the pair with both maps scaled bilinearly to `cells` x `cells` cells, as the paper does it."""
    return _with_maps([one.resample((cells, cells), "bilinear") for one in _maps(pair)])


def _maps(pair: ContactProblem) -> list[HeightMap]:
    return [HeightMap(body.surface.heights(pair.plan.grid), SIZE) for body in (pair.body, pair.counter)]


def _with_maps(maps: Sequence[HeightMap]) -> ContactProblem:
    ball, ring = (Body(one, STEEL) for one in maps)
    return ContactProblem(ball, ring)
