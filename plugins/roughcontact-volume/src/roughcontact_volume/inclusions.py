"""Inclusions below a surface: regions of other moduli, solved together with the contact."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.results import Condition
from roughcontact.typing import Array, LoadIncrement, Part, Quantity

from roughcontact_volume.equivalent_strain import Contrast, find_eigenstrain, measure, split
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
from roughcontact_volume.shapes import Shape, Triple, read_triple

Memory = Mapping[str, Array]
# Largest violation of the law of a material, over the largest stress: of the state, and of the bounds of its numbers.
_TOLERANCE = 1e-5
_BOUND_TOLERANCE = 1e-4
# Error of a contact over that of the eigenstrain, and its largest.
_INNER_ERROR = 0.03
_LOOSEST_INNER = 1e-3
_KERNELS = (rc.Love, rc.FourierHalfSpace)
_MEANING = (
    "stress less the moduli of its cell times its strain, over the mean moduli of cell and body and the largest stress"
)
_BOUNDS = ("approach", "peak pressure", "von Mises stress")


def _young(value: Quantity) -> float:
    return rc.Elastic(value, 0.0).young


def _poisson(value: Quantity) -> float:
    return rc.Elastic(1.0, value).poisson


def _shape(value: object) -> Shape:
    if not isinstance(value, Shape):
        raise rc.InputError.about("The shape of an inclusion", value, "a Sphere, an Ellipsoid or a Cuboid")
    return value


def _centre(value: object) -> Triple:
    return read_triple(value, "The centre of an inclusion")


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

    shape: Shape = attrs.field(converter=_shape)
    young: float = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})
    centre: Triple = attrs.field(converter=_centre, metadata={"unit": "m"})


def _inclusions(value: object) -> tuple[Inclusion, ...]:
    found = tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,)
    if not found or not all(isinstance(one, Inclusion) for one in found):
        raise rc.InputError.about("The inclusions", value, "an Inclusion or a list of them")
    return found


def _side(value: object) -> str:
    if value not in ("body", "counterbody"):
        raise rc.InputError.about("The body of the inclusions", value, "'body' or 'counterbody'")
    return str(value)


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
        An `Inclusion` or several that do not overlap.
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

    inclusions: tuple[Inclusion, ...] = attrs.field(converter=_inclusions)
    side: str = attrs.field(default="body", converter=_side, kw_only=True)

    rates: ClassVar[tuple[str, ...]] = ()
    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {
        "eigenstrain": ("eigenstrain of the cells of the inclusions", ""),
        "bounds": (f"{', '.join(_BOUNDS)} with the softer and with the stiffer mixture of cut cells", ""),
    }
    default_area: ClassVar[str] = ""

    def start(self, problem: Any) -> Memory:
        """Return no eigenstrain; see `CoupledProcess.start`."""
        count = self._find_region(problem).cells.places.size
        return {"eigenstrain": np.zeros((6, count)), "bounds": np.zeros((2, len(_BOUNDS)))}

    def change_gap(self, problem: Any, increment: LoadIncrement, memory: Memory) -> Array:
        """Return the displacement of the surface by the eigenstrain, m; see `Law.change_gap`."""
        return self._find_region(problem).displace(memory["eigenstrain"])

    def settle(self, problem: Any, press: Any, increment: LoadIncrement, memory: Memory) -> Memory:
        """Return the eigenstrain under the load of an increment; see `CoupledProcess.settle`."""
        region = self._find_region(problem)
        tolerance = problem.plan.solver.tolerance
        found, _ = _press_region(region, press, "middle", memory["eigenstrain"], _TOLERANCE, tolerance)
        bounds = []
        for mixture in ("softer", "stiffer"):
            strain, contact = _press_region(region, press, mixture, found, _BOUND_TOLERANCE, tolerance)
            stress = region.find_largest_von_mises(contact.pressure, strain)
            bounds.append([contact.approach, float(contact.pressure.max()), stress])
        return {"eigenstrain": found, "bounds": np.array(bounds)}

    def judge(
        self, problem: Any, state: Any, increment: LoadIncrement, before: Memory, after: Memory
    ) -> Iterable[Condition]:
        """Return how well the stress of each cell is that of its moduli; see `CoupledProcess.judge`."""
        region = self._find_region(problem)
        strain = after["eigenstrain"]
        stress = region.find_stress(state.pressure, strain)
        contrast = region.find_contrast("middle")
        error = contrast.measure(contrast.find_step(stress, strain)) / max(measure(stress), np.finfo(float).tiny)
        return [Condition("inclusions", error, _MEANING)]

    def list_numbers(self, state: Any, memory: Memory) -> Mapping[str, rc.Estimate | tuple[float, str]]:
        """Return approach, maximum pressure and stress, each between the two mixtures, with half their distance."""
        low, high = memory["bounds"]
        value, half = 0.5 * (low + high), 0.5 * np.abs(high - low)
        numbers = zip(("approach", "peak_pressure", "von_mises"), value, half, ("m", "Pa", "Pa"), strict=True)
        return {f"{name}_with_inclusions": rc.Estimate(float(v), float(h), unit) for name, v, h, unit in numbers}

    def _find_region(self, problem: Any) -> Region:
        body = getattr(problem, self.side)
        require_possible(problem, body.material)
        return find_region(
            self.inclusions, problem.plan.grid, problem.boundary, body.material.young, body.material.poisson
        )


def require_possible(problem: Any, material: Any) -> None:
    """Raise `InputError` where inclusions are not solved with the parts of a problem."""
    if type(material) is not rc.Elastic:
        raise rc.InputError(
            f"Inclusions lie in an Elastic body, but its material is {material!r}: a body that yields, relaxes or "
            "has a hardness is not solved with them."
        )
    kernel = problem.plan.kernel
    if not isinstance(kernel, _KERNELS):
        raise rc.InputError(
            f"The stress below the surface is known for a homogeneous half-space, but not for the kernel {kernel!r}: "
            "omit kernel=, or the inclusions."
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

    def find_largest_von_mises(self, pressure: Array, strain: Array) -> float:
        """Return the largest von Mises stress in and beside the inclusions, Pa."""
        return np.sqrt(1.5) * measure(split(self.find_field(pressure, strain)[:, 1:])[1])

    def spread(self, strain: Array) -> Array:
        """Return an eigenstrain of its cells in all layers, shape (6, nz, nx, ny)."""
        field = np.zeros((6, int(np.prod(self.operators.shape[1:]))))
        field[:, self.cells.places] = strain
        return field.reshape(self.operators.shape)

    def find_contrast(self, mixture: Mixture) -> Contrast:
        """Return the moduli of its cells by a mixture."""
        thicknesses = self.operators.thicknesses
        layers = self.cells.places // self.operators.grid.cells
        return Contrast(
            bulk=self.cells.bulk[mixture],
            shear=self.cells.shear[mixture],
            bulk_modulus=float(find_bulk_modulus(self.operators.young, self.operators.poisson)),
            shear_modulus=float(find_shear_modulus(self.operators.young, self.operators.poisson)),
            weights=thicknesses[layers] / thicknesses[layers[0]],
        )


@lru_cache(maxsize=4)
def find_region(
    inclusions: tuple[Inclusion, ...], grid: rc.Grid, boundary: rc.Boundary, young: float, poisson: float
) -> Region:
    """Return the cells of inclusions in a body."""
    body = rc.Elastic(young, poisson)
    for one in inclusions:
        check_contrast(one.young, one.poisson, body)
    interfaces, fractions = fill([(one.shape, one.centre) for one in inclusions], grid, boundary)
    bulk = [float(find_bulk_modulus(one.young, one.poisson) / find_bulk_modulus(young, poisson)) for one in inclusions]
    shear = [
        float(find_shear_modulus(one.young, one.poisson) / find_shear_modulus(young, poisson)) for one in inclusions
    ]
    operators = VolumeOperators(grid, boundary, np.diff(interfaces), young, poisson)
    return Region(operators, mix(fractions, bulk, shear))


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
