"""The kernel keeps what the kit claims of any kernel."""

from __future__ import annotations

import pytest
import roughcontact as rc
from roughcontact.testing import claims

from roughcontact_layered import Layer, LayeredKernel

COATED = LayeredKernel(layers=(Layer(young=420e9, poisson=0.25, thickness=2e-6),), substrate=rc.Elastic(210e9, 0.3))


@pytest.mark.parametrize("claim", claims("kernel"), ids=str)
def test_it_conforms(claim):
    claim.check(COATED)
