"""A real server for tests: the REST API of a station, listening at a free port of this machine."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import uvicorn

from skiros_py.errors import DeviceError
from skiros_py.runtime import Options, Session
from skiros_py.server.app import create_app
from skiros_py.server.serving import bind
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings

__all__ = ["Served", "serving"]

_PATIENCE = 30.0
"""How long the server may take to listen [s]."""


@dataclass(frozen=True, slots=True)
class Served:
    """A server that runs.

    Attributes:
        url: Its address, such as "http://127.0.0.1:40123"; the API is below ``/api/v1``.
        services: What it is made of.
    """

    url: str
    services: Services


@contextmanager
def serving(
    scene: str, data: Path, options: Options = Options(fake=True), settings: ServerSettings = ServerSettings()
) -> Iterator[Served]:
    """Serves a scene while the block runs.

    Args:
        scene: Name or path of the scene: the first content of a new data directory.
        data: The data directory.
        options: How to open the session; the pretending robot where left out.
        settings: How the server is set up; the port is any free one.

    Yields:
        The server, ready.
    """
    chosen = replace(options, data=data)
    listening = bind(replace(settings, port=0))
    with Services(lambda: Session(scene, chosen), data, settings) as services:
        config = uvicorn.Config(create_app(services), log_config=None, access_log=False, timeout_graceful_shutdown=1)
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, name="skiros-test-server")
        thread.start()
        try:
            _wait(server, thread)
            yield Served(f"http://127.0.0.1:{listening.getsockname()[1]}", services)
        finally:
            server.should_exit = True
            thread.join()


def _wait(server: uvicorn.Server, thread: threading.Thread) -> None:
    deadline = time.monotonic() + _PATIENCE
    while not server.started:
        if not thread.is_alive() or time.monotonic() > deadline:
            raise DeviceError("the server did not start")
        time.sleep(0.01)
