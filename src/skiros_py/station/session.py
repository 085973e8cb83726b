"""The composition root: reads the scene, loads plug-ins, connects adapters to ports, opens and closes everything."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from skiros_py.catalogue import Catalogue, fitting, load_catalogue
from skiros_py.config import find_scene
from skiros_py.errors import FileError, UnknownName, UsageError, WrongState
from skiros_py.execution.running import RunningModule
from skiros_py.execution.runtime import RunDigest, Runtime, RuntimeOptions
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.listeners import Listeners
from skiros_py.messages import Message
from skiros_py.planning.problem.stock import believed
from skiros_py.planning.requests import RuledOut
from skiros_py.planning.service import Planned
from skiros_py.plugins.plugin import PluginFault
from skiros_py.ports.adapters import Ports
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CompositeDriver
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.restart import respawn
from skiros_py.station.starting import start_cell, start_planning, start_ports
from skiros_py.station.worlds import Report, open_data, open_world, warn
from skiros_py.system import default_simulation
from skiros_py.tasks.goals import parse_goal
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.rehearsal import Cancellable, Rehearsal
from skiros_py.tasks.report import ConditionReport, GoalReport
from skiros_py.tasks.task_manager import TaskManager, learn_costs
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ROBOT
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.simulation.cell import SimulatedCell
    from skiros_py.tasks.jobs.manager import JobManager

_log = logging.getLogger(__name__)

_STREAM = 1
"""Random numbers of modules are a stream of their own beside those of the simulation."""
_HASH_EVERY = 20
"""Cycles between two entries of joint states into a run's digest."""


@dataclass(frozen=True, slots=True)
class Options:
    """How to open a session.

    Attributes:
        seed: Seed of every random choice.
        robot: Id of the robot to use; None for all robots of the scene.
        fake: True for no physics: skills only pretend.
        pace: Simulated seconds per wall second; None for as fast as possible.
        gui: True to open the simulation's window.
        simulation: Name of the physics engine that simulates; PyBullet where it is installed, otherwise MuJoCo.
        imperfections: Factor of the errors of measured poses, mounted cameras and depth images in the simulation: 1
            for those of a real cell, 0 for none.
        goal: Goal text or texts; empty for the goal that goes with the scene.
        driver: Name of a cell driver that a plug-in brings; None for the simulation (or the fake).
        config: Values of configuration parameters by "module.key".
        planner: Name of the planner; None for the first that takes what a task uses.
        planner_command: Command line of a planner, with ``{domain}``, ``{problem}`` and perhaps ``{plan}``; instead of
            a name.
        data: A data directory, in which world and jobs outlive the session; the scene is the first content of a new
            one. None for a session that leaves nothing behind.
        temporal: True to plan in time, with durations; that takes a planner for durative actions.
        skills: Names of the skills to load; empty for all that are installed.
        overrun: Wall time for which one module may hold the control cycle [s]; None for the watchdog's own limit.
    """

    seed: int = 0
    robot: str | None = None
    fake: bool = False
    pace: float | None = None
    gui: bool = False
    simulation: str = field(default_factory=default_simulation)
    imperfections: float = 0.0
    goal: str | tuple[str, ...] = ()
    driver: str | None = None
    config: Mapping[str, Any] = field(default_factory=dict)
    planner: str | None = None
    planner_command: str | None = None
    data: Path | None = None
    temporal: bool = False
    overrun: float | None = None
    skills: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise UsageError(f"seed: a whole number from 0, not {self.seed!r}")
        if self.pace is not None and not 0.0 < self.pace < float("inf"):
            raise UsageError(f"pace: a positive factor, or None for as fast as possible, not {self.pace!r}")
        if self.planner is not None and self.planner_command is not None:
            raise UsageError("planner: give its name or its command line, not both")


_GOALS = 64
"""Number of goals that are not parsed again before the world changes: a factory system orders the same ones."""


