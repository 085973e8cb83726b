"""Interrupting code from outside: what a thread is doing, and the exceptions that are raised in it.

They are no faults, and authors must not catch them. Recording an activity is a plain assignment per tick, so that it
costs next to nothing; all locking is on the side that rarely runs, when a tick overruns.
"""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol


class Interruption(BaseException):
    """The platform cancels what runs, such as code that holds the control cycle."""


class UserStop(KeyboardInterrupt):
    """The user asks the command to end: what its handlers of signals raise."""


def by_user(error: BaseException) -> bool:
    """Tells whether an exception comes from the user; without a handler of Ctrl-C, each interrupt counts."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        return isinstance(error, KeyboardInterrupt)
    return isinstance(error, UserStop)


def raise_in(thread: int, kind: type[BaseException]) -> None:
    """Raises an exception in a thread, at one of its next Python instructions."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def take_back(kind: type[BaseException]) -> None:
    """Takes back an exception of :func:`raise_in` that has not been raised yet in the current thread.

    It is replaced by one that is raised and caught here: taken back in C, it would leave CPython 3.11's evaluation loop
    checking for it forever, and a program that is profiled would never go on.
    """
    try:
        raise_in(threading.get_ident(), kind)
        while True:
            pass
    except kind:
        pass


class Watched(Protocol):
    """A task, as the watchdog sees it.

    Attributes:
        name: For messages.
        done: True when nothing more of it will run.
        interruptible: True when it may be interrupted anywhere.
    """

    name: str
    done: bool
    interruptible: bool

    def fail(self, fault: BaseException) -> None:
        """Ends it with a fault."""
        ...


@dataclass(eq=False, slots=True)
class Chore:
    """Work of the cycle itself (devices, listeners): reported when it takes too long, never interrupted.

    Attributes:
        name: For messages.
    """

    name: str
    done: bool = False
    interruptible: bool = False

    def fail(self, fault: BaseException) -> None:
        """Goes on: the cycle cannot do without it."""


@dataclass(frozen=True, slots=True)
class Overrun:
    """One tick that takes too long.

    Attributes:
        task: Whose tick it is.
        tick: Which tick it is.
        seconds: For how long it had lasted when it was noticed [s].
        limit: For how long it may last [s].
        module: The innermost primitive that was running; the task where there is none.
        stack: Where the control thread was, as text.
    """

    task: Watched
    tick: int
    seconds: float
    limit: float
    module: str
    stack: str

    def __str__(self) -> str:
        where = self.module if self.module == self.task.name else f"{self.module} (of {self.task.name})"
        return (
            f"{where} held the control cycle for {self.seconds:.2f} s, {self.limit:.2f} s are allowed: "
            "yield more often, or give long work to a worker process"
        )


class CycleOverrun(Interruption):
    """Raised inside code that holds the control cycle; no ``except Exception`` of its author catches it.

    Attributes:
        overrun: What was noticed; None while it is on its way.
    """

    def __init__(self, overrun: Overrun | None = None) -> None:
        self.overrun = overrun
        super().__init__("held the control cycle too long" if overrun is None else str(overrun))


class Activity:
    """What the control thread is doing, for the watchdog.

    Attributes:
        tick: Grows with every cycle and with every piece of work that is timed by itself: with :attr:`task` it names
            one tick.
        task: Whose code is running; None between ticks.
        thread: Identity of the control thread.
        waits: Above 0 while the control thread legitimately waits.
        allowed: How long the present piece of work may take where that is more than for a tick [s]; else 0.
        overrun: The tick that was interrupted; mostly None.
    """

    __slots__ = ("_guard", "allowed", "overrun", "task", "thread", "tick", "waits")

    def __init__(self) -> None:
        self.tick = 0
        self.task: Watched | None = None
        self.thread = 0
        self.waits = 0
        self.allowed = 0.0
        self.overrun: Overrun | None = None
        self._guard = threading.Lock()

    def begin_cycle(self) -> None:
        """A cycle's ticks begin, in the calling thread."""
        self.tick += 1
        self.thread = threading.get_ident()

    def enter(self, task: Watched) -> Watched | None:
        """Code begins to run outside a task's turn, such as when one is closed; returns whose code it interrupts."""
        outer, self.task = self.task, task
        self.begin_cycle()
        return outer

    def leave(self, outer: Watched | None) -> None:
        """Ends what :meth:`enter` began."""
        self.task = outer
        self.tick += 1
        if self.overrun is not None:
            self.settle()

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

        The order matters: at no moment does the old limit meet the tick of the longer work.

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

        The order matters: the overrun is announced before the tick is looked at once more. The control thread marks the
        end of a tick before it looks for announcements, so one of the two always sees the other.
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
        """Takes back an exception that came too late, and ends the task that overran; for the control thread."""
        while self.overrun is not None:
            try:
                overrun = self._take_back()
                if overrun is not None:
                    overrun.task.fail(CycleOverrun(overrun))
            except CycleOverrun:  # the exception arrived just here: that settles it, too
                continue

    def _take_back(self) -> Overrun | None:
        with self._guard:
            take_back(CycleOverrun)
            overrun, self.overrun = self.overrun, None
            return overrun
