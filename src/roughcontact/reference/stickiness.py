"""Theories of rough surfaces that attract each other: whether they stick, and what full contact costs; SI units."""

from __future__ import annotations

import math

import attrs
import numpy as np

from roughcontact._base.arrays import Array
from roughcontact._base.checks import number
from roughcontact._parts.grid import Grid
from roughcontact.errors.door import guarded
from roughcontact.reference.adhesion import read_work
from roughcontact.reference.closed_forms import read_length, read_pressure
from roughcontact.reference.roughness import Waves, list_waves

# Contact area of a rough surface without adhesion times E* h' over the force, as in the paper.
_AREA_COEFFICIENT = 2.0


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
