"""A law of an interface: columns over the load, each with its uncertainty, and power laws where they hold."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.laws import formats
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Estimate, ShownAsPrinted, counted, outlined, si
from roughcontact.errors import InputError

# Misfit that is allowed whatever the uncertainties, both over the value and over its change in the range.
_ALLOWED_MISFIT = 0.01
# Smallest number of loads of a power law, and smallest ratio of the last to the first: in a shorter range a power law
# fits any smooth curve.
_MIN_FITTED_LOADS = 4
_MIN_LOAD_RANGE = 10.0


@attrs.frozen
class PowerFit(ShownAsPrinted):
    """A power law of the pressure, value = `factor` (pressure / `pivot`)^`exponent`, and where it holds.

    Attributes
    ----------
    exponent, exponent_std
        The exponent and its standard deviation, from the uncertainties of the values and the misfit.
    factor
        The value at the pivot, in the unit of the column.
    pivot
        The geometric mean of the loads that were fitted, Pa.
    pressures
        The lowest and highest load of the range, Pa, in which the law is within the uncertainties or 1 %.
    loads
        Loads in it.
    misfit
        Maximum relative misfit in it.
    """

    exponent: float
    exponent_std: float
    factor: float
    pivot: float
    pressures: Pair
    loads: int
    misfit: float

    def __str__(self) -> str:
        low, high = (si(pressure, "Pa") for pressure in self.pressures)
        exponent = f"pressure^({self.exponent:.3f} +- {self.exponent_std:.1g})"
        return f"{exponent} from {low} to {high}, within {100.0 * self.misfit:.1g} %"


def fit_power(pressures: Array, values: Array, uncertainties: Array) -> PowerFit | None:
    """Return the power law over the widest range of neighbouring loads in which it holds; None without one.

    It holds where every value is within its uncertainty of the weighted least-squares line of the logarithms, or within
    1 % of the value and of its change over the range.
    """
    usable = np.isfinite(values) & (values > 0.0) & np.isfinite(uncertainties)
    best: PowerFit | None = None
    widest = 0.0
    for first in range(pressures.size):
        for last in range(pressures.size, first + _MIN_FITTED_LOADS - 1, -1):
            chosen = slice(first, last)
            ratio = float(pressures[last - 1] / pressures[first])
            if ratio < _MIN_LOAD_RANGE * (1.0 - 1e-9) or ratio <= widest or not usable[chosen].all():
                continue
            found = _fit(pressures[chosen], values[chosen], uncertainties[chosen] / values[chosen])
            if found is not None:
                best = found
                widest = ratio
                break
    return best


def _fit(pressures: Array, values: Array, relative: Array) -> PowerFit | None:
    """Return the line through the logarithms of all these values; None if one of them is off."""
    x = np.log(pressures)
    y = np.log(values)
    allowed = np.maximum(relative, _ALLOWED_MISFIT)
    weights = 1.0 / allowed**2
    pivot, level = (float(np.average(each, weights=weights)) for each in (x, y))
    spread = float(np.sum(weights * (x - pivot) ** 2))
    exponent = float(np.sum(weights * (x - pivot) * (y - level))) / spread
    misfit = y - level - exponent * (x - pivot)
    change = min(1.0, abs(exponent) * float(x[-1] - x[0]))
    if (np.abs(misfit) > np.maximum(relative, _ALLOWED_MISFIT * change)).any():
        return None
    variance = relative**2 + float(np.sum(misfit**2)) / (x.size - 2)
    std = math.sqrt(float(np.sum((weights * (x - pivot)) ** 2 * variance))) / spread
    middle = float(np.mean(x))
    factor = math.exp(level + exponent * (middle - pivot))
    ends = float(pressures[0]), float(pressures[-1])
    return PowerFit(exponent, std, factor, math.exp(middle), ends, x.size, float(np.abs(misfit).max()))


@attrs.frozen(eq=False)
class LawColumn:
    """A quantity over the load.

    Attributes
    ----------
    name, unit
        Its name, and its SI unit; empty for a ratio.
    values
        Shape (loads,), in the unit.
    uncertainties
        One standard deviation of each value, shape (loads,), in the unit.
    """

    name: str
    unit: str
    values: Array = attrs.field(converter=read_only, repr=outlined)
    uncertainties: Array = attrs.field(converter=read_only, repr=outlined)


@attrs.frozen(eq=False)
class InterfaceLaw(TableResult):
    """The properties of a nominally flat interface over the nominal mean pressure.

    Attributes
    ----------
    pressures
        Nominal mean pressures, shape (loads,), Pa, ascending.
    columns
        The quantities by name: ``"area"``, the real over the nominal contact area; ``"mean_gap"``, m; and what was
        asked, over nominal area where it is in proportion to it.
    description
        What was solved, in sentences.
    warnings
        Why the law must not be trusted, in sentences with their loads; empty without a reason.
    """

    pressures: Array = attrs.field(converter=read_only)
    columns: Mapping[str, LawColumn]
    description: tuple[str, ...]
    warnings: tuple[str, ...]

    def __getitem__(self, name: str) -> LawColumn:
        if name not in self.columns:
            raise InputError.unknown("column of the law", name, self.columns)
        return self.columns[name]

    def fit(self, name: str) -> PowerFit | None:
        """Return the power law of a column over the widest range of loads in which it holds; None without one.

        It holds where all values are within their uncertainties, or 1 %, over a decade and four loads at least.
        """
        column = self[name]
        return fit_power(self.pressures, column.values, column.uncertainties)

    def table(self) -> Table:
        """Return a row for each load; see `roughcontact.typing.Table`."""
        columns: dict[str, Any] = {"pressure": self.pressures}
        for name, column in self.columns.items():
            pairs = zip(column.values.tolist(), column.uncertainties.tolist(), strict=True)
            columns[name] = [Estimate(value, uncertainty, column.unit) for value, uncertainty in pairs]
        return Table(columns, {"pressure": "Pa"})

    def _list_head(self) -> Sequence[str]:
        return self.description

    def _list_notes(self) -> Sequence[str]:
        fits = {name: self.fit(name) for name in self.columns}
        return [f"{name}: {found}" for name, found in fits.items() if found is not None]

    def to_table(self) -> dict[str, Array]:
        """Return all numbers by the names of their columns, ``pressure``, ``area``, ``area_uncertainty`` and so on."""
        table = {"pressure": self.pressures}
        for name, column in self.columns.items():
            table |= {name: column.values, f"{name}_uncertainty": column.uncertainties}
        return table

    def __repr__(self) -> str:
        low, high = (si(float(pressure), "Pa") for pressure in self.pressures[[0, -1]])
        return f"<InterfaceLaw {counted(len(self.pressures), 'load')}, {low} to {high}: {', '.join(self.columns)}>"

    def to_abaqus(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str | None = "conductance",
        electrical: bool = False,
        units: str = "SI",
    ) -> None:
        """Write a surface interaction for Abaqus: pressure over closure and, if it is a column, the conductance.

        Include the file in the model data, ``*INCLUDE, INPUT=...``, and name the interaction in ``*CONTACT PAIR``.

        Parameters
        ----------
        path
            The file; it may replace one.
        name
            Name of the surface interaction.
        conductance
            Column of the conductance; None: none, as where the law does not have the column ``"conductance"``.
        electrical
            Whether it is an electrical one, of conductivities in S/m.
        units
            ``"SI"``, or ``"mm"``: mm, N, tonne, s, K, in which a pressure is in MPa.
        """
        _write(path, formats.write_abaqus(self, name, conductance, electrical, units))

    def to_ansys(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str = "conductance",
        units: str = "SI",
    ) -> None:
        """Write the thermal conductance over the contact pressure for Ansys, as commands of Mechanical APDL.

        They make a table and give it to the contact elements of the set of real constants ``cid``: read the file with
        ``/INPUT``, or paste it into a command object below a contact of Workbench.

        Parameters
        ----------
        path
            The file; it may replace one.
        name
            Name of the table.
        conductance
            Column of the conductance.
        units
            As of `to_abaqus`.
        """
        _write(path, formats.write_ansys(self, name, conductance, units))

    def to_calculix(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "ROUGH",
        conductance: str | None = "conductance",
        units: str = "SI",
    ) -> None:
        """Write a surface interaction for CalculiX; include it before the first step. See `to_abaqus`.

        A row whose overclosure is less than 1e-10 above the one before is omitted: CalculiX would change it.
        """
        _write(path, formats.write_calculix(self, name, conductance, units))

    def to_comsol(
        self,
        path: str | os.PathLike[str],
        *,
        table: str = "conductance",
        conductance: str = "conductance",
        units: str = "SI",
    ) -> None:
        """Write a table for an interpolation function of COMSOL Multiphysics, in the spreadsheet format.

        Choose linear interpolation, and the units that the file states for argument and function.

        Parameters
        ----------
        path
            The file, such as ``.txt``; it may replace one.
        table
            ``"conductance"``: conductance over pressure; ``"closure"``: pressure over closure.
        conductance
            Column of the conductance.
        units
            As of `to_abaqus`.
        """
        _write(path, formats.write_comsol(self, table, conductance, units))

    def to_moose(
        self,
        path: str | os.PathLike[str],
        *,
        name: str = "rough",
        conductance: str = "conductance",
        min_gap: float = 1e-6,
        units: str = "SI",
    ) -> None:
        """Write the conductance for MOOSE: a table of a `PiecewiseLinear` function, and the blocks that read it.

        Parameters
        ----------
        path
            The table, ``.csv``; the blocks are written beside it with the ending ``.i``. Both may replace files.
        name
            Name of the function, and of the contact.
        conductance
            Column of the thermal conductance.
        min_gap
            Distance below which MOOSE counts the gap as closed, m.
        units
            As of `to_abaqus`.
        """
        target = checks.path(path, "The table")
        if target.suffix != ".csv":
            raise InputError.about("The table of MOOSE", str(target), "a file that ends in .csv")
        table, blocks = formats.write_moose(self, target.name, name, conductance, min_gap, units)
        _write(target, table)
        _write(target.with_suffix(".i"), blocks)

    def plot(self, column: str = "stiffness", axes: Any = None, *, dark: bool = False) -> Any:
        """Draw a column over the pressure with a band of two standard deviations, and its power law (extra ``plot``).

        Parameters
        ----------
        column
            Name of the column.
        axes
            Matplotlib's axes to draw on; None: new ones.
        dark
            Whether new axes are for a dark page.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return find_view("law")(self.pressures, self[column], self.fit(column), axes, checks.flag(dark, "dark="))


def interpolation_warning(pressures: Array, largest: float) -> tuple[str, ...]:
    """Return a warning if neighbouring loads differ by more than a factor."""
    ratio = float(np.max(pressures[1:] / pressures[:-1], initial=1.0))
    if ratio <= largest * (1.0 + 1e-9):
        return ()
    text = f"Neighbouring loads differ by up to {ratio:.3g} times. Programs that draw straight lines between them"
    return (f"{text} may be off by more than 1 %: take ratios of at most {largest:g}.",)


def _write(path: str | os.PathLike[str], lines: list[str]) -> None:
    with replacing(checks.path(path, "The file")) as partial:
        partial.write_text("\n".join([*lines, ""]), encoding="ascii", errors="replace", newline="\n")
