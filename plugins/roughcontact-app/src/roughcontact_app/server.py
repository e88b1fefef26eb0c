"""The server of the page: on this machine alone, behind a token, with bounds on all that it takes."""

from __future__ import annotations

import contextlib
import hmac
import html
import http
import json
import re
import socket
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import Any
from urllib.parse import parse_qs

from roughcontact.errors import RoughContactError
from roughcontact.errors.door import translated

from roughcontact_app import connections
from roughcontact_app.process import TaskEnded
from roughcontact_app.session import Session
from roughcontact_app.settings import PREFIXES

# The loopback address: no other machine can reach it.
HOST = "127.0.0.1"
# Bytes of settings; seconds without a byte; bytes that are sent at a time.
_LONGEST_BODY = 1 << 16
_SILENCE = 30.0
_BLOCK = 1 << 18
# Seconds after which a page that waits for another phase of a run is told how far it has come.
_LOOK = 0.5
# Characters of the name of a page.
_LONGEST_NAME = 40
# Bytes, and seconds, of a refused request that are read after the answer, so that the client sees it.
_DRAINED = 1 << 20
_DRAINING = 2.0
_TYPES = {
    "css": "text/css; charset=utf-8",
    "csv": "text/csv; charset=utf-8",
    "gif": "image/gif",
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "npz": "application/octet-stream",
    "png": "image/png",
    "svg": "image/svg+xml",
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; form-action 'none'; "
    "base-uri 'none'; frame-ancestors 'none'"
)
# A report is a page of its own, without scripts, and reaches nothing.
_REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; sandbox"
_JSON = "application/json"
# A sentence to a browser that has not found the page: it needs no other file.
_PAGE = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    '<meta name="color-scheme" content="light dark"><title>roughcontact</title><h1>roughcontact</h1><p>{}</p></html>'
)
_LENGTH = re.compile(r"[0-9]{1,12}")
_RUN = re.compile(r"(?P<run>[0-9a-f]{24})(?:/(?P<name>[a-z0-9-]+\.[a-z]+))?")


class Refusal(Exception):
    """A request that is not served: status and sentence; and where to ask instead, if that is known."""

    def __init__(self, status: int, sentence: str, location: str = ""):
        super().__init__(sentence)
        self.status = status
        self.location = location