class Session(AbstractContextManager["Session"]):
    """An open cell: world, robots, skill managers, planning, task manager. Close it, or use it in a ``with``.

    Its caller steps it: nothing moves unless a method such as :meth:`run` steps the control cycle, so a run in lockstep
    depends on its seed alone. ``skiros run``, ``plan`` and ``module``, tests and benchmarks use it like this, for one
    goal in one thread. A :class:`~skiros_py.station.station.Station` lets a control thread step its session, and adds
    what several callers share: events, alarms, recordings, documents, previews. Both start a goal by :meth:`begin` and
    a module by :meth:`start_module`; there is no other way.

    Args:
        scene: Name or path of the scene; empty where the data directory has its world already.
        options: How to open it.
        catalogue: Plug-ins that were found already; None to find them.

    Attributes:
        world: The live world model.
        monitor: Module events.
        goal: The goal: that of the options, else the one that goes with the scene.
        catalogue: The plug-ins found.
        cell: The driver: simulation or fake.
        spec: The cell as brought up.
        runtime: Runs modules on the cell.
        cycle: The control cycle.
        managers: The skill managers by the id of their subsystem.
        questions: Questions of the robots to a person.
        planning: The planning service.
        stopped: True if a stop was requested.
        left_out: Bodies without which it was opened, each with the reason: their descriptions are incomplete.
    """

    def __init__(self, scene: str, options: Options = Options(), *, catalogue: Catalogue | None = None) -> None:
        self._stack = ExitStack()
        self._stop_wanted = False
        self._closed = self._opened = False
        self.stopped = False
        self.left_out: dict[str, str] = {}
        self._digest = RunDigest()
        self._on_plan = Listeners[[Planned]]("plans")
        self.options = options
        self.scene = scene
        self.catalogue = catalogue or load_catalogue()
        self._parse = lru_cache(maxsize=_GOALS)(self._parse_at)
        try:
            self._open(scene)
            self._opened = True
        except BaseException:
            self.close()
            raise

    def _open(self, scene: str) -> None:
        faults: list[PluginFault] = []
        self.world = self._open_world(scene, faults.extend)
        # They are known already where the catalogue is that of the installation.
        self.catalogue = replace(self.catalogue, early=tuple(dict.fromkeys((*self.catalogue.faults, *faults))))
        fake = None if self.options.driver else self.options.fake  # what a driver is for is known when it is there
        self.catalogue = fitting(self.catalogue, self.world.ontology, self.world.reasoners, fake=fake)
        warn(self.catalogue.faults)
        self.goal = self._own_goal()
        self.spec = self._read_cell()
        ports = start_ports(self._stack, self.spec, physics=not self.options.fake)
        self.cell = start_cell(self._stack, self.spec, self.catalogue, self.options, self.world)
        self.world.subscribe(self._digest.add_change)
        self._set_up(ports)
        self._watch()
        self.planning = start_planning(self._stack, self.world, self.catalogue, self.options)
        self.tasks = TaskManager(
            self.runtime,
            self.planning,
            self._source.stem,
            on_plan=self._on_plan.notify,
            leaving=lambda: self._stop_wanted,
            temporal=self.options.temporal,
            absent=self.catalogue.absent,
            rehearser=self._rehearse,
        )
        if not self.options.fake:
            learn_costs(self.tasks, self.runtime)

    def _read_cell(self) -> CellSpec:
        """Reads the cell; of a world that people have changed since it began, without what they have left unfinished.

        In a scene that has just been read that is its author's mistake.
        """
        lived = self.options.data is not None and self.world.log.version > 1
        spec = read_cell(
            self.world,
            self.robots_in(self.world),
            simulated=self.simulates,
            left_out=self.left_out if lived else None,
        )
        for element, why in self.left_out.items():
            _log.warning("the station is brought up without %s: %s", element, why)
        return spec

    def _open_world(self, scene: str, report: Report) -> World:
        if self.options.data is None:
            return open_world(scene, report)
        directory = open_data(self.options.data, scene, report=report)
        self._stack.callback(lambda: directory.close() if self._opened else directory.discard())
        if self.simulates:
            respawn(directory.world, directory.journal)
        return directory.world

    @property
    def simulates(self) -> bool:
        """True if physics moves the bodies."""
        return self.options.driver is None and not self.options.fake

    def _own_goal(self) -> tuple[Condition, ...]:
        """Reads the goal of the options, else the one that goes with the scene."""
        if self.options.goal:
            return self._read_goal(self.options.goal)
        try:
            return self.parse(self.world.goals)
        except UsageError as error:
            raise FileError(self._source, f"sk:goal: {error}") from error

    @property
    def _source(self) -> Path:
        """The file of the world: a scene, or the data directory alone."""
        if self.scene or self.options.data is None:
            return find_scene(self.scene)
        return self.options.data

    def robots_in(self, world: WorldView) -> tuple[str, ...]:
        """Returns the ids of the robots that a session such as this one uses in a scene.

        Raises:
            UnknownName: The robot that was chosen is not in it.
        """
        robots = world.instances(ROBOT)  # a scene may have none: it is edited and looked at all the same
        wanted = self.options.robot
        if wanted is None:
            return robots
        by_name = {name: robot for robot in robots for name in (world.element(robot).label, robot)}
        if wanted not in by_name:
            raise UnknownName("robot", wanted, robots, where=f"in scene '{self.scene}'")
        return (by_name[wanted],)

    def _set_up(self, ports: Ports) -> None:
        """Brings control cycle, skill managers and watchdog up."""
        providers, faults = self.catalogue.signal_providers(self.spec)
        warn(faults)
        self.catalogue = replace(self.catalogue, early=(*self.catalogue.early, *faults))
        options = RuntimeOptions(
            seed=(self.options.seed, _STREAM),
            pace=self.options.pace,
            ports=ports,
            config=self.options.config,
            signals=[provider for provider, _ in providers],
            sources=[source for _, source in providers],
            signals_missing="; ".join(fault.reason for fault in faults),
            overrun=self.options.overrun,
        )
        skills = self.catalogue.chosen_skills(self.options.skills)
        runtime = Runtime(self.world, self.spec, self.cell, skills, self.catalogue.primitives, options)
        self.runtime = self._stack.enter_context(runtime)
        self.cycle, self.managers = runtime.cycle, runtime.managers
        self.monitor, self.questions = runtime.monitor, runtime.questions
        self.cycle.observe(self._digest_state)

    def _watch(self) -> None:
        """Starts what runs in the background; a stop ends it with everything else."""
        if not self.options.fake:
            self.managers.watch()

    def _rehearse(self, goal: Sequence[Condition]) -> Cancellable[Rehearsal]:
        from skiros_py.station.rehearsals.order import order_of  # most goals are not rehearsed
        from skiros_py.station.rehearsals.rehearsal import RunningRehearsal

        return RunningRehearsal(order_of(self, [str(condition) for condition in goal]))

    # ------------------------------------------------------------------ use

    def parse(self, texts: Sequence[str]) -> tuple[Condition, ...]:
        """Reads goal texts; see :func:`skiros_py.tasks.goals.parse_goal`."""
        return self._parse(self.world.version, tuple(texts))

    def _parse_at(self, _version: int, texts: Sequence[str]) -> tuple[Condition, ...]:
        return parse_goal(texts, self.world, self.catalogue.conditions)

    def on_plan(self, listener: Callable[[Planned], None]) -> None:
        """Calls the listener with every new plan."""
        self._on_plan.add(listener)

    def plan(self, goal: str | Sequence[Condition] | Sequence[str] | None = None) -> Planned:
        """Plans from the current beliefs without doing anything."""
        asked = self.planning.ask(self.tasks.plan_request(self._conditions(goal)))
        try:
            return asked.result().value
        finally:
            asked.cancel()

    def run(
        self,
        goal: str | Sequence[Condition] | Sequence[str] | None = None,
        policy: Policy | None = None,
        ruled_out: Sequence[RuledOut] = (),
    ) -> GoalReport:
        """Pursues a goal until it ends, or until :meth:`stop`; steps the control cycle.

        Args:
            goal: Conditions or goal texts; None for the goal of the scene.
            policy: What to do if part of the goal cannot be reached.
            ruled_out: Attempts that are not planned.

        Raises:
            UsageError: There is no goal.
            WrongState: The cell is halted; see :meth:`reset`.
        """
        wanted = self._conditions(goal)
        self.runtime.require_ready()
        self._digest.begin(self.simulation.state_bytes() if self.simulates else b"")
        task = self.begin(wanted, policy, ruled_out)
        ended = self.runtime.finish(task, lambda: self._stop_wanted)
        stopped = self._obey_stop()
        report = replace(task.result, digest=str(self._digest))
        if not ended:  # cut off between two cycles: what the last step has reached is not in the report yet
            report = replace(report, conditions=tuple(map(self._seen_again, wanted, report.conditions)))
        if stopped:
            report = replace(report, stopped=True, fault="")
        if not self.simulates:
            return report
        from skiros_py.station.judgement import judge  # physics is an extra

        return report.with_truth(judge(self.simulation, self.spec, self.world, wanted))

    def _seen_again(self, condition: Condition, was: ConditionReport) -> ConditionReport:
        if was.believed or not believed(condition, self.world):
            return was
        return replace(was, believed=True, tries=was.tries + 1, reason="")

    def begin(
        self,
        goal: str | Sequence[Condition] | Sequence[str] | None = None,
        policy: Policy | None = None,
        ruled_out: Sequence[RuledOut] = (),
    ) -> TaskHandle:
        """Starts to pursue a goal, and returns immediately; it continues as the control cycle is stepped.

        Args:
            goal: Conditions or goal texts; None for the goal of the scene.
            policy: What to do if part of the goal cannot be reached.
            ruled_out: Attempts that are not planned.

        Raises:
            UsageError: There is no goal.
            WrongState: The cell is halted; see :meth:`reset`.
        """
        conditions = self._conditions(goal)
        self.runtime.require_ready()
        return self.tasks.begin(conditions, policy=policy, ruled_out=ruled_out)

    def start_module(self, module: str, arguments: Mapping[str, Any], agent: str | None = None) -> RunningModule:
        """Starts a single skill or primitive; step the cycle until it has ended.

        Args:
            module: Its name.
            arguments: Its parameters; the others are inferred.
            agent: Id of the subsystem; None for the first that can run it.

        Raises:
            UnknownName: There is no such module or subsystem.
            UsageError: It has no implementation for the driver.
            WrongState: It cannot be started now: it is running, its manager is lost, or the cell is halted.
        """
        self.runtime.require_ready()
        if agent is not None and agent not in self.managers:
            raise UnknownName("skill manager", agent, self.managers)
        manager = self.who_runs(module) if agent is None else self.managers[agent]
        if manager.lost:
            raise WrongState("the skill manager of {agent} is lost: {lost}", agent=manager.agent, lost=manager.lost)
        if module in manager.running:
            raise WrongState(
                "{module} of {agent} is running already: wait for its end, or stop it",
                module=module,
                agent=manager.agent,
            )
        return manager.start(module, arguments)

    def who_runs(self, module: str) -> SkillManager:
        """Returns the first skill manager that can run a module.

        Raises:
            UnknownName: None can.
            UsageError: It has no implementation for the driver.
        """
        if module in self.catalogue.elsewhere:
            raise UsageError(self.catalogue.why_elsewhere(module))
        return self.managers.who_runs(module)

    def run_module(self, module: str, arguments: Mapping[str, Any], agent: str | None = None) -> Outcome:
        """Runs a single skill or primitive until it ends, or until :meth:`stop`; see :meth:`start_module`."""
        running = self.start_module(module, arguments, agent)
        self.runtime.finish(running, lambda: self._stop_wanted)
        self._obey_stop()
        return running.result

    @cached_property
    def jobs(self) -> JobManager:
        """The queue of jobs; stored in the data directory, if there is one.

        Raises:
            FileError: The file with the jobs cannot be used.
        """
        from skiros_py.tasks.jobs.manager import JobManager  # most sessions have no jobs
        from skiros_py.tasks.jobs.store import JobStore

        folder = self.options.data or Path(self._stack.enter_context(TemporaryDirectory(prefix="skiros-jobs-")))
        store = self._stack.enter_context(closing(JobStore(folder / "jobs.db")))
        return JobManager(self.tasks, self.runtime, store, self.parse)

    def run_jobs(self) -> None:
        """Steps the control cycle until no job is active or allowed to start, or until :meth:`stop`."""
        while not (self.jobs.idle or self._stop_wanted or self.cycle.halted):
            self.cycle.step()
        self._obey_stop()

    @property
    def resting(self) -> bool:
        """True if no job, task or module is active, and no job would start by itself.

        While the cell is halted, waiting jobs do not start.
        """
        at_work = self.tasks.active or any(manager.running for manager in self.managers.values())
        return not at_work and ("jobs" not in self.__dict__ or bool(self.cycle.halted) or self.jobs.idle)

    def reset(self) -> None:
        """Ends a halt by the watchdog, a module or ``cycle.halt``; check its reason first.

        It is not needed after :meth:`stop`.

        Raises:
            UsageError: A device still moves.
        """
        if self.cycle.halted:
            self.cycle.reset()
            self._watch()

    def _obey_stop(self) -> bool:
        """Stops everything if :meth:`stop` was called and the cell is not halted; afterwards it is ready again.

        Returns:
            True if it was stopped.
        """
        wanted, self._stop_wanted = self._stop_wanted, False
        if not wanted or self.cycle.halted:
            return False
        if self.cycle.stop_all("stopped"):
            self.reset()
        return True

    def stop(self) -> None:
        """Requests a stop: everything halts in the next cycle; safe to call from a signal handler."""
        self._stop_wanted = self.stopped = True

    def _conditions(self, goal: str | Sequence[Condition] | Sequence[str] | None) -> tuple[Condition, ...]:
        if self._closed:
            raise UsageError("the session is closed")
        if not self.spec.robots and not self.managers:
            iri = "https://w3id.org/skiros-py/robots/mobile_panda"
            raise UsageError("scene '{scene}' has no robot: import one, such as <{iri}>", scene=self.scene, iri=iri)
        return self._read_goal(goal)

    def _read_goal(self, goal: str | Sequence[Condition] | Sequence[str] | None) -> tuple[Condition, ...]:
        given: Sequence[Any] = self.goal if goal is None else (goal,) if isinstance(goal, str) else goal
        if not isinstance(given, Sequence) or not all(isinstance(part, str | Condition) for part in given):
            raise UsageError(f"a goal is a text, or a list of texts or conditions, not {goal!r}")
        texts = [part for part in given if isinstance(part, str)]
        conditions = tuple(part for part in given if isinstance(part, Condition)) + (self.parse(texts) if texts else ())
        if goal is not None and not conditions:
            raise UsageError(Message("the goal is empty: nothing is wanted"))
        if not conditions:
            raise UsageError(
                "scene '{scene}' comes without a goal: state one, such as --goal 'InKit(Starter, kit_1)'",
                scene=self.scene,
            )
        return conditions

    @property
    def simulation(self) -> SimulatedCell:
        """The physics simulation, for operations that only a simulation offers (moving bodies, pictures from outside).

        Raises:
            UsageError: The session runs on a fake.
        """
        from skiros_py.simulation.cell import SimulatedCell

        cell = self.cell.drivers[0] if isinstance(self.cell, CompositeDriver) else self.cell
        if not isinstance(cell, SimulatedCell):
            raise UsageError("there is no simulation behind this robot: leave out --fake and --driver")
        return cell

    # ------------------------------------------------------------------ digest and end

    def _digest_state(self) -> None:
        if self.simulates and self.cycle.board.snapshot.cycle % _HASH_EVERY == 0:
            self._digest.add(self.simulation.state_bytes())

    def on_close(self, *callbacks: Callable[[], object]) -> None:
        """Calls functions when the session is closed, before its own parts are; those added last come first.

        One that raises does not prevent the others; its exception is raised by :meth:`close`.
        """
        for callback in callbacks:
            self._stack.callback(callback)

    def close(self) -> None:
        """Ends all processes and the simulation; may be called twice."""
        self._closed = True
        self._stack.close()

    def __exit__(self, *_: object) -> None:
        self.close()
