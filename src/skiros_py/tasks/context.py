"""The environment of tasks: the parts of the station that they use; and control requests to a running task."""

from __future__ import annotations

import enum
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.requests import Answer, Asked, PlanningHost
from skiros_py.planning.service import USUAL, Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import Questions
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.rehearsal import Cancellable, Rehearser
from skiros_py.tasks.reservations import Reservations
from skiros_py.world.vocabulary import HAS_SKILL
from skiros_py.world.world import World


class Mode(enum.Enum):
    """How a task proceeds."""

    RUN = "run"
    """Without pauses."""
    PAUSE = "pause"
    """Paused: running steps come to a standstill."""
    SINGLE = "single"
    """Until the running steps have ended; if none runs, the next ready steps start first."""


class Control:
    """The control requests for one task, from any thread. The last mode requested counts, but the first stop.

    Attributes:
        mode: The requested mode.
        stop: Why it was asked to stop; None if it was not.
    """

    def __init__(self) -> None:
        self.mode = Mode.RUN
        self.stop: str | None = None
        self._guard = threading.Lock()

    def wish(self, mode: Mode) -> None:
        """Requests another mode."""
        with self._guard:
            self.mode = mode

    def end_single(self) -> Mode:
        """Pauses after a single step, unless another mode was requested meanwhile; returns the resulting mode."""
        with self._guard:
            if self.mode is Mode.SINGLE:
                self.mode = Mode.PAUSE
            return self.mode

    def end(self, reason: str) -> None:
        """Requests a stop; the first reason counts."""
        with self._guard:
            if self.stop is None:
                self.stop = reason


class StopWanted(Exception):
    """The task was asked to stop; the text gives the reason."""


T = TypeVar("T")

_POLL = 0.0005
"""Poll interval for an answer while simulated time stands still [s]."""


@dataclass(frozen=True, slots=True)
class TaskContext:
    """The environment of tasks.

    Attributes:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: The planning service.
        cycle: The control cycle that runs the tasks.
        on_plan: Called with every new plan.
        monitor: Notified of steps that have to wait; None for no monitoring.
        questions: Where questions to the user are posted.
        reservations: Which task holds which robots and things.
        leaving: Returns True once a shutdown is requested; simulated time then continues so that it can complete.
        options: Planning options.
        lockstep: True if simulated time stands still during planning.
        rehearser: Starts rehearsals; None where there is no physics for them.
    """

    world: World
    managers: Mapping[str, SkillManager]
    planning: PlanningHost
    cycle: ControlCycle
    on_plan: Callable[[Planned], None] = lambda _planned: None
    monitor: Monitor | None = None
    questions: Questions = field(default_factory=Questions)
    reservations: Reservations = field(default_factory=Reservations)
    leaving: Callable[[], bool] = lambda: False
    options: PlanningOptions = USUAL
    lockstep: bool = True
    rehearser: Rehearser | None = None

    @property
    def now(self) -> float:
        """Run time [s]."""
        return self.cycle.board.snapshot.time

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills available according to the world model, with the agents that provide them."""
        found: dict[str, tuple[SkillDescription, list[str], list[Sequence[Condition]]]] = {}
        for agent, manager in sorted(self.managers.items()):
            registered = {self.world.element(s).label for s in self.world.objects(agent, HAS_SKILL)}
            for name, description in manager.descriptions.items():
                if name in registered:
                    _, agents, ways = found.setdefault(name, (description, [], []))
                    agents.append(agent)
                    ways += manager.alternatives[name]
        return tuple(Capability(d.under(ways), tuple(agents)) for _, (d, agents, ways) in sorted(found.items()))

    def offers(self, agent: str, skill: str) -> bool:
        """Returns True if a subsystem is present and provides a skill."""
        return agent in self.managers and self.managers[agent].offers(skill)

    # ------------------------------------------------------------------ answers of planning

    def answer(self, asked: Asked[T], control: Control) -> Execution[Answer[T]]:
        """Waits for an answer; the request is cancelled when the caller stops waiting.

        Args:
            asked: The request.
            control: Control requests of the waiting task.

        Raises:
            PlanningError: Planning failed.
        """
        return (yield from self.wait_for(asked, control))

    def wait_for(self, asked: Cancellable[T], control: Control) -> Execution[T]:
        """Waits for the result of other work, as for an answer."""
        try:
            self.wait_in_lockstep(asked, control)
            while not asked.done():
                yield
            return asked.result()
        finally:
            asked.cancel()

    def wait_in_lockstep(self, asked: Cancellable[Any], control: Control) -> None:
        """Waits for an answer while simulated time stands still, at most until the task is asked to end."""
        if self.lockstep:
            with self.cycle.activity.waiting():
                while not (asked.done() or self.cycle.halted or self.leaving() or control.stop is not None):
                    time.sleep(_POLL)
