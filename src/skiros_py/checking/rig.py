"""A fake robot in a world, for one trial of one skill."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from typing import Any

import numpy as np

from skiros_py.errors import PlanningError, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.managers import Managers
from skiros_py.execution.monitor import Monitor
from skiros_py.planning.fast_downward import FastDownward
from skiros_py.planning.service import PlanningService
from skiros_py.robot.devices import DeviceBoard
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import Libraries, RunContext
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.questions import Questions
from skiros_py.skills.sensing import BoardSensors
from skiros_py.skills.skill import Skill
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.world.vocabulary import ROBOT
from skiros_py.world.world import World

__all__ = ["Rig"]

_LONGEST = 600.0
"""A skill that runs longer than this on a fake is broken off [s, simulated]."""


class Rig:
    """Runs skills and goals on fake robots in a world.

    Args:
        world: The world.
        skills: Implementations; those for fakes are taken.
        primitives: Primitives that they call, by name.
    """

    def __init__(self, world: World, skills: Sequence[Skill], primitives: Mapping[str, type[Primitive[Any]]]) -> None:
        self.world = world
        spec = read_cell(world, world.instances(ROBOT))
        self._board = DeviceBoard(FakeCell(spec))
        world.clock = lambda: self._board.snapshot.time
        world.sensors = BoardSensors(self._board)
        self._cycle = ControlCycle(self._board)
        context = RunContext(
            world,
            self._board,
            Libraries(),
            spec,
            np.random.default_rng(0),
            lockstep=True,
            report=lambda _module, _code, _text: None,
            clock=self._board,
            questions=_answered(),
        )
        self._managers = Managers(skills, primitives, context, self._cycle, Monitor(), driver="fake")
        self._managers.open_all([robot.id for robot in spec.robots])

    def agents(self, skill: str) -> tuple[str, ...]:
        """Returns the subsystems that offer a skill."""
        return tuple(agent for agent, manager in sorted(self._managers.items()) if skill in manager.descriptions)

    def run(self, agent: str, skill: str, arguments: Mapping[str, Any]) -> Outcome:
        """Runs a skill to its end, or until it takes too long."""
        running = self._managers[agent].start(skill, arguments)
        deadline = self._board.snapshot.time + _LONGEST
        while not running.done:
            if self._board.snapshot.time > deadline:
                running.stop()
                self._cycle.step()
                return Failure(f"it did not end within {_LONGEST:.0f} s")
            self._cycle.step()
        return running.result

    def reach(self, goal: Sequence[Condition]) -> bool:
        """Plans for a goal and does it; tells whether it holds then."""
        with closing(FastDownward()) as planner:
            tasks = TaskManager(self.world, self._managers, PlanningService(planner, "contract"), self._cycle)
            try:
                self._cycle.run(self._cycle.start(tasks.pursue(goal), "the contract test's goal"))
            except (PlanningError, UsageError):
                return False
        return all(condition.evaluate(self.world) for condition in goal)


def _answered() -> Questions:
    """Returns questions to a person who always takes the first option."""
    questions = Questions()
    questions.subscribe(lambda question: questions.answer(question.id, question.options[0], by="the contract test"))
    return questions
