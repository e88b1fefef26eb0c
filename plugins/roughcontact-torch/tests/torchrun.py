"""Starts programs by torchrun, as a user does."""

import os
import subprocess
import sys


def run(count, *arguments, timeout=120):
    """Return the finished run of Python with arguments, by so many processes on processors; one that hangs fails."""
    command = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", str(count)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "CUDA_VISIBLE_DEVICES": ""}
    return subprocess.run(
        [*command, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, env=environment, check=False
    )
