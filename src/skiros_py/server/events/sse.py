"""The answer that does not end: server-sent events, as long as the client listens."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import AbstractContextManager

from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

_log = logging.getLogger(__name__)

_STALLED = 60.0
"""A client that has taken nothing for so long is disconnected, to make room for others [s]."""
_HEADERS = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
"""Proxies must not buffer events."""


class EventStream(StreamingResponse):
    """Sends what a generator yields. What the client does not take is neither made nor kept.

    Args:
        frames: The events, as server-sent events.
        place: Entered while it lasts: what counts the streams, and may refuse this one.
        stalled: After this time without taking anything a client is disconnected [s].
    """

    media_type = "text/event-stream"

    def __init__(
        self,
        frames: AsyncIterator[bytes],
        place: AbstractContextManager[None],
        *,
        stalled: float = _STALLED,
        status_code: int = 200,  # which the API's description is made from
    ) -> None:
        super().__init__(frames, status_code, headers=_HEADERS)
        self._place = place
        self._stalled = stalled

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers."""
        with self._place:
            try:
                await super().__call__(scope, receive, send)
            except TimeoutError:
                _log.warning("a client of %s takes no events for %g s: its stream ends", scope["path"], self._stalled)
                raise

    async def stream_response(self, send: Send) -> None:
        """Sends everything, but waits for the client only so long."""

        async def patiently(message: dict[str, object]) -> None:
            async with asyncio.timeout(self._stalled):
                await send(message)

        await super().stream_response(patiently)  # type: ignore[arg-type]
