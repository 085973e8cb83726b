"""The connections of a server: deadlines for clients, and room for newcomers, whose request may be a stop."""

from __future__ import annotations

import asyncio
import logging
import re
import resource
import socket
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import Any, TypeAlias

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from skiros_py.server.access.limiters import network_of
from skiros_py.server.settings import ServerSettings

_log = logging.getLogger(__name__)

_DESCRIPTORS = 8192
"""Soft limit of open files that is set if the hard limit allows it."""
_KEPT_BACK = 256
"""Descriptors that are never used for connections: they are for the journal, recordings and child processes."""
_FEWEST = 64
"""Number of connections that are accepted however low the limit of open files is."""
_LONGEST_HEADER = 64 << 10
"""Maximum length of a header [bytes]; the gate refuses shorter ones with an explanation."""
_REQUEST = re.compile(rb"[A-Z\r\n]")
"""How a request begins: a method, after empty lines."""
_END_OF_HEADER = re.compile(rb"\n\r?\n")
_STOP = re.compile(rb"\s*POST \S*/api/v1/stop[ ?]")
"""How the header of a stop begins."""
_PIPELINED = 100
"""Maximum number of requests of one connection that wait until the one before them is answered."""
_LOOK = 0.5
"""Period at which deadlines are checked [s]."""
_ACCEPTED_AT_ONCE = 64
"""Number of connections that are accepted before requests are served again."""
_PAUSE = 0.05
"""Time until the next attempt after a connection could not be accepted [s]."""
_SILENCE = 60.0
"""Shortest time between two warnings about connections closed for lack of room [s]."""


