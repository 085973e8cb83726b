"""The messages: CloudEvents (1.0, structured JSON), signed according to Standard Webhooks."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from cloudevents.core.formats.json import JSONFormat
from cloudevents.core.v1.event import CloudEvent
from standardwebhooks import Webhook as Signer

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
