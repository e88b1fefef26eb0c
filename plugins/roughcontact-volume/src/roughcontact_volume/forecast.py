"""What plastic flow takes of a solve, before it: the box, its memory, and the stresses that are computed."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import WorkText
from roughcontact.typing import Array, Load, si

from roughcontact_volume.box import count_layers, find_operators, find_yield_depth
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.refusals import require_possible
from roughcontact_volume.yielding import Yielding

# Stresses of a step, and steps of a first load at the default accuracy: measured on balls and rough surfaces, they are
# from a fifth to five times as many. The steps grow with the accuracy that is asked.
_STRESSES = 10.0
_STEPS = 15.0
_DEFAULT_ACCURACY = 0.02
# Time of a stress with its contact over that of the maps of the volume, and fields of a strain beside them.
_WITH_CONTACT = 1.3
_FIELDS = 4


def make_elastic(problem: Any) -> Any:
    """Return the problem as if its bodies that flow were elastic."""
    bodies = {side: getattr(problem, side) for side in ("body", "counterbody")}
    elastic = {
        side: rc.Body(one.surface, rc.Elastic(one.material.young, one.material.poisson))
        for side, one in bodies.items()
        if isinstance(one.material, Yielding)
    }
    return attrs.evolve(problem, laws=(), **elastic)


def forecast_flow(problem: Any, material: Yielding, load: Load | None) -> list[tuple[str, str]]:
    """Return what the flow of a body takes at a load, in rows of a plan; see `Law.explain_work`."""
    if load is None:
        text = "as deep as an elastic contact comes near the yield stress: name a load, explain(force=...)"
        return [("box", WorkText(text))]
    try:
        require_possible(problem)
        return _forecast(problem, material, load)
    except (rc.InputError, rc.OutOfMemory) as error:
        return [("box", WorkText(f"refused: {error}"))]


def _forecast(problem: Any, material: Yielding, load: Load) -> list[tuple[str, str]]:
    grid, boundary = problem.plan.grid, problem.boundary
    started = time.perf_counter()
    elastic = make_elastic(problem).solve(**load.arguments, throw=False)
    depth = find_yield_depth(grid, boundary, material, elastic.pressure)
    if not depth:
        text = f"none: at {load} the elastic contact stays below the yield stress"
        return [("box", WorkText(text, 0.0, time.perf_counter() - started))]
    operators = find_operators(grid, boundary, max(2, count_layers(grid, depth)), material)
    count = len(operators.thicknesses)
    field = np.zeros(operators.shape)
    # The first time prepares the maps.
    seconds = _WITH_CONTACT * min(_time_product(operators, elastic.pressure, field) for _ in range(2))
    stresses = _STRESSES * max(1.0, _STEPS * _DEFAULT_ACCURACY / material.accuracy)
    memory = operators.bytes_needed + _FIELDS * field.nbytes
    seconds *= stresses
    reach = si(float(operators.thicknesses.sum()), "m")
    box = f"{count} layers to {reach} at {load}, more where flow reaches the lowest: {memory / 2**20:.3g} MiB"
    flow = f"about {stresses:.0f} stresses, {si(seconds, 's', 2)} in all, within a factor of five"
    return [("box", WorkText(box, memory, 0.0)), ("flow", WorkText(flow, 0.0, seconds))]


def _time_product(operators: VolumeOperators, pressure: Array, strain: Array) -> float:
    """Return the time of the maps from a pressure and a strain, s."""
    started = time.perf_counter()
    operators.press(pressure)
    operators.find_stress(strain)
    operators.displace(strain)
    return time.perf_counter() - started
