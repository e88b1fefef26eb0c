"""The convolver keeps what the kit claims of any convolver, on each device that there is."""

import pytest
import torch
from roughcontact.testing import claims

from roughcontact_torch import TorchFFT

DEVICES = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("claim", claims("convolver"), ids=str)
def test_it_conforms(claim, device):
    claim.check(TorchFFT(device))
