"""Wear by sliding and by slip, as processes that remember the heights that are lost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from roughcontact._base.arrays import Array, restore_state
from roughcontact._base.checks import choice, number_or_array
from roughcontact._base.units import Estimate
from roughcontact._solve.solution.contact import ContactSolution
from roughcontact._solve.solution.laws import Memory, Process
from roughcontact._solve.solution.load_increment import LoadIncrement


def _coefficient(value: object) -> float | Array:
    return number_or_array(value, "The wear coefficient", "m2/N", zero=True)


def _energy_coefficient(value: object) -> float | Array:
    return number_or_array(value, "The wear coefficient", "m3/J", zero=True)


def _side(value: object) -> str:
    return choice(value, "The body that wears", ("body", "counterbody"))


def _divide_worn(of: str, memory: Memory) -> tuple[float | Array, float | Array]:
    worn = memory["worn_height"]
    return (worn, 0.0) if of == "body" else (0.0, worn)


def _measure_worn(state: ContactSolution, memory: Memory) -> dict[str, Estimate | tuple[float, str]]:
    worn = memory["worn_height"]
    return {
        "worn_volume": (float(worn.sum()) * state.grid.cell_area, "m3"),
        "wear_depth": (float(worn.max()), "m"),
    }


@attrs.frozen(eq=False)
class Archard(Process):
    r"""Wear in proportion to the pressure and the sliding distance: :math:`dw/ds = k p`.

    The height w is lost where the contact is. Along a path with ``shift=`` the counterbody moves over the body, and
    each keeps its wear in its own frame; else the contact does not move over the surface that wears, as on a pin on a
    disc, or in fretting. An increment is solved by the trapezoidal rule,
    :math:`w = w_0 + \tfrac{1}{2} k \, \Delta s \, (p_0 + p)`, implicitly: the pressure p at its end takes part in
    the contact as a local compliance, so that long increments do not overshoot, as explicit ones do from
    :math:`k \, \Delta s \, E^*` of 1.25 cells on. The volume is :math:`k F s` in each.

    Parameters
    ----------
    coefficient
        Wear coefficient k, volume per force and sliding distance, m2/N: a number, or an array of shape (nx, ny). It is
        Archard's dimensionless coefficient over the hardness.
    of
        The body that loses height: ``"body"`` or ``"counterbody"``.

    References
    ----------
    Archard, J. Appl. Phys. 24 (1953) 981-988, https://doi.org/10.1063/1.1721448

    Examples
    --------
    >>> import roughcontact as rc
    >>> pin = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(pin, grid=rc.Grid((48, 48), 160e-6), laws=rc.Archard("1e-16m2/N"))
    >>> path = problem.path(force=1.0, sliding=["0m", "2m"])
    >>> [f"{state.pressure.max() / 1e9:.2f} GPa" for state in path]
    ['2.16 GPa', '0.67 GPa']
    """

    coefficient: float | Array = attrs.field(converter=_coefficient, metadata={"unit": "m2/N"})
    of: str = attrs.field(default="body", converter=_side)

    __setstate__ = restore_state

    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {
        "worn_height": ("height lost by wear", "m"),
        "worn_pressure": ("pressure at the end of the last increment", "Pa"),
    }

    rates: ClassVar[tuple[str, ...]] = ("sliding",)
    follows_bodies: ClassVar[bool] = True

    # The pressure of a worn contact ends with a finite value, not as a root: estimators by roots give too little area.
    default_area: ClassVar[str] = "cell-count"

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return the height lost before, and by the pressure at the begin of the increment; see `Law.change_gap`."""
        lost = memory["worn_height"] + self._wear(increment) * memory["worn_pressure"]
        return np.asarray(increment.place(lost) if self.of == "counterbody" else lost)

    def find_local_compliance(self, problem: Any, increment: LoadIncrement, memory: Memory) -> float | Array:
        """Return the height lost by the pressure at its end, m/Pa; see `Law.find_local_compliance`."""
        wear = self._wear(increment)
        return increment.place(wear) if self.of == "counterbody" else wear

    def remember(self, state: ContactSolution, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the height lost, m, and the pressure, Pa, after an increment."""
        pressure = state.contact_pressure
        if self.of == "counterbody":
            pressure = np.asarray(increment.place_back(pressure))
        lost = self._wear(increment) * (memory["worn_pressure"] + pressure)
        return {"worn_height": memory["worn_height"] + lost, "worn_pressure": pressure}

    def divide(self, problem: Any, memory: Memory) -> tuple[float | Array, float | Array]:
        """Return the loss of the body that wears."""
        return _divide_worn(self.of, memory)

    def list_numbers(self, state: ContactSolution, memory: Memory) -> Mapping[str, Estimate | tuple[float, str]]:
        """Return the worn volume, m3, and the largest depth, m."""
        return _measure_worn(state, memory)

    def _wear(self, increment: LoadIncrement) -> float | Array:
        """Return the height lost by a pressure at one end of an increment, over that pressure, m/Pa."""
        return 0.5 * increment.sliding * self.coefficient


@attrs.frozen(eq=False)
class EnergyWear(Process):
    r"""Wear in proportion to the energy that friction loses at each place: :math:`dw = \alpha \, q \cdot ds`.

    It is that of fretting, along a path with friction, in partial slip or sliding: q is the traction and ds the slip.
    Where all slides by a coefficient of friction, it is `Archard` with the coefficient :math:`\mu \alpha`. The height
    is lost where the contact is, at the end of each increment.

    Parameters
    ----------
    coefficient
        Wear coefficient, volume per energy, m3/J: a number, or an array of shape (nx, ny).
    of
        The body that loses height: ``"body"`` or ``"counterbody"``.

    References
    ----------
    Fouvry, Kapsa and Vincent, Wear 200 (1996) 186-205, https://doi.org/10.1016/0043-1648(96)07306-1

    Examples
    --------
    A thousand cycles of a ball that slides back and forth:

    >>> import roughcontact as rc
    >>> steel = rc.Elastic(young=210e9, poisson=0.3)
    >>> ball, flat = rc.Body(rc.ParaboloidSurface(radius=1e-3), steel), rc.Body(rc.FlatSurface(), steel)
    >>> problem = rc.ContactProblem(ball, flat, grid=rc.Grid((24, 24), 100e-6), laws=rc.EnergyWear("5e-14m3/J"))
    >>> path = problem.path(force=1.0, displacement=[(1e-6, 0.0), (-1e-6, 0.0)], friction=0.5, cycles=[1, 1000])
    >>> [f"{state.pressure.max() / 1e9:.2f} GPa" for state in path]
    ['1.36 GPa', '1.36 GPa', '1.04 GPa', '1.04 GPa']
    """

    coefficient: float | Array = attrs.field(converter=_energy_coefficient, metadata={"unit": "m3/J"})
    of: str = attrs.field(default="body", converter=_side)

    __setstate__ = restore_state

    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {
        "worn_height": ("height lost by wear", "m"),
        "friction_work": ("energy lost by friction per area", "J/m2"),
    }

    rates: ClassVar[tuple[str, ...]] = ("slip",)
    default_area: ClassVar[str] = "cell-count"

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return the height lost before, m; see `Law.change_gap`."""
        return memory["worn_height"]

    def remember(self, state: ContactSolution, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the height lost, m, and the energy, J/m2, after an increment; without a slip those before."""
        if state.shear is None or state.is_steady:
            return memory
        work = increment.cycles * np.einsum("aij,aij->ij", state.shear, state.slip)
        return {
            "worn_height": memory["worn_height"] + self.coefficient * work,
            "friction_work": memory["friction_work"] + work,
        }

    def divide(self, problem: Any, memory: Memory) -> tuple[float | Array, float | Array]:
        """Return the loss of the body that wears."""
        return _divide_worn(self.of, memory)

    def list_numbers(self, state: ContactSolution, memory: Memory) -> Mapping[str, Estimate | tuple[float, str]]:
        """Return the worn volume, m3, the largest depth, m, and the energy lost by friction, J."""
        lost = float(memory["friction_work"].sum()) * state.grid.cell_area
        return {**_measure_worn(state, memory), "friction_work": (lost, "J")}
