"""The clients: one for blocking and one for asynchronous programs; both find a local server by its data directory."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import AsyncIterator, Generator, Iterator
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

import httpx2
import stamina
from pydantic import ValidationError

from skiros_py.api.server import SERVER_FILE, LocalServer
from skiros_py.client.operation import AsyncSender, C, Sender
from skiros_py.client.request import Call, arguments_of, reaching, result_of, retries, settings_for
from skiros_py.client.streams import Stream, follow, follow_later
from skiros_py.client.topics import Topics
from skiros_py.errors import FileError, UsageError

_LONGEST = 4096


def find_server(data: Path) -> LocalServer | None:
    """Returns the server that owns a data directory now; None if there is none, regardless of old files.

    Raises:
        FileError: Its file cannot be read, for example because it belongs to another user.
    """
    owner = _owner(data)
    if owner is None:
        return None
    server = _announced(data)
    return server if server is not None and server.pid == owner else None


def _announced(data: Path) -> LocalServer | None:
    """Returns the file contents of the last server of a data directory, whether it is running or not."""
    path = data / SERVER_FILE
    try:
        return LocalServer.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except ValidationError:
        return None  # incomplete, so of another version: it is written atomically
    except PermissionError:
        raise FileError(
            path, "belongs to somebody else's server: reach it by its address (--url), with a key of your own"
        ) from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error


def server_of(data: Path) -> LocalServer:
    """Returns the server that owns a data directory.

    Raises:
        FileError: There is none, or its file cannot be read.
    """
    server = find_server(data)
    if server is None:
        raise FileError(data, f"no server runs on this data directory: 'skiros serve --data {data}' starts one")
    return server


class InStep(httpx2.Auth):
    """Sends each request to the server that currently owns a data directory: a restarted one has another key.

    The directory's lock is not checked, since that could interfere with a starting server; without a running server
    the connection simply fails.

    Args:
        data: The data directory.
    """

    def __init__(self, data: Path) -> None:
        self._data = data

    def auth_flow(self, request: httpx2.Request) -> Generator[httpx2.Request, httpx2.Response, None]:
        """Addresses a request."""
        server = _announced(self._data)
        if server is not None:
            url = httpx2.URL(server.url)
            request.url = request.url.copy_with(scheme=url.scheme, host=url.host, port=url.port)
            request.headers["Host"] = url.netloc.decode("ascii")
            request.headers["Authorization"] = f"Bearer {server.token}"
        yield request


def _owner(data: Path) -> int | None:
    """Returns the process that holds the directory's lock, from the kernel; None if it is free."""
    try:
        file = os.open(data / "lock", os.O_RDONLY)
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return _signed(os.pread(file, _LONGEST, 0))
    finally:
        os.close(file)
    return None


def _signed(text: bytes) -> int | None:
    try:
        return int(json.loads(text)["pid"])
    except (ValueError, KeyError, TypeError):
        return None


class AnyClient(Topics[C]):
    """A client of one server; for its arguments see :class:`~skiros_py.client.client.Client`."""

    http: Any
    _http: ClassVar[Any]

    def __init__(
        self, url: str = "http://127.0.0.1:8000", key: str | None = None, *, timeout: float = 30.0, tries: int = 6
    ) -> None:
        super().__init__(self)  # type: ignore[arg-type]  # each kind of client is one of the senders
        if not isinstance(tries, int) or tries < 1:
            raise UsageError(f"tries: 1 or more, not {tries!r}")
        self.http = self._http(**settings_for(url, key, timeout))
        self.url = url.rstrip("/")
        self._tries = tries

    @classmethod
    def of_data(cls, data: str | Path, **options: Any) -> Self:
        """Returns the client of the server that owns a data directory of this machine; it needs no key.

        A replacement server started later, perhaps at another address, is found as well.

        Args:
            data: The data directory.
            **options: ``timeout`` and ``tries``.

        Raises:
            FileError: No server runs on it, or another user's does.
        """
        client = cls(server_of(Path(data)).url, **options)
        client.http.auth = InStep(Path(data))
        return client


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
        async for attempt in stamina.retry_context(**retries(call, self._tries)):
            with attempt, reaching(self.url):
                return result_of(call, await self.http.request(**request))
        raise AssertionError("the last try returns or raises")

    def follow(self, stream: Stream[T], *, after: str | None = None, patience: float = 60.0) -> AsyncIterator[T]:
        """Yields events for ``async for``; see :meth:`skiros_py.client.client.Client.follow`."""
        return follow_later(self.http, stream, after=after, patience=patience)

    async def close(self) -> None:
        """Closes all connections; may be called twice."""
        await self.http.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


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
        for attempt in stamina.retry_context(**retries(call, self._tries)):
            with attempt, reaching(self.url):
                return result_of(call, self.http.request(**request))
        raise AssertionError("the last try returns or raises")

    def follow(self, stream: Stream[T], *, after: str | None = None, patience: float = 60.0) -> Iterator[T]:
        """Yields events, across broken connections and server restarts; leave the loop to stop.

        Args:
            stream: What to follow, from :mod:`skiros_py.client.streams`.
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

    def __exit__(self, *_: object) -> None:
        self.close()
