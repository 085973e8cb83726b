"""What tasks are done with: everything of the station that they reach."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.requests import Answer, Asked, PlanningHost
from skiros_py.planning.service import USUAL, Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.skills.primitive import Execution
from skiros_py.skills.questions import Questions
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.control import Control
from skiros_py.tasks.reservations import Reservations
from skiros_py.world.vocabulary import HAS_SKILL
from skiros_py.world.world import World

T = TypeVar("T")

_POLL = 0.0005
"""Time between two looks for an answer while simulated time stands still [s]."""


@dataclass(frozen=True, slots=True)
class TaskContext:
    """What tasks are done with.

    Attributes:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: Where it is planned.
        cycle: Runs everything.
        on_plan: Told of every new plan.
        monitor: Hears of steps that have to wait; None where nobody listens.
        questions: Where a person is asked.
        reservations: Which task has which robots and things.
        leaving: Tells whether a stop is wanted: then simulated time goes on, for the stop to happen.
        options: How to plan.
        lockstep: True where simulated time stands still while it is planned.
    """

    world: World
    managers: Mapping[str, Transport]
    planning: PlanningHost
    cycle: ControlCycle
    on_plan: Callable[[Planned], None] = lambda _planned: None
    monitor: Monitor | None = None
    questions: Questions = field(default_factory=Questions)
    reservations: Reservations = field(default_factory=Reservations)
    leaving: Callable[[], bool] = lambda: False
    options: PlanningOptions = USUAL
    lockstep: bool = True

    @property
    def now(self) -> float:
        """Run time [s]."""
        return self.cycle.board.snapshot.time

    @property
    def capabilities(self) -> tuple[Capability, ...]:
        """The skills that the world model says are there, with who has them."""
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
        """Tells whether a subsystem is there and has a skill."""
        return agent in self.managers and skill in self.managers[agent].descriptions

    # ------------------------------------------------------------------ answers of planning

    def answer(self, asked: Asked[T], control: Control) -> Execution[Answer[T]]:
        """Waits for an answer, which is cancelled when it is no longer waited for.

        Args:
            asked: The request.
            control: What people want of the task that waits.

        Raises:
            PlanningError: It broke.
        """
        try:
            self.wait_in_lockstep(asked, control)
            while not asked.done():
                yield
            return asked.result()
        finally:
            asked.cancel()

    def wait_in_lockstep(self, asked: Asked[T], control: Control) -> None:
        """Waits for an answer where simulated time stands still meanwhile; only until the task shall end."""
        if self.lockstep:
            with self.cycle.pulse.waiting():
                while not (asked.done() or self.cycle.halted or self.leaving() or control.stop is not None):
                    time.sleep(_POLL)
