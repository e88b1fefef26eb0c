"""A solver of shear within given limits."""

import attrs
import numpy as np
import scipy

import roughcontact as rc
from roughcontact.typing import ShearOutcome, ShearSolver, natural_residual


@attrs.frozen
class ProjectedGradient(ShearSolver):
    """Projected gradients with Nesterov's momentum, restarted where it points uphill."""

    def solve(self, convolution, task):
        """Return the shear; see `ShearSolver.solve`."""
        # Powers of two near the limit and the displacement of a cell: results do not depend on units, to the bit.
        unit, own = (float(2.0 ** np.ceil(np.log2(size or 1.0))) for size in (task.limit.max(), convolution.own[0]))
        limit = task.limit / unit
        offset = task.offset / (unit * own)
        force = np.array([np.nan if one is None else one / unit for one in task.shear_force])
        moved = np.array([0.0 if one is None else one / (unit * own) for one in task.displacement])
        # The largest eigenvalue, by the power method.
        wave = np.random.default_rng(0).random(offset.shape)
        for _ in range(30):
            wave = convolution.apply(wave / np.linalg.norm(wave)) / own
        step = 0.9 / float(np.linalg.norm(wave))
        shear, moved = project(np.zeros_like(offset), limit, force, moved, step)
        ahead, momentum = shear, 1.0
        iterations, residual = 0, np.inf
        while residual > task.tolerance and iterations < task.max_iterations:
            iterations += 1
            slip = offset - convolution.apply(ahead) / own
            found, moved = project(ahead + step * slip, limit, force, moved, step)
            if np.sum((ahead - found) * (found - shear)) > 0.0:
                momentum = 1.0
            grown = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
            ahead = found + (momentum - 1.0) / grown * (found - shear)
            shear, momentum = found, grown
            slip = offset - convolution.apply(shear) / own + moved[:, None, None]
            residual = natural_residual(shear, slip, limit, float(np.mean(convolution.own)) / own)
        is_found = residual <= task.tolerance
        return ShearOutcome(
            shear=shear * unit,
            displacement=tuple(moved * (unit * own)),
            residual=residual,
            iterations=iterations,
            products=2 * iterations + 30,
            status=rc.Status.CONVERGED if is_found else rc.Status.MAXIMUM_ITERATIONS,
        )


def project(shear, limit, force, moved, step):
    """Return the nearest shear within the limits that has the given forces, and the displacement that adds them."""

    def shift(displacement):
        trial = shear + step * displacement[:, None, None]
        size = np.hypot(*trial)
        return trial * np.minimum(1.0, limit / np.where(size > 0.0, size, 1.0))

    def excess(part):
        return (shift(fill(part)).sum(axis=(1, 2)) - force)[given]

    def fill(part):
        filled = moved.copy()
        filled[given] = part
        return filled

    given = np.isfinite(force)
    if given.any():
        moved = fill(scipy.optimize.root(excess, moved[given], tol=1e-15).x)
    return shift(moved), moved
