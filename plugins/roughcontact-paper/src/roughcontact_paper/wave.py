"""Section 3.1 of the paper: a wavy surface on a rigid flat, solved as the paper must have solved it."""

from __future__ import annotations

import time

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc

# The paper's surface: side, wavelength and amplitude, m.
SIZE = 250e-6
WAVELENGTH = 12.5e-6
AMPLITUDE = 0.5e-6
# The paper prints 210 GPa, but all of its values follow from E* = 200 GPa / (1 - 0.3^2).
MATERIAL = rc.Elastic(young=200e9, poisson=0.3)
# A summit next to the centre of the domain, from its border, m.
SUMMIT = SIZE / 2 + WAVELENGTH / 2


@attrs.frozen(eq=False, kw_only=True)
class WaveCase:
    """One solve of Tables 1 and 2.

    Attributes
    ----------
    cells, load
        Cells along a side, and nominal pressure, MPa.
    p_max
        Maximum contact pressure, GPa.
    area, default_area
        Area of the cells in contact, and by the default estimator, % of nominal.
    contact_cells
        Number of cells in contact.
    iterations, cpu
        Iterations of the solver, and CPU time of the solve with its kernel, s.
    summit
        Cells in contact around one summit, a boolean mask.
    """

    cells: int
    load: int
    p_max: float
    area: float
    default_area: float
    contact_cells: int
    iterations: int
    cpu: float
    summit: npt.NDArray[np.bool_]

    @property
    def spacing(self) -> float:
        """Distance of neighbouring heights, m."""
        return SIZE / (self.cells - 1)


def wave_problem(cells: int) -> rc.ContactProblem:
    """Return the paper's problem on `cells` x `cells` cells.

    The heights are sampled on `cells` points from border to border, both included, while the cell
    is size / cells: the wave that is solved is a little too short. Only the nearest image counts.
    """
    profile = -AMPLITUDE * np.cos(2 * np.pi * np.linspace(0.0, SIZE, cells) / WAVELENGTH)
    surface = rc.HeightMap(profile[:, np.newaxis] + profile[np.newaxis, :], size=SIZE)
    return rc.ContactProblem(rc.Body(surface, MATERIAL), boundary="wrapped", solver="polonsky-keer", threads=1)


def solve_wave(cells: int, load: int) -> WaveCase:
    """Solve the problem on `cells` x `cells` cells at `load` MPa."""
    started = time.process_time()
    solution = wave_problem(cells).solve(pressure=1e6 * load)
    cpu = time.process_time() - started
    first, last = _around_summit(cells)
    return WaveCase(
        cells=cells,
        load=load,
        p_max=float(solution.pressure.max()) / 1e9,
        area=100 * solution.area("cell-count").fraction,
        default_area=100 * solution.area().fraction,
        contact_cells=int(np.count_nonzero(solution.contact)),
        iterations=solution.iterations,
        cpu=cpu,
        summit=solution.contact[first : last + 1, first : last + 1],
    )


def summit_positions(case: WaveCase) -> npt.NDArray[np.float64]:
    """Return the positions of the heights in `WaveCase.summit` from the summit, along either axis, m."""
    first, _ = _around_summit(case.cells)
    return np.asarray((first + np.arange(case.summit.shape[0])) * case.spacing - SUMMIT)


def _around_summit(cells: int) -> tuple[int, int]:
    """Return the indices of the first and the last height within a quarter of a wave from the summit."""
    first, last = (int(np.rint((SUMMIT + side * WAVELENGTH / 4) / SIZE * (cells - 1))) for side in (-1, 1))
    return first, last
