"""Plastic flattening: what the cells at the pressure limit lose, and a process that remembers it."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import Part, flag
from roughcontact._base.registry import Registry
from roughcontact._base.units import Estimate
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.laws import Memory, Process
from roughcontact._solve.solution.load_increment import LoadIncrement
from roughcontact.errors import InputError, argument


class FlatteningModel(Part, abc.ABC):
    """A model of plastic flattening; a class of your own gives the loss of height.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class HalfOverlap(rc.Overlap):
    ...     def height_loss(self, solution):
    ...         return 0.5 * super().height_loss(solution)
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=HalfOverlap()).shakedown)
    True
    """

    @abc.abstractmethod
    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the loss of height of both bodies together after unloading, shape (nx, ny), m.

        Negative where the surfaces rise. The elastic displacement recovers completely.
        """


flattening_models = Registry(FlatteningModel, "flattening model", "roughcontact.flattening_models")


@attrs.frozen
class Overlap(FlatteningModel):
    """The overlap of the saturated cells remains as flattening; its volume is lost into the bulk.

    Pressure and position of the bodies under load are conserved: loaded again in the same place, the surfaces
    carry the same pressure elastically, so that one cycle is shakedown. (The approach counts from first touch, which
    is later by the height that the highest summit lost.) The volume is not conserved. The same rule is used, for
    instance, by Weber et al., Nat. Commun. 9 (2018) 888, https://doi.org/10.1038/s41467-018-02981-y

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=rc.Overlap()).shakedown)
    True
    """

    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the overlap of the saturated cells, shape (nx, ny), m, zero elsewhere."""
        return np.where(solution.saturated, np.maximum(-solution.gap, 0.0), 0.0)


@attrs.frozen
class UniformRise(FlatteningModel):
    """The volume of the overlap comes back as a uniform rise of all cells that are not in contact.

    The volume, and so the mean height, is conserved. Loaded again in the same place, the raised surface carries part of
    the load. In full contact all cells rise. The rise was observed on confined specimens by Pullen and Williamson,
    Proc. R. Soc. Lond. A 327 (1972) 159, https://doi.org/10.1098/rspa.1972.0038

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=rc.UniformRise()).shakedown)
    True
    """

    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the overlap less the rise, shape (nx, ny), m; its mean is zero.

        Raises
        ------
        InputError
            If the volume exceeds the volume of the gap.
        """
        loss = Overlap().height_loss(solution)
        open_cells = ~solution.contact
        count = np.count_nonzero(open_cells)
        if count == 0:
            return np.asarray(loss - loss.mean(), dtype=np.float64)
        displaced = float(loss.sum())
        if displaced > float(solution.gap[open_cells].sum()):
            raise InputError(
                "The open cells cannot take the displaced volume: the gap there is smaller. Choose a smaller load, or "
                "the model 'overlap'."
            )
        loss[open_cells] -= displaced / count
        return loss


def find_height_loss(model: FlatteningModel, solution: ContactSolution) -> Array:
    """Return the loss of height by a model, checked to be a field of the grid, m."""
    height_loss = np.asarray(model.height_loss(solution))
    if height_loss.shape != solution.grid.shape or height_loss.dtype.kind != "f" or not np.isfinite(height_loss).all():
        raise InputError(
            f"The flattening model {model!r} must give finite real heights of shape {solution.grid.shape}, but gave an "
            f"array of shape {height_loss.shape} and type {height_loss.dtype}."
        )
    return height_loss


def find_softer(problem: Any) -> float | Array:
    """Return the body's fraction of the flattening: all where it is softer, half where both are equal."""
    one, other = (np.asarray(side.material.pressure_limit) for side in (problem.body, problem.counterbody))
    if np.isinf(one).all() and np.isinf(other).all():
        raise InputError(
            "Neither material has a pressure limit, so nothing is flattened: make one ElasticPerfectlyPlastic(...)."
        )
    sign = np.sign(other - one, where=one != other, out=np.zeros(np.broadcast(one, other).shape))
    fraction = 0.5 * (1.0 + sign)
    return float(fraction) if fraction.ndim == 0 else fraction


def _find_model(choice: str | FlatteningModel) -> FlatteningModel:
    return flattening_models.resolve(choice)


def _both(value: object) -> bool:
    return flag(value, "both=")


