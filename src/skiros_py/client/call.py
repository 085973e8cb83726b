"""One request to the API as a value: made by :mod:`skiros_py.client.calls`, sent by either client."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Concatenate, Generic, ParamSpec, Protocol, TypeVar

import httpx2

__all__ = ["Call", "LaterTopic", "Sends", "SendsLater", "Topic", "awaiting", "blocking", "nothing", "plain"]

T = TypeVar("T")
P = ParamSpec("P")


@dataclass(frozen=True, slots=True)
class Call(Generic[T]):
    """One request, and what its answer is read as.

    Attributes:
        method: HTTP method.
        path: Path below ``/api/v1``, quoted already.
        read: Makes the result of a good answer.
        query: Query parameters; None leaves one out.
        json: Body, as plain data; None for none.
        content: Body as it is, in the place of data; the headers say what it is.
        headers: Further headers; None leaves one out.
        repeatable: True where the same request twice does no harm, so that it may be sent again when the connection
            breaks.
    """

    method: str
    path: str
    read: Callable[[httpx2.Response], T]
    query: Mapping[str, Any] = field(default_factory=dict)
    json: Any = None
    headers: Mapping[str, str | None] = field(default_factory=dict)
    repeatable: bool = True
    content: bytes | None = None


class Sends(Protocol):
    """A blocking client, as its parts see it."""

    def send(self, call: Call[T]) -> T:
        """Sends a call, and returns what it asked for."""
        ...


class SendsLater(Protocol):
    """An asynchronous client, as its parts see it."""

    async def send(self, call: Call[T]) -> T:
        """Sends a call, and returns what it asked for."""
        ...


class Topic(Protocol):
    """A part of a blocking client."""

    @property
    def client(self) -> Sends:
        """The client."""
        ...


class LaterTopic(Protocol):
    """A part of an asynchronous client."""

    @property
    def client(self) -> SendsLater:
        """The client."""
        ...


def blocking(make: Callable[P, Call[T]]) -> Callable[Concatenate[Topic, P], T]:
    """Makes the method of a blocking client of a function that makes a call."""

    def method(topic: Topic, /, *args: P.args, **kwargs: P.kwargs) -> T:
        return topic.client.send(make(*args, **kwargs))

    method.__name__, method.__doc__ = make.__name__, make.__doc__
    vars(method)["call"] = make
    return method


def awaiting(make: Callable[P, Call[T]]) -> Callable[Concatenate[LaterTopic, P], Awaitable[T]]:
    """Makes the method of an asynchronous client of a function that makes a call."""

    async def method(topic: LaterTopic, /, *args: P.args, **kwargs: P.kwargs) -> T:
        return await topic.client.send(make(*args, **kwargs))

    method.__name__, method.__doc__ = make.__name__, make.__doc__
    vars(method)["call"] = make
    return method


def plain(response: httpx2.Response) -> Any:
    """Reads an answer as plain data."""
    return response.json()


def nothing(_response: httpx2.Response) -> None:
    """Reads an answer without a body."""
