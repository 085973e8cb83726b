"""Webhooks on the wire: who wants to be told of jobs, and what became of what they were told."""

from __future__ import annotations

import enum
from typing import Annotated

from pydantic import AwareDatetime, Field

from skiros_py.api.wire import Answer, Request

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

    url: str = Field(
        max_length=2000,
        description="Where to: http or https, at a host that the server was told to allow (--webhook-host).",
        examples=["https://mes.example/skiros"],
    )
    states: tuple[str, ...] = Field(
        default=(),
        max_length=20,
        description="States of which to tell: NotAllowedToStart, AllowedToStart, Running, Interrupted, Ended, Aborted, "
        "Removed; empty for all.",
        examples=[["Ended", "Aborted"]],
    )
    jobs: Pattern = Field(default="", description="Tell only of jobs whose id begins so.", examples=["line-1-"])
    secret: str = Field(
        default="",
        max_length=200,
        description="Key of the signature (whsec_ and base64 of 24 to 64 bytes); empty to have one made.",
    )
    description: str = Field(default="", max_length=1000, description="For people.", examples=["the factory's MES"])


class WebhookChange(Request):
    """What shall be different."""

    active: bool | None = Field(default=None, description="False keeps what happens until it is active again.")
    states: tuple[str, ...] | None = Field(default=None, max_length=20, description="States of which to tell.")
    jobs: Pattern | None = Field(default=None, description="Tell only of jobs whose id begins so.")
    description: str | None = Field(default=None, max_length=1000, description="For people.", examples=["night shift"])


class Webhook(Answer):
    """Somebody who is told of jobs."""

    id: str = Field(description="Given by the server.", examples=["wh_5f0c"])
    url: str = Field(description="Where to.", examples=["https://mes.example/skiros"])
    states: tuple[str, ...] = Field(description="States of which to tell; empty for all.")
    jobs: str = Field(description="Tell only of jobs whose id begins so.")
    description: str = Field(description="For people.")
    active: bool = Field(description="False while what happens is kept, and not sent.")
    created: AwareDatetime = Field(description="Since when.")
    pending: int = Field(default=0, description="Deliveries that wait.")
    dead: int = Field(default=0, description="Dead letters.")


class WebhookSecret(Answer):
    """A new webhook, with the key of its signature, which is shown this once."""

    webhook: Webhook
    secret: str = Field(description="Check signatures with it (Standard Webhooks).")


class Delivery(Answer):
    """One message to one target."""

    webhook: str = Field(description="Id of the webhook.")
    number: int = Field(description="Counts the messages of this webhook; the receiver sees it as `sequence`.")
    event: str = Field(description="Id of the event: the same in every try; receivers drop what they have had.")
    job: str = Field(description="Id of the job; empty for a ping.")
    state: DeliveryState = Field(description="How far it is.")
    attempts: int = Field(description="How often it was tried.")
    created: AwareDatetime = Field(description="When it happened.")
    next_try: AwareDatetime | None = Field(default=None, description="When it is tried next.")
    status: int | None = Field(default=None, description="HTTP status of the last answer.")
    error: str = Field(default="", description="Why the last try failed.")


class Deliveries(Answer):
    """A page of deliveries, the latest first."""

    items: tuple[Delivery, ...]
    next: str | None = Field(default=None, description="Cursor of the next page.")
