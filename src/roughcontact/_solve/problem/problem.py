"""The contact problem: two bodies, a grid and the parts that solve it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, overload

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import callback, choice, flag
from roughcontact._base.machine.progress import show_progress
from roughcontact._base.units import Estimate, Force, Length, Pressure
from roughcontact._parts.grid import Load
from roughcontact._parts.interactions import FrictionLaw
from roughcontact._parts.materials import Viscoelastic
from roughcontact._solve.problem.accuracy import Target, solve_within, with_tolerance
from roughcontact._solve.problem.brought_laws import remember_flattening
from roughcontact._solve.problem.cycle import AdhesionCycle, list_approaches, run_cycle
from roughcontact._solve.problem.friction_certificate import verify_state
from roughcontact._solve.problem.frictional_path import FrictionalPath
from roughcontact._solve.problem.increments import Increment
from roughcontact._solve.problem.load_path import PATH_ACCURACY, LoadPath, run_load_path
from roughcontact._solve.problem.loads import solve_loads
from roughcontact._solve.problem.loads_along import resolve_sliding, run_path, run_slide
from roughcontact._solve.problem.pull_off import find_pull_off
from roughcontact._solve.problem.required_load import RequiredLoad, find_load_of_area, find_required_load
from roughcontact._solve.problem.run import computing, require_success, run_solve
from roughcontact._solve.problem.scene import Scene
from roughcontact._solve.problem.sweep import Sweep
from roughcontact._solve.problem.task import limit_load
from roughcontact._solve.solution import DEFAULT_AREA, AreaEstimator, ContactSolution, Response, SteadySliding
from roughcontact._solve.solvers import Step
from roughcontact.errors import InputError, argument


@attrs.frozen(eq=False, repr=False)
class ContactProblem(Scene):
    """Normal, frictionless contact of two rough bodies on half-spaces, which may attract each other.

    Parameters
    ----------
    body, counterbody
        The two bodies; heights of both are positive towards the other.
    grid
        The grid; None if a surface has one of its own.
    boundary
        ``"free"``: nothing lies beyond the domain; ``"periodic"``: it repeats without end; ``"wrapped"``:
        the nearest image only. A pair, such as ``("free", "periodic")``, is one for x and one for y: for rollers and
        seals. The approach is then relative to the surface at a distance of the length of the free axis.
    kernel, convolver, solver
        Registered names or instances; ``"auto"`` chooses the convolver and the solver.
    adhesion
        The law by which the surfaces attract each other, such as `Exponential`; None: they do not.
    laws
        What else changes the contact, such as wear: a `Law`, its registered name, or a sequence of them.
    threads
        Threads of a solve, at most as many as this process may use; ``"auto"``: as many as gain on this grid, and one
        in a process of a pool. The solution is the same to the last bit.
    memory_limit
        Memory that a solve may take beyond the problem itself, bytes or a text such as ``"8 GiB"``; None: all that this
        process may take. A grid that needs more is refused.

    Raises
    ------
    InputError
        If the parts do not fit together.

    Examples
    --------
    >>> import roughcontact as rc
    >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
    >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
    >>> solution = problem.solve(force=1.2)
    >>> print(solution.area())
    (778.331 +- 0.023) µm2, (7.78331 +- 0.00023) % of nominal [blend]
    >>> print(solution.peak_pressure())
    2.3125 GPa +- 0.0045 %
    """

    def solve(
        self,
        *,
        pressure: Pressure | None = None,
        force: Force | None = None,
        approach: Length | None = None,
        area_within: float | None = None,
        peak_within: float | None = None,
        tolerance: float | None = None,
        start: Array | None = None,
        branch: str = "loading",
        throw: bool = True,
        on_step: Callable[[Step], None] | None = None,
    ) -> ContactSolution:
        """Solve the contact at a given load.

        Parameters
        ----------
        pressure
            Nominal mean pressure, Pa.
        force
            Normal force, N.
        approach
            Approach of the bodies since first touch, m. Of surfaces that attract each other each of the three may be
            zero or negative: a tensile load, bodies that do not touch yet.
        area_within, peak_within
            Admissible relative errors of the real contact area and the maximum pressure, with 95 %: two standard
            deviations. Grid, over the same domain, and tolerance are then chosen; `ContactSolution.accuracy` states
            them. A map is solved on its own grid if it is not known between its points.
        tolerance
            The tolerance of the solver, instead of its own or the one that follows from the accuracy.
        start
            A contact pressure to start from, shape (nx, ny), Pa, as of a similar load.
        branch
            Where several states of surfaces that attract each other are stable: ``"loading"``, found from the contact
            without adhesion, or ``"unloading"``, found from full contact. Only a path decides which: see `cycle`.
        on_step
            Called with a `Step` after each iteration.
        throw
            Whether to raise when the solver does not converge, or to return the unfinished solution.

        Returns
        -------
        ContactSolution
            The fields, and their residuals verified in float64 (the certificate).

        Raises
        ------
        InputError
            If not exactly one load is given, or the bodies cannot carry it.
        NotConverged
            If the solution is not certified, or not as accurate as requested, and `throw` is true; the error has it.
        """
        load = self._load_of(pressure=pressure, force=force, approach=approach)
        throw = flag(throw, "throw=")
        branch = choice(branch, "The branch", ("loading", "unloading"))
        if branch == "unloading" and self.adhesion is None:
            raise InputError(f"Without {argument('adhesion')} each load has one state: omit branch=.")
        on_step = callback(on_step, "on_step=", "step")
        target = Target.of(area_within, peak_within)
        if target is None:
            problem = self if tolerance is None else with_tolerance(self, tolerance)
            closed = np.zeros(self._grid.shape) if branch == "unloading" else None
            return run_solve(problem, load, start, throw=throw, on_step=on_step, start_gap=closed)
        solution = solve_within(self, load, target, tolerance, on_step, start)
        return require_success(solution) if throw else solution

    def require_load(
        self, *, pressure: Pressure | None = None, force: Force | None = None, approach: Length | None = None
    ) -> Load:
        """Return the given load; `InputError` if the bodies cannot carry it; see `solve`."""
        load = self._load_of(pressure=pressure, force=force, approach=approach)
        limit_load(self.plan, self.initial_gap, load)
        return load

    def _load_of(self, **given: object) -> Load:
        return Load.of(**given) if self.adhesion is None else Load.signed(**given)

    def sweep(
        self,
        *,
        pressure: Iterable[Pressure] | None = None,
        force: Iterable[Force] | None = None,
        approach: Iterable[Length] | None = None,
        progress: bool = False,
    ) -> Sweep:
        """Solve for several loads, each from those before; from the largest down, or in order where states remember.

        Parameters
        ----------
        pressure, force, approach
            Exactly one list: nominal mean pressures, Pa; normal forces, N; approaches, m. With a hardness each load is
            a first loading; ``run_in(problem, ...).problem.sweep(...)`` solves for loads after a larger one.
        progress
            Whether to show on standard error what runs (extra ``progress``).

        Returns
        -------
        Sweep
            The solutions in the order of the loads, and a table of their results.

        Raises
        ------
        InputError
            If not exactly one list is given, it is empty, or a load cannot be carried: then nothing is solved.
        NotConverged
            If a solution is not certified.
        """
        make_loads = Load.sequence if self.adhesion is None else Load.signed_sequence
        loads = make_loads(pressure=pressure, force=force, approach=approach)
        for load in loads if not self.laws else ():
            limit_load(self.plan, self.initial_gap, load)
        with show_progress("sweep", shown=flag(progress, "progress=")) as change:
            return solve_loads(self, loads, change)

    def cycle(
        self,
        *,
        approach: Iterable[Length],
        on_state: Callable[[ContactSolution], None] | None = None,
        progress: bool = False,
    ) -> AdhesionCycle:
        """Press surfaces that attract each other together and pull them apart again, along given approaches.

        Parameters
        ----------
        approach
            Approaches of loading, m, ascending; those of unloading are the same in the other order. Negative ones are
            before the first touch. On a periodic boundary the mean gap is the mean of the initial gap minus them.
        on_state
            Called with each state when it is found.
        progress
            Whether to show on standard error what runs (extra ``progress``).

        Returns
        -------
        AdhesionCycle
            Both branches, their jumps, the energy lost, pull-in and pull-off.

        Raises
        ------
        InputError
            If there is no adhesion, the approaches do not ascend, or the cells do not resolve the range of the law.
        NotConverged
            If a state is not certified.
        """
        with show_progress("cycle", shown=flag(progress, "progress=")) as change:
            solve = partial(run_solve, remember_flattening(self))
            return run_cycle(solve, self.require_cycle(approach=approach), on_state, change)

    def require_cycle(self, *, approach: Iterable[Length]) -> tuple[Load, ...]:
        """Return the loads of a branch of a cycle; `InputError` if it cannot be followed; see `cycle`."""
        return list_approaches(self.plan, self.initial_gap, approach)

    @overload
    def path(
        self,
        *,
        force: Force | Iterable[Force] | None = None,
        pressure: Pressure | Iterable[Pressure] | None = None,
        approach: Length | Iterable[Length] | None = None,
        friction: None = None,
        time: Iterable[float | str] | None = None,
        sliding: Iterable[Length] | None = None,
        shift: Iterable[Sequence[int]] | None = None,
        accuracy: float = PATH_ACCURACY,
        on_increment: Callable[[Any], None] | None = None,
        file: str | os.PathLike[str] | None = None,
        progress: bool = False,
    ) -> LoadPath: ...

    @overload
    def path(
        self,
        *,
        force: Force | Iterable[Force] | None = None,
        pressure: Pressure | Iterable[Pressure] | None = None,
        approach: Length | Iterable[Length] | None = None,
        friction: float | FrictionLaw,
        direction: float | None = None,
        time: Iterable[float | str] | None = None,
        sliding: Iterable[Length],
        accuracy: float = PATH_ACCURACY,
        on_increment: Callable[[Any], None] | None = None,
        file: str | os.PathLike[str] | None = None,
        progress: bool = False,
    ) -> LoadPath: ...

    @overload
    def path(
        self,
        *,
        force: Force | Iterable[Force] | None = None,
        pressure: Pressure | Iterable[Pressure] | None = None,
        approach: Length | Iterable[Length] | None = None,
        tangential_force: Iterable[Sequence[Force]] | Sequence[Force] | None = None,
        displacement: Iterable[Sequence[Length]] | Sequence[Length] | None = None,
        friction: float | FrictionLaw,
        substeps: int | str = "auto",
        cycles: Iterable[float] | None = None,
        accuracy: float = PATH_ACCURACY,
        on_increment: Callable[[Increment], None] | None = None,
        progress: bool = False,
    ) -> FrictionalPath: ...

    def path(
        self,
        *,
        force: Force | Iterable[Force] | None = None,
        pressure: Pressure | Iterable[Pressure] | None = None,
        approach: Length | Iterable[Length] | None = None,
        tangential_force: Iterable[Sequence[Force]] | Sequence[Force] | None = None,
        displacement: Iterable[Sequence[Length]] | Sequence[Length] | None = None,
        friction: float | FrictionLaw | None = None,
        direction: float | None = None,
        substeps: int | str = "auto",
        cycles: Iterable[float] | None = None,
        time: Iterable[float | str] | None = None,
        sliding: Iterable[Length] | None = None,
        shift: Iterable[Sequence[int]] | None = None,
        accuracy: float = PATH_ACCURACY,
        on_increment: Callable[[Any], None] | None = None,
        file: str | os.PathLike[str] | None = None,
        progress: bool = False,
    ) -> FrictionalPath | LoadPath:
        """Follow a contact along a path of loads, each state from the one before.

        With friction the loads are normal and tangential ones, or the bodies slide steadily. The surfaces change: they
        are flattened where the pressure reaches the hardness, which is remembered (`Flattening`), and as the laws of
        the problem say, such as by wear (`Archard`) over a sliding distance.

        Parameters
        ----------
        force, pressure, approach
            Exactly one of them: a list, a value for each step; or one value for all steps, which is applied before the
            first. Of a list the first step goes from the first touch to the first of both loads at once. Without
            friction a force or pressure of zero is complete unloading.
        tangential_force, displacement
            Exactly one of them: a list of pairs (x, y), or one pair for all steps. The force by which the counterbody
            is pushed over the body, N; or its displacement since the first touch, m.
        friction, direction
            A coefficient of friction, or a law such as `Coulomb` or `LimitedCoulomb`; None: no friction. With `sliding`
            the direction of steady sliding, as for `slide`; by default along x.
        cycles
            With friction and a law of wear by slip, `EnergyWear`: the loads are one cycle, and return. The numbers of
            the cycles whose states are wanted; those between are computed in part, each for many.
        time, sliding
            Without tangential loads, time, s, and distance, m, over which the surfaces slide, since its start at each
            place. One load acts from the start on, the first of several rises until there.
        shift
            Without friction, cells (x, y) by which the counterbody is displaced at each place from its first one, on a
            periodic boundary. What each body has lost moves with it. The sliding distance is by default that of the
            counterbody. Steps should be at most half the shortest wave.
        accuracy
            Admissible error of an increment, as many as that takes, of the change of the surfaces over its maximum;
            of cycles, admissible height that is lost at once, over the approach.
        substeps
            Increments of each step, in which both loads change in proportion. ``"auto"``: one where that is exact; else
            up to 16, until displacement, energy and stick area hardly change; their limits are extrapolated.
        on_increment
            Called after each increment with an `Increment`, without friction with its state.
        file
            Without tangential loads, a file ``.npz`` into which the path is written while it grows: the same call goes
            on from there after its process was killed, to the same bits, and reads a path that is finished.
        progress
            Whether to show on standard error what runs (extra ``progress``).

        Returns
        -------
        FrictionalPath or LoadPath
            The states at the given loads, each certified with the one before.

        Raises
        ------
        InputError
            If the loads do not fit together, or nothing that is given uses them. With friction, if tangential loads
            make the bodies slide; with adhesion, on a wrapped boundary or if the kernel does not know shear; of unlike
            materials if friction times beta exceeds 1; if a law of the problem depends on what does not pass.
        NotConverged
            If a state is not certified.
        """
        normal = {"force": force, "pressure": pressure, "approach": approach}
        tangential = {"tangential_force": tangential_force, "displacement": displacement}
        passed = {"time": time, "sliding": sliding, "shift": shift}
        with show_progress("path", shown=flag(progress, "progress=")) as change:
            if friction is None or sliding is not None:
                steady = resolve_sliding(friction, direction)
                omitted = tangential | {"substeps": None if substeps == "auto" else substeps, "cycles": cycles}
                return run_load_path(self, normal, omitted, passed, accuracy, on_increment, change, file, steady)
            unused = {"direction": direction, **passed, "file": file}
            return run_path(
                self, normal, tangential, unused, friction, substeps, on_increment, change, cycles, accuracy
            )

    def slide(
        self,
        *,
        force: Force | None = None,
        pressure: Pressure | None = None,
        approach: Length | None = None,
        friction: float | FrictionLaw | None = None,
        speed: float | str | None = None,
        direction: float = 0.0,
    ) -> ContactSolution:
        """Return the contact while the counterbody slides steadily over the body, with friction or viscoelastic losses.

        Parameters
        ----------
        force, pressure, approach
            Exactly one: normal force, N; nominal mean pressure, Pa; approach since first touch, m.
        friction
            A coefficient of friction, or a law: the traction of each cell is its shear strength.
        speed
            Instead of friction, the speed at which viscoelastic bodies slide, m/s: see `SteadySliding`. The state then
            has a ``friction_coefficient``, by the energy that they lose.
        direction
            Angle of the traction on the body, and of the motion of the counterbody, from x towards y, degrees.

        Raises
        ------
        InputError
            As for `path`; friction times beta above one is admitted in full contact alone. With a speed, unless a body
            is viscoelastic, one of them is flat, and the boundary is periodic along the direction.
        NotConverged
            If the state is not certified.
        """
        normal = {"force": force, "pressure": pressure, "approach": approach}
        if (speed is None) is (friction is None):
            given = f"{argument('friction')} or, if they are viscoelastic, at {argument('speed')}"
            raise InputError(f"Bodies slide with {given}: give one of them.")
        if speed is None:
            return run_slide(self, normal, friction, direction)
        if not any(isinstance(side.material, Viscoelastic) for side in (self.body, self.counterbody)):
            raise InputError(f"Nothing changes with the speed: give {argument('friction')}, or a viscoelastic body.")
        sliding = attrs.evolve(self, laws=(*self.laws, SteadySliding(speed, direction)))
        return sliding.solve(force=force, pressure=pressure, approach=approach)

    def pull_off(self) -> Estimate:
        """Return the force at which surfaces that attract each other come apart, N, negative: the minimum on unloading.

        The path begins at zero load and is followed by the approach, downwards. With `ShortRange` the force is that of
        the limit, extrapolated from the range that the grid resolves and one 1.4 times as long.

        Raises
        ------
        InputError
            If there is no adhesion, or the cells do not resolve the range of the law.
        NotConverged
            If a state is not certified.
        """
        return find_pull_off(self)

    def solve_for(
        self, response: Response[Any] | None = None, *, value: float | str | None = None, **wanted: Any
    ) -> RequiredLoad:
        """Find the load at which the contact has a wanted area, stiffness, leakage or other answer.

        Parameters
        ----------
        response
            A response or an area estimator, in place of a name; `value` is then wanted of it.
        value
            The wanted answer, in the SI unit of the response or as a text with a unit.
        wanted
            By name: ``area=``, m2, ``"0.1mm2"`` or ``"10%"`` of nominal, or a registered response with one number, such
            as ``stiffness=``, ``peak_pressure=``, ``leakage=``; and beside it the fields of the response.

        Raises
        ------
        InputError
            If no load gives the answer, on this grid and with this pressure limit; with adhesion.
        NotConverged
            If a solution is not certified.

        Examples
        --------
        >>> import roughcontact as rc
        >>> ball = rc.Body(rc.SphereSurface(radius=1e-3), rc.Elastic(young=210e9, poisson=0.3))
        >>> problem = rc.ContactProblem(ball, grid=rc.Grid((32, 32), 100e-6))
        >>> print(problem.solve_for(peak_pressure="2GPa").force)
        776.2... mN +- 0.012 %
        """
        return find_required_load(self, partial(run_solve, self), response, value, wanted)

    def solve_area(self, fraction: float, estimator: str | AreaEstimator = DEFAULT_AREA) -> ContactSolution:
        """Return the contact whose area is a fraction of nominal; `solve_for` has the uncertainty of its load too.

        Parameters
        ----------
        fraction
            Real over nominal contact area, above 0 and below 1.
        estimator
            Registered name or instance of the area estimator.

        Raises
        ------
        InputError
            If the fraction is out of bounds or no load gives it, on this grid and with this pressure limit.
        """
        return find_load_of_area(self, partial(run_solve, self), fraction, estimator)

    def verify(self, solution: ContactSolution) -> None:
        """Recompute the displacement and residuals of a solution of this problem from its pressure: one convolution.

        Parameters
        ----------
        solution
            A solution whose `origin` states its load, such as one from a file; with friction both of its states count.

        Raises
        ------
        InputError
            If it is not a solution of this problem, or its fields, residuals and status contradict each other.
        """
        with computing(self):
            verify_state(self, solution)
