"""The columns of a law of an interface, each with its uncertainty, and power laws of the load where they hold."""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from roughcontact._base.arrays import Array, Pair, read_only
from roughcontact._base.tables import Table, TableResult
from roughcontact._base.units import Estimate, ShownAsPrinted, outlined, si
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
    """A quantity over the load, or over the separation.

    Attributes
    ----------
    name, unit
        Its name, and its SI unit; empty for a ratio.
    values
        Shape (rows,), in the unit.
    uncertainties
        One standard deviation of each value by the grid, shape (rows,), in the unit.
    sampling
        One standard deviation between places of the surface, shape (rows,), in the unit; None where it is not known.
    """

    name: str
    unit: str
    values: Array = attrs.field(converter=read_only, repr=outlined)
    uncertainties: Array = attrs.field(converter=read_only, repr=outlined)
    sampling: Array | None = attrs.field(default=None, converter=attrs.converters.optional(read_only), repr=outlined)


class ColumnTable(TableResult):
    """Columns with uncertainties over a load or a separation, which the files of a law hold."""

    __slots__ = ()

    columns: Mapping[str, LawColumn]
    description: tuple[str, ...]
    warnings: tuple[str, ...]

    @abc.abstractmethod
    def _list_rows(self) -> Mapping[str, tuple[str, Array]]:
        """Return unit and values of what the columns are given over, by name."""

    def __getitem__(self, name: str) -> LawColumn:
        if name not in self.columns:
            raise InputError.unknown("column of the law", name, self.columns)
        return self.columns[name]

    def table(self) -> Table:
        """Return all rows; see `roughcontact.typing.Table`."""
        units = {name: unit for name, (unit, _) in self._list_rows().items() if unit}
        columns: dict[str, Any] = {name: values for name, (_, values) in self._list_rows().items()}
        for name, column in self.columns.items():
            pairs = zip(column.values.tolist(), column.uncertainties.tolist(), strict=True)
            columns[name] = [Estimate(value, uncertainty, column.unit) for value, uncertainty in pairs]
            if column.sampling is not None:
                columns[f"{name}_sampling"] = column.sampling
                units[f"{name}_sampling"] = column.unit
        return Table(columns, units)

    def to_table(self) -> dict[str, Array]:
        """Return all numbers by the names of their columns, such as ``area``, ``area_uncertainty``."""
        table = {name: values for name, (_, values) in self._list_rows().items()}
        for name, column in self.columns.items():
            table |= {name: column.values, f"{name}_uncertainty": column.uncertainties}
            table |= {} if column.sampling is None else {f"{name}_sampling": column.sampling}
        return table

    def _list_head(self) -> Sequence[str]:
        return self.description


@attrs.frozen(eq=False)
class LawTable(ColumnTable):
    """The columns of a law of an interface over the load; see `InterfaceLaw`."""

    pressures: Array = attrs.field(converter=read_only)
    columns: Mapping[str, LawColumn]
    description: tuple[str, ...]
    warnings: tuple[str, ...]

    def _list_rows(self) -> Mapping[str, tuple[str, Array]]:
        return {"pressure": ("Pa", self.pressures)}

    def fit(self, name: str) -> PowerFit | None:
        """Return the power law of a column over the widest range of loads in which it holds; None without one.

        It holds where all values are within their uncertainties, or 1 %, over a decade and four loads at least.
        """
        column = self[name]
        return fit_power(self.pressures, column.values, column.uncertainties)

    def _list_notes(self) -> Sequence[str]:
        fits = {name: self.fit(name) for name in self.columns}
        return [f"{name}: {found}" for name, found in fits.items() if found is not None]


def interpolation_warning(pressures: Array, largest: float) -> tuple[str, ...]:
    """Return a warning if neighbouring loads differ by more than a factor."""
    ratio = float(np.max(pressures[1:] / pressures[:-1], initial=1.0))
    if ratio <= largest * (1.0 + 1e-9):
        return ()
    text = f"Neighbouring loads differ by up to {ratio:.3g} times. Programs that draw straight lines between them"
    return (f"{text} may be off by more than 1 %: take ratios of at most {largest:g}.",)
