"""The server: keys, the caller's session, the audit log, past events, and webhooks."""

# mypy: disable-error-code="empty-body"
# An operation is declared by its signature alone.

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api import webhooks
from skiros_py.api.events import EventKind, EventPage
from skiros_py.api.server import ApiKey, ApiKeys, AuditPage, Backup, DataFindings, KeyOrder, Me, NewKey
from skiros_py.api.view import StationState
from skiros_py.client.operation import C, Topic, operation


class Audit(Topic[C]):
    """The audit log: changes and refused requests."""

    @operation("GET /audit")
    def list(self, limit: int = 100, cursor: str | None = None) -> AuditPage:
        """Lists requests that changed something or were refused, newest first."""

    @operation("GET /audit/export")
    def export(self) -> str:
        """Returns all records as JSON Lines, oldest first; each holds the SHA-256 of the line before."""


class Data(Topic[C]):
    """The data directory of the server."""

    @operation("GET /data/findings")
    def check(self) -> DataFindings:
        """Reads every file, and returns what is wrong."""

    @operation("POST /data/backups", once=True)
    def back_up(self, name: str) -> Backup:
        """Copies the data directory into its folder ``backups``."""


class Events(Topic[C]):
    """Past events, in pages; the client's :meth:`follow` streams new ones."""

    @operation("GET /events/recent", kinds="kind", types="type")
    def list(
        self,
        *,
        kinds: Sequence[EventKind] = (),
        types: Sequence[str] = (),
        job: str = "",
        element: str = "",
        after: str | None = None,
        limit: int = 100,
    ) -> EventPage:
        """Lists the events after a given one, oldest first; the page gives the cursor for the next."""

    @operation("GET /state")
    def state(self) -> StationState:
        """Returns the current state of all robots."""


class Keys(Topic[C]):
    """API keys."""

    @operation("GET /keys")
    def list(self) -> ApiKeys:
        """Lists the keys, revoked ones too."""

    @operation("POST /keys", once=True)
    def create(self, order: KeyOrder) -> NewKey:
        """Creates a key; its secret is shown only this once."""

    @operation("GET /keys/{key}")
    def get(self, key: str) -> ApiKey:
        """Returns a key by its id."""

    @operation("DELETE /keys/{key}")
    def revoke(self, key: str) -> ApiKey:
        """Revokes a key by its id."""


class Session(Topic[C]):
    """The caller's own session."""

    @operation("GET /session")
    def get(self) -> Me:
        """Returns who the caller is and what they may do."""

    @operation("POST /session")
    def login(self, key: str) -> Me:
        """Starts a login session, as web pages do; not needed by programs, which send their key with each request."""

    @operation("DELETE /session")
    def logout(self) -> None:
        """Ends the session."""


class Webhooks(Topic[C]):
    """Job notifications to other systems."""

    @operation("GET /webhooks")
    def list(self) -> webhooks.Webhooks:
        """Lists the webhooks."""

    @operation("POST /webhooks", once=True)
    def create(self, order: webhooks.WebhookOrder) -> webhooks.WebhookSecret:
        """Creates a webhook; its signing key is shown only this once."""

    @operation("GET /webhooks/{webhook}")
    def get(self, webhook: str) -> webhooks.Webhook:
        """Returns one webhook."""

    @operation("PATCH /webhooks/{webhook}")
    def change(self, webhook: str, change: webhooks.WebhookChange) -> webhooks.Webhook:
        """Changes a webhook's subscriptions, or disables it."""

    @operation("DELETE /webhooks/{webhook}")
    def delete(self, webhook: str) -> None:
        """Removes a webhook with its pending messages."""

    @operation("POST /webhooks/{webhook}/ping")
    def ping(self, webhook: str) -> None:
        """Sends a test message."""

    @operation("GET /webhooks/{webhook}/deliveries")
    def deliveries(
        self, webhook: str, *, state: webhooks.DeliveryState | None = None, limit: int = 100, cursor: str | None = None
    ) -> webhooks.Deliveries:
        """Lists the messages of a webhook, newest first."""

    @operation("GET /webhooks/dead-letters")
    def dead_letters(self, *, limit: int = 100, cursor: str | None = None) -> webhooks.Deliveries:
        """Lists the undeliverable messages."""

    @operation("POST /webhooks/{webhook}/deliveries/{number}/redeliver")
    def redeliver(self, webhook: str, number: int) -> None:
        """Resends an undeliverable message."""
