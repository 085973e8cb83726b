"""One control cycle: exchange with the devices, compute signals, tick all tasks, merge what runs want, exchange.

All tasks of a cycle see the same snapshot. Time is the cell's; the pace says how it relates to the wall clock.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from skiros_py.errors import SkirosError, UsageError
from skiros_py.execution.command_mixing import Mix
from skiros_py.execution.module_faults import off_words
from skiros_py.execution.signals import Signals
from skiros_py.execution.task import RunClock, Task
from skiros_py.interruptions import CycleOverrun, CycleStep, WatchedTask, by_user
from skiros_py.messages import Message
from skiros_py.ports.board import DeviceBoard

__all__ = ["ControlCycle", "Task"]

_log = logging.getLogger(__name__)

T = TypeVar("T")

_SUCCESSORS = 100
"""How many tasks that other tasks start have their first tick in the same cycle: endless starting must not hold it."""


class _Observer:
    """What is called at the end of every cycle, as the watchdog sees it; one of a plug-in can be switched off."""

    def __init__(self, call: Callable[[], None], owner: str) -> None:
        self.call = call
        self.name = f"the observer {getattr(call, '__qualname__', call)}{f' of {owner}' if owner else ''}"
        self.interruptible = bool(owner)
        self.done = False

    def fail(self, fault: BaseException) -> None:
        """Switches it off where it is a plug-in's; the cycle cannot do without its own."""
        if self.interruptible:
            self.done = True
            _log.warning("%s was switched off: %s", self.name, off_words(fault))


