"""Reynolds' equation on the open cells: a network of conductances, its pressures, and how far cells resolve it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from roughcontact._answers.flow.dissection import dissect
from roughcontact._answers.flow.faces import Faces, make_faces
from roughcontact._base.arrays import Array, Mask, RealArray, sum_of_products
from roughcontact.errors import MissingPackage

# Gap over the widest gap below which float64 does not tell it from zero.
MIN_FILM_RATIO = 1e-14
# Neighbours of a cell: liquid passes through sides, not through corners.
SIDE_NEIGHBOURS = np.array(((0, 1, 0), (1, 1, 1), (0, 1, 0)), dtype=bool)
# Cells up to which elimination is used, 2048 x 2048 with 30 % in contact: it then takes 2.7 GiB and a third of the time
# of conjugate gradients, and needs no package and no stopping rule.
MAX_ELIMINATION_CELLS = 3_000_000
# Unknowns from which SuperLU is faster with panels, and their width: 2.2 s for 3.6 s on 512 x 512 cells.
_MIN_PANEL_CELLS = 60_000
_PANEL_WIDTH = 8
# Cells from which nested dissection of the whole grid is faster, if so many of the grid are open: 9 s for 20 s on
# 1024 x 1024 with 1 % in contact. With few open ones SuperLU is.
_MIN_DISSECTED_CELLS = 100_000
_MIN_DISSECTED_FRACTION = 0.92
# Conjugate gradients end at this residual over the right side, once the flow changes by less over so many iterations
# and inflow and outflow agree. The residual alone hides throats: at 1e-4 the flow is up to 58 % too large.
_RESIDUAL_TOLERANCE = 1e-6
_FLOW_TOLERANCE = 1e-4
_STEADY_ITERATIONS = 5
_MAX_ITERATIONS = 300
# Weights of the three measures of the uncertainty (`estimate_uncertainty`), set on 215 flows through 64 smooth and 66
# machined gaps (draw 91 of benchmarks/edged_classes.py, against cells a quarter as long) by their likelihood, and a
# tenth larger. Other draws confirm them (docs/use/leakage.md).
_THROAT_WEIGHT = 0.55
_RULE_WEIGHT = 0.27
_WALL_WEIGHT = 0.2
# Weight of the change of the flow between the rules of grooves with creases and of other heights, set on machined gaps
# of draw 503 of the same.
_CREASED_WEIGHT = 0.5
# Cells beyond a periodic border in which the nearest contact is searched.
_MAX_PADDING_CELLS = 16


@attrs.frozen(eq=False)
class Ends:
    """The cells at both ends of a network.

    Attributes
    ----------
    inlet, outlet
        Their positions.
    inlet_conductance, outlet_conductance
        Conductances of the half cells between their centres and the border.
    """

    inlet: RealArray
    outlet: RealArray
    inlet_conductance: Array
    outlet_conductance: Array


@attrs.frozen(eq=False)
class FlowNetwork:
    """The open cells that join both ends of the domain; liquid flows along axis 0 of its arrays.

    Conductances are dimensionless: a face between square cells with the widest gap has 1.

    Attributes
    ----------
    shape
        Cells (along, across) the flow.
    widest
        The widest gap, m.
    aspect
        Length of a cell across the flow over its length along it.
    wraps
        Whether the gap repeats beyond its borders, (along, across) the flow.
    cells
        Flat indices of the open cells that join both ends, ascending.
    film
        Gap of each of these cells over the widest gap.
    faces
        Faces between these cells.
    conductance
        Conductance of each face.
    ends
        The cells at both ends.
    """

    shape: tuple[int, int]
    widest: float
    aspect: float
    wraps: tuple[bool, bool]
    cells: RealArray
    film: Array
    faces: Faces
    conductance: Array
    ends: Ends

    @property
    def resolved_aspect(self) -> float:
        """The aspect of cells that resolve both axes; 1 of a single line of cells, which is even along the other."""
        return self.aspect if min(self.shape) > 1 else 1.0

    def make_matrix(self) -> Any:
        """Return the matrix of the flow balance of each cell, in CSR."""
        from scipy import sparse

        first = self.faces.first
        second = self.faces.second
        c = self.find_exchange()
        outlet = self.ends.outlet, self.ends.outlet_conductance
        diagonal = self.find_inflow() + self.gather((first, c), (second, c), outlet)
        each = np.arange(self.cells.size, dtype=np.int32)
        rows = np.concatenate((first, second, each))
        columns = np.concatenate((second, first, each))
        entries: Any = (np.concatenate((-c, -c, diagonal)), (rows, columns))
        return sparse.csr_matrix(entries, shape=(each.size, each.size))

    def find_inflow(self) -> Array:
        """Return the flow into each cell from the inlet at 1: the right side of the balances."""
        return self.gather((self.ends.inlet, self.ends.inlet_conductance))

    def find_exchange(self) -> Array:
        """Return the conductance of each face; zero where a single line of cells wraps and joins each to itself."""
        return np.where(self.faces.first == self.faces.second, 0.0, self.conductance)

    def gather(self, *parts: tuple[RealArray, Array]) -> Array:
        """Return the sum of values at positions for each cell."""
        count = self.cells.size
        sums = (np.bincount(where, values, count) for where, values in parts)
        return np.asarray(sum(sums), dtype=np.float64)

    def find_flow(self, pressure: Array) -> Array:
        """Return the flow through each face, from its first to its second cell."""
        return np.asarray(self.conductance * self._find_drops(pressure))

    def _find_drops(self, pressure: Array) -> Array:
        """Return the pressure in the first cell of each face less that in the second."""
        return np.asarray(pressure[self.faces.first] - pressure[self.faces.second])

    def find_ends(self, pressure: Array) -> tuple[float, float]:
        """Return the flow in at the inlet and the flow out at the outlet."""
        into, out = self._find_end_flows(pressure)
        return float(np.sum(into)), float(np.sum(out))

    def _find_end_flows(self, pressure: Array) -> tuple[Array, Array]:
        """Return the flow into each cell at the inlet, and out of each cell at the outlet."""
        return self.ends.inlet_conductance * (1.0 - pressure[self.ends.inlet]), self.ends.outlet_conductance * pressure[
            self.ends.outlet
        ]

    def residual(self, pressure: Array) -> Array:
        """Return the flow into each cell less the flow out of it."""
        faces = self.find_flow(pressure)
        into, out = self._find_end_flows(pressure)
        inner = (self.faces.second, faces), (self.faces.first, -faces)
        return self.gather(*inner, (self.ends.inlet, into), (self.ends.outlet, -out))

    def dissipation(self, pressure: Array) -> tuple[Array, Array]:
        """Return the power lost in each face and in each cell: they sum to the flow at unit pressure."""
        faces, lost = self.spread_loss(self._find_drops(pressure))
        into = self.ends.inlet_conductance * (1.0 - pressure[self.ends.inlet]) ** 2
        out = self.ends.outlet_conductance * pressure[self.ends.outlet] ** 2
        return faces, lost + self.gather((self.ends.inlet, into), (self.ends.outlet, out))

    def spread_loss(self, drops: Array) -> tuple[Array, Array]:
        """Return the power lost in each face, over which the pressure drops, and in the halves of each cell.

        A face joins half of either cell in series, so that the tighter cell loses more.
        """
        faces = self.conductance * drops**2
        first = self.faces.first_film**3
        second = self.faces.second_film**3
        part = faces * second / (first + second)
        return faces, self.gather((self.faces.first, part), (self.faces.second, faces - part))

    def find_flow_of_cells(self, pressure: Array) -> tuple[Array, Array]:
        """Return the flow through each cell along and across: the mean of the flows through its two faces."""
        half = 0.5 * self.find_flow(pressure)
        fields = np.zeros((2, *self.shape))
        one = slice(None, self.faces.along)
        other = slice(self.faces.along, None)
        into, out = self._find_end_flows(pressure)
        ends = (self.ends.inlet, 0.5 * into), (self.ends.outlet, 0.5 * out)
        for field, part, extra in ((fields[0], one, ends), (fields[1], other, ())):
            faces = (self.faces.first[part], half[part]), (self.faces.second[part], half[part])
            field.reshape(-1)[self.cells] = self.gather(*faces, *extra)
        return fields[0], fields[1]


def make_network(
    gap: Array, open_cells: Mask, *, aspect: float, periodic: bool, creased: float = 0.0
) -> FlowNetwork | None:
    """Return the network of the open cells, or None if no path of cell sides joins both ends.

    Parameters
    ----------
    gap, open_cells
        Gap, and the cells that are not in contact, shape (along, across) the flow.
    aspect
        Length of a cell across the flow over its length along it.
    periodic
        Whether the gap repeats across the flow.
    creased
        How far the heights have grooves with creases, from 0 to 1 (`find_creases`).
    """
    widest = float(gap.max(where=open_cells, initial=0.0))
    if widest <= 0.0:
        return None
    film = np.where(open_cells, gap / widest, 0.0)
    kept = find_paths(film > MIN_FILM_RATIO, periodic=periodic)
    if not kept.any():
        return None
    number = number_cells(kept)
    inlet, outlet = (row[row >= 0] for row in (number[0], number[-1]))
    first, last = (2.0 * aspect * film[row][kept[row]] ** 3 for row in (0, -1))
    ends = Ends(inlet, outlet, first, last)
    return join_cells(film, number, ends, widest=widest, aspect=aspect, wraps=(False, periodic), creased=creased)


def number_cells(kept: Mask) -> RealArray:
    """Return the position of each cell in a network of these cells, -1 for the others."""
    number = np.full(kept.shape, -1, dtype=np.int32)
    number[kept] = np.arange(np.count_nonzero(kept), dtype=np.int32)
    return number


def join_cells(
    film: Array,
    number: RealArray,
    ends: Ends,
    *,
    widest: float,
    aspect: float,
    wraps: tuple[bool, bool],
    creased: float = 0.0,
) -> FlowNetwork:
    """Return the network of numbered cells; film is the gap over the widest one, zero in closed cells.

    `creased` is that of `make_faces`.
    """
    faces = make_faces(film, number, steps=(1.0, aspect), wraps=wraps, creased=creased)
    conductance = faces.find_cubes()
    conductance[: faces.along] *= aspect
    conductance[faces.along :] /= aspect
    cells = np.flatnonzero(number >= 0)
    return FlowNetwork(film.shape, widest, aspect, wraps, cells, film.reshape(-1)[cells], faces, conductance, ends)


def find_paths(open_cells: Mask, *, periodic: bool, corners: bool = False) -> Mask:
    """Return the open cells of paths that join the first and the last row.

    Parameters
    ----------
    open_cells
        Shape (along, across) the flow.
    periodic
        Whether the domain repeats beyond its borders beside the flow.
    corners
        Whether a path may also pass through corners of cells.
    """
    from scipy import ndimage, sparse

    labels, count = ndimage.label(open_cells, structure=np.ones((3, 3), dtype=bool) if corners else SIDE_NEIGHBOURS)
    piece: RealArray = np.arange(count + 1)
    if periodic and count:
        one = labels[:, -1]
        other = labels[:, 0]
        if corners:
            one = np.tile(one, 3)
            other = np.concatenate([other, _shift_row(other, 1), _shift_row(other, -1)])
        both = (one > 0) & (other > 0)
        links = sparse.coo_matrix((np.ones(both.sum()), (one[both], other[both])), shape=(count + 1, count + 1))
        piece = sparse.csgraph.connected_components(links, directed=False)[1]
    first, last = (np.unique(piece[row[row > 0]]) for row in (labels[0], labels[-1]))
    joined = np.isin(piece, np.intersect1d(first, last))
    joined[0] = False
    return np.asarray(joined[labels])


def _shift_row(values: RealArray, step: int) -> RealArray:
    """Return values moved by one step along the row, with zero at the end that becomes free."""
    moved = np.roll(values, step)
    moved[0 if step == 1 else -1] = 0
    return moved


def solve_network(network: FlowNetwork) -> tuple[Array, bool]:
    """Return the pressure in each cell, 1 at the inlet and 0 at the outlet, and whether the flow has converged."""
    if network.cells.size <= MAX_ELIMINATION_CELLS:
        return eliminate(network), True
    return iterate(network)


def eliminate(network: FlowNetwork) -> Array:
    """Return the pressure by elimination, with one step of refinement."""
    right = network.find_inflow()
    solve = factor(network)
    pressure = solve(right[:, np.newaxis])[:, 0]
    return np.asarray(pressure + solve(network.residual(pressure)[:, np.newaxis])[:, 0])


def factor(network: FlowNetwork) -> Callable[[Array], Array]:
    """Return what solves the balances for flows into the cells, shape (cells, one or two right sides)."""
    if network.cells.size >= max(_MIN_DISSECTED_CELLS, _MIN_DISSECTED_FRACTION * math.prod(network.shape)):
        try:
            return _factor_grid(network)
        except np.linalg.LinAlgError:
            # Rounding of films that differ by many orders; the sparse elimination has no roots to take.
            pass
    return factor_cells(network)


def _factor_grid(network: FlowNetwork) -> Callable[[Array], Array]:
    """Return what solves the balances, by nested dissection of the whole grid; closed cells stand alone."""
    leak, beside, above = np.zeros((3, math.prod(network.shape)))
    leak[:] = 1.0
    leak[network.cells] = network.gather(
        (network.ends.inlet, network.ends.inlet_conductance), (network.ends.outlet, network.ends.outlet_conductance)
    )
    faces = network.faces
    from_cells = network.cells[faces.first]
    c = network.find_exchange()
    beside[from_cells[: faces.along]] = c[: faces.along]
    above[from_cells[faces.along :]] = c[faces.along :]
    factors = dissect(leak.reshape(network.shape), (beside.reshape(network.shape), above.reshape(network.shape)))

    def solve(given: Array) -> Array:
        right = np.zeros((leak.size, 2))
        right[network.cells, : given.shape[1]] = given
        return np.asarray(factors.solve(right)[network.cells, : given.shape[1]])

    return solve


def factor_cells(network: FlowNetwork) -> Callable[[Array], Array]:
    """Return what solves the balances, by sparse elimination of the cells alone.

    A checkerboard of cells is eliminated, then SuperLU the rest.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    matrix = network.make_matrix()
    # Cells of one colour are joined to those of the other alone, and so are known from these.
    i, j = np.divmod(network.cells, network.shape[1])
    is_known = (i + j) % 2 == 0
    # Around a periodic domain of an odd number of cells two of one colour meet.
    for place, count in zip((i, j), network.shape, strict=True):
        is_known[(place == count - 1) & (place % 2 == 0)] = False
    known = np.flatnonzero(is_known)
    rest = np.flatnonzero(~is_known)
    diagonal = matrix.diagonal()[:, np.newaxis]
    if rest.size == 0:
        return lambda given: np.asarray(given / diagonal)
    diagonal = diagonal[known]
    rows = matrix[rest]
    joined = rows[:, known]
    reduced = rows[:, rest] - joined @ sparse.diags_array(1.0 / diagonal[:, 0]) @ joined.T
    # Diagonally dominant and symmetric: no pivoting. Columns of small networks are too short for panels.
    width = 1 if rest.size < _MIN_PANEL_CELLS else _PANEL_WIDTH
    factors = splu(
        reduced.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        relax=width,
        panel_size=width,
        options={"SymmetricMode": True},
    )

    def solve(given: Array) -> Array:
        found = np.empty(given.shape)
        found[rest] = factors.solve(given[rest] - joined @ (given[known] / diagonal))
        found[known] = (given[known] - joined.T @ found[rest]) / diagonal
        return found

    return solve


