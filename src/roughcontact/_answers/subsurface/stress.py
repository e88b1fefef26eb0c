"""The stress below the surface of a body in contact, a depth at a time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.subsurface.cells import COMPONENTS
from roughcontact._answers.subsurface.field import StressField, von_mises
from roughcontact._answers.subsurface.free import FreePlanes
from roughcontact._answers.subsurface.maximum import (
    PlanePeak,
    StressMaximum,
    find_maximum,
    find_shear,
    find_von_mises,
)
from roughcontact._answers.subsurface.periodic import PeriodicPlanes
from roughcontact._answers.subsurface.planes import StressPlanes, common_step, find_steps
from roughcontact._base.checks import Array, choice, frozen_array, numbers, read_only
from roughcontact._base.machine import require_memory, use_threads
from roughcontact._base.units import outlined, si
from roughcontact._base.warnings import ContactWarning
from roughcontact._parts.grid import Boundary, Grid
from roughcontact._solve.problem import problem_of
from roughcontact._solve.solution import ContactSolution, Response, responses
from roughcontact.errors import InputError

# Depths by default: from half a cell, each so many times the last, to two radii of the largest patch, at least some
# cells and at most half a side of the domain.
_FIRST = 0.5
_RATIO = 1.15
_RADII = 2.0
_FEWEST = 4.0
_LAST = 0.5
# Largest depth, in sides of the domain, for which the stress is computed.
_DEEPEST = 100.0
_SHARP = ContactWarning(
    "the contact has a sharp edge or reaches the border, where the stress is unbounded: it depends on the grid",
    "sharp edge",
)
_DEPTHS = "a number or a list of numbers (m), from 0 at the surface to 1e60"


@attrs.frozen(eq=False)
class Stress:
    """The stress below the surface of a body: computed when asked for, a depth at a time but for `components`.

    Iteration, `len` and ``stress[i]`` give a `StressField` for each depth.

    Attributes
    ----------
    solution
        The contact; its pressure is constant on each cell.
    depths
        Depths below the surface, shape (depths,), m.
    poisson
        Poisson's ratio of the body.
    """

    solution: ContactSolution = attrs.field(repr=False)
    depths: Array = attrs.field(converter=frozen_array, repr=outlined)
    poisson: float
    _threads: int = attrs.field(default=1, repr=False)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the stress must not be trusted, in sentences; empty without a reason."""
        warnings = [] if self.solution.status.success else [ContactWarning(str(self.solution.status), "convergence")]
        if self.solution.boundary is Boundary.WRAPPED:
            text = "beyond the wrapped border nothing lies for the stress, as if the boundary were free"
            warnings.append(ContactWarning(text, "wrapped boundary"))
        return tuple(warnings)

    def __len__(self) -> int:
        return self.depths.size

    def __getitem__(self, index: int) -> StressField:
        if isinstance(index, bool) or not isinstance(index, (int, np.integer)) or not -len(self) <= index < len(self):
            raise InputError.about("The number of a depth", index, f"a whole number from 0 to {len(self) - 1}")
        depth = float(self.depths[index])
        return self._field(depth, find_steps(self._grid.shape, self._sides, depth / self._grid.spacing[0]))

    def __iter__(self) -> Iterator[StressField]:
        return (self[index] for index in range(len(self)))

    @cached_property
    def components(self) -> Array:
        """The components xx, yy, zz, yz, xz, xy at all depths, shape (depths, 6, nx, ny), Pa; tension is positive."""
        stress = self._allocate((len(self), len(COMPONENTS), *self._grid.shape))
        for place, depth in enumerate(self.depths):
            stress[place] = self._field(float(depth), (1, 1)).values
            stress[place] *= self._scale
        return read_only(stress)

    @cached_property
    def von_mises(self) -> Array:
        """Von Mises equivalent stress at all depths, shape (depths, nx, ny), Pa."""
        stress = self._allocate((len(self), *self._grid.shape))
        for place, depth in enumerate(self.depths):
            stress[place] = von_mises(self._field(float(depth), (1, 1)).values)
            stress[place] *= self._scale
        return read_only(stress)

    @property
    def maximum(self) -> StressMaximum:
        """The maximum of the von Mises stress, between the points and the depths, with its place and uncertainty."""
        return self._find_maximum(0)

    @property
    def maximum_shear(self) -> StressMaximum:
        """The maximum shear stress, of all directions, with its place and uncertainty."""
        return self._find_maximum(1)

    @property
    def profile(self) -> Array:
        """The maximum of the von Mises stress at each depth, shape (depths,), Pa."""
        known = {float(depth): peak[0].value for depth, peak in zip(np.unique(self.depths), self._peaks, strict=True)}
        return np.array([known[float(depth)] * self._scale for depth in self.depths])

    def _find_maximum(self, measure: int) -> StressMaximum:
        peaks = [peak[measure] for peak in self._peaks]
        found = find_maximum(np.unique(self.depths), peaks, self._scale, max(self._grid.spacing))
        if self._reaches_border or (found.warnings and self._has_sharp_edge):
            found = attrs.evolve(found, uncertainty=found.value, warnings=(*found.warnings, _SHARP))
        return attrs.evolve(found, warnings=(*self.warnings, *found.warnings))

    @property
    def _reaches_border(self) -> bool:
        contact = self.solution.contact
        sides = (0, -1)
        reaches = any(contact[side].any() or contact[:, side].any() for side in sides)
        return reaches and self.solution.boundary is not Boundary.PERIODIC

    @cached_property
    def _has_sharp_edge(self) -> bool:
        # Such a maximum of the pressure is as uncertain as it is large.
        peak = self.solution.peak_pressure()
        return peak.uncertainty >= peak.value

    @cached_property
    def _peaks(self) -> list[tuple[PlanePeak, PlanePeak]]:
        """The maxima of von Mises stress and maximum shear at each depth, from the smallest to the largest."""
        order = np.unique(self.depths, return_index=True)[1]
        fields = (self[int(index)] for index in order)
        return [
            (find_von_mises(field, self.solution.boundary), find_shear(field, self.solution.boundary))
            for field in fields
        ]

    @property
    def _grid(self) -> Grid:
        return self.solution.grid

    @cached_property
    def _scale(self) -> float:
        return float(self.solution.pressure.max())

    @property
    def _sides(self) -> tuple[float, float]:
        return 1.0, self._grid.spacing[1] / self._grid.spacing[0]

    @cached_property
    def _planes(self) -> StressPlanes:
        pressure = (self.solution.pressure / self._scale).astype(np.float32)
        if self.solution.boundary is Boundary.PERIODIC:
            return PeriodicPlanes(pressure, self._sides)
        steps = [find_steps(self._grid.shape, self._sides, float(z)) for z in self.depths / self._grid.spacing[0]]
        return FreePlanes(pressure, self._sides, common_step(steps))

    def _field(self, depth: float, steps: tuple[int, int]) -> StressField:
        grid = self._grid
        if steps != (1, 1):
            grid = Grid((grid.shape[0] // steps[0], grid.shape[1] // steps[1]), grid.size)
        with use_threads(self._threads):
            values = self._planes.at(depth / self._grid.spacing[0], self.poisson, steps)
        return StressField(depth, grid, values, self._scale)

    def _allocate(self, shape: tuple[int, ...]) -> Array:
        advice = "ask for fewer depths, or go through them one at a time, for field in stress"
        require_memory(8.0 * math.prod(shape), f"The stress at {len(self)} depths", advice)
        return np.empty(shape)

    def __str__(self) -> str:
        return (
            f"stress at {len(self)} depths from {si(float(self.depths.min()), 'm')} to "
            f"{si(float(self.depths.max()), 'm')}\n"
            f"maximum von Mises stress {self.maximum}\nmaximum shear stress {self.maximum_shear}"
        )


def _depths(value: Any) -> Array | None:
    if value is None:
        return None
    depths = np.atleast_1d(numbers(value, "The depths", _DEPTHS))
    if depths.ndim != 1 or depths.size == 0 or not np.all((depths >= 0.0) & (depths <= 1e60)):
        raise InputError.about("The depths", value, _DEPTHS)
    return frozen_array(depths)


def body_name(value: str) -> str:
    """Return the name of one of the bodies, or raise `InputError`."""
    return choice(value, "The body", ("body", "counterbody"))


@responses.register("stress")
@attrs.frozen(eq=False)
class StressBelow(Response[Stress]):
    """Stress below the surface of one of the bodies, by Love's solution for each cell of the contact.

    Parameters
    ----------
    depths
        Depths below the surface, m; None: from half a cell to two radii of the largest contact patch, each 1.15 times
        the last.
    body
        ``"body"`` or ``"counterbody"``.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009
    """

    depths: Array | None = attrs.field(default=None, converter=_depths)
    body: str = attrs.field(default="body", converter=body_name)

    def respond(self, solution: ContactSolution) -> Stress:
        """Return the stress; see `Response.respond`."""
        if solution.moduli is not None:
            raise InputError(
                "The stress below the surface is that of a homogeneous half-space; this kernel is of another."
            )
        scale = float(solution.pressure.max())
        if not (math.isfinite(scale) and scale > 0.0):
            raise InputError(
                "The contact carries no load, or its pressure is not finite: there is no stress to compute."
            )
        problem = problem_of(solution)
        material = getattr(problem, self.body).material
        poisson = getattr(material, "poisson", None)
        if poisson is None or material.compliance == 0.0:
            what = f"The material of the {self.body}, {type(material).__name__}, has"
            other = "counterbody" if self.body == "body" else "body"
            raise InputError(
                f"{what} no stress below its surface: ask for body='{other}', or give it a Poisson's ratio."
            )
        depths = default_depths(solution) if self.depths is None else self.depths
        deepest = _DEEPEST * max(solution.grid.size)
        if float(depths.max()) > deepest:
            allowed = f"at most {si(deepest, 'm')}, {_DEEPEST:g} times the side of the domain"
            raise InputError.about("A depth", float(depths.max()), allowed, "Depths are in metres.")
        return Stress(solution, depths, float(poisson), threads=problem.plan.thread_choice[0])


def default_depths(solution: ContactSolution) -> Array:
    """Return depths in which the maximum of the stress is found, m, ascending."""
    cell = max(solution.grid.spacing)
    patches = solution.patches
    radius = math.sqrt(float(patches.areas.max()) / math.pi) if patches.count else 0.0
    last = max(_FEWEST * cell, min(_RADII * radius, _LAST * max(solution.grid.size)))
    count = math.ceil(math.log(last / (_FIRST * cell)) / math.log(_RATIO)) + 1
    return np.asarray(np.geomspace(_FIRST * cell, last, count), dtype=np.float64)
