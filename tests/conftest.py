from __future__ import annotations

import contextlib
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


@pytest.fixture
def start_dask():
    """Start a cluster of the given number of processes and return its client; both end with the test."""
    distributed = pytest.importorskip("distributed")
    with contextlib.ExitStack() as stack:

        def start(workers):
            # Any free port: two tests at once may not ask for the same one.
            cluster = distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0")
            return stack.enter_context(distributed.Client(stack.enter_context(cluster)))

        yield start
