"""The solution of a contact with friction: tractions, stick and slip, and their certificate."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import attrs
import numpy as np

from roughcontact._base import checks
from roughcontact._base.arrays import Array, Mask, Pair, read_only
from roughcontact._base.tables import Result
from roughcontact._base.units import Estimate, ShownAsPrinted, si
from roughcontact._parts.grid import Boundary, Grid, extend
from roughcontact._parts.interactions import FrictionLaw, shear_limit
from roughcontact._parts.materials import PairConstants
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.frictional_files import read_frictional, write_frictional
from roughcontact._solve.solution.frictional_state import FrictionalResiduals, FrictionalState, TangentialLoad
from roughcontact._solve.solution.results import Response, Status, list_fields, require_with_friction, responses
from roughcontact._solve.solution.writers import describe_as_data
from roughcontact.errors import InputError
from roughcontact.errors.warning import AskedOf

if TYPE_CHECKING:
    from roughcontact.responses import Stress

T = TypeVar("T")
# Traction over the shear strength from which a cell counts as slipping: it moves the edge of the stick zone by less
# than a cell, as the uncertainty of its area does.
_SLIPPING_FRACTION = 1.0 - 1e-3
# Relative standard deviation of the displacement of a contact of one cell's radius, which falls as the square of the
# radius: measured on balls of 3 to 24 cells at random places against Cattaneo and Mindlin, and on rough contacts
# against finer grids. And of the energy lost in slip that is one cell wide, which falls as the square of the width: set
# on 180 steps of balls and rough surfaces against cells of a quarter. Both are means over x and y.
_DISPLACEMENT_ERROR = 0.1
_ENERGY_ERROR = 0.06
# Relative standard deviation of the displacement of a contact of one cell's radius whose edge sticks, which falls as
# the radius; and the part of the edge that slip one cell wide frees. Set on 50 balls of 3.5 to 16 cells with cells of
# 1:1 to 8:1 under 1e-6 to .9 of the force of sliding.
_STUCK_ERROR = 0.07
_RESOLVED_SLIP = 0.5
# Area that slips of a ball under a small tangential force, over that of its contact and the force over that of sliding:
# its stick zone is (1 - Q / mu P)^(2/3) of the contact (Cattaneo, Mindlin).
_SLIP_OF_BALL = 2.0 / 3.0
# Component of the tangential force over the force that is printed as zero.
_ROUNDING = 1e-12


@attrs.frozen(eq=False, kw_only=True)
class FrictionalSolution(Result, ShownAsPrinted, AskedOf):
    """A contact with friction at the end of one step of a path, or in steady sliding.

    All signs are those of the traction on the body: the counterbody is pushed over the body along the tangential
    force, and moves by the displacement; slip is that of the counterbody's surface relative to the body's.

    Attributes
    ----------
    contact
        The normal contact, on the initial gap changed by the traction: of like bodies, that without friction.
    shear
        Traction on the body, shape (2, nx, ny), Pa.
    displacement
        Displacement (x, y) of the counterbody relative to the body since the first touch, far from the contact, m: on
        a periodic boundary what the contact adds. In steady sliding it is not determined, and nan.
    slip
        Slip in this step, shape (2, nx, ny), m, of cells that do not touch too; in steady sliding per distance.
    friction
        The friction law.
    given
        The tangential load.
    pair
        The pair of materials.
    before
        The state at the begin of the last increment of the step.
    dissipated
        Energy that friction has lost in this step, J; in steady sliding per distance, J/m. Its uncertainty is that of
        the increments and of the cells.
    elastic_energy
        Energy stored in both bodies, J.
    residuals
        The certificate.
    status, passes, iterations, increments, seconds
        End of the solve, and its cost: alternations of normal and tangential solves, iterations of the tangential
        ones, increments of the step, wall time in s.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> flat = rc.Body(rc.FlatSurface(), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, flat, grid=rc.Grid((32, 32), 100e-6))
    >>> path = problem.path(force=1.0, tangential_force=[(0.15, 0.0)], friction=0.3)
    >>> isinstance(path[0], rc.FrictionalSolution)
    True
    >>> print(f"{100 * path[0].stick_area.value / path[0].contact.area().value:.0f} % of the contact sticks")
    68 % of the contact sticks
    """

    contact: ContactSolution
    shear: Array = attrs.field(converter=read_only)
    displacement: Pair
    slip: Array = attrs.field(converter=read_only)
    friction: FrictionLaw
    given: TangentialLoad
    pair: PairConstants
    before: FrictionalState
    dissipated: Estimate
    elastic_energy: float
    residuals: FrictionalResiduals
    status: Status
    passes: int
    iterations: int
    increments: int = 1
    seconds: float = 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the normal contact must not be trusted, in sentences; empty without a reason."""
        return self.contact.warnings

    @property
    def grid(self) -> Grid:
        """The cells."""
        return self.contact.grid

    @property
    def boundary(self) -> Boundary:
        """What lies beyond the border."""
        return self.contact.boundary

    @property
    def pressure(self) -> Array:
        """Contact pressure, shape (nx, ny), Pa."""
        return self.contact.pressure

    @property
    def force(self) -> float:
        """Normal force, N."""
        return self.contact.force

    @property
    def approach(self) -> float:
        """Approach of the bodies since first touch, m."""
        return self.contact.approach

    @property
    def tangential_force(self) -> Pair:
        """Force (x, y) by which the counterbody is pushed over the body, N."""
        x, y = (float(part.sum()) * self.grid.cell_area for part in self.shear)
        return x, y

    @cached_property
    def limit(self) -> Array:
        """Shear strength of each cell by the friction law, shape (nx, ny), Pa."""
        return read_only(shear_limit(self.friction, self.pressure))

    @cached_property
    def stick(self) -> Mask:
        """Cells in contact that stick, whose traction is below 99.9 % of the strength, shape (nx, ny)."""
        size = np.hypot(*self.shear)
        return read_only(self.contact.contact & (size < _SLIPPING_FRACTION * self.limit))

    @property
    def slipping(self) -> Mask:
        """Cells in contact that slip, shape (nx, ny)."""
        return read_only(self.contact.contact & ~self.stick)

    @property
    def stick_area(self) -> Estimate:
        """Area that sticks, m2: its uncertainty is half a ring of cells along the edge between stick and slip.

        Where the edge of the contact sticks it is that of the real contact area, and of slip that no cell sees.
        """
        return self._stick_area

    @cached_property
    def _stick_area(self) -> Estimate:
        edges = sum(int(np.count_nonzero(np.diff(self.stick, axis=axis) & self._both_touch(axis))) for axis in (0, 1))
        area = self.contact.area()
        part, correction = self._stick_of_edge
        value = max(int(np.count_nonzero(self.stick)) * self.grid.cell_area + part * correction, 0.0)
        rings = 0.5 * edges * self.grid.cell_area
        return Estimate(value, math.hypot(rings, part * area.uncertainty, self._find_hidden_slip()), "m2")

    def _find_hidden_slip(self) -> float:
        """Return the area of slip that is narrower than half a cell along an edge that sticks, m2."""
        half_ring = 0.5 * self._sides[1] * math.sqrt(self.grid.cell_area)
        strength = float(self.limit.sum())
        if strength == 0.0:
            return 0.0
        part = float(np.hypot(*self.shear.sum(axis=(1, 2)))) / strength
        return min(half_ring, _SLIP_OF_BALL * part * self._stick_of_edge[0] * self.contact.area().value)

    @property
    def slip_area(self) -> Estimate:
        """Area that slips, m2: the real contact area less that which sticks, with the uncertainties of both."""
        area = self.contact.area()
        part, correction = self._stick_of_edge
        value = int(np.count_nonzero(self.slipping)) * self.grid.cell_area + (1.0 - part) * correction
        uncertainty = math.hypot(self.stick_area.uncertainty, area.uncertainty)
        return Estimate(max(value, 0.0), uncertainty, "m2", area.warnings)

    @cached_property
    def _stick_of_edge(self) -> Pair:
        """The part of the edge of the contact that sticks, and the contact area beyond that of its cells, m2."""
        whole, sticking = self._sides
        cells = int(np.count_nonzero(self.contact.contact)) * self.grid.cell_area
        return sticking / whole if whole else 0.0, self.contact.area().value - cells

    @cached_property
    def _sides(self) -> Pair:
        """Length of the sides of cells along the edge of the contact, m, and of those whose cell sticks."""
        masks = [extend(mask, 1, self.boundary) for mask in (self.contact.contact, self.stick)]
        whole = 0.0
        sticking = 0.0
        for axis, side in enumerate(self.grid.spacing[::-1]):
            edge, held = (np.diff(np.moveaxis(mask, axis, 0)[:, 1:-1], axis=0) for mask in masks)
            whole += int(np.count_nonzero(edge)) * side
            sticking += int(np.count_nonzero(edge & held)) * side
        return whole, sticking

    def _both_touch(self, axis: int) -> Mask:
        touching = np.moveaxis(self.contact.contact, axis, 0)
        return np.moveaxis(touching[1:] & touching[:-1], 0, axis)

    @cached_property
    def cell_errors(self) -> Pair:
        """Relative standard deviations of the displacement and of the energy lost, by the size of the cells."""
        if not self._edge_length:
            return 0.0, 0.0
        spacing = np.array(self.grid.spacing)
        radius = 2.0 * int(np.count_nonzero(self.contact.contact)) * self.grid.cell_area / self._edge_length / spacing
        width = np.maximum(find_slip_width(self), self.grid.cell_area / self._edge_length / spacing)
        # An edge that sticks in part of its cells, because slip has not reached across them.
        stuck = np.maximum(1.0 - _RESOLVED_SLIP * width, 0.0)
        displacement = math.hypot(
            _DISPLACEMENT_ERROR * float(np.mean(radius**-2)), _STUCK_ERROR * float(np.mean(stuck / radius))
        )
        return min(displacement, 1.0), _ENERGY_ERROR * float(np.mean(width**-2))

    @property
    def _edge_length(self) -> float:
        """Length of the edge of the contact, m: of a disc the sides of its cells are longer. Zero without one."""
        return 0.25 * math.pi * self._sides[0]

    @property
    def is_steady(self) -> bool:
        """Whether the bodies slide steadily."""
        return self.given.kind == "direction"

    @property
    def state(self) -> FrictionalState:
        """What the next step of a path knows of this one."""
        return FrictionalState(
            pressure=self.pressure, shear=self.shear, displacement=self.displacement, approach=self.approach
        )

    def response(self, response: str | Response[T]) -> T:
        """Return a quantity of the contact, or its response to a small change, a current or a flow.

        A response with a field ``traction``, such as the stress, is that under pressure and traction; others are those
        of the normal contact.

        Parameters
        ----------
        response
            Registered name or instance of a response; see `ContactSolution.response`.

        Raises
        ------
        InputError
            If it means nothing for a contact with friction, or states a traction or a friction of its own.
        """
        asked: Any = responses.resolve(response)
        require_with_friction(asked)
        if "traction" in list_fields(asked):
            own = [name for name in ("traction", "friction") if getattr(asked, name, None) is not None]
            if own:
                raise InputError(f"The state has its own traction: omit {own[0]}= of the response.")
            asked = attrs.evolve(asked, traction=self.shear)
        found: T = self.contact.response(asked)
        return found

    def stress(self, depths: float | Array | Sequence[float] | None = None, body: str = "body") -> Stress:
        """Return the stress below a surface under pressure and traction; see `ContactSolution.stress`.

        Parameters
        ----------
        depths
            Depths below the surface, m, shape (n,); None: from half a cell to two radii of the largest patch.
        body
            ``"body"`` or ``"counterbody"``.

        Raises
        ------
        InputError
            If the body has no stress: it is rigid or layered.
        """
        found: Stress = self.response(responses.create("stress", depths, body=body))
        return found

    def verify(self) -> None:
        """Recompute the certificate from tractions, displacement and the state before.

        Raises
        ------
        InputError
            If they contradict each other or the problem, as after the friction cone was kept from another pressure.
        """
        origin = self.contact.origin
        if origin is None or origin.source is None:
            raise InputError("The solution does not hold its problem: call problem.verify(solution).")
        origin.source.verify(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file ``.npz``, completely or not at all; an existing file is replaced.

        It holds both states, so that `load` verifies it alone; the state before is named by its digest too, so that
        the steps of a path can be put in a row.
        """
        write_frictional(checks.path(path, "The file"), self)

    def to_dict(self) -> dict[str, Any]:
        """Return answers, certificate and inputs as plain data; see `ContactSolution.to_dict`."""
        return describe_as_data(self)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> FrictionalSolution:
        """Return the solution in a file that `save` has written.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute the certificate. False takes it from the file.

        Raises
        ------
        InputError
            If there is no such file, it is damaged or of another kind, or its content contradicts itself.
        """
        return read_frictional(checks.path(path, "The file"), cls, verify=checks.flag(verify, "verify="))

    def __str__(self) -> str:
        rows = {**list_state(self), "status": str(self.status), "residuals": str(self.residuals)}
        return "\n".join(f"{name:18} {value}" for name, value in rows.items())

    def __repr__(self) -> str:
        return f"<FrictionalSolution {self.grid}, force {si(self.force, 'N')}, {self.status.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # Arrays in pickles and deep copies are writable: the constructor makes them read-only again.
        return _restore, (attrs.asdict(self, recurse=False),)


def find_slip_width(state: FrictionalSolution) -> Array:
    """Return the mean width of the slip along the edge of the contact in cells along x and y, shape (2,)."""
    area = int(np.count_nonzero(state.slipping)) * state.grid.cell_area
    return area / max(state._edge_length, math.sqrt(state.grid.cell_area)) / np.array(state.grid.spacing)


def list_state(state: FrictionalSolution) -> dict[str, str]:
    """Return the forces, displacement, areas and energy of a state in words, by their names."""
    moved = " and ".join(si(value, "m", 5) for value in state.displacement)
    largest = max(abs(value) for value in state.tangential_force)
    pushed = " and ".join(
        si(value, "N", 5) if abs(value) > _ROUNDING * largest else "0 N" for value in state.tangential_force
    )
    areas = (
        f"{si(one.value, 'm2', 5)} +- {si(one.uncertainty, 'm2', 2)}" for one in (state.stick_area, state.slip_area)
    )
    return {
        "normal force": si(state.force, "N", 6),
        "tangential force": f"{pushed} (x, y)",
        "displacement": "steady sliding" if state.is_steady else f"{moved} (x, y)",
        "contact area": str(state.contact.area()),
        **dict(zip(("area that sticks", "area that slips"), areas, strict=True)),
        "energy lost": str(state.dissipated),
    }


def _restore(fields: dict[str, Any]) -> FrictionalSolution:
    return FrictionalSolution(**fields)
