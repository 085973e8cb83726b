"""A skill manager: what one subsystem of a robot (a base, an arm) can do (paper §3.3).

It is reached through a small interface of plain data, so that it may one day live in another process or host.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from skiros_py.errors import UnknownName, UsageError
from skiros_py.execution.claims import pieces
from skiros_py.execution.modules import CellModules, ModuleInfo, Modules
from skiros_py.execution.monitor import Status
from skiros_py.execution.panel import Panel, primitive_panel, skill_panel
from skiros_py.execution.registration import Registration
from skiros_py.execution.running import RunnableDocument, Running, RunningModule
from skiros_py.execution.scope import Scope
from skiros_py.execution.skill_run import SkillRun
from skiros_py.execution.task import RunClock, Task
from skiros_py.interruptions import Watched
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure, Outcome
from skiros_py.skills.parameters import Kind, params_of
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.skills.surroundings import owner
from skiros_py.world.change import Change
from skiros_py.world.vocabulary import HAS_A

_PATIENCE = 1.0
"""For how long a write is waited for when a manager is lost [s]."""
_MOST_CHANGES = 1000
"""Changes of which it is kept that one run of a module made them."""


class Transport(Protocol):
    """How a task manager reaches a skill manager, wherever it lives."""

    @property
    def agent(self) -> str:
        """Id of the subsystem."""

    @property
    def descriptions(self) -> Mapping[str, SkillDescription]:
        """The skills it offers, by name; none when it is lost."""

    @property
    def alternatives(self) -> Mapping[str, Sequence[Sequence[Condition]]]:
        """What each implementation of a skill asks for besides what the description does, by the skill's name."""

    @property
    def running(self) -> Mapping[str, Running]:
        """What runs now, by name."""

    def start(self, module: str, arguments: Mapping[str, Any], *, task: str = "", parent: str = "") -> Running:
        """Starts a module.

        Args:
            module: Its name.
            arguments: Its parameters.
            task: Name of the task that it is done for; empty for none.
            parent: Id of what it is part of, such as a step of a plan; empty for none.

        Raises:
            UsageError: It cannot be started now.
        """


