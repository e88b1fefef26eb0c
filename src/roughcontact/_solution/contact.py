"""What a solve returns: the fields, the certificate and the quantities derived from them; how it is kept and shown."""

from __future__ import annotations

import os
from typing import Any

import attrs

from roughcontact import checks
from roughcontact._solution import storage
from roughcontact._solution.answers import ContactAnswers
from roughcontact._solution.summary import abbreviate, summarize
from roughcontact._solution.vti import to_pyvista, view_solution
from roughcontact._solution.writers import write_solution, writers
from roughcontact.archive import replacing
from roughcontact.panel import Panel
from roughcontact.panel.figures import plot


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution(ContactAnswers):
    """A solved contact: its fields, the certificate, and all that is asked of them."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file, completely or not at all.

        Parameters
        ----------
        path
            Its ending names one of the registered ``writers``; an existing file is replaced. ``.npz``, or ``.nc`` for
            netCDF with units (extra ``store``), can be loaded again: they hold the fields, shape (nx, ny), under
            their own names, the force, approach and area, the versions of the packages, and the problem: each part
            by its registered name and fields. Python warns of a part whose class is not registered. ``.html`` is the
            report, ``.vti`` image data for ParaView.

        Raises
        ------
        InputError
            If there is no such folder.
        MissingPackage
            If netCDF is asked for without its packages.
        """
        write_solution(self, checks.path(path, "The file"))

    def to_html(self, path: str | os.PathLike[str] | None = None) -> str:
        """Return a report, one page of HTML that opens without a network; written to a file if a path is given."""
        target = None if path is None else checks.path(path, "The report")
        writer: Any = writers.create("html")
        # Its figures take seconds: they are drawn once.
        text: str = writer.text(self)
        if target is not None:
            with replacing(target) as partial:
                partial.write_text(text, encoding="utf-8")
        return text

    def plot(self, panel: str | Panel | None = None, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the contact (extra ``plot``).

        Parameters
        ----------
        panel
            Registered name or instance of one panel; None: the four that say most, side by side.
        axes
            Matplotlib's axes to draw one panel on; None: new ones.
        dark
            Whether the background is dark.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            The axes of one panel, or the figure of several.
        """
        return plot("solution", self, panel, axes, checks.flag(dark, "dark="))

    def plot_3d(self, *, exaggeration: float | None = None, dark: bool = False) -> Any:
        """Return the combined heights as a relief in perspective, coloured by the pressure (extra ``vtk``).

        Parameters
        ----------
        exaggeration
            How many times as high the heights are drawn; None: 1, 2 or 5 times a power of ten, so that the relief
            is a tenth as high as the domain is long, at most.
        dark
            Whether the background is dark.

        Returns
        -------
        pyvista.Plotter
            Its `show` opens a window, in a notebook a picture; its `screenshot` writes a file.
        """
        return view_solution(self, exaggeration, dark)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, verify: bool = True) -> ContactSolution:
        """Return the solution in a file that `save` has written.

        Its problem can be solved again with ``ContactProblem(**solution.origin.problem)``, once the classes
        that ``solution.origin.missing`` names are registered. A file cannot run code: only registered
        classes and public ones of this package are built.

        Parameters
        ----------
        path
            The file.
        verify
            Whether to build the problem and recompute displacement and residuals from the pressure: the time of
            one convolution. False takes them as the file gives them.

        Raises
        ------
        InputError
            If there is no such file, or it is damaged, of another kind or of another format; if its content
            contradicts itself, or cannot be verified because a class of the problem is not registered.
        """
        file = checks.path(path, "The file")
        solution = cls(**storage.read(file))
        if checks.flag(verify, "verify="):
            storage.verify(file, solution)
        return solution

    def to_xarray(self) -> Any:
        """Return the solution as an `xarray.Dataset` over x and y, m, with units (extra ``store``)."""
        return storage.to_xarray(self)

    def to_pyvista(self) -> Any:
        """Return the solution as `pyvista.ImageData`, for views in three dimensions (extra ``vtk``).

        Its cells, in the plane z = 0 about the centre of the domain, have ``pressure``, Pa, ``gap``, ``initial_gap``,
        ``displacement`` and the ``heights`` of the body, m, and ``contact``; the scalars, as ``force``, are field data.
        """
        return to_pyvista(self)

    def __str__(self) -> str:
        return summarize(self, self._measured, self._materials)

    def __repr__(self) -> str:
        return abbreviate(self)

    def _repr_html_(self) -> str:
        writer: Any = writers.create("html")
        text: str = writer.table(self)
        return text
