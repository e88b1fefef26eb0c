"""What a path of loads tells as an indentation: its curve, hardness, energies, and what Oliver and Pharr would read."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import attrs
import numpy as np
import roughcontact as rc
import scipy
from roughcontact.results import WarningText
from roughcontact.typing import Array, Table

from roughcontact_volume.flowed_body import FlowedBody

# Of the displacement by a paraboloid of revolution at the edge of its contact, over force and stiffness.
_EDGE_FACTOR = 0.75
# Points to a cell along each axis at which the area below a depth is counted.
_POINTS = 8


@attrs.frozen(eq=False)
class Indentation:
    r"""A path of loads as an indentation.

    Attributes
    ----------
    states
        The states of the path.
    energies
        Of each of them the plastic work, the energy of the residual stress and that of the pressure, shape (n, 3), J.
    stiffness
        Stiffness on unloading at the largest force, N/m.
    area
        Contact area there, m2.
    hardness
        Contact hardness, the force over this area, Pa.
    read_area, read_hardness, read_modulus
        What the method of Oliver and Pharr reads in place of area, m2, and hardness, Pa, and the contact modulus E*,
        Pa.
    modulus
        The contact modulus, Pa.
    warnings
        Why the numbers must not be trusted, in sentences; empty without a reason.
    """

    states: Sequence[Any] = attrs.field(repr=False)
    energies: Array = attrs.field(repr=False)
    stiffness: rc.Estimate
    area: rc.Estimate
    hardness: rc.Estimate
    read_area: rc.Estimate
    read_hardness: rc.Estimate
    read_modulus: rc.Estimate
    modulus: float
    warnings: tuple[str, ...] = ()

    @property
    def work(self) -> Array:
        """Work of the load from the first touch to each state by the trapezoidal rule, shape (n,), J."""
        force, approach = (
            np.array([0.0, *(getattr(one, name) for one in self.states)]) for name in ("force", "approach")
        )
        return np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(approach))

    @property
    def lost(self) -> Array:
        """Work that did not come back if the load were taken off at each state, shape (n,), J.

        It is the plastic work and the energy of the residual stress.
        """
        return np.asarray(self.energies[:, :2].sum(axis=1))

    @property
    def estimates(self) -> Mapping[str, rc.Estimate]:
        """The numbers at the largest force, by name."""
        names = ("stiffness", "area", "hardness", "read_area", "read_hardness", "read_modulus")
        return {name: getattr(self, name) for name in names}

    def table(self) -> Table:
        """Return a row for each state: force, approach, the work by the trapezoidal rule, and the parts of the energy.

        Work is the sum of the three but for the steps of the curve and of the flow.
        """
        columns = {
            "force": [one.force for one in self.states],
            "approach": [one.approach for one in self.states],
            "work": self.work,
            **dict(zip(("plastic_work", "residual_energy", "elastic_energy"), self.energies.T, strict=True)),
        }
        return Table(columns, {"force": "N", "approach": "m", **dict.fromkeys(list(columns)[2:], "J")})

    def __str__(self) -> str:
        rows = {
            "stiffness on unloading": self.stiffness,
            "contact area": self.area,
            "contact hardness": self.hardness,
            "area by Oliver and Pharr": self.read_area,
            "hardness by Oliver and Pharr": self.read_hardness,
            "modulus E* by Oliver and Pharr": self.read_modulus,
        }
        lines = [f"{name:30} {value}" for name, value in rows.items()]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings)])


def find_indentation(path: Sequence[Any]) -> Indentation:
    r"""Return what a path of loads tells as an indentation.

    With the stiffness S on unloading from the largest force F at the approach h, Oliver and Pharr read

    .. math:: h_c = h - 0.75 \frac{F}{S}, \quad A = A(h_c), \quad H = \frac{F}{A}, \quad
       E^* = \frac{\sqrt{\pi}}{2} \frac{S}{\sqrt{A}}

    with the area A of the indenter at a depth: here that of the cells whose initial gap is below it. Pile-up makes it
    too small. The work of the load goes into plastic work, the energy of the residual stress and that of the pressure
    (:math:`\tfrac12 \int p u\,\mathrm{d}A`), which unloading returns.

    Parameters
    ----------
    path
        A `LoadPath` of normal loads, or its states, of a body of the material `Plastic`.

    References
    ----------
    Oliver, Pharr, Journal of Materials Research 7 (1992) 1564-1583, https://doi.org/10.1557/JMR.1992.1564

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Plastic, find_indentation
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1GPa", hardening="4GPa")
    >>> ball = rc.Body(rc.ParaboloidSurface("1mm"), rc.Rigid())
    >>> problem = rc.ContactProblem(ball, rc.Body(rc.FlatSurface(), steel), grid=rc.Grid((21, 21), "65um"))
    >>> found = find_indentation(problem.path(force=["1N", "2N", "0N"]))
    >>> 1.4e9 < found.hardness.value < 1.8e9
    True
    """
    states = tuple(path)
    if not states or not max(state.force for state in states) > 0.0:
        raise rc.InputError("The path carries no load that would indent anything.")
    if np.any(getattr(path, "shift", 0)):
        raise rc.InputError("The indenter moves along the path: give one without shift=.")
    bodies = [FlowedBody.list_of(state) for state in states]
    top = max(range(len(states)), key=lambda place: states[place].force)
    state = states[top]
    stiffness = state.stiffness(unloading=True)
    area = state.area()
    force = state.force
    read_area = _read_area(state, stiffness, float(bodies[top][0].step_errors[1]))
    modulus = 0.5 * math.sqrt(math.pi) * stiffness.value / math.sqrt(read_area.value)
    relative = math.hypot(stiffness.uncertainty / stiffness.value, 0.5 * read_area.uncertainty / read_area.value)
    warnings: dict[str, None] = dict.fromkeys(text for some in bodies for one in some for text in one.warnings)
    warnings |= dict.fromkeys((*stiffness.warnings, *area.warnings, *read_area.warnings))
    return Indentation(
        states,
        np.array([_find_energies(one) for one in states]),
        stiffness,
        rc.Estimate(area.value, area.uncertainty, "m2", area.warnings),
        _divide_force(force, area),
        read_area,
        _divide_force(force, read_area),
        rc.Estimate(modulus, relative * modulus, "Pa", read_area.warnings),
        state.modulus,
        tuple(warnings),
    )


def _find_energies(state: Any) -> tuple[float, float, float]:
    """Return the plastic work, the energy of the residual stress, and that of the pressure, of both bodies, J."""
    numbers = [pair for added in state.added for pair in added.list_numbers(state).items()]
    work, left = (
        sum(value[0] for name, value in numbers if name.startswith(word))
        for word in ("plastic_work", "residual_energy")
    )
    pressed = 0.5 * float(np.einsum("xy,xy->", state.pressure, state.displacement)) * state.grid.cell_area
    return work, left, pressed


def _divide_force(force: float, area: rc.Estimate) -> rc.Estimate:
    pressure = force / area.value
    return rc.Estimate(pressure, pressure * area.uncertainty / area.value, "Pa", area.warnings)


def _read_area(state: Any, stiffness: rc.Estimate, step_error: float) -> rc.Estimate:
    """Return the area of the indenter at the contact depth of Oliver and Pharr, m2."""
    sunk = _EDGE_FACTOR * state.force / stiffness.value
    depth = state.approach - sunk
    error = math.hypot(step_error, sunk * stiffness.uncertainty / stiffness.value)
    find_area: Callable[[float], float] = partial(_find_area_below, _refine(state.origin.scene.initial_gap), state.grid)
    value = find_area(depth)
    spread = 0.5 * (find_area(depth + error) - find_area(depth - error))
    warnings = []
    if value >= 0.5 * state.grid.area:
        text = "at its contact depth the indenter is wider than half the grid: choose a larger one"
        warnings.append(WarningText(text, "grid"))
    if not value > 0.0:
        raise rc.InputError("At the contact depth by Oliver and Pharr the indenter has no area: refine the grid.")
    return rc.Estimate(value, spread, "m2", tuple(warnings))


def _find_area_below(gap: Array, grid: rc.Grid, depth: float) -> float:
    return float(np.count_nonzero(gap < depth)) / gap.size * grid.area


def _refine(gap: Array) -> Array:
    """Return a gap at more points in each cell, by cubic splines, shape (8 nx, 8 ny), m."""
    for axis in (0, 1):
        count = gap.shape[axis]
        inner = (np.arange(_POINTS * count) + 0.5) / _POINTS - 0.5
        gap = scipy.interpolate.make_interp_spline(np.arange(float(count)), gap, k=min(3, count - 1), axis=axis)(inner)
    return np.asarray(gap)
