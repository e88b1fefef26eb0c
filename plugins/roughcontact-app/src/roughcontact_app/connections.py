"""The open connections of the server: those that have shown the token, and those that give way to them."""

from __future__ import annotations

import contextlib
import socket
import threading
import time

# Connections at a time, with the token and without; seconds in which one must have shown it.
LIMIT = 64
PATIENCE = 5.0


class Connections:
    """Open connections, each a stranger until it has shown the token."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # In their order, with the end of their time.
        self._strangers: dict[socket.socket, float] = {}
        self._admitted: set[socket.socket] = set()

    def add(self, connection: socket.socket) -> None:
        """Take a stranger; of too many the oldest is closed."""
        with self._lock:
            self._strangers[connection] = time.monotonic() + PATIENCE
            if len(self._strangers) > LIMIT:
                self._close_oldest()

    def admit(self, connection: socket.socket) -> bool:
        """Return whether a stranger that has shown the token is served: it is not closed, nor one too many."""
        with self._lock:
            is_served = self._strangers.pop(connection, None) is not None and len(self._admitted) < LIMIT
            if is_served:
                self._admitted.add(connection)
            return is_served

    def remove(self, connection: socket.socket) -> None:
        """Forget a connection, before it is closed."""
        with self._lock:
            self._strangers.pop(connection, None)
            self._admitted.discard(connection)

    def close_late(self) -> None:
        """Close the strangers whose time has ended."""
        with self._lock:
            while self._strangers and next(iter(self._strangers.values())) < time.monotonic():
                self._close_oldest()

    def _close_oldest(self) -> None:
        connection = next(iter(self._strangers))
        del self._strangers[connection]
        # The thread that waits for it finds its end.
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)
