"""A judge of solutions in extended precision, written anew: direct sums, no transform, no code of the package.

Of a solution it reads pressure, approach, gap and status, of a problem the initial heights, the grid, E* and the
pressure limit. `violations` measures the contact conditions, `exact_pressure` solves small problems by active sets.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import attrs
import mpmath as mp
import numpy as np

Long = np.longdouble
PI = Long("3.14159265358979323846264338327950288")
# np.longdouble is plain double on some platforms; it cannot judge there.
EXTENDED = bool(np.finfo(Long).eps < 1e-18)
# What docs/use/conventions.md allows: twice the tolerance for "converged", this for "converged to rounding".
TO_ROUNDING = 1e-5
# Relative error of the load that docs/use/conventions.md allows.
LOAD = 1e-12
# A uniform pressure displaces a periodic surface by nothing: a range below this, over the pressure, is rounding.
UNIFORM = 1e-12


def love_by_mpmath(i, j, dx, dy):
    """Love's four logarithms with 80 digits, for 1/(pi E*) = 1."""
    with mp.workdps(80):
        dx, dy = mp.mpf(dx), mp.mpf(dy)

        def corner(x, y):
            return (x * mp.asinh(y / abs(x)) if x else 0) + (y * mp.asinh(x / abs(y)) if y else 0)

        x, y = (i - mp.mpf(1) / 2) * dx, (j - mp.mpf(1) / 2) * dy
        return corner(x + dx, y + dy) - corner(x, y + dy) - corner(x + dx, y) + corner(x, y)


def love(i, j, aspect):
    """Displacement by unit pressure on a cell of sides (1, aspect) at offsets in cells, E* = 1.

    Along each side the inner integral is a difference of two asinh, taken as one; what remains cancels by the
    offset in cells alone, whatever the aspect.
    """
    x, y, a = np.asarray(i, Long), np.asarray(j, Long), Long(aspect)
    half = Long(0.5)
    x1, x2, y1, y2 = x - half, x + half, (y - half) * a, (y + half) * a

    def between(low, high, distance):
        low, high = low / np.abs(distance), high / np.abs(distance)
        lower, upper = np.hypot(1, low), np.hypot(1, high)
        # Only where both have one sign; elsewhere nothing cancels.
        with np.errstate(invalid="ignore", divide="ignore"):
            same = (high - low) * (high + low) / (high * lower + low * upper)
            return np.where(low > 0, np.arcsinh(same), np.arcsinh(high) - np.arcsinh(low))

    along = y2 * between(x1, x2, y2) - y1 * between(x1, x2, y1)
    across = x2 * between(y1, y2, x2) - x1 * between(y1, y2, x1)
    return (along + across) / PI


def _alternating(count=64, averages=40):
    """Orders -count .. count, and weights that sum an alternating series over them (Euler's method)."""
    sums = np.tri(count + 1, dtype=Long)
    for _ in range(averages):
        sums = (sums[1:] + sums[:-1]) / 2
    orders = np.arange(-count, count + 1)
    return orders, sums[-1][np.abs(orders)] * np.where(orders % 2 == 0, 1, -1)


ORDERS, WEIGHTS = _alternating()


