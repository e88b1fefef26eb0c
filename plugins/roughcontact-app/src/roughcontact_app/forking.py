"""How processes are started: on Linux forked from one that has imported what they need."""

from __future__ import annotations

import multiprocessing
import sys
from typing import Any

# Elsewhere libraries of the system may not outlive a fork. Python 3.11.0 lets other users reach the process that forks
# (CVE-2022-42919).
_FORKED = sys.platform == "linux" and sys.version_info >= (3, 11, 1)
CONTEXT: Any = multiprocessing.get_context("forkserver" if _FORKED else "spawn")
if _FORKED:
    CONTEXT.set_forkserver_preload(["roughcontact_app.ready"])


def start_ahead() -> None:
    """Start the process that forks, which takes seconds to import what the others need."""
    if _FORKED:
        from multiprocessing.forkserver import ensure_running

        ensure_running()
