"""``roughcontact app``: a page on this machine for those who do not program."""

from __future__ import annotations

import argparse
import contextlib
import signal
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from roughcontact.errors import FileError
from roughcontact.typing import Command

_ADVICE = "Only this machine can reach it. If no browser shows it, copy this address into one. Ctrl-C ends it."
_SNAPS = Path("/snap")
# A page that leads to another one.
_LEADING = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={0}">'
    '<title>roughcontact</title><p><a href="{0}">roughcontact</a></p></html>'
)


class App(Command):
    """Open a page in the browser that solves contacts on this machine."""

    epilog = """
examples:
  roughcontact app
  roughcontact app --port 8000 --no-browser
"""

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Declare the port, and whether a browser is opened."""
        parser.add_argument(
            "--port", type=_port, default=0, metavar="N", help="port of this machine (any that is free)"
        )
        parser.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")

    def run(self, options: argparse.Namespace) -> int:
        """Serve until Ctrl-C; return 0."""
        from roughcontact_app.forking import start_ahead

        # Its imports take seconds, as do those of this process.
        start_ahead()
        from roughcontact_app import AppServer, Session

        with _ending_on_signals():
            try:
                with contextlib.closing(Session()) as session, _open(AppServer, session, options.port) as server:
                    session.prepare()
                    print(f"The page is at {server.address}\n{_ADVICE}", flush=True)
                    with contextlib.nullcontext() if options.no_browser else _shown(server.address, session.folder):
                        server.serve_forever()
            except KeyboardInterrupt:
                # With the terminal its output may be gone.
                with contextlib.suppress(OSError):
                    print("\nEnded; its files are removed.", flush=True)
        return 0


def _port(text: str) -> int:
    """Return the number of a port, for argparse."""
    if not (text.isascii() and text.isdecimal() and len(text) <= 5 and int(text) <= 65535):
        raise argparse.ArgumentTypeError(f"{text[:80]!r} is not a port from 0 to 65535; write it like 8000")
    return int(text)


def _open(server: Any, session: Any, port: int) -> Any:
    try:
        return server(session, port)
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"The port {port} cannot be used ({reason}): choose another, or omit --port.") from error


@contextlib.contextmanager
def _shown(address: str, folder: Path) -> Iterator[None]:
    """Show the page by a private file that leads to it: every user sees the command line of the browser."""
    # Browsers of snaps see the home folder, but neither the temporary nor hidden folders.
    handle, name = tempfile.mkstemp(".html", "roughcontact-", Path.home() if _SNAPS.is_dir() else folder)
    try:
        with open(handle, "w", encoding="utf-8") as file:
            file.write(_LEADING.format(address))
        # A browser in the terminal returns only when it is left.
        threading.Thread(target=webbrowser.open, args=(Path(name).as_uri(),), daemon=True).start()
        yield
    finally:
        Path(name).unlink(missing_ok=True)


@contextlib.contextmanager
def _ending_on_signals() -> Iterator[None]:
    """Let signals end what is done here as Ctrl-C does; those that come while it ends are ignored."""
    names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    signals = [getattr(signal, name) for name in names if hasattr(signal, name)]
    # What is ignored from the start stays so: nohup ignores that the terminal is closed.
    before = {one: kept for one in signals if (kept := signal.getsignal(one)) != signal.SIG_IGN}

    def stop(*_: Any) -> None:
        for one in before:
            signal.signal(one, signal.SIG_IGN)
        raise KeyboardInterrupt

    for one in before:
        signal.signal(one, stop)
    try:
        yield
    finally:
        for one, kept in before.items():
            signal.signal(one, kept)
