"""A skill manager: what one subsystem of a robot (a base, an arm) can do (paper §3.3).

It is reached through a small interface of plain data, so that it may one day live in another process or host.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.execution.claims import Claim, Claims
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.loader import Loader
from skiros_py.execution.modules import ModuleInfo, choose
from skiros_py.execution.monitor import Monitor, Status
from skiros_py.execution.panel import Panel, primitive_panel, skill_panel
from skiros_py.execution.primitive_run import PrimitiveRun
from skiros_py.execution.registration import Registration
from skiros_py.execution.running import BehaviourRun, RunningModule
from skiros_py.execution.scope import ModuleRun, Scope
from skiros_py.execution.skill_run import SkillRun
from skiros_py.execution.task import RunClock, Task
from skiros_py.interruptions import WatchedTask
from skiros_py.messages import Message
from skiros_py.skills.behaviour import calls_of
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.context import RunContext, Tried
from skiros_py.skills.outcome import BROKEN, Failure, Outcome
from skiros_py.skills.parameters import Access, Kind, Output, params_of
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import RunnableDocument, Skill, SkillDescription
from skiros_py.skills.surroundings import owner
from skiros_py.world.change import Change
from skiros_py.world.view import pieces
from skiros_py.world.vocabulary import HAS_A

_PATIENCE = 1.0
"""For how long a write is waited for when a manager is lost [s]."""
_MOST_CHANGES = 1000
"""Changes of which it is kept that one run of a module made them."""


@dataclass(frozen=True, slots=True)
class CellModules:
    """What the skill managers of a cell share.

    Attributes:
        skills: All skills found.
        primitives: All primitives found, by name; they may load themselves when they are looked up.
        context: World, devices, adapters.
        cycle: Runs everything.
        monitor: Takes module events.
        watches: Conditions under watch.
        driver: Kind of cell driver; a fake one gets the implementations that only pretend.
        config: Values of configuration parameters by module and key.
        claims: Who may use which device.
        documents: Documents that every manager runs as modules, by name; they may be exchanged at any time.
        managers: The skill managers that are there or lost, by the id of their subsystem; for any thread.
    """

    skills: Sequence[Skill]
    primitives: Mapping[str, type[Primitive[Any]]]
    context: RunContext
    cycle: ControlCycle
    monitor: Monitor
    watches: Watches
    driver: str
    config: Mapping[str, Mapping[str, Any]]
    claims: Claims = field(default_factory=Claims)
    documents: dict[str, RunnableDocument] = field(default_factory=dict)
    managers: dict[str, SkillManager] = field(default_factory=dict)

    def who_runs(self, module: str, arguments: Mapping[str, Any], caller: SkillManager) -> SkillManager:
        """Returns the skill manager that runs a called module.

        That is the one of the subsystem that the arguments name, else the caller itself, else one of the caller's
        robot, else the first by its id; the caller for a module that is offered nowhere as a skill.
        """
        view = self.context.world
        able = [one for one in tuple(self.managers.values()) if module in one.skills and not one.lost]
        robot = owner(view, caller.agent)

        def far(one: SkillManager) -> tuple[bool, bool, bool, str]:
            named = arguments.get(one.skills[module][0].description.agent) == one.agent
            return not named, one is not caller, owner(view, one.agent) != robot, one.agent

        return min(able, key=far, default=caller)


class SkillManager:
    """Offers the modules that fit one subsystem and runs them in the control cycle.

    The same module runs once at a time, different ones at the same time, as far as their devices allow.

    Args:
        agent: Id of the subsystem.
        cell: What all skill managers share; of its skills those are taken that are for this class and driver.

    Attributes:
        agent: Id of the subsystem.
        skills: Implementations of each skill by its name, in the order in which they are tried.
        lost: Why it is lost; empty while it is there.
    """

    def __init__(self, agent: str, cell: CellModules) -> None:
        self.agent = agent
        self.lost = ""
        self._cell = cell
        self._context = cell.context
        self._cycle = cell.cycle
        self.skills = choose(cell.skills, cell.context, agent, cell.driver)
        self._loader = Loader(cell.primitives, cell.config, cell.cycle.activity)
        self._running: dict[str, RunningModule] = {}
        self._watching: dict[str, Task[Outcome]] = {}
        self._launched: dict[str, tuple[str, Mapping[str, Any]]] = {}
        self._registration = Registration(cell.context.world, agent)
        self._leave_cycle = cell.cycle.observe(self._attend)
        self._leave_world = cell.context.world.subscribe(self._note_change)
        self._retired = False

    # ------------------------------------------------------------------ what it offers

    @property
    def descriptions(self) -> Mapping[str, SkillDescription]:
        """The skills it offers, by name; none when it is lost."""
        return {} if self.lost else {name: ways[0].description for name, ways in self.skills.items()}

    def offers(self, skill: str) -> bool:
        """Returns True if it offers a skill."""
        return not self.lost and skill in self.skills

    @property
    def alternatives(self) -> Mapping[str, Sequence[Sequence[Condition]]]:
        """What each implementation of a skill asks for besides what the description does, by the skill's name."""
        return {name: [way.when for way in ways] for name, ways in self.skills.items()}

    @property
    def modules(self) -> tuple[str, ...]:
        """Names of all modules it can run: its skills, and the primitives whose hardware it has."""
        fitting = [name for name in sorted(self._cell.primitives) if self._has_hardware_for(name)]
        return (*sorted(self.skills), *fitting)

    def info(self, module: str) -> ModuleInfo:
        """Describes one module.

        Raises:
            UnknownName: There is no such module.
        """
        kind = self._kind(module)
        if kind == "document":
            found = self._cell.documents[module]
            outputs = tuple(Output(name, "", "") for name in found.outputs)
            return ModuleInfo(module, kind, found.help, found.params, str(found.revision), outputs=outputs)
        if kind == "skill":
            ways = self.skills[module]
            first, labels = ways[0], tuple(skill.label for skill in ways)
            return ModuleInfo(module, kind, first.description.help, first.description.params, first.version, labels)
        cls = self._cell.primitives[module]
        help_ = (cls.__doc__ or "").strip().partition("\n")[0]
        return ModuleInfo(module, kind, help_, params_of(cls.Params), cls.version, outputs=cls.outputs)

    def _kind(self, module: str) -> str:
        offered = {"skill": self.skills, "primitive": self._cell.primitives, "document": self._cell.documents}
        for kind, modules in offered.items():
            if module in modules:
                return kind
        raise UnknownName("module", module, [*chain.from_iterable(offered.values())], where=f"of {self.agent}")

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the documents that run as modules, by any manager."""
        return () if self.lost else tuple(sorted(self._cell.documents))

    def document(self, module: str) -> RunnableDocument | None:
        """Returns the document that a module runs; None for skills and primitives."""
        return self._cell.documents.get(module)

    def panel(self, module: str, given: Mapping[str, Any]) -> Panel:
        """Tells what a module would be run with now, and which of its conditions hold.

        Raises:
            UnknownName: There is no such module.
            UsageError: Something is wrong with what is given.
        """
        info, world = self.info(module), self._context.world
        if info.kind != "skill":
            return primitive_panel(info.params, given, world, self.agent)
        return skill_panel(self.skills[module][0].description, given, world, self.agent)

    def _has_hardware_for(self, primitive: str) -> bool:
        cls, view = self._cell.primitives[primitive], self._context.world
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
        self.stop()
        for task in self._watching.values():
            task.stop("its skill manager goes")
        self._registration.withdraw(Message("goes"))

    def lose(self, reason: str) -> None:
        """Marks it as lost: its skills are no longer offered. For any thread; everything else goes on.

        A lost module may hold the world's write lock: then its skills leave the world model when the lock is released.
        """
        if self.lost:
            return
        self.lost = reason
        leaving = threading.Thread(
            target=self._registration.withdraw,
            args=(Message("is lost: {reason}", reason=reason),),
            name=f"skiros-leaving-{self.agent}",
            daemon=True,
        )
        leaving.start()
        leaving.join(_PATIENCE)

    def watch(self) -> None:
        """Starts what runs in the background, as far as it does not run: also what was launched, and then stopped.

        A primitive that watches devices runs at most once for each of this subsystem's devices of its class.
        """
        stopped = [launched for name, launched in self._launched.items() if self._watching[name].aborted]
        self._watching = {name: task for name, task in self._watching.items() if not task.done}
        self._launched = {name: one for name, one in self._launched.items() if name in self._watching}
        view = self._context.world
        for primitive, cls in sorted(self._cell.primitives.items()):
            for device in view.objects(self.agent, HAS_A) if cls.watches else ():
                name = f"{primitive} of {device}"
                if name not in self._watching and view.ontology.is_a(view.element(device).type, cls.watches or ""):
                    run = self.run(primitive, {"device": device}, self._scope(name))
                    self._watching[name] = self._cycle.start(run, name=name)
        for module, arguments in stopped:
            self.launch(module, arguments)

    def launch(self, module: str, arguments: Mapping[str, Any]) -> None:
        """Starts a module in the background, where it runs until it ends or the manager goes.

        One that runs there already with these arguments stays as it is.

        Raises:
            UnknownName: There is no such module.
        """
        name = f"{module}({', '.join(f'{key}={value}' for key, value in sorted(arguments.items()))})"
        running = self._watching.get(name)
        if running is None or running.done:
            self._launched[name] = (module, arguments)
            self._watching[name] = self._cycle.start(self.run(module, arguments, self._scope(name)), name=name)

    # ------------------------------------------------------------------ running

    @property
    def running(self) -> Mapping[str, RunningModule]:
        """What runs now, by name."""
        return dict(self._running)

    def runs(self, task: WatchedTask) -> bool:
        """Tells whether a task is of one of its modules, or of what it runs in the background."""
        own = (*self._watching.copy().values(), *(running.task for running in self.running.values()))
        return any(one is task for one in own)

    def start(
        self,
        module: str,
        arguments: Mapping[str, Any],
        *,
        task: str = "",
        parent: str = "",
        tried: Tried | None = None,
        ahead: frozenset[str] = frozenset(),
    ) -> RunningModule:
        """Starts a module.

        Parameters that are left out are inferred in the first cycle; what is wrong with them is the run's failure.

        Args:
            module: Its name.
            arguments: Its parameters.
            task: Name of the task that it is done for; empty for none.
            parent: Id of what it is part of, such as a step of a plan; empty for none.
            tried: What was tried in vain for the same purpose; None for nothing.
            ahead: Ids of what the next steps of the plan are about.

        Raises:
            UnknownName: It does not offer that module.
            UsageError: The module runs already, the manager is lost, or everything was stopped and not reset.
        """
        if self.lost:
            raise UsageError("the skill manager of {agent} is lost: {lost}", agent=self.agent, lost=self.lost)
        if module in self._running:
            raise UsageError(
                "{module} of {agent} is running already: wait for its end, or stop it", module=module, agent=self.agent
            )
        self._prepare(module, {}, set())
        clock, run_id = RunClock(self._cycle.board), self._cell.monitor.new_id()
        scope = replace(
            self._scope(module),
            context=replace(self._context, clock=clock, tried=tried or Tried(), ahead=ahead),
            task=task,
            id=parent,
            root=parent or run_id,
        )
        run = self._module_run(module, arguments, scope, run_id)
        task_of_run = self._cycle.start(run.execute(), name=f"{module} of {self.agent}", clock=clock)
        self._running[module] = RunningModule(run, task_of_run, scope)
        return self._running[module]

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
        self._kind(module)
        if module in self._running:
            raise UsageError("{module} of {agent} is running: stop it first", module=module, agent=self.agent)
        self._loader.reset(module, self._context)

    def run(self, module: str, arguments: Mapping[str, Any], scope: Scope) -> Execution[Outcome]:
        """Returns the run of a module within a scope; ticked to its end, or closed.

        A skill that another subsystem does runs as by the skill manager of that one.

        Args:
            module: Its name.
            arguments: Its parameters.
            scope: What it runs in.

        Raises:
            UnknownName: There is no such module.
        """
        able = self._cell.who_runs(module, arguments, self)
        if able is not self:
            scope = replace(scope, agent=able.agent, modules=able)
        return able._module_run(module, arguments, scope).execute()  # noqa: SLF001 - one of the same class

    def _module_run(self, module: str, arguments: Mapping[str, Any], scope: Scope, run: str = "") -> ModuleRun:
        match self._kind(module):
            case "document":
                return BehaviourRun(module, self._cell.documents[module], arguments, scope, run)
            case "skill":
                return SkillRun(self.skills[module], arguments, scope, self._take, run)
            case _:
                return PrimitiveRun(module, self._loader, arguments, scope, self._take, run)

    def _take(self, owner: str, devices: Mapping[str, Access], within: Claim | None) -> Claim:
        """Asks for devices, out of those of the module around it.

        Raises:
            DescriptionError: A device is to be shared whose kind has no mix rule, or the module around has not declared
                a device.
            DeviceError: A device was closed or switched off.
        """
        board = self._cell.context.board
        for device in devices:
            board.require_open(device)
        shared = [device for device, access in devices.items() if access is Access.SHARED]
        for spec in (board.devices[device] for device in shared if device in board.devices):
            if not spec.mixes():
                raise DescriptionError(f"{owner} shares {spec.id}, but kind '{spec.kind}' has no mix rule")
        claim = self._cell.claims.request(owner, devices, shared=shared, within=within)
        task = board.owner
        if within is None and task is not None:
            task.devices = claim.devices
        return claim

    def _prepare(self, module: str, arguments: Mapping[str, Any], seen: set[tuple[str, str]]) -> None:
        """Loads the primitives that a module is made of, as far as its composition names them.

        Those that a primitive calls by itself are loaded when it does.
        """
        able = self._cell.who_runs(module, arguments, self)
        if (able.agent, module) in seen:
            return
        seen.add((able.agent, module))
        if module not in able.skills and module in self._cell.primitives:
            able._loader.prepare(module, self._context)  # noqa: SLF001 - one of the same class
        bodies = [skill.nodes for skill in able.skills.get(module, ())]
        if module in self._cell.documents:
            bodies.append((self._cell.documents[module].behaviour,))
        for nodes in bodies:
            for call in calls_of(*nodes):
                able._prepare(call.module, call.arguments, seen)  # noqa: SLF001 - one of the same class

    def _scope(self, name: str) -> Scope:
        cell = self._cell
        return Scope(cell.context, self, cell.watches, cell.monitor, self.agent, path=name)

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
        result = running.result
        running.run.tell(status, code, result.reason if isinstance(result, Failure) else result.message)
