"""The flow of a liquid through the gap, and its critical throat."""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from roughcontact._answers.areas.cells import find_lost_std
from roughcontact._answers.flow.faces import find_creases
from roughcontact._answers.flow.network import (
    FlowNetwork,
    estimate_uncertainty,
    find_paths,
    make_network,
    solve_network,
)
from roughcontact._base import checks
from roughcontact._base.arrays import Array, Mask, Pair, RealArray, read_only
from roughcontact._base.checks import number
from roughcontact._base.units import Estimate, Quantity, ShownAsPrinted, WarningText, percent, si
from roughcontact._parts.grid import Grid, grow
from roughcontact._solve.solution import ContactSolution, FilledGap, Response, fill_gap, heal, responses
from roughcontact.errors import InputError, NotConverged

# Number of cells, by decreasing loss, that are tried as the centre of the critical throat.
_MAX_THROAT_CANDIDATES = 50
# Cells across a throat below which the grid does not resolve it.
_MIN_THROAT_CELLS = 3.0
# Fraction of the pressure drop in a throat from which its resolution matters.
_MIN_LOSS_FRACTION = 0.1
# Relative uncertainty above which flows may err by more than 10 %: none of 215 flows without this warning, on which the
# constants were set, does.
_MAX_RELATIVE_STD = 0.1
# The same of holes, and where so much of it is by creases and sharp edges, whose errors have one sign.
_MAX_CREASE_STD = 0.055
_MIN_CREASE_FRACTION = 0.25
# The same where nearly all of it is that of the gap: the flow may then change as a whole, as beside a free border.
_MAX_GAP_STD = 0.08
_MIN_GAP_FRACTION = 0.9
# The same of grooves with creases, where few cells may miss a path; and the fraction of the uncertainty by creases that
# is left there, as the rule of the faces is that of creases. Set on draw 503.
_MAX_CREASED_STD = 0.05
_CREASED_FRACTION = 0.5
# Pressure, over the mean in contact, below which cells beside open ones may be open on a finer grid. Set on craters.
_LIGHT_PRESSURE = 0.5
# Power of the gap with which the flow grows.
_GAP_EXPONENT = 3.0
# Weight of the uncertainty of the gap at non-measured points, which are throats more often than others. Set on rough
# contacts with points, blobs and margins that are lost.
_HOLE_WEIGHT = 1.5
# Gap below which a liquid does not flow as a continuum, m: some molecules of water.
_MOLECULAR_GAP = 1e-9


@attrs.frozen
class Throat(ShownAsPrinted):
    """The place where the flow through a gap loses most power for its width: a square as wide as the gap is there.

    Attributes
    ----------
    place
        Centre (x, y) of its cell, m; the origin is the centre of the domain.
    gap
        Gap there, m.
    width
        Width between the contacts on both sides, m: the shortest of four directions through the cell.
    cells
        The width in cells.
    fraction
        Fraction of the power, and so of the pressure drop of this path, that is lost in the square.
    """

    place: Pair
    gap: float
    width: float
    cells: float
    fraction: float

    def __str__(self) -> str:
        x, y = (si(value, "m", 3) for value in self.place)
        return (
            f"throat at ({x}, {y}), gap {si(self.gap, 'm', 3)}, {self.cells:.3g} cells across, "
            f"{percent(self.fraction)} of the loss"
        )


