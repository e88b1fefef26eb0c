"""The overlap stays, and its volume rises elsewhere."""

from __future__ import annotations

import attrs
import numpy as np

from roughcontact.checks import Array
from roughcontact.errors import InputError
from roughcontact.flattening.base import PermanentSet, overlap
from roughcontact.solution import ContactSolution


@attrs.frozen
class UniformRise(PermanentSet):
    """The volume of the overlap comes back as a uniform rise of all cells that are not in contact.

    Conserved is the volume, and so the mean height. Loaded again in the same place, the raised surface
    takes over some of the load. In full contact, where nothing is open, the rise is that of the whole
    surface. It was observed on confined specimens:

    Pullen, Williamson, Proc. R. Soc. Lond. A 327 (1972) 159, https://doi.org/10.1098/rspa.1972.0038
    """

    def lowering(self, solution: ContactSolution) -> Array:
        """Return the overlap less the rise, shape (nx, ny), m; its mean is zero.

        Raises
        ------
        InputError
            If the open cells cannot take the volume.
        """
        lower = overlap(solution)
        open_cells = ~solution.contact
        count = np.count_nonzero(open_cells)
        if count == 0:
            return np.asarray(lower - lower.mean(), dtype=np.float64)
        displaced = float(lower.sum())
        if displaced > float(solution.gap[open_cells].sum()):
            raise InputError(
                "The open cells cannot take the volume that is displaced: the gap left there is smaller. Choose a "
                "smaller load, or the model 'overlap'."
            )
        lower[open_cells] -= displaced / count
        return lower
