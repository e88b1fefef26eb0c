"""Plastic flow below the surface as a process that is solved together with the contact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import Condition
from roughcontact.typing import Array, Load, LoadIncrement

from roughcontact_volume.forecast import forecast_flow
from roughcontact_volume.judgement import judge_flow
from roughcontact_volume.measures import measure_flow
from roughcontact_volume.refusals import require_possible
from roughcontact_volume.shapes import read_side
from roughcontact_volume.substeps import ANSWERS, PlasticState, SubstepMarch
from roughcontact_volume.yielding import Yielding

# Admissible error of the flow in a step.
_TOLERANCE = 1e-4
# Difference of two loads, over them, below which they are the same: then substeps change nothing.
_SAME_LOAD = 1e-6
_FIELDS = tuple(attrs.fields_dict(PlasticState))


def _side(value: object) -> str:
    return read_side(value, "The body that flows")


@attrs.frozen
class PlasticFlow(rc.CoupledProcess):
    r"""The plastic flow of a body of the material `Plastic`, which brings it.

    The plastic strain :math:`\varepsilon` in cells below the surface leaves the residual stress
    :math:`T \varepsilon` and the imprint :math:`U \varepsilon`, an offset of the gap. In an increment of the load it
    grows until the stress is nowhere beyond the yield surface, with the contact on the changed gap solved in each
    evaluation. Each body keeps its fields in its own frame, with z into it.

    Parameters
    ----------
    of
        The body that flows: ``"body"`` or ``"counterbody"``.

    References
    ----------
    Jacq, Nelias, Lormand, Girodin, J. Tribol. 124 (2002) 653-667, https://doi.org/10.1115/1.1467920

    Examples
    --------
    A ball is pressed into steel that flows, lifted, and pressed again, when nothing flows:

    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((12, 12), "100um"))
    >>> path = problem.path(force=["2N", "0N", "2N"])
    >>> [f"{work * 1e9:.0f} nJ" for work in path.table().columns["plastic_work"]]
    ['37 nJ', '37 nJ', '37 nJ']
    """

    of: str = attrs.field(default="body", converter=_side)

    rates: ClassVar[tuple[str, ...]] = ()
    of_material: ClassVar[bool] = True
    follows_bodies: ClassVar[bool] = True
    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {
        "plastic_strain": ("plastic strain xx, yy, zz, yz, xz, xy below the surface", ""),
        "accumulated_strain": ("accumulated plastic strain below the surface", ""),
        "last_flow": ("plastic strain that flowed in the last substep", ""),
        "imprint": ("displacement of the surface by the plastic strain, into the body", "m"),
        "step_errors": (f"errors of {', '.join(ANSWERS)} by the substeps, in SI units", ""),
        "last_load": ("force, N, and approach, m, at the end of the increment", ""),
    }

    left_behind: ClassVar[str] = "the residual stress and the hardening below the surface"

    def start(self, problem: Any) -> Mapping[str, Array]:
        """Return what is remembered of a fresh body: nothing, in the uppermost layer alone."""
        require_possible(problem)
        fresh = PlasticState.fresh(problem.plan.grid.shape, 1)
        return {**_describe(fresh), "step_errors": np.zeros(len(ANSWERS)), "last_load": np.zeros(2)}

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Mapping[str, Array]) -> Array:
        """Return the imprint where its body lies, m; see `Law.change_gap`."""
        return np.asarray(self._place(increment, memory["imprint"]))

    def settle(
        self, problem: Any, press: Any, increment: LoadIncrement, memory: Mapping[str, Array]
    ) -> Mapping[str, Array]:
        """Return what is remembered after an increment of the load, in substeps that its answers ask for."""
        grid = problem.plan.grid
        material = self._find_material(problem)
        march = SubstepMarch(
            grid,
            problem.boundary,
            material,
            press,
            partial(self._place, increment),
            partial(self._place_back, increment),
            _TOLERANCE,
        )
        is_divisible = not _is_same(increment, grid, memory["last_load"])
        found, change = march.settle(_read(memory), material.accuracy, is_divisible=is_divisible)
        return {
            **_describe(found),
            "step_errors": np.hypot(memory["step_errors"], change),
            "last_load": np.array([march.contact.force, march.contact.approach]),
        }

    def judge(
        self,
        problem: Any,
        state: Any,
        increment: LoadIncrement,
        before: Mapping[str, Array],
        after: Mapping[str, Array],
    ) -> Iterable[Condition]:
        """Return the conditions of plastic flow, with the stress recomputed from pressure and plastic strain."""
        pressure = self._place_back(increment, state.pressure)
        return judge_flow(problem.plan.grid, problem.boundary, self._find_material(problem), pressure, _read(after))

    def list_errors(self, state: Any, memory: Mapping[str, Array]) -> Mapping[str, float]:
        """Return the errors of maximum pressure, approach and mean gap by the substeps."""
        pressure, approach, _, imprint = memory["step_errors"].tolist()
        errors = {"approach": approach, "mean-gap": math.hypot(approach, imprint)}
        return {"peak-pressure": pressure, **errors} if state.pressure.any() else errors

    def explain_limits(self, memory: Mapping[str, Array]) -> Mapping[str, str]:
        """Return what a body that has flowed asks of responses; see `Law.explain_limits`."""
        if not memory["accumulated_strain"].any():
            return {}
        stress = "plastic flow leaves a stress below the surface, which the pressure does not tell"
        return {
            "inner stress": f"{stress}: ask for the response 'total-stress'",
            "inner flow": "the body may flow as the load changes: ask for the stiffness on unloading",
        }

    def explain_work(self, problem: Any, load: Load | None) -> Iterable[tuple[str, str]]:
        """Return the box that a load takes, its memory, and the stresses that are computed; see `Law.explain_work`."""
        return forecast_flow(problem, self.of, self._find_material(problem), load)

    def divide(self, problem: Any, memory: Mapping[str, Array]) -> tuple[float | Array, float | Array]:
        """Return the imprint as what its body has lost of its heights, m."""
        return (memory["imprint"], 0.0) if self.of == "body" else (0.0, memory["imprint"])

    def list_numbers(self, state: Any, memory: Mapping[str, Array]) -> Mapping[str, Any]:
        """Return the size of the plastic zone, what flowed in it, and what is left of it."""
        problem, kinds = state.origin.scene, state.origin.load
        material = self._find_material(problem)
        return measure_flow(problem.plan.grid, problem.boundary, material, _read(memory), memory["step_errors"], kinds)

    def _find_material(self, problem: Any) -> Yielding:
        material = (problem.body if self.of == "body" else problem.counterbody).material
        if not isinstance(material, Yielding):
            raise rc.InputError.about(f"The material of the {self.of} that flows", material, "a Plastic")
        return material

    def _place(self, increment: LoadIncrement, values: Array) -> Array:
        return np.asarray(increment.place(values)) if self.of == "counterbody" else values

    def _place_back(self, increment: LoadIncrement, values: Array) -> Array:
        return np.asarray(increment.place_back(values)) if self.of == "counterbody" else values


def _read(memory: Mapping[str, Array]) -> PlasticState:
    return PlasticState(**{name: memory[name] for name in _FIELDS})


def _describe(state: PlasticState) -> dict[str, Array]:
    return {name: getattr(state, name) for name in _FIELDS}


def _is_same(increment: LoadIncrement, grid: rc.Grid, last: Array) -> bool:
    """Return whether the load is that at the end of the increment before."""
    force, approach = last.tolist()
    before = {"force": force, "pressure": force / grid.area, "approach": approach}[increment.load.kind]
    return bool(abs(increment.load.value - before) <= _SAME_LOAD * abs(before))
