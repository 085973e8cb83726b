"""What tasks are done with: everything of the station that they reach."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.skill_manager import Transport
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.skills.conditions import Condition
from skiros_py.skills.questions import Questions
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.reservations import Reservations
from skiros_py.tasks.turn import Turn
from skiros_py.world.vocabulary import HAS_SKILL
from skiros_py.world.world import World

__all__ = ["TaskContext"]


@dataclass(frozen=True, slots=True)
class TaskContext:
    """What tasks are done with.

    Attributes:
        world: The live world model.
        managers: Skill managers by agent id.
        planning: Plans.
        cycle: Runs everything.
        on_plan: Told of every new plan.
        monitor: Hears of steps that have to wait; None where nobody listens.
        questions: Where a person is asked.
        reservations: Which task has which robots and things.
        turn: Which task works at this moment.
    """

    world: World
    managers: Mapping[str, Transport]
    planning: PlanningService
    cycle: ControlCycle
    on_plan: Callable[[Planned], None] = lambda _planned: None
    monitor: Monitor | None = None
    questions: Questions = field(default_factory=Questions)
    reservations: Reservations = field(default_factory=Reservations)
    turn: Turn = field(default_factory=Turn)

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
