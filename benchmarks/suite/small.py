"""Solves, answers and paths of small contacts: CPU time by numpy alone, and compiled where the plug-in is there."""

from __future__ import annotations

import time
from collections.abc import Sequence

import attrs

import roughcontact as rc

from .scenes import ELASTIC, SCENES, SLOPE, Scene

CELLS = (64, 128, 256)  # along a side
# A path takes its time from its states.
PATH_CELLS = CELLS[:2]
CONVOLVERS = ("numpy", "compiled")
ANSWERS = ("peak-pressure", "perimeter", "approach", "mean-gap")
# Loads of a sweep over E* times rms slope; steps of a branch of a cycle; increments of a step with friction.
LOADS = [0.01 * (1 + k) for k in range(20)]
STEPS, INCREMENTS = 10, 4


def choose(problem: rc.ContactProblem, convolver: str) -> rc.ContactProblem:
    """Return the problem on one thread with a convolver of numpy, or the compiled one if it is installed."""
    numpys = "circular-fft" if problem.plan.boundary is rc.Boundary.PERIODIC else "dc-fft"
    name = numpys if convolver == "numpy" else convolver
    if name not in rc.convolvers:
        # asv omits the case.
        raise NotImplementedError("the plug-in roughcontact-numba is not installed")
    return attrs.evolve(problem, convolver=name, threads=1)


def make_soft(cells: int) -> rc.ContactProblem:
    """Return a rough contact with adhesion, waves of 16 cells to a quarter of the domain."""
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=SLOPE, shortest=16.0, longest=0.25 * cells, seed=1)
    work = 0.02 * SLOPE**2
    law = rc.Exponential(work, (4.0 * work) ** 0.5)
    grid = rc.Grid((cells, cells), float(cells))
    return rc.ContactProblem(rc.Body(surface, ELASTIC), grid=grid, boundary="periodic", adhesion=law)


def make_frictional(cells: int, other: rc.Elastic) -> rc.ContactProblem:
    """Return two rough elastic bodies on a free boundary."""
    surface = SCENES["rough, 0.05"](cells).problem.body.surface
    grid = rc.Grid((cells, cells), float(cells))
    return rc.ContactProblem(rc.Body(surface, rc.Elastic(2.0, 0.3)), rc.Body(rc.FlatSurface(), other), grid=grid)


class SmallScenes:
    """A contact on a small grid."""

    params: Sequence[Sequence[str | int]] = (("rough, 0.05", "rough, 1", "wave", "ball, free"), CELLS, CONVOLVERS)
    param_names = ("scene", "cells", "convolver")
    timer = time.process_time

    def setup(self, name: str, cells: int, convolver: str) -> None:
        scene = SCENES[name](cells)
        self.scene = Scene(choose(scene.problem, convolver), scene.pressure)
        self.solve()

    def solve(self) -> rc.ContactSolution:
        return self.scene.problem.solve(pressure=self.scene.pressure)


class SmallSolve(SmallScenes):
    """One solve of a problem that is prepared, and of a new one."""

    def time_solve(self, name: str, cells: int, convolver: str) -> None:
        self.solve()

    def time_new_problem(self, name: str, cells: int, convolver: str) -> None:
        attrs.evolve(self.scene.problem).solve(pressure=self.scene.pressure)

    def track_convolutions(self, name: str, cells: int, convolver: str) -> float:
        return self.solve().convolutions


class SmallAnswers(SmallScenes):
    """What is asked of a solution: the default area, and with it four other answers."""

    params = (("rough, 0.05", "wave", "ball, free"), CELLS, CONVOLVERS)

    def setup(self, name: str, cells: int, convolver: str) -> None:
        super().setup(name, cells, convolver)
        self.solution = self.solve()

    def time_area(self, name: str, cells: int, convolver: str) -> None:
        attrs.evolve(self.solution).area()

    def time_five(self, name: str, cells: int, convolver: str) -> None:
        solution = attrs.evolve(self.solution)
        solution.area()
        for answer in ANSWERS:
            solution.response(answer)


class SmallPaths:
    """A sweep of 20 loads, a cycle of adhesion, and the first step of a path with friction."""

    params = (PATH_CELLS, CONVOLVERS)
    param_names = ("cells", "convolver")
    timer = time.process_time

    def setup(self, cells: int, convolver: str) -> None:
        self.rough = choose(SCENES["rough, 0.05"](cells).problem, convolver)
        self.soft = choose(make_soft(cells), convolver)
        self.like = choose(make_frictional(cells, rc.Elastic(2.0, 0.3)), convolver)
        self.unlike = choose(make_frictional(cells, rc.Elastic(4.0, 0.2)), convolver)
        self.rough.solve(pressure=0.05 * SLOPE)

    def time_sweep(self, cells: int, convolver: str) -> None:
        self.rough.sweep(pressure=[load * SLOPE for load in LOADS])

    def time_cycle(self, cells: int, convolver: str) -> None:
        height = float(self.soft.initial_gap.mean())
        self.soft.cycle(approach=[height * (0.5 * k / STEPS - 0.1) for k in range(STEPS)])

    def time_friction(self, cells: int, convolver: str) -> None:
        self.push(self.like)

    def time_friction_of_unlike_bodies(self, cells: int, convolver: str) -> None:
        self.push(self.unlike)

    def push(self, problem: rc.ContactProblem) -> None:
        """Load a contact, and push it by half of its friction."""
        force = 0.05 * SLOPE * problem.grid.area
        problem.path(force=[force], tangential_force=[(0.15 * force, 0.0)], friction=0.3, substeps=INCREMENTS)
