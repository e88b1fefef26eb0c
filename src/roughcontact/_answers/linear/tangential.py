"""Tangential stiffness before slip: the compliance of two materials where every cell in contact sticks."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._answers.linear.stiffness import find_normal_answer
from roughcontact._answers.linear.tangent import Tangent, tangent_of
from roughcontact._base import checks
from roughcontact._base.arrays import Array
from roughcontact._base.units import WarningText
from roughcontact._parts.kernels import SupportsTangential, has_layers
from roughcontact._parts.materials import MAX_UNCOUPLED_BETA, pair_constants
from roughcontact._solve.problem import ContactProblem, problem_of
from roughcontact._solve.solution import ContactSolution, Estimate, Response, responses
from roughcontact._solve.solvers import ProjectedShearCG, ShearTask
from roughcontact.errors import InputError, NotConverged, argument

# Limit of the traction over the maximum of the normal answer, so that no cell slips, and residual in this unit.
_STICK_LIMIT = 100.0
_STICK_TOLERANCE = 1e-6
# Rounds in which pressure and traction of unlike bodies follow each other, and the relative change of the compliance at
# which they end. Each round multiplies the error of the compliance by a third to two thirds of beta^4 (measured).
_MAX_ROUNDS = 12
_ROUND_TOLERANCE = 1e-6
# Relative standard deviation by the shape that the cells give a patch, over the anisotropy, times the root of their
# number. Set on 60 ellipses of 1:1 to 81:1 in radii, of 1.5 to 8 cells.
_SHAPE_STD = 0.1
# On layers: relative residual; waves of which coupling and anisotropy are found, and cells over their length; and
# relative standard deviations, over the square of Dundurs' beta, by the neglected change of pressure, up to 0.21 on
# discs, and, over that of the anisotropy, by the tractions across the force, up to 0.085 with a third in contact.
_LAYERED_TOLERANCE = 1e-3
_WAVES = 9
_FINE = 1e-3
_MAX_SILENT_BETA = 0.2
_COUPLING_STD = 0.2
_ACROSS_STD = 0.1


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


def find_energy_ratio(solution: ContactSolution, answer: Array, axis: int, *, coupled: bool = False) -> float:
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
    coupled
        Whether the pressure of unlike bodies changes too, under the same normal force.
    """
    convolution = problem_of(solution).shear_convolution
    coupled = coupled and abs(convolution.setup.kernel.pair.beta) > MAX_UNCOUPLED_BETA
    if convolution.setup.kernel.pair.gamma == 0.0 and not coupled:
        return 1.0
    start = np.zeros((2, *solution.grid.shape))
    start[axis] = answer / float(np.abs(answer).max())
    trial = _sum_products(start, convolution.apply(start))
    shear = _find_stuck_shear(solution, start, axis, np.zeros_like(start))
    if not coupled:
        return _sum_products(shear, convolution.apply(shear)) / trial
    before = math.inf
    for _ in range(_MAX_ROUNDS):
        moved = convolution.apply(shear, to="xyz")
        pressure = _find_change_of_pressure(solution, answer, moved[2])
        energy = _sum_products(np.stack((*shear, pressure)), moved)
        if abs(before - energy) <= _ROUND_TOLERANCE * energy:
            return energy / trial
        before = energy
        shear = _find_stuck_shear(solution, shear, axis, -convolution.apply(pressure[np.newaxis], of="z"))
    raise NotConverged("The tangential answer of the contact of unlike bodies was not found.", solution)


def _find_stuck_shear(solution: ContactSolution, start: Array, axis: int, offset: Array) -> Array:
    """Return the shear with the force of `start` that moves all cells in contact as one, shape (2, nx, ny)."""
    force = float(start[axis].sum())
    task = ShearTask(
        limit=np.where(solution.contact, _STICK_LIMIT, 0.0),
        offset=offset,
        shear_force=(force, 0.0) if axis == 0 else (0.0, force),
        start=start,
        tolerance=_STICK_TOLERANCE,
    )
    found = ProjectedShearCG().solve(problem_of(solution).shear_convolution, task)
    if not found.status.success:
        raise NotConverged(f"The tangential answer of the contact was not found: {found.status}.", solution)
    return found.shear


