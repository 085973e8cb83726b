"""Finds the server of a data directory: by the file it writes there, and the lock it holds while it runs."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Generator
from pathlib import Path

import httpx2
from pydantic import ValidationError

from skiros_py.api.local import SERVER_FILE, LocalServer
from skiros_py.errors import FileError

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
