"""One control cycle: exchange with the robots, then tick everything that runs, in a fixed order (D4 of the design).

All tasks of a cycle see the same snapshot. Time is the cell's; the pace says how it relates to the wall clock.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from skiros_py.robot.devices import DeviceBoard

__all__ = ["ControlCycle", "Task"]

T = TypeVar("T")


class Task(Generic[T]):
    """A generator that is ticked once per cycle until it returns."""

    def __init__(self, generator: Generator[None, None, T]) -> None:
        self._generator = generator
        self.done = False
        self.stopped = False
        self._result: T | None = None

    def tick(self) -> None:
        """Runs it up to its next ``yield``."""
        try:
            next(self._generator)
        except StopIteration as end:
            self._result = end.value
            self.done = True
        except BaseException:
            self.done = self.stopped = True
            raise

    def stop(self) -> None:
        """Breaks it off now; its ``finally`` blocks run, and nothing more of it afterwards."""
        if not self.done:
            self.done = self.stopped = True
            self._generator.close()

    @property
    def result(self) -> T:
        """What it returned.

        Raises:
            RuntimeError: It still runs or was stopped.
        """
        if not self.done or self.stopped:
            raise RuntimeError("a task has a result only after it ended by itself")
        return self._result  # type: ignore[return-value]  # T may include None


class ControlCycle:
    """Owns time: nothing happens between two calls of :meth:`step`.

    Args:
        board: The devices.
        pace: Simulated seconds per wall second; None for as fast as possible.
    """

    def __init__(self, board: DeviceBoard, pace: float | None = None) -> None:
        self.board = board
        self._pace = pace
        self._tasks: list[Task[object]] = []
        self._observers: list[Callable[[], None]] = []
        self._epoch = (time.perf_counter(), board.snapshot.time)

    def start(self, generator: Generator[None, None, T]) -> Task[T]:
        """Adds a task; it is ticked for the first time in the coming cycle."""
        task = Task(generator)
        self._tasks.append(task)  # type: ignore[arg-type]  # the cycle only ticks it
        return task

    def observe(self, observer: Callable[[], None]) -> None:
        """Calls a function at the end of every cycle; it must be quick and change nothing."""
        self._observers.append(observer)

    def step(self) -> None:
        """Runs one cycle."""
        self.board.exchange()
        for task in list(self._tasks):
            task.tick()
        self._tasks = [task for task in self._tasks if not task.done]
        for observer in self._observers:
            observer()
        self._keep_pace()

    def run(self, task: Task[T]) -> T:
        """Runs cycles until a task is done and returns its result."""
        while not task.done:
            self.step()
        return task.result

    def stop_all(self, *, patience: float = 5.0) -> bool:
        """Stops every task and runs on until everything stands.

        Args:
            patience: Longest time to wait for standstill [s].

        Returns:
            True when everything stands.

        Raises:
            Exception: What the first task raised while it was stopped; all are stopped before.
        """
        faults = [fault for task in self._tasks if (fault := _stop(task)) is not None]
        self._tasks = []
        deadline = self.board.snapshot.time + patience
        self.step()
        while not self.board.still and self.board.snapshot.time < deadline:
            self.step()
        if faults:
            raise faults[0]
        return self.board.still

    def _keep_pace(self) -> None:
        if self._pace is None:
            return
        wall, simulated = self._epoch
        due = wall + (self.board.snapshot.time - simulated) / self._pace
        delay = due - time.perf_counter()
        if delay > 0.0:
            time.sleep(delay)
        elif delay < -1.0:  # far behind (a long planning): do not race to catch up
            self._epoch = (time.perf_counter(), self.board.snapshot.time)


def _stop(task: Task[object]) -> Exception | None:
    """Stops a task; what its clean-up raises is returned, so that the others are stopped too."""
    try:
        task.stop()
    except Exception as fault:  # noqa: BLE001 - an author's code: whatever it raises, the robot has to stop
        return fault
    return None