class ControlCycle:
    """Owns time: nothing happens between two calls of :meth:`step`.

    Args:
        board: The devices.
        pace: Simulated seconds per wall second; None for as fast as possible.

    Attributes:
        board: The devices.
        pace: Simulated seconds per wall second; None for as fast as possible.
        activity: What the control thread does at this moment, for the watchdog.
        halted: Why everything was halted; empty while tasks may run.
        signals: What is computed of each snapshot before the tasks run; None for nothing.
    """

    def __init__(self, board: DeviceBoard, pace: float | None = None) -> None:
        self.board = board
        self.pace = pace
        self.activity = board.guard.activity
        board.guard.halt = self.halt
        self.halted = ""
        self.signals: Signals | None = None
        self._mix = Mix(board)
        self._tasks: list[Task[Any]] = []
        self._later: list[Task[Any]] = []
        self._ended: list[Task[Any]] = []
        self._places = math.inf
        self._stopping: list[Task[Any]] = []
        self._exchanging = CycleStep("the exchange with the devices")
        self._observers: list[_Observer] = []
        self._guest = ""
        self._epoch = (time.perf_counter(), board.snapshot.time)

    # ------------------------------------------------------------------ running

    def start(self, generator: Generator[None, None, T], name: str = "", *, clock: RunClock | None = None) -> Task[T]:
        """Adds a task; it is ticked for the first time in the coming cycle, or in this one where a task starts it.

        Args:
            generator: What is ticked.
            name: For messages; the generator's own name where left out.
            clock: The task's clock, where others read it too.

        Raises:
            UsageError: Everything was halted, and :meth:`reset` was not called since.
        """
        task = Task(generator, self.board, name, clock, self._ended.append)
        if self.halted:
            raise UsageError(
                "{name} cannot start: everything was halted ({halted}); reset the robots first",
                name=task.name,
                halted=self.halted,
            )
        self._places -= 1
        (self._tasks if self._places >= 0 else self._later).append(task)
        return task

    def observe(self, observer: Callable[[], None]) -> Callable[[], None]:
        """Calls a function at the end of every cycle; it must be quick. Returns a function that ends this."""
        entry = _Observer(observer, self._guest)
        self._observers.append(entry)
        return lambda: self._observers.remove(entry)

    @contextmanager
    def guest(self, name: str) -> Iterator[None]:
        """Observers that are added in a ``with`` of it are a plug-in's: one that raises or hangs is switched off.

        Args:
            name: Whose it is, for messages.
        """
        self._guest = name
        try:
            yield
        finally:
            self._guest = ""

    def step(self) -> None:
        """Runs one cycle."""
        self._obey_halt()
        if self.board.shared:
            self._mix.merge()
        self._do(self._exchanging, self.board.exchange)
        if self.signals is not None:
            self.signals.update()
        self._settle()
        self._tick_all()
        self._obey_halt()
        self._sort_out()
        for observer in tuple(self._observers):
            if not observer.done:
                self._observe(observer)
        self._keep_pace()

    def run(self, task: Task[T]) -> T:
        """Runs cycles until a task is done and returns its result, or raises its fault."""
        while not task.done:
            self.step()
        return task.result

    # ------------------------------------------------------------------ halting

    def halt(self, reason: str) -> None:
        """Brakes everything at once, past all queues, and ends all tasks in the control thread's next cycle.

        May be called in any thread and in a task. No task can be started until :meth:`reset`.

        Args:
            reason: Why, for a person.
        """
        self.forbid(reason)
        self.board.halt()

    def forbid(self, reason: str) -> None:
        """Ends all tasks in the next cycle, as :meth:`halt` does; the devices get no command to brake."""
        self.halted = self.halted or reason or "halted"

    def stop_all(self, reason: str = "a stop was asked for") -> bool:
        """Halts everything and runs on until all stands, or the robots' braking time is over; only between two cycles.

        No task can be started until :meth:`reset`.

        Args:
            reason: Why, for a person.

        Returns:
            True when everything stands.

        Raises:
            UsageError: A task called it.
        """
        if self.activity.task is not None:
            raise UsageError(f"{self.activity.task.name}: a task cannot wait for its own end; it may halt everything")
        self.halt(reason)
        deadline = self.board.snapshot.time + self.board.braking_time
        self.step()
        while not self.board.still and self.board.snapshot.time < deadline:
            self.step()
        return self.board.still

    def reset(self) -> None:
        """Lets tasks be started again after everything was halted.

        Raises:
            UsageError: Something still moves, or a task still runs.
        """
        if isinstance(self.activity.task, Task) or (self.halted and not all(task.done for task in self._tasks)):
            raise UsageError(Message("reset is for when everything has stopped: a task still runs"))
        if not self.board.still:
            raise UsageError(Message("reset is for when everything stands: something still moves"))
        self.board.guard.restart()
        self.board.release()
        if self.signals is not None:
            self.signals.restart()
        self.board.unmixed.clear()
        self.halted = ""

    def _obey_halt(self) -> None:
        if self.halted and self._tasks:
            for task in self._tasks:
                task.stop(self.halted)
            self._sort_out()

    def set_pace(self, pace: float) -> None:
        """Goes on at another pace from now on; only between two cycles, and not in lockstep.

        Args:
            pace: Simulated seconds per wall second.

        Raises:
            UsageError: It is no positive number, or the run is in lockstep: whether workers are waited for was
                decided when it began.
        """
        if self.pace is None:
            raise UsageError("a run in lockstep goes as fast as it can: start it with a pace to be able to change that")
        if not 0.0 < pace < math.inf:
            raise UsageError(f"pace: a positive factor, not {pace!r}")
        self.pace = pace
        self._epoch = (time.perf_counter(), self.board.snapshot.time)

    # ------------------------------------------------------------------ parts of a cycle

    def _do(self, chore: WatchedTask, work: Callable[[], object]) -> None:
        """Runs a part of the cycle itself, watched by the watchdog."""
        outer = self.activity.enter(chore)
        try:
            work()
        finally:
            self.activity.leave(outer)

    def _observe(self, observer: _Observer) -> None:
        try:
            self.activity.run(observer, observer.call)
        except Exception as error:
            if not observer.interruptible:
                raise
            observer.fail(error)

    def _tick_all(self) -> None:
        """Runs every task up to its next ``yield``, and those that they start, unless they are paused.

        An interruption that comes late, between two ticks, changes nothing.
        """
        board, activity = self.board, self.activity
        activity.begin_cycle()
        self._places = _SUCCESSORS
        coming = iter(self._tasks)  # also those that are added meanwhile
        while True:
            try:
                for task in coming:
                    activity.task = board.owner = task
                    if self.halted:  # also after each overrun
                        if activity.overrun is not None:
                            activity.settle()
                        break
                    if task.done or not (task.clock.steady or task.has_turn()):
                        continue
                    try:  # here, and not in a method of the task: 1,000 calls would cost a quarter of the cycle
                        next(task.generator)
                    except StopIteration as end:
                        task.finish(end.value)
                    except BaseException as fault:  # an author's code: it ends this task only
                        task.fail(fault)
                        if by_user(fault):
                            raise
                    if task.aborted:
                        task.close()
                activity.task = board.owner = None
                if activity.overrun is not None:
                    activity.settle()
                break
            except CycleOverrun:
                continue
            finally:
                activity.task = board.owner = board.share = None
        self._places = math.inf
        self._tasks += self._later
        self._later.clear()

    def _sort_out(self) -> None:
        """Removes finished tasks and reports faults."""
        if not self._ended:
            return
        self._ended.clear()
        done = [task for task in self._tasks if task.done]
        self._tasks = [task for task in self._tasks if not task.done]
        for task in done:
            task.settle()
            if task.fault is not None:
                self._report(task)
        self._stopping += [task for task in done if task.stopping]

    def _settle(self) -> None:
        """Checks which stopped tasks have come to a standstill."""
        for task in self._stopping:
            before = task.fault
            task.settle()
            if task.fault is not before:
                self._report(task)
        if self._stopping:
            self._stopping = [task for task in self._stopping if task.stopping]

    def _report(self, task: Task[Any]) -> None:
        # The words of our own faults say it all, and the watchdog logs stacks itself.
        own = isinstance(task.fault, SkirosError | CycleOverrun)
        _log.error("%s ended with a fault: %s", task.name, task.fault, exc_info=None if own else task.fault)

    def _keep_pace(self) -> None:
        if self.pace is None:
            return
        wall, simulated = self._epoch
        due = wall + (self.board.snapshot.time - simulated) / self.pace
        delay = due - time.perf_counter()
        if delay > 0.0:
            time.sleep(delay)
        elif delay < -1.0:  # far behind (a long planning): do not race to catch up
            self._epoch = (time.perf_counter(), self.board.snapshot.time)
