"""Laws: a physics of one's own as a value of a problem."""

from __future__ import annotations

import abc
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeAlias

import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import Part
from roughcontact._base.registry import Registry
from roughcontact._base.units import Estimate
from roughcontact._parts.grid import Load
from roughcontact._parts.kernels import InfluenceKernel
from roughcontact._solve.solution.additions import Condition
from roughcontact._solve.solution.load_increment import LoadIncrement

# Arrays by name, of shape (nx, ny) but for coupled processes: what a law remembers.
Memory: TypeAlias = Mapping[str, Array]


class Law(Part, abc.ABC):
    """A physics of your own: what it changes of a contact, and what it adds to its state.

    A problem takes laws as ``laws=``. Its states print, save, draw and judge what they add; a class that is registered
    in `roughcontact.laws`, or listed under the entry points ``roughcontact.laws``, may come from files.

    Examples
    --------
    A lubricant of given pressure in the whole gap presses the surfaces apart:

    >>> import attrs
    >>> import roughcontact as rc
    >>> @attrs.frozen
    ... class Lubricant(rc.Law):
    ...     pressure: float = attrs.field(metadata={"unit": "Pa"})
    ...     def change_gap(self, problem, increment, memory):
    ...         rest = problem.initial_gap > 1e-7
    ...         return problem.displace(rest * self.pressure)
    ...     def list_numbers(self, state, memory):
    ...         carried = self.pressure * float((state.initial_gap > 1e-7).sum()) * state.grid.cell_area
    ...         return {"lubricant_load": (carried, "N")}
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), laws=Lubricant("2MPa"))
    >>> problem.solve(force=1.0).certificate.error < 1e-5
    True
    """

    rates: ClassVar[tuple[str, ...]] = ("time", "sliding", "slip")
    """What passes between two states, and changes something by it: a path refuses what no law of a problem names.

    Slip passes along a path with friction: a state has it with its traction.
    """

    keeps_modulus: ClassVar[bool] = True
    """Whether `find_stiffening` is one whatever passes: answers by the modulus of the problem hold then."""

    default_area: ClassVar[str] = ""
    """Registered name of the area estimator that holds where it has changed the surfaces; empty: the usual one.

    Of a `Process` it is ``"level-set"``, unless it says otherwise.
    """

    follows_bodies: ClassVar[bool] = False
    """Whether it knows `LoadIncrement.shift`: what it remembers of the counterbody moves with it."""

    of_material: ClassVar[bool] = False
    """Whether materials alone bring it to a problem, by `Material.bring_laws`."""

    @abc.abstractmethod
    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return what it adds to the gap before deformation, shape (nx, ny), m.

        Parameters
        ----------
        problem
            The `ContactProblem`.
        increment
            What changes from the state before to this one.
        memory
            What it remembers of the increments before; empty of a law that does not remember.
        """

    def find_local_compliance(self, problem: Any, increment: LoadIncrement, memory: Memory) -> float | Array:
        """Return what the pressure on a cell adds to the gap there, m/Pa, at least zero: one number, or (nx, ny).

        By default nothing. A rate law solves an increment implicitly so, as `Archard` does.
        """
        return 0.0

    def find_stiffening(self, problem: Any, increment: LoadIncrement, memory: Memory) -> float:
        """Return the contact modulus in the increment over that of the problem, above zero; by default one."""
        return 1.0

    def respond(self, problem: Any, displacement: Array) -> Array:
        """Return what the displacement by the pressure itself, shape (nx, ny), m, adds to the gap; by default nothing.

        A law that defines it, such as `SteadySliding`, lets contacts be solved by turns with what they add.
        """
        return np.zeros(displacement.shape)

    def soften(self, problem: Any) -> InfluenceKernel:
        """Return the kernel for these contacts, the nearest one to that with `respond`; by default the problem's."""
        kernel: InfluenceKernel = problem.plan.kernel
        return kernel

    def list_numbers(self, state: Any, memory: Memory) -> Mapping[str, Estimate | tuple[float, str]]:
        """Return its numbers of a `ContactSolution` by name: estimates, or a number with its unit."""
        return {}

    def list_errors(self, state: Any, memory: Memory) -> Mapping[str, float]:
        """Return what it adds to the uncertainty of ``"area"`` and of responses, by registered name, in their unit."""
        return {}

    def explain_limits(self, memory: Memory) -> Mapping[str, str]:
        """Return which responses do not know what it does below a surface, and why, in words, by `Response.fails_with`.

        By default none. A law that leaves a stress there says so under ``"inner stress"``, one that may change it as
        the load changes under ``"inner flow"``, and one that changes the moduli there under ``"inner moduli"``.
        """
        return {}

    def explain_work(self, problem: Any, load: Load | None) -> Iterable[tuple[str, str]]:
        """Return what it takes of a solve, in rows of the plan: a word, and what it says; by default nothing.

        A text that is a `WorkText` says what the row takes in numbers, too.

        Parameters
        ----------
        problem
            The `ContactProblem`.
        load
            The load of the solve; None: it is not known.
        """
        return ()

    def list_conditions(self, state: Any, memory: Memory) -> Iterable[Condition]:
        """Return its conditions of the certificate, recomputed from the fields of a state."""
        return ()


