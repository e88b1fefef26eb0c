"""Tangential stiffness before slip: the compliance of two materials where every cell in contact sticks."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.linear.stiffness import find_normal_answer
from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.units import ContactWarning
from roughcontact._parts.materials import pair_constants
from roughcontact._solve.problem import problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact._solve.solvers import ProjectedShearCG, ShearTask
from roughcontact.errors import InputError, NotConverged

# Dundurs' second constant below which normal and tangential displacement count as uncoupled.
MAX_UNCOUPLED_BETA = 0.01
# Limit of the traction over the maximum of the normal answer, so that no cell slips, and residual in this unit.
_STICK_LIMIT = 100.0
_STICK_TOLERANCE = 1e-6
# Relative standard deviation by the neglected change of the pressure, over the square of Dundurs' beta: with all nine
# components of the kernel discs, ellipses and rough contacts are stiffer by 0.08 to 0.18 of this square.
_COUPLING_STD = 0.1
# Relative standard deviation by the shape that the cells give a patch, over the anisotropy, times the root of their
# number. Set on 60 ellipses of 1:1 to 81:1 in radii, of 1.5 to 8 cells.
_SHAPE_STD = 0.1


def tangential_axis(value: int) -> int:
    """Return the axis of a tangential force, or raise `InputError`."""
    return checks.axis(value, "The axis of the tangential force")


def find_anisotropy(solution: ContactSolution) -> float:
    """Return the relative excess of the stiffness of waves of shear along their normal over those across it.

    It is Poisson's ratio of like materials.
    """
    gamma = pair_constants(*problem_of(solution).plan.materials).gamma
    return abs(gamma) / (1.0 + gamma)


def find_compliance_ratio(solution: ContactSolution, traction: Array, axis: int) -> float:
    """Return the tangential over the normal compliance of a traction along an axis and as a pressure.

    Compliances are energies over squared forces. A traction that displaces nothing has the ratio of round contacts.

    Parameters
    ----------
    solution
        The contact.
    traction
        Traction, shape (nx, ny), in any unit.
    axis
        0 for a force along x, 1 along y.
    """
    convolution = problem_of(solution).shear_convolution
    unit = (traction / float(np.abs(traction).max()))[np.newaxis]
    letter = "xy"[axis]
    tangential, normal = (_sum_products(unit, convolution.apply(unit, one, one)) for one in (letter, "z"))
    gamma = convolution.setup.kernel.pair.gamma
    return tangential / normal if normal > 0.0 else 1.0 + 0.5 * gamma


def find_energy_ratio(solution: ContactSolution, answer: Array, axis: int) -> float:
    """Return the compliance of cells in contact that all stick, over that under a traction as their normal answer.

    The force is along an axis, and the cells may move across it. The compliance is an energy near its minimum, so that
    its error is the square of that of the traction.

    Parameters
    ----------
    solution
        The contact.
    answer
        The normal answer of its cells to a unit approach, shape (nx, ny), in any unit.
    axis
        0 for a force along x, 1 along y.
    """
    convolution = problem_of(solution).shear_convolution
    if convolution.setup.kernel.pair.gamma == 0.0:
        return 1.0
    start = np.zeros((2, *solution.grid.shape))
    start[axis] = answer / float(np.abs(answer).max())
    force = float(start.sum())
    task = ShearTask(
        limit=np.where(solution.contact, _STICK_LIMIT, 0.0),
        offset=np.zeros_like(start),
        shear_force=(force, 0.0) if axis == 0 else (0.0, force),
        start=start,
        tolerance=_STICK_TOLERANCE,
    )
    found = ProjectedShearCG().solve(convolution, task)
    if not found.status.success:
        raise NotConverged(f"The tangential answer of the contact was not found: {found.status}.", solution)
    true, trial = (_sum_products(one, convolution.apply(one)) for one in (found.shear, start))
    return true / trial


def _sum_products(tractions: Array, displacements: Array) -> float:
    return float(np.einsum("aij,aij->", tractions, displacements))


@responses.register("tangential-stiffness")
@attrs.frozen
class TangentialStiffness(Response[Estimate]):
    r"""Stiffness against a tangential force along an axis before any slip, N/m.

    All cells A in contact stick: of the tractions on them with the force Q along the axis and none across, that with
    the smallest energy moves them as one,

    .. math:: \min_{\sum q = (Q, 0)} \tfrac12\, q \cdot K_{AA}\, q, \qquad
       \frac{S_x}{S} = \frac{C_{zz}}{C_{xx}}, \qquad C = \frac{q \cdot K_{AA}\, q}{Q^2},

    with the compliance :math:`C_{zz}` of the same cells under the normal answer, so that the correction of the edge in
    the normal stiffness S serves both. Round contacts of like materials have Mindlin's :math:`2(1-\nu)/(2-\nu)`.
    Between unlike bodies the force also changes the pressure, though to first order not the cells in contact. The
    stiffness without that is a lower bound: a warning names beta, and the uncertainty contains the deficit.

    Parameters
    ----------
    axis
        0 for a force along x, 1 along y.

    References
    ----------
    Mindlin, J. Appl. Mech. 16 (1949) 259-268, https://doi.org/10.1115/1.4009973
    """

    axis: int = attrs.field(default=0, converter=tangential_axis)

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the stiffness; see `Response.respond`."""
        if solution.moduli is not None:
            raise InputError(
                "The tangential stiffness follows from the normal one of two isotropic half-spaces, but this kernel is "
                "of a layer or a crystal: choose kernel='love'."
            )
        if solution.saturated.any():
            raise InputError(
                "The pressure has reached its limit on a part of the contact, which resists a tangential force as a "
                "yielding solid: the tangential stiffness holds for elastic contact only."
            )
        plan = problem_of(solution).plan
        beta = abs(pair_constants(*plan.materials).beta)
        normal = find_normal_answer(solution, "tangential stiffness")
        warnings = normal.warnings
        if beta > MAX_UNCOUPLED_BETA:
            text = (
                f"the bodies are unlike, Dundurs' beta = {beta:.2g}: a tangential force changes the pressure too, and "
                "without that the stiffness is a lower bound"
            )
            warnings += (ContactWarning(text, "coupling", beta),)
        if not 0.0 < normal.value < math.inf:
            return Estimate(normal.value, 0.0, "N/m", warnings)
        ratio = find_compliance_ratio(solution, normal.field, self.axis)
        value = normal.value / (ratio * find_energy_ratio(solution, normal.field, self.axis))
        by_shape = _SHAPE_STD * find_anisotropy(solution) * _find_scatter(solution, normal.field)
        std = math.hypot(normal.uncertainty / normal.value, by_shape, _COUPLING_STD * beta**2) * value
        return Estimate(value, std, "N/m", warnings)


def _find_scatter(solution: ContactSolution, answer: Array) -> float:
    """Return the root of the sum over the patches of the square of their part of the answer over their cells."""
    parts = solution.patches.sum(answer) / float(answer.sum())
    oblong = max(solution.grid.spacing) / math.sqrt(solution.grid.cell_area)
    return oblong * math.sqrt(float(np.sum(parts**2 / solution.patches.cells)))
