"""Serving: listens first, opens the station, serves until somebody ends it, and leaves everything standing."""

from __future__ import annotations

import asyncio
import errno
import logging
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import httpx2
import uvicorn
from fastapi import FastAPI

from skiros_py.errors import SkirosError, UsageError
from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings

_SWITCH = 0.001
"""How long a thread keeps the interpreter when others want it [s]."""
_GRACE = 3
"""How long open connections (streams) are waited for at the end [s]."""
_NO_FREE_PORT = (errno.EADDRINUSE, errno.EACCES)
"""Another port does where the address itself is good."""
_log = logging.getLogger(__name__)


@contextmanager
def switching_quickly() -> Iterator[None]:
    """Has threads hand on the interpreter sooner while the block runs.

    The control thread asks for it 200 times a second and would wait for 5 ms each time that a request is being
    answered: a whole cycle.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def bind(settings: ServerSettings) -> socket.socket:
    """Takes the address, before anything else is started.

    Raises:
        UsageError: Another program has it, or there is no such address.
    """
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((settings.host, settings.port))
        listening.listen()  # two sockets that only wait to listen may have one address
    except (OSError, OverflowError, ValueError) as error:  # ValueError: of a host that cannot be written in ASCII
        listening.close()
        raise UsageError(f"cannot listen at {settings.host}:{settings.port}: {_why(error)}") from None
    return listening


def _why(error: OSError | OverflowError | ValueError) -> str:
    if isinstance(error, OverflowError) or getattr(error, "errno", None) in _NO_FREE_PORT:
        return f"{getattr(error, 'strerror', error)}; choose another --port, 0 for any free one"
    text = getattr(error, "strerror", None) or error
    return f"{text}; --host is no address of this machine: 127.0.0.1 is one, and 0.0.0.0 stands for all that it has"


def url_of(listening: socket.socket) -> str:
    """Returns the address at which a server that listens there is reached from this machine."""
    host, port = listening.getsockname()[:2]
    here = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)  # noqa: S104 - it is compared with, not bound
    return f"http://[{here}]:{port}" if ":" in here else f"http://{here}:{port}"


class Serving:
    """One run of the server.

    Args:
        services: Started already; its maker closes it.
        listening: From :func:`bind`.
        on_listening: Called as soon as requests are answered.
    """

    def __init__(self, services: Services, listening: socket.socket, on_listening: Callable[[], None]) -> None:
        app = create_app(services)
        asyncio.run(_warm_up(app))
        config = uvicorn.Config(
            app,
            http="httptools",
            log_config=None,
            access_log=False,
            server_header=False,
            proxy_headers=False,  # any program on this machine could claim to speak for somebody else
            timeout_graceful_shutdown=_GRACE,
        )
        self._server = _Server(config, on_listening, lambda: _halt(services))
        self._listening = listening

    def run(self) -> None:
        """Serves until :meth:`end`, then brakes everything and lets open requests come to their end."""
        self._server.run(sockets=[self._listening])

    def end(self) -> None:
        """Asks the server to end; safe to call from a signal handler."""
        self._server.should_exit = True


async def _warm_up(app: FastAPI) -> None:
    """Has everything made that is made for the first request, which may be somebody's stop."""
    async with httpx2.AsyncClient(transport=httpx2.ASGITransport(app), base_url="http://127.0.0.1") as client:
        await client.get("/healthz")


class _Server(uvicorn.Server):
    """Tells when it listens and when it ends; its caller handles signals."""

    def __init__(self, config: uvicorn.Config, on_listening: Callable[[], None], on_end: Callable[[], None]) -> None:
        super().__init__(config)
        self._on_listening = on_listening
        self._on_end = on_end

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self._on_listening()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._on_end()
        await super().shutdown(sockets)


def _halt(services: Services) -> None:
    """Brakes everything before the connections are waited for; running jobs wait for a person then."""
    services.streams.end()
    if not services.station.control.alive:
        return
    try:
        services.station.session.cycle.halt("the server ends")
    except SkirosError as error:
        _log.error("not everything was halted: %s", error)
