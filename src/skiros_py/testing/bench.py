"""A bench: a world on a fake cell with skill managers and a task manager, without scene file or plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import ModuleEvent, Monitor
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.planning.fast_downward import FastDownward
from skiros_py.planning.planner import Planner
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.robot.devices import DeviceBoard
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition, ConditionType
from skiros_py.skills.context import Libraries, RunContext
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.tasks.goals import parse_goal
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.testing.tiny_skills import CONDITIONS, SKILLS
from skiros_py.world.vocabulary import AGENT, HAS_A, ROBOT
from skiros_py.world.world import World

__all__ = ["Bench"]


class Bench:
    """Runs skills and goals on a fake robot. Use it in a ``with``.

    Args:
        world: The world, such as :func:`skiros_py.testing.tiny_world`.
        skills: Implementations for the fake driver; the tiny domain's where left out.
        primitives: Primitives that the skills' bodies name.
        robots: Ids of the robots that get skill managers; None for all.
        conditions: Words of goals.
        planner: Plans; Fast Downward where left out.
        attempts: How often a skill may fail on one target.

    Attributes:
        events: Every module event so far.
        plans: Every plan so far.
    """

    def __init__(
        self,
        world: World,
        skills: Sequence[Skill] = SKILLS,
        primitives: Sequence[type[Primitive[Any]]] = (),
        *,
        robots: Sequence[str] | None = None,
        conditions: Mapping[str, ConditionType] = CONDITIONS,
        planner: Planner | None = None,
        attempts: int = 3,
    ) -> None:
        self.world = world
        self.events: list[ModuleEvent] = []
        self.plans: list[Planned] = []
        self._conditions = conditions
        spec = read_cell(world, world.instances(ROBOT) if robots is None else robots)
        board = DeviceBoard(FakeCell(spec))
        world.clock = lambda: board.snapshot.time
        self.cycle = ControlCycle(board)
        self.monitor = Monitor()
        self.monitor.subscribe(self.events.append)
        self.context = RunContext(
            world, board, Libraries(), spec, np.random.default_rng(0), lockstep=True, report=lambda _m, _c, _t: None
        )
        named = {primitive.name: primitive for primitive in primitives}
        agents = [a for robot in spec.robots for a in world.objects(robot.id, HAS_A) if _is_agent(world, a)]
        self.managers = {
            agent: SkillManager(agent, skills, named, self.context, self.cycle, self.monitor, driver="fake")
            for agent in agents
        }
        for manager in self.managers.values():
            manager.register()
        self._planner = planner or FastDownward()
        planning = PlanningService(self._planner, "bench")
        self.tasks = TaskManager(
            world, self.managers, planning, self.cycle, on_plan=self.plans.append, attempts=attempts
        )

    def goal(self, *texts: str) -> tuple[Condition, ...]:
        """Reads goal texts."""
        return parse_goal(texts, self.world, self._conditions)

    def plan(self, *texts: str) -> Planned:
        """Plans for a goal without doing anything."""
        return self.cycle.run(self.cycle.start(self.tasks.plan(self.goal(*texts))))

    def pursue(self, *texts: str) -> GoalReport:
        """Pursues a goal to its end."""
        return self.cycle.run(self.cycle.start(self.tasks.pursue(self.goal(*texts))))

    def run(self, skill: str, *, break_off: Callable[[], str] = lambda: "", **arguments: str) -> Outcome:
        """Runs one skill by the first manager that offers it.

        Args:
            skill: Its name.
            break_off: Asked in every cycle for a reason to break the skill off.
            **arguments: Element ids by parameter key.
        """
        manager = next(m for _, m in sorted(self.managers.items()) if skill in m.descriptions)
        running = manager.start(skill, arguments)
        while not running.done:
            reason = break_off()
            if reason:
                running.break_off(reason)
            self.cycle.step()
        return running.result

    def close(self) -> None:
        """Ends the planner."""
        self._planner.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _is_agent(world: World, element: str) -> bool:
    return world.ontology.is_a(world.element(element).type, AGENT)
