"""The answers of a contact with inclusions, with the error by their boundaries and by the cells of the contact."""

from __future__ import annotations

import math
from typing import Any

import attrs
import roughcontact as rc

from roughcontact_volume.inclusions import Inclusions


@attrs.frozen
class InclusionAnswers:
    """What a contact with inclusions answers.

    Attributes
    ----------
    approach
        Approach of the bodies since the first touch, m.
    peak_pressure
        Maximum pressure, Pa.
    von_mises
        Largest von Mises stress of the cells in and beside the inclusions, Pa. At edges and corners of an inclusion it
        grows with every grid.
    """

    approach: rc.Estimate
    peak_pressure: rc.Estimate
    von_mises: rc.Estimate

    @property
    def estimates(self) -> dict[str, rc.Estimate]:
        """All three, by name."""
        return {"approach": self.approach, "peak_pressure": self.peak_pressure, "von_mises": self.von_mises}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why they must not be trusted, in sentences; empty without a reason."""
        return tuple(dict.fromkeys(text for one in self.estimates.values() for text in one.warnings))

    def __str__(self) -> str:
        return "\n".join(f"{name.replace('_', ' ')} {one}" for name, one in self.estimates.items())


def find_inclusion_answers(state: Any) -> InclusionAnswers:
    """Return approach, maximum pressure and largest stress of a contact with `Inclusions`.

    Each lies between the answers with the softer and the stiffer mixture of the cells that a boundary cuts: half their
    distance is an uncertainty, to which that of the contact on its cells is added as of any contact.

    Parameters
    ----------
    state
        A `ContactSolution` of a problem with `Inclusions`.

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Inclusion, Inclusions, Sphere, find_inclusion_answers
    >>> oxide = Inclusion(Sphere("20um"), "390GPa", 0.2, centre=(0.0, 0.0, "35um"))
    >>> ball = rc.Body(rc.SphereSurface("5mm"), rc.Elastic("210GPa", 0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), "200um"), laws=Inclusions(oxide))
    >>> found = find_inclusion_answers(problem.solve(force="10N"))
    >>> 0.0 < found.approach.uncertainty < 0.01 * found.approach.value
    True
    """
    bounds = _find_bounds(state)
    own = state.response("approach", uncertainty="model"), state.peak_pressure(uncertainty="model")
    cells = state.approach, float(state.pressure.max())
    # The answers of the state, moved to the middle between the mixtures.
    approach, peak = (
        attrs.evolve(
            one, value=one.value + bound.value - cell, uncertainty=math.hypot(one.uncertainty, bound.uncertainty)
        )
        for one, bound, cell in zip(own, bounds, cells, strict=False)
    )
    return InclusionAnswers(approach, peak, bounds[2])


def _find_bounds(state: Any) -> list[rc.Estimate]:
    for addition in state.added:
        for law, memory in zip(getattr(addition, "laws", ()), getattr(addition, "memory", ()), strict=True):
            if isinstance(law, Inclusions):
                return list(law.list_numbers(state, memory).values())
    raise rc.InputError("The contact has no Inclusions: ask for its approach and its peak_pressure as of any contact.")
