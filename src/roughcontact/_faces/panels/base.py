"""The base class of panels and their registry."""

from __future__ import annotations

import abc
from typing import Any, ClassVar

from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry
from roughcontact._solve.solution import Law


class Panel(Part, abc.ABC):
    """One picture, drawn into axes of matplotlib. Subclass it, state the subject, and define `draw`.

    Attributes
    ----------
    subject
        The kind of subject: ``"solution"``, ``"surface"`` (then `draw` gets a `SampledSurface`) or ``"sweep"``.
    needs_adhesion
        Whether it draws only surfaces that attract each other.
    needs_law
        Class of the laws of which it draws what they have changed, of states with such a law alone; None without one.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class Pressures(rc.Panel):
    ...     def draw(self, subject, axes):
    ...         axes.hist(subject.pressure[subject.contact])
    >>> Pressures.subject
    'solution'
    """

    subject: ClassVar[str] = "solution"
    needs_adhesion: ClassVar[bool] = False
    needs_law: ClassVar[type[Law] | None] = None

    @classmethod
    def fits(cls, solution: Any) -> bool:
        """Return whether a `ContactSolution`, or the first one of a sweep, has what it needs."""
        laws = [law for addition in solution.added for law in getattr(addition, "laws", ())]
        has_law = cls.needs_law is None or any(isinstance(law, cls.needs_law) for law in laws)
        return has_law and (solution.tension is not None or not cls.needs_adhesion)

    @abc.abstractmethod
    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution, a surface or a sweep into `matplotlib.axes.Axes`.

        Raises
        ------
        InputError
            If there is nothing to draw: the sentence says why.
        """


panels = Registry(Panel, "panel", "roughcontact.panels", in_files=False)
