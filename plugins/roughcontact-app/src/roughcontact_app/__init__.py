"""The page in the browser, on this machine."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from roughcontact_app.server import AppServer
    from roughcontact_app.session import Session

__all__ = ["AppServer", "Session"]

_MODULES = {"AppServer": "server", "Session": "session"}


def __getattr__(name: str) -> Any:
    # They load every response; the help of the command line, which has the command of this package, needs none.
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