class SkillManager:
    """Offers the modules that fit one subsystem and runs them in the control cycle.

    The same module runs once at a time, different ones at the same time, as far as their devices allow.

    Args:
        agent: Id of the subsystem.
        cell: What all skill managers share; of its skills those are taken that are for this class and driver.

    Attributes:
        agent: Id of the subsystem.
        lost: Why it is lost; empty while it is there.
    """

    def __init__(self, agent: str, cell: CellModules) -> None:
        self.agent = agent
        self.lost = ""
        self._cell = cell
        self._context = cell.context
        self._cycle = cell.cycle
        self._modules = cell.offers[agent] = Modules(
            agent, _choose(cell.skills, cell.context, agent, cell.driver), cell
        )
        self._running: dict[str, RunningModule] = {}
        self._watching: dict[str, Task[Outcome]] = {}
        self._registration = Registration(cell.context.world, agent)
        self._leave_cycle = cell.cycle.observe(self._attend)
        self._leave_world = cell.context.world.subscribe(self._note_change)
        self._retired = False

    # ------------------------------------------------------------------ what it offers

    @property
    def descriptions(self) -> Mapping[str, SkillDescription]:
        """The skills it offers, by name; none when it is lost."""
        return {} if self.lost else {name: ways[0].description for name, ways in self._modules.skills.items()}

    @property
    def alternatives(self) -> Mapping[str, Sequence[Sequence[Condition]]]:
        """What each implementation of a skill asks for besides what the description does, by the skill's name."""
        return {name: [way.when for way in ways] for name, ways in self._modules.skills.items()}

    @property
    def modules(self) -> tuple[str, ...]:
        """Names of all modules it can run: its skills, and the primitives whose hardware it has."""
        fitting = [name for name in sorted(self._modules.primitives) if self._has_hardware_for(name)]
        return (*sorted(self._modules.skills), *fitting)

    def info(self, module: str) -> ModuleInfo:
        """Describes one module.

        Raises:
            UnknownName: There is no such module.
        """
        return self._modules.info(module)

    def implementations(self, skill: str) -> Sequence[Skill]:
        """Returns the ways of doing a skill, in the order in which they are tried.

        Raises:
            UnknownName: It does not offer that skill.
        """
        if skill not in self._modules.skills:
            raise UnknownName("skill", skill, self._modules.skills, where=f"of {self.agent}")
        return self._modules.skills[skill]

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the documents that run as modules, by any manager."""
        return () if self.lost else tuple(sorted(self._modules.documents))

    def document(self, module: str) -> RunnableDocument | None:
        """Returns the document that a module runs; None for skills and primitives."""
        return self._modules.documents.get(module)

    def panel(self, module: str, given: Mapping[str, Any]) -> Panel:
        """Tells what a module would be run with now, and which of its conditions hold.

        Raises:
            UnknownName: There is no such module.
            UsageError: Something is wrong with what is given.
        """
        info, world = self.info(module), self._context.world
        if info.kind != "skill":
            return primitive_panel(info.params, given, world, self.agent)
        return skill_panel(self._modules.skills[module][0].description, given, world, self.agent)

    def _has_hardware_for(self, primitive: str) -> bool:
        cls, view = self._modules.primitives[primitive], self._context.world
        if cls.watches is not None:
            return False
        there = [view.element(e).type for e in pieces(view, self.agent)]
        wanted = [p.element_class for p in params_of(cls.Params) if p.kind is Kind.HARDWARE]
        return all(any(view.ontology.is_a(type_, class_) for type_ in there) for class_ in wanted)

    # ------------------------------------------------------------------ coming and going

    def register(self, *, adopt: bool = False) -> None:
        """Writes what it can do into the world model, where planners and people find it.

        Args:
            adopt: True for the first manager of its subsystem: what is written already was left by another program.
        """
        self._registration.write((self.info(name) for name in self.modules), adopt=adopt)

    def retire(self) -> None:
        """Stops what runs, ends its watching, and takes back what it wrote about itself into the world model.

        It starts nothing any more. What it has stopped keeps its devices until it stands.
        """
        self._retired = True
        self.lost = self.lost or "it was let go"
        self._withdraw_offer()
        self.stop()
        for task in self._watching.values():
            task.stop("its skill manager goes")
        self._registration.withdraw("goes")

    def lose(self, reason: str) -> None:
        """Marks it as lost: its skills are no longer offered. For any thread; everything else goes on.

        A lost module may hold the world's write lock: then its skills leave the world model when the lock is released.
        """
        if self.lost:
            return
        self.lost = reason
        self._withdraw_offer()
        leaving = threading.Thread(
            target=self._registration.withdraw,
            args=(f"is lost: {reason}",),
            name=f"skiros-leaving-{self.agent}",
            daemon=True,
        )
        leaving.start()
        leaving.join(_PATIENCE)

    def watch(self) -> None:
        """Starts the primitives that watch this subsystem's devices in the background, as far as they do not run.

        Each runs at most once for each device of its class.
        """
        self._watching = {name: task for name, task in self._watching.items() if not task.done}
        for primitive, device in self._watched():
            name = f"{primitive} of {device}"
            if name not in self._watching:
                run = self._modules.run(primitive, {"device": device}, self._scope(name))
                self._watching[name] = self._cycle.start(run, name=name)

    def _watched(self) -> Iterator[tuple[str, str]]:
        view = self._context.world
        for name, primitive in sorted(self._modules.primitives.items()):
            for device in view.objects(self.agent, HAS_A) if primitive.watches else ():
                if view.ontology.is_a(view.element(device).type, primitive.watches or ""):
                    yield name, device

    def _withdraw_offer(self) -> None:
        if self._cell.offers.get(self.agent) is self._modules:
            del self._cell.offers[self.agent]

    # ------------------------------------------------------------------ running

    @property
    def running(self) -> Mapping[str, RunningModule]:
        """What runs now, by name."""
        return dict(self._running)

    def runs(self, task: Watched) -> bool:
        """Tells whether a task is of one of its modules, or of what it runs in the background."""
        own = (*self._watching.copy().values(), *(running.task for running in self.running.values()))
        return any(one is task for one in own)

    def start(self, module: str, arguments: Mapping[str, Any], *, task: str = "", parent: str = "") -> RunningModule:
        """Starts a module.

        Parameters that are left out are inferred in the first cycle; what is wrong with them is the run's failure.

        Args:
            module: Its name.
            arguments: Its parameters.
            task: Name of the task that it is done for; empty for none.
            parent: Id of what it is part of, such as a step of a plan; empty for none.

        Raises:
            UnknownName: It does not offer that module.
            UsageError: The module runs already, the manager is lost, or everything was stopped and not reset.
        """
        if self.lost:
            raise UsageError(f"the skill manager of {self.agent} is lost: {self.lost}")
        if module in self._running:
            raise UsageError(f"{module} of {self.agent} is running already: wait for its end, or stop it")
        kind = self._modules.kind(module)
        self._modules.prepare(module, self._context)
        clock, run_id = RunClock(self._cycle.board), self._cell.monitor.new_id()
        scope = replace(
            self._scope(module),
            context=replace(self._context, clock=clock),
            task=task,
            id=parent,
            root=parent or run_id,
        )
        cancel, account = None, None
        if kind == "skill":
            skill = SkillRun(self._modules.skills[module], arguments, scope, self._modules.take, run_id)
            run, arguments, cancel, account = skill.execute(), skill.arguments, skill.cancel, skill.account
        else:
            run = self._modules.run(module, arguments, scope, run_id)
        task_of_run = self._cycle.start(run, name=f"{module} of {self.agent}", clock=clock)
        started = RunningModule(module, run_id, task_of_run, scope, cancel, arguments=arguments, account=account)
        self._running[module] = started
        return started

    def stop(self) -> None:
        """Stops everything it runs, in this cycle."""
        for running in list(self._running.values()):
            running.stop()

    def reset(self, module: str) -> None:
        """Makes a module fit to run again after a fault.

        Raises:
            UnknownName: It does not offer that module.
            UsageError: The module runs.
        """
        self._modules.kind(module)
        if module in self._running:
            raise UsageError(f"{module} of {self.agent} is running: stop it first")
        self._modules.reset(module, self._context)

    def _scope(self, name: str) -> Scope:
        cell = self._cell
        return Scope(cell.context, self._modules, cell.watches, cell.monitor, self.agent, path=name)

    def _attend(self) -> None:
        """Removes ended runs at the end of each cycle; reports stopped ones when their devices stand."""
        for name, running in list(self._running.items()):
            if running.done:
                del self._running[name]
                for unfinished in running.scope.unfinished:
                    unfinished.claim.release()
                if running.status == "stopped" or running.task.fault is not None:
                    self._report_stopped(running)
        if self._retired and not self._running:
            self._leave_cycle()
            self._leave_world()

    def _note_change(self, change: Change) -> None:
        """Keeps which change is whose: that of the module whose code the control thread executes."""
        activity = self._cycle.activity
        if activity.thread != threading.get_ident():
            return
        for running in tuple(self._running.values()):
            if running.task is activity.task and len(running.changes) < _MOST_CHANGES:
                running.changes.append(change.number)

    def _report_stopped(self, running: RunningModule) -> None:
        broke = running.task.fault is not None
        status, code = (Status.ERROR, BROKEN) if broke else (Status.PREEMPTED, 0)
        result, kind = running.result, self._modules.kind(running.name)
        text = result.reason if isinstance(result, Failure) else result.message
        running.scope.publish(kind, running.name, status, code, text, id=running.id, parent=running.scope.id)


def _choose(skills: Sequence[Skill], context: RunContext, agent: str, driver: str) -> dict[str, tuple[Skill, ...]]:
    """Takes the implementations that fit the subsystem and its robot, by skill, in the order of trying."""
    view = context.world
    robot = owner(view, agent) or agent
    there = [view.element(e).type for e in pieces(view, robot)]
    chosen: dict[str, list[Skill]] = {}
    for skill in skills:
        wanted = skill.driver == driver if driver == "fake" else skill.driver in (None, driver)
        equipped = all(any(view.ontology.is_a(t, class_) for t in there) for class_ in skill.requires)
        if wanted and equipped and view.ontology.is_a(view.element(agent).type, skill.description.agent_class):
            chosen.setdefault(skill.description.name, []).append(skill)
    return {name: tuple(sorted(ways, key=lambda s: (s.order, s.label))) for name, ways in chosen.items()}
