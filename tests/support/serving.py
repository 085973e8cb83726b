"""A real server for tests: the REST API of a station, listening at a free port of this machine."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.errors import DeviceError
from skiros_py.server.services import Services
from skiros_py.server.serving import Serving, bind, switching_quickly, url_of
from skiros_py.server.settings import ServerSettings
from skiros_py.station.session import Options, Session

_PATIENCE = 30.0
"""How long the server may take to listen [s]."""
_PRETENDING = Options(fake=True)
_USUAL = ServerSettings()


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
    scene: str,
    data: Path,
    options: Options = _PRETENDING,
    settings: ServerSettings = _USUAL,
    catalogue: Catalogue | None = None,
) -> Iterator[Served]:
    """Serves a scene while the block runs.

    Args:
        scene: Name or path of the scene: the first content of a new data directory.
        data: The data directory.
        options: How to open the session; the pretending robot where left out.
        settings: How the server is set up; the port is any free one.
        catalogue: Its plug-ins; None for those that are installed.

    Yields:
        The server, ready.
    """
    chosen = replace(options, data=data)
    with (
        switching_quickly(),
        closing(bind(replace(settings, port=0))) as listening,
        Services(lambda: Session(scene, chosen, catalogue=catalogue), data, settings) as services,
    ):
        ready = threading.Event()
        server = Serving(services, listening, ready.set)
        thread = threading.Thread(target=server.run, name="skiros-test-server")
        thread.start()
        try:
            if not ready.wait(_PATIENCE):
                raise DeviceError("the server did not start")
            yield Served(url_of(listening), services)
        finally:
            server.end()
            thread.join()
