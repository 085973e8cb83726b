"""Interrupting code from outside: what a thread is doing, and the exceptions that are raised in it.

These exceptions are not faults, and authors must not catch them. Recording an activity is a plain assignment per tick,
so that it costs next to nothing; all locking is on the side that rarely runs, when a tick overruns.
"""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol, TypeVar

T = TypeVar("T")

_log = logging.getLogger(__name__)


class Interruption(BaseException):
    """The platform cancels what runs, such as code that holds the control cycle."""


class EndlessCalls(Interruption):
    """Modules call each other without end: the whole run fails, whatever nodes lie between the calls."""


class UserStop(KeyboardInterrupt):
    """The user asks the command to end; raised by the signal handlers of the command."""


def by_user(error: BaseException) -> bool:
    """Tells whether an exception comes from the user: any KeyboardInterrupt if the command has no SIGINT handler."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        return isinstance(error, KeyboardInterrupt)
    return isinstance(error, UserStop)


def not_the_authors(error: BaseException) -> bool:
    """Tells whether an exception that ended an author's code is the user's or the platform's, and has to go on."""
    return isinstance(error, Interruption) or by_user(error)


def raise_in(thread: int, kind: type[BaseException]) -> None:
    """Raises an exception in a thread, at one of its next Python instructions."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def cancel_pending(kind: type[BaseException]) -> None:
    """Cancels an exception of :func:`raise_in` that has not been raised yet in the current thread.

    It is replaced by one that is raised and caught here: cancelled in C, it would leave CPython 3.11's evaluation loop
    checking for it forever, and a program that is profiled would never go on.
    """
    try:
        raise_in(threading.get_ident(), kind)
        while True:
            pass
    except kind:
        pass


class WatchedTask(Protocol):
    """A task, as the watchdog sees it.

    Attributes:
        done: True when nothing more of it will run.
        interruptible: True when it may be interrupted anywhere.
    """

    done: bool
    interruptible: bool

    @property
    def name(self) -> str:
        """For messages."""

    def fail(self, fault: BaseException) -> None:
        """Ends it with a fault."""


@dataclass(eq=False, slots=True)
class CycleStep:
    """Work of the cycle itself (devices, listeners): reported when it takes too long, never interrupted.

    Attributes:
        name: For messages.
    """

    name: str
    done: bool = False
    interruptible: bool = False

    def fail(self, fault: BaseException) -> None:
        """Does nothing: the cycle cannot run without this step."""


@dataclass(frozen=True, slots=True)
class Overrun:
    """One tick that takes too long.

    Attributes:
        task: The task that was running.
        tick: The number of the tick.
        seconds: Its duration when the overrun was detected [s].
        limit: The longest allowed duration [s].
        module: The innermost primitive or device that was running; the task where there is none.
        stack: Where the control thread was, as text.
        device: The device whose kind was running within the task's own code; None for none.
    """

    task: WatchedTask
    tick: int
    seconds: float
    limit: float
    module: str
    stack: str
    device: Any = None

    def __str__(self) -> str:
        where = self.module if self.module == self.task.name else f"{self.module} (of {self.task.name})"
        own_code = self.device is None and not isinstance(self.task, CycleStep)
        hint = "yield more often" if own_code else "return at once"
        return (
            f"{where} held the control cycle for {self.seconds:.2f} s, {self.limit:.2f} s are allowed: "
            f"{hint}, or give long work to a worker process"
        )


class CycleOverrun(Interruption):
    """Raised inside code that holds the control cycle; no ``except Exception`` of its author catches it.

    Attributes:
        overrun: The overrun; None until the exception is delivered.
    """

    def __init__(self, overrun: Overrun | None = None) -> None:
        self.overrun = overrun
        super().__init__("held the control cycle too long" if overrun is None else str(overrun))


class Activity:
    """What the control thread is doing, for the watchdog.

    Attributes:
        tick: Incremented every cycle and for every separately timed step; ``(task, tick)`` identifies one tick.
        task: The task whose code is running; None between ticks.
        thread: Identity of the control thread.
        waits: Above 0 while the control thread legitimately waits.
        allowed: How long the present piece of work may take where that is more than for a tick [s]; else 0.
        overrun: The tick that was interrupted; mostly None.
    """

    __slots__ = ("_guard", "allowed", "overrun", "task", "thread", "tick", "waits")

    def __init__(self) -> None:
        self.tick = 0
        self.task: WatchedTask | None = None
        self.thread = 0
        self.waits = 0
        self.allowed = 0.0
        self.overrun: Overrun | None = None
        self._guard = threading.Lock()

    def begin_cycle(self) -> None:
        """Starts the ticks of a cycle, in the calling thread."""
        self.tick += 1
        self.thread = threading.get_ident()

    def enter(self, task: WatchedTask) -> WatchedTask | None:
        """Starts code outside a task's turn, such as closing one; returns what was running, for :meth:`leave`."""
        outer, self.task = self.task, task
        self.begin_cycle()
        return outer

    def leave(self, outer: WatchedTask | None) -> None:
        """Ends what :meth:`enter` began."""
        self.task = outer
        self.tick += 1
        if self.overrun is not None:
            self.settle()

    def run(self, task: WatchedTask, work: Callable[[], T]) -> T | None:
        """Runs code outside a task's turn; returns None where it took too long: it was interrupted, the task failed."""
        outer = self.enter(task)
        try:
            try:
                return work()
            finally:
                self.leave(outer)
        except CycleOverrun:
            if not task.done:  # it belongs to the enclosing work, or arrived while this work ended
                self.leave(outer)
            if not task.done:
                raise
            return None

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Tells the watchdog that the control thread waits for a worker, as it may in lockstep."""
        self.waits += 1
        try:
            yield
        finally:
            self.waits -= 1

    @contextmanager
    def allowing(self, seconds: float) -> Iterator[None]:
        """Tells the watchdog that this piece of work may take longer than a tick.

        The limit is set before the new tick begins, so that the old limit never applies to the longer work.

        Args:
            seconds: Wall time that it may take [s].
        """
        outer, self.allowed = self.allowed, max(seconds, self.allowed)
        self.tick += 1
        try:
            yield
        finally:
            self.tick += 1
            self.allowed = outer

    def interrupt(self, overrun: Overrun) -> bool:
        """Raises :class:`CycleOverrun` in the control thread, if it still is in that tick; for the watchdog's thread.

        The order matters: :attr:`overrun` is set before the tick is checked again, and the control thread ends the tick
        before it reads :attr:`overrun`, so one of the two always sees the other.
        """
        if not overrun.task.interruptible:
            return False
        with self._guard:
            known = self.overrun
            self.overrun = known or overrun
            if self.task is not overrun.task or self.tick != overrun.tick:
                self.overrun = known
                return False
            raise_in(self.thread, CycleOverrun)
            return True

    def settle(self) -> None:
        """Cancels an exception that came too late, and ends the task that overran; for the control thread."""
        while self.overrun is not None:
            try:
                overrun = self._cancel_pending()
                if overrun is not None:
                    overrun.task.fail(CycleOverrun(overrun))
            except CycleOverrun:  # the exception arrived just here: that settles it, too
                continue

    def _cancel_pending(self) -> Overrun | None:
        with self._guard:
            cancel_pending(CycleOverrun)
            overrun, self.overrun = self.overrun, None
            return overrun


# ---------------------------------------------------------------- code outside the control cycle

_POLL_INTERVAL = 0.1
"""Time between two checks of what runs with a time limit [s]."""
_limited: dict[int, _Limited] = {}
_has_limited = threading.Event()


@dataclass(eq=False)
class _Limited:
    """Code with a time limit, in whichever thread."""

    what: Callable[[], str]
    seconds: float
    ends: float
    activity: Activity
    done: bool = False
    interruptible: bool = True
    where: str = ""

    @property
    def name(self) -> str:
        return self.what()

    def fail(self, fault: BaseException) -> None:  # noqa: ARG002 - the protocol
        self.done = True

    def check(self, now: float) -> None:
        if now > self.ends:
            self.ends = now + self.seconds
            self.where = _location(self.activity.thread)
            interrupted = self.activity.interrupt(
                Overrun(self, self.activity.tick, self.seconds, self.seconds, self.name, "")
            )
            if interrupted:
                _log.error("%s has not ended within %g s%s", self.name, self.seconds, self.where)


def limited(what: Callable[[], str], seconds: float, work: Callable[[], T]) -> T:
    """Runs code of a plug-in outside the control cycle, and interrupts it where it does not end in time.

    A call into C that does not return is only reported in the log.

    Args:
        what: Names the code, for messages.
        seconds: Wall time that it may take [s].
        work: Runs it.

    Raises:
        TimeoutError: It did not end in time, and was interrupted.
    """
    one = _Limited(what, seconds, time.monotonic() + seconds, Activity())
    _watch_limits()
    _limited[id(one)] = one
    _has_limited.set()
    results: list[T] = []
    try:
        one.activity.run(one, lambda: results.append(work()))
    finally:
        del _limited[id(one)]
    if not results:
        raise TimeoutError(f"{what()} did not end within {seconds:g} s{one.where}")
    return results[0]


def _location(thread: int) -> str:
    """Returns where a thread is, for a message."""
    frame = sys._current_frames().get(thread)  # noqa: SLF001 - documented, for debugging
    return "" if frame is None else f" (in {frame.f_code.co_qualname}, {frame.f_code.co_filename}:{frame.f_lineno})"


@cache
def _watch_limits() -> None:
    os.register_at_fork(after_in_child=_watch_limits.cache_clear)
    threading.Thread(target=_check_limits, name="skiros-time-limits", daemon=True).start()


def _check_limits() -> None:
    while True:
        _has_limited.wait()
        time.sleep(_POLL_INTERVAL)
        now = time.monotonic()
        for one in tuple(_limited.values()):
            one.check(now)
        _has_limited.clear()
        if _limited:
            _has_limited.set()