def iterate(network: FlowNetwork) -> tuple[Array, bool]:
    """Return the pressure by conjugate gradients with smoothed aggregation, and whether the flow has converged."""
    matrix = network.make_matrix()
    right = network.find_inflow()
    precondition = _prepare_multigrid(matrix)
    pressure = np.zeros(right.size)
    residual = right.copy()
    corrected = precondition @ residual
    direction = corrected
    product = sum_of_products(residual, corrected)
    allowed = _RESIDUAL_TOLERANCE**2 * sum_of_products(right, right)
    flows = [np.inf]
    for _ in range(_MAX_ITERATIONS):
        pushed = matrix @ direction
        step = product / sum_of_products(direction, pushed)
        pressure += step * direction
        residual -= step * pushed
        into, out = network.find_ends(pressure)
        flows.append(into)
        steady = abs(into - flows[max(0, len(flows) - 1 - _STEADY_ITERATIONS)]) <= _FLOW_TOLERANCE * into
        if steady and abs(into - out) <= _FLOW_TOLERANCE * into and sum_of_products(residual, residual) <= allowed:
            return pressure, True
        corrected = precondition @ residual
        product, before = sum_of_products(residual, corrected), product
        direction = corrected + (product / before) * direction
    return pressure, False


def _prepare_multigrid(matrix: Any) -> Any:
    """Return one cycle of smoothed aggregation as an operator.

    Strength by the evolution of errors finds the throats: classical multigrid hardly converges on these matrices.
    """
    try:
        import pyamg
    except ImportError:
        raise MissingPackage(
            f"The flow through {matrix.shape[0]} cells needs the package pyamg: pip install 'roughcontact[flow]'."
        ) from None
    return pyamg.smoothed_aggregation_solver(matrix, strength="evolution").aspreconditioner()


