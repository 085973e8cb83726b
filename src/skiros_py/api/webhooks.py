"""Webhooks on the wire: who is notified of jobs, and what became of the notifications."""

from __future__ import annotations

import enum
from typing import Annotated

from pydantic import AwareDatetime, Field, StrictBool

from skiros_py.api.wire import Answer, Page, Request

STATES = frozenset({"NotAllowedToStart", "AllowedToStart", "Running", "Interrupted", "Ended", "Aborted", "Removed"})
"""States of jobs that webhooks report: those of ISA-95, and Removed."""

Pattern = Annotated[str, Field(max_length=200)]


class DeliveryState(enum.StrEnum):
    """State of a delivery."""

    PENDING = "pending"
    """It waits for its turn, or for a retry."""
    DONE = "done"
    """The target accepted it."""
    DEAD = "dead"
    """All retries failed; it can be sent again on request."""


class WebhookOrder(Request):
    """An order for a webhook."""

    url: str = Field(max_length=2000, examples=["https://mes.example/skiros"])
    """Target URL: http or https, at a host permitted by --webhook-host."""
    states: tuple[str, ...] = Field(default=(), max_length=20, examples=[["Ended", "Aborted"]])
    """States to report: NotAllowedToStart, AllowedToStart, Running, Interrupted, Ended, Aborted, Removed; empty for
    all.
    """
    jobs: Pattern = Field(default="", examples=["line-1-"])
    """Prefix of the ids of reported jobs."""
    secret: str = Field(default="", max_length=200)
    """Key of the signature (whsec_ and base64 of 24 to 64 bytes); generated if empty."""
    description: str = Field(default="", max_length=1000, examples=["the factory's MES"])
    """Description, for people."""


class WebhookChange(Request):
    """Changes of a webhook."""

    active: StrictBool | None = None
    """False suspends deliveries; events are stored until it is active again."""
    states: tuple[str, ...] | None = Field(default=None, max_length=20)
    """States to report."""
    jobs: Pattern | None = None
    """Prefix of the ids of reported jobs."""
    description: str | None = Field(default=None, max_length=1000, examples=["night shift"])
    """Description, for people."""


class Webhook(Answer):
    """A webhook."""

    id: str = Field(examples=["wh_5f0c"])
    """Its id."""
    url: str = Field(examples=["https://mes.example/skiros"])
    """Target URL."""
    states: tuple[str, ...]
    """States to report; empty for all."""
    jobs: str
    """Prefix of the ids of reported jobs."""
    description: str
    """Description, for people."""
    active: bool
    """False while deliveries are suspended."""
    created: AwareDatetime
    """When it was created."""
    pending: int = 0
    """Number of pending deliveries."""
    dead: int = 0
    """Number of dead letters."""


Webhooks = Page[Webhook]
"""The webhooks."""


class WebhookSecret(Answer):
    """A new webhook with the key of its signatures, which is returned only once."""

    webhook: Webhook
    secret: str
    """Key for checking signatures (Standard Webhooks)."""


class Delivery(Answer):
    """One message to one target."""

    webhook: str
    """Id of the webhook."""
    number: int
    """Number of the message of this webhook; `sequence` for the receiver."""
    event: str
    """Id of the event, the same in every retry: receivers ignore duplicates."""
    job: str
    """Id of the job; empty for a ping."""
    state: DeliveryState
    """Its state."""
    attempts: int
    """Number of attempts."""
    created: AwareDatetime
    """When it happened."""
    next_try: AwareDatetime | None = None
    """Time of the next attempt."""
    status: int | None = None
    """HTTP status of the last response."""
    error: str = ""
    """Why the last attempt failed."""


Deliveries = Page[Delivery]
"""A page of deliveries, newest first."""
