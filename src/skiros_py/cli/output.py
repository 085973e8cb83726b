"""Stdout is for the answer: whatever else is printed while a command runs, also from C, goes to stderr."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

import click

from skiros_py.cli.exit_status import REACHED
from skiros_py.cli.text import escaped

_answers: TextIO | None = None


@contextmanager
def answers_alone(*, prints: bool) -> Iterator[None]:
    """Keeps what others print from C away from stdout, and on request all that is printed in Python, too.

    Args:
        prints: True where only :func:`answer` shall reach stdout.
    """
    global _answers
    outer = sys.stdout
    _answers = _moved(outer)
    sys.stdout = sys.stderr if prints else _answers
    try:
        yield
    finally:
        _answers.flush()
        sys.stdout, _answers = outer, None


def answer(value: Any) -> None:
    """Prints the answer of a command as JSON, in one line."""
    answer_text(json.dumps(value))


def tell(found: Any, lines: Iterable[str] = (), *, as_json: bool) -> int:
    """Prints what a command has found: as JSON, or as lines for people.

    Args:
        found: Plain data, or what the API answers.
        lines: The same for people; what others wrote into them is escaped.
        as_json: Which of the two.

    Returns:
        The exit status for success.
    """
    if as_json:
        answer(_plain(found))
    else:
        for line in lines:
            click.echo(escaped(line))
    return REACHED


def _plain(found: Any) -> Any:
    if isinstance(found, dict):
        return {name: _plain(value) for name, value in found.items()}
    if isinstance(found, list | tuple):
        return [_plain(one) for one in found]
    return found.model_dump(mode="json", by_alias=True) if hasattr(found, "model_dump") else found


def answer_text(text: str) -> None:
    """Prints the answer of a command, as it is."""
    click.echo(text, file=_answers)


def silence() -> None:
    """Keeps the interpreter from complaining at exit about a closed output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), (_answers or sys.stdout).fileno())


def _moved(stdout: TextIO) -> TextIO:
    """Returns stdout on a descriptor of its own; what writes to the usual one writes to stderr from now on."""
    try:
        if stdout.fileno() != 1:
            return stdout
    except OSError:  # it is no file: nothing that C writes can get there
        return stdout
    stdout.flush()
    ours = os.dup(1)
    os.dup2(2, 1)
    return os.fdopen(ours, "w", encoding=stdout.encoding, errors=stdout.errors, buffering=1)
