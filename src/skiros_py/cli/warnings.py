"""What is logged as a warning while a command runs, said on stderr."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager

import click

from skiros_py.cli.text import brief, escaped


@contextmanager
def warnings_on_stderr() -> Iterator[None]:
    """Says each warning once, in one line, while it lasts; stdout stays the answer's."""
    logger, handler = logging.getLogger("skiros_py"), _Stderr(logging.WARNING)
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


def no_warnings_on_stderr() -> None:
    """Ends that early, where a log says it all."""
    logger = logging.getLogger("skiros_py")
    for handler in [one for one in logger.handlers if isinstance(one, _Stderr)]:
        logger.removeHandler(handler)


class _Stderr(logging.Handler):
    """Says in one line what happened and where; with SKIROS_DEBUG the stack follows."""

    def __init__(self, level: int) -> None:
        super().__init__(level)
        self._said: set[str] = set()
        self._whole = logging.Formatter()

    def emit(self, record: logging.LogRecord) -> None:
        whole = self._whole.format(record)
        text = brief(whole)
        if text in self._said:  # a command that opens two worlds meets the same plug-ins twice
            return
        self._said.add(text)
        click.echo(escaped(f"skiros: {record.levelname.lower()}: {text}"), err=True)
        if os.environ.get("SKIROS_DEBUG"):
            for line in whole.splitlines()[1:]:
                click.echo(escaped(line), err=True)