def find_throat(
    network: FlowNetwork, lost: Array, open_cells: Mask, grid: Grid, axis: int, *, periodic: bool
) -> Throat:
    """Return the critical throat: the cell around which a square as wide as the gap loses most power for its width.

    Parameters
    ----------
    network, lost
        The network, and the power lost in each of its cells.
    open_cells
        Cells that are not in contact, shape (along, across) the flow.
    grid, axis
        The grid, and the axis of the flow.
    periodic
        Whether the gap repeats across the flow.
    """
    along, across = grid.spacing if axis == 0 else grid.spacing[::-1]
    field = np.zeros(network.shape)
    field.reshape(-1)[network.cells] = lost
    left = field.copy()
    total = float(lost.sum())
    best = (-1.0, 0.0, (0, 0), 0.0, 0.0)
    for _ in range(_MAX_THROAT_CANDIDATES):
        i, j = divmod(int(np.argmax(left)), network.shape[1])
        width, cells = _measure_width(open_cells, (i, j), along, across, periodic=periodic)
        square = _square_around((i, j), math.ceil(0.5 * cells), network.shape, periodic=periodic)
        fraction = float(field[square].sum()) / total
        best = max(best, (fraction / width, fraction, (i, j), width, cells))
        left[square] = 0.0
    _, fraction, (i, j), width, cells = best
    place = (i, j) if axis == 0 else (j, i)
    position = int(np.searchsorted(network.cells, i * network.shape[1] + j))
    return Throat(
        place=(float(grid.x[place[0], 0]), float(grid.y[0, place[1]])),
        gap=float(network.film[position]) * network.widest,
        width=width,
        cells=cells,
        fraction=fraction,
    )


def _measure_width(
    open_cells: Mask, at: tuple[int, int], along: float, across: float, *, periodic: bool
) -> tuple[float, float]:
    """Return the length of the shortest of four lines through a cell from contact to contact, m and cells."""
    diagonal = math.hypot(along, across)
    widths = []
    for step, length, cells in (
        ((1, 0), along, 1.0),
        ((0, 1), across, 1.0),
        ((1, 1), diagonal, math.sqrt(2.0)),
        ((1, -1), diagonal, math.sqrt(2.0)),
    ):
        both = step, (-step[0], -step[1])
        count = 1 + sum(_count_open(open_cells, at, one, periodic=periodic) for one in both)
        # Around a periodic domain a cell is met from both sides.
        count = min(count, max(open_cells.shape))
        widths.append((count * length, count * cells))
    return min(widths)


def _square_around(
    at: tuple[int, int], reach: int, shape: tuple[int, int], *, periodic: bool
) -> tuple[RealArray, RealArray]:
    """Return the indices of the cells up to `reach` cells away."""
    rows = np.arange(max(at[0] - reach, 0), min(at[0] + reach + 1, shape[0]))
    columns = np.arange(at[1] - reach, at[1] + reach + 1)
    columns = np.unique(columns % shape[1]) if periodic else columns[(columns >= 0) & (columns < shape[1])]
    return rows[:, np.newaxis], columns


def _count_open(open_cells: Mask, start: tuple[int, int], step: tuple[int, int], *, periodic: bool) -> int:
    """Return the number of open cells from a cell along a direction, without the cell itself."""
    nx, ny = open_cells.shape
    i, j = start
    count = 0
    while count < max(nx, ny):
        i = i + step[0]
        j = j + step[1]
        j = j % ny if periodic else j
        if not (0 <= i < nx and 0 <= j < ny and open_cells[i, j]):
            break
        count += 1
    return count


