"""The store of subscriptions and of signed deliveries (CloudEvents 1.0, Standard Webhooks); it survives restarts."""

from __future__ import annotations

import secrets
import sqlite3
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cloudevents.core.formats.json import JSONFormat
from cloudevents.core.v1.event import CloudEvent
from pydantic import Field
from standardwebhooks import Webhook as Signer

from skiros_py.api.webhooks import Delivery, DeliveryState, Webhook
from skiros_py.database import COUNTED, Database, Schema
from skiros_py.errors import Busy
from skiros_py.messages import Message
from skiros_py.station.jobs.views import Announcement, state_name
from skiros_py.station.requests import find

JOB_STATE = "io.skiros.job.state.v1"
PING = "io.skiros.ping.v1"
MEDIA_TYPE = "application/cloudevents+json"


def payload(event: str, type_: str, source: str, *, subject: str, sequence: int, wall: float, data: Any) -> str:
    """Returns the text of a message.

    Args:
        event: Its id, the same in every attempt.
        type_: Type of the message.
        source: The sender.
        subject: Id of the job.
        sequence: Number of the message among those of its webhook.
        wall: Time of the event [s since 1970].
        data: The event, as plain data.
    """
    attributes = {
        "id": event,
        "source": source,
        "type": type_,
        "specversion": "1.0",
        "time": datetime.fromtimestamp(wall, UTC),
        "datacontenttype": "application/json",
        "sequence": f"{sequence:020}",  # compared as text
        **({"subject": subject} if subject else {}),
    }
    written: bytes = JSONFormat().write(CloudEvent(attributes=attributes, data=data))
    return written.decode()


def signed(secret: str, event: str, body: str, now: float) -> Mapping[str, str]:
    """Returns the headers that prove the sender and the time of a message.

    Args:
        secret: The key shared by sender and receiver.
        event: Id of the message.
        body: The message.
        now: Time of this attempt [s since 1970].
    """
    signature = Signer(secret).sign(event, datetime.fromtimestamp(now, UTC), body)
    return {
        "Content-Type": MEDIA_TYPE,
        "webhook-id": event,
        "webhook-timestamp": str(int(now)),
        "webhook-signature": signature,
    }


_TABLES = """
CREATE TABLE subscriptions (id TEXT PRIMARY KEY, data TEXT NOT NULL, seen INTEGER NOT NULL, last INTEGER NOT NULL)
    WITHOUT ROWID;
CREATE TABLE deliveries (
    webhook TEXT NOT NULL, number INTEGER NOT NULL, job TEXT NOT NULL, event TEXT NOT NULL, wall REAL NOT NULL,
    body TEXT NOT NULL, state TEXT NOT NULL, attempts INTEGER NOT NULL, next_try REAL NOT NULL, status INTEGER,
    error TEXT NOT NULL, since REAL NOT NULL, head INTEGER NOT NULL, PRIMARY KEY (webhook, number)
) WITHOUT ROWID;
CREATE INDEX pending_by_job ON deliveries (webhook, job, number) WHERE state = 'pending';
CREATE INDEX heads ON deliveries (webhook, next_try, number) WHERE head = 1;
CREATE INDEX by_state ON deliveries (state, webhook, number);
"""

_SCHEMA = Schema(Message("the webhooks of a server"), 0x736B7768, (_TABLES, COUNTED))
"""Application id of such a file: "skwh"."""

_MOST = 50
_KEPT = 1000
"""Number of finished deliveries kept per webhook."""
_LETTERBOX = 100_000
"""Maximum number of waiting deliveries per webhook; beyond it the oldest become dead letters."""
_COLUMNS = "webhook, number, job, event, wall, body, state, attempts, next_try, status, error, since"
_SELECT = f"SELECT 'message ' || number || ' to webhook ' || webhook, {_COLUMNS} FROM deliveries"  # noqa: S608 - our own names
_HEAD = """UPDATE deliveries SET head = 1 WHERE webhook = :webhook AND number =
    (SELECT min(number) FROM deliveries WHERE webhook = :webhook AND job = :job AND state = 'pending')"""
