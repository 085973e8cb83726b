"""Runs the server: listens first, opens the station, serves until ended; and announces it to local programs."""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx2
import uvicorn
from fastapi import FastAPI
from fastapi.concurrency import run_in_threadpool

from skiros_py.api.server import SERVER_FILE, LocalServer
from skiros_py.errors import FileError, SkirosError, UsageError
from skiros_py.server.app import create_app
from skiros_py.server.connections import Connection, Connections
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings


@contextmanager
def announced(data: Path, url: str, token: str) -> Iterator[LocalServer]:
    """Announces the server of a data directory for the duration of the block.

    Args:
        data: The data directory; the caller holds its lock.
        url: Address of the server.
        token: The key that programs of the same user may use until the server ends.

    Raises:
        FileError: The announcement cannot be written.
    """
    server = LocalServer(url=url, pid=os.getpid(), token=token)
    path = data / SERVER_FILE
    try:
        _write(path, server.model_dump_json())
    except OSError as error:
        raise FileError(path, f"cannot be written: {error.strerror}") from error
    try:
        yield server
    finally:
        with suppress(OSError):  # a leftover announcement is recognised by the free lock
            path.unlink()


def _write(path: Path, text: str) -> None:
    """Writes a file atomically, and so that other users can never read it."""
    new = path.with_name(f"{path.name}.new")
    new.unlink(missing_ok=True)  # a leftover file may be readable for others
    with open(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:  # noqa: PTH123
        file.write(text)
    new.replace(path)


_SWITCH = 0.0002
"""Switch interval of the interpreter [s]."""
_GRACE = 3
"""Maximum wait for open connections (streams) at shutdown [s]."""
_BACKLOG = 4096
"""Maximum number of connections that wait to be accepted; the system may have a lower limit."""
_NO_FREE_PORT = (errno.EADDRINUSE, errno.EACCES)
"""Errors after which another port can help, since the address itself is valid."""
_log = logging.getLogger(__name__)


@contextmanager
def switching_quickly() -> Iterator[None]:
    """Makes threads release the interpreter sooner for the duration of the block.

    The control thread needs it 200 times a second, and would wait for 5 ms, a whole cycle, whenever a request is being
    answered.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def bind(settings: ServerSettings) -> socket.socket:
    """Binds the address before anything else is started.

    Raises:
        UsageError: The address is in use, or does not exist.
    """
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((settings.host, settings.port))
        listening.listen(_BACKLOG)  # two sockets that are bound but not listening may share an address
    except (OSError, OverflowError, ValueError) as error:  # ValueError: for a host that cannot be encoded in ASCII
        listening.close()
        raise UsageError(f"cannot listen at {settings.host}:{settings.port}: {_why(error)}") from None
    return listening


def _why(error: OSError | OverflowError | ValueError) -> str:
    if isinstance(error, OverflowError) or getattr(error, "errno", None) in _NO_FREE_PORT:
        return f"{getattr(error, 'strerror', error)}; choose another --port, 0 for any free one"
    text = getattr(error, "strerror", None) or error
    return f"{text}; --host is no address of this machine: 127.0.0.1 is one, and 0.0.0.0 stands for all that it has"


def url_of(listening: socket.socket) -> str:
    """Returns the URL at which a server with this socket is reached from this machine."""
    host, port = listening.getsockname()[:2]
    here = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)  # noqa: S104 - it is compared with, not bound
    return f"http://[{here}]:{port}" if ":" in here else f"http://{here}:{port}"


class Serving(uvicorn.Server):
    """One run of the server; its caller handles signals.

    Args:
        services: The services, already started; closed by the caller.
        listening: From :func:`bind`.
        on_listening: Called as soon as requests are answered.
    """

    def __init__(self, services: Services, listening: socket.socket, on_listening: Callable[[], None]) -> None:
        app = create_app(services)
        asyncio.run(_warm_up(app))
        config = uvicorn.Config(
            app,
            http="httptools",
            ws="none",  # a WebSocket would have no deadlines, and there is none
            log_config=None,
            access_log=False,
            server_header=False,
            proxy_headers=False,  # the application reads them, from trusted proxies only
            timeout_keep_alive=services.settings.idle_seconds,
            timeout_graceful_shutdown=_GRACE,
        )
        super().__init__(config)
        self._services = services
        self._listening = listening
        self._connections = Connections(services.settings)
        self._on_listening = on_listening

    def run(self, sockets: list[socket.socket] | None = None) -> None:
        """Serves until :meth:`end`, then brakes everything and lets open requests finish."""
        super().run(sockets or [self._listening])

    def end(self) -> None:
        """Requests the end of the server; safe to call from a signal handler."""
        self.should_exit = True

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leaves signals to the caller."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Starts to listen."""
        await super().startup([])
        (listening,) = sockets or [self._listening]
        usual = {"config": self.config, "server_state": self.server_state, "app_state": self.lifespan.state}
        self._connections.listen(listening, lambda newcomer: Connection(self._connections, newcomer, **usual))
        self._on_listening()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Brakes everything, then waits for connections to close; running jobs then wait for a person."""
        self._services.streams.end()
        self._connections.close()
        if self._services.station.control.alive:
            try:
                self._services.station.session.cycle.halt("the server ends")
            except SkirosError as error:
                _log.error("not everything was halted: %s", error)
        await super().shutdown(sockets)


async def _warm_up(app: FastAPI) -> None:
    """Does all lazy initialisation in advance, because the first request may be a stop, or delay one."""
    await run_in_threadpool(lambda: None)  # loads what runs routes in threads, and streams
    async with httpx2.AsyncClient(transport=httpx2.ASGITransport(app), base_url="http://127.0.0.1") as client:
        await client.get("/healthz")