def estimate_uncertainty(
    network: FlowNetwork,
    faces: Array,
    lost: Array,
    open_cells: Mask,
    *,
    gap_error: float,
) -> float:
    """Return one standard deviation of the flow over the flow.

    Means over the cells, weighted with the power that they lose, tell what matters: the change to another rule for
    the faces, and 1/d^2 and 1/d^3 of the distance d to the contact in cells. An edge that is a fraction of a cell off
    changes the gap beside it, and a wall of steps the flow along it.

    Parameters
    ----------
    network, faces, lost
        The network, and the power lost in its faces and cells.
    open_cells
        Cells that are not in contact, shape (along, across) the flow.
    gap_error
        Error of the gap by the residual of the contact, over the widest gap.
    """
    flow = float(lost.sum())
    rule = _compare_rules(network, faces, flow)
    # The longer sides of the cells place the edge of the contact.
    oblong = math.sqrt(max(network.resolved_aspect, 1.0 / network.resolved_aspect))
    near = oblong / _find_distances(network, open_cells)
    squared, cubed = (float(np.sum(lost * near**power)) / flow for power in (2, 3))
    residual = 3.0 * gap_error * float(np.sum(lost / network.film)) / flow
    throat = _THROAT_WEIGHT * math.sqrt(rule * cubed)
    creased = 0.0
    if network.faces.creased > 0.0:
        creased = _CREASED_WEIGHT * abs(float(np.sum(faces * network.faces.compare_cubes()))) / flow
    return math.hypot(throat, _RULE_WEIGHT * rule, _WALL_WEIGHT * squared, residual, creased)


