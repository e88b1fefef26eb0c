"""Theories of rough surfaces: contact after Persson, whether they stick, and what full contact costs; SI units."""

from __future__ import annotations

import math

import attrs
import numpy as np
import scipy

from roughcontact._base.arrays import Array, read_only
from roughcontact._base.checks import number
from roughcontact._base.units import ShownAsPrinted, outlined, si
from roughcontact._parts.grid import Grid
from roughcontact.errors import InputError
from roughcontact.errors.door import guarded
from roughcontact.reference.adhesion import read_work
from roughcontact.reference.closed_forms import read_length, read_pressure
from roughcontact.reference.roughness import Waves, list_waves

# Correction of the elastic energy of a partial contact, no unit.
_GAMMA = 0.45
# Bands of wave numbers, and pressures at which the energy is evaluated; four times as many change the gap by less than
# 1e-4 of the rms height.
_WAVE_BANDS = 256
_PRESSURE_NODES = 512
# Pressure, over the smallest rms pressure of full contact, below which the energy is proportional to it, and over the
# largest, above which the energy is constant.
_LIGHT_PRESSURE_RATIO = 1e-3
_FULL_PRESSURE_RATIO = 8.0
# Contact area of a rough surface without adhesion times E* h' over the force, as in the paper.
_AREA_COEFFICIENT = 2.0


@guarded
@attrs.frozen(eq=False)
class PerssonContact(ShownAsPrinted):
    """Contact after Persson, at one or several pressures.

    Attributes
    ----------
    pressure
        Nominal mean pressures, shape (count,) or (), Pa; the others have its shape.
    area_fraction
        Real over nominal contact area.
    mean_gap
        Mean gap, m.
    stiffness
        Normal stiffness over nominal area, -dp/d(mean gap), Pa/m; infinite in full contact.
    """

    pressure: Array = attrs.field(converter=read_only, repr=outlined)
    area_fraction: Array = attrs.field(converter=read_only, repr=outlined)
    mean_gap: Array = attrs.field(converter=read_only, repr=outlined)
    stiffness: Array = attrs.field(converter=read_only, repr=outlined)

    def __str__(self) -> str:
        columns = (
            np.atleast_1d(values) for values in (self.pressure, self.area_fraction, self.mean_gap, self.stiffness)
        )
        lines = [f"{'mean pressure':>14} {'area, %':>10} {'mean gap':>12} {'stiffness':>14}"]
        lines += [
            f"{si(p, 'Pa'):>14} {100.0 * a:>10.4g} {si(u, 'm'):>12} {si(k, 'Pa/m'):>14}"
            for p, a, u, k in zip(*columns, strict=True)
        ]
        return "\n".join(lines)


@guarded
def persson(
    heights: Array, grid: Grid, modulus: float, pressure: float | Array, *, periodic: bool = True
) -> PerssonContact:
    r"""Return area, mean gap and stiffness after Persson, from the spectrum of the heights.

    With the power :math:`C_q` of the waves, and the variance G of the pressure in full contact by those up to q,

    .. math:: \frac{A}{A_0} = s(q_1), \quad s(q) = \mathrm{erf}\frac{p}{\sqrt{2 G(q)}}, \quad
              G(q) = \frac{E^{*2}}{4} \sum_{|q'| \le q} q'^2 C_{q'}

    .. math:: U = \frac{E^*}{4} \sum_q q\, C_q\, s\,(\gamma + (1 - \gamma) s^2), \quad
              \bar u = \int_p^\infty \frac{1}{p'} \frac{\mathrm{d}U}{\mathrm{d}p'} \mathrm{d}p', \quad
              k = -\frac{\mathrm{d}p}{\mathrm{d}\bar u} = p \left( \frac{\mathrm{d}U}{\mathrm{d}p} \right)^{-1}

    with :math:`\gamma = 0.45`. The theory holds for nominally flat, isotropic, Gaussian roughness of many waves; its
    area is 17 to 31 % below that of solved contacts, the less the larger the contact.

    Parameters
    ----------
    heights, grid
        Sum of the heights of both bodies, shape `grid.shape`, m, and their grid.
    modulus
        Contact modulus E*, Pa.
    pressure
        Nominal mean pressures, Pa, above zero.
    periodic
        Whether the heights repeat beyond the border. If not, subtract their form first; they are windowed (Hann), and
        all results depend on both.

    References
    ----------
    Persson, J. Chem. Phys. 115 (2001) 3840-3861, https://doi.org/10.1063/1.1388626;
    Persson, Phys. Rev. Lett. 99 (2007) 125502, https://doi.org/10.1103/PhysRevLett.99.125502;
    Yang, Persson, J. Phys.: Condens. Matter 20 (2008) 215214, https://doi.org/10.1088/0953-8984/20/21/215214

    Examples
    --------
    >>> import roughcontact as rc
    >>> grid = rc.Grid((256, 256), 100e-6)
    >>> rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3e-6, longest=50e-6, rolloff=12e-6, seed=1)
    >>> contact = rc.reference.persson(rough.heights(grid), grid, modulus=1e9, pressure=10e6)
    >>> print(f"{100 * contact.area_fraction:.1f} %")
    15.9 %
    """
    modulus = number(modulus, "The contact modulus", "Pa", above=0.0)
    several = isinstance(pressure, (list, tuple)) or (isinstance(pressure, np.ndarray) and pressure.ndim > 0)
    given = list(pressure) if several else [pressure]  # type: ignore[arg-type]
    if not given:
        raise InputError.about("The pressure", pressure, "a number or a list of numbers above 0 (Pa)")
    found = np.array([number(one, "The pressure", "Pa", above=0.0) for one in given])
    pressures = found if several else found.reshape(())
    return evaluate_persson(list_waves(heights, grid, periodic), modulus, pressures)


