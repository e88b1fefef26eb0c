from __future__ import annotations

import os
from pathlib import Path

import hypothesis
import pytest

hypothesis.settings.register_profile("default", max_examples=60, deadline=None, derandomize=True)
hypothesis.settings.load_profile("default")


@pytest.fixture(scope="session")
def measured_maps():
    """The folder of measured height maps, named by an environment variable."""
    folder = os.environ.get("ROUGHCONTACT_MAPS")
    if not folder or not Path(folder).is_dir():
        pytest.skip("no measured maps: set ROUGHCONTACT_MAPS to their folder")
    return Path(folder)