def room_for(wanted: int) -> int:
    """Raises the soft limit of open files, and returns how many connections it allows.

    Args:
        wanted: Maximum number of connections.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    aim = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_DESCRIPTORS, hard)
    if soft == resource.RLIM_INFINITY:
        return wanted
    if soft < aim:
        resource.setrlimit(resource.RLIMIT_NOFILE, (aim, hard))
    return min(wanted, max(_FEWEST, max(soft, aim) - _KEPT_BACK))


class _Group:
    """Connections of one network, or all of them.

    Attributes:
        idle: Those that wait for their client: to send a complete header, or to read. The longest waiting come first.
        busy: Those with a request in progress, in the order of these requests.
    """

    def __init__(self) -> None:
        self.idle: OrderedDict[Client, None] = OrderedDict()
        self.busy: OrderedDict[Client, None] = OrderedDict()

    def __len__(self) -> int:
        return len(self.idle) + len(self.busy)

    def close_oldest(self) -> None:
        """Closes the connection that has waited longest for its client; if none does, the oldest busy one."""
        for connection in self.idle or self.busy:
            connection.abort()
            return


class Connections:
    """Accepts connections, and closes those whose clients take too long. To be used in the event loop only.

    A newcomer is never refused, because its request may be a stop: if there is no room for it, the connection that has
    waited longest for its client is closed.

    Args:
        settings: Settings of the server.
    """

    def __init__(self, settings: ServerSettings) -> None:
        self.settings = settings
        self._most = room_for(settings.connections)
        self._all = _Group()
        self._networks: dict[str, _Group] = {}
        self._warned = -_SILENCE
        self._ready: deque[Newcomer] = deque()
        self._accepting: set[asyncio.Task[Any]] = set()
        self._loop: asyncio.AbstractEventLoop
        self._listening: socket.socket | None = None
        self._make: Callable[[Newcomer], Connection]

    # ------------------------------------------------------------------ accepting

    def listen(self, listening: socket.socket, make: Callable[[Newcomer], Connection]) -> None:
        """Starts to accept connections.

        The event loop's own server is not used: after a failure to accept, uvloop's stops listening for good.

        Args:
            listening: A listening socket, closed by the caller after :meth:`close`.
            make: Creates the protocol of a connection whose first header has arrived.
        """
        listening.setblocking(False)
        self._loop, self._listening, self._make = asyncio.get_running_loop(), listening, make
        self._resume()
        self._check_deadlines()

    def close(self) -> None:
        """Stops accepting connections, and closes those without a request."""
        if self._listening is not None:
            self._loop.remove_reader(self._listening)
            self._listening = None
        for connection in tuple(self._all.idle):
            connection.shutdown()

    def _resume(self) -> None:
        if self._listening is not None:
            self._loop.add_reader(self._listening, self._accept, self._listening)

    def _accept(self, listening: socket.socket) -> None:
        for _ in range(_ACCEPTED_AT_ONCE):
            try:
                accepted, address = listening.accept()
            except BlockingIOError:
                return
            except ConnectionError:  # the client has gone
                continue
            except OSError as error:  # no descriptor or no memory is left
                self._make_room(self._all, str(error))
                self._loop.remove_reader(listening)
                self._loop.call_later(_PAUSE, self._resume)
                return
            newcomer = Newcomer(self, accepted, str(address[0]))
            self.add(newcomer)
            newcomer.receive()

    def serve(self, newcomer: Newcomer) -> None:
        """Answers the requests of a connection whose first header has arrived: a stop at once, others in turn.

        One begins in a round of the event loop, so that many do not delay the acceptance of a stop.
        """
        if _STOP.match(newcomer.received):
            self._begin(newcomer)
            return
        self.set_busy(newcomer)  # it waits for the server now, however long that takes
        self._ready.append(newcomer)
        if len(self._ready) == 1:
            self._loop.call_soon(self._begin_next)

    def _begin_next(self) -> None:
        self._begin(self._ready.popleft())
        if self._ready:
            self._loop.call_soon(self._begin_next)

    def _begin(self, newcomer: Newcomer) -> None:
        if newcomer.accepted.fileno() < 0:  # closed meanwhile
            return
        self.discard(newcomer)
        making = self._loop.connect_accepted_socket(lambda: self._make(newcomer), newcomer.accepted)
        task = self._loop.create_task(making)
        self._accepting.add(task)
        task.add_done_callback(self._accepting.discard)

    # ------------------------------------------------------------------ states

    def add(self, connection: Client) -> None:
        """Adds a new connection, and closes an old one if there are too many."""
        network = self._networks.setdefault(connection.network, _Group())
        if len(network) >= self.settings.connections_of_one and not self.settings.is_proxy(connection.address):
            self._make_room(network, f"{connection.network} has {len(network)}")
        elif len(self._all) >= self._most:
            self._make_room(self._all, f"there are {self._most}")
        self._networks.setdefault(connection.network, network)
        self.set_idle(connection)

    def set_idle(self, connection: Client) -> None:
        """Marks a connection as waiting for its client."""
        for group in self._groups(connection):
            group.busy.pop(connection, None)
            group.idle[connection] = None
            group.idle.move_to_end(connection)

    def set_busy(self, connection: Client) -> None:
        """Marks a connection as having a request in progress."""
        for group in self._groups(connection):
            if group.idle.pop(connection, _ABSENT) is not _ABSENT:
                group.busy[connection] = None

    def discard(self, connection: Client) -> None:
        """Removes a connection; may be called twice."""
        for group in self._groups(connection):
            group.idle.pop(connection, None)
            group.busy.pop(connection, None)
        if not self._networks.get(connection.network, ()):
            self._networks.pop(connection.network, None)

    def _groups(self, connection: Client) -> tuple[_Group, ...]:
        network = self._networks.get(connection.network)
        return (self._all,) if network is None else (self._all, network)

    def _make_room(self, group: _Group, why: str) -> None:
        group.close_oldest()
        now = time.monotonic()
        if now - self._warned >= _SILENCE:
            self._warned = now
            _log.warning("connections: the one that waits longest is closed for a new one: %s", why)

    def _check_deadlines(self) -> None:
        """Closes the connections whose clients are late; called periodically."""
        if self._listening is None:
            return
        now = self._loop.time()
        for one in tuple(self._all.busy):
            if isinstance(one, Connection) and one.transport.is_closing():  # once the client has read everything
                one.wait_for_client(self.settings.stalled_seconds)
        for late in [one for one in self._all.idle if one.deadline < now]:
            late.check_progress()
        self._loop.call_later(_LOOK, self._check_deadlines)


_ABSENT = object()


class Newcomer:
    """A connection until its first header has arrived: only a socket, since there may be thousands of them.

    Args:
        connections: All connections.
        accepted: Its socket.
        address: Address of the client, or of its proxy.

    Attributes:
        accepted: Its socket.
        address: Address of the client, or of its proxy.
        network: Key by which connections of one origin are counted.
        deadline: Time until which the client has to send a complete header [s of the event loop].
        received: What the client has sent.
    """

    def __init__(self, connections: Connections, accepted: socket.socket, address: str) -> None:
        self._connections = connections
        self._loop = asyncio.get_running_loop()
        self.accepted = accepted
        self.address = address
        self.network = network_of(address)
        self.deadline = self._loop.time() + connections.settings.header_seconds
        self.received = bytearray()
        accepted.setblocking(False)
        self._loop.add_reader(accepted, self.receive)

    def receive(self) -> None:
        """Reads what has arrived; a complete header is answered, and so is what begins no request."""
        try:
            data = self.accepted.recv(_LONGEST_HEADER)
        except BlockingIOError:
            return
        except OSError:  # the client has gone
            data = b""
        before = len(self.received)
        self.received += data
        if not data:
            self.abort()
        elif (
            _END_OF_HEADER.search(self.received, max(0, before - 2))
            or not _REQUEST.match(self.received)
            or len(self.received) > _LONGEST_HEADER
        ):
            self._loop.remove_reader(self.accepted)
            self._connections.serve(self)

    def abort(self) -> None:
        """Closes the connection."""
        self._connections.discard(self)
        self._loop.remove_reader(self.accepted)
        self.accepted.close()

    check_progress = shutdown = abort


class Connection(HttpToolsProtocol):
    """A connection whose first header has arrived.

    Args:
        connections: All connections.
        newcomer: What it was before.
        **usual: Arguments of uvicorn's own protocol.

    Attributes:
        address: Address of the client, or of its proxy.
        network: Key by which connections of one origin are counted.
        deadline: Time until which the client has to send a complete header, or to read [s of the event loop].
    """

    def __init__(self, connections: Connections, newcomer: Newcomer, **usual: Any) -> None:
        super().__init__(**usual)
        self._connections = connections
        self._settings = connections.settings
        self._header: int | None = None
        self._unread = 0
        self._received = bytes(newcomer.received)
        self.address = newcomer.address
        self.network = newcomer.network
        self.deadline = newcomer.deadline

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Answers the first request."""
        super().connection_made(transport)
        self._connections.add(self)
        self.data_received(self._received)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forgets the connection."""
        self._connections.discard(self)
        super().connection_lost(exc)

    def abort(self) -> None:
        """Closes the connection immediately, without sending what the client has not read."""
        self._connections.discard(self)
        self.transport.abort()

    def wait_for_client(self, seconds: float) -> None:
        """Waits for the client, for a limited time [s]."""
        self.deadline = self.loop.time() + seconds
        self._connections.set_idle(self)

    def check_progress(self) -> None:
        """Closes the connection, unless the client has read something since the last check."""
        unread = self.transport.get_write_buffer_size()
        if unread < self._unread:
            self._unread = unread
            self.deadline = self.loop.time() + self._settings.stalled_seconds
        else:
            self.abort()

    # ------------------------------------------------------------------ requests

    def data_received(self, data: bytes) -> None:
        """Handles data, but only a limited amount for one header."""
        begun = self._header is not None
        super().data_received(data)
        if begun and self._header is not None:
            self._header += len(data)
            if self._header > _LONGEST_HEADER and not self.transport.is_closing():
                self.send_400_response("The header is too long.")

    def on_message_begin(self) -> None:
        """Expects a complete header soon."""
        super().on_message_begin()
        self._header = 0
        self.deadline = min(self.deadline, self.loop.time() + self._settings.header_seconds)

    def on_headers_complete(self) -> None:
        """Starts to answer, or queues the request."""
        self._header = None
        if len(self.pipeline) < _PIPELINED:
            super().on_headers_complete()
            self._connections.set_busy(self)
        else:
            self.abort()

    def on_message_complete(self) -> None:
        """Waits for the next request, if this one was answered before it had arrived."""
        super().on_message_complete()
        if self.cycle.response_complete:
            self.wait_for_client(self._settings.idle_seconds)

    def on_response_complete(self) -> None:
        """Waits for the next request, unless it has arrived."""
        super().on_response_complete()
        if self.cycle.response_complete:
            partial = self._header is not None or self.cycle.more_body
            self.wait_for_client(self._settings.header_seconds if partial else self._settings.idle_seconds)

    # ------------------------------------------------------------------ answers

    def pause_writing(self) -> None:
        """Waits until the client reads."""
        super().pause_writing()
        self._unread = self.transport.get_write_buffer_size()
        self.wait_for_client(self._settings.stalled_seconds)

    def resume_writing(self) -> None:
        """Continues with the answer."""
        super().resume_writing()
        self._unread = 0
        if self.cycle is not None and not self.cycle.response_complete:
            self._connections.set_busy(self)


Client: TypeAlias = Newcomer | Connection
