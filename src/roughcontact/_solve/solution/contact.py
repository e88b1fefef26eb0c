"""The solution of a contact: its fields, its certificate, and the answers derived from them."""

from __future__ import annotations

import os
from typing import Any

import attrs

from roughcontact._base import checks
from roughcontact._base.registry import find_view
from roughcontact._base.tables import Result
from roughcontact._solve.solution import storage
from roughcontact._solve.solution.named_responses import ContactResponses
from roughcontact._solve.solution.summary import abbreviate, summarize
from roughcontact._solve.solution.writers import describe_as_data, to_pyvista, write_solution
from roughcontact.errors import InputError


@attrs.frozen(eq=False, kw_only=True)
class ContactSolution(Result, ContactResponses):
    """A solved contact: its fields, its certificate, and the answers derived from them.

    With friction it is the end of one step of a path, or steady sliding: beside the normal contact it has ``shear``,
    ``slip``, ``stick`` and the other fields of friction. Of unlike bodies the initial gap is that changed by the
    traction, of like ones that without friction.

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> solution = problem.solve(pressure=100e6)
    >>> solution.pressure.shape
    (32, 32)
    >>> print(solution.status)
    converged: the conditions of contact hold within the tolerance
    >>> print(solution.area())
    (176.341 +- 0.069) µm2, (1.76341 +- 0.00069) % of nominal [blend]
    """

    def verify(self) -> None:
        """Recompute the certificate from the fields, with friction from those of the state before too.

        Raises
        ------
        InputError
            If they contradict each other or the problem, or the solution is from a file: `ContactProblem.verify` takes
            its problem.
        """
        if self.origin is None or self.origin.source is None:
            raise InputError("The solution does not hold its problem: call problem.verify(solution).")
        self.origin.source.verify(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the solution to a file, completely or not at all.

        Parameters
        ----------
        path
            Its ending names one of the registered ``writers``; an existing file is replaced. ``.npz``, or ``.nc`` for
            netCDF with units (extra ``store``), can be loaded again: they hold the fields, shape (nx, ny), under
            their own names, the force, approach and area, the versions of the packages, and the problem: each part by
            its registered name and fields; with friction also the state before, so that it is verified alone.
            A warning names parts whose class is not registered. ``.html`` is the report,
            ``.vti`` image data for ParaView, ``.json`` what `to_dict` returns.

        Raises
        ------
        InputError
            If there is no such folder.
        MissingPackage
            If netCDF is asked for without its packages.
        """
        write_solution(self, checks.path(path, "The file"))

    def plot(self, panel: Any = None, *, axes: Any = None, dark: bool = False) -> Any:
        """Draw the contact (extra ``plot``).

        Parameters
        ----------
        panel
            Registered name or instance of one panel; None: the four most important ones, side by side.
        axes
            Matplotlib's axes to draw one panel on; None: new ones.
        dark
            Whether the background is dark.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            The axes of one panel, or the figure of several.
        """
        return find_view("panels")("solution", self, panel, axes, checks.flag(dark, "dark="))

    def plot_3d(self, *, exaggeration: float | None = None, dark: bool = False) -> Any:
        """Return a `pyvista.Plotter` of the combined heights in space, coloured by the pressure (extra ``vtk``).

        Heights are drawn `exaggeration` times as high; None: 0.12 domains from peak to valley, at most.
        """
        return find_view("solution-3d")(self, exaggeration, dark)

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
            Whether to build the problem and recompute displacement and residuals from the pressure: the time of one
            convolution. False takes them from the file.

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

    def to_dict(self) -> dict[str, Any]:
        """Return answers with uncertainty and unit, certificate, warnings and inputs as plain data, in SI units.

        Its types are those of JSON; what is not known is None. ``roughcontact solve --json`` prints the same.
        """
        return describe_as_data(self)

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
        return summarize(self, [one for one in self._maps if not one.periodic], self._materials)

    def __repr__(self) -> str:
        return abbreviate(self)