class Process(Law):
    """A law that remembers: what a contact changes of the surfaces, from one load to the next.

    Attributes
    ----------
    remembered
        The fields that it remembers, zero on fresh surfaces: meaning and unit by name.
    left_behind
        What it remembers of bodies that is not in their heights, in words: `LoadPath.bodies` warns of it.

    Examples
    --------
    Summits that are worn by the pressure (Archard) over a sliding distance for each load:

    >>> import attrs
    >>> import roughcontact as rc
    >>> @attrs.frozen
    ... class Wear(rc.Process):
    ...     rate: float = attrs.field(metadata={"unit": "m/Pa"})
    ...     remembered = {"height_loss": ("height lost by wear", "m")}
    ...     def change_gap(self, problem, increment, memory):
    ...         return memory["height_loss"]
    ...     def remember(self, state, increment, memory):
    ...         return {"height_loss": memory["height_loss"] + self.rate * state.pressure}
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), laws=Wear(1e-17))
    >>> peaks = [state.pressure.max() for state in problem.sweep(force=[1.0, 1.0, 1.0])]
    >>> [f"{peak / 1e9:.2f} GPa" for peak in peaks]
    ['2.16 GPa', '1.96 GPa', '1.78 GPa']
    """

    remembered: ClassVar[Mapping[str, tuple[str, str]]]
    left_behind: ClassVar[str] = ""

    # What loads leave is not a summit, whose curvature tells the area.
    default_area: ClassVar[str] = "level-set"

    def divide(self, problem: Any, memory: Memory) -> tuple[float | Array, float | Array]:
        """Return what body and counterbody have lost of their heights, numbers or of shape (nx, ny), m.

        By default nothing: a process that changes them says so for `LoadPath.bodies`.
        """
        return 0.0, 0.0

    @abc.abstractmethod
    def remember(self, state: Any, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return what it remembers after an increment, arrays of shape (nx, ny) by name.

        Parameters
        ----------
        state
            The `ContactSolution` at its end.
        increment
            What has changed in it.
        memory
            What it remembers of those before.
        """


class Press(Protocol):
    """A contact on the gap with an offset, as a coupled process asks for it."""

    def __call__(
        self, offset: Array, *, part: float = 1.0, start: Array | None = None, tolerance: float | None = None
    ) -> Any:
        """Return the contact, a `ContactSolution`.

        Parameters
        ----------
        offset
            What the process adds to the gap before deformation, shape (nx, ny), m.
        part
            The part of the change of the load in the increment, above zero to one.
        start
            The pressure to start from, shape (nx, ny), Pa; None: that of the contact before.
        tolerance
            The tolerance of the solver; None: that of the problem.
        """


class CoupledProcess(Process):
    """A process that is solved together with the contact: what it changes depends on the pressure that it changes.

    It finds what it remembers at the end of an increment by contacts of its own, and judges it. It may remember arrays
    of any shape.

    Examples
    --------
    Springs behind the body, whose deflection is solved with the contact:

    >>> import attrs
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> @attrs.frozen
    ... class Spring(rc.CoupledProcess):
    ...     stiffness: float = attrs.field(metadata={"unit": "N/m"})
    ...     remembered = {"deflection": ("deflection of the spring", "m")}
    ...     def start(self, problem):
    ...         return {"deflection": np.zeros(1)}
    ...     def change_gap(self, problem, increment, memory):
    ...         return np.full(problem.plan.grid.shape, memory["deflection"][0])
    ...     def settle(self, problem, press, increment, memory):
    ...         force = press(self.change_gap(problem, increment, memory)).force
    ...         return {"deflection": np.array([force / self.stiffness])}
    ...     def judge(self, problem, state, increment, before, after):
    ...         error = abs(state.force / self.stiffness - after["deflection"][0]) / problem.initial_gap.max()
    ...         return [rc.results.Condition("spring", error, "error of the deflection over the largest gap")]
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6), laws=Spring(2e6))
    >>> f"{problem.solve(force=1.0).approach * 1e6:.2f} µm"
    '0.72 µm'
    """

    @abc.abstractmethod
    def start(self, problem: Any) -> Memory:
        """Return what it remembers of fresh surfaces, arrays of any shape by the names of `remembered`."""

    @abc.abstractmethod
    def settle(self, problem: Any, press: Press, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return what it remembers after an increment.

        `change_gap` by it is then the offset of the state, whose contact is solved once more.

        Parameters
        ----------
        problem
            The `ContactProblem`.
        press
            Solves the contact for an offset that it tries.
        increment
            What changes from the state before to this one.
        memory
            What it remembers of the increments before.
        """

    @abc.abstractmethod
    def judge(
        self, problem: Any, state: Any, increment: LoadIncrement, before: Memory, after: Memory
    ) -> Iterable[Condition]:
        """Return its conditions of the certificate, recomputed from the fields of a state and both memories."""

    def remember(self, state: Any, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return a memory as it is: `settle` has found that after the increment."""
        return memory

    def join(self, other: CoupledProcess) -> CoupledProcess | None:
        """Return the process that is this one and another one of a contact, solved together; by default None.

        So the materials of body and counterbody may each bring one (`Material.bring_laws`), though a contact is solved
        with one alone.
        """
        return None


laws: Registry[Law] = Registry(Law, "law", "roughcontact.laws")


def join_laws(brought: Sequence[Law]) -> tuple[Law, ...]:
    """Return laws that materials bring, those in one that are solved together."""
    found: list[Law] = []
    for law in brought:
        for place, other in enumerate(found):
            both = other.join(law) if isinstance(other, CoupledProcess) and isinstance(law, CoupledProcess) else None
            if both is not None:
                found[place] = both
                break
        else:
            found.append(law)
    return tuple(found)


def as_laws(given: object) -> tuple[Law, ...]:
    """Return the laws of a problem, which may be given as one, as registered names, or as a sequence of them."""
    one = isinstance(given, (str, Law)) or not isinstance(given, Sequence)
    found: tuple[Any, ...] = (given,) if one else tuple(given)  # type: ignore[arg-type]
    return tuple(laws.resolve(law) for law in found)
