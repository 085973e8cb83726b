"""Output of the commands: text or JSON, escaped for the terminal, and exit statuses."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

import click

REACHED = 0
"""The goal holds: by the simulator's truth, or by belief where a fake ran."""
NOT_REACHED = 1
"""It does not, or something broke on the way."""
DIFFERENT = 1
"""The compared things differ, or a copy is outdated."""
USAGE = 2
"""Wrong usage, or a file that cannot be understood; nothing was started."""
NO_PLAN = 3
"""No plan leads to the goal; nothing was done."""
STOPPED = 130
"""It was stopped."""


_STACKS = ('\n  File "', "\nTraceback (most recent call last):")
"""How stacks begin that follow a text."""


def escaped(text: str) -> str:
    r"""Returns a line in which everything that cannot be printed is written out, as in ``\x1b`` or ``\n``.

    Labels, authors and reasons come from anywhere; what they say must not steer the terminal or look like more lines.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def brief(text: str) -> str:
    """Returns a text without the stack trace that follows it, but with its line in the author's code."""
    from skiros_py.plugins.plugin import authors_line  # help is there at once, without all that

    start = min((at for stack in _STACKS if (at := text.find(stack)) >= 0), default=-1)
    if start < 0:
        return text
    head, frame = text[:start], authors_line(text[start:])
    return head if frame is None else f"{head} ({frame[0]}:{frame[1]} in {frame[2]})"


_answers: TextIO | None = None


@contextmanager
def answers_alone(*, prints: bool) -> Iterator[None]:
    """Keeps output printed from C away from stdout; optionally also all output printed in Python.

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
    """Prints the result of a command: as JSON, or as lines for people.

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


@contextmanager
def progress(first: str) -> Iterator[Callable[[str], None]]:
    """Shows progress on a terminal; elsewhere nothing."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False)
    with console.status(first) as status:
        yield lambda text: status.update(f"{text} …")


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
