"""Serving: listens first, opens the station, serves until somebody ends it, and leaves everything standing."""

from __future__ import annotations

import socket

import uvicorn

from skiros_py.errors import UsageError
from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings

__all__ = ["bind", "serve"]

_GRACE = 3
"""How long open connections (streams) are waited for at the end [s]."""


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
    except OSError as error:
        listening.close()
        raise UsageError(
            f"cannot listen at {settings.host}:{settings.port}: {error.strerror}; choose another --port, 0 for any free one"
        ) from None
    return listening


def serve(services: Services, listening: socket.socket) -> None:
    """Serves until the process is asked to end (Ctrl-C, a polite kill).

    Args:
        services: Started already; whoever made it closes it.
        listening: From :func:`bind`.
    """
    config = uvicorn.Config(
        create_app(services),
        http="httptools",
        log_config=None,
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=_GRACE,
    )
    uvicorn.Server(config).run(sockets=[listening])
