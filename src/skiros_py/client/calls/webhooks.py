"""Webhooks: notifying other systems of jobs."""

from __future__ import annotations

from skiros_py.api.webhooks import Deliveries, DeliveryState, Webhook, WebhookChange, WebhookOrder, WebhookSecret
from skiros_py.client.request import Call, nothing, path_of


def list_webhooks() -> Call[list[Webhook]]:
    """Lists the webhooks."""
    return Call("GET", "/webhooks", list[Webhook])


def create_webhook(order: WebhookOrder) -> Call[WebhookSecret]:
    """Creates a webhook; its signing key is shown only this once."""
    return Call("POST", "/webhooks", WebhookSecret, json=order.model_dump(mode="json"), repeatable=False)


def get_webhook(webhook: str) -> Call[Webhook]:
    """Returns one webhook."""
    return Call("GET", path_of("webhooks", webhook), Webhook)


def change_webhook(webhook: str, change: WebhookChange) -> Call[Webhook]:
    """Changes a webhook's subscriptions, or disables it."""
    body = change.model_dump(mode="json", exclude_none=True)
    return Call("PATCH", path_of("webhooks", webhook), Webhook, json=body)


def delete_webhook(webhook: str) -> Call[None]:
    """Removes a webhook with its pending messages."""
    return Call("DELETE", path_of("webhooks", webhook), nothing)


def ping_webhook(webhook: str) -> Call[None]:
    """Sends a test message."""
    return Call("POST", path_of("webhooks", webhook, "ping"), nothing)


def list_deliveries(
    webhook: str, *, state: DeliveryState | None = None, limit: int = 100, cursor: str | None = None
) -> Call[Deliveries]:
    """Lists the messages of a webhook, newest first."""
    query = {"state": state, "limit": limit, "cursor": cursor}
    return Call("GET", path_of("webhooks", webhook, "deliveries"), Deliveries, query=query)


def list_dead_letters(*, limit: int = 100, cursor: str | None = None) -> Call[Deliveries]:
    """Lists the undeliverable messages."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/webhooks/dead-letters", Deliveries, query=query)


def redeliver(webhook: str, number: int) -> Call[None]:
    """Resends an undeliverable message."""
    return Call("POST", path_of("webhooks", webhook, "deliveries", number, "redeliver"), nothing)
