"""Models of plastic flattening: how much lower the surfaces are after unloading."""

from __future__ import annotations

import abc

import attrs
import numpy as np

from roughcontact._base.checks import Array
from roughcontact._base.registry import Registry
from roughcontact._solve.solution import ContactSolution
from roughcontact.errors import InputError


class FlatteningModel(abc.ABC):
    """A model of plastic flattening; a class of your own gives the loss of height.

    Examples
    --------
    >>> import roughcontact as rc
    >>> class HalfOverlap(rc.Overlap):
    ...     def height_loss(self, solution):
    ...         return 0.5 * super().height_loss(solution)
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=HalfOverlap()).shakedown)
    True
    """

    @abc.abstractmethod
    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the loss of height of both bodies together after unloading, shape (nx, ny), m.

        Negative where the surfaces rise. The elastic displacement recovers completely.
        """


flattening_models = Registry(FlatteningModel, "flattening model", "roughcontact.flattening_models")


@attrs.frozen
class Overlap(FlatteningModel):
    """The overlap of the saturated cells remains as flattening; its volume is lost into the bulk.

    Conserved are the pressure and the position of the bodies under load: loaded again in the same place, the surfaces
    carry the same pressure elastically, so that one cycle is shakedown. (The approach counts from first touch, which
    is later by the height that the highest summit lost.) The volume is not conserved. The same rule is used, for
    instance, by Weber et al., Nat. Commun. 9 (2018) 888, https://doi.org/10.1038/s41467-018-02981-y

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=rc.Overlap()).shakedown)
    True
    """

    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the overlap of the saturated cells, shape (nx, ny), m, zero elsewhere."""
        return np.where(solution.saturated, np.maximum(-solution.gap, 0.0), 0.0)


@attrs.frozen
class UniformRise(FlatteningModel):
    """The volume of the overlap comes back as a uniform rise of all cells that are not in contact.

    Conserved is the volume, and so the mean height. Loaded again in the same place, the raised surface carries part of
    the load. In full contact all cells rise. The rise was observed on confined specimens by Pullen and Williamson,
    Proc. R. Soc. Lond. A 327 (1972) 159, https://doi.org/10.1098/rspa.1972.0038

    Examples
    --------
    >>> import roughcontact as rc
    >>> wave = rc.WavySurface(amplitude=1e-6, wavelength=50e-6)
    >>> steel = rc.ElasticPerfectlyPlastic(young=210e9, poisson=0.3, hardness=2e9)
    >>> body = rc.Body(wave, steel)
    >>> problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 100e-6), boundary="periodic")
    >>> print(rc.run_in(problem, pressure=100e6, model=rc.UniformRise()).shakedown)
    True
    """

    def height_loss(self, solution: ContactSolution) -> Array:
        """Return the overlap less the rise, shape (nx, ny), m; its mean is zero.

        Raises
        ------
        InputError
            If the volume exceeds that of the gap.
        """
        loss = Overlap().height_loss(solution)
        open_cells = ~solution.contact
        count = np.count_nonzero(open_cells)
        if count == 0:
            return np.asarray(loss - loss.mean(), dtype=np.float64)
        displaced = float(loss.sum())
        if displaced > float(solution.gap[open_cells].sum()):
            raise InputError(
                "The open cells cannot take the displaced volume: the gap there is smaller. Choose a smaller load, or "
                "the model 'overlap'."
            )
        loss[open_cells] -= displaced / count
        return loss
