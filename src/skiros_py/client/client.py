"""The client of blocking programs."""

from __future__ import annotations

from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx2

from skiros_py.client.any_client import AnyClient
from skiros_py.client.call import Call, Sender
from skiros_py.client.request import Outcome, arguments_of, result_of
from skiros_py.client.streams import Stream, follow

T = TypeVar("T")


class Client(AnyClient[Sender]):
    """Communicates with one server. Close it, or use it in a ``with`` statement; thread-safe.

    Failed requests are retried if that is safe; job orders are retried, too, and still executed only once.

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

    http: httpx2.Client
    _http = httpx2.Client

    def send(self, call: Call[T]) -> T:
        """Sends a call, with retries if needed, and returns its result.

        Raises:
            ProblemError: The server refused.
            Unreachable: The server does not answer.
        """
        request = arguments_of(call)
        for attempt in self._patience.attempts(call):
            with attempt:
                return result_of(call, self._try(request), self.url)
        raise AssertionError("the last try returns or raises")

    def _try(self, request: dict[str, Any]) -> Outcome:
        try:
            return self.http.request(**request)
        except httpx2.TransportError as error:
            return error

    def follow(self, stream: Stream[T], *, after: str | None = None, patience: float = 60.0) -> Iterator[T]:
        """Yields events, across broken connections and server restarts; leave the loop to stop.

        Args:
            stream: What to follow, from :mod:`skiros_py.client.calls.events`.
            after: Id of the last event seen; None for events from now on (for a job: all that are kept).
            patience: How long the server may stay silent before this gives up [s].

        Raises:
            ProblemError: The server refuses.
            Unreachable: The server does not answer.
        """
        return follow(self.http, stream, after=after, patience=patience)

    def close(self) -> None:
        """Closes all connections; may be called twice."""
        self.http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
