"""The control groups (cgroup 1 and 2) of this process: those of a container, or of a job of a cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path


def control_groups(controller: str, root: Path) -> Iterator[tuple[Path, int]]:
    """Yield the folder and the version of each group whose limits hold for this process, from below.

    Parameters
    ----------
    controller
        What is limited: ``"memory"`` or ``"cpu"``.
    root
        The root of the file system, another one for tests.
    """
    lines: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    for line in lines:
        _, controllers, place = line.split(":", 2)
        for name, version in (("", 2), (controller, 1)):
            if name in controllers.split(","):
                top = root / "sys/fs/cgroup" / name
                group = top / place.lstrip("/")
                # Every group above sets a limit too. In a container the lowest that is visible is its own.
                while group.is_relative_to(top):
                    yield group, version
                    group = group.parent
