import pytest

import roughcontact.testing as kit
from roughcontact_example import Between, Foam, Springback, Springs


@pytest.mark.parametrize("claim", kit.claims("material"), ids=str)
def test_foam(claim):
    claim.check(Foam(young=70e9, strength=200e6, density=0.1))


@pytest.mark.parametrize("claim", kit.claims("kernel"), ids=str)
def test_springs(claim):
    claim.check(Springs(thickness=2e-6))


@pytest.mark.parametrize("claim", kit.claims("area"), ids=str)
def test_between(claim):
    claim.check(Between())


@pytest.mark.parametrize("claim", kit.claims("set"), ids=str)
def test_springback(claim):
    claim.check(Springback())
