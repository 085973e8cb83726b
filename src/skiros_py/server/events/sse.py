"""An endless answer: server-sent events for as long as the client listens."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import AbstractContextManager

from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

_log = logging.getLogger(__name__)

_STALLED = 60.0
"""A client that has received nothing for this time is disconnected, to make room for others [s]."""
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
"""Proxies must not buffer events."""


class EventStream(StreamingResponse):
    """Sends the events of a generator at the pace of the client: pending events are neither made nor buffered.

    Args:
        frames: The events, as server-sent events.
        place: Context manager entered while the stream lasts; counts the streams, and may refuse this one.
        stalled: A client that has received nothing for this time is disconnected [s].
    """

    media_type = "text/event-stream"

    def __init__(
        self,
        frames: AsyncIterator[bytes],
        place: AbstractContextManager[None],
        *,
        stalled: float = _STALLED,
        status_code: int = 200,  # required by the OpenAPI description
    ) -> None:
        super().__init__(frames, status_code, headers=_HEADERS)
        self._place = place
        self._stalled = stalled

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers the request."""
        with self._place:
            try:
                await super().__call__(scope, receive, send)
            except TimeoutError:
                _log.warning("a client of %s takes no events for %g s: its stream ends", scope["path"], self._stalled)
                raise

    async def stream_response(self, send: Send) -> None:
        """Sends everything, but limits the time spent waiting for the client."""

        async def patiently(message: dict[str, object]) -> None:
            async with asyncio.timeout(self._stalled):
                await send(message)

        await super().stream_response(patiently)  # type: ignore[arg-type]