@attrs.frozen(eq=False, kw_only=True)
class Leakage(Estimate):
    """The flow of a liquid through the gap, driven by a pressure drop between two opposite sides.

    Attributes
    ----------
    value
        Volume flow, m3/s; exactly zero if no open path joins both sides.
    uncertainty
        One standard deviation, m3/s, because the cells do not resolve the gap everywhere.
    unit
        ``"m3/s"``.
    connected
        Whether an open path joins both sides.
    flow_factor
        The flow over the flow through a parallel gap with the same mean gap.
    throat
        The critical throat; None if no path is open.
    inflow, outflow
        Flow in at one side and out at the other, m3/s: they differ by the error of the linear solve.
    grid, axis
        The cells, and the axis along which the liquid flows.
    viscosity, pressure_drop
        Viscosity, Pa s, and pressure drop, Pa.
    warnings
        Why the value must not be trusted, in sentences; empty without a reason.
    """

    value: float = 0.0
    uncertainty: float = 0.0
    unit: str = attrs.field(default="m3/s", init=False)
    connected: bool = False
    flow_factor: float = 0.0
    throat: Throat | None = None
    inflow: float = 0.0
    outflow: float = 0.0
    grid: Grid
    axis: int
    viscosity: float
    pressure_drop: float
    warnings: tuple[str, ...] = ()
    _network: FlowNetwork | None = attrs.field(default=None, repr=False)
    _pressure: Array | None = attrs.field(default=None, repr=False)

    @cached_property
    def fluid_pressure(self) -> Array:
        """Pressure of the liquid above the pressure at the outlet, shape `grid.shape`, Pa; nan where nothing flows."""
        field = np.full(self.grid.shape, np.nan)
        if self._network is not None and self._pressure is not None:
            oriented = field if self.axis == 0 else field.T
            oriented[np.divmod(self._network.cells, oriented.shape[1])] = self.pressure_drop * self._pressure
        return read_only(field)

    @cached_property
    def flux(self) -> Array:
        """Flow over width along x and y at the cell centres, shape (2, nx, ny), m2/s; zero where nothing flows."""
        if self._network is None or self._pressure is None:
            return read_only(np.zeros((2, *self.grid.shape)))
        unit = flow_unit(self.viscosity, self.pressure_drop, self._network.widest)
        along, across = self._network.find_flow_of_cells(self._pressure)
        dx, dy = self.grid.spacing
        components = (along / dy, across / dx) if self.axis == 0 else (across.T / dy, along.T / dx)
        return read_only(unit * np.stack(components))

    def __str__(self) -> str:
        axis = "xy"[self.axis]
        if not self.connected:
            return f"no flow along {axis}: no open path joins the two sides{self._reasons}"
        spread = percent(self.uncertainty / self.value) if self.value > 0.0 else si(self.uncertainty, "m3/s", 2)
        return (
            f"{si(self.value, 'm3/s', 5)} +- {spread} along {axis}, flow factor {self.flow_factor:.4g}; "
            f"{self.throat}{self._reasons}"
        )


def flow_axis(value: int) -> int:
    """Return the axis of the flow, or raise `InputError`."""
    return checks.axis(value, "The axis of the flow")


def _viscosity(value: Quantity) -> float:
    return number(value, "The viscosity", "Pa s", above=0.0)


def _pressure_drop(value: Quantity) -> float:
    return number(value, "The pressure drop", "Pa", above=0.0)