def _find_change_of_pressure(solution: ContactSolution, answer: Array, pressed_in: Array) -> Array:
    """Return the change of pressure, of no force, that keeps the cells in contact where shear presses them in."""
    unit = solution.grid.spacing[0] / solution.modulus
    pressure = tangent_of(solution).solve(-unit * pressed_in, _STICK_TOLERANCE).values
    return np.asarray(pressure - answer * (float(pressure.sum()) / float(answer.sum())))


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
    Between unlike bodies the force also changes the pressure p, though to first order not the cells in contact: the
    energy of both has its minimum over p, which has no force, as well. On layers (`SupportsTangential`) the tractions
    are along the axis alone and p is unchanged, which the uncertainty contains.

    Parameters
    ----------
    axis
        0 for a force along x, 1 along y.

    References
    ----------
    Mindlin, J. Appl. Mech. 16 (1949) 259-268, https://doi.org/10.1115/1.4009973
    """

    memory_arrays = 49.0  # the symbols of shear
    fails_with = frozenset({"inner flow", "inner moduli"})
    flagged_factors = 0.5, 0.1

    axis: int = attrs.field(default=0, converter=tangential_axis)

    def respond(self, solution: ContactSolution) -> Estimate:
        """Return the stiffness; see `Response.respond`."""
        problem = problem_of(solution)
        kernel = problem.plan.kernel
        if solution.moduli is not None and not isinstance(kernel, SupportsTangential):
            raise InputError(
                "The tangential stiffness needs the response to shear, which this kernel of a graded body, a crystal "
                f"or layers does not know: choose {argument('kernel', 'love')}."
            )
        if solution.saturated.any():
            raise InputError(
                "The pressure has reached its limit on a part of the contact, which resists a tangential force as a "
                "yielding solid: the tangential stiffness holds for elastic contact only."
            )
        normal = find_normal_answer(solution, "tangential stiffness")
        warnings = normal.warnings
        if not 0.0 < normal.value < math.inf:
            return Estimate(normal.value, 0.0, "N/m", warnings)
        if isinstance(kernel, SupportsTangential):
            ratio, anisotropy, beta = _compare_on_layers(solution, problem, kernel, self.axis)
            neglected = math.hypot(_COUPLING_STD * beta**2, _ACROSS_STD * anisotropy**2)
            if beta > _MAX_SILENT_BETA:
                text = (
                    f"the coupling of normal and tangential displacement on layers, Dundurs' beta = {beta:.2g}, is "
                    f"neglected: expect a stiffness too small by up to {100.0 * _COUPLING_STD * beta**2:.2g} %"
                )
                warnings = (*warnings, WarningText(text, "coupling", beta))
        else:
            ratio = find_compliance_ratio(solution, normal.field, self.axis)
            ratio *= find_energy_ratio(solution, normal.field, self.axis, coupled=True)
            anisotropy = find_anisotropy(solution)
            neglected = 0.0
        value = normal.value / ratio
        by_shape = _SHAPE_STD * anisotropy * _find_scatter(solution, normal.field)
        std = math.hypot(normal.uncertainty / normal.value, by_shape, neglected) * value
        return Estimate(value, std, "N/m", warnings)


def _compare_on_layers(
    solution: ContactSolution, problem: ContactProblem, kernel: SupportsTangential, axis: int
) -> tuple[float, float, float]:
    """Return the tangential over the normal compliance of tractions along the axis alone, anisotropy and coupling.

    The anisotropy is that of `find_anisotropy`, the coupling the magnitude of Dundurs' beta, each the largest of all
    waves.
    """
    pair = pair_constants(*problem.plan.materials)
    if not has_layers(kernel, "body", problem.body.material):
        if not has_layers(kernel, "counterbody", problem.counterbody.material):
            raise InputError(
                f"The tangential stiffness needs to know which body carries the layers, but neither "
                f"{problem.body.material!r} nor {problem.counterbody.material!r} is the substrate of {kernel!r}."
            )
        pair = attrs.evolve(pair, beta=-pair.beta)
    bound = problem.convolution.setup.kernel
    shear = attrs.evolve(bound, kernel=kernel.shear_kernel(axis, pair))
    unit = np.ones(solution.grid.shape)
    normal, tangential = (
        Tangent(solution, kernel=one).solve(unit, _LAYERED_TOLERANCE).product for one in (None, shear)
    )
    resolved = solution.grid.resolved
    waves = np.geomspace(1.0 / max(resolved.size), 1.0 / min(resolved.spacing), _WAVES)
    beta = float(np.abs(kernel.coupling(waves, bound.compliance, pair)).max())
    # Waves on cells much smaller than they are.
    ends = np.array([[0.0], [1.0]])
    spectra = [shear.spectrum(q * ends, q * ends.T, (_FINE / q, _FINE / q)) for q in waves]
    along_x, along_y = np.array([[spectrum[1, 0], spectrum[0, 1]] for spectrum in spectra]).T
    along, across = (along_x, along_y) if axis == 0 else (along_y, along_x)
    anisotropy = float(np.abs(1.0 - along / across).max())
    return normal / tangential, anisotropy, beta


def _find_scatter(solution: ContactSolution, answer: Array) -> float:
    """Return the root of the sum over the patches of the square of their part of the answer over their cells."""
    parts = solution.patches.sum(answer) / float(answer.sum())
    oblong = max(solution.grid.resolved.spacing) / math.sqrt(solution.grid.resolved.cell_area)
    return oblong * math.sqrt(float(np.sum(parts**2 / solution.patches.cells)))
