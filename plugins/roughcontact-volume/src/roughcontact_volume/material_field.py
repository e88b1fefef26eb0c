"""Bodies whose moduli vary from cell to cell: arrays of a user, or drawn at random."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt
import roughcontact as rc
from roughcontact.typing import Array, Part, Quantity

from roughcontact_volume.mixtures import MAX_CONTRAST, Cells, check_contrast, find_bulk_modulus, find_shear_modulus


def _positive(values: object, what: str, unit: str, dimensions: int) -> Array:
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim != dimensions or found.size == 0 or not ((found > 0.0) & (found <= 1e60)).all():
        shape = "a list" if dimensions == 1 else "an array (nz, nx, ny)"
        raise rc.InputError.about(what, values, f"{shape} of finite numbers above 0 ({unit})")
    found.flags.writeable = False
    return found


def _young(values: object) -> Array:
    return _positive(values, "The Young's moduli of a MaterialField", "Pa", 3)


def _thicknesses(values: object) -> Array:
    return _positive(values, "The thicknesses of a MaterialField", "m", 1)


def _poisson(value: Quantity) -> float:
    return rc.Elastic(1.0, value).poisson


def _depth(value: object) -> float:
    found = float(value) if isinstance(value, (int, float, np.integer, np.floating)) else -1.0
    if isinstance(value, bool) or not 0.0 <= found <= 1e60:
        raise rc.InputError.about("The depth of a MaterialField", value, "a finite number, at least 0 (m)")
    return found


@attrs.frozen(eq=False)
class MaterialField(Part):
    """Moduli of all cells of some layers of a body, in place of inclusions of a shape.

    Parameters
    ----------
    young
        Young's modulus of each cell of the grid in each layer, shape (nz, nx, ny), Pa; a tenth of that of the body to
        ten times as much.
    poisson
        Poisson's ratio of these cells.
    thicknesses
        Thicknesses of the layers, from above, shape (nz,), m.
    depth
        Depth of the uppermost one, m; zero: they begin at the surface.

    Examples
    --------
    A body that is softer towards its surface:

    >>> import numpy as np
    >>> from roughcontact_volume import MaterialField
    >>> young = np.array([100e9, 150e9, 200e9])[:, None, None] * np.ones((32, 32))
    >>> MaterialField(young, 0.3, ["5um", "5um", "10um"]).young.shape
    (3, 32, 32)
    """

    young: Array = attrs.field(converter=_young, metadata={"unit": "Pa"})
    poisson: float = attrs.field(converter=_poisson, metadata={"unit": ""})
    thicknesses: Array = attrs.field(converter=_thicknesses, metadata={"unit": "m"})
    depth: float = attrs.field(default=0.0, converter=_depth, metadata={"unit": "m"})

    def __attrs_post_init__(self) -> None:
        if self.young.shape[0] != self.thicknesses.size:
            raise rc.InputError(
                f"A MaterialField needs a thickness for each layer, but it has {self.young.shape[0]} layers and "
                f"{self.thicknesses.size} thicknesses."
            )

    def find_cells(self, grid: rc.Grid, body: rc.Elastic) -> tuple[Array, Cells]:
        """Return the depths between the layers from the surface, m, and the cells whose moduli are not the body's."""
        if self.young.shape[1:] != grid.shape:
            raise rc.InputError(
                f"A MaterialField has the cells of the grid, {grid.shape}, in each layer, but its young has "
                f"{self.young.shape[1:]}."
            )
        check_contrast(self.young, self.poisson, body)
        ends = self.depth + np.concatenate(([0.0], np.cumsum(self.thicknesses)))
        above = np.zeros(int(self.depth > 0.0))
        bulk, shear = (
            np.asarray(find(self.young, self.poisson) / find(body.young, body.poisson)).ravel()
            for find in (find_bulk_modulus, find_shear_modulus)
        )
        own = np.flatnonzero((bulk != 1.0) | (shear != 1.0))
        places = own + above.size * grid.cells
        moduli = [dict.fromkeys(("softer", "middle", "stiffer"), one[own]) for one in (bulk, shear)]
        return np.concatenate((above, ends)), Cells(places, moduli[0], moduli[1])


def draw_moduli(
    grid: rc.Grid, thicknesses: npt.ArrayLike, young: float, deviation: float, length: float, seed: int
) -> Array:
    r"""Return random Young's moduli of cells, shape (nz, nx, ny), Pa, for a `MaterialField`.

    Their logarithm is Gaussian, with the correlation :math:`\exp(-r^2 / l^2)`, periodic along x and y; they are cut at
    a tenth of the median and at ten times as much.

    Parameters
    ----------
    grid
        The cells.
    thicknesses
        Thicknesses of the layers, shape (nz,), m.
    young
        The median, Pa.
    deviation
        Standard deviation of the natural logarithm.
    length
        Correlation length l, m.
    seed
        Seed of the random numbers: the same one gives the same moduli.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact_volume import draw_moduli
    >>> young = draw_moduli(rc.Grid((32, 32), 32e-6), np.full(8, 1e-6), 200e9, deviation=0.2, length=5e-6, seed=1)
    >>> young.shape, bool(abs(np.log(young / 200e9).std() - 0.2) < 0.05)
    ((8, 32, 32), True)
    """
    steps = _positive(thicknesses, "The thicknesses of the layers", "m", 1)
    median, spread, reach = (
        float(_positive([value], what, unit, 1)[0])
        for value, what, unit in (
            (young, "The median of Young's modulus", "Pa"),
            (deviation, "The deviation of its logarithm", ""),
            (length, "The correlation length", "m"),
        )
    )
    depths = np.cumsum(steps) - 0.5 * steps
    values, vectors = np.linalg.eigh(np.exp(-(((depths[:, np.newaxis] - depths) / reach) ** 2)))
    along_z = vectors * np.sqrt(np.maximum(values, 0.0))
    noise = np.random.default_rng(seed).standard_normal((steps.size, *grid.shape))
    # The square root of the spectrum of the correlation: noise that it filters has unit variance.
    qx, qy = (2.0 * np.pi * np.fft.fftfreq(n, side) for n, side in zip(grid.shape, grid.spacing, strict=True))
    root = np.exp(-0.125 * reach**2 * (qx[:, np.newaxis] ** 2 + qy**2))
    root *= np.sqrt(grid.cells / (root**2).sum())
    smooth = np.fft.ifft2(np.fft.fft2(noise) * root).real
    field = np.einsum("zk,kxy->zxy", along_z, smooth)
    return np.asarray(median * np.clip(np.exp(spread * field), 1.0 / MAX_CONTRAST, MAX_CONTRAST))
