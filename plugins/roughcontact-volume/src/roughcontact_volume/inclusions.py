"""Inclusions below a surface: regions of other moduli, solved together with the contact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import Condition
from roughcontact.typing import Array, LoadIncrement, Part, Quantity

from roughcontact_volume.equivalent_strain import Contrast, find_eigenstrain, measure
from roughcontact_volume.given_strains import StrainedRegion
from roughcontact_volume.material_field import MaterialField
from roughcontact_volume.mixtures import (
    Cells,
    Mixture,
    check_contrast,
    fill,
    find_bulk_modulus,
    find_shear_modulus,
    mix,
)
from roughcontact_volume.operators import VolumeOperators
from roughcontact_volume.radial_return import find_equivalent
from roughcontact_volume.refusals import require_uniform
from roughcontact_volume.shapes import Shape, Triple, read_centre, read_shape, read_side

Memory = Mapping[str, Array]
# Largest violation of the law of a material, over the largest stress: of the state, and of the bounds of its numbers.
_TOLERANCE = 1e-5
_BOUND_TOLERANCE = 1e-4
# Largest violation with which a state counts as solved.
_MAX_ERROR = 1e-3
# Error of a contact over that of the eigenstrain, and its largest.
_INNER_ERROR = 0.03
_LOOSEST_INNER = 1e-3
_MEANING = (
    "stress less the moduli of its cell times its strain, over the mean moduli of cell and body and the largest stress"
)
# What is remembered of the contact with each mixture: name and unit; the last is the error of the one before by cells.
_BOUNDS = {"approach": "m", "peak pressure": "Pa", "von Mises stress": "Pa", "change of it from cell to cell": "Pa"}


def _young(value: Quantity) -> float:
    return rc.Elastic(value, 0.0).young


def _poisson(value: Quantity) -> float:
    return rc.Elastic(1.0, value).poisson


@attrs.frozen
class Inclusion(Part):
    """A region of other moduli in a body, bonded to it.

    Parameters
    ----------
    shape
        A `Sphere`, an `Ellipsoid` or a `Cuboid`.
    young, poisson
        Its Young's modulus, Pa, and Poisson's ratio.
    centre
        Its centre (x, y, depth), m; x and y from the middle of the domain.

    Examples
    --------
    >>> from roughcontact_volume import Inclusion, Sphere
    >>> Inclusion(Sphere("20um"), "390GPa", 0.2, centre=(0.0, 0.0, "50um")).centre
    (0.0, 0.0, 5e-05)
    """

    shape: Shape = attrs.field(converter=read_shape)
    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})
    centre: Triple = attrs.field(converter=read_centre, metadata={"unit": "m"})


def _inclusions(value: object) -> tuple[Inclusion, ...] | MaterialField:
    if isinstance(value, MaterialField):
        return value
    found = tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,)
    if not found or not all(isinstance(one, Inclusion) for one in found):
        raise rc.InputError.about("The inclusions", value, "an Inclusion, a list of them, or a MaterialField")
    return found


@attrs.frozen
class Inclusions(rc.CoupledProcess):
    r"""Inclusions in a body, a law of a problem: they change its pressure, its approach and the stress in and by them.

    Each acts on the uniform body as an eigenstrain (Eshelby's equivalent inclusion, cell by cell), solved with the
    contact inside:

    .. math:: \sigma = S p + T e, \qquad \sigma = C_i (C^{-1} \sigma + e)

    Cells that a boundary cuts mix the moduli by volume. The state has the mean of the arithmetic and the harmonic
    mixture. Both are solved too: their answers enclose the one with sharp boundaries, and half their distance is the
    uncertainty of the numbers `list_numbers`.

    Parameters
    ----------
    inclusions
        An `Inclusion` or several that do not overlap; or a `MaterialField`, whose cells are taken as they are.
    side
        The body in which they lie, ``"body"`` or ``"counterbody"``.

    References
    ----------
    Eshelby, Proc. R. Soc. Lond. A 241 (1957) 376-396, https://doi.org/10.1098/rspa.1957.0133

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact_volume import Inclusion, Inclusions, Sphere
    >>> oxide = Inclusion(Sphere("20um"), "390GPa", 0.2, centre=(0.0, 0.0, "35um"))
    >>> ball = rc.Body(rc.SphereSurface("5mm"), rc.Elastic("210GPa", 0.3))
    >>> grid = rc.Grid((32, 32), "200um")
    >>> problem = rc.ContactProblem(ball, grid=grid, laws=Inclusions([oxide]))
    >>> problem.solve(force="10N").certificate.error < 1e-4
    True
    """

    inclusions: tuple[Inclusion, ...] | MaterialField = attrs.field(converter=_inclusions)
    side: str = attrs.field(default="body", converter=read_side, kw_only=True)

    rates: ClassVar[tuple[str, ...]] = ()
    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {
        "eigenstrain": ("eigenstrain of the cells of the inclusions", ""),
        "bounds": (f"{', '.join(_BOUNDS)} with the softer and with the stiffer mixture of cut cells", ""),
    }
    default_area: ClassVar[str] = ""

    def start(self, problem: Any) -> Memory:
        """Return no eigenstrain; see `CoupledProcess.start`."""
        others = [law for law in problem.laws if isinstance(law, StrainedRegion)]
        if others:
            raise rc.InputError(
                f"Inclusions are solved in a body without other strain below its surface: omit {others[0]!r}."
            )
        count = self._find_region(problem).cells.places.size
        return {"eigenstrain": np.zeros((6, count)), "bounds": np.zeros((2, len(_BOUNDS)))}

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return the displacement of the surface by the eigenstrain, m; see `Law.change_gap`."""
        return self._find_region(problem).displace(memory["eigenstrain"])

    def settle(self, problem: Any, press: Any, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the eigenstrain under the load of an increment; see `CoupledProcess.settle`."""
        region = self._find_region(problem)
        finest = problem.plan.solver.tolerance
        strain, contact = _press_region(region, press, "middle", memory["eigenstrain"], _TOLERANCE, finest)
        ends = [(strain, contact)] * 2
        if region.cells.are_cut:
            ends = [
                _press_region(region, press, mixture, strain, _BOUND_TOLERANCE, finest)
                for mixture in ("softer", "stiffer")
            ]
        bounds = [
            [end.approach, float(end.pressure.max()), *region.find_largest_von_mises(end.pressure, one)]
            for one, end in ends
        ]
        return {"eigenstrain": strain, "bounds": np.array(bounds)}

    def judge(
        self, problem: Any, state: Any, increment: LoadIncrement, before: Memory, after: Memory
    ) -> Iterable[Condition]:
        """Return how well the stress of each cell is that of its moduli; see `CoupledProcess.judge`."""
        region = self._find_region(problem)
        strain = after["eigenstrain"]
        stress = region.find_stress(state.pressure, strain)
        contrast = region.find_contrast("middle")
        error = contrast.measure(contrast.find_step(stress, strain)) / max(measure(stress), np.finfo(float).tiny)
        return [Condition("inclusions", error, _MEANING, tolerance=_MAX_ERROR)]

    def list_numbers(self, state: Any, memory: Memory) -> Mapping[str, rc.Estimate]:
        """Return approach, maximum pressure and stress, each between the two mixtures, with half their distance.

        The largest von Mises stress is that of the cells in and beside the inclusions: its uncertainty has their change
        to the next cells too, since it lies at a boundary. The error of the contact by its cells is not among them:
        `find_inclusion_answers` adds it.
        """
        low, high = memory["bounds"]
        value, half = 0.5 * (low + high), 0.5 * np.abs(high - low)
        half[2] = math.hypot(half[2], value[3])
        numbers = zip(("approach", "peak_pressure", "von_mises"), value, half, _BOUNDS.values(), strict=False)
        return {f"{name}_with_inclusions": rc.Estimate(float(v), float(h), unit) for name, v, h, unit in numbers}

    def explain_limits(self, memory: Memory) -> Mapping[str, str]:
        """Return that the body is not uniform; see `Law.explain_limits`."""
        return {
            "inner stress": "inclusions change the stress below the surface: ask for find_inclusion_answers",
            "inner moduli": "inclusions change how the body answers a load: take the difference of two loads",
        }

    def _find_region(self, problem: Any) -> Region:
        body = getattr(problem, self.side)
        require_uniform(problem, body.material, "An inclusion")
        return find_region(
            self.inclusions, problem.plan.grid, problem.boundary, body.material.young, body.material.poisson
        )


@attrs.frozen(eq=False)
class Region:
    """The cells of inclusions, and the operators of the body around them."""

    operators: VolumeOperators
    cells: Cells

    def displace(self, strain: Array) -> Array:
        """Return the displacement of the surface, shape (nx, ny), m, by an eigenstrain of its cells, (6, cells)."""
        if not strain.any():
            return np.zeros(self.operators.grid.shape)
        return self.operators.displace(self.spread(strain))

    def find_stress(self, pressure: Array, strain: Array) -> Array:
        """Return the stress of its cells, shape (6, cells), Pa."""
        return self.find_field(pressure, strain).reshape(6, -1)[:, self.cells.places]

    def find_field(self, pressure: Array, strain: Array) -> Array:
        """Return the stress in all layers, shape (6, nz, nx, ny), Pa."""
        return self.operators.press(pressure) + self.operators.find_stress(self.spread(strain))

    def find_largest_von_mises(self, pressure: Array, strain: Array) -> tuple[float, float]:
        """Return the largest von Mises stress in and beside the inclusions, Pa, and its fall to the next cells."""
        # Above them one thick layer lies.
        stress = find_equivalent(self.find_field(pressure, strain)[:, 1:])
        place = np.unravel_index(int(stress.argmax()), stress.shape)
        around = tuple(slice(max(0, at - 1), at + 2) for at in place)
        lowest = min(
            float(stress[tuple(around[k] if k == axis else place[k] for k in range(3))].min()) for axis in range(3)
        )
        return float(stress.max()), float(stress.max()) - lowest

    def spread(self, strain: Array) -> Array:
        """Return an eigenstrain of its cells in all layers, shape (6, nz, nx, ny)."""
        field = np.zeros((6, int(np.prod(self.operators.shape[1:]))))
        field[:, self.cells.places] = strain
        return field.reshape(self.operators.shape)

    def find_contrast(self, mixture: Mixture) -> Contrast:
        """Return the moduli of its cells by a mixture."""
        return Contrast(
            bulk=self.cells.bulk[mixture],
            shear=self.cells.shear[mixture],
            bulk_modulus=float(find_bulk_modulus(self.operators.young, self.operators.poisson)),
            shear_modulus=float(find_shear_modulus(self.operators.young, self.operators.poisson)),
        )


@lru_cache(maxsize=4)
def find_region(
    inclusions: tuple[Inclusion, ...] | MaterialField,
    grid: rc.Grid,
    boundary: rc.Boundary,
    young: float,
    poisson: float,
) -> Region:
    """Return the cells of inclusions in a body."""
    body = rc.Elastic(young, poisson)
    if isinstance(inclusions, MaterialField):
        interfaces, cells = inclusions.find_cells(grid, body)
    else:
        interfaces, cells = _mix_inclusions(inclusions, grid, boundary, body)
    return Region(VolumeOperators(grid, boundary, np.diff(interfaces), young, poisson), cells)


def _mix_inclusions(
    inclusions: tuple[Inclusion, ...], grid: rc.Grid, boundary: rc.Boundary, body: rc.Elastic
) -> tuple[Array, Cells]:
    for one in inclusions:
        check_contrast(one.young, one.poisson, body)
    interfaces, fractions = fill([(one.shape, one.centre) for one in inclusions], grid, boundary)
    bulk, shear = (
        [float(find(one.young, one.poisson) / find(body.young, body.poisson)) for one in inclusions]
        for find in (find_bulk_modulus, find_shear_modulus)
    )
    return interfaces, mix(fractions, bulk, shear)


def _press_region(
    region: Region, press: Any, mixture: Mixture, start: Array, tolerance: float, finest: float
) -> tuple[Array, Any]:
    """Return the eigenstrain of a mixture under the load, and the contact with it."""
    contact = None

    def find_stress(strain: Array, error: float) -> Array:
        nonlocal contact
        inner = min(max(_INNER_ERROR * error, finest), max(_LOOSEST_INNER, finest))
        contact = press(region.displace(strain), tolerance=inner)
        return region.find_stress(contact.pressure, strain)

    strain = find_eigenstrain(region.find_contrast(mixture), find_stress, start, tolerance)
    return strain, contact