def _compare_rules(network: FlowNetwork, faces: Array, flow: float) -> float:
    """Return how much the flow differs between films that are linear between two cells and harmonic means, over it.

    Both are bounds: of the linear film by the flow through each face as it is (Thomson's principle), of the harmonic
    mean by the pressures as they are (Dirichlet's).
    """
    ratio = network.faces.ratio
    weight = network.faces.weight
    linear, harmonic = (float(np.sum(faces * (1.0 - ratio**power))) / flow for power in (weight, 1.0 - weight))
    return max(1.0 / (1.0 - linear) - (1.0 - harmonic), 0.0)


def _find_distances(network: FlowNetwork, open_cells: Mask) -> Array:
    """Return the distance of each cell of the network to the contact, in cells; infinite without any."""
    from scipy import ndimage

    if open_cells.all():
        return np.full(network.cells.size, math.inf)
    pairs = zip(network.wraps, network.shape, strict=True)
    beyond = [min(_MAX_PADDING_CELLS, count) if wraps else 0 for wraps, count in pairs]
    extended = np.pad(open_cells, [(count, count) for count in beyond], mode="wrap")
    side = math.sqrt(network.resolved_aspect)
    distances = ndimage.distance_transform_edt(extended, sampling=(1.0 / side, side))
    i, j = np.divmod(network.cells, network.shape[1])
    return np.asarray(distances[i + beyond[0], j + beyond[1]], dtype=np.float64)
