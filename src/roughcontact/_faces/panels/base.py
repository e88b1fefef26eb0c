"""The base class of panels and their registry."""

from __future__ import annotations

import abc
from typing import Any, ClassVar

from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry


class Panel(Part, abc.ABC):
    """One picture, drawn into axes of matplotlib. Subclass it, state the subject, and define `draw`.

    Attributes
    ----------
    subject
        The kind of subject: ``"solution"``, ``"surface"`` (then `draw` gets a `SampledSurface`) or ``"sweep"``.
    needs_adhesion
        Whether it draws only surfaces that attract each other.

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

    @abc.abstractmethod
    def draw(self, subject: Any, axes: Any) -> None:
        """Draw a solution, a surface or a sweep into `matplotlib.axes.Axes`.

        Raises
        ------
        InputError
            If there is nothing to draw: the sentence says why.
        """


panels = Registry(Panel, "panel", "roughcontact.panels", in_files=False)
