"""The plan of a solve: its parts, time and memory, and the omitted steps with their reasons."""

from __future__ import annotations

import contextlib
import functools
import math
import time
from functools import cached_property
from typing import Any

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, Mask, frozen_array
from roughcontact._base.checks import number
from roughcontact._base.machine import available_memory, choose_threads
from roughcontact._base.registry import name_in_words
from roughcontact._base.units import PlainText, binary, outlined, si
from roughcontact._parts.grid import FIRST_LOADING, Boundary, Grid
from roughcontact._parts.interactions import Interaction
from roughcontact._parts.kernels import InfluenceKernel, kernels
from roughcontact._parts.materials import (
    MAX_UNCOUPLED_BETA,
    Material,
    Rigid,
    Viscoelastic,
    combined_pressure_limit,
    contact_modulus,
    pair_constants,
)
from roughcontact._parts.surfaces import FlatSurface
from roughcontact._solve.convolvers import Convolver, Direct, convolvers
from roughcontact._solve.problem.body import Body, InitialGap
from roughcontact._solve.problem.memory import UNRESTRICTED_ARRAYS, memory_of_solve, require_arrays
from roughcontact._solve.solution import (
    RESOLVED_CELLS,
    Flattening,
    Law,
    Process,
    areas,
    describe_range,
    find_scene,
    responses,
)
from roughcontact._solve.solvers import ProjectedConjugateGradient, Solver, coarser_shape, solvers
from roughcontact.errors import InputError, argument

# The convolver of a package that is chosen where it is installed, and the cells up to which it is the fastest.
_COMPILED_CONVOLVER = "compiled"
_MAX_COMPILED_CELLS = 2**16
_AUTO_SOLVER = "projected-cg"
_ADHESIVE_SOLVER = "gap-descent"
# Time of a solve in transforms there and back on the grid, by the number of free axes; measured on self-affine, wavy
# and spherical surfaces of 128 x 128 to 512 x 512 cells, most of which need less.
_TRANSFORMS_PER_SOLVE = (40.0, 52.0, 64.0)
# Seconds of a solve on the smallest grid, measured on the same surfaces.
_MIN_SOLVE_SECONDS = 0.1
# Cells along a side of the transform that is timed, and its repetitions.
_TIMED_SIDE = 256
_TIMED_REPEATS = 5
# Maximum aspect ratio of the cells; kernels are compared with mpmath up to 1e12 (test_kernels), which leaves room for
# coarser and finer grids.
_MAX_CELL_ASPECT = 1e8
# Maximum length, m, and modulus, Pa, and inverse of the minimum, so that forces, areas and curvatures stay within the
# 1e308 of float64.
_MAX_MAGNITUDE = 1e40
# What the plan of a contact with friction does not omit: how its text begins.
OMITTED_FRICTION = "friction"
_REMEMBERS = ": remembers, so that loads are followed in their order"
_AT_ONCE = "A single load acts at once, on bodies that have not relaxed; problem.path follows loads over time."
# Wave numbers at which the effective modulus is sampled: about 24 per decade on a grid of 1000 cells a side.
_SAMPLED_WAVE_NUMBERS = 96
# Directions over half a turn at which it is sampled: the mean over them for an ellipse of axes 10 : 1 errs by 1e-8.
_SAMPLED_DIRECTIONS = 128
_OMITTED_IMAGES = {
    Boundary.FREE: "images of the domain: the boundary is free",
    Boundary.PERIODIC: "padding: the domain repeats, every image counts",
    Boundary.FREE_PERIODIC: "padding along y, where every image counts; images along x, where the boundary is free",
    Boundary.PERIODIC_FREE: "padding along x, where every image counts; images along y, where the boundary is free",
    Boundary.WRAPPED: "padding and all but the nearest images: the boundary is wrapped",
}


def forecast_seconds(cells: int, boundary: Boundary) -> float:
    """Return about how long one solve takes on this machine, s: likely within a factor of three."""
    return _MIN_SOLVE_SECONDS + _TRANSFORMS_PER_SOLVE[
        sum(boundary.free_axes)
    ] * _time_of_transform() * cells * math.log(max(cells, 2))


@functools.cache
def _time_of_transform() -> float:
    """Return the time of a transform there and back over n log n, s, measured here and now."""
    values = np.random.default_rng(0).random((_TIMED_SIDE, _TIMED_SIDE))
    times = []
    for _ in range(_TIMED_REPEATS):
        started = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(values), s=values.shape)
        times.append(time.perf_counter() - started)
    return min(times) / (values.size * math.log(values.size))


