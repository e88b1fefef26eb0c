"""``roughcontact app``: a page on this machine for those who do not program."""

from __future__ import annotations

import argparse
import signal
import webbrowser
from typing import Any

from roughcontact.cli import Command
from roughcontact.errors import FileError, InputError


class App(Command):
    """Open a page in the browser that solves contacts on this machine."""

    epilog = """
examples:
  roughcontact app
  roughcontact app --port 8000 --no-browser
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--port", type=int, default=0, metavar="N", help="port of this machine (any that is free)")
        parser.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")

    def run(self, options: argparse.Namespace) -> int:
        """Serve until Ctrl-C; return 0."""
        from roughcontact.app import AppServer, Session

        if not 0 <= options.port <= 65535:
            raise InputError.about("The port", options.port, "0 to 65535")
        session = Session()
        try:
            server = _open(AppServer, session, options.port)
            with server:
                signal.signal(signal.SIGTERM, _stop)
                print(f"The page is at {server.address}\nOnly this machine can reach it. Ctrl-C ends it.", flush=True)
                if not options.no_browser:
                    webbrowser.open(server.address)
                server.serve_forever()
        except KeyboardInterrupt:
            print("\nEnded; its files are removed.")
        finally:
            session.close()
        return 0


def _open(server: Any, session: Any, port: int) -> Any:
    try:
        return server(session, port)
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"The port {port} cannot be used ({reason}): choose another, or omit --port.") from error


def _stop(*_: Any) -> None:
    raise KeyboardInterrupt
