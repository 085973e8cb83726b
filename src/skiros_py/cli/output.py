"""Output of the commands: text or JSON, escaped for the terminal, and exit statuses."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

import click

from skiros_py.errors import escaped

if TYPE_CHECKING:
    from rich.console import Console, ConsoleRenderable

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


_FILE_WIDTH = 200
"""Width of a table that is not shown on a terminal."""
_NARROWEST = 12
"""Width of the columns of a table for which it is readable."""
_STACKS = ('\n  File "', "\nTraceback (most recent call last):")
"""How stacks begin that follow a text."""


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
        found: Plain data, frozen values, or what the API answers.
        lines: The same for people; what others wrote into them is escaped.
        as_json: Which of the two.

    Returns:
        The exit status for success.
    """
    if as_json:
        from pydantic_core import to_jsonable_python

        answer(to_jsonable_python(found))
    else:
        for line in lines:
            click.echo(escaped(line))
    return REACHED


def counted(**numbers: int) -> str:
    """Returns numbers of things with their names: "2 files, 1 error"."""
    return ", ".join(f"{number} {name}{'' if number == 1 else 's'}" for name, number in numbers.items())


def table_lines(columns: Sequence[str], rows: Iterable[Sequence[str]], *, right: Collection[str] = ()) -> list[str]:
    """Returns the lines of a table; cells that do not fit into a terminal are folded.

    In a terminal too narrow for that, each row is a list with a line for each cell.

    Args:
        columns: The titles.
        rows: The cells; what others wrote into them is escaped.
        right: Columns that are aligned to the right.
    """
    from rich.table import Table
    from rich.text import Text

    cells = [[escaped(cell) for cell in row] for row in rows]
    longest = [max(map(len, column)) for column in zip(columns, *cells, strict=True)]
    if sum(min(length, _NARROWEST) + 1 for length in longest) > console().width:
        return [
            line
            for row in cells
            for line in (*(f"{name}: {cell}" for name, cell in zip(columns, row, strict=True) if cell), "")
        ]
    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in right else "left", overflow="fold")
    for row in cells:
        table.add_row(*map(Text, row))
    return rendered(table)


def rendered(what: ConsoleRenderable) -> list[str]:
    """Returns the lines of something that rich draws, such as a table or a tree, as wide as the terminal."""
    plain = console(color_system=None)
    with plain.capture() as captured:
        plain.print(what)
    return [line.rstrip() for line in captured.get().splitlines()]


def console(**options: Any) -> Console:
    """Returns a console of rich that is as wide as the terminal; a file or a pipe has no width to fit."""
    from rich.console import Console

    found = Console(highlight=False, **options)
    if not found.is_terminal:
        found.width = _FILE_WIDTH
    return found


@contextmanager
def progress(first: str) -> Iterator[Callable[[str], None]]:
    """Shows progress on a terminal; elsewhere nothing."""
    with console(stderr=True).status(first) as status:
        yield lambda text: status.update(f"{text} …")


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
