"""The open connections of the server: those that have shown the token, and those that give way to them."""

from __future__ import annotations

import asyncio
import contextlib
import http
import sys
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

# Connections at a time, with the token and without; seconds in which one must have shown it.
LIMIT = 64
PATIENCE = 5.0


class Connections:
    """Open connections, each a stranger until it has shown the token; all of them live in one event loop."""

    def __init__(self) -> None:
        # In their order.
        self._strangers: dict[asyncio.Transport, None] = {}
        self._admitted: set[asyncio.Transport] = set()

    def add(self, connection: asyncio.Transport) -> None:
        """Take a stranger for a while; of too many the oldest is closed."""
        self._strangers[connection] = None
        if len(self._strangers) > LIMIT:
            self._close(next(iter(self._strangers)))
        asyncio.get_running_loop().call_later(PATIENCE, self._close, connection)

    def admit(self, connection: asyncio.Transport) -> bool:
        """Return whether a stranger that has shown the token is served: it is not closed, nor one too many."""
        is_served = connection in self._strangers and len(self._admitted) < LIMIT
        if is_served:
            del self._strangers[connection]
            self._admitted.add(connection)
        return is_served

    def remove(self, connection: asyncio.Transport) -> None:
        """Forget a connection that is closed."""
        self._strangers.pop(connection, None)
        self._admitted.discard(connection)

    def _close(self, connection: asyncio.Transport) -> None:
        if connection in self._strangers:
            del self._strangers[connection]
            connection.abort()


class GuardedProtocol(H11Protocol):
    """HTTP of uvicorn on a connection of `Connections`, which the application of its configuration has.

    The application finds the connection as ``transport`` in the state of a request.
    """

    app_state: dict[str, Any]

    def connection_made(self, transport: Any) -> None:
        """Take a connection as a stranger."""
        super().connection_made(transport)
        # Whatever is sent waits until it has gone.
        transport.set_write_buffer_limits(high=0)
        self.app_state = {**self.app_state, "transport": transport}
        self._known.add(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        self._known.remove(self.transport)
        super().connection_lost(exc)

    @property
    def _known(self) -> Connections:
        application: Any = self.config.app
        known: Connections = application.connections
        return known

    # Where uvicorn is not installed, its type is not known.
    def eof_received(self) -> Any:
        """Keep a connection whose client sends no more, but waits for the answer to what it has sent."""
        if self.cycle is None or self.cycle.response_complete:
            return False
        self.cycle.more_body = False
        self.cycle.message_event.set()
        return True

    def send_400_response(self, msg: str) -> None:
        """Answer what is not HTTP by a sentence, and what does not state its length by the status of that."""
        is_of_length = "Content-Length" in str(sys.exc_info()[1])
        status = http.HTTPStatus.LENGTH_REQUIRED if is_of_length else http.HTTPStatus.BAD_REQUEST
        headers = [("Content-Type", "text/plain; charset=utf-8"), ("Connection", "close")]
        sentence = f"This request is not served: {status.phrase}."
        # The answer may be under way.
        with contextlib.suppress(h11.LocalProtocolError):
            for event in (
                h11.Response(status_code=status, headers=headers, reason=status.phrase),
                h11.Data(data=sentence.encode()),
                h11.EndOfMessage(),
            ):
                self.transport.write(self.conn.send(event) or b"")
        self.transport.close()
