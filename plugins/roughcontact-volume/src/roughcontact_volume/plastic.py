"""The material that flows below the surface."""

from __future__ import annotations

import attrs

from roughcontact_volume.flow import PlasticFlow
from roughcontact_volume.yielding import Yielding


@attrs.frozen
class Plastic(Yielding):
    r"""Isotropic, elastic, and plastic below the surface where the von Mises stress reaches the yield stress.

    A path of loads (`ContactProblem.path`) follows the plastic strain (`PlasticFlow`); strains are small.

    Parameters
    ----------
    young
        Young's modulus, Pa, above zero.
    poisson
        Poisson's ratio, above -1 and at most 0.5.
    yield_stress
        Yield stress in tension of the material that never flowed, Pa, above zero.
    hardening
        A `Hardening`; a number or text is a hardening modulus, Pa; None: perfectly plastic.
    accuracy
        Admissible change of maximum pressure, approach, force and imprint, over their size, by a doubling of the
        substeps of an increment of the load, over which the strain is then extrapolated. The errors that are left are
        among the numbers of a state. From one load to twice that, the default takes two to four substeps, 0.005 eight
        to sixteen.
    residual
        A `ResidualStress` that it has below its surface before any load, everywhere below the yield stress; None:
        it has none. It adds to the stress that makes it flow, and flow relaxes it.

    Examples
    --------
    >>> from roughcontact_volume import Plastic, SwiftHardening
    >>> steel = Plastic("210GPa", 0.3, yield_stress="1.2GPa", hardening=SwiftHardening(strain=0.004, power=0.12))
    >>> f"{steel.find_yield_stress(0.02) / 1e9:.3f} GPa"
    '1.488 GPa'
    """

    def bring_laws(self, side: str) -> tuple[PlasticFlow]:
        """Return the process by which it flows, on a side; see `Material.bring_laws`."""
        return (PlasticFlow(side, is_stressed=self.residual is not None),)
