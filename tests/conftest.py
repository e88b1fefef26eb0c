from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import hypothesis
import numpy as np
import pytest

import roughcontact as rc
from roughcontact.__main__ import main
from scenes import act_as_on_large_grids

# Processes that tests start, and those of pytest-xdist, share what one of them has compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# The same draws in each run, so that they are few.
hypothesis.settings.register_profile("default", max_examples=25, deadline=None, derandomize=True)
# For `pytest --hypothesis-profile=random`: other draws in each run.
hypothesis.settings.register_profile("random", max_examples=60, deadline=None, print_blob=True)
hypothesis.settings.load_profile("default")


@pytest.fixture(scope="session")
def measured_maps():
    """The folder of measured height maps, named by an environment variable."""
    folder = os.environ.get("ROUGHCONTACT_MAPS")
    if not folder or not Path(folder).is_dir():
        pytest.skip("no measured maps: set ROUGHCONTACT_MAPS to their folder")
    return Path(folder)


@pytest.fixture(scope="session")
def exported_map(tmp_path_factory):
    """A map of 400 x 300 points, and the files of it that a program wrote: a row for each x, and one for each y.

    Four lines of header, semicolons, decimal commas, heights in µm; 3 % of the points are empty, single or in blobs.
    """
    grid, draws = rc.Grid((400, 300), (200e-6, 150e-6)), np.random.default_rng(5)
    surface = rc.SelfAffineSurface(hurst=0.8, rms_height=0.5e-6, shortest=6e-6, longest=60e-6, seed=3)
    micrometres = np.round(1e6 * surface.heights(grid), 4)
    lost = draws.random(grid.shape) < 0.02
    for x, y in draws.random((6, 2)) * grid.shape:
        lost |= np.hypot(*np.ogrid[-x : 400 - x, -y : 300 - y]) < 8.0
    header = ["Instrument;Profilometer 5", "Date;23.11.2026 10:15", "Field;200,0 um x 150,0 um", "Heights in um"]
    folder = tmp_path_factory.mktemp("exported")
    for name, values, empty in (("x", micrometres, lost), ("y", micrometres.T, lost.T)):
        rows = [
            ";".join("" if none else f"{value:.4f}".replace(".", ",") for value, none in zip(*row, strict=True))
            for row in zip(values, empty, strict=True)
        ]
        (folder / f"{name}.csv").write_text("\n".join([*header, *rows]) + "\n", encoding="utf-8")
    heights = np.where(lost, 0.0, 1e-6 * micrometres)
    return rc.HeightMap(heights, grid.size, non_measured=lost), folder / "x.csv", folder / "y.csv"


@pytest.fixture
def run(capsys):
    """A call of the command line, which returns its exit status, output and errors."""

    def call(*arguments):
        capsys.readouterr()
        try:
            status = main([str(one) for one in arguments])
        except SystemExit as ended:
            status = ended.code
        return status, *capsys.readouterr()

    return call


@pytest.fixture
def leave_memory(monkeypatch):
    """Let there be so many bytes of memory that this process may take."""
    return lambda count: monkeypatch.setattr("roughcontact._base.machine.available_memory", lambda: count)


@pytest.fixture
def no_pictures(monkeypatch):
    """Reports without their pictures, for tests of what stands beside these: drawing eight takes two seconds."""
    monkeypatch.setattr("roughcontact._faces.html.report.can_draw", lambda: False)


@pytest.fixture
def as_on_large_grids(monkeypatch):
    """See `scenes.act_as_on_large_grids`."""
    act_as_on_large_grids(monkeypatch)


@pytest.fixture(params=["on fields", "on lists"])
def on_fields_and_on_lists(request):
    """The default solver descends on fields, as on small grids, and as it does on large ones."""
    if request.param == "on lists":
        request.getfixturevalue("as_on_large_grids")


class DaskCluster:
    """A scheduler of dask in this process, and workers, processes of their own that nobody starts again."""

    def __init__(self, distributed, stack):
        # Any free port: two tests at once may not ask for the same one.
        cluster = distributed.LocalCluster(n_workers=0, dashboard_address=":0")
        self.client = stack.enter_context(distributed.Client(stack.enter_context(cluster)))
        self.command = [sys.executable, "-m", "distributed.cli.dask_worker", cluster.scheduler_address, "--no-nanny"]
        self.command += ["--nthreads", "1", "--memory-limit", "0", "--dashboard-address", ":0"]
        # What the workers are sent may be of a module of tests.
        self.environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        self.stack, self.workers = stack, []

    def start(self, count):
        """Bring the number of running workers to `count`, when the scheduler has seen which ones have ended."""
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        deadline = time.monotonic() + 60
        while len(self.client.scheduler_info(n_workers=-1)["workers"]) > len(self.workers):
            assert time.monotonic() < deadline
            time.sleep(0.02)
        for _ in range(count - len(self.workers)):
            worker = subprocess.Popen(self.command, env=self.environment, stderr=subprocess.DEVNULL)
            self.stack.callback(worker.wait)
            self.stack.callback(worker.kill)
            self.workers.append(worker)
        self.client.wait_for_workers(count, timeout=60)


@pytest.fixture
def dask_cluster():
    distributed = pytest.importorskip("distributed")
    with contextlib.ExitStack() as stack:
        yield DaskCluster(distributed, stack)
