"""Robots in a world, for one trial of one skill."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from typing import Any

from skiros_py.errors import PlanningError, UsageError
from skiros_py.execution.pulse import Chore
from skiros_py.execution.runtime import Runtime, RuntimeOptions
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.thread_host import ThreadHost
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.questions import Questions
from skiros_py.skills.skill import Skill
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.world.vocabulary import ROBOT
from skiros_py.world.world import World

_LONGEST = 600.0
"""A skill that runs longer than this is cancelled [s, simulated]."""


class Rig:
    """Runs skills and goals on the robots of a cell, supervised by its watchdog.

    Args:
        runtime: The runtime.
    """

    def __init__(self, runtime: Runtime) -> None:
        self.world = runtime.world
        self._runtime = runtime
        self._cycle = runtime.cycle
        self._managers = runtime.managers
        self._looking = Chore("a contract test", interruptible=True)
        _answer(runtime.questions)

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Lets the watchdog supervise code outside the control cycle: conditions of an author.

        Raises:
            CycleOverrun: They blocked the cycle for too long.
        """
        outer = self._cycle.pulse.enter(self._looking)
        try:
            yield
        finally:
            self._cycle.pulse.leave(outer)

    def agents(self, skill: str) -> tuple[str, ...]:
        """Returns the subsystems that offer a skill."""
        return tuple(agent for agent, manager in sorted(self._managers.items()) if skill in manager.descriptions)

    def run(self, agent: str, skill: str, arguments: Mapping[str, Any]) -> Outcome:
        """Runs a skill to its end, or until it takes too long."""
        running = self._managers[agent].start(skill, arguments)
        deadline = self._runtime.context.now + _LONGEST
        in_time = self._runtime.finish(running, leave=lambda: self._runtime.context.now > deadline)
        if not in_time and not self._cycle.halted:
            running.stop()
            self._cycle.step()
            return Failure(f"it did not end within {_LONGEST:.0f} s")
        return running.result

    def reach(self, goal: Sequence[Condition]) -> bool:
        """Plans for a goal and executes the plan; returns whether the goal then holds."""
        with closing(FastDownward()) as planner, closing(ThreadHost(self.world, planner)) as planning:
            tasks = TaskManager(self.world, self._managers, planning, self._cycle)
            try:
                task = tasks.begin(goal)
                self._runtime.finish(task)
                task.result  # noqa: B018 - raises what broke it
            except (PlanningError, UsageError):
                return False
        with self.watched():
            return all(condition.evaluate(self.world) for condition in goal)


@contextmanager
def fake_rig(
    world: World,
    skills: Sequence[Skill],
    primitives: Mapping[str, type[Primitive[Any]]],
    overrun: float | None = None,
) -> Iterator[Rig]:
    """Sets up fake robots in a world.

    Args:
        world: The world.
        skills: Implementations; only those for fakes are used.
        primitives: Primitives that they call, by name.
        overrun: Wall time for which an author's code may block the cycle [s]; None for the watchdog's own limit.
    """
    spec = read_cell(world, world.instances(ROBOT), simulated=False)
    options = RuntimeOptions(overrun=overrun)
    with closing(FakeCell(spec)) as cell, Runtime(world, spec, cell, skills, primitives, options) as runtime:
        yield Rig(runtime)


def _answer(questions: Questions) -> None:
    """Answers each question with its first option."""
    questions.subscribe(lambda question: questions.answer(question.id, question.options[0], by="the contract test"))
