"""Solves and areas of the scenes: CPU and wall time, peak memory, products, and errors."""

from __future__ import annotations

import time

import attrs

import roughcontact as rc

from .scenes import SCENES, make_ball, make_wave

CELLS = 512  # along a side
# Coarse, so that the error of the area is far above that of its true value.
COARSE = (100, 160, 250)


class Scenes:
    """A new problem, whose influence coefficients are not known yet."""

    params = tuple(SCENES)
    param_names = ("scene",)

    def setup(self, name: str) -> None:
        self.scene = SCENES[name](CELLS)

    def solve(self) -> rc.ContactSolution:
        return attrs.evolve(self.scene.problem).solve(pressure=self.scene.pressure)


class Solve(Scenes):
    """One solve: CPU time, memory, products, residual."""

    timer = time.process_time

    def time_solve(self, name: str) -> None:
        self.solve()

    def peakmem_solve(self, name: str) -> None:
        self.solve()

    def track_convolutions(self, name: str) -> float:
        return self.solve().convolutions

    def track_residual(self, name: str) -> float:
        return self.solve().residuals.error


class Wall(Scenes):
    """One solve by the clock on the wall."""

    timer = time.perf_counter

    def time_solve(self, name: str) -> None:
        self.solve()


class Area(Scenes):
    """The default area of a solution, without its solve."""

    timer = time.process_time

    def setup(self, name: str) -> None:
        super().setup(name)
        self.solution = self.solve()

    def time_area(self, name: str) -> None:
        # A copy, of which nothing is known yet.
        attrs.evolve(self.solution).area()


class AreaError:
    """The default area beside the true one on coarse grids, in per cent."""

    params = (("wave", "ball"), COARSE)
    param_names = ("scene", "cells")
    unit = "%"

    def setup(self, name: str, cells: int) -> None:
        scene = {"wave": make_wave, "ball": make_ball}[name](cells)
        self.area, self.true = scene.problem.solve(pressure=scene.pressure).area(), scene.fraction

    def track_error(self, name: str, cells: int) -> float:
        return 100.0 * (self.area.fraction / self.true - 1.0)

    def track_uncertainty(self, name: str, cells: int) -> float:
        return 100.0 * self.area.uncertainty / self.area.value


class Import:
    """A new process that imports the package."""

    def timeraw_import(self) -> str:
        return "import roughcontact"
