"""Claims about area estimators."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.grid import Boundary, Grid
from roughcontact.solution import Area, ContactSolution, EstimatesArea
from roughcontact.testing.claim import Claim, require
from roughcontact.testing.common import common
from roughcontact.testing.moved import copied, mirrored, scaled, shifted
from roughcontact.testing.scenes import full, rough, sphere

_LOADS = (0.002, 0.005, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
_CLOSE = 1e-9


def _scenes() -> tuple[tuple[str, ContactSolution], ...]:
    return (
        ("a rough surface", rough(0.05)),
        ("a rough surface on a free boundary", rough(0.05, Boundary.FREE)),
        ("a rough surface that flows", rough(0.05, Boundary.PERIODIC, True)),
        ("a sphere", sphere(5.0, (0.3, 0.1))),
        ("full contact", full()),
    )


def _sound(estimator: EstimatesArea) -> str:
    bars = []
    for name, solution in _scenes():
        area = estimator.estimate(solution)
        require(isinstance(area, Area), f"{name}: returned {type(area).__name__}, no Area")
        require(math.isfinite(area.value) and area.value >= 0.0, f"{name}: an area of {area.value} m2")
        require(area.value <= solution.grid.area * (1 + _CLOSE), f"{name}: an area greater than the domain")
        whole = math.isclose(area.fraction, area.value / solution.grid.area, rel_tol=_CLOSE)
        require(whole, f"{name}: the fraction {area.fraction:g} is not value over nominal area")
        good = math.isfinite(area.uncertainty) and area.uncertainty >= 0.0
        require(good, f"{name}: an uncertainty of {area.uncertainty} m2")
        require(isinstance(area.estimator, str) and area.estimator, f"{name}: it does not tell its name")
        bars.append(area.uncertainty / area.value if area.value else 0.0)
    return f"areas within the domain, bars of 0 to {100 * max(bars):.2g} %"


def _clusters(estimator: EstimatesArea) -> str:
    for name, solution in _scenes():
        area = estimator.estimate(solution)
        if area.clusters is not None:
            require(area.clusters.shape == (solution.clusters.count,), f"{name}: not one area for each cluster")
            total = float(area.clusters.sum())
            require(math.isclose(total, area.value, rel_tol=1e-6), f"{name}: the clusters have {total:g} m2 together")
    return "together the area, where it tells them"


def _full(estimator: EstimatesArea) -> str:
    area = estimator.estimate(full())
    require(abs(area.fraction - 1.0) <= 1e-12, f"full contact is {100 * area.fraction:.6g} % of the domain")
    return "the domain"


def _empty(estimator: EstimatesArea) -> str:
    for name, solution in _scenes():
        nothing: Array = np.zeros_like(solution.pressure)
        apart = attrs.evolve(
            solution, pressure=nothing, displacement=nothing, approach=-float(np.std(solution.undeformed))
        )
        area = estimator.estimate(apart)
        require(area.value == 0.0, f"{name}: {area.value:g} m2 where nothing touches")
        require(area.uncertainty >= 0.0, f"{name}: an uncertainty of {area.uncertainty} m2 where nothing touches")
    return "nothing where nothing touches"


def _monotone(estimator: EstimatesArea) -> str:
    for boundary, capped in ((Boundary.PERIODIC, False), (Boundary.FREE, False)):
        found = [(load, estimator.estimate(rough(load, boundary, capped)).fraction) for load in _LOADS]
        for (light, less), (heavy, more) in itertools.pairwise(found):
            require(
                more >= less,
                f"boundary {boundary}: the area falls from {100 * less:.4g} to {100 * more:.4g} % as the load "
                f"rises from {light:g} to {heavy:g} of E* slope",
            )
    return f"from {100 * found[0][1]:.3g} to {100 * found[-1][1]:.3g} % over {len(_LOADS)} loads"


def _hertz(estimator: EstimatesArea) -> str:
    rng, held, worst = np.random.default_rng(2), [], 0.0
    for cells in (2.5, 4.0, 6.5, 11.0):
        for x, y in rng.uniform(-0.5, 0.5, (4, 2)):
            solution = sphere(cells, (float(x), float(y)))
            exact = math.pi * (cells * solution.grid.spacing[0]) ** 2
            area = estimator.estimate(solution)
            held.append(abs(area.value - exact) <= 2 * area.uncertainty)
            worst = max(worst, abs(area.value / exact - 1.0))
    share = float(np.mean(held))
    require(share >= 0.9, f"two bars hold {100 * share:.0f} % of the spheres; errors reach {100 * worst:.2g} %")
    return f"two bars hold {100 * share:.0f} % of the spheres; errors reach {100 * worst:.2g} %"


def _same(estimator: EstimatesArea, solution: ContactSolution, other: ContactSolution, factor: float) -> float:
    one, two = estimator.estimate(solution), estimator.estimate(other)
    off = abs(two.value / factor - one.value) / one.value
    return max(off, abs(two.uncertainty / factor - one.uncertainty) / one.value)


def _mirrored(estimator: EstimatesArea) -> str:
    worst = 0.0
    for name, solution in _scenes():
        for axes in ((0,), (1,), (0, 1)):
            worst = max(worst, _same(estimator, solution, mirrored(solution, axes), 1.0))
            require(worst <= _CLOSE, f"{name}: seen in a mirror its area differs by {worst:.1e}")
    return f"one area, to {worst:.0e}"


def _shifted(estimator: EstimatesArea) -> str:
    worst = 0.0
    for solution in (rough(0.05), rough(0.05, Boundary.PERIODIC, True)):
        for shift in ((1, 0), (0, 1), (17, 23)):
            worst = max(worst, _same(estimator, solution, shifted(solution, shift), 1.0))
            require(worst <= _CLOSE, f"moved by {shift} cells on a periodic domain its area differs by {worst:.1e}")
    return f"one area, to {worst:.0e}"


def _units(estimator: EstimatesArea) -> str:
    worst = 0.0
    for name, solution in _scenes():
        for length, stiffness in ((2.0**10, 1.0), (3e-4, 1.0), (1.0, 7e4)):
            other = scaled(solution, length, stiffness)
            worst = max(worst, _same(estimator, solution, other, length**2))
            require(
                worst <= _CLOSE,
                f"{name}: lengths times {length:g} and moduli times {stiffness:g} change it by {worst:.1e}",
            )
    return f"areas scale as lengths squared, to {worst:.0e}"


def _untouched(estimator: EstimatesArea) -> str:
    for name, solution in _scenes():
        given = copied(solution)
        estimator.estimate(given)
        for field in ("pressure", "displacement", "undeformed", "gap", "contact"):
            same = np.array_equal(getattr(given, field), getattr(solution, field))
            require(same, f"{name}: it changed the {field} of the solution")
    return "the solution is left as it was"


def _repeatable(estimator: EstimatesArea) -> str:
    for name, solution in _scenes():
        one, two = estimator.estimate(solution), estimator.estimate(solution)
        same = (one.value, one.uncertainty) == (two.value, two.uncertainty)
        require(same, f"{name}: asked again, it answers differently")
    return "the same bits, asked again"


def _small(estimator: EstimatesArea) -> str:
    for shape in ((2, 1), (1, 2), (1, 9), (3, 2)):
        for count in range(shape[0] * shape[1] + 1):
            solution = attrs.evolve(
                full(),
                grid=Grid(shape, (shape[0] * 1e-6, shape[1] * 1e-6)),
                pressure=np.where(np.arange(shape[0] * shape[1]).reshape(shape) < count, 1e6, 0.0),
                displacement=np.zeros(shape),
                undeformed=np.where(np.arange(shape[0] * shape[1]).reshape(shape) < count, 0.0, 1e-8),
                approach=0.0,
                origin=None,
            )
            value = estimator.estimate(solution).value
            require(math.isfinite(value), f"{count} cells in contact of {shape} have {value} m2")
    return "finite on grids of a few cells"


CLAIMS = (
    Claim("area", "sound areas and bars", _sound),
    Claim("area", "areas of clusters", _clusters),
    Claim("area", "full contact", _full),
    Claim("area", "no contact", _empty),
    Claim("area", "monotone in the load", _monotone),
    Claim("area", "bars hold Hertz", _hertz),
    Claim("area", "mirror images", _mirrored),
    Claim("area", "moved contacts", _shifted),
    Claim("area", "units", _units),
    Claim("area", "solution left as it was", _untouched),
    Claim("area", "repeatable", _repeatable),
    Claim("area", "few cells", _small),
    *common("area"),
)