def evaluate_persson(waves: Waves, modulus: float, pressures: Array) -> PerssonContact:
    """Return the contact of a surface of these waves; see `persson`."""
    unit = modulus * (waves.height / waves.cell)
    energy, variance = _list_bands(waves)
    p = np.atleast_1d(pressures) / unit
    area = scipy.special.erf(p / math.sqrt(2.0 * variance[-1]))
    light = _LIGHT_PRESSURE_RATIO * math.sqrt(variance[0])
    full = _FULL_PRESSURE_RATIO * math.sqrt(variance[-1])
    nodes = np.unique(np.concatenate((np.geomspace(light, full, _PRESSURE_NODES), p[(p > light) & (p < full)])))
    slope = _slope_of_energy(nodes, energy, variance)
    steps = 0.5 * (slope[1:] + slope[:-1]) * np.diff(np.log(nodes))
    above = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
    gap = np.where(p < full, np.interp(np.clip(p, light, full), nodes, above), 0.0)
    gap += slope[0] * np.log(np.maximum(light / p, 1.0))
    own = _slope_of_energy(p, energy, variance)
    stiffness = np.divide(p, own, out=np.full(p.size, np.inf), where=own > 0.0)
    columns = area, gap * waves.height, stiffness * (unit / waves.height)
    return PerssonContact(pressures, *(values.reshape(pressures.shape) for values in columns))


def find_persson_area(waves: Waves, modulus: float, pressure: float) -> float:
    """Return the area fraction of `evaluate_persson` at one pressure, Pa, alone."""
    variance = _list_bands(waves)[1]
    p = pressure / (modulus * (waves.height / waves.cell))
    return float(scipy.special.erf(p / math.sqrt(2.0 * variance[-1])))


def _list_bands(waves: Waves) -> tuple[Array, Array]:
    """Return for each band of wave numbers its elastic energy, and the variance of the pressure up to its end."""
    square = waves.square
    power = waves.count * waves.power
    q = np.sqrt(square)
    low = float(q.min())
    high = float(q.max())
    width = math.log(high / low) / _WAVE_BANDS or 1.0
    band = np.minimum((np.log(q / low) / width).astype(np.intp), _WAVE_BANDS - 1)
    energy, variance = (0.25 * np.bincount(band, weight * power, _WAVE_BANDS) for weight in (q, square))
    # A band without waves adds nothing.
    filled = energy > 0.0
    return np.asarray(energy[filled], dtype=np.float64), np.cumsum(variance[filled], dtype=np.float64)


def _slope_of_energy(pressure: Array, energy: Array, variance: Array) -> Array:
    """Return dU/dp at pressures, shape (count,)."""
    ratio = pressure[:, np.newaxis] / np.sqrt(2.0 * variance)
    factor = _GAMMA + 3.0 * (1.0 - _GAMMA) * scipy.special.erf(ratio) ** 2
    density = factor * np.exp(-(np.minimum(ratio, 30.0) ** 2))
    return np.asarray(density @ (energy * np.sqrt(2.0 / (np.pi * variance))))


def _slope(value: float) -> float:
    return number(value, "The rms slope", above=0.0)


def _curvature(value: float) -> float:
    return number(value, "The rms curvature", "1/m", above=0.0)


