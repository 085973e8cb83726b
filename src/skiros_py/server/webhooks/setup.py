"""Opens the sender of webhooks."""

from __future__ import annotations

import socket
from collections.abc import Sequence
from contextlib import ExitStack, closing

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.server.webhooks.sender import WebhookSender
from skiros_py.server.webhooks.store import Post, WebhookStore
from skiros_py.station.jobs.views import announced_job
from skiros_py.station.station import Station


def open_sender(station: Station, hosts: Sequence[str], stack: ExitStack) -> tuple[WebhookStore, WebhookSender]:
    """Opens the file of webhooks and begins to send.

    Args:
        station: The station whose jobs are announced.
        hosts: Hosts that webhooks may be sent to.
        stack: Closes them.
    """
    origin = f"urn:skiros:{socket.gethostname()}:{station.data.name}"
    store = stack.enter_context(closing(WebhookStore(station.data / "webhooks.db", origin)))

    def on_dead(post: Post, why: str) -> None:
        text = f"{post.webhook} was not told of {post.job or 'a ping'} ({why}): see the dead letters of the webhooks"
        station.alarm_book.raise_(
            AlarmKind.WEBHOOK, text, post.webhook, severity=Severity.LOW, lasts=False, job=post.job
        )

    sender = WebhookSender(
        store,
        lambda after, most: station.session.jobs.announcements(after, most),
        lambda: station.session.jobs.last_announcement,
        lambda upto: station.session.jobs.forget_announcements(upto),
        announced_job,
        hosts,
        on_dead=on_dead,
    )
    stack.enter_context(closing(sender))
    sender.start()
    return store, sender
