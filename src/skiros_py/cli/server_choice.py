"""Selects the server of a command, and its key."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skiros_py.cli.options import open_existing
from skiros_py.errors import FileError, UsageError

if TYPE_CHECKING:
    from skiros_py.cli.world_open import OpenWorld
    from skiros_py.cli.world_server import ServedWorld
    from skiros_py.client import Client

_LONGEST_KEY = 1000


def reach(data: Path | None, url: str | None, key_file: Path | None, **options: Any) -> Client:
    """Returns the client of the server that the options name; close it.

    Args:
        data: A data directory of this machine.
        url: An address, instead.
        key_file: File with the key for that.
        **options: Those of :class:`~skiros_py.client.Client`: ``timeout`` and ``tries``.

    Raises:
        UsageError: They say two things.
        FileError: No server runs on the data directory, or the key cannot be read.
    """
    from stamina.instrumentation import set_on_retry_hooks

    from skiros_py.client import Client

    set_on_retry_hooks([])  # those that are usual write to stdout, which is for the answer
    if data is not None:
        if key_file is not None:
            raise UsageError("--key-file is for --url: the server of a data directory of yours needs no key")
        return Client.of_data(data, **options)  # whatever SKIROS_URL says
    return Client(url or "http://127.0.0.1:8000", _key(key_file), **options)


@contextmanager
def present_world(data: Path, **options: Any) -> Iterator[OpenWorld | ServedWorld]:
    """Reaches the world of a data directory: that of the server that owns it, or else one that is opened here.

    Args:
        data: The data directory.
        **options: Those of :class:`~skiros_py.client.Client`, where there is a server.

    Raises:
        FileError: It is not there, another process uses it, it cannot be read or written, or a file is broken.
    """
    from skiros_py.client.client import find_server

    if find_server(data) is None:
        from skiros_py.cli.world_open import OpenWorld

        with open_existing(data) as directory:
            yield OpenWorld(directory.world, directory.journal)
    else:
        from skiros_py.cli.world_server import ServedWorld

        with reach(data, None, None, **options) as client:
            yield ServedWorld(client)


def _key(file: Path | None) -> str | None:
    if file is None:
        return os.environ.get("SKIROS_KEY") or None
    try:
        with file.open(encoding="ascii") as opened:
            text = opened.read(_LONGEST_KEY + 1).strip()
    except (OSError, UnicodeError) as error:
        raise FileError(file, f"the key cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not text or len(text) > _LONGEST_KEY:
        raise FileError(file, "is no file with a key: it holds one line, as 'skiros key create' prints it")
    return text