@guarded
@attrs.frozen
class PastewkaRobbins:
    r"""Whether rough surfaces stick: the criterion of Pastewka and Robbins.

    Contact patches have the mean diameter :math:`d = 4h'/h''`, where a summit of the mean curvature h''/2 has the slope
    h' at its edge. Beside the edges the gap opens with the power 3/2 of the distance. Where it is below the range
    :math:`\Delta r` the surfaces attract each other with :math:`w/\Delta r`, and they stick if that is more than what
    carries the patches, :math:`E^* h'/\kappa` with :math:`\kappa = 2`:

    .. math:: \frac{E^* h' \Delta r}{\kappa w}\left[\frac{h' d}{4\Delta r}\right]^{2/3}
              < \pi\left(\tfrac{3}{16}\right)^{2/3}

    It holds for a range that is short beside the heights, and weak adhesion: patches keep their form.

    Parameters
    ----------
    rms_slope
        Root mean square h' of the gradient.
    rms_curvature
        Root mean square h'' of the Laplacian, 1/m.
    modulus
        Contact modulus E*, Pa.
    work
        Work of adhesion w, J/m2.
    range
        Range of the attraction, m: the work over the strength.

    References
    ----------
    Pastewka, Robbins, Proc. Natl. Acad. Sci. 111 (2014) 3298-3303, https://doi.org/10.1073/pnas.1320846111

    Examples
    --------
    >>> from roughcontact.reference import PastewkaRobbins
    >>> rubber = PastewkaRobbins(rms_slope=0.1, rms_curvature=1e6, modulus=1e6, work=0.05, range=1e-9)
    >>> rubber.sticks, PastewkaRobbins(0.1, 1e6, modulus=100e9, work=0.05, range=1e-9).sticks
    (True, False)
    """

    rms_slope: float = attrs.field(converter=_slope)
    rms_curvature: float = attrs.field(converter=_curvature)
    modulus: float = attrs.field(converter=read_pressure)
    work: float = attrs.field(converter=read_work)
    range: float = attrs.field(converter=read_length)

    @property
    def patch_diameter(self) -> float:
        """Mean diameter of a contact patch without adhesion, m."""
        return 4.0 * self.rms_slope / self.rms_curvature

    @property
    def ratio(self) -> float:
        """What carries the patches over what attracts them: below one the surfaces stick."""
        pressure = self.modulus * self.rms_slope / _AREA_COEFFICIENT
        width = math.cbrt((0.25 * self.rms_slope * self.patch_diameter / self.range) ** 2)
        return pressure * self.range / self.work * width / (math.pi * math.cbrt(9.0 / 256.0))

    @property
    def sticks(self) -> bool:
        """Whether a finite force is needed to separate the surfaces."""
        return self.ratio < 1.0


@guarded
@attrs.frozen
class FullContactEnergies:
    """The energies of two surfaces pressed into full contact, per nominal area.

    Attributes
    ----------
    elastic
        Elastic energy of closing all gaps, J/m2.
    released
        Work of adhesion less the elastic energy, J/m2: what full contact releases, or costs if it is negative. It is
        the effective work of adhesion of Persson and Tosatti without the area that the roughness adds.
    """

    elastic: float
    released: float


@guarded
def full_contact_energies(heights: Array, grid: Grid, work: float, modulus: float) -> FullContactEnergies:
    r"""Return the energies of full contact of a surface that repeats, by the power of its waves.

    .. math:: U = \frac{E^*}{4} \sum_q q\,|h_q|^2

    Parameters
    ----------
    heights
        Heights, shape (nx, ny), m.
    grid
        Their grid.
    work
        Work of adhesion, J/m2.
    modulus
        Contact modulus E*, Pa.

    References
    ----------
    Persson, Tosatti, J. Chem. Phys. 115 (2001) 5597-5610, https://doi.org/10.1063/1.1398300

    Examples
    --------
    >>> import roughcontact as rc
    >>> from roughcontact.reference import full_contact_energies
    >>> grid = rc.Grid((64, 64), 64e-6)
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=32e-6).heights(grid)
    >>> energies = full_contact_energies(wave, grid, work=0.05, modulus=1e6)
    >>> print(f"{energies.elastic:.4f} J/m2 of 0.05 J/m2")
    0.0491 J/m2 of 0.05 J/m2
    """
    return evaluate_full_contact(list_waves(heights, grid, periodic=True), read_work(work), read_pressure(modulus))


def evaluate_full_contact(waves: Waves, work: float, modulus: float) -> FullContactEnergies:
    """Return the energies of full contact of a surface with given waves; see `full_contact_energies`."""
    strain = waves.sum(np.sqrt(waves.square)) * waves.height**2 / waves.cell
    elastic = 0.25 * modulus * strain
    return FullContactEnergies(elastic, work - elastic)
