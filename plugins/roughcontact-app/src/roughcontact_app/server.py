"""The server of the page: on this machine alone, behind a token, with bounds on all that it takes."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import html
import json
import re
import socket
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from typing import Any

import uvicorn
from roughcontact.errors import RoughContactError
from roughcontact.errors.door import translated
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, Router
from starlette.types import Message, Receive, Scope, Send

from roughcontact_app import connections
from roughcontact_app.jobs import Job
from roughcontact_app.process import TaskEnded
from roughcontact_app.session import Session
from roughcontact_app.settings import PREFIXES

# The loopback address: no other machine can reach it.
HOST = "127.0.0.1"
# Bytes of settings; seconds without a byte; bytes that are sent at a time.
_LONGEST_BODY = 1 << 16
_SILENCE = 30.0
_BLOCK = 1 << 18
# Seconds after which a page that waits for another phase of a run has an answer anyway.
_LOOK = 0.5
# Characters of the name of a page.
_LONGEST_NAME = 40
# Seconds, and seconds without a byte, for which a refused request is read so that the client sees the answer.
_DRAINING = 2.0
_DRAINED_SILENCE = 0.5
_TYPES = {
    "css": "text/css; charset=utf-8",
    "csv": "text/csv; charset=utf-8",
    "gif": "image/gif",
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "json": "application/json",
    "npz": "application/octet-stream",
    "png": "image/png",
    "svg": "image/svg+xml",
    "txt": "text/plain; charset=utf-8",
}
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
    "Connection": "close",
}
# A report is a page of its own, without scripts, and reaches nothing.
_REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; sandbox"
# A sentence to a browser that has not found the page: it needs no other file.
_PAGE = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    '<meta name="color-scheme" content="light dark"><title>roughcontact</title><h1>roughcontact</h1><p>{}</p></html>'
)
_NUMBER = re.compile(r"[0-9]{1,12}")
_NOT_FOUND = "There is nothing at this address, or this run is not known."


class Refusal(Exception):
    """A request that is not served: status and sentence; the wrong setting, or where to ask instead, if known."""

    def __init__(self, status: int, sentence: str, setting: str = "", location: str = ""):
        super().__init__(sentence)
        self.status = status
        self.setting = setting
        self.location = location


class AppServer:
    """The page at an address of this machine, until it is closed.

    Parameters
    ----------
    session
        What it serves.
    port
        The port; 0 for any that is free.
    """

    def __init__(self, session: Session, port: int = 0):
        self.session = session
        self._socket = socket.create_server((HOST, port), backlog=2 * connections.LIMIT)
        self.server_address: tuple[str, int] = self._socket.getsockname()
        self.server_port = self.server_address[1]
        application = _Application(session, self.server_port)
        self.pages = application.pages
        self.connections = application.connections
        config = uvicorn.Config(
            application,
            http=connections.GuardedProtocol,
            loop="asyncio",
            ws="none",
            interface="asgi3",
            lifespan="off",
            proxy_headers=False,
            server_header=False,
            # No log: paths hold the token.
            access_log=False,
            log_config=None,
            log_level="critical",
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        self._application = application
        self._ended = threading.Event()
        # Signals come to the main thread alone, which waits.
        threading.Thread(target=self._run, daemon=True).start()

    def __enter__(self) -> AppServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
        self._socket.close()
        self._application.close()

    @property
    def address(self) -> str:
        """The link to the page, with its token."""
        return f"http://{HOST}:{self.server_port}/{self.session.token}/"

    def serve_forever(self) -> None:
        """Wait until `shutdown`, or an exception in this thread such as that of Ctrl-C."""
        # On Windows a signal comes only between two waits.
        while not self._ended.wait(0.5):
            pass

    def shutdown(self) -> None:
        """Serve no more; what is being answered has a second."""
        self._server.should_exit = True
        self._ended.wait()

    def _run(self) -> None:
        try:
            self._server.run([self._socket])
        finally:
            self._ended.set()


class _Application:
    """What answers each request; whatever it is, that ends in an answer or in a sentence."""

    def __init__(self, session: Session, port: int):
        self._session = session
        # Any other name of the host is that of an attacker's page (DNS rebinding).
        self._hosts = tuple(f"{name}:{port}" for name in (HOST, "localhost"))
        self.connections = connections.Connections()
        folder = resources.files("roughcontact_app") / "static"
        self.pages = {entry.name: entry.read_bytes() for entry in folder.iterdir() if entry.is_file()}
        # What waits for a process or a disk holds up nobody else.
        self._threads = ThreadPoolExecutor(connections.LIMIT, thread_name_prefix="request")
        jobs = session.jobs
        gets = {
            "/api/start": self._json(session.describe, _name_page),
            "/api/runs": self._json(lambda: {"runs": jobs.list_names()}),
            "/runs/{run}": self._json(self._describe_run, self._find_job, _read_version),
            "/runs/{run}/{name}": self._get_file,
            "/pictures/{name}": self._get_picture,
            "/{name}": self._get_page,
            "/": self._get_page,
        }
        posts = {
            "/api/surface": self._json(session.show_surface, _read_json, _name_page),
            "/api/roughness": self._json(session.describe_roughness, _read_json, _name_page),
            "/api/plan": self._json(session.plan, _read_json, _name_page),
            "/api/state": self._json(session.draw_state, _read_json, _name_page),
            "/api/runs": self._json(session.start, _read_json, _name_page),
            "/api/file": self._json(session.find_upload, _read_json, _name_page, _name_body),
            "/api/cancel/{run}": self._json(self._cancel, self._find_job, _read_json),
            "/api/upload": self._post_upload,
        }
        routes = [Route(path, serve, methods=["GET"]) for path, serve in gets.items()]
        routes += [Route(path, serve, methods=["POST"]) for path, serve in posts.items()]
        self._router = Router(routes, redirect_slashes=False)

    def close(self) -> None:
        """Do nothing any more for requests whose time has ended."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, in the interface ASGI."""
        transport = scope["state"]["transport"]
        request = Request(scope, receive)
        try:
            try:
                # Where it finds an application, Starlette raises what it refuses.
                below = {**scope, "path": f"/{self._admit(request, transport)}", "app": self}
                await self._router(below, _receive_in_time(receive), _send_in_time(send))
            except (ClientDisconnect, ConnectionError):
                pass
            except Exception as error:
                # A client that still sends gets the answer only if what it sends is read.
                in_time = _send_in_time(send, lambda: _drain(receive))
                await _refuse(request, _explain(error))(scope, receive, in_time)
        except TimeoutError:
            # The client does not read the answer.
            transport.abort()

    def _admit(self, request: Request, transport: asyncio.Transport) -> str:
        """Return the path below the token, or raise `Refusal`."""
        host = request.headers.get("Host", "").lower()
        if host not in self._hosts:
            raise Refusal(403, f"Open the page as {HOST}: this server has no other name.")
        token, slash, rest = request.scope["path"].removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode("utf-8", "replace"), self._session.token.encode()):
            raise Refusal(
                403,
                "This link is not of the run of 'roughcontact app' that serves here: open the address that it has "
                "printed. There, 'Restore from a link' takes the settings of an old link.",
            )
        if not self.connections.admit(transport):
            raise Refusal(503, "There are too many requests at once: try it again.")
        if request.method not in ("GET", "POST"):
            raise Refusal(501, "The page sends no such request.")
        if not slash:
            raise Refusal(302, "The address of the page ends with a slash.", location=f"/{token}/")
        if request.method == "POST" and request.headers.getlist("Origin") != [f"http://{host}"]:
            raise Refusal(403, "Only the page of this server may send this.")
        return str(rest)

    async def _do(self, act: Callable[..., Any], *values: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._threads, act, *values)

    def _json(self, act: Callable[..., Any], *parts: Callable[[Request], Any]) -> Callable[[Request], Any]:
        """Return what answers a request by what a function returns of some parts of it."""

        async def answer(request: Request) -> Response:
            return JSONResponse(await self._do(act, *[await part(request) for part in parts]))

        return answer

    def _describe_run(self, job: Job, version: int | None) -> dict[str, Any]:
        if version is not None:
            job.wait_past(version, _LOOK)
        return self._session.jobs.describe(job)

    def _cancel(self, job: Job, _: object) -> dict[str, Any]:
        self._session.jobs.cancel(job)
        return self._session.jobs.describe(job)

    async def _find_job(self, request: Request) -> Job:
        job = self._session.jobs.find(request.path_params["run"])
        if job is None:
            raise Refusal(404, "This run is not known here any more: solve again.")
        return job

    async def _get_page(self, request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        return _send_file(self.pages.get(name), name)

    async def _get_picture(self, request: Request) -> Response:
        return _send_file(self._session.picture(request.path_params["name"]), "picture.png")

    async def _get_file(self, request: Request) -> Response:
        job = await self._find_job(request)
        name = request.path_params["name"]
        if not job.offers(name):
            raise Refusal(404, "This run has no such file.")
        file = await self._do(self._session.jobs.write_file, job, name)
        return _send_file(await self._do(file.read_bytes), name)

    async def _post_upload(self, request: Request) -> Response:
        size = _read_length(request)
        uploads = self._session.uploads
        try:
            uploads.require_size(size)
        except RoughContactError as error:
            raise Refusal(413, str(error)) from None
        with uploads.begin(size, request.query_params.get("name", "")) as partial:
            async for block in request.stream():
                await self._do(partial.write, block)
            names = await _name_page(request), await _name_body(request)
            return JSONResponse(await self._do(self._session.upload, partial, *names))


def _explain(error: Exception) -> Refusal:
    """Return the refusal that an error of a request is."""
    if isinstance(error, Refusal):
        return error
    if isinstance(error, HTTPException):
        return Refusal(404, _NOT_FOUND)
    if isinstance(error, (TaskEnded, RoughContactError)):
        return Refusal(422, str(error), getattr(error, "setting", ""))
    if isinstance(error, TimeoutError):
        return Refusal(408, "The request came too slowly.")
    return Refusal(500, str(translated(error, "The page")))


def _refuse(request: Request, refusal: Refusal) -> Response:
    extra = {"Location": refusal.location} if refusal.location else {}
    # A person's browser asks for a page, the scripts of this page for JSON.
    if request.method == "GET" and "text/html" in request.headers.get("Accept", ""):
        return Response(_PAGE.format(html.escape(str(refusal))), refusal.status, extra, _TYPES["html"])
    return JSONResponse({"error": str(refusal), "setting": refusal.setting}, refusal.status, extra)


async def _name_page(request: Request) -> str:
    """Return the name that a page has given itself; empty if it has none."""
    return str(request.headers.get("X-Page", "")[:_LONGEST_NAME])


async def _name_body(request: Request) -> str:
    """Return the beginning of the settings of the body that a file is for."""
    named = str(request.query_params.get("body", ""))
    return named if named in PREFIXES else ""


async def _read_version(request: Request) -> int | None:
    known = request.query_params.get("after", "")
    return int(known) if _NUMBER.fullmatch(known) else None


def _read_length(request: Request) -> int:
    length = request.headers.get("Content-Length", "")
    if not _NUMBER.fullmatch(length) or "Transfer-Encoding" in request.headers:
        raise Refusal(411, "The request must state its length.")
    return int(length)


async def _read_json(request: Request) -> Any:
    if _read_length(request) > _LONGEST_BODY:
        raise Refusal(413, f"Settings have at most {_LONGEST_BODY} bytes.")
    body = await request.body()
    try:
        return json.loads(body.decode())
    except (ValueError, RecursionError):
        raise Refusal(400, "The settings are not JSON.") from None


def _send_file(content: bytes | None, name: str) -> Response:
    if content is None:
        raise Refusal(404, _NOT_FOUND)
    ending = name.rpartition(".")[2]
    extra = {"Content-Type": _TYPES[ending]}
    if name == "report.html":
        extra["Content-Security-Policy"] = _REPORT_POLICY
    if ending in ("csv", "gif", "json", "npz", "txt"):
        # The page's link names the file.
        extra["Content-Disposition"] = "attachment"
    return Response(content, headers=extra)


def _receive_in_time(receive: Receive) -> Receive:
    async def receive_in_time() -> Message:
        async with asyncio.timeout(_SILENCE):
            return await receive()

    return receive_in_time


def _send_in_time(send: Send, before_end: Callable[[], Any] | None = None) -> Send:
    """Return what sends an answer with the headers that protect, and block by block.

    The time without a byte begins anew with each block: over ssh a large file comes slowly. Before the answer ends,
    `before_end` is waited for.
    """

    async def send_block(message: Message) -> None:
        async with asyncio.timeout(_SILENCE):
            await send(message)

    async def send_in_time(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
            await send_block(message)
            return
        body = message["body"]
        for start in range(0, len(body), _BLOCK):
            await send_block({**message, "body": body[start : start + _BLOCK], "more_body": True})
        if before_end is not None:
            await before_end()
        await send_block({**message, "body": b""})

    return send_in_time


async def _drain(receive: Receive) -> None:
    """Read what a client still sends, for a while."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(_DRAINING):
            more = True
            while more:
                async with asyncio.timeout(_DRAINED_SILENCE):
                    more = (await receive()).get("more_body", False)
