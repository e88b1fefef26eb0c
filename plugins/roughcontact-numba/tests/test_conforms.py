"""The convolver keeps what the kit claims of any convolver."""

import pytest
from roughcontact.testing import claims

from roughcontact_numba import CompiledFFT


@pytest.mark.parametrize("claim", claims("convolver"), ids=str)
def test_it_conforms(claim):
    claim.check(CompiledFFT())
