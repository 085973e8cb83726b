"""Webhooks on the wire: who wants to be told of jobs, and what became of what they were told."""

from __future__ import annotations

import enum
from typing import Annotated

from pydantic import AwareDatetime, Field

from skiros_py.api.wire import Answer, Page, Request

STATES = frozenset({"NotAllowedToStart", "AllowedToStart", "Running", "Interrupted", "Ended", "Aborted", "Removed"})
"""States of a job of which a webhook may be told: those of ISA-95, and that it is there no more."""

Pattern = Annotated[str, Field(max_length=200)]


class DeliveryState(enum.StrEnum):
    """How far a delivery is."""

    PENDING = "pending"
    """It waits for its turn, or for another try."""
    DONE = "done"
    """The target took it."""
    DEAD = "dead"
    """It was tried for as long as is sensible; somebody may have it sent again."""


class WebhookOrder(Request):
    """A wish to be told of jobs."""

    url: str = Field(max_length=2000, examples=["https://mes.example/skiros"])
    """Where to: http or https, at a host that the server was told to allow (--webhook-host)."""
    states: tuple[str, ...] = Field(default=(), max_length=20, examples=[["Ended", "Aborted"]])
    """States of which to tell: NotAllowedToStart, AllowedToStart, Running, Interrupted, Ended, Aborted, Removed; empty
    for all.
    """
    jobs: Pattern = Field(default="", examples=["line-1-"])
    """Tell only of jobs whose id begins so."""
    secret: str = Field(default="", max_length=200)
    """Key of the signature (whsec_ and base64 of 24 to 64 bytes); empty to have one made."""
    description: str = Field(default="", max_length=1000, examples=["the factory's MES"])
    """For people."""


class WebhookChange(Request):
    """What shall be different."""

    active: bool | None = None
    """False keeps what happens until it is active again."""
    states: tuple[str, ...] | None = Field(default=None, max_length=20)
    """States of which to tell."""
    jobs: Pattern | None = None
    """Tell only of jobs whose id begins so."""
    description: str | None = Field(default=None, max_length=1000, examples=["night shift"])
    """For people."""


class Webhook(Answer):
    """Somebody who is told of jobs."""

    id: str = Field(examples=["wh_5f0c"])
    """Given by the server."""
    url: str = Field(examples=["https://mes.example/skiros"])
    """Where to."""
    states: tuple[str, ...]
    """States of which to tell; empty for all."""
    jobs: str
    """Tell only of jobs whose id begins so."""
    description: str
    """For people."""
    active: bool
    """False while what happens is kept, and not sent."""
    created: AwareDatetime
    """Since when."""
    pending: int = 0
    """Deliveries that wait."""
    dead: int = 0
    """Dead letters."""


class WebhookSecret(Answer):
    """A new webhook, with the key of its signature, which is shown this once."""

    webhook: Webhook
    secret: str
    """Check signatures with it (Standard Webhooks)."""


class Delivery(Answer):
    """One message to one target."""

    webhook: str
    """Id of the webhook."""
    number: int
    """Counts the messages of this webhook; the receiver sees it as `sequence`."""
    event: str
    """Id of the event: the same in every try; receivers drop what they have had."""
    job: str
    """Id of the job; empty for a ping."""
    state: DeliveryState
    """How far it is."""
    attempts: int
    """How often it was tried."""
    created: AwareDatetime
    """When it happened."""
    next_try: AwareDatetime | None = None
    """When it is tried next."""
    status: int | None = None
    """HTTP status of the last answer."""
    error: str = ""
    """Why the last try failed."""


Deliveries = Page[Delivery]
"""A page of deliveries, the latest first."""
