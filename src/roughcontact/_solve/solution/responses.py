"""What a contact does, asked of its solution: the base class and the registry."""

from __future__ import annotations

import abc
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from roughcontact._base.registry import Registry

if TYPE_CHECKING:
    from roughcontact._solve.solution.contact import ContactSolution

T_co = TypeVar("T_co", covariant=True)


class Response(abc.ABC, Generic[T_co]):
    """What a contact does: its answer to a small change, a current, a flow. Subclass it and define `respond`.

    What is asked beside the contact, a conductivity or depths, are fields of the subclass.

    Attributes
    ----------
    depends_on_place
        Whether its number changes where a periodic contact is shifted, as a flow between two sides does.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class OpenVolume(rc.Response):
    ...     def respond(self, solution):
    ...         volume = float(solution.gap.sum()) * solution.grid.cell_area
    ...         return rc.Estimate(volume, 0.01 * volume, "m3")
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> body = rc.Body(wave, rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(problem.solve(pressure=100e6).response(OpenVolume()))
    18139 µm3 +- 1 %
    """

    depends_on_place: ClassVar[bool] = False

    @abc.abstractmethod
    def respond(self, solution: ContactSolution) -> T_co:
        """Return the response: an `Estimate`, or an object that says its uncertainty and warnings.

        Raises
        ------
        InputError
            If it means nothing for this contact: the sentence says why.
        """


responses: Registry[Response[Any]] = Registry(Response, "response", "roughcontact.responses")