@functools.lru_cache
def _sample_lengths(shortest: float, longest: float) -> Array:
    """Return the inverse wave numbers at which moduli are sampled, read-only; the contacts of a study have the same."""
    return frozen_array(np.geomspace(shortest, longest, _SAMPLED_WAVE_NUMBERS))


@attrs.frozen(eq=False, kw_only=True)
class SolvePlan:
    """The parts of a solve, and the omitted steps with their reasons; its `str` is the text of ``explain()``.

    Attributes
    ----------
    grid, boundary, kernel, convolver, solver
        The parts that will run.
    materials
        Those of the two bodies.
    modulus
        Contact modulus E*, Pa.
    initial_gap
        Gap before deformation, shape (nx, ny), m.
    peak_to_valley
        Maximum of the initial gap, m.
    pressure_limit
        Maximum pressure, shape () or (nx, ny), Pa; `inf` where there is none.
    omitted
        Omitted steps, with the reasons.
    non_measured
        Points that were not measured, shape (nx, ny); None if there are none.
    histories
        Preparation of the heights of each body, in words.
    threads
        The given number of threads, or ``"auto"``.
    memory_limit
        The memory that a solve may take, bytes; None: the memory of the machine.
    interaction
        The law by which the surfaces attract each other, resolved for the grid; None without adhesion.
    chosen_range
        Whether its range is chosen by the cells.
    laws
        What else changes the contact.
    """

    grid: Grid
    boundary: Boundary
    kernel: InfluenceKernel
    convolver: Convolver
    solver: Solver
    materials: tuple[Material, Material]
    modulus: float
    initial_gap: Array
    peak_to_valley: float
    pressure_limit: Array
    omitted: tuple[str, ...]
    non_measured: Mask | None
    histories: tuple[tuple[str, ...], tuple[str, ...]]
    threads: int | str = "auto"
    memory_limit: int | None = None
    interaction: Interaction | None = None
    chosen_range: bool = False
    laws: tuple[Law, ...] = ()

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Likely mistakes in the problem, in sentences."""
        findings = find_scene(self.initial_gap, self.grid, self.boundary, self.materials)
        texts = [finding.warning for finding in findings if finding.warning]
        if self.interaction is not None and not self.chosen_range:
            texts.append(describe_range(self.interaction, self.grid, self.surface_modulus) or "")
        return tuple(filter(None, texts))

    @property
    def surface_modulus(self) -> float:
        """Contact modulus of the shortest waves, Pa: that of a layer on the body where the cells are finer than it."""
        return find_surface_modulus(self.kernel, self.grid, self.modulus)

    @cached_property
    def sampled_moduli(self) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """Inverse wave numbers, from a tenth of a cell to the domain, m, and the effective modulus at each, Pa."""
        grid = self.grid.resolved
        lengths = _sample_lengths(0.1 * min(grid.spacing), max(grid.size))
        return self._require_moduli(lengths, self.kernel.effective_modulus(1.0 / lengths, 1.0 / self.modulus))

    @cached_property
    def sampled_directions(self) -> tuple[float, ...] | None:
        """The modulus of waves at equal angles from the x axis over half a turn, Pa."""
        angles = np.linspace(0.0, np.pi, _SAMPLED_DIRECTIONS, endpoint=False)
        found = self._require_moduli(angles, self.kernel.directional_modulus(angles, 1.0 / self.modulus))
        return None if found is None else found[1]

    def _require_moduli(
        self, places: Array, moduli: Array | None
    ) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """Return places and the moduli that the kernel has there, which must be above zero; None without any."""
        if moduli is None:
            return None
        if moduli.shape != places.shape or not (np.isfinite(moduli).all() and moduli.min() > 0.0):
            raise InputError(f"The kernel {self.kernel!r} must return moduli above zero, of shape {places.shape}.")
        return tuple(places.tolist()), tuple(moduli.tolist())

    @property
    def transform_shape(self) -> tuple[int, int]:
        """Cells on which the convolver works, padding included."""
        return self.convolver.transform_shape(self.grid, self.boundary)

    @property
    def thread_choice(self) -> tuple[int, str]:
        """How many threads a solve takes here and now, and why."""
        return choose_threads(self.threads, self.grid.cells)

    @property
    def seconds(self) -> float:
        """About how long one solve takes here, s, from a transform timed now: likely within a factor of three."""
        return forecast_seconds(self.grid.cells, self.boundary)

    @property
    def memory(self) -> int:
        """Peak memory of a solve with all cells in contact, beyond the problem itself, bytes."""
        return self.memory_at(1.0)

    def memory_at(self, contact_fraction: float) -> int:
        """Return the peak memory of a solve, beyond the problem itself, bytes.

        Parameters
        ----------
        contact_fraction
            Fraction of the cells that are in contact below the pressure limit, 0 to 1.
        """
        contact_fraction = number(contact_fraction, "The contact fraction", at_least=0.0, at_most=1.0)
        own = self.solver.memory_arrays(self.boundary)
        if own is not None:
            return int(8 * self.grid.cells * own)
        memory = memory_of_solve(self.grid, self.boundary, contact_fraction)
        restricted = isinstance(self.solver, ProjectedConjugateGradient) and not isinstance(self.convolver, Direct)
        return memory if restricted else max(memory, int(8 * self.grid.cells * UNRESTRICTED_ARRAYS))

    def require_memory(self) -> None:
        """Refuse a problem of which a solve does not fit into memory, even at light contact."""
        require_arrays(self.memory_at(0.0), "A solve", self.grid, self.boundary, self.memory_limit)

    def __str__(self) -> str:
        nx, ny = self.transform_shape
        histories = [(f"heights {number}", "; ".join(steps)) for number, steps in enumerate(self.histories, 1) if steps]
        rows = [
            ("grid", f"{self.grid}, boundary {self.boundary}"),
            *self._describe_coarse_grids(),
            *self._describe_non_measured(),
            (
                "bodies",
                f"contact modulus {si(self.modulus, 'Pa')}, peak to valley {si(self.peak_to_valley, 'm')}, "
                f"pressure limit {_format_range(self.pressure_limit)}",
            ),
            *histories,
            *self._describe_adhesion(),
            *(("law", f"{law!r}{_REMEMBERS if isinstance(law, Process) else ''}") for law in self.laws),
            ("kernel", name_in_words(self.kernel)),
            ("convolver", f"{name_in_words(self.convolver)} on {nx} x {ny} cells"),
            ("solver", name_in_words(self.solver)),
            ("precision", "fields and residuals in double precision, whatever the solver uses inside"),
            ("threads", "{}: {}".format(*self.thread_choice)),
            ("memory", self._format_memory()),
            *self._list_heavy_answers(),
            *self._describe_loads(),
            *(("omitted", text) for text in self.omitted),
            *(("warning", text) for text in self.warnings),
        ]
        return PlainText("\n".join(f"{label:<10} {text}" for label, text in rows))

    def __repr__(self) -> str:
        return str(self)

    def _describe_loads(self) -> list[tuple[str, str]]:
        forgets = not any(isinstance(law, Flattening) for law in self.laws)
        found = [("loads", FIRST_LOADING)] if np.isfinite(self.pressure_limit).any() and forgets else []
        relaxing = any(isinstance(material, Viscoelastic) for material in self.materials)
        relaxing = relaxing and all(law.keeps_modulus for law in self.laws)
        return [*found, ("loads", _AT_ONCE)] if relaxing else found

    def _describe_coarse_grids(self) -> list[tuple[str, str]]:
        if not self.solver.climbs_grids:
            return []
        shapes = [self.grid.shape]
        while (coarser := coarser_shape(shapes[0])) != shapes[0]:
            shapes.insert(0, coarser)
        if len(shapes) == 1:
            return []
        ladder = ", ".join(f"{nx} x {ny}" for nx, ny in shapes)
        part = ", or on the part that can touch" if self.boundary.has_free_axis else ""
        return [("solved on", f"{ladder} cells{part}: each grid starts from the coarser one, unless a start is given")]

    def _describe_non_measured(self) -> list[tuple[str, str]]:
        if self.non_measured is None:
            return []
        found = f"{int(np.count_nonzero(self.non_measured))} of {self.grid.cells} points were not measured"
        return [("points", f"{found}: they carry nothing, and answers continue the gap of their neighbours there")]

    def _describe_adhesion(self) -> list[tuple[str, str]]:
        law = self.interaction
        if law is None:
            return []
        cells = law.cohesive_cells(self.grid.resolved.spacing, self.surface_modulus)
        strength = si(float(np.max(law.strength)), "Pa")
        resolved = f"cohesive length {cells:.3g} cells ({RESOLVED_CELLS:g} are enough)"
        return [
            ("adhesion", f"{_name_law(law)}: strength {strength}, {resolved}"),
            ("branch", "loading, from the contact without adhesion, unless asked: other stable states may exist"),
        ]

    def _format_memory(self) -> str:
        light, full = (
            f"{size / 2**20:.3g} MiB ({size / (8 * self.grid.cells):.3g} arrays of the grid)"
            for size in (self.memory_at(0.0), self.memory)
        )
        text = f"{light} at light contact, at most {full}"
        limit = self.memory_limit if self.memory_limit is not None else available_memory()
        if limit is None or self.memory <= limit:
            return text
        fits = max((k for k in range(101) if self.memory_at(0.01 * k) <= limit), default=0)
        return f"{text}; the {binary(limit)} there are suffice for up to {fits} % of the cells in contact"

    def _list_heavy_answers(self) -> list[tuple[str, str]]:
        """Return the row of the answers that take more memory than a solve; none without any."""
        array = 8 * self.grid.cells
        heavy = {name: responses[name].memory_arrays for name in responses if name not in areas}
        texts = [
            f"{name} {binary(count * array)} ({count:g} arrays)"
            for name, count in sorted(heavy.items(), key=lambda one: -one[1])
            if count * array > self.memory
        ]
        return [("answers", f"more memory than the solve take {', '.join(texts)}")] if texts else []


def make_plan(
    body: Body,
    counterbody: Body,
    gap: InitialGap,
    *,
    grid: Grid,
    boundary: Boundary,
    kernel: str | InfluenceKernel,
    convolver: str | Convolver,
    solver: str | Solver,
    threads: int | str = "auto",
    memory_limit: int | None = None,
    adhesion: Interaction | None = None,
    laws: tuple[Law, ...] = (),
) -> SolvePlan:
    """Return the plan of a problem; `InputError` unless its parts fit together."""
    kernel = kernels.resolve(kernel)
    convolver = choose_convolver(grid, boundary) if convolver == "auto" else convolvers.resolve(convolver)
    preferred = _AUTO_SOLVER if adhesion is None else _ADHESIVE_SOLVER
    solver = solvers.resolve(preferred if solver == "auto" else solver)
    convolver.require(kernel, boundary)
    short, long = sorted(grid.spacing)
    if not long <= _MAX_CELL_ASPECT * short:
        raise InputError.about(
            "The cells of the grid", grid.spacing, f"at most {_MAX_CELL_ASPECT:g} times as long as wide"
        )
    peak_to_valley = float(gap.values.max())
    if peak_to_valley == 0.0:
        raise InputError("Both surfaces are flat, so the pressure is uniform: give at least one of them heights.")
    modulus = contact_modulus(body.material, counterbody.material)
    _require_range(modulus, "Pa", "contact modulus")
    _require_range(peak_to_valley, "m", "peak-to-valley height")
    for side in grid.spacing:
        _require_range(side, "m", "side of the cells")
    limit = combined_pressure_limit(body.material, counterbody.material)
    if limit.shape not in ((), grid.shape):
        raise InputError(f"The pressure limit is an array of shape {limit.shape}, but the grid has {grid.shape} cells.")
    capped = bool(np.isfinite(limit).any())
    solver.require(capped=capped)
    interaction = None
    if adhesion is not None:
        interaction = _resolve_interaction(adhesion, grid, find_surface_modulus(kernel, grid, modulus), solver)
    plan = SolvePlan(
        grid=grid,
        boundary=boundary,
        kernel=kernel,
        convolver=convolver,
        solver=solver,
        materials=(body.material, counterbody.material),
        modulus=modulus,
        initial_gap=gap.values,
        peak_to_valley=peak_to_valley,
        pressure_limit=limit,
        omitted=(
            *_list_omitted((body, counterbody), boundary, capped=capped, adhesive=interaction is not None),
            *solver.omitted,
            *_list_borders(solver, boundary),
        ),
        non_measured=gap.non_measured,
        histories=(body.provenance, counterbody.provenance),
        threads=threads,
        memory_limit=memory_limit,
        interaction=interaction,
        chosen_range=interaction is not adhesion,
        laws=laws,
    )
    plan.require_memory()
    return plan


def choose_convolver(grid: Grid, boundary: Boundary) -> Convolver:
    """Return the convolver that is the fastest on a grid: compiled, where one is installed and can be loaded."""
    if grid.cells <= _MAX_COMPILED_CELLS and _COMPILED_CONVOLVER in convolvers:
        with contextlib.suppress(InputError):
            compiled = convolvers.create(_COMPILED_CONVOLVER)
            if boundary in compiled.boundaries:
                return compiled
    return convolvers.create("dc-fft" if boundary.has_free_axis else "circular-fft")


def find_surface_modulus(kernel: InfluenceKernel, grid: Grid, modulus: float) -> float:
    """Return the contact modulus of the shortest waves on a grid, Pa; see `SolvePlan.surface_modulus`."""
    found = kernel.effective_modulus(np.array([1.0 / max(grid.resolved.spacing)]), 1.0 / modulus)
    return modulus if found is None else float(found[0])


def _resolve_interaction(adhesion: Interaction, grid: Grid, modulus: float, solver: Solver) -> Interaction:
    """Return the law for the grid, after a check that the solver and the grid fit it."""
    if not solver.adhesive:
        raise InputError(
            f"The solver {solver!r} knows no tension: with adhesion choose {argument('solver', 'auto')} or 'majorise'."
        )
    law = adhesion.resolve(grid.resolved.spacing, modulus)
    kind: Any = type(law)
    for field in attrs.fields(kind) if attrs.has(kind) else ():
        shape = np.shape(getattr(law, field.name))
        if len(shape) > 1 and shape != grid.shape:
            raise InputError(
                f"The {field.alias} of the adhesion is an array of shape {shape}, but the grid has {grid.shape} cells."
            )
    return law


def _name_law(law: Interaction) -> str:
    kind: Any = type(law)
    fields = attrs.fields(kind) if attrs.has(kind) else ()
    texts = []
    for field in fields:
        value = getattr(law, field.name)
        unit = field.metadata.get("unit", "")
        texts.append(f"{field.alias}={outlined(value) if np.ndim(value) else si(value, unit) if unit else value}")
    return f"{type(law).__name__}({', '.join(texts)})"


def _require_range(value: float, unit: str, name: str) -> None:
    if not 1.0 / _MAX_MAGNITUDE < value < _MAX_MAGNITUDE:
        raise InputError(f"A {name} of {value:g} {unit} leaves the range of double precision: check the units.")


def _list_omitted(bodies: tuple[Body, Body], boundary: Boundary, *, capped: bool, adhesive: bool) -> list[str]:
    """Return the steps that this problem does not need, with the reasons."""
    texts = [_OMITTED_IMAGES[boundary]]
    if not capped:
        texts.append("pressure limit: neither material has one")
    beta = _find_coupling(bodies)
    if beta > MAX_UNCOUPLED_BETA:
        texts.append(
            f"{OMITTED_FRICTION}, which would change the pressure between these unlike bodies, "
            f"Dundurs' beta = {beta:.2g}"
        )
    texts.append("the repulsive part of the law: the wall is hard" if adhesive else "adhesion: none is given")
    if boundary is Boundary.PERIODIC:
        texts.append("kernel in real space: its spectrum is used")
    for body in bodies:
        if isinstance(body.material, Rigid):
            texts.append("deformation of one body: it is rigid")
        if isinstance(body.surface, FlatSurface):
            texts.append("heights of one body: it is flat")
    return texts


def _find_coupling(bodies: tuple[Body, Body]) -> float:
    """Return the magnitude of Dundurs' second constant; zero where Poisson's ratio of a material is not known."""
    try:
        return abs(pair_constants(*(body.material for body in bodies)).beta)
    except InputError:
        return 0.0


def _list_borders(solver: Solver, boundary: Boundary) -> list[str]:
    if not boundary.has_free_axis or not isinstance(solver, ProjectedConjugateGradient):
        return []
    return ["the borders of the domain where they cannot touch: the solver works on the part between them"]


def _format_range(limit: Array) -> str:
    low = float(limit.min())
    high = float(limit.max())
    if math.isinf(low):
        return "none"
    return si(low, "Pa") if low == high else f"{si(low, 'Pa')} to {si(high, 'Pa')}"