class AppServer(ThreadingHTTPServer):
    """The page at an address of this machine, until it is closed.

    Parameters
    ----------
    session
        What it serves.
    port
        The port; 0 for any that is free.
    """

    daemon_threads = True
    allow_reuse_address = False
    request_queue_size = 2 * connections.LIMIT

    def __init__(self, session: Session, port: int = 0):
        super().__init__((HOST, port), _Handler)
        self.session = session
        folder = resources.files("roughcontact_app") / "static"
        self.pages = {entry.name: entry.read_bytes() for entry in folder.iterdir() if entry.is_file()}
        self.connections = connections.Connections()

    @property
    def hosts(self) -> tuple[str, ...]:
        """The names of this server in requests: any other is that of an attacker's page (DNS rebinding)."""
        return tuple(f"{name}:{self.server_port}" for name in (HOST, "localhost"))

    @property
    def address(self) -> str:
        """The link to the page, with its token."""
        return f"http://{HOST}:{self.server_port}/{self.session.token}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a request in a thread of its own."""
        self.connections.add(request)
        super().process_request(request, client_address)

    def service_actions(self) -> None:
        """Close what has not shown the token in time; called twice a second."""
        super().service_actions()
        self.connections.close_late()

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        self.connections.remove(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a client that went away."""


class _Handler(BaseHTTPRequestHandler):
    """One request; whatever it is, it ends in an answer or in a sentence."""

    server: AppServer
    timeout = connections.PATIENCE
    server_version = "roughcontact"
    sys_version = ""

    def do_GET(self) -> None:
        self._answer(self._get)

    def do_POST(self) -> None:
        self._answer(self._post)

    def log_message(self, *_: Any) -> None:
        """Write no log: paths hold the token."""

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send a sentence instead of a page; for what the base class refuses."""
        self.close_connection = True
        known = http.HTTPStatus(code).phrase
        self._send(code, "text/plain; charset=utf-8", f"This request is not served: {known}.".encode())

    def _answer(self, serve: Any) -> None:
        try:
            serve(self._admit())
        except Refusal as refusal:
            self._fail(refusal.status, str(refusal), {"Location": refusal.location} if refusal.location else None)
        except (TaskEnded, RoughContactError) as error:
            self._fail(http.HTTPStatus.UNPROCESSABLE_ENTITY, str(error), setting=getattr(error, "setting", ""))
        except TimeoutError:
            self._fail(http.HTTPStatus.REQUEST_TIMEOUT, "The request came too slowly.")
        except ConnectionError:
            self.close_connection = True
        except Exception as error:
            self._fail(http.HTTPStatus.INTERNAL_SERVER_ERROR, str(translated(error, "The page")))

    def _admit(self) -> str:
        """Return the path below the token, or raise `Refusal`."""
        names = self.headers.get_all("Host", [])
        if len(names) != 1 or names[0].lower() not in self.server.hosts:
            raise Refusal(http.HTTPStatus.FORBIDDEN, f"Open the page as {HOST}: this server has no other name.")
        path = self.path.partition("?")[0]
        token, slash, rest = path.removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode("utf-8", "replace"), self.server.session.token.encode()):
            raise Refusal(
                http.HTTPStatus.FORBIDDEN,
                "This link is not of the run of 'roughcontact app' that serves here: open the address that it has "
                "printed. There, 'Restore from a link' takes the settings of an old link.",
            )
        if not self.server.connections.admit(self.connection):
            raise Refusal(http.HTTPStatus.SERVICE_UNAVAILABLE, "There are too many requests at once: try it again.")
        self.connection.settimeout(_SILENCE)
        if not slash:
            raise Refusal(http.HTTPStatus.FOUND, "The address of the page ends with a slash.", f"/{token}/")
        origin = f"http://{names[0].lower()}"
        if self.command == "POST" and self.headers.get_all("Origin", []) != [origin]:
            raise Refusal(http.HTTPStatus.FORBIDDEN, "Only the page of this server may send this.")
        return rest

    def _get(self, path: str) -> None:
        session = self.server.session
        folder, _, rest = path.partition("/")
        if path == "" or path in self.server.pages:
            name = path or "index.html"
            self._send(200, _TYPES[name.rpartition(".")[2]], self.server.pages[name])
        elif path == "api/start":
            self._send_json(session.describe(self._page))
        elif path == "api/runs":
            self._send_json({"runs": session.jobs.list_names()})
        elif folder == "pictures" and (picture := session.picture(rest)) is not None:
            self._send(200, _TYPES["png"], picture)
        elif folder == "runs" and (found := _RUN.fullmatch(rest)):
            self._send_run(found["run"], found["name"])
        else:
            raise Refusal(http.HTTPStatus.NOT_FOUND, "There is nothing at this address.")

    def _send_run(self, run: str, name: str | None) -> None:
        jobs = self.server.session.jobs
        job = jobs.find(run)
        if job is None:
            raise Refusal(http.HTTPStatus.NOT_FOUND, "This run is not known here any more: solve again.")
        if name is None:
            known = self._query("after")
            if _LENGTH.fullmatch(known):
                job.wait_past(int(known), _LOOK)
            self._send_json(jobs.describe(job))
            return
        if not job.offers(name):
            raise Refusal(http.HTTPStatus.NOT_FOUND, "This run has no such file.")
        file = jobs.write_file(job, name)
        ending = name.rpartition(".")[2]
        extra = {"Content-Security-Policy": _REPORT_POLICY} if ending == "html" else {}
        if ending in ("csv", "gif", "npz"):
            # The page's link names the file.
            extra = {"Content-Disposition": "attachment"}
        self._send(200, _TYPES[ending], file.read_bytes(), extra)

    def _post(self, path: str) -> None:
        session = self.server.session
        parts = path.split("/")
        if path == "api/upload":
            self._upload()
            return
        actions = {
            "api/surface": session.show_surface,
            "api/roughness": session.describe_roughness,
            "api/plan": session.plan,
            "api/state": session.draw_state,
            "api/runs": session.start,
        }
        if path in actions:
            self._send_json(actions[path](self._read_json(), self._page))
        elif path == "api/file":
            self._send_json(session.find_upload(str(self._read_json()), self._page, self._body))
        elif parts[:2] == ["api", "cancel"] and (job := session.jobs.find("/".join(parts[2:]))):
            self._read_json()
            session.jobs.cancel(job)
            self._send_json(session.jobs.describe(job))
        else:
            raise Refusal(http.HTTPStatus.NOT_FOUND, "There is nothing at this address, or this run is not known.")

    def _upload(self) -> None:
        size = self._length()
        try:
            self.server.session.uploads.require_size(size)
        except RoughContactError as error:
            raise Refusal(http.HTTPStatus.REQUEST_ENTITY_TOO_LARGE, str(error)) from None
        self._send_json(self.server.session.upload(self.rfile, size, self._query("name"), self._page, self._body))

    def _query(self, name: str) -> str:
        """Return what a request says behind the question mark; empty if it does not."""
        return parse_qs(self.path.partition("?")[2], max_num_fields=4).get(name, [""])[0]

    @property
    def _body(self) -> str:
        """The beginning of the settings of the body that a file is for."""
        named = self._query("body")
        return named if named in PREFIXES else ""

    @property
    def _page(self) -> str:
        """The name that a page has given itself; empty if it has none."""
        return self.headers.get("X-Page", "")[:_LONGEST_NAME]

    def _length(self) -> int:
        lengths = self.headers.get_all("Content-Length", [])
        if len(lengths) != 1 or not _LENGTH.fullmatch(lengths[0]) or "Transfer-Encoding" in self.headers:
            raise Refusal(http.HTTPStatus.LENGTH_REQUIRED, "The request must state its length.")
        return int(lengths[0])

    def _read_json(self) -> Any:
        size = self._length()
        if size > _LONGEST_BODY:
            raise Refusal(http.HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"Settings have at most {_LONGEST_BODY} bytes.")
        body = self.rfile.read(size)
        try:
            return json.loads(body.decode())
        except (ValueError, RecursionError):
            raise Refusal(http.HTTPStatus.BAD_REQUEST, "The settings are not JSON.") from None

    def _fail(self, status: int, sentence: str, extra: dict[str, str] | None = None, setting: str = "") -> None:
        self.close_connection = True
        # A person's browser asks for a page, the scripts of this page for JSON.
        if self.command == "GET" and "text/html" in self.headers.get("Accept", ""):
            self._send(status, _TYPES["html"], _PAGE.format(html.escape(sentence)).encode(), extra)
        else:
            self._send(status, _JSON, json.dumps({"error": sentence, "setting": setting}).encode(), extra)
        # A client that still sends gets the answer only if what it sends is read.
        self.connection.settimeout(1.0)
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_WR)
            left = _DRAINED
            end = time.monotonic() + _DRAINING
            while left > 0 and time.monotonic() < end and (block := self.connection.recv(min(left, 1 << 16))):
                left -= len(block)

    def _send_json(self, data: Any) -> None:
        self._send(200, _JSON, json.dumps(data, allow_nan=False).encode())

    def _send(self, status: int, kind: str, body: bytes, extra: dict[str, str] | None = None) -> None:
        headers = {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Content-Security-Policy": _POLICY,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cache-Control": "no-store",
            "Connection": "close",
        }
        self.send_response(status)
        for name, value in (headers | (extra or {})).items():
            self.send_header(name, value)
        self.end_headers()
        # The time without a byte begins anew with each block: over ssh a large file comes slowly.
        for start in range(0, len(body), _BLOCK):
            self.wfile.write(body[start : start + _BLOCK])
