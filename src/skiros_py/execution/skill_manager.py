"""A skill manager: what one subsystem of a robot (a base, an arm) can do (paper §3.3).

It is reached through a small interface of plain data, so that it may one day live in another process or host.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from skiros_py.errors import UnknownName
from skiros_py.execution.cycle import ControlCycle, Task
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.execution.skill_run import SkillRun
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.vocabulary import HAS_A, HAS_SKILL, SKILL

__all__ = ["Running", "RunningSkill", "SkillManager", "Transport"]


class Running(Protocol):
    """A skill that was started, wherever it runs."""

    @property
    def done(self) -> bool:
        """True when it ended or was stopped."""
        ...

    @property
    def result(self) -> Outcome:
        """How it ended by itself."""
        ...

    def break_off(self, reason: str) -> None:
        """Ends it because the world changed; it still does what must follow, such as stowing the arm."""
        ...

    def stop(self) -> None:
        """Stops it in this cycle; nothing follows."""
        ...


class RunningSkill:
    """A skill that runs in this process's control cycle."""

    def __init__(self, run: SkillRun, task: Task[Outcome]) -> None:
        self._run = run
        self._task = task

    @property
    def done(self) -> bool:
        """True when it ended or was stopped."""
        return self._task.done

    @property
    def result(self) -> Outcome:
        """How it ended by itself."""
        return self._task.result

    def break_off(self, reason: str) -> None:
        """Ends it because the world changed; it still does what must follow, such as stowing the arm."""
        self._run.break_off(reason)

    def stop(self) -> None:
        """Stops it in this cycle; nothing follows."""
        self._task.stop()


class Transport(Protocol):
    """How a task manager reaches a skill manager, wherever it lives."""

    @property
    def agent(self) -> str:
        """Id of the subsystem."""
        ...

    @property
    def descriptions(self) -> Mapping[str, SkillDescription]:
        """What it offers, by name."""
        ...

    def start(self, skill: str, arguments: Mapping[str, str]) -> Running:
        """Starts a skill."""
        ...


class SkillManager:
    """Offers the skills that fit one subsystem and runs them in the control cycle.

    Args:
        agent: Id of the subsystem.
        skills: All skills found; those for its class and its driver are taken.
        primitives: All primitives found, by name.
        context: World, devices, libraries.
        cycle: Runs everything.
        monitor: Takes module events.
        driver: Kind of cell driver; a fake one gets the implementations that only pretend.
    """

    def __init__(
        self,
        agent: str,
        skills: Sequence[Skill],
        primitives: Mapping[str, type[Primitive[Any]]],
        context: RunContext,
        cycle: ControlCycle,
        monitor: Monitor,
        *,
        driver: str,
    ) -> None:
        self.agent = agent
        self._primitives = primitives
        self._context = context
        self._cycle = cycle
        self._monitor = monitor
        self._skills = _choose(skills, context, agent, driver)

    @property
    def descriptions(self) -> Mapping[str, SkillDescription]:
        """What it offers, by name."""
        return {name: skill.description for name, skill in self._skills.items()}

    def register(self) -> None:
        """Writes what it can do into the world model, where planners and people find it."""
        if not self._skills:
            return
        with self._context.world.transaction(author=f"skill manager {self.agent}", reason="registers its skills") as tx:
            for name in sorted(self._skills):
                skill = tx.add(SKILL, label=name)
                tx.relate(self.agent, HAS_SKILL, skill)

    def watch(self) -> None:
        """Starts the primitives that watch this subsystem's devices in the background."""
        view = self._context.world
        for name, primitive in sorted(self._primitives.items()):
            for device in view.objects(self.agent, HAS_A) if primitive.watches else ():
                if view.ontology.is_a(view.element(device).type, primitive.watches or ""):
                    report = self._reporter(name)
                    watcher = primitive(replace(self._context, report=report), primitive.Params(device=device))
                    self._cycle.start(watcher.execute())

    def _reporter(self, primitive: str) -> Callable[[str, int, str], None]:
        def report(_module: str, code: int, text: str) -> None:
            event = ModuleEvent(self._context.now, "primitive", primitive, Status.RUNNING, code, text)
            self._monitor.publish(event)

        return report

    def start(self, skill: str, arguments: Mapping[str, str]) -> RunningSkill:
        """Starts a skill.

        Raises:
            UnknownName: It does not offer that skill.
        """
        if skill not in self._skills:
            raise UnknownName("skill", skill, self._skills, where=f"of {self.agent}")
        run = SkillRun(self._skills[skill], arguments, self._context, self._primitives, self._monitor)
        return RunningSkill(run, self._cycle.start(run.execute()))


def _choose(skills: Sequence[Skill], context: RunContext, agent: str, driver: str) -> dict[str, Skill]:
    """Takes one implementation of each description that fits the subsystem."""
    view = context.world
    chosen: dict[str, Skill] = {}
    for skill in skills:
        wanted = skill.driver == driver if driver == "fake" else skill.driver is None
        class_ = skill.description.agent_class
        if wanted and view.ontology.is_a(view.element(agent).type, class_):
            chosen.setdefault(skill.description.name, skill)
    return chosen
