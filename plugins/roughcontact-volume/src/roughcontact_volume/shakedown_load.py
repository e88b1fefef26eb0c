"""The load between shakedown and flow in every pass, by passes of several loads."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import attrs
import roughcontact as rc
from roughcontact.typing import Force, Table

from roughcontact_volume.hardening import check_number
from roughcontact_volume.shakedown import PassCount, Passes

_SHAKEN = frozenset({"shakes down", "stays elastic"})
_FLOWING = "flows in every pass"
# Fewest passes after which a body counts as one that flows in every pass: the first ones lead there.
_FEWEST_PASSES = 4


@attrs.frozen(eq=False)
class ShakedownLoad:
    """The load between shakedown and flow in every pass.

    Attributes
    ----------
    trials
        The loads that were tried, N, each with its passes, rising.
    """

    trials: tuple[tuple[float, Passes], ...]

    @property
    def below(self) -> tuple[float, Passes]:
        """The largest load that shakes down, or stays elastic, N, and its passes."""
        return [one for one in self.trials if one[1].verdict in _SHAKEN][-1]

    @property
    def above(self) -> tuple[float, Passes]:
        """The smallest load that flows in every pass, N, and its passes."""
        smallest = self.below[0]
        return next(one for one in self.trials if one[0] > smallest and one[1].verdict == _FLOWING)

    @property
    def force(self) -> rc.Estimate:
        """The load, N: the middle between both, and the standard deviation of what lies anywhere between them."""
        return self._between(self.below[0], self.above[0], "N")

    @property
    def peak_pressure(self) -> rc.Estimate:
        """The largest pressure of the last pass, on the track that the passes leave, Pa."""
        return self._between(self.below[1].peak_pressure, self.above[1].peak_pressure, "Pa")

    def _between(self, one: float, other: float, unit: str) -> rc.Estimate:
        return rc.Estimate(0.5 * (one + other), abs(other - one) / math.sqrt(12.0), unit, self.warnings)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why it must not be trusted, in sentences; empty without a reason."""
        undecided = [force for force, passes in self.trials if passes.verdict == "undecided"]
        texts = [text for _, passes in (self.below, self.above) for text in passes.warnings]
        if undecided:
            texts.append(f"{len(undecided)} of the loads between are undecided after the passes that were allowed")
        return tuple(dict.fromkeys(texts))

    def table(self) -> Table:
        """Return a row for each load that was tried."""
        columns: dict[str, Sequence[Any]] = {
            "force": [force for force, _ in self.trials],
            "passes": [len(passes.new_strain) for _, passes in self.trials],
            "new_strain": [float(passes.new_strain[-1]) for _, passes in self.trials],
            "accumulated_strain": [float(passes.accumulated_strain[-1]) for _, passes in self.trials],
            "peak_pressure": [passes.peak_pressure for _, passes in self.trials],
            "verdict": [passes.verdict for _, passes in self.trials],
        }
        return Table(columns, {"force": "N", "new_strain": "", "accumulated_strain": "", "peak_pressure": "Pa"})

    def __str__(self) -> str:
        lines = [f"shakedown load {self.force}", f"maximum pressure {self.peak_pressure}"]
        return "\n".join([*lines, *(f"warning: {one}" for one in self.warnings)])


def find_shakedown_load(
    problem: rc.ContactProblem,
    shift: Iterable[Sequence[int]],
    force: Sequence[Force],
    *,
    within: float = 0.05,
    passes: int = 8,
) -> ShakedownLoad:
    """Return the force between shakedown and flow in every pass, by passes of a fresh body at several forces.

    Each force takes as many passes as it needs to be judged (`judge_passes`), but at least four to flow in every pass.
    A force in the middle of what is left is tried next.

    Parameters
    ----------
    problem
        A contact whose body is `Plastic`, on a boundary that repeats along the track.
    shift
        The places of one pass, in cells (x, y); see `ContactProblem.path`. Two fifths of the radius of the contact
        between two places, and three radii in all, are enough.
    force
        Two forces, N: one at which the passes shake down, and one at which they flow in every pass.
    within
        Admissible ratio of the two forces that are left, less one.
    passes
        Most passes at a force. One that is undecided then, as next to the limit, bounds what is left.

    Raises
    ------
    InputError
        If passes at the first force do not shake down, or those at the second do not flow in every pass.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 9.2, https://doi.org/10.1017/CBO9781139171731

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic, find_shakedown_load
    >>> body = rc.Body(rc.FlatSurface(), Plastic("210GPa", 0.3, yield_stress="1GPa", accuracy=1.0))
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(body, ball, grid=rc.Grid((24, 12), ("104um", "52um")), boundary="periodic")
    >>> found = find_shakedown_load(problem, [(-4, 0), (0, 0), (4, 0)], force=("1N", "4N"), within=3.0)
    >>> [passes.verdict for _, passes in found.trials]
    ['shakes down', 'flows in every pass']
    """
    places = list(shift)
    check_number(within, "The admissible ratio of two forces, less one,", "")
    if isinstance(passes, bool) or not isinstance(passes, int) or passes < _FEWEST_PASSES:
        raise rc.InputError.about("The number of passes at a force", passes, f"at least {_FEWEST_PASSES}")
    loads = [problem.require_load(force=one).value for one in force]
    if len(loads) != 2 or not loads[0] < loads[1]:
        raise rc.InputError.about("The forces between which shakedown ends", list(force), "two, the smaller one first")
    trials = {one: _roll(problem, places, one, passes) for one in loads}
    for one, wanted, text in (
        (loads[0], _SHAKEN, "smaller force, at which they shake down"),
        (loads[1], {_FLOWING}, "larger force, at which they flow in every pass"),
    ):
        if trials[one].verdict not in wanted:
            raise rc.InputError.about("The passes", f"{one:g} N: {trials[one]}", f"those of a {text}")
    while (gap := _find_gap(trials, within)) is not None:
        middle = math.sqrt(gap[0] * gap[1])
        trials[middle] = _roll(problem, places, middle, passes)
    return ShakedownLoad(tuple(sorted(trials.items())))


def _find_gap(trials: dict[float, Passes], within: float) -> tuple[float, float] | None:
    """Return the wider of the gaps in which shakedown or flow in every pass ends; None if they are narrow enough."""
    loads = sorted(trials)
    shaken = max(one for one in loads if trials[one].verdict in _SHAKEN)
    flowing = min(one for one in loads if trials[one].verdict == _FLOWING and one > shaken)
    if flowing <= shaken * (1.0 + within):
        return None
    inner = [one for one in loads if shaken <= one <= flowing]
    gaps = [(inner[0], inner[1]), (inner[-2], inner[-1])]
    low, high = max(gaps, key=lambda gap: gap[1] / gap[0])
    # Undecided loads do not vanish by trying more of them.
    return (low, high) if high > low * (1.0 + 0.5 * within) else None


def _roll(problem: rc.ContactProblem, places: Sequence[Any], force: float, most: int) -> Passes:
    """Return the passes at a force, as many as tell."""
    path: Any = problem.path(force=force, shift=places)
    count = PassCount()
    while True:
        count.add(path[-len(places) :])
        found = count.judge()
        number = len(count.strains)
        if found.verdict in _SHAKEN or number == most or (found.verdict == _FLOWING and number >= _FEWEST_PASSES):
            return found
        path = attrs.evolve(path, states=path.states[-1:], increments=path.increments[-1:])
        path = path.extend(force=force, shift=places)
