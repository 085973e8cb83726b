"""A planner that is a program: a private folder for each call, limits, and everything killed on cancel."""

from __future__ import annotations

import tempfile
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from threading import Event

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Answer
from skiros_py.planning.planners.programs import USUAL_LIMITS, Child, Ended, Limits, Running, run_program

DOMAIN, PROBLEM = "domain.pddl", "problem.pddl"
"""Names of the files in the folder of a call."""


class Solving:
    """One running call.

    Attributes:
        latency: Declared time from request to answer [s].
    """

    latency = 0.0

    def __init__(self, title: str, future: Future[Answer], stop: Event) -> None:
        self._title = title
        self._future = future
        self._stop = stop

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""
        return self._future.done()

    def result(self) -> Answer:
        """Waits for the answer.

        Raises:
            PlanningError: The planner failed or was stopped.
        """
        try:
            return self._future.result()
        except CancelledError as error:
            raise PlanningError(f"{self._title} was stopped") from error

    def cancel(self) -> None:
        """Kills it, at the latest a moment later; does nothing when it has ended."""
        self._stop.set()
        self._future.cancel()


class ProgramPlanner(ABC):
    """The common base of planners that are programs.

    Args:
        limits: Resource limits of each call; a safeguard, not a means of control.

    Attributes:
        name: The name by which users select it.
        title: Its name in messages.
        supports: The PDDL requirements it supports.
        is_alone: True if it is known to start no programs that leave its process group.
        limits: Resource limits of each call.
    """

    name: str
    title: str
    supports: frozenset[str]
    is_alone = False

    def __init__(self, limits: Limits = USUAL_LIMITS) -> None:
        self.limits = limits
        self._threads = ThreadPoolExecutor(thread_name_prefix=self.name)
        self._closed = False

    @abstractmethod
    def start(self, folder: Path, environment: Mapping[str, str]) -> Running:
        """Starts the program in a folder.

        Raises:
            PlanningError: It cannot be started.
        """

    @abstractmethod
    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the answer of a program that has ended.

        Raises:
            PlanningError: It has none.
        """

    def prepare(self, folder: Path) -> None:  # noqa: B027 - most programs need no more than the two files
        """Puts further files the program needs into its folder."""

    def solve(self, domain: str, problem: str) -> Solving:
        """Starts solving; several calls may be under way at once.

        Raises:
            PlanningError: The planner is closed.
        """
        if self._closed:
            raise PlanningError(f"{self.title} was stopped")
        stop = Event()
        try:
            future = self._threads.submit(self._solve, domain, problem, stop)
        except RuntimeError as error:  # closed concurrently by another thread
            raise PlanningError(f"{self.title} was stopped") from error
        return Solving(self.title, future, stop)

    def close(self) -> None:
        """Kills running calls and waits for them; may be called twice."""
        self._closed = True
        self._threads.shutdown(wait=True, cancel_futures=True)

    def _solve(self, domain: str, problem: str, stop: Event) -> Answer:
        try:
            with tempfile.TemporaryDirectory(prefix="skiros-plan-", ignore_cleanup_errors=True) as name:
                return self._solve_in(Path(name), domain, problem, stop)
        except OSError as error:
            raise PlanningError(f"{self.title}: {error}") from error

    def _solve_in(self, folder: Path, domain: str, problem: str, stop: Event) -> Answer:
        (folder / DOMAIN).write_text(domain, encoding="utf-8")
        (folder / PROBLEM).write_text(problem, encoding="utf-8")
        self.prepare(folder)
        start = partial(self.start, folder)
        ended = run_program(
            self.title, start, self.limits, lambda: self._closed or stop.is_set(), is_alone=self.is_alone
        )
        return self.read(ended, folder)


class CommandLinePlanner(ProgramPlanner):
    """A planner that is one command line."""

    @abstractmethod
    def command(self, domain: str, problem: str) -> Sequence[str]:
        """Returns the command line for two files in the folder where it will run."""

    def start(self, folder: Path, environment: Mapping[str, str]) -> Child:
        """Starts the program in a folder."""
        return Child(self.title, self.command(DOMAIN, PROBLEM), folder, self.limits, environment)
