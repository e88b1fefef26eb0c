"""Bodies of several materials on cells: layers, and the moduli of cells that a boundary cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import attrs
import numpy as np
import roughcontact as rc
from roughcontact.typing import Array, IntArray

from roughcontact_volume.shapes import Shape, Triple, check_place, find_fractions

Mixture: TypeAlias = Literal["softer", "middle", "stiffer"]
# Bulk and shear moduli over those of the body.
MAX_CONTRAST = 10.0


def find_bulk_modulus(young: float | Array, poisson: float | Array) -> float | Array:
    """Return the bulk modulus, Pa."""
    return young / (3.0 * (1.0 - 2.0 * poisson))


def find_shear_modulus(young: float | Array, poisson: float | Array) -> float | Array:
    """Return the shear modulus, Pa."""
    return young / (2.0 * (1.0 + poisson))


def check_contrast(young: float | Array, poisson: float | Array, body: rc.Elastic) -> None:
    """Raise `InputError` where moduli are more than ten times those of the body, or less than a tenth."""
    for name, find in (("bulk", find_bulk_modulus), ("shear", find_shear_modulus)):
        ratio = np.asarray(find(young, poisson) / find(body.young, body.poisson))
        low, high = float(ratio.min()), float(ratio.max())
        if low < (1.0 - 1e-9) / MAX_CONTRAST or high > (1.0 + 1e-9) * MAX_CONTRAST:
            worst = low if low * MAX_CONTRAST < 1.0 else high
            raise rc.InputError.about(
                f"The {name} modulus of an inclusion over that of the body",
                worst,
                f"between {1.0 / MAX_CONTRAST:g} and {MAX_CONTRAST:g}",
                "Cavities and rigid inclusions are not covered.",
            )


@attrs.frozen(eq=False)
class Cells:
    """The cells of a body whose moduli differ from its own.

    Attributes
    ----------
    places
        Their places in fields of shape (nz, nx, ny), raveled.
    bulk, shear
        Their moduli over those of the body, by the mixture: keys ``"softer"``, ``"middle"``, ``"stiffer"``.
    """

    places: IntArray
    bulk: dict[str, Array]
    shear: dict[str, Array]

    @property
    def are_cut(self) -> bool:
        """Whether a boundary cuts any of them, so that its mixtures differ."""
        pairs = ((one["softer"], one["stiffer"]) for one in (self.bulk, self.shear))
        return any((softer != stiffer).any() for softer, stiffer in pairs)


def mix(fractions: Sequence[Array], bulk: Sequence[float], shear: Sequence[float]) -> Cells:
    """Return the cells of inclusions, by the fraction of each cell in each of them and by their moduli over the body's.

    The softer mixture is the harmonic mean by volume (Reuss), the stiffer one the arithmetic mean (Voigt), that in the
    middle half their sum (Hill, Proc. Phys. Soc. A 65 (1952) 349-354, https://doi.org/10.1088/0370-1298/65/5/307).
    """
    total = np.sum(fractions, axis=0)
    if total.max() > 1.0 + 1e-9:
        raise rc.InputError("Two inclusions overlap: move them apart.")
    places = np.flatnonzero(total)
    if places.size == 0:
        raise rc.InputError("The inclusions are smaller than a cell: refine the grid.")
    inside = [one.ravel()[places] for one in fractions]
    rest = 1.0 - total.ravel()[places]
    mixed = []
    for moduli in (bulk, shear):
        stiffer = rest + sum(f * m for f, m in zip(inside, moduli, strict=True))
        softer = 1.0 / (rest + sum(f / m for f, m in zip(inside, moduli, strict=True)))
        # Cells that no boundary cuts have their moduli to the last bit.
        softer = np.where(np.isclose(softer, stiffer, rtol=1e-12, atol=0.0), stiffer, softer)
        mixed.append({"softer": softer, "middle": 0.5 * (softer + stiffer), "stiffer": stiffer})
    return Cells(places, mixed[0], mixed[1])


def choose_interfaces(tops_and_bottoms: Sequence[tuple[float, float]], side: float) -> Array:
    """Return the depths between layers, from the surface, m.

    They are about as thick as the side of a cell where inclusions lie and beside them, elsewhere as the body between.
    """
    merged: list[list[float]] = []
    for top, bottom in sorted(tops_and_bottoms):
        if merged and top - merged[-1][1] < 3.0 * side:
            merged[-1][1] = max(bottom, merged[-1][1])
        else:
            merged.append([top, bottom])
    interfaces = [0.0]
    for top, bottom in merged:
        # Beside an inclusion the stress is found too.
        interfaces += [one for one in (top - 2.0 * side, top - side) if one > interfaces[-1] + 0.25 * side]
        count = max(1, math.ceil((bottom - top) / side - 1e-9))
        interfaces += [*np.linspace(top, bottom, count + 1), bottom + side, bottom + 2.0 * side]
    return np.array(interfaces)


def find_side(grid: rc.Grid) -> float:
    """Return the side of a square as large as a cell, m."""
    return math.sqrt(grid.cell_area)


def fill(shapes: Sequence[tuple[Shape, Triple]], grid: rc.Grid, boundary: rc.Boundary) -> tuple[Array, list[Array]]:
    """Return the interfaces of the layers that hold shapes, shape (nz + 1,), m, and the fractions of their cells."""
    for shape, centre in shapes:
        check_place(shape, centre, grid, boundary)
    ends = [(centre[2] - shape.half_lengths[2], centre[2] + shape.half_lengths[2]) for shape, centre in shapes]
    interfaces = choose_interfaces(ends, find_side(grid))
    return interfaces, [find_fractions(shape, centre, grid, boundary, interfaces) for shape, centre in shapes]