@attrs.frozen
class Flattening(Process):
    """The flattening of a contact whose pressure is limited, remembered: unloading and reloading are elastic.

    On loads that rise one increment is exact, as the state does not depend on the loads between; so it is on loads that
    fall, on which nothing flows. The work is lost in the cells at the limit, as their surfaces overlap, at that limit.

    Parameters
    ----------
    model
        Registered name or instance of a `FlatteningModel`: ``"overlap"``, by which the overlap remains, or another.
    both
        Whether each body remembers its own loss: a path with ``shift=`` brings it for bodies that are equally hard.

    Examples
    --------
    A ball of steel after an overload carries half of it by a larger contact:

    >>> import roughcontact as rc
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), steel)
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((64, 64), 100e-6), laws=rc.Flattening())
    >>> up, back = problem.sweep(force=[4.0, 2.0])
    >>> print(back.area().value > problem.solve(force=2.0).area().value)
    True
    """

    model: FlatteningModel = attrs.field(factory=Overlap, converter=_find_model)
    both: bool = attrs.field(default=False, converter=_both, repr=False)

    rates: ClassVar[tuple[str, ...]] = ()
    follows_bodies: ClassVar[bool] = True

    # Where flattened surfaces are not loaded as far again, summits are no longer those that estimators by Hertz know.
    default_area: ClassVar[str] = "level-set"

    @property
    def remembered(self) -> Mapping[str, tuple[str, str]]:  # type: ignore[override]
        """Heights that are lost and the work: what the counterbody has lost for itself, where both are flattened."""
        other = {"flattened_counterbody": ("height lost by the counterbody", "m")} if self.both else {}
        return {
            "flattened_height": ("height lost by plastic flattening", "m"),
            **other,
            "plastic_work": ("plastic work per area", "J/m2"),
        }

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return the height lost before, m; see `Law.change_gap`."""
        lost = memory["flattened_height"]
        if self.both:
            return np.asarray(lost + increment.place(memory["flattened_counterbody"]))
        return np.asarray(increment.place(lost)) if self._is_of_counterbody(problem, increment) else lost

    def remember(self, state: ContactSolution, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the height lost, m, and the plastic work per area, J/m2, after an increment."""
        overlap = Overlap().height_loss(state)
        # Without a limit, which is infinite, nothing overlaps.
        work = np.multiply(state.pressure_limit, overlap, where=overlap > 0.0, out=np.zeros(overlap.shape))
        lost = find_height_loss(self.model, state)
        assert state.origin is not None
        scene = state.origin.scene
        found = {}
        if self.both:
            part = find_softer(scene)
            moved = increment.place_back((1.0 - part) * lost)
            found["flattened_counterbody"] = memory["flattened_counterbody"] + moved
            lost = part * lost
        elif self._is_of_counterbody(scene, increment):
            lost, work = (np.asarray(increment.place_back(values)) for values in (lost, work))
        return found | {
            "flattened_height": memory["flattened_height"] + lost,
            "plastic_work": memory["plastic_work"] + work,
        }

    def _is_of_counterbody(self, problem: Any, increment: LoadIncrement) -> bool:
        """Return whether the counterbody, which has moved, is the one that is flattened."""
        if increment.shift == (0, 0):
            return False
        part = find_softer(problem)
        if not isinstance(part, float) or part not in (0.0, 1.0):
            raise InputError(
                "Bodies that move over each other and are equally hard are both flattened, each in its own place: give "
                f"{argument('laws', 'rc.Flattening(both=True)')}, or begin the path with {argument('shift')}."
            )
        return part == 0.0

    def divide(self, problem: Any, memory: Memory) -> tuple[float | Array, float | Array]:
        """Return the loss of each body: all of the softer one, half of both where they are equally hard."""
        lost = memory["flattened_height"]
        if self.both:
            return lost, memory["flattened_counterbody"]
        part = find_softer(problem)
        return part * lost, (1.0 - part) * lost

    def list_numbers(self, state: ContactSolution, memory: Memory) -> Mapping[str, Estimate | tuple[float, str]]:
        """Return the volume flattened, m3, and the plastic work, J, since the first touch."""
        names = (name for name in memory if name.startswith("flattened"))
        flattened = sum(float(np.maximum(memory[name], 0.0).sum()) for name in names)
        cell = state.grid.cell_area
        return {
            "flattened_volume": (flattened * cell, "m3"),
            "plastic_work": (float(memory["plastic_work"].sum()) * cell, "J"),
        }
