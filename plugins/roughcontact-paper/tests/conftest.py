from __future__ import annotations

import functools

import pytest

from roughcontact_paper.wave import solve_wave


@pytest.fixture(scope="session")
def case_of():
    """The cases of Tables 1 and 2, each solved once."""
    return functools.cache(solve_wave)
