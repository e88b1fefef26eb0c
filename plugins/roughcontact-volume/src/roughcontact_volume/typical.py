r"""Typical metals that harden, by the entry points ``roughcontact.typical``: ``rc.Body(surface, "OFHC-copper")``.

Yield stress and hardening are the static part :math:`A + B \kappa^n` of the model of Johnson and Cook, at a rate of
1/s and at room temperature. It was fitted to large strains: below a hundredth it is not known to hold, and heats of
one grade differ by about a tenth. The elastic constants are those of textbooks, rounded.

Of a hardened bearing steel (AISI 52100, 100Cr6) and of S355 no curve was found that a second text confirms: a table of
a test of one's own, `TabulatedHardening`, serves better than a guess.

References
----------
Copper and 4340: Johnson, Cook, Eng. Fract. Mech. 21 (1985) 31-48, https://doi.org/10.1016/0013-7944(85)90052-9; quoted
for copper by Banerjee, https://arxiv.org/abs/cond-mat/0512466, table 4.
2024-T351 and 1006: Johnson, Cook, Proc. 7th Int. Symp. Ballistics, The Hague (1983), without a DOI.
"""

from __future__ import annotations

from roughcontact_volume.hardening import LudwikHardening
from roughcontact_volume.plastic import Plastic

# Annealed.
OFHC_COPPER = Plastic(124e9, 0.34, 90e6, LudwikHardening(292e6, 0.31))
# Naturally aged after stretching.
ALUMINIUM_2024_T351 = Plastic(73e9, 0.33, 265e6, LudwikHardening(426e6, 0.34))
# Low-carbon sheet and bar, near to a mild structural steel.
STEEL_1006 = Plastic(210e9, 0.3, 350e6, LudwikHardening(275e6, 0.36))
# Quenched and tempered.
STEEL_4340 = Plastic(210e9, 0.3, 792e6, LudwikHardening(510e6, 0.26))
