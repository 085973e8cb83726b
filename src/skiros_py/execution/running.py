"""A module that was started: its handle."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Protocol

from skiros_py.errors import UsageError
from skiros_py.execution.scope import Scope
from skiros_py.execution.task import Task
from skiros_py.skills.outcome import BROKEN, Failure, Outcome


class Running(Protocol):
    """A module that was started, wherever it runs."""

    @property
    def id(self) -> str:
        """Id of this run."""
        ...

    @property
    def done(self) -> bool:
        """True when it ended, or when it was stopped and all it moved stands."""
        ...

    @property
    def result(self) -> Outcome:
        """How it ended."""
        ...

    @property
    def account(self) -> Mapping[str, Any]:
        """What it was run with, what was found of its conditions, and what it changed, as plain data.

        ``inputs``: values by parameter key; ``conditions``: what was found last of each one that was looked at;
        ``implementation``: of a skill, the label of the way that was tried last; ``changes``: numbers of its changes
        of the world.
        """
        ...

    def break_off(self, reason: str) -> None:
        """Cancels it because the world changed; finishing motion, such as stowing the arm, still runs."""
        ...

    def pause(self) -> None:
        """Lets it come to a standstill where it is."""
        ...

    def resume(self) -> None:
        """Goes on after a pause."""
        ...

    def step(self) -> None:
        """Lets it do one cycle while it is paused."""
        ...

    def stop(self) -> None:
        """Stops it in this cycle; nothing follows."""
        ...


class RunningModule:
    """A module that runs in this process's control cycle.

    Args:
        name: The module.
        id: Id of this run.
        task: Its task.
        scope: Its outermost scope; its devices are kept until all stands.
        break_off: Ends it so that what must follow is still done; None for what can only be stopped.
        arguments: Its parameters; those that are inferred come in the first cycle.
        account: Gives what it was run with and what was found of its conditions; None where it has none.

    Attributes:
        changes: Numbers of its changes of the world; filled in by its skill manager.
    """

    def __init__(
        self,
        name: str,
        id: str,  # noqa: A002 - as in module events
        task: Task[Outcome],
        scope: Scope,
        break_off: Callable[[str], None] | None = None,
        *,
        arguments: Mapping[str, Any] = MappingProxyType({}),
        account: Callable[[], Mapping[str, Any]] | None = None,
    ) -> None:
        self.name = name
        self.id = id
        self.task = task
        self.scope = scope
        self.arguments = arguments
        self.changes: list[int] = []
        self._break_off = break_off
        self._account = account

    @property
    def breakpoints(self) -> set[str]:
        """Paths of nodes before which it is paused (``pick/body/1``); they may be changed while it runs."""
        return self.scope.breakpoints

    @property
    def account(self) -> Mapping[str, Any]:
        """What it was run with, what was found of its conditions, and what it changed, as plain data."""
        said = self._account() if self._account is not None else {"inputs": dict(self.arguments), "conditions": []}
        return {**said, "changes": list(self.changes)}

    @property
    def done(self) -> bool:
        """True when it ended, or when it was stopped and all it moved stands."""
        return self.task.done and not self.task.stopping

    @property
    def status(self) -> str:
        """One of "running", "paused", "stopping", "stopped", "ended"."""
        task = self.task
        if task.stopping:
            return "stopping"
        if task.done:
            return "stopped" if task.stopped else "ended"
        return "paused" if task.paused else "running"

    @property
    def result(self) -> Outcome:
        """How it ended; a module that was stopped, or broke, has failed.

        Raises:
            UsageError: It still runs.
        """
        task = self.task
        if not task.done:
            raise UsageError(f"{self.name} still runs")
        if task.fault is not None:
            return Failure(f"{self.name} broke: {task.fault}", BROKEN)
        if task.stopped or task.stopping:
            return Failure(f"{self.name} was stopped{': ' + task.reason if task.reason else ''}")
        return task.result

    def break_off(self, reason: str) -> None:
        """Cancels it because the world changed; finishing motion, such as stowing the arm, still runs."""
        if self._break_off is None:
            self.task.stop(reason)
        else:
            self._break_off(reason)
            self.task.resume()  # what was paused must be able to end

    def pause(self) -> None:
        """Lets it come to a standstill where it is; its devices stay its own."""
        self.task.pause()

    def resume(self) -> None:
        """Goes on after a pause."""
        self.task.resume()

    def step(self) -> None:
        """Lets it do one cycle while it is paused."""
        self.task.step()

    def stop(self) -> None:
        """Stops it in this cycle; nothing follows. It is done when all it moved stands."""
        self.task.stop()
