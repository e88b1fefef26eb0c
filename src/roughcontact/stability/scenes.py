"""The gallery's scenes: stiff, extreme, or not to be solved at all."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Array
from roughcontact.grid import Grid
from roughcontact.materials import Elastic, ElasticPerfectlyPlastic
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import HeightMap, SelfAffineSurface

_CELLS = 48
_YOUNG = 1e9
_POISSON = 0.3
_HARDNESS = 1e6


@attrs.frozen(eq=False)
class Scene:
    """A contact to be solved at a load.

    Attributes
    ----------
    name
        What is extreme about it.
    problem
        Makes the problem, or refuses.
    pressure
        Nominal mean pressure, Pa.
    """

    name: str
    problem: Callable[[], ContactProblem]
    pressure: float


def scenes() -> tuple[Scene, ...]:
    """Return all scenes."""
    return (*_magnitudes(), *_shapes(), *_loads(), *_bad())


def _rough(cells: int = _CELLS) -> Array:
    """Return heights of about one on cells of one."""
    surface = SelfAffineSurface(hurst=0.8, rms_height=1.0, shortest=6.0, longest=float(cells), seed=0)
    return surface.heights(Grid((cells, cells), float(cells)))


def _scene(
    name: str,
    heights: Array,
    size: float | tuple[float, float] = 1.0,
    *,
    young: float = _YOUNG,
    share: float = 0.01,
    boundary: str = "free",
) -> Scene:
    """Return an elastic scene at a share of E times the mean slope."""

    def make() -> ContactProblem:
        body = Body(HeightMap(heights, size=size), Elastic(young, _POISSON))
        return ContactProblem(body, boundary=boundary)

    return Scene(name, make, share * young * float(np.ptp(heights)) / float(np.max(size)))


def _long(aspect: float, boundary: str, share: float) -> Scene:
    name = f"cells of aspect {aspect:g}, {boundary}, {'light' if share < 0.1 else 'heavy'}"
    return _scene(name, _rough(16), (aspect, 1.0), boundary=boundary, share=share * max(aspect, 1.0))


def _plastic(name: str, share: float, boundary: str, limit: float = _HARDNESS) -> Scene:
    def make() -> ContactProblem:
        body = Body(HeightMap(1e-2 * _rough(), size=1.0), ElasticPerfectlyPlastic(_YOUNG, _POISSON, limit))
        return ContactProblem(body, boundary=boundary)

    return Scene(name, make, share * _HARDNESS)


def _magnitudes() -> tuple[Scene, ...]:
    return (
        *(_scene(f"E = {young:.0e} Pa", 1e-2 * _rough(), young=young) for young in (1.0, 1e5, 1e10, 1e15)),
        *(_scene(f"heights of {height:.0e} m on 1 m", height * _rough()) for height in (1e-12, 1e-6, 1.0, 1e3)),
        _scene("heights of 1e-12 m on 1e-9 m", 1e-12 * _rough(), 1e-9),
        _scene("heights of 1e3 m on 1e9 m", 1e3 * _rough(), 1e9),
        _scene("two scales 1e6 apart", _rough() + 1e-6 * np.random.default_rng(1).standard_normal((_CELLS, _CELLS))),
    )


def _shapes() -> tuple[Scene, ...]:
    needle, step = np.zeros((_CELLS, _CELLS)), np.zeros((_CELLS, _CELLS))
    needle[_CELLS // 2, _CELLS // 3] = 1e-2
    step[: _CELLS // 2] = 1e-2
    noise = np.random.default_rng(0).standard_normal((2, 4096))
    return (
        *(_long(aspect, boundary, share) for aspect in (1e-3, 1e3) for boundary in ("free", "periodic")
          for share in (0.01, 1.0)),
        *(_scene(f"needle, {100 * share:g} %", needle, share=share) for share in (1e-6, 1e-2)),
        *(_scene(f"step, {boundary}", step, boundary=boundary) for boundary in ("free", "periodic")),
        *(_scene(f"2 x 4096 cells, {boundary}", noise, (2.0, 4096.0), boundary=boundary, share=10.0)
          for boundary in ("free", "periodic")),
        *(_scene(f"1 x 500 cells, {boundary}", noise[:1, :500], (1.0, 500.0), boundary=boundary)
          for boundary in ("free", "periodic")),
        _scene("two cells", np.array([[0.0, 1e-3]]), (1.0, 2.0)),
    )  # fmt: skip


def _loads() -> tuple[Scene, ...]:
    return (
        _scene("one cell touches", _rough(), share=1e-9),
        _scene("one cell touches, periodic", _rough(), share=1e-9, boundary="periodic"),
        *(_scene(f"full contact, {boundary}", 1e-2 * _rough(), share=1e2, boundary=boundary)
          for boundary in ("free", "periodic")),
        *(_scene(f"mean pressure {share:.0e} E relief, periodic", 1e-2 * _rough(), share=share, boundary="periodic")
          for share in (1e6, 1e9, 1e12)),
        *(_plastic(f"mean pressure {share:g} H, {boundary}", share, boundary)
          for share in (0.999, 1.0) for boundary in ("free", "periodic")),
        _plastic("limit one ulp above the mean", 1.0, "free", float(np.nextafter(_HARDNESS, np.inf))),
        _plastic("mean pressure 1.001 H", 1.001, "free"),
    )  # fmt: skip


def _bad() -> tuple[Scene, ...]:
    lost = _rough()
    lost[3, 5] = np.nan
    return (
        attrs.evolve(_scene("one NaN", lost), pressure=_HARDNESS),
        _scene("no relief", np.zeros((_CELLS, _CELLS)), share=0.0),
        Scene("heights of 1e300 m", _scene("", 1e300 * _rough()).problem, _HARDNESS),
        Scene("a modulus without its giga", _scene("", 1e-9 * _rough(), 0.1, young=210.0).problem, 1e9),
    )
