"""The page in the browser, on this machine."""

from roughcontact.app.server import AppServer
from roughcontact.app.session import Session

__all__ = ["AppServer", "Session"]
