"""The paper's scene, solved exactly as the paper must have solved it."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.body import Body
from roughcontact.checks import Mask
from roughcontact.materials import Elastic
from roughcontact.problem import ContactProblem
from roughcontact.surfaces import HeightMap

SIZE = 250e-6
WAVELENGTH = 12.5e-6
AMPLITUDE = 0.5e-6
# The paper prints 210 GPa, but all of its figures were made with this: 200 GPa / (1 - 0.3^2).
MATERIAL = Elastic(young=200e9, poisson=0.3)
# A summit next to the centre of the domain.
SUMMIT = SIZE / 2 + WAVELENGTH / 2


@attrs.frozen(eq=False, kw_only=True)
class Case:
    """One solve of the paper's Tables 1 and 2.

    Attributes
    ----------
    cells
        Cells along a side.
    load
        Nominal pressure, MPa.
    p_max
        Greatest contact pressure, GPa.
    area
        Counted area, % of nominal.
    perimeter_area
        Area by the perimeter estimator, % of nominal.
    contact_cells
        Number of cells in contact.
    iterations
        What the solve took.
    summit
        Cells in contact around one summit.
    """

    cells: int
    load: int
    p_max: float
    area: float
    perimeter_area: float
    contact_cells: int
    iterations: int
    summit: Mask

    @property
    def spacing(self) -> float:
        """Distance of neighbouring heights, m."""
        return SIZE / (self.cells - 1)


def problem(cells: int) -> ContactProblem:
    """Return the paper's problem on `cells` x `cells` cells.

    The heights are sampled on `cells` points from border to border, both included, while the cell
    is size / cells: the wave that is solved is a little too short. Only the nearest image counts.
    """
    along = -AMPLITUDE * np.cos(2 * np.pi * np.linspace(0.0, SIZE, cells) / WAVELENGTH)
    surface = HeightMap(along[:, np.newaxis] + along[np.newaxis, :], size=SIZE)
    return ContactProblem(Body(surface, MATERIAL), boundary="wrapped", solver="polonsky-keer")


def run_case(cells: int, load: int) -> Case:
    """Solve the scene on `cells` x `cells` cells at `load` MPa."""
    solution = problem(cells).solve(pressure=1e6 * load)
    first, last = _around_summit(cells)
    return Case(
        cells=cells,
        load=load,
        p_max=float(solution.pressure.max()) / 1e9,
        area=100 * solution.area("cell-count").fraction,
        perimeter_area=100 * solution.area("perimeter").fraction,
        contact_cells=int(np.count_nonzero(solution.contact)),
        iterations=solution.iterations,
        summit=solution.contact[first : last + 1, first : last + 1],
    )


def summit_positions(case: Case) -> np.ndarray:
    """Return the distances from the summit of the heights that `Case.summit` covers, along either axis, m."""
    first, _ = _around_summit(case.cells)
    return (first + np.arange(case.summit.shape[0])) * case.spacing - SUMMIT


def _around_summit(cells: int) -> tuple[int, int]:
    """Return the first and the last height within a quarter of a wave from the summit, along either axis."""
    first, last = (int(np.rint((SUMMIT + side * WAVELENGTH / 4) / SIZE * (cells - 1))) for side in (-1, 1))
    return first, last
