"""The skill managers of a cell; they may come, go and die while everything runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.behaviour_run import RunnableDocument
from skiros_py.execution.claims import Claims
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.modules import Directory, Modules
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.pulse import Watched
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.ports.cell import CellSpec
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AGENT, HAS_A


def agents_of(view: WorldView, cell: CellSpec) -> tuple[str, ...]:
    """Returns who may have a skill manager: the subsystems of each robot, and devices that belong to no robot."""
    parts = [part for robot in cell.robots for part in view.objects(robot.id, HAS_A)]
    single = [device.id for group in cell.single for device in group.devices]
    return tuple(e for e in (*parts, *single) if view.ontology.is_a(view.element(e).type, AGENT))


class Managers(Mapping[str, SkillManager]):
    """The skill managers that are there, by the id of their subsystem.

    Args:
        skills: All skills found.
        primitives: All primitives found, by name.
        context: World, devices, adapters.
        cycle: Runs everything.
        monitor: Takes module events.
        driver: Kind of cell driver.
        config: Values of configuration parameters by "module.key".

    Attributes:
        documents: Documents that every manager runs as modules, by name: what is put here runs from its next start on.
    """

    def __init__(
        self,
        skills: Sequence[Skill],
        primitives: Mapping[str, type[Primitive[Any]]],
        context: RunContext,
        cycle: ControlCycle,
        monitor: Monitor,
        *,
        driver: str,
        config: Mapping[str, Any] | None = None,
    ) -> None:
        self.claims = Claims()
        self._skills = skills
        self._primitives = primitives
        self._context = context
        self._cycle = cycle
        self._monitor = monitor
        self._driver = driver
        self._config = config or {}
        self.documents: dict[str, RunnableDocument] = {}
        self._watches = Watches(context.world)
        self._directory: Directory[Modules] = Directory(context.world)
        self._watching = False
        self._managers: dict[str, SkillManager] = {}
        self._seen: set[str] = set()

    def __getitem__(self, agent: str) -> SkillManager:
        return self._managers[agent]

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._managers))

    def __len__(self) -> int:
        return len(self._managers)

    def open_all(self) -> None:
        """Opens one manager for each subsystem of each robot, and for each device without a robot that acts."""
        for agent in agents_of(self._context.world, self._context.cell):
            self.open(agent)

    def open(self, agent: str) -> SkillManager:
        """Opens the skill manager of a subsystem and registers what it can do; in the place of one that was lost.

        Raises:
            UnknownName: There is no such element.
            UsageError: It is there already, or the element is no subsystem that could have one.
        """
        view = self._context.world
        if agent in self._managers and not self._managers[agent].lost:
            raise UsageError(f"the skill manager of {agent} is there already")
        if not view.ontology.is_a(view.element(agent).type, AGENT):
            raise UsageError(f"{agent} is a {view.element(agent).type}, and only an {AGENT} has a skill manager")
        if agent in self._managers:
            self.close(agent)
        manager = SkillManager(
            agent,
            self._skills,
            self._primitives,
            self._context,
            self._cycle,
            self._monitor,
            driver=self._driver,
            claims=self.claims,
            watches=self._watches,
            directory=self._directory,
            config=self._config,
            documents=self.documents,
        )
        manager.register(adopt=agent not in self._seen)
        self._seen.add(agent)
        self._managers[agent] = manager
        if self._watching and not self._cycle.halted:
            manager.watch()
        return manager

    def close(self, agent: str) -> None:
        """Stops what a manager runs, and lets it go.

        Raises:
            UnknownName: There is none for this subsystem.
        """
        if agent not in self._managers:
            raise UnknownName("skill manager", agent, self._managers)
        self._managers.pop(agent).retire()

    def watch(self) -> None:
        """Starts what runs in the background of each, and of those that come; once more after everything was halted."""
        self._watching = True
        for manager in self._managers.values():
            manager.watch()

    def lose(self, task: Watched) -> None:
        """Gives up the manager whose task does not come back; for the watchdog's thread."""
        for manager in tuple(self._managers.values()):
            if manager.runs(task):
                manager.lose(f"{task.name} does not come back")

    def who_runs(self, module: str) -> SkillManager:
        """Returns the first manager, by id, that can run a module; one that is lost only where there is no other.

        Raises:
            UnknownName: None can.
        """
        able = [manager for _, manager in sorted(self._managers.items()) if module in manager.modules]
        if able:
            return min(able, key=lambda manager: bool(manager.lost))
        known = {name for manager in self._managers.values() for name in manager.modules}
        raise UnknownName("module", module, known)
