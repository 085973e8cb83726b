"""Questions of a robot on the terminal: shown when they come, answered by a line of input."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.skills.questions import Question, Questions

_Command = TypeVar("_Command", bound=Callable[..., Any])


def ask_option(function: _Command) -> _Command:
    """Adds the option that says whether robots may ask the person at the terminal."""
    return click.option(
        "--ask/--no-ask",
        default=None,
        help="Whether robots may ask questions, answered by lines of input.  [default: if input is a terminal]",
    )(function)


@contextmanager
def answering(questions: Questions, *, ask: bool | None) -> Iterator[None]:
    """Lets a person answer the questions of a run.

    Args:
        questions: The run's questions.
        ask: False to answer none; None for where input is a terminal.
    """
    if not (sys.stdin.isatty() if ask is None else ask):
        yield
        return
    came = threading.Event()

    def show(question: Question) -> None:
        click.echo(f"? {question.asker} asks: {question.text} [{'/'.join(question.options)}]", err=True)
        came.set()

    unsubscribe = questions.subscribe(show)
    threading.Thread(target=_read, args=(questions, came), name="skiros-answers", daemon=True).start()
    try:
        yield
    finally:
        unsubscribe()


def _read(questions: Questions, came: threading.Event) -> None:
    """Takes each line of input for the answer to the oldest question."""
    while True:
        came.wait()
        line = sys.stdin.readline()
        if not line:
            return  # end of input: who asks more waits for its own timeout, or for a stop
        open_ = questions.open
        if not open_:
            continue
        try:
            questions.answer(open_[0].id, line.strip(), by="terminal")
        except UsageError as error:
            click.echo(f"? {error}", err=True)
