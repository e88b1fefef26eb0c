"""A synthetic pair in place of the paper's measured ones, which are not published: a ball on a ground ring.

The domain, the ball, the steel and the loads are the paper's (section 3.2, Table 4). The roughness is that
of usual ground and lapped steel; docs/trust/paper.md has the sources.
"""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
import roughcontact as rc
from roughcontact.results import RunIn
from roughcontact.typing import replacing

Kept: TypeAlias = tuple[rc.ContactProblem, float, bool]

# Table 4: 52100 steel, and side of the domain and radius of the ball, m.
STEEL = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=6e9)
SIZE = 264.2e-6
BALL_RADIUS = 5e-3
# The paper's finest grid. Its eight cells are the shortest wave, m, so that the sub-grid area is right to
# 0.3 % there and serves as the true one. A confocal microscope resolves about half of that wave.
FINEST = 2048
SHORTEST = 8 * SIZE / FINEST
# A ground steel ring: rms heights of 0.1 to 0.4 um are usual; lengths along the lay are ten times those across.
RING = rc.SelfAffineSurface(
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
BALL = rc.SelfAffineSurface(hurst=0.8, rms_height=0.025e-6, longest=SIZE, rolloff=20e-6, shortest=SHORTEST, seed=100)
# Running in: the largest load of the paper, N, at four places along the lay of the ring, until a round of
# cycles flattens less than a hundredth of the volume so far.
RUN_IN_FORCE = 10.0
PLACES = 4
TOLERANCE = 1e-2
MODEL = "overlap"


def new_pair(cells: int) -> rc.ContactProblem:
    """Return the pair before running in, on `cells` x `cells` cells."""
    grid = rc.Grid((cells, cells), SIZE)
    ball = (rc.SphereSurface(BALL_RADIUS) + BALL).heights(grid)
    return _problem_of([rc.HeightMap(ball, SIZE), rc.HeightMap(RING.heights(grid), SIZE)])


def run_in_pair(
    pair: rc.ContactProblem, path: Path, on_cycle: Callable[[RunIn], None] | None = None
) -> rc.ContactProblem:
    """Return a pair run in at 10 N, by rounds of cycles until one flattens next to nothing.

    A file keeps the maps after each round: an interrupted run is continued from the last, and a finished
    one is not repeated. The file serves only the same pair and the same way of running in.
    """
    cells = pair.plan.grid.shape[1]
    shifts = [(0, cells * place // PLACES) for place in range(PLACES)]
    key = _key(pair, shifts)
    worn, volume, finished = _read(path, key) or (pair, 0.0, False)
    while not finished:
        result = rc.run_in(
            worn, force=RUN_IN_FORCE, shifts=shifts, model=MODEL, rounds=1, tolerance=0.0, on_cycle=on_cycle
        )
        volume += result.volume
        worn = result.problem
        finished = result.volume <= TOLERANCE * volume
        _write(path, key, (worn, volume, finished))
    return worn


def coarsen(pair: rc.ContactProblem, cells: int) -> rc.ContactProblem:
    """Return the pair with both maps scaled bilinearly to `cells` x `cells` cells, as the paper does it."""
    return _problem_of([one.resample((cells, cells), "bilinear") for one in _maps_of(pair)])


def _maps_of(pair: rc.ContactProblem) -> list[rc.HeightMap]:
    return [rc.HeightMap(body.surface.heights(pair.plan.grid), SIZE) for body in (pair.body, pair.counterbody)]


def _problem_of(maps: Sequence[rc.HeightMap]) -> rc.ContactProblem:
    ball, ring = (rc.Body(one, STEEL) for one in maps)
    return rc.ContactProblem(ball, ring)


def _key(pair: rc.ContactProblem, shifts: Sequence[tuple[int, int]]) -> str:
    """Return a digest of the maps and of the way of running in."""
    digest = hashlib.sha256(repr((STEEL, SIZE, RUN_IN_FORCE, shifts, TOLERANCE, MODEL)).encode())
    for one in _maps_of(pair):
        digest.update(one.values.tobytes())
    return digest.hexdigest()


def _write(path: Path, key: str, kept: Kept) -> None:
    worn, volume, finished = kept
    ball, ring = (one.values for one in _maps_of(worn))
    with replacing(path) as partial:
        # In memory first: numpy.savez of old versions does not close its file on a full disk.
        file = io.BytesIO()
        np.savez(file, ball=ball, ring=ring, key=key, volume=volume, finished=finished)
        partial.write_bytes(file.getvalue())


def _read(path: Path, key: str) -> Kept | None:
    try:
        with path.open("rb") as file, np.load(file) as data:
            if str(data["key"]) != key:
                return None
            maps = [rc.HeightMap(data[name], SIZE) for name in ("ball", "ring")]
            return _problem_of(maps), float(data["volume"]), bool(data["finished"])
    # No such file, or a damaged one, for which numpy has errors of many kinds: run in again.
    except Exception:
        return None
