"""What routes reach: the station, and what the server adds to it: access, streams, webhooks, metrics."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Annotated, Self

from fastapi import Depends, Request

from skiros_py.server.access.audit import AuditLog
from skiros_py.server.access.authenticator import Authenticator
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.setup import set_up_access
from skiros_py.server.events.streams import Streams
from skiros_py.server.logs import job_events_logged
from skiros_py.server.metrics import Metrics
from skiros_py.server.settings import ServerSettings
from skiros_py.server.webhooks.sender import WebhookSender
from skiros_py.server.webhooks.setup import open_sender
from skiros_py.server.webhooks.store import WebhookStore
from skiros_py.station.control import OpenSession
from skiros_py.station.session import Session
from skiros_py.station.station import Station, StationLimits


class Services:
    """What one server is made of. Start it, and close it, or use it in a ``with``.

    Args:
        opening: Opens the session.
        data: The data directory.
        settings: How the server is set up.

    Attributes:
        settings: How the server is set up.
        station: The use cases that routes call.
        keys: API keys; from :meth:`start` on.
        authenticator: Finds out who makes a request; from :meth:`start` on.
        audit: Who changed what, and who was refused; from :meth:`start` on.
        streams: Who listens to events.
        metrics: Figures for those who watch the server.
        webhooks: Subscriptions and deliveries; from :meth:`start` on.
    """

    def __init__(self, opening: OpenSession, data: Path, settings: ServerSettings) -> None:
        self.settings = settings
        self.station = station = Station(opening, data, StationLimits(settings.kept_events, settings.open_jobs))
        self.keys: KeyStore
        self.authenticator: Authenticator
        self.audit: AuditLog
        job_events_logged(station.events)
        self.streams = Streams(station.events, settings.streams, lambda caller: self.authenticator.still(caller))
        self.metrics = Metrics(station.control, station.events)
        self.webhooks: WebhookStore
        self._sender: WebhookSender | None = None
        station.control.on_open(self._follow_jobs)
        self._stack = ExitStack()

    def start(self) -> None:
        """Opens the session and runs it.

        Raises:
            SkirosError: It cannot be opened.
        """
        station = self.station
        try:
            station.make_folder()
            self.keys, self.authenticator, self.audit = set_up_access(self.settings, station.data, self._stack)
            self._stack.enter_context(station)
            self.webhooks, self._sender = open_sender(station, self.settings.webhook_hosts, self._stack)
        except BaseException:
            self.close()
            raise

    def _follow_jobs(self, session: Session) -> None:
        session.jobs.subscribe(lambda _job: self.send_webhooks())

    def send_webhooks(self) -> None:
        """Wakes the sender of webhooks; quick, and for any thread."""
        if self._sender is not None:
            self._sender.wake()

    def close(self) -> None:
        """Stops everything and ends all that was started; may be called twice."""
        self._stack.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


async def _services(request: Request) -> Services:  # not in the thread pool: a stop must not wait for a place there
    services: Services = request.app.state.services
    return services


async def _station(request: Request) -> Station:
    services: Services = request.app.state.services
    return services.station


ServicesDep = Annotated[Services, Depends(_services)]
"""For routes: everything there is."""
StationDep = Annotated[Station, Depends(_station)]
"""For routes: the use cases."""
