"""The client of asynchronous programs."""

from __future__ import annotations

from collections.abc import AsyncIterator
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx2

from skiros_py.client.any_client import AnyClient
from skiros_py.client.call import AsyncSender, Call
from skiros_py.client.request import Outcome, arguments_of, result_of
from skiros_py.client.streams import Stream, follow_later

T = TypeVar("T")


class AsyncClient(AnyClient[AsyncSender]):
    """Communicates with one server like :class:`~skiros_py.client.client.Client`, with ``await``.

    Args:
        url: Address of the server.
        key: Key, as ``skiros key create`` printed it; None if the server needs none.
        timeout: How long an answer may take [s].
        tries: How often a request is sent at most.

    Attributes:
        url: Address of the server.
        http: The HTTP client; its base URL is that of the API.

    Raises:
        UsageError: The URL or the key is malformed.
    """

    http: httpx2.AsyncClient
    _http = httpx2.AsyncClient

    async def send(self, call: Call[T]) -> T:
        """Sends a call, with retries if needed, and returns its result.

        Raises:
            ProblemError: The server refused.
            Unreachable: The server does not answer.
        """
        request = arguments_of(call)
        async for attempt in self._patience.attempts(call):
            with attempt:
                return result_of(call, await self._try(request), self.url)
        raise AssertionError("the last try returns or raises")

    async def _try(self, request: dict[str, Any]) -> Outcome:
        try:
            return await self.http.request(**request)
        except httpx2.TransportError as error:
            return error

    def follow(self, stream: Stream[T], *, after: str | None = None, patience: float = 60.0) -> AsyncIterator[T]:
        """Yields events for ``async for``; see :meth:`skiros_py.client.client.Client.follow`."""
        return follow_later(self.http, stream, after=after, patience=patience)

    async def close(self) -> None:
        """Closes all connections; may be called twice."""
        await self.http.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()
