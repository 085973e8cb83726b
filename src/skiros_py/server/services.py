"""The services that routes use: the station, access, streams, webhooks."""

from __future__ import annotations

import socket
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Self

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.messages import Message
from skiros_py.server.access.audit import AuditLog
from skiros_py.server.access.authenticator import Authenticator, check_access
from skiros_py.server.access.keys import KeyStore, open_access
from skiros_py.server.monitoring import Metrics, job_events_logged
from skiros_py.server.results import Results
from skiros_py.server.settings import ServerSettings
from skiros_py.server.streams import Streams
from skiros_py.server.webhooks.sender import WebhookSender
from skiros_py.server.webhooks.store import Post, WebhookStore
from skiros_py.station.control import OpenSession
from skiros_py.station.jobs.views import announced_job
from skiros_py.station.station import Station


class Services:
    """The services of one server. Use it in a ``with``.

    Args:
        opening: Opens the session.
        data: The data directory.
        settings: Settings of the server.

    Attributes:
        settings: Settings of the server.
        station: The use cases that routes call.
        keys: API keys, while it runs.
        authenticator: Identifies the caller of a request, while it runs.
        audit: The log of changes and refusals, while it runs.
        streams: The event streams.
        metrics: The metrics of the server.
        results: Awaits what other threads do.
        webhooks: Subscriptions and deliveries, while it runs.
    """

    def __init__(self, opening: OpenSession, data: Path, settings: ServerSettings) -> None:
        self.settings = settings
        self.station = station = Station(opening, data, events=settings.kept_events, open_jobs=settings.open_jobs)
        self.keys: KeyStore
        self.authenticator: Authenticator
        self.audit: AuditLog
        job_events_logged(station.events)
        self.streams = Streams(station.events, settings.streams, lambda caller: self.authenticator.recheck(caller))
        self.metrics = Metrics(station.control, station.events)
        self.results = Results()
        self.webhooks: WebhookStore
        self._sender: WebhookSender | None = None
        station.control.on_open(lambda session: session.jobs.subscribe(lambda _job: self.send_webhooks()))

    def __enter__(self) -> Self:
        """Opens the session and runs it.

        Raises:
            SkirosError: It cannot be opened.
        """
        station, data = self.station, self.station.data
        with ExitStack() as stack:
            station.make_folder()
            self.keys, self.authenticator, self.audit = set_up_access(self.settings, data, stack)
            stack.enter_context(station)
            origin = f"urn:skiros:{socket.gethostname()}:{data.name}"
            self.webhooks = stack.enter_context(closing(WebhookStore(data / "webhooks.db", origin)))
            sender = WebhookSender(
                self.webhooks,
                lambda: station.session,
                announced_job,
                self.settings.webhook_hosts,
                on_dead=self._on_dead,
            )
            self._sender = stack.enter_context(closing(sender))
            self._sender.start()
            station.unreadable += [self.keys.unreadable, self.audit.unreadable, self.webhooks.unreadable]
            self._close = stack.pop_all().close
        return self

    def send_webhooks(self) -> None:
        """Wakes the sender of webhooks; does not block; callable from any thread."""
        if self._sender is not None:
            self._sender.wake()

    def _on_dead(self, post: Post, why: str) -> None:
        text = Message(
            "{webhook} did not get {message} ({why}): see the dead letters of the webhooks",
            webhook=post.webhook,
            message=post.job or "ping",
            why=why,
        )
        alarms = self.station.alarms
        alarms.raise_(AlarmKind.WEBHOOK, text, post.webhook, severity=Severity.LOW, lasts=False, job=post.job)

    def __exit__(self, *_: object) -> None:
        """Stops everything and closes all services."""
        self._close()


def set_up_access(settings: ServerSettings, data: Path, stack: ExitStack) -> tuple[KeyStore, Authenticator, AuditLog]:
    """Opens the keys and the audit log of a data directory.

    Args:
        settings: Settings of the server.
        data: The data directory.
        stack: Closes them at the end.

    Raises:
        UsageError: Other machines can reach the server, and there is no key.
        FileError: The file cannot be opened or created, or is damaged.
    """
    keys = stack.enter_context(closing(KeyStore(data)))
    check_access(settings, keys)
    # A separate connection: a request that looks up its key never waits for writes.
    audit = AuditLog(open_access(data), besides=keys.save_last_used)
    stack.callback(audit.close)
    audit.start()
    return keys, Authenticator(settings, keys), audit
