"""One request to the API as a value: made by :mod:`skiros_py.client.calls`, sent by either client."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial
from types import GenericAlias
from typing import Any, Generic, ParamSpec, Protocol, TypeVar, overload
from urllib.parse import quote

import httpx2
from pydantic import BaseModel, TypeAdapter

T = TypeVar("T")
P = ParamSpec("P")
C_co = TypeVar("C_co", bound="Sender | AsyncSender", covariant=True)


@dataclass(frozen=True, slots=True)
class Call(Generic[T]):
    """One request, and how its response is parsed.

    Attributes:
        method: HTTP method.
        path: Path below ``/api/v1``, already quoted.
        read: How a successful response is parsed: a model, a list of models, or a function of the response.
        query: Query parameters; None leaves one out.
        json: Body, as plain data; None for none.
        content: Raw body instead of ``json``; the headers give its type.
        headers: Further headers; None leaves one out.
        repeatable: True if repeating the request is safe, so that it may be sent again when the connection breaks.
    """

    method: str
    path: str
    read: type[T] | Callable[[httpx2.Response], T]
    query: Mapping[str, Any] = field(default_factory=dict)
    json: Any = None
    headers: Mapping[str, str | None] = field(default_factory=dict)
    repeatable: bool = True
    content: bytes | None = None

    def result(self, response: httpx2.Response) -> T:
        """Parses a successful response.

        Raises:
            ValueError: The response does not have the expected shape.
        """
        result: T = _reader(self.read)(response)
        return result


def _reader(read: Any) -> Callable[[httpx2.Response], Any]:
    """Returns the function that parses a response as a model or a list of models; functions are returned as is."""
    if isinstance(read, GenericAlias) or (isinstance(read, type) and issubclass(read, BaseModel)):
        return lambda response: _adapter(read).validate_json(response.content)
    return read  # type: ignore[no-any-return]


@lru_cache(maxsize=128)
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


class Sender(Protocol):
    """A blocking client, as its topics see it."""

    def send(self, call: Call[T]) -> T:
        """Sends a call and returns its result."""
        ...


class AsyncSender(Protocol):
    """An asynchronous client, as its topics see it."""

    async def send(self, call: Call[T]) -> T:
        """Sends a call and returns its result."""
        ...


class Topic(Generic[C_co]):
    """A part of a client."""

    def __init__(self, client: C_co) -> None:
        self.client = client


class Method(Generic[P, T]):
    """A method of a topic, made from a function that creates a call: blocking or awaitable, depending on the client.

    Args:
        make: Creates the call.
    """

    def __init__(self, make: Callable[P, Call[T]]) -> None:
        self.make = make
        self.__doc__ = make.__doc__

    @overload
    def __get__(self, topic: None, owner: type) -> Method[P, T]: ...
    @overload
    def __get__(self, topic: Topic[Sender], owner: type) -> Callable[P, T]: ...
    @overload
    def __get__(self, topic: Topic[AsyncSender], owner: type) -> Callable[P, Awaitable[T]]: ...
    def __get__(self, topic: Topic[Any] | None, owner: type) -> Any:
        """Returns the method of one client."""
        if topic is None:
            return self
        send = partial(_send, topic.client, self.make)
        send.__doc__ = self.__doc__  # for help()
        return send


def _send(client: Sender | AsyncSender, make: Callable[P, Call[T]], /, *args: P.args, **kwargs: P.kwargs) -> Any:
    return client.send(make(*args, **kwargs))


def path_of(*parts: str | int) -> str:
    """Returns a resource path below ``/api/v1``; each part is quoted."""
    return "".join(f"/{quote(str(part), safe='')}" for part in parts)


def if_match(version: int | None, otherwise: str | None = None) -> dict[str, str | None]:
    """Returns the header with the expected version.

    Args:
        version: The version.
        otherwise: The value if there is no version; None to omit the header.
    """
    return {"If-Match": otherwise if version is None else f'"{version}"'}


def plain(response: httpx2.Response) -> Any:
    """Parses a response as plain data."""
    return response.json()


def nothing(_response: httpx2.Response) -> None:
    """Accepts a response without a body."""