@responses.register("leakage")
@attrs.frozen(kw_only=True)
class GapFlow(Response[Leakage]):
    r"""The slow flow of a liquid through the gap, by Reynolds' equation.

    .. math:: \nabla \cdot \left(\frac{g^3}{12 \eta} \nabla p\right) = 0

    with the gap g on the open cells (Reynolds 1886, doi:10.1098/rstl.1886.0005). The liquid does not move the bodies.
    At non-measured points the gap is continued from their neighbours.

    Parameters
    ----------
    axis
        0: from the side of smallest x to the opposite side; 1: along y.
    viscosity
        Dynamic viscosity, Pa s.
    pressure_drop
        Pressure at the inlet minus pressure at the outlet, Pa.
    """

    depends_on_place = True
    holds_with = frozenset({"tension", "shear", "relaxation"})
    memory_arrays = 168.0  # the matrix of the flow and its multigrid

    axis: int = attrs.field(default=0, converter=flow_axis)
    viscosity: float = attrs.field(converter=_viscosity, metadata={"unit": "Pa s"})
    pressure_drop: float = attrs.field(converter=_pressure_drop, metadata={"unit": "Pa"})

    def respond(self, solution: ContactSolution) -> Leakage:
        """Return the flow; see `Response.respond`.

        Raises
        ------
        InputError
            If the gap is not finite.
        MissingPackage
            If more than 3 million open cells join the sides and pyamg is not installed.
        NotConverged
            If the flow does not converge.
        """
        filled = fill_gap(solution)
        open_cells = self._turn(find_open_cells(solution, filled.values))
        along, across = solution.grid.spacing if self.axis == 0 else solution.grid.spacing[::-1]
        periodic = not solution.boundary.free_axes[1 - self.axis]
        network = make_network(
            self._turn(filled.values),
            open_cells,
            aspect=across / along,
            periodic=periodic,
            creased=find_creases(heal(solution).initial_gap),
        )
        if network is not None:
            return self._measure(solution, network, filled, open_cells)
        warnings = (*_list_warnings(solution), *_judge_closure(solution, open_cells, self.axis))
        return Leakage(grid=solution.grid, **attrs.asdict(self), warnings=warnings)

    def _turn(self, field: RealArray) -> RealArray:
        """Return a field with the axis of the flow first, or such a field turned back."""
        return field if self.axis == 0 else field.T

    def _measure(self, solution: ContactSolution, network: FlowNetwork, filled: FilledGap, open_cells: Mask) -> Leakage:
        """Return the flow through a network, with its uncertainty and its throat."""
        grid = solution.grid
        periodic = not solution.boundary.free_axes[1 - self.axis]
        pressure, converged = solve_network(network)
        if not converged:
            raise NotConverged("The flow through the gap did not converge.", solution)
        faces, lost = network.dissipation(pressure)
        flow = float(lost.sum())
        ends = network.find_ends(pressure)
        gap_error = solution.residuals.error * solution.residuals.scale / network.widest
        relative = estimate_uncertainty(network, faces, lost, open_cells, gap_error=gap_error)
        of_creases, of_mean_gap = _find_gap_stds(solution, network, lost)
        std_of_cells = self._turn(filled.std).reshape(-1)[network.cells] / (network.film * network.widest)
        of_holes = _HOLE_WEIGHT * _GAP_EXPONENT * float(np.sum(lost * std_of_cells)) / flow
        relative = math.hypot(relative, of_creases, of_mean_gap, of_holes)
        throat = find_throat(network, lost, open_cells, grid, self.axis, periodic=periodic)
        warnings = (*_list_warnings(solution), *_judge_throat(throat, min(grid.shape)))
        if not warnings:
            warnings = _judge_uncertainty(
                relative, of_creases, of_mean_gap, of_holes, is_creased=network.faces.creased > 0.0
            )
        unit = flow_unit(self.viscosity, self.pressure_drop, network.widest)
        mean = float(np.mean(np.where(self._turn(open_cells), filled.values, 0.0))) / network.widest
        return Leakage(
            grid=grid,
            **attrs.asdict(self),
            value=unit * flow,
            uncertainty=unit * flow * relative,
            connected=True,
            flow_factor=flow / mean**3 * grid.size[self.axis] / grid.size[1 - self.axis],
            throat=throat,
            inflow=unit * ends[0],
            outflow=unit * ends[1],
            warnings=warnings,
            network=network,
            pressure=pressure,
        )


def _find_gap_stds(solution: ContactSolution, network: FlowNetwork, lost: Array) -> tuple[float, float]:
    """Return the relative standard deviations of the flow by that of the gap, which the cells of the flow do not show.

    The flow grows with the cube of the gap. Creases and sharp edges shift it by the same everywhere, which is most in
    the throats: the first one. The second is that of the mean gap by all else.
    """
    shift = find_lost_std(solution)
    rises = (1.0 + shift / (network.film * network.widest)) ** _GAP_EXPONENT - 1.0
    of_shift = float(np.sum(lost * rises)) / float(np.sum(lost))
    of_shift *= 1.0 - (1.0 - _CREASED_FRACTION) * network.faces.creased
    known = (
        solution.response("mean-gap", uncertainty="model")
        if solution._laws <= responses["mean-gap"].holds_with
        else None
    )
    if known is None or known.value <= 0.0:
        return of_shift, 0.0
    rest = math.sqrt(max(known.uncertainty**2 - shift**2, 0.0))
    return of_shift, _GAP_EXPONENT * rest / known.value


