"""The end of a command: signals, logged warnings, and code that does not return."""

from __future__ import annotations

import atexit
import gc
import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import click

from skiros_py.cli.output import answer, brief
from skiros_py.errors import escaped
from skiros_py.interruptions import UserStop

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def raise_interrupt(_number: int, _frame: object) -> None:
    """Unwinds the stack, so that everything is closed."""
    raise UserStop


def unwind_on_stops() -> None:
    """Lets each stop signal unwind the stack."""
    for number in STOPS:
        signal.signal(number, raise_interrupt)


def ignore_stops() -> None:
    """Ignores stop signals, so that a clean-up in progress can finish."""
    for number in STOPS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def heard_at_once(listener: Callable[[], None]) -> Iterator[None]:
    """Calls a function, in a thread of its own, for each stop: also while the main thread is in C and hears none."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    thread = threading.Thread(target=_listen, args=(reading, listener), name="skiros-stops", daemon=True)
    thread.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)
        thread.join()
        os.close(reading)


def _listen(reading: int, listener: Callable[[], None]) -> None:
    while numbers := os.read(reading, 1):
        if numbers[0] in STOPS:
            listener()


@contextmanager
def warnings_on_stderr() -> Iterator[None]:
    """Prints each warning once, in one line, to stderr."""
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
    """Prints in one line what happened and where; with SKIROS_DEBUG, also the stack."""

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


GRACE = 3.0
"""Maximum time that the control thread may be stuck when the command should end [s]."""
_LEAVING = 2.0
"""Maximum time for threads and exit handlers of other libraries after the command has ended [s]."""
_LOOK = 0.05


def end_unless(comes_back: Callable[[], bool], text: str, status: int, *, as_json: bool, within: float = GRACE) -> None:
    """Ends the process from a thread of its own, unless there is a sign of life in time.

    Args:
        comes_back: Returns whether there is one; asked again and again.
        text: What is said then.
        status: Exit status then.
        as_json: Whether that is an answer in JSON, too.
        within: For how long it is waited for [s].
    """

    def wait() -> None:
        end = time.monotonic() + within
        while not comes_back():
            if time.monotonic() > end:
                click.echo(escaped(f"skiros: {text}"), err=True)
                if as_json:
                    answer({"error": text, "status": status})
                end_now(status)
            time.sleep(_LOOK)

    threading.Thread(target=wait, name="skiros-ending", daemon=True).start()


def leave(status: int) -> None:
    """Ends the process in the usual way, but does not wait for ever for threads that others have started."""
    threading.Thread(target=_end_late, args=(status,), name="skiros-leaving", daemon=True).start()
    atexit.register(gc.freeze)  # else the interpreter looks for garbage in all there is, for a second or two
    sys.exit(status)


def _end_late(status: int) -> None:
    main = threading.main_thread()
    main.join(_LEAVING)
    if main.is_alive():  # the command was called by a program that goes on
        return
    time.sleep(_LEAVING)
    left = [thread.name for thread in threading.enumerate() if thread is not main and not thread.daemon]
    what = f"threads that are no daemons still run: {', '.join(left)}" if left else "an exit handler does not end"
    click.echo(escaped(f"skiros: warning: {what}; the command ends nevertheless"), err=True)
    end_now(status)


def end_now(status: int) -> None:
    """Ends at once: no clean-up of others runs any more; what is in a data directory is on the disk already."""
    for child in _children():
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(status)


def _children() -> Iterator[int]:
    """Yields the processes that this one has started, where the system tells."""
    for file in Path("/proc/self/task").glob("*/children"):
        with suppress(OSError):  # that thread is gone
            yield from map(int, file.read_text(encoding="ascii").split())