"""Makes the oldest waiting message of a job the head of its queue, which is sent next."""


class Subscription(Webhook):
    """A webhook with the key of its signatures, which is never shown."""

    secret: str = Field(repr=False)
    """The key."""

    def wants(self, state: str, job: str) -> bool:
        """Returns whether a new state of a job is sent to the target."""
        return job.startswith(self.jobs) and (not self.states or state in self.states)


class Post(Delivery):
    """One message to one target, with what is sent."""

    body: str
    """The message."""
    since: float
    """Start of the attempts: the time of the event or of a request to redeliver [s since 1970]."""


class WebhookStore:
    """The file with subscriptions and deliveries; thread-safe. Close it.

    Args:
        path: The file; created if missing.
        source: The sender as named in messages: the address of this server.

    Raises:
        FileError: It cannot be opened or created, or is damaged.

    Attributes:
        unreadable: The records that were left out because they cannot be read, by name.
    """

    def __init__(self, path: Path, source: str) -> None:
        self._database = Database(path, _SCHEMA, durable=True)
        self.unreadable = self._database.unreadable
        self._source = source

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._database.close()

    # ------------------------------------------------------------------ subscriptions

    @property
    def subscriptions(self) -> tuple[Subscription, ...]:
        """Returns all subscriptions that can be read, by id."""
        rows = self._database.rows("SELECT 'webhook ' || id, data FROM subscriptions ORDER BY id")
        return tuple(self._database.readable(rows, Subscription.model_validate_json))

    def subscription(self, webhook: str) -> Subscription:
        """Returns a subscription.

        Raises:
            UnknownName: There is none with this id.
        """
        return find("webhook", webhook, {one.id: one for one in self.subscriptions}, "UnknownWebhook")

    def add(self, subscription: Subscription, seen: int) -> None:
        """Adds a subscription.

        Args:
            subscription: The subscription.
            seen: Number of the last announcement that is not sent to it.

        Raises:
            Busy: There are too many.
        """
        if len(self.subscriptions) >= _MOST:
            raise Busy(f"there are {_MOST} webhooks, which are the most: remove one first", retry_after=3600.0)
        with self._database.transaction(f"webhook {subscription.id}, added") as connection:
            connection.execute(
                "INSERT INTO subscriptions VALUES (?, ?, ?, 0)", (subscription.id, _data(subscription), seen)
            )

    def change(self, webhook: str, **changes: Any) -> Subscription:
        """Changes a subscription.

        Raises:
            UnknownName: There is none with this id.
        """
        with self._database.transaction(f"webhook {webhook}, changed") as connection:
            changed = self.subscription(webhook).model_copy(update=changes)
            connection.execute("UPDATE subscriptions SET data = ? WHERE id = ?", (_data(changed), webhook))
        return changed

    def remove(self, webhook: str) -> None:
        """Deletes a subscription with all its deliveries.

        Raises:
            UnknownName: There is none with this id.
        """
        with self._database.transaction(f"webhook {webhook}, removed") as connection:
            removed = connection.execute("DELETE FROM subscriptions WHERE id = ? RETURNING id", (webhook,)).fetchall()
            if not removed:  # one that cannot be read is removed like others
                self.subscription(webhook)
            connection.execute("DELETE FROM deliveries WHERE webhook = ?", (webhook,))

    # ------------------------------------------------------------------ messages to send

    @property
    def seen(self) -> int | None:
        """Number of the last announcement that all subscriptions have received; None if there is no subscription."""
        ((seen,),) = self._database.rows("SELECT min(seen) FROM subscriptions")
        return None if seen is None else int(seen)

    def take(self, announcements: Sequence[Announcement], tell: Callable[[Announcement], Any]) -> None:
        """Creates the deliveries of announcements that each subscription has not received yet, in one transaction.

        Args:
            announcements: In order.
            tell: Returns the data of a message.
        """
        with self._database.transaction(f"messages about {len(announcements)} announcements") as connection:
            readable = {one.id: one for one in self.subscriptions}
            for id_, seen, last in connection.execute("SELECT id, seen, last FROM subscriptions").fetchall():
                subscription, number = readable.get(id_), int(last)
                for one in announcements:
                    if subscription and one.number > seen and subscription.wants(state_of(one), one.job.id):
                        number += 1
                        text = payload(
                            event := f"{subscription.id}-{one.number}",
                            JOB_STATE,
                            self._source,
                            subject=one.job.id,
                            sequence=number,
                            wall=one.wall,
                            data=tell(one),
                        )
                        _insert(connection, (subscription.id, number, one.job.id, event, one.wall, text))
                connection.execute(
                    "UPDATE subscriptions SET seen = max(seen, ?), last = ? WHERE id = ?",
                    (announcements[-1].number, number, id_),
                )

    def ping(self, webhook: str, now: float) -> int:
        """Queues a test message; returns its number.

        Raises:
            NotFound: There is no such webhook.
        """
        self.subscription(webhook)
        with self._database.transaction(f"webhook {webhook}: a ping") as connection:
            ((number,),) = connection.execute(
                "UPDATE subscriptions SET last = last + 1 WHERE id = ? RETURNING last", (webhook,)
            ).fetchall()
            event = f"{webhook}-ping-{number}"
            text = payload(event, PING, self._source, subject="", sequence=number, wall=now, data={"ping": webhook})
            _insert(connection, (webhook, number, "", event, now, text))
        return int(number)

    def due(self, webhook: str, now: float, most: int) -> tuple[Post, ...]:
        """Returns the messages due, of each job only the oldest waiting one; the most overdue first.

        Args:
            webhook: Id of the webhook.
            now: Wall time [s since 1970].
            most: Maximum number of messages.
        """
        rows = self._database.rows(
            f"{_SELECT} WHERE webhook = ? AND head = 1 AND next_try <= ? ORDER BY next_try, number LIMIT ?",
            (webhook, now, most),
        )
        return tuple(self._database.readable(rows, _post))

    def next_due(self, webhook: str, now: float) -> float | None:
        """Returns when the next message will be due [s since 1970]; None if none waits."""
        sql = "SELECT min(next_try) FROM deliveries WHERE webhook = ? AND head = 1 AND next_try > ?"
        ((when,),) = self._database.rows(sql, (webhook, now))
        return None if when is None else float(when)

    def settle(
        self, post: Post, state: DeliveryState, *, next_try: float = 0.0, status: int | None = None, error: str = ""
    ) -> None:
        """Stores the result of an attempt."""
        with self._database.transaction(
            f"webhook {post.webhook}: message {post.number} is {state.value}"
        ) as connection:
            connection.execute(
                "UPDATE deliveries SET state = ?, attempts = attempts + 1, next_try = ?, status = ?, error = ?"
                " WHERE webhook = ? AND number = ?",
                (state.value, next_try, status, error[:_LONGEST], post.webhook, post.number),
            )
            if state is not DeliveryState.PENDING:
                _pass_on(connection, post.webhook, post.number, post.job)
            if state is DeliveryState.DONE:
                connection.execute(
                    "DELETE FROM deliveries WHERE webhook = ? AND state = 'done' AND number < ?",
                    (post.webhook, post.number - _KEPT),
                )

    def drop_oldest(self) -> int:
        """Makes the oldest messages beyond the limit dead letters; returns their number."""
        with self._database.transaction("messages beyond the limit") as connection:
            dropped = connection.execute(
                "UPDATE deliveries SET state = 'dead', error = 'too many were waiting'"
                " WHERE state = 'pending' AND number <= (SELECT last FROM subscriptions WHERE id = webhook) - ?"
                " RETURNING webhook, number, job",
                (_LETTERBOX,),
            ).fetchall()
            for webhook, number, job in dropped:
                _pass_on(connection, webhook, number, job)
        return len(dropped)

    def redeliver(self, webhook: str, number: int, now: float) -> None:
        """Sends a dead letter again, immediately; older waiting messages of the same job are sent first.

        Args:
            webhook: Id of the subscription.
            number: Number of the message.
            now: Wall time, from which it is attempted for another day [s since 1970].

        Raises:
            NotFound: There is no such dead letter.
        """
        self.subscription(webhook)
        with self._database.transaction(f"webhook {webhook}: message {number} is sent again") as connection:
            changed = connection.execute(
                "UPDATE deliveries SET state = 'pending', next_try = 0, attempts = 0, since = ?, error = ''"
                " WHERE webhook = ? AND number = ? AND state = 'dead' RETURNING job",
                (now, webhook, number),
            ).fetchall()
            for (job,) in changed:
                connection.execute(
                    "UPDATE deliveries SET head = 0 WHERE webhook = ? AND job = ? AND state = 'pending'", (webhook, job)
                )
                connection.execute(_HEAD, {"webhook": webhook, "job": job})
        if not changed:
            dead = {str(post.number): post for post in self.posts(webhook, "dead", None, 100)}
            find("dead letter", str(number), dead, "UnknownDeadLetter")

    # ------------------------------------------------------------------ queries

    def posts(
        self, webhook: str | None, state: str | None, before: tuple[int, str] | None, most: int
    ) -> tuple[Post, ...]:
        """Returns the deliveries that can be read, latest first.

        Args:
            webhook: Id of the webhook; None for all.
            state: State of the deliveries; None for any.
            before: Number and webhook of a delivery: return only those listed after it; None for the first ones.
            most: Maximum number of messages.
        """
        wanted = (
            ("webhook = ?", webhook and (webhook,)),
            ("state = ?", state and (state,)),
            ("(number, webhook) < (?, ?)", before),
        )
        given = [(text, values) for text, values in wanted if values]
        where = f"WHERE {' AND '.join(text for text, _ in given)}" if given else ""
        rows = self._database.rows(
            f"{_SELECT} {where} ORDER BY number DESC, webhook DESC LIMIT ?",
            (*(value for _, values in given for value in values), most),
        )
        found = tuple(self._database.readable(rows, _post))
        if len(found) < len(rows) == most:  # further ones in the place of those that cannot be read
            _, last, number, *_ = rows[-1]
            found += self.posts(webhook, state, (number, last), most - len(found))
        return found

    def counts(self) -> dict[tuple[str, str], int]:
        """Returns the number of deliveries by webhook and state."""
        rows = self._database.rows("SELECT webhook, state, count(*) FROM deliveries GROUP BY state, webhook")
        return {(webhook, state): number for webhook, state, number in rows}