def _aliases(count):
    """Phases of all aliases of the waves 0 .. count // 2 and their sinc factors with weights, shape (waves, orders)."""
    theta = 2 * PI * np.arange(count // 2 + 1, dtype=Long)[:, None] / count
    phases = theta + 2 * PI * ORDERS
    own = np.where(theta == 0, 1, np.sin(theta / 2) / np.where(theta == 0, 1, theta / 2))
    others = 2 * np.sin(theta / 2) / np.where(phases == 0, 1, phases)
    return phases, WEIGHTS * np.where(ORDERS == 0, own, others)


@lru_cache(maxsize=64)
def love_waves(shape, aspect):
    """Amplitudes by unit pressure waves on cells (1, aspect), E* = 1: sums over all aliases; zero for the mean."""
    (x, fx), (y, fy) = (_aliases(n) for n in shape)
    found = np.zeros((len(x), len(y)), Long)
    for a, b in np.ndindex(found.shape):
        if a or b:
            found[a, b] = 2 * (fx[a] @ (fy[b] / np.hypot(x[a][:, None], y[b] / Long(aspect))).sum(axis=1))
    return found


def fourier_waves(shape, aspect):
    """2 / (E* |q|) itself."""
    qx, qy = (2 * PI * np.arange(n // 2 + 1, dtype=Long) / n for n in shape)
    q = np.hypot(qx[:, None], qy / Long(aspect))
    return np.divide(2, q, out=np.zeros_like(q), where=q > 0)


def strips(shape, aspect):
    """Responses where x is free and y periodic, zero at the distance nx by a uniform pressure: sums over images.

    The images beyond M are replaced by the strip less what lies nearer, and the rest extrapolated in (M + 1/2)^-2.
    """
    nx, ny = shape
    x, y = np.arange(nx)[:, None], np.arange(ny)[None, :]
    low, high = (x - Long(0.5)), (x + Long(0.5))
    area = high * np.log(high) - low * np.log(np.abs(low)) - 1 - np.log(Long(nx))
    nodes, weights = (part.astype(Long) / 2 for part in np.polynomial.legendre.leggauss(9))
    length, sums, sizes = ny * Long(aspect), [], []
    first = 8 + int(2 * nx / length)
    step = max(4, first // 3)
    for last in range(first, first + 7 * step, step):
        total = sum(love(x, y + m * ny, aspect) for m in range(-last, last + 1))
        reach = (2 * last + 1) * length
        near = sum(w * love(x, (y - s) * Long(aspect) / reach, reach) for s, w in zip(nodes, weights, strict=True))
        sums.append(total - (2 / PI * area + near) * Long(aspect) / length)
        sizes.append((last + Long(0.5)) ** -2)
    sizes = np.array(sizes)
    others = [np.delete(sizes, k) for k in range(len(sizes))]
    return sum(total * np.prod(rest / (rest - size)) for total, size, rest in zip(sums, sizes, others, strict=True))


def responses(problem):
    """Displacement by unit pressure at each offset, shape (nx, ny), in cells along x and E* = 1."""
    shape, (lx, ly) = problem.plan.grid.shape, problem.plan.grid.size
    aspect = (Long(ly) / shape[1]) / (Long(lx) / shape[0])
    if str(problem.boundary) == "free-periodic":
        return strips(shape, aspect)
    if str(problem.boundary) == "periodic-free":
        return aspect * strips(shape[::-1], 1 / aspect).T
    if str(problem.boundary) != "periodic":
        return love(np.arange(shape[0])[:, None], np.arange(shape[1])[None, :], aspect)
    waves = (fourier_waves if problem.kernel == "fourier" else love_waves)(shape, aspect)
    # Waves n/2 < k < n mirror those below; the response has cosines only.
    kx, ky = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    cx, cy = (np.cos(2 * PI * (np.outer(np.arange(n), np.arange(n)) % n) / Long(n)) for n in shape)
    return cx @ waves[np.ix_(kx, ky)] @ cy.T / (shape[0] * shape[1])


@attrs.frozen
class Scene:
    """A problem as the judge reads it: flat arrays over the cells, SI units; the load is a sum of pressures.

    `responses` are displacements by unit pressure at each offset, `offsets` those of all pairs of rows and of columns.
    """

    responses: np.ndarray
    offsets: tuple[np.ndarray, np.ndarray]
    gap: np.ndarray
    limit: np.ndarray
    measured: np.ndarray
    load: Long | None
    approach: Long | None

    @classmethod
    def of(cls, problem, load):
        plan = problem.plan
        grid, bodies = plan.grid, (problem.body, problem.counterbody)
        heights = sum(body.heights(grid) for body in bodies).ravel().astype(Long)
        holes = [mask for mask in (body.non_measured(grid) for body in bodies) if mask is not None]
        measured = ~np.logical_or.reduce(holes).ravel() if holes else np.ones(heights.size, bool)
        (kind, value), *_ = load.items()
        cells = Long(heights.size)
        area = Long(grid.size[0]) * Long(grid.size[1])
        sums = {"pressure": Long(value) * cells, "force": Long(value) / area * cells, "approach": None}
        offsets = [np.abs(np.arange(n)[:, None] - np.arange(n)) for n in grid.shape]
        # The responses of periodic axes are those of all images, at the offset from any of them.
        if str(problem.boundary) == "wrapped":
            offsets = [np.minimum(offset, len(offset) - offset) for offset in offsets]
        return cls(
            responses=responses(problem) * (Long(grid.size[0]) / grid.shape[0] / Long(plan.modulus)),
            offsets=tuple(offsets),
            gap=heights[measured].max() - heights,
            limit=np.broadcast_to(plan.pressure_limit, grid.shape).ravel().astype(Long),
            measured=measured,
            load=sums[kind],
            approach=Long(value) if kind == "approach" else None,
        )

    def displace(self, pressure):
        """The displacement by a pressure: a direct sum, row by row."""
        rows, columns = self.offsets
        rows_of, field = self.responses[:, columns], pressure.reshape(self.responses.shape)
        return np.concatenate([np.einsum("ajk,ak->j", rows_of[row], field) for row in rows])

    @cached_property
    def matrix(self):
        """The dense matrix of the displacements, cells in C order."""
        (i, j), cells = self.offsets, self.responses.size
        return self.responses[i[:, None, :, None], j[None, :, None, :]].reshape(cells, cells)


@attrs.frozen
class Verdict:
    """How far a solution is from the contact conditions, and from what its own fields say, over `scale`.

    `allowed` is the error that its status promises; `holds` tells whether it keeps the promise.
    """

    complementarity: float
    penetration: float
    fields: float
    load: float
    bounded: bool
    scale: float
    allowed: float

    @property
    def error(self):
        return max(self.complementarity, self.penetration, self.fields)

    @property
    def holds(self):
        return self.bounded and self.load <= LOAD and self.error <= self.allowed


def violations(problem, load, solution, scene=None):
    """Measure the contact conditions on the pressure of a solution; see `Verdict`."""
    scene = scene or Scene.of(problem, load)
    pressure = solution.pressure.ravel().astype(Long)
    measured, limit = scene.measured, scene.limit
    displacement = scene.displace(pressure)
    level = displacement + scene.gap
    saturated = pressure >= limit
    datum = _datum(level, pressure, saturated, measured) if scene.approach is None else scene.approach
    gap = level - datum
    wrong = np.where(saturated, np.maximum(gap, 0), np.abs(gap))
    open_or_elastic = gap[measured & ~saturated]
    scale = _scale(problem, scene, pressure, displacement)
    fields = max(
        abs(float(solution.approach) - datum) if (pressure[~saturated] > 0).any() else 0,
        np.abs(solution.displacement.ravel() - displacement).max(),
    )
    total = pressure.sum()
    off = Long(0) if scene.load is None else abs(total - scene.load) / scene.load
    rounded = "rounding" in str(solution.status)
    return Verdict(
        complementarity=float((pressure * wrong).sum() / total / scale) if total > 0 else float("inf"),
        penetration=float(max(0, -open_or_elastic.min(initial=np.inf)) / scale),
        fields=float(fields / scale),
        load=float(off),
        bounded=bool((pressure >= 0).all() and (pressure <= limit).all() and not pressure[~measured].any()),
        scale=float(scale),
        allowed=TO_ROUNDING if rounded else 2 * problem.plan.solver.tolerance,
    )


def _datum(level, pressure, saturated, measured):
    """The approach that a load implies: the mean level in elastic contact, or one between saturated and open cells."""
    elastic = np.where(saturated, 0, pressure)
    if elastic.any():
        return (elastic * level).sum() / elastic.sum()
    lower = level[saturated & measured].max(initial=level[measured].min())
    return min(lower, level[(pressure <= 0) & measured].min(initial=np.inf))


def _scale(problem, scene, pressure, displacement):
    rms = np.std(scene.gap[scene.measured])
    extent = np.ptp(displacement)
    cell = Long(problem.plan.grid.spacing[0]) / Long(problem.plan.modulus)
    extent = extent if extent > UNIFORM * pressure.max() * cell else Long(0)
    return min(rms, extent) or max(rms, extent) or Long(1)


def exact_pressure(scene, start, rounds=100):
    """Return the pressure that satisfies the conditions exactly, by active sets; None if they do not settle.

    It starts from the cells that `start` has open, elastic and saturated; the signs of all pressures and gaps
    decide, so that a wrong start only costs rounds.
    """
    start = start.ravel()
    saturated = start >= scene.limit
    elastic = (start > 0) & ~saturated
    for _ in range(rounds):
        pressure, level = _on_active_set(scene, elastic, saturated)
        if pressure is None:
            return None
        rounding = 1e-17 * np.abs(level).max()
        too_low, too_high = elastic & (pressure < 0), elastic & (pressure > scene.limit)
        closing = scene.measured & ~elastic & ~saturated & (level < -rounding)
        opening = saturated & (level > rounding)
        if not (too_low | too_high | closing | opening).any():
            return pressure
        elastic = (elastic | closing | opening) & ~too_low & ~too_high
        saturated = (saturated | too_high) & ~opening
    return None


def _on_active_set(scene, elastic, saturated):
    """Pressure and gap with zero gap on elastic cells, the limit on saturated ones and none on the others."""
    pressure = np.where(saturated, scene.limit, Long(0))
    index = np.flatnonzero(elastic)
    right = -(scene.gap + scene.matrix @ pressure)[index]
    system, count = scene.matrix[np.ix_(index, index)], len(index)
    if scene.approach is None:
        if count == 0:
            return None, None
        # The approach is the last unknown; rows and columns are brought to one size.
        unit = system.diagonal().max()
        system = np.block([[system / unit, -np.ones((count, 1))], [np.ones((1, count)), np.zeros((1, 1))]])
        right = np.append(right / unit, scene.load - pressure.sum())
        found = _solve(system, right)
        approach = found[-1] * unit
    else:
        approach = scene.approach
        found = _solve(system, right + approach)
    pressure[index] = found[:count]
    return pressure, scene.matrix @ pressure + scene.gap - approach


def _solve(matrix, right):
    """Gauss elimination with pivots: numpy's linear algebra knows no extended precision."""
    rows = np.column_stack([matrix, right]).astype(Long)
    count = len(right)
    for k in range(count):
        best = k + int(np.abs(rows[k:, k]).argmax())
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, k]
        others = np.arange(count) != k
        rows[others] -= rows[others, k][:, None] * rows[k]
    return rows[:, -1]
