"""Which server a data directory belongs to: the file that it leaves there, and the lock that says whether it lives."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path

from pydantic import ValidationError

from skiros_py.api.local import SERVER_FILE, LocalServer
from skiros_py.errors import FileError

__all__ = ["find_server", "server_of"]

_LONGEST = 4096


def find_server(data: Path) -> LocalServer | None:
    """Returns the server that owns a data directory now; None where there is none, whatever an earlier one left.

    Raises:
        FileError: What it says of itself cannot be read, such as when it belongs to somebody else.
    """
    owner = _owner(data)
    if owner is None:
        return None
    path = data / SERVER_FILE
    try:
        server = LocalServer.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except ValidationError:
        return None  # an unfinished one of another version: it is written in one go
    except PermissionError:
        raise FileError(
            path, "belongs to somebody else's server: reach it by its address (--url), with a key of your own"
        ) from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    return server if server.pid == owner else None


def server_of(data: Path) -> LocalServer:
    """Returns the server that owns a data directory.

    Raises:
        FileError: There is none; or what it says of itself cannot be read.
    """
    server = find_server(data)
    if server is None:
        raise FileError(data, f"no server runs on this data directory: 'skiros serve --data {data}' starts one")
    return server


def _owner(data: Path) -> int | None:
    """Returns the process that has the directory's lock; None where nobody has. The kernel knows, not the file."""
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
