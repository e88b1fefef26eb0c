"""The page in the browser, on this machine."""

from roughcontact_app.server import AppServer
from roughcontact_app.session import Session

__all__ = ["AppServer", "Session"]
