"""Webhooks: signed notifications about jobs for other systems, in order for each job, at least once."""

from __future__ import annotations

import re
import secrets
import time
from base64 import b64decode
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Path, Query

from skiros_py.api import webhooks as api
from skiros_py.errors import UsageError
from skiros_py.server.access.roles import Admin
from skiros_py.server.problems import Problem, topic_router
from skiros_py.server.services import Services
from skiros_py.server.webhooks.sender import resolve, target_of
from skiros_py.server.webhooks.store import Subscription, new_secret

router = topic_router("webhooks", "/webhooks")

WebhookId = Annotated[str, Path(max_length=100, description="Id of the webhook.", examples=["wh_5f0c"])]
Number = Annotated[int, Path(ge=1, lt=2**53, description="Number of the delivery.")]
Limit = Annotated[int, Query(ge=1, le=1000)]
Cursor = Annotated[str | None, Query(max_length=120)]
_CURSOR = re.compile(r"\d{1,18}\.\w+", re.ASCII)


@router.get("")
def list_webhooks(act: Admin) -> api.Webhooks:
    """List webhooks.

    Lists the webhooks, with the number of pending deliveries.
    """
    return api.Webhooks(items=[_shown(act.services, one) for one in act.services.webhooks.subscriptions])


@router.post("", status_code=201)
def create_webhook(act: Admin, order: api.WebhookOrder) -> api.WebhookSecret:
    """Create a webhook.

    Creates a webhook, which receives events from now on; the key of its signatures is returned only in this response.
    """
    _check(order, act.services)
    given = order.model_copy(update={"secret": order.secret or new_secret()}).model_dump()
    subscription = Subscription(id=f"wh_{secrets.token_hex(6)}", active=True, created=datetime.now(UTC), **given)
    act.services.webhooks.add(subscription, act.services.station.session.jobs.store.last_announcement)
    act.locate("webhooks", subscription.id)
    return api.WebhookSecret(webhook=_shown(act.services, subscription), secret=subscription.secret)


@router.get("/dead-letters")
def list_dead_letters(act: Admin, limit: Limit = 100, cursor: Cursor = None) -> api.Deliveries:
    """List dead letters.

    Lists the messages that no target accepted for a day; ``POST …/redeliver`` sends one again.
    """
    return _page(act.services, None, api.DeliveryState.DEAD, cursor, limit)


@router.get("/{webhook}")
def get_webhook(act: Admin, webhook: WebhookId) -> api.Webhook:
    """Get a webhook.

    Returns a webhook without its key.
    """
    return _shown(act.services, act.services.webhooks.subscription(webhook))


@router.patch("/{webhook}")
def change_webhook(act: Admin, webhook: WebhookId, change: api.WebhookChange) -> api.Webhook:
    """Change a webhook.

    Changes the events that a webhook receives, or suspends it; events are kept for it meanwhile.
    """
    _check_states(change.states or ())
    changed = act.services.webhooks.change(webhook, **change.model_dump(exclude_none=True))
    act.services.send_webhooks()
    return _shown(act.services, changed)


@router.delete("/{webhook}", status_code=204)
def delete_webhook(act: Admin, webhook: WebhookId) -> None:
    """Delete a webhook.

    Deletes a webhook with its pending deliveries.
    """
    act.services.webhooks.remove(webhook)


@router.post("/{webhook}/ping", status_code=202)
def ping_webhook(act: Admin, webhook: WebhookId) -> None:
    """Test a webhook.

    Sends a message of type ``io.skiros.ping.v1``; the deliveries show whether it arrived.
    """
    act.services.webhooks.ping(webhook, time.time())
    act.services.send_webhooks()
    act.locate("webhooks", webhook, "deliveries")


@router.get("/{webhook}/deliveries")
def list_deliveries(
    act: Admin,
    webhook: WebhookId,
    state: api.DeliveryState | None = None,
    limit: Limit = 100,
    cursor: Cursor = None,
) -> api.Deliveries:
    """List deliveries.

    Lists the messages of a webhook, newest first; the last thousand delivered ones are kept.

    Parameters:
        state: Only deliveries in this state.
    """
    act.services.webhooks.subscription(webhook)
    return _page(act.services, webhook, state, cursor, limit)


@router.post("/{webhook}/deliveries/{number}/redeliver", status_code=202)
def redeliver(act: Admin, webhook: WebhookId, number: Number) -> None:
    """Redeliver a dead letter.

    Sends a message again that was given up.
    """
    act.services.webhooks.redeliver(webhook, number, time.time())
    act.services.send_webhooks()


def _check(order: api.WebhookOrder, services: Services) -> None:
    """Checks that an order can be fulfilled.

    Raises:
        UsageError: Its target, key or states are none.
    """
    resolve(target_of(order.url, services.settings.webhook_hosts))
    _check_states(order.states)
    if order.secret:
        try:
            key = b64decode(order.secret.removeprefix("whsec_"), validate=True)
        except ValueError:
            key = b""
        if not order.secret.startswith("whsec_") or not 24 <= len(key) <= 64:
            raise UsageError("secret: whsec_ and the base64 text of 24 to 64 bytes; leave it out to have one made")


def _check_states(states: tuple[str, ...]) -> None:
    unknown = sorted(set(states) - api.STATES)
    if unknown:
        raise UsageError(f"states: {', '.join(unknown)[:200]} is none of {', '.join(sorted(api.STATES))}")


def _shown(services: Services, one: Subscription) -> api.Webhook:
    counts = services.webhooks.counts()
    return api.Webhook.view_of(
        one,
        pending=counts.get((one.id, api.DeliveryState.PENDING.value), 0),
        dead=counts.get((one.id, api.DeliveryState.DEAD.value), 0),
    )


def _page(
    services: Services, webhook: str | None, state: api.DeliveryState | None, cursor: str | None, limit: int
) -> api.Deliveries:
    if cursor is not None and not _CURSOR.fullmatch(cursor):
        raise Problem(422, "InvalidRequest", "cursor: pass 'next' of the previous page unchanged")
    number, _, name = (cursor or "").partition(".")
    posts = services.webhooks.posts(
        webhook, None if state is None else state.value, (int(number), name) if cursor else None, limit + 1
    )
    last = posts[limit - 1] if len(posts) > limit else None
    return api.Deliveries(items=posts[:limit], next=f"{last.number}.{last.webhook}" if last else None)
