"""Objects that were pickled or copied, restored as they were."""

from __future__ import annotations

from typing import Any

import numpy as np

from roughcontact._base.checks import read_only


def restore_state(self: Any, state: Any) -> None:
    """Restore an object that was pickled or copied, its arrays read-only as before; it serves as ``__setstate__``."""
    own, slots = state if isinstance(state, tuple) else (state, None)
    for name, value in {**(own or {}), **(slots or {})}.items():
        object.__setattr__(self, name, read_only(value) if isinstance(value, np.ndarray) else value)
