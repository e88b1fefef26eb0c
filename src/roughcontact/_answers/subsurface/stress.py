"""The stress below the surface of a body in contact, one depth at a time, and its maximum between the depths."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.subsurface.edge import EdgeStress, find_edge_stress
from roughcontact._answers.subsurface.field import (
    Measure,
    StressField,
    common_step,
    find_crossland,
    find_dang_van,
    find_steps,
    list_paths,
    maximum_principal,
    maximum_shear,
    von_mises,
)
from roughcontact._answers.subsurface.inputs import (
    MAX_LOAD_RATIO,
    SupportsResidualStress,
    body_name,
    coefficient,
    degrees,
    read_depths,
    read_residual,
    read_traction,
    sliding_traction,
)
from roughcontact._answers.subsurface.maximum import (
    MIN_DEPTH_CELLS,
    MIN_RELATIVE_ERROR,
    PlanePeak,
    StressMaximum,
    default_depths,
    find_maxima_of_layers,
    find_shear,
    find_von_mises,
    is_near_surface,
    judge_depth,
    with_interfaces,
)
from roughcontact._answers.subsurface.near import find_near_maxima, replace_by_finer
from roughcontact._answers.subsurface.summit import judge_by_summit
from roughcontact._base import checks
from roughcontact._base.arrays import Array, RealArray, Waves, frozen_array, read_only
from roughcontact._base.checks import number
from roughcontact._base.machine import require_memory, use_threads
from roughcontact._base.units import ShownAsPrinted, WarningText, outlined, si
from roughcontact._parts.grid import Boundary, Grid, list_borders
from roughcontact._parts.kernels import STRESS_COMPONENTS, HalfSpaceStress, Love, SupportsStress
from roughcontact._solve.convolvers import StressConvolution
from roughcontact._solve.problem import ContactProblem, problem_of
from roughcontact._solve.solution import ContactSolution, Response, judge, responses
from roughcontact.errors import InputError, argument
from roughcontact.errors.warning import Answer

# Largest depth, in sides of the domain, for which the stress is computed.
_MAX_DEPTH_SIDES = 100.0
_SHARP_EDGE_WARNING = WarningText(
    "the contact has a sharp edge or a crease, or reaches the border, where the stress is unbounded: it grows with "
    "every grid",
    "sharp edge",
)


@attrs.frozen(eq=False)
class Stress(ShownAsPrinted, Answer):
    """The stress below the surface of a body, computed on access: one depth at a time, except for `components`.

    Iteration, `len` and ``stress[i]`` give a `StressField` for each depth.

    Attributes
    ----------
    solution
        The contact; its pressure is constant on each cell.
    depths
        Depths below the surface, shape (depths,), m.
    poisson
        Poisson's ratio of the body, under its layers if it has some.
    traction
        Tangential traction on this body along x and y, shape (2, nx, ny), Pa; None without.
    residual
        The stress of the body without a load, which adds to that of the contact; None without.
    """

    solution: ContactSolution = attrs.field(repr=False)
    depths: Array = attrs.field(converter=frozen_array, repr=outlined)
    poisson: float
    traction: Array | None = attrs.field(default=None, converter=attrs.converters.optional(frozen_array), repr=outlined)
    residual: SupportsResidualStress | None = attrs.field(default=None, kw_only=True)
    _kernel: SupportsStress = attrs.field(kw_only=True, repr=False)
    _asked: Response[Any] = attrs.field(kw_only=True, repr=False)
    _threads: int = attrs.field(default=1, repr=False)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the stress must not be trusted, in sentences; empty without a reason."""
        warnings = [] if self.solution.status.success else [WarningText(str(self.solution.status), "convergence")]
        if self.solution.boundary is Boundary.WRAPPED:
            text = "beyond the wrapped border nothing lies for the stress, as if the boundary were free"
            warnings.append(WarningText(text, "wrapped boundary"))
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
        return self._stack((len(STRESS_COMPONENTS),), lambda values: values)

    @cached_property
    def von_mises(self) -> Array:
        """Von Mises equivalent stress at all depths, shape (depths, nx, ny), Pa."""
        return self._stack((), von_mises)

    @property
    def maximum(self) -> StressMaximum:
        """The maximum of the von Mises stress, between the points and the depths, with its place and uncertainty."""
        return self._judge_by_grids(self._find_maximum(0, von_mises), "von_mises")

    @property
    def maximum_shear(self) -> StressMaximum:
        """The maximum shear stress, of all directions, with its place and uncertainty."""
        return self._judge_by_grids(self._find_maximum(1, maximum_shear), "shear")

    @cached_property
    def maximum_principal(self) -> StressMaximum:
        """The maximum principal stress at the surface, where brittle bodies crack; tension is positive.

        Behind a sliding contact it has a peak, which cells of constant load smooth: around it the pressure is fitted in
        finer cells, with the place of the edge.
        """
        edge = self._edge
        value, uncertainty = edge.extrapolate(maximum_principal)
        uncertainty = max(uncertainty, MIN_RELATIVE_ERROR * abs(value)) * self._scale
        found = StressMaximum(value * self._scale, uncertainty, edge.x, edge.y, 0.0, self.warnings)
        return self._judge_place(found)

    @property
    def estimates(self) -> dict[str, StressMaximum]:
        """The maximum von Mises stress and the maximum shear stress, by name."""
        return {"von_mises": self.maximum, "shear": self.maximum_shear}

    def crossland(self, alpha: float, axis: int = 0) -> Array:
        r"""Return Crossland's fatigue number at each depth for a contact that rolls or slides along an axis.

        A point of the body passes through all stresses s along the axis. From its path, with :math:`R` the radius of
        the smallest sphere around the deviators, in the norm :math:`\sqrt{s_{ij} s_{ij}}`, and :math:`\sigma_H` a third
        of the trace,

        .. math:: \sqrt{J_{2,a}} + \alpha\, \max_t \sigma_H(t), \quad \sqrt{J_{2,a}} = R / \sqrt 2

        The point comes from where there is no stress; on a periodic boundary from the period before. A life is endless
        where the number is below the fatigue limit in torsion.

        Parameters
        ----------
        alpha
            Sensitivity to the mean stress, a constant of the material.
        axis
            Axis of rolling: 0 (x) or 1 (y).

        Returns
        -------
        numpy.ndarray
            The maximum over all paths, shape (depths,), Pa.
        """
        return self._find_fatigue(find_crossland, alpha, axis)

    def dang_van(self, alpha: float, axis: int = 0) -> Array:
        r"""Return Dang Van's fatigue number at each depth for a contact that rolls or slides along an axis.

        The mesoscopic shear stress is that around the centre :math:`s^*` of the smallest sphere of `crossland`:

        .. math:: \max_t \left[\tau(t) + \alpha\, \sigma_H(t)\right], \quad
                  \tau = \tfrac12 (\hat s_1 - \hat s_3), \quad \hat s = s(t) - s^*

        Parameters
        ----------
        alpha
            Sensitivity to the mean stress, a constant of the material.
        axis
            Axis of rolling: 0 (x) or 1 (y).

        Returns
        -------
        numpy.ndarray
            The maximum over all paths, shape (depths,), Pa.

        References
        ----------
        Dang Van, Griveau, Message, in: Biaxial and Multiaxial Fatigue, EGF 3 (1989) 479-496
        """
        return self._find_fatigue(find_dang_van, alpha, axis)

    def _find_fatigue(self, find: Callable[[RealArray, float], float], alpha: float, axis: int) -> Array:
        alpha = number(alpha, "The sensitivity to the mean stress", at_least=0.0)
        axis = checks.axis(axis, "The axis of rolling")
        starts_unloaded = not self.solution.boundary.repeats[axis]
        found = []
        for field in self:
            # A point comes from where the body has its residual stress alone.
            rest = self._find_rest(field.depth)
            found.append(find(list_paths(field.values - rest, axis, starts_unloaded) + rest, alpha))
        return np.array(found) * self._scale

    @property
    def profile(self) -> Array:
        """The maximum of the von Mises stress at each depth, shape (depths,), Pa."""
        known = {float(depth): peak[0].value for depth, peak in zip(np.unique(self.depths), self._peaks, strict=True)}
        return np.array([known[float(depth)] * self._scale for depth in self.depths])

    @property
    def maxima(self) -> dict[int, StressMaximum]:
        """The maximum of the von Mises stress in each layer, from the topmost, 0, to the body under all."""
        return {k: self._judge(one, von_mises, at_surface=k == 0) for k, one in self._find_in_layers(0).items()}

    def _find_maximum(self, place: int, measure: Measure) -> StressMaximum:
        found = max(self._find_in_layers(place).values(), key=lambda one: one.value)
        return self._judge(found, measure, at_surface=True)

    def _judge_by_grids(self, found: StressMaximum, name: str) -> StressMaximum:
        """Return a maximum with the uncertainty that its solution asks for."""
        solution = self.solution
        return judge(solution, found, solution.uncertainty, lambda one: one.response(self._asked).estimates[name])

    def _find_in_layers(self, place: int) -> dict[int, StressMaximum]:
        peaks = [peak[place] for peak in self._peaks]
        ends = np.append(self._kernel.interfaces, self._kernel.base_depth)
        cell = max(self._grid.resolved.spacing)
        return find_maxima_of_layers(np.unique(self.depths), ends, peaks, self._scale, cell)

    def _judge(self, found: StressMaximum, measure: Measure, *, at_surface: bool) -> StressMaximum:
        """Return a maximum beside the peak at the edge of a sliding contact, if at the surface, with warnings."""
        if at_surface and self.traction is not None and (self.depths == 0.0).any():
            found = self._compare_with_edge(found, measure)
        found = self._judge_place(found)
        if self.traction is None and self.residual is None and isinstance(self._kernel, HalfSpaceStress):
            if is_near_surface(found, self.solution) and measure in self._near:
                found = replace_by_finer(found, self._near[measure], self.solution)
            found = judge_by_summit(found, self.solution, self.poisson, measure)
        return attrs.evolve(found, warnings=(*self.warnings, *found.warnings))

    def _judge_place(self, found: StressMaximum) -> StressMaximum:
        """Return a maximum that is as uncertain as its place, at sharp edges or some cells below the surface."""
        near = found.depth < MIN_DEPTH_CELLS * max(self._grid.resolved.spacing)
        # Beyond a wrapped border nothing lies for the stress, whose pressure is bounded there.
        if self._reaches_border and (self.solution.boundary is Boundary.WRAPPED or self._has_sharp_edge):
            return self._warn_of_edge(found)
        if (near or found.warnings) and self._has_sharp_edge:
            return self._warn_of_edge(found)
        return judge_depth(found, self.solution)

    def _warn_of_edge(self, found: StressMaximum) -> StressMaximum:
        return attrs.evolve(found, uncertainty=abs(found.value), warnings=(*found.warnings, _SHARP_EDGE_WARNING))

    def _compare_with_edge(self, found: StressMaximum, measure: Measure) -> StressMaximum:
        """Return the larger one of a maximum between the cells and the peak at an edge, which the cells smooth."""
        value, uncertainty = (part * self._scale for part in self._edge.extrapolate(measure))
        if value > found.value:
            return StressMaximum(value, uncertainty, self._edge.x, self._edge.y, 0.0)
        above = max(value + uncertainty - found.value, 0.0)
        return attrs.evolve(found, uncertainty=math.hypot(found.uncertainty, above))

    @cached_property
    def _near(self) -> dict[Measure, StressMaximum]:
        return find_near_maxima(self.solution, self.poisson, lambda depth: self._field(depth, (1, 1)))

    @cached_property
    def _edge(self) -> EdgeStress:
        pressure = self.solution.pressure / self._scale
        traction = None if self.traction is None else self.traction / self._scale
        return find_edge_stress(
            self._field(0.0, (1, 1)), pressure, traction, self._kernel.poisson_at(0.0), self.solution.boundary
        )

    @property
    def _reaches_border(self) -> bool:
        boundary = self.solution.boundary
        borders = Boundary.FREE if boundary is Boundary.WRAPPED else boundary
        return any(border.any() for border in list_borders(self.solution.contact, borders))

    @cached_property
    def _has_sharp_edge(self) -> bool:
        # The uncertainty of the maximum pressure at a sharp edge is the pressure itself.
        peak = self.solution.peak_pressure(uncertainty="model")
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
    def _convolution(self) -> StressConvolution:
        steps = [find_steps(self._grid.shape, self._sides, float(z)) for z in self.depths / self._grid.spacing[0]]
        return StressConvolution(self._kernel, self._grid, self.solution.boundary, common_step(steps))

    @cached_property
    def _loads(self) -> tuple[str, Waves]:
        """The letters of the loads that are not zero, and their waves."""
        fields = [self.solution.pressure] if self.traction is None else [self.solution.pressure, *self.traction]
        loads = {letter: field / self._scale for letter, field in zip("zxy", fields, strict=False) if field.any()}
        of = "".join(loads)
        return of, self._convolution.transform(np.array([*loads.values()], dtype=np.float32), of)

    def _field(self, depth: float, steps: tuple[int, int]) -> StressField:
        grid = self._grid
        if steps != (1, 1):
            grid = Grid((grid.shape[0] // steps[0], grid.shape[1] // steps[1]), grid.size)
        with use_threads(self._threads):
            of, waves = self._loads
            values = self._convolution.apply(waves, depth, of, steps)
        if self.residual is not None:
            values += self._find_rest(depth)
        return StressField(depth, grid, values, self._scale)

    def _find_rest(self, depth: float) -> RealArray:
        """Return the residual stress at a depth over the scale, shape (6, 1, 1)."""
        if self.residual is None:
            return np.zeros((6, 1, 1))
        return self.residual.find_stress(np.array([depth])).reshape(6, 1, 1) / self._scale

    def _stack(self, axes: tuple[int, ...], measure: Measure) -> Array:
        """Return a measure of the stress, of shape (`axes`, nx, ny), at all depths, Pa."""
        shape = (len(self), *axes, *self._grid.shape)
        advice = "ask for fewer depths, or go through them one at a time, for field in stress"
        require_memory(8.0 * math.prod(shape), f"The stress at {len(self)} depths", advice)
        stress = np.empty(shape)
        for place, depth in enumerate(self.depths):
            stress[place] = measure(self._field(float(depth), (1, 1)).values)
            stress[place] *= self._scale
        return read_only(stress)

    def __str__(self) -> str:
        return (
            f"stress at {len(self)} depths from {si(float(self.depths.min()), 'm')} to "
            f"{si(float(self.depths.max()), 'm')}\n"
            f"maximum von Mises stress {self.maximum}\nmaximum shear stress {self.maximum_shear}"
        )


@responses.register("stress")
@attrs.frozen(eq=False)
class StressBelow(Response[Stress]):
    r"""Stress below the surface of one of the bodies, by Love's and Cerruti's solutions for each cell of the contact.

    A traction on the body along x presses it together ahead of the contact, at larger x, and pulls it behind. The
    counterbody has the opposite traction, so that it is pulled at larger x. The stress :math:`\sigma_{xz}` has the
    opposite sign of the traction, as z points into the body.

    Parameters
    ----------
    depths
        Depths below the surface, m; None: from half a cell to two radii of the largest contact patch, each 1.15 times
        the last, and the surface itself where there is a tangential traction.
    body
        ``"body"`` or ``"counterbody"``.
    traction
        Tangential traction on the body along x and y, shape (2, nx, ny), Pa; the counterbody has the opposite one.
    friction
        In place of a traction: the coefficient of friction, a number or shape (nx, ny), of a contact in full sliding,
        whose traction is the friction times the contact pressure.
    direction
        Direction of this traction on the body, degrees from x towards y: against the sliding of the body.
    residual
        Residual stress of the body by depth, such as ``ResidualStress`` of the plug-in roughcontact-volume.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377-420, https://doi.org/10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), sec. 3.6, https://doi.org/10.1017/CBO9781139171731
    """

    holds_with = frozenset({"tension", "shear", "relaxation"})
    fails_with = frozenset({"inner stress"})
    memory_arrays = 32.0  # one plane at a time, by pressure and traction on a free boundary

    depths: Array | None = attrs.field(default=None, converter=read_depths, metadata={"unit": "m"})
    body: str = attrs.field(default="body", converter=body_name)
    traction: Array | None = attrs.field(default=None, converter=read_traction, repr=outlined)
    friction: Array | None = attrs.field(default=None, converter=coefficient, repr=outlined, metadata={"unit": ""})
    direction: float = attrs.field(default=0.0, converter=degrees)
    residual: SupportsResidualStress | None = attrs.field(default=None, converter=read_residual)

    def __attrs_post_init__(self) -> None:
        if self.traction is not None and self.friction is not None:
            raise InputError("Both a traction and a friction were given: give one of them.")

    def respond(self, solution: ContactSolution) -> Stress:
        """Return the stress; see `Response.respond`."""
        scale = float(solution.pressure.max())
        if not (math.isfinite(scale) and scale > 0.0):
            raise InputError(
                "The contact carries no load, or its pressure is not finite: there is no stress to compute."
            )
        problem = problem_of(solution)
        material = getattr(problem, self.body).material
        layers = self._find_layers(solution, problem)
        poisson = getattr(material, "poisson", None)
        if poisson is None or material.compliance == 0.0:
            what = f"The material of the {self.body}, {type(material).__name__}, has"
            other = "counterbody" if self.body == "body" else "body"
            raise InputError(
                f"{what} no stress below its surface: ask for body='{other}', or give it a Poisson's ratio."
            )
        kernel = HalfSpaceStress(float(poisson)) if layers is None else layers
        traction = self._find_traction(solution)
        depths = self.depths
        if depths is None:
            depths = default_depths(solution)
            depths = depths if traction is None else np.concatenate(([0.0], depths))
            if self.residual is not None:
                depths = np.union1d(depths, self.residual.depth[self.residual.depth > 0.0])
            depths = with_interfaces(depths, kernel.interfaces, kernel.base_depth)
        base = kernel.base_depth
        if float(depths.max()) > base:
            raise InputError.about("A depth", float(depths.max()), f"at most {si(base, 'm')}, down to the rigid base")
        deepest = _MAX_DEPTH_SIDES * max(solution.grid.resolved.size)
        if float(depths.max()) > deepest:
            allowed = f"at most {si(deepest, 'm')}, {_MAX_DEPTH_SIDES:g} times the side of the domain"
            raise InputError.about("A depth", float(depths.max()), allowed, "Depths are in metres.")
        threads = problem.plan.thread_choice[0]
        rest = self.residual
        return Stress(
            solution, depths, float(poisson), traction, residual=rest, threads=threads, kernel=kernel, asked=self
        )

    def _find_layers(self, solution: ContactSolution, problem: ContactProblem) -> SupportsStress | None:
        """Return the kernel if its layers lie on the chosen body, None if this body is a homogeneous half-space."""
        part = problem.plan.kernel.part_of(self.body)
        kernel = problem.plan.kernel if part is None else part
        if not isinstance(kernel, SupportsStress):
            if isinstance(part, Love) or solution.moduli is None:
                return None
            raise InputError(
                "The stress below the surface is known for homogeneous half-spaces and for kernels that state it, but "
                f"this kernel is of a layer: choose {argument('kernel', 'love')}."
            )
        names = ("body", "counterbody") if part is None else (self.body,)
        coated = next((name for name in names if kernel.describes(getattr(problem, name).material)), None)
        if coated is None:
            where = " or of the ".join(names)
            raise InputError(f"The layers lie on another material than that of the {where}: give both the same one.")
        return kernel if coated == self.body else None

    def _find_traction(self, solution: ContactSolution) -> Array | None:
        """Return the traction on the chosen body, shape (2, nx, ny), Pa."""
        traction = self.traction
        if self.friction is not None:
            traction = sliding_traction(solution, self.friction, self.direction)
        if traction is None:
            return None
        shape = (2, *solution.grid.shape)
        if traction.shape != shape:
            raise InputError.about("The shape of the traction", traction.shape, f"{shape}, along x and y")
        if not np.abs(traction).max() <= MAX_LOAD_RATIO * solution.pressure.max():
            allowed = f"finite, at most {MAX_LOAD_RATIO:g} times the maximum pressure"
            raise InputError.about("The traction", float(np.abs(traction).max()), allowed, "Tractions are in pascals.")
        return traction if self.body == "body" else -traction
