"""The overlap stays."""

from __future__ import annotations

import attrs

from roughcontact.checks import Array
from roughcontact.flattening.base import PermanentSet, overlap
from roughcontact.solution import ContactSolution


@attrs.frozen
class Overlap(PermanentSet):
    """The overlap of the saturated cells stays as flattening; its volume is lost into the bulk.

    Conserved are the pressure and the position of the bodies under load: loaded again in the same place,
    the surfaces carry the same pressure elastically, so that one cycle is shakedown. (The approach counts
    from first touch, which is later by what the highest summit lost.) Not conserved is the volume. The same
    rule is used, for instance, by Weber et al., Nat. Commun. 9 (2018) 888,
    https://doi.org/10.1038/s41467-018-02981-y
    """

    def lowering(self, solution: ContactSolution) -> Array:
        """Return the overlap, shape (nx, ny), m."""
        return overlap(solution)
