"""Selects the server of a command, and its key."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from skiros_py.cli.options import JSON, data_option, open_existing
from skiros_py.cli.output import tell
from skiros_py.errors import FileError, UsageError

if TYPE_CHECKING:
    from skiros_py.cli.world_open import OpenWorld
    from skiros_py.cli.world_server import ServedWorld
    from skiros_py.client import Client

Found = tuple[Any, Iterable[str]]
"""The result of a command: as plain data, and as lines for people."""
_Command = TypeVar("_Command", bound=Callable[..., Any])

_LONGEST_KEY = 1000
_URL = click.option(
    "--url", metavar="URL", envvar="SKIROS_URL", help="Address of the server.  [default: http://127.0.0.1:8000]"
)
_KEY_FILE = click.option(
    "--key-file",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File with the key; or set SKIROS_KEY in the environment.",
)


def server_options(command: _Command) -> _Command:
    """Adds the options that select a server: ``data``, ``url`` and ``key_file``."""
    return data_option(required=False)(_URL(_KEY_FILE(command)))


def with_client(**options: Any) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Adds the options that select a server, and calls the command with its ``client``.

    Args:
        **options: Those of :class:`~skiros_py.client.Client`: ``timeout`` and ``tries``.
    """

    def decorate(command: Callable[..., int]) -> Callable[..., int]:
        @functools.wraps(command)
        def run(*arguments: Any, data: Path | None, url: str | None, key_file: Path | None, **others: Any) -> int:
            with reach(data, url, key_file, **options) as client:
                return command(*arguments, client=client, **others)

        return server_options(run)

    return decorate


def served(
    group: click.Group,
    example: str,
    opened: Callable[[Path | None, str | None, Path | None], AbstractContextManager[Any]] | None = None,
    **options: Any,
) -> Callable[[Callable[..., Found]], click.Command]:
    """Returns a command of a group for a server, with the options that select it, and ``--json``.

    The function receives a client, then its arguments, and returns its result as data and as lines for people.

    Args:
        group: The group.
        example: How it is used ("device open gripper_1 --data cell"); its second word is the command's name.
        opened: Opens something else than a client for the options ``data``, ``url`` and ``key_file``.
        **options: Those of a click command.
    """

    def decorate(command: Callable[..., Found]) -> click.Command:
        @functools.wraps(command)
        def run(data: Path | None, url: str | None, key_file: Path | None, as_json: bool, **arguments: Any) -> int:
            with (opened or reach)(data, url, key_file) as subject:
                return tell(*command(subject, **arguments), as_json=as_json)

        made = group.command(example.split()[1], epilog=f"Example: skiros {example}", **options)
        return made(server_options(JSON(run)))

    return decorate


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
