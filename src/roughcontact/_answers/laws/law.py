"""A law of an interface, and its files for other programs."""

from __future__ import annotations

import os
from typing import Any

import attrs

from roughcontact._answers.laws import formats
from roughcontact._answers.laws.columns import LawTable
from roughcontact._base import checks
from roughcontact._base.archive import replacing
from roughcontact._base.registry import find_view
from roughcontact._base.units import counted, si
from roughcontact.errors import InputError


@attrs.frozen(eq=False)
class InterfaceLaw(LawTable):
    """The properties of a nominally flat interface over the nominal mean pressure, and files of them.

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


def _write(path: str | os.PathLike[str], lines: list[str]) -> None:
    with replacing(checks.path(path, "The file")) as partial:
        partial.write_text("\n".join([*lines, ""]), encoding="ascii", errors="replace", newline="\n")
