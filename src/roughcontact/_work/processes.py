"""Repeated loading: running in until shakedown."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import callback, integer, number
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Estimate, Force, Pressure, si
from roughcontact._parts.grid import Load
from roughcontact._parts.surfaces import repeats
from roughcontact._solve.problem import (
    PATH_ACCURACY,
    ContactProblem,
    LoadMarch,
    Place,
    find_bodies,
    list_shifts,
    run_solve,
)
from roughcontact._solve.solution import (
    Area,
    ContactSolution,
    Flattening,
    FlatteningModel,
    LoadIncrement,
    Process,
    find_height_loss,
    find_softer,
    flattening_models,
)
from roughcontact.errors import InputError, argument
from roughcontact.errors.door import guarded

# Most positions of the counterbody whose last pressure is kept as a start: each takes the memory of a field.
_MAX_KEPT_PRESSURES = 16
# Loss of height, over the approach, up to which it is rounding and printed as zero.
_MIN_PRINTED_LOSS_RATIO = 1e-12
# Range of the heights, over the depth to which they are lost, up to which a load has flattened everything.
_MIN_LEFT_HEIGHT = 1e-12


@attrs.frozen(kw_only=True)
class Cycle:
    """One cycle of loading, flattening and unloading.

    Attributes
    ----------
    shift
        Cells (x, y) by which the counterbody was displaced.
    volume
        Volume flattened in this cycle, of both bodies, m3.
    deepest
        Maximum loss of height in this cycle, of both bodies, m.
    area, saturated
        Real contact area under load, and the saturated part of it.
    approach
        Approach under load, m.
    """

    shift: tuple[int, int]
    volume: float
    deepest: float
    area: Area
    saturated: Area
    approach: float


@attrs.frozen(eq=False, kw_only=True)
class RunIn(TableResult):
    """Surfaces that were run in, and a record of the cycles.

    Attributes
    ----------
    problem
        The problem with the residual topographies, unloaded, the counterbody in its first position.
    cycles
        One record for each cycle.
    shakedown
        Whether the last round of cycles flattened no more than the tolerance.
    height_loss
        Loss of height of the body and of the counterbody, each of shape (nx, ny), m.
    solution
        The last contact under load; its approach counts from the first touch of the fresh bodies.
    """

    problem: ContactProblem
    cycles: tuple[Cycle, ...]
    shakedown: bool
    height_loss: tuple[Array, Array]
    solution: ContactSolution

    @property
    def volume(self) -> float:
        """Volume flattened in all cycles, m3."""
        return sum(cycle.volume for cycle in self.cycles)

    def __repr__(self) -> str:
        return f"<RunIn {str(self).splitlines()[0]}>"

    def table(self) -> Table:
        """Return a row for each cycle, in SI units; see `roughcontact.typing.Table`."""
        areas = {"area": [one.area for one in self.cycles], "saturated_area": [one.saturated for one in self.cycles]}
        columns: dict[str, Any] = {
            "cycle": range(1, len(self.cycles) + 1),
            "shift_x": [one.shift[0] for one in self.cycles],
            "shift_y": [one.shift[1] for one in self.cycles],
            "volume": np.array([one.volume for one in self.cycles]),
            "deepest": np.array([one.deepest for one in self.cycles]),
            **{name: [Estimate(one.value, one.uncertainty, "m2") for one in found] for name, found in areas.items()},
            "approach": np.array([one.approach for one in self.cycles]),
        }
        return Table(columns, {"volume": "m3", "deepest": "m", "approach": "m"})

    def short_table(self) -> Table:
        """Return a row for each cycle for people, with the areas in percent of nominal."""
        nominal = self.problem.plan.grid.area
        lost = [one.deepest > _MIN_PRINTED_LOSS_RATIO * one.approach for one in self.cycles]
        pairs = list(zip(self.cycles, lost, strict=True))
        return Table(
            {
                "cycle": range(1, len(self.cycles) + 1),
                "shift": [str(one.shift) for one in self.cycles],
                "volume, um3": [f"{one.volume * 1e18 if is_lost else 0.0:.4g}" for one, is_lost in pairs],
                "deepest": [si(one.deepest if is_lost else 0.0, "m", 3) for one, is_lost in pairs],
                "area, %": [f"{100 * one.area.value / nominal:.4g}" for one in self.cycles],
                "saturated, %": [f"{100 * one.saturated.value / nominal:.3g}" for one in self.cycles],
            }
        )

    def _list_head(self) -> Sequence[str]:
        end = "shakedown" if self.shakedown else "no shakedown yet"
        return [f"{end} after {len(self.cycles)} cycles, {self.volume * 1e18:.4g} um3 flattened"]


@guarded
def run_in(
    problem: ContactProblem,
    *,
    pressure: Pressure | None = None,
    force: Force | None = None,
    model: str | FlatteningModel = "overlap",
    shifts: Sequence[tuple[int, int]] = ((0, 0),),
    rounds: int = 20,
    tolerance: float = 1e-3,
    on_cycle: Callable[[RunIn], None] | None = None,
) -> RunIn:
    """Return two bodies after repeated loading, flattening and unloading, until shakedown.

    Each cycle solves the contact and takes the loss of height from the softer body, or half of it from each where
    they are equally hard. From cycle to cycle the counterbody is displaced by whole cells, periodically across the
    border, as a ring moves under a ball. Each cycle starts from the pressure of the last one in the same position.

    Parameters
    ----------
    problem
        The fresh bodies; at least one has a pressure limit.
    pressure, force
        Exactly one load, as in `ContactProblem.solve`. (An approach is counted from first touch, which flattening
        moves.)
    model
        Registered name or instance of a flattening model: ``"overlap"`` or ``"uniform-rise"``.
    shifts
        Cells (x, y) by which the counterbody is displaced from its first position, for each cycle of a round.
    rounds
        Maximum number of rounds.
    tolerance
        Shakedown is reached when a round flattens no more than this fraction of the volume so far.
    on_cycle
        Called after each cycle with the `RunIn` so far; its problem may be saved, and run in further.

    Raises
    ------
    InputError
        If neither body has a pressure limit, the load is not admissible or flattens everything, the counterbody is
        displaced although its heights do not repeat, or the model does not return heights.
    NotConverged
        If a contact is not certified.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> worn = rc.run_in(problem, pressure=100e6)
    >>> print(f"{1e18 * worn.volume:.0f} µm3 flattened, shakedown: {worn.shakedown}")
    78 µm3 flattened, shakedown: True
    """
    if not isinstance(problem, ContactProblem):
        raise InputError.about("The problem", problem, "a ContactProblem")
    if problem.adhesion is not None:
        raise InputError(
            f"Running in knows no tension: omit {argument('adhesion')}, or follow the loads by problem.sweep."
        )
    chosen = flattening_models.resolve(model)
    moves = _check_shifts(shifts, problem)
    rounds = integer(rounds, "The number of rounds", at_least=1)
    tolerance = number(tolerance, "The tolerance of shakedown", at_least=0.0, at_most=1.0)
    on_cycle = callback(on_cycle, "on_cycle=", "result")
    load = problem.require_load(pressure=pressure, force=force)
    # Bodies without a hardness are refused before the first contact.
    find_softer(problem)
    others = tuple(law for law in problem.laws if not isinstance(law, Flattening))
    for law in others:
        if isinstance(law, Process):
            raise InputError(
                f"Running in remembers flattening alone, not {type(law).__name__}: omit it from {argument('laws')}, or "
                "follow the loads by problem.path."
            )
    scene = attrs.evolve(problem, laws=(*others, Flattening(chosen, both=True)))
    pressures: dict[tuple[int, int], Array] = {}

    def solve(
        load: Load,
        start: Array | None = None,
        *,
        increment: LoadIncrement,
        before: ContactSolution | None = None,
    ) -> ContactSolution:
        """Solve from the last pressure in the same position: that of another one says little."""
        shift = increment.shift
        found = run_solve(scene, load, pressures.get(shift), before=before, increment=increment)
        if len(pressures) < _MAX_KEPT_PRESSURES or shift in pressures:
            pressures[shift] = found.pressure
        return found

    march = LoadMarch(solve, PATH_ACCURACY)
    cycles: list[Cycle] = []
    shakedown = False
    for shift in itertools.islice(itertools.cycle(moves), min(rounds * len(moves), sys.maxsize)):
        march.go(None, Place(load=load, shift=shift))
        cycles.append(_record_cycle(march.last, shift, find_height_loss(chosen, march.last)))
        volumes = [cycle.volume for cycle in cycles]
        # Only a complete round counts.
        complete = len(cycles) % len(moves) == 0
        shakedown = complete and sum(volumes[-len(moves) :]) <= tolerance * sum(volumes)
        if on_cycle is not None:
            on_cycle(_make_result(problem, cycles, shakedown, march.last))
        if shakedown:
            break
    return _make_result(problem, cycles, shakedown, march.last)


def _record_cycle(state: ContactSolution, shift: tuple[int, int], height_loss: Array) -> Cycle:
    """Return the record of a cycle; `InputError` if it leaves no heights."""
    measured = True if state.non_measured is None else ~state.non_measured
    touch = float(np.min(state.initial_gap, where=measured, initial=np.inf))
    left = (state.initial_gap + height_loss)[np.broadcast_to(measured, height_loss.shape)]
    if np.ptp(left) <= _MIN_LEFT_HEIGHT * np.abs(left).max():
        raise InputError("The load has flattened everything, and nothing is left to run in: choose a smaller one.")
    return Cycle(
        shift=shift,
        volume=float(np.maximum(height_loss, 0.0).sum()) * state.grid.cell_area,
        deepest=max(float(height_loss.max()), 0.0),
        area=state.area(),
        saturated=state.saturated_area(),
        # From the first touch of the surfaces as they are.
        approach=state.approach - touch,
    )


def _make_result(problem: ContactProblem, cycles: Sequence[Cycle], shakedown: bool, last: ContactSolution) -> RunIn:
    """Return the result so far, of bodies with the heights after a last state."""
    grid = problem.plan.grid
    body, counterbody = find_bodies(last, f"run in by {len(cycles)} cycles")
    pairs = ((problem.body, body), (problem.counterbody, counterbody))
    loss, other = (fresh.heights(grid) - now.heights(grid) for fresh, now in pairs)
    return RunIn(
        problem=attrs.evolve(problem, body=body, counterbody=counterbody, grid=grid),
        cycles=tuple(cycles),
        shakedown=shakedown,
        height_loss=(loss, other),
        solution=last,
    )


def _check_shifts(shifts: Sequence[tuple[int, int]], problem: ContactProblem) -> tuple[tuple[int, int], ...]:
    """Return the shifts; `InputError` if something would not move with the counterbody."""
    moves = list_shifts(shifts)
    array = np.array(moves)
    if array.any():
        if any(np.ndim(side.material.pressure_limit) for side in (problem.body, problem.counterbody)):
            raise InputError("The pressure limit is an array, so the counterbody cannot be shifted: leave shifts= out.")
        heights = problem.counterbody.surface.heights(problem.plan.grid)
        for axis, name in enumerate("xy"):
            if array[:, axis].any() and not repeats(heights, axis):
                raise InputError(
                    f"The counterbody's heights do not repeat along {name}, so that shifting it puts a step into the "
                    f"contact: use a map that repeats, or shifts of zero along {name}."
                )
    return moves
