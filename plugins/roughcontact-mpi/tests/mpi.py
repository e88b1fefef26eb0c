"""Runs programs by `mpiexec`, as a user does; says why where it cannot."""

import functools
import os
import shutil
import subprocess
import sys
from pathlib import Path

_HELLO = "from mpi4py import MPI; MPI.COMM_WORLD.rank or print(MPI.COMM_WORLD.size)"
# What Open MPI needs as root, and on a machine with fewer processors than processes.
_SETTINGS = {
    "OMP_NUM_THREADS": "1",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
}


def find_mpiexec():
    """Return the `mpiexec` of this Python, or the one on PATH."""
    return shutil.which("mpiexec", path=os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", ""))))


def run(count, *arguments, timeout=300):
    """Return the finished run of Python with arguments, by so many processes; one that hangs fails."""
    command = [find_mpiexec(), "-n", str(count), sys.executable, *map(str, arguments)]
    environment = {**os.environ, **_SETTINGS}
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=environment, check=False)


@functools.cache
def missing():
    """Return why no program can be run by two processes; empty if one can."""
    if find_mpiexec() is None:
        return "no mpiexec: pip install mpich"
    found = run(2, "-c", _HELLO, timeout=120)
    if found.returncode:
        return f"mpi4py finds no MPI: {found.stderr.strip()[-200:]}"
    return "" if found.stdout.split() == ["2"] else "mpiexec and mpi4py are of different MPIs"