def flow_unit(viscosity: float, pressure_drop: float, gap: float) -> float:
    """Return the flow, m3/s, through a square parallel gap."""
    return gap * gap / (12.0 * viscosity) * gap * pressure_drop


def find_open_cells(solution: ContactSolution, gap: Array) -> Mask:
    """Return the cells through which liquid flows: without pressure, and open in a gap that is known everywhere, m.

    Non-measured points are open where the gap of their neighbours, continued, is.
    """
    if not np.isfinite(gap).all():
        raise InputError("The gap is not finite everywhere, so that no flow through it can be computed.")
    return ~solution.contact & (gap > 0.0)


def _list_warnings(solution: ContactSolution) -> tuple[str, ...]:
    """Return why the gap must not be trusted."""
    warnings = [] if solution.status.success else [WarningText(f"The contact is {solution.status}.", "convergence")]
    return tuple(warnings)


def _judge_closure(solution: ContactSolution, open_cells: Mask, axis: int) -> tuple[str, ...]:
    """Return why a finer grid may join the two sides, that no path of open cells joins, shape (along, across)."""
    periodic = not solution.boundary.free_axes[1 - axis]
    if find_paths(open_cells, periodic=periodic, corners=True).any():
        text = "The two sides are joined through corners of cells alone: refine the grid."
        return (WarningText(text, "resolution"),)
    pressure = solution.contact_pressure
    light = pressure < _LIGHT_PRESSURE * pressure.mean(where=solution.contact)
    beside = light & grow(~solution.contact, 1, solution.boundary)
    if find_paths(open_cells | (beside if axis == 0 else beside.T), periodic=periodic).any():
        text = "Cells with little pressure close the last path: refine the grid."
        return (WarningText(text, "resolution"),)
    return ()


def _judge_uncertainty(
    relative: float, of_creases: float, of_mean_gap: float, of_holes: float, *, is_creased: bool
) -> tuple[str, ...]:
    """Return why the flow may err by more than 10 %, from its relative standard deviation and parts of it."""
    of_gap = math.hypot(of_creases, of_mean_gap)
    if of_holes > max(_MAX_CREASE_STD, of_gap):
        text = (
            "The gap at non-measured points, continued from their neighbours, hardly determines the flow: measure them."
        )
        return (WarningText(text, "non-measured points", of_holes),)
    allowed = _MAX_GAP_STD if of_gap > _MIN_GAP_FRACTION * relative else _MAX_RELATIVE_STD
    allowed = _MAX_CREASE_STD if of_creases > _MIN_CREASE_FRACTION * relative else allowed
    allowed = _MAX_CREASED_STD if is_creased else allowed
    if relative > allowed:
        text = "The grid hardly determines the flow, which may err by more than 10 %: refine the grid."
        return (WarningText(text, "uncertainty", relative),)
    return ()


def _judge_throat(throat: Throat, cells: int) -> tuple[str, ...]:
    """Return why the flow through a throat must not be trusted; cells is the shorter side of the domain."""
    warnings = []
    if throat.cells < min(_MIN_THROAT_CELLS, cells) and throat.fraction >= _MIN_LOSS_FRACTION:
        text = f"The critical throat is {throat.cells:.3g} cells across, below {_MIN_THROAT_CELLS:g}: refine the grid."
        warnings.append(WarningText(text, "resolution", throat.cells))
    if throat.gap < _MOLECULAR_GAP:
        text = f"The gap in the critical throat is {si(throat.gap, 'm', 3)}, of molecular size."
        warnings.append(WarningText(text, "molecular gap", throat.gap))
    return tuple(warnings)
