"""Commands that return their result as data and as lines for people, with ``--json`` to choose between the two."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from skiros_py.cli.options import JSON, combined, data_option
from skiros_py.cli.output import REACHED, tell
from skiros_py.cli.server_choice import reach
from skiros_py.errors import UsageError

Found = tuple[Any, Iterable[str]] | tuple[Any, Iterable[str], int]
"""The result of a command: data, lines for people, and the exit status unless it succeeded."""

SERVER = combined(
    data_option(required=False),
    click.option(
        "--url", metavar="URL", envvar="SKIROS_URL", help="Address of the server.  [default: http://127.0.0.1:8000]"
    ),
    click.option(
        "--key-file",
        metavar="FILE",
        type=click.Path(path_type=Path, dir_okay=False),
        help="File with the key; or set SKIROS_KEY in the environment.",
    ),
)
"""The options that select a server: ``data``, ``url`` and ``key_file``."""


def reports(
    example: str, group: click.Group | None = None, *, name: str = "", **settings: Any
) -> Callable[[Callable[..., Found]], click.Command]:
    """Returns a command with ``--json`` for a function that returns its result.

    Args:
        example: How it is used ("scene list --json"), beginning with its group; the next word is the command's name.
        group: The group; None for a command of ``skiros`` itself, or one that its group imports when needed.
        name: Its name, unless it follows from the example.
        **settings: Those of a click command; by default, the example is its epilog.
    """
    words = example.split()
    name = name or (words[0] if group is None else words[words.index(str(group.name)) + 1])
    settings = {"epilog": f"Example: skiros {example}", **settings}

    def decorate(function: Callable[..., Found]) -> click.Command:
        @functools.wraps(function)
        def run(*, as_json: bool, **arguments: Any) -> int:
            data, lines, *status = function(**arguments)
            tell(data, lines, as_json=as_json)
            return status[0] if status else REACHED

        return (click.command if group is None else group.command)(name, **settings)(JSON(run))

    return decorate


def served(
    example: str,
    group: click.Group | None = None,
    opened: Callable[..., AbstractContextManager[Any]] = reach,
    *,
    client: dict[str, Any] | None = None,
    **settings: Any,
) -> Callable[[Callable[..., Found]], click.Command]:
    """Returns a command for a server, with the options that select it; its function receives a client first.

    Args:
        example: As of :func:`reports`.
        group: The group.
        opened: Opens something else than a client for the options ``data``, ``url`` and ``key_file``.
        client: Options of the client.
        **settings: As of :func:`reports`.
    """

    def decorate(function: Callable[..., Found]) -> click.Command:
        @functools.wraps(function)
        def run(data: Path | None, url: str | None, key_file: Path | None, **arguments: Any) -> Found:
            source = click.get_current_context().get_parameter_source("url")
            if data is not None and source is ParameterSource.COMMANDLINE:
                raise UsageError("--data and --url each name a server: give one of them")
            with opened(data, url, key_file, **(client or {})) as subject:
                return function(subject, **arguments)

        return reports(example, group, **settings)(SERVER(run))

    return decorate
