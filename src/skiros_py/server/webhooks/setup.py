"""Brings up what sends webhooks."""

from __future__ import annotations

import socket
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.server.webhooks.office import WebhookOffice
from skiros_py.server.webhooks.store import Post, WebhookStore
from skiros_py.station.jobs.views import job_view
from skiros_py.tasks.jobs.announcements import Announcement

if TYPE_CHECKING:
    from skiros_py.server.services import Services

__all__ = ["open_office"]


def open_office(services: Services, stack: ExitStack) -> tuple[WebhookStore, WebhookOffice]:
    """Opens the file of webhooks and begins to send.

    Args:
        services: Whose jobs are told of.
        stack: Ends it.
    """
    source = f"urn:skiros:{socket.gethostname()}:{services.data.name}"
    store = stack.enter_context(closing(WebhookStore(services.data / "webhooks.db", source)))

    def on_dead(post: Post, why: str) -> None:
        text = f"{post.webhook} was not told of {post.job or 'a ping'} ({why}): see the dead letters of the webhooks"
        services.alarms.raise_(AlarmKind.WEBHOOK, text, post.webhook, severity=Severity.LOW, lasts=False, job=post.job)

    office = WebhookOffice(
        store,
        lambda after, most: services.session.jobs.announcements(after, most),
        lambda: services.session.jobs.last_announcement,
        lambda upto: services.session.jobs.forget_announcements(upto),
        _data,
        services.settings.webhook_hosts,
        on_dead=on_dead,
    )
    stack.enter_context(closing(office))
    office.start()
    return store, office


def _data(announcement: Announcement) -> Any:
    job = job_view(announcement.job, announcement.wall)
    return {"trigger": announcement.trigger, "job": job.model_dump(mode="json", by_alias=True)}