_LONGEST = 1000


def _insert(connection: sqlite3.Connection, row: tuple[str, int, str, str, float, str]) -> None:
    """Adds a message at the end of its job's queue."""
    webhook, _, job, _, wall, _ = row
    sql = "SELECT 1 FROM deliveries WHERE webhook = ? AND job = ? AND state = 'pending' LIMIT 1"
    first = not connection.execute(sql, (webhook, job)).fetchall()
    values = (*row, wall, int(first))
    connection.execute("INSERT INTO deliveries VALUES (?, ?, ?, ?, ?, ?, 'pending', 0, 0, NULL, '', ?, ?)", values)


def _pass_on(connection: sqlite3.Connection, webhook: str, number: int, job: str) -> None:
    """Makes the next message of a job the head of its queue."""
    connection.execute("UPDATE deliveries SET head = 0 WHERE webhook = ? AND number = ?", (webhook, number))
    connection.execute(_HEAD, {"webhook": webhook, "job": job})


def state_of(announcement: Announcement) -> str:
    """Returns the new state of a job, as named in webhooks."""
    if announcement.trigger in ("cancelled", "cleared"):
        return "Removed"
    return state_name(announcement.job.state).value


def new_secret() -> str:
    """Creates the key of a webhook's signatures."""
    return f"whsec_{b64encode(secrets.token_bytes(32)).decode()}"


def _data(subscription: Subscription) -> str:
    return subscription.model_dump_json(exclude={"pending", "dead"})


def _post(*row: Any) -> Post:
    post = dict(zip(_COLUMNS.split(", "), row, strict=True))
    waits = post["state"] == DeliveryState.PENDING and post["next_try"] > 0
    return Post(**{**post, "created": post["wall"], "next_try": post["next_try"] if waits else None})
