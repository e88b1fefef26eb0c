"""The scene of a contact: two bodies, a grid and the parts that solve it, and what is prepared from them."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import MAX_MAGNITUDE, instance_of, numbers
from roughcontact._base.machine import limit_of_memory, thread_count
from roughcontact._base.units import Force, Length, Pressure, WorkText
from roughcontact._parts.grid import Boundary, Grid, Load, as_boundary
from roughcontact._parts.interactions import Interaction
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._solve.convolvers import Convolver, PreparedConvolution, ShearConvolution
from roughcontact._solve.problem.body import RIGID_FLAT, Body, InitialGap, find_initial_gap
from roughcontact._solve.problem.memory import require_memory_of_solve
from roughcontact._solve.problem.plan import SolvePlan, choose_convolver, make_plan
from roughcontact._solve.problem.task import prepare_convolution, prepare_shear, pressure_unit
from roughcontact._solve.solution import Law, Process, as_laws, join_laws
from roughcontact._solve.solvers import Solver
from roughcontact.errors import InputError

# Arguments for the machine: they change no bit of a solution, and are not part of its problem.
_MACHINE_ARGUMENTS = ("threads", "memory_limit")

_is_body = instance_of(Body, "Each side of a contact", "a Body(surface, material)")
_is_interaction = attrs.validators.optional(
    instance_of(Interaction, "The adhesion", "an Interaction such as Exponential(work=0.05, range=2e-9)")
)
_is_grid = attrs.validators.optional(instance_of(Grid, "The grid", "a Grid(shape, size)"))


@attrs.frozen(eq=False)
class Scene:
    """The parts of a contact problem, which do not change, and what is prepared from them: see `ContactProblem`."""

    body: Body = attrs.field(validator=_is_body)
    counterbody: Body = attrs.field(default=RIGID_FLAT, validator=_is_body)
    grid: Grid | None = attrs.field(default=None, kw_only=True, validator=_is_grid)
    boundary: Boundary = attrs.field(default=Boundary.FREE, converter=as_boundary, kw_only=True)
    kernel: str | InfluenceKernel = attrs.field(default="love", kw_only=True)
    convolver: str | Convolver = attrs.field(default="auto", kw_only=True)
    solver: str | Solver = attrs.field(default="auto", kw_only=True)
    adhesion: Interaction | None = attrs.field(default=None, kw_only=True, validator=_is_interaction)
    laws: tuple[Law, ...] = attrs.field(default=(), converter=as_laws, kw_only=True)
    threads: int | str = attrs.field(default="auto", converter=thread_count, kw_only=True)
    memory_limit: int | None = attrs.field(default=None, converter=limit_of_memory, kw_only=True)

    def __attrs_post_init__(self) -> None:
        brought = self._list_brought_laws()
        object.__setattr__(self, "laws", (*_omit_brought(self.laws, brought), *brought))
        # The plan checks that the parts fit together.
        _ = self.plan

    @cached_property
    def plan(self) -> SolvePlan:
        """The parts of a solve, and its omitted steps."""
        return make_plan(
            self.body,
            self.counterbody,
            self._gap,
            grid=self._grid,
            boundary=self.boundary,
            kernel=self.kernel,
            convolver=self.convolver,
            solver=self.solver,
            threads=self.threads,
            memory_limit=self.memory_limit,
            adhesion=self.adhesion,
            laws=self.laws,
        )

    @cached_property
    def convolution(self) -> PreparedConvolution:
        """The prepared convolution in dimensionless variables: lengths in cells, E* = 1."""
        return prepare_convolution(self.plan)

    @cached_property
    def shear_convolution(self) -> ShearConvolution:
        """The map from tractions to displacements, in the variables of `convolution`; normal contact needs none.

        `InputError` if the boundary or the kernel has none, Poisson's ratio is not known, or it exceeds the memory.
        """
        return prepare_shear(self.plan, self.convolution)

    @property
    def initial_gap(self) -> Array:
        """Gap before deformation when the summits just touch, shape (nx, ny), m, at least zero."""
        return self._gap.values

    @property
    def summit(self) -> float:
        """Maximum of the sum of both heights, m, where the bodies touch first."""
        return self._gap.summit

    @cached_property
    def _gap(self) -> InitialGap:
        # The heights come after the check of the memory.
        require_memory_of_solve(self._grid, self.boundary, self.memory_limit)
        return find_initial_gap(self.body, self.counterbody, self._grid, self.convolver)

    def _find_gap(self, shift: tuple[int, int]) -> InitialGap:
        """Return the gap with the counterbody displaced by cells (x, y), from the first touch there."""
        if shift == (0, 0):
            return self._gap
        return find_initial_gap(self.body, self.counterbody, self._grid, self.convolver, shift)

    @cached_property
    def _grid(self) -> Grid:
        own = (body.own_grid for body in (self.body, self.counterbody))
        grid = self.grid or next((grid for grid in own if grid is not None), None)
        if grid is None:
            raise InputError("The surfaces carry no grid of their own: give grid=Grid(shape, size).")
        return grid

    @property
    def parts(self) -> dict[str, Any]:
        """The arguments that determine its solutions, by name: all but `threads` and `memory_limit`."""
        found = attrs.asdict(self, recurse=False, filter=lambda field, _: field.name not in _MACHINE_ARGUMENTS)
        if self.adhesion is None:
            # Solutions without adhesion are named and saved as they were before there was any.
            del found["adhesion"]
        if not self.laws:
            del found["laws"]
        return found

    def _list_brought_laws(self) -> tuple[Law, ...]:
        sides = {"body": self.body, "counterbody": self.counterbody}
        return join_laws(as_laws([law for side, body in sides.items() for law in body.material.bring_laws(side)]))

    @property
    def chosen(self) -> tuple[type, ...]:
        """The classes of the parts that ``"auto"`` chooses by what is installed, which `parts` does not name."""
        return (type(choose_convolver(self._grid, self.boundary)),) if self.convolver == "auto" else ()

    @property
    def remembers(self) -> bool:
        """Whether a state depends on those before, so that loads are followed in their order."""
        return self.adhesion is not None or bool(self.processes)

    @property
    def processes(self) -> tuple[Process, ...]:
        """The laws that remember."""
        return tuple(law for law in self.laws if isinstance(law, Process))

    def displace(self, pressure: float | Array) -> Array:
        """Return the displacement of both surfaces, positive into the bodies, by a pressure on the gap.

        Parameters
        ----------
        pressure
            Pressure that presses the surfaces apart, a number or of shape (nx, ny), Pa, such as that of a lubricant.

        Returns
        -------
        Array
            Shape (nx, ny), m; on a periodic boundary its mean is zero.
        """
        allowed = f"a number or an array of shape {self.plan.grid.shape}, finite (Pa)"
        given = numbers(pressure, "The pressure", allowed, "Pa")
        if given.shape not in ((), self.plan.grid.shape) or not np.abs(given).max() <= MAX_MAGNITUDE:
            raise InputError.about("The pressure", pressure, allowed)
        unit = pressure_unit(self.plan)
        field = np.broadcast_to(given, self.plan.grid.shape) / unit
        return self.convolution.to_numpy(
            self.convolution.apply(self.convolution.from_numpy(field)) * self.plan.peak_to_valley
        )

    def explain(
        self, *, pressure: Pressure | None = None, force: Force | None = None, approach: Length | None = None
    ) -> WorkText:
        """Return the parts of a solve, and its omitted steps with their reasons, in words.

        The text knows the memory and the time that its laws take beside the contact; see `WorkText`.

        Parameters
        ----------
        pressure, force, approach
            The load of the solve; all None: not known. With it laws may say more of their work, such as `Plastic` of
            `roughcontact-volume`, which solves an elastic contact for it.
        """
        given = {"pressure": pressure, "force": force, "approach": approach}
        load = None
        if any(value is not None for value in given.values()):
            load = (Load.of if self.adhesion is None else Load.signed)(**given)
        rows = [row for law in self.laws for row in law.explain_work(self, load)]
        memory, seconds = (sum((getattr(text, name, 0.0) for _, text in rows), 0.0) for name in ("memory", "seconds"))
        lines = [str(self.plan), *(f"{label:<10} {text}" for label, text in rows)]
        return WorkText("\n".join(lines), memory, seconds)

    def __repr__(self) -> str:
        bodies = " on ".join(type(body.surface).__name__ for body in (self.body, self.counterbody))
        return f"<{type(self).__name__} {self._grid}, {self.boundary}: {bodies}>"


def _omit_brought(laws: tuple[Law, ...], brought: tuple[Law, ...]) -> list[Law]:
    """Return the laws without those of materials, in whose place they are brought anew."""
    for law in laws:
        if law.of_material and type(law) not in map(type, brought):
            raise InputError(f"The law {law!r} is one that a material brings: give a body such a material, or omit it.")
    return [law for law in laws if not law.of_material]
