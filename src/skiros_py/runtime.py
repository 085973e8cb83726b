"""The composition root: reads the scene, loads plug-ins, wires adapters to ports, starts and stops everything."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from skiros_py.catalogue import Catalogue, fitting, load_catalogue
from skiros_py.config import find_scene, ontology_paths
from skiros_py.errors import DescriptionError, FileError, UnknownName, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.plugins import PluginFault
from skiros_py.robot.devices import DeviceBoard
from skiros_py.robot.driver import CellDriver
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Condition
from skiros_py.skills.context import Libraries, RunContext
from skiros_py.system import check_system_libraries
from skiros_py.tasks.goals import parse_goal
from skiros_py.tasks.report import ConditionReport, GoalReport
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.world.change import Change
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.plugins import load_reasoners
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.vocabulary import AGENT, HAS_A, ROBOT
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.simulation.pybullet.cell import PyBulletCell
    from skiros_py.world.journal import DataDirectory

__all__ = ["Options", "Session", "open_data", "open_world", "scene_title"]

_log = logging.getLogger(__name__)

_PLANNER = "fast-downward"
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
        gui: True to open PyBullet's window.
        goal: Goal text or texts; empty for the goal that goes with the scene.
    """

    seed: int = 0
    robot: str | None = None
    fake: bool = False
    pace: float | None = None
    gui: bool = False
    goal: str | tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise UsageError(f"seed: a whole number from 0, not {self.seed!r}")
        if self.pace is not None and not 0.0 < self.pace < float("inf"):
            raise UsageError(f"pace: a positive factor, or None for as fast as possible, not {self.pace!r}")


class Session:
    """A scene brought to life: world, robots, skill managers, task manager. Close it, or use it in a ``with``.

    Attributes:
        world: The live world model.
        monitor: Module events.
        goal: The goal: that of the options, else the one that goes with the scene.
        catalogue: The plug-ins found.
        cell: The driver: simulation or fake.
        spec: The cell as brought up.
        cycle: The control cycle.
    """

    def __init__(self, scene: str, options: Options = Options(), *, catalogue: Catalogue | None = None) -> None:
        self._stack = ExitStack()
        self._stop_wanted = False
        self._closed = False
        self._digest = hashlib.sha256()
        self._on_plan: list[Callable[[Planned], None]] = []
        self.options = options
        self.scene = scene
        self.catalogue = catalogue or load_catalogue()
        self.monitor = Monitor()
        try:
            self._open(scene)
        except BaseException:
            self.close()
            raise

    def _open(self, scene: str) -> None:
        self.world, faults = _opened(scene)
        # They are known already where the catalogue is that of the installation.
        self.catalogue = replace(self.catalogue, faults=tuple(dict.fromkeys((*self.catalogue.faults, *faults))))
        self.catalogue = fitting(self.catalogue, self.world.ontology, self.world.reasoners)
        _warn(self.catalogue.faults)
        self.goal = self._own_goal()
        self.spec = read_cell(self.world, self._robots())
        if _PLANNER not in self.catalogue.planners:
            raise UsageError(f"planner '{_PLANNER}' did not load: skiros skills says why")
        libraries = Libraries() if self.options.fake else self._start_libraries()
        self.cell = self._start_cell()
        board = DeviceBoard(self.cell)
        self.world.clock = lambda: board.snapshot.time
        self.world.subscribe(self._digest_change)
        self.cycle = ControlCycle(board, self.options.pace)
        self.cycle.observe(self._digest_state)
        context = RunContext(
            world=self.world,
            board=board,
            libraries=libraries,
            cell=self.spec,
            rng=np.random.default_rng([self.options.seed, 1]),
            lockstep=self.options.pace is None,
            report=lambda _module, _code, _text: None,
        )
        self.managers = self._start_managers(context)
        self._watch()
        planner = self._stack.enter_context(closing(self.catalogue.planners[_PLANNER]()))
        self.planning = PlanningService(planner, scene_title(scene), lockstep=self.options.pace is None)
        self.tasks = TaskManager(self.world, self.managers, self.planning, self.cycle, on_plan=self._tell_plan)

    def _own_goal(self) -> tuple[Condition, ...]:
        """Reads the goal of the options, else the one that goes with the scene."""
        if self.options.goal:
            return self._conditions(self.options.goal)
        try:
            return self.parse(self.world.goals)
        except UsageError as error:
            raise FileError(find_scene(self.scene), f"sk:goal: {error}") from error

    def _robots(self) -> tuple[str, ...]:
        robots = self.world.instances(ROBOT)
        if not robots:
            raise UsageError(f"scene '{self.scene}' has no robot: import one, such as robots/mobile_panda.ttl")
        wanted = self.options.robot
        if wanted is None:
            return robots
        by_name = {name: robot for robot in robots for name in (self.world.element(robot).label, robot)}
        if wanted not in by_name:
            raise UnknownName("robot", wanted, robots, where=f"in scene '{self.scene}'")
        return (by_name[wanted],)

    def _start_libraries(self) -> Libraries:
        """Starts the worker processes first: their imports take seconds and run side by side."""
        from skiros_py.motion.arm_planner import WorkerArmPlanner
        from skiros_py.motion.base_paths import ShapelyBasePlanner
        from skiros_py.perception.worker import Open3dPartDetector, Open3dRegistrar, start_perception

        check_system_libraries()
        if len(self.spec.robots) != 1:
            raise DescriptionError("a physical run takes one robot so far: choose it with --robot")
        perception = self._stack.enter_context(closing(start_perception()))
        arm_planner = self._stack.enter_context(closing(WorkerArmPlanner(self.spec.robots[0])))
        base_planner = self._stack.enter_context(closing(ShapelyBasePlanner()))
        return Libraries(arm_planner, base_planner, Open3dPartDetector(perception), Open3dRegistrar(perception))

    def _start_cell(self) -> CellDriver:
        if self.options.fake:
            from skiros_py.simulation.fake.cell import FakeCell

            return self._stack.enter_context(closing(FakeCell(self.spec, seed=self.options.seed)))
        from skiros_py.simulation.pybullet.cell import PyBulletCell

        return self._stack.enter_context(closing(PyBulletCell(self.spec, seed=self.options.seed, gui=self.options.gui)))

    def _start_managers(self, context: RunContext) -> dict[str, SkillManager]:
        """One skill manager for each subsystem of each robot (paper §3.3)."""
        managers = {}
        for robot in self.spec.robots:
            for agent in self.world.objects(robot.id, HAS_A):
                if self.world.ontology.is_a(self.world.element(agent).type, AGENT):
                    managers[agent] = self._manager(agent, context)
        return managers

    def _manager(self, agent: str, context: RunContext) -> SkillManager:
        skills = [skill for _, skill in sorted(self.catalogue.skills.items())]
        manager = SkillManager(
            agent, skills, self.catalogue.primitives, context, self.cycle, self.monitor, driver=self.cell.kind
        )
        manager.register()
        return manager

    def _watch(self) -> None:
        """Starts what runs in the background; a stop ends it with everything else."""
        for manager in self.managers.values() if not self.options.fake else ():
            manager.watch()

    # ------------------------------------------------------------------ use

    def parse(self, texts: Sequence[str]) -> tuple[Condition, ...]:
        """Reads goal texts; see :func:`skiros_py.tasks.goals.parse_goal`."""
        return parse_goal(texts, self.world, self.catalogue.conditions)

    def on_plan(self, listener: Callable[[Planned], None]) -> None:
        """Calls the listener with every new plan."""
        self._on_plan.append(listener)

    def _tell_plan(self, planned: Planned) -> None:
        for listener in self._on_plan:
            listener(planned)

    def plan(self, goal: str | Sequence[Condition] | Sequence[str] | None = None) -> Planned:
        """Plans from the present beliefs without doing anything."""
        planning = self.tasks.plan(self._conditions(goal))
        while True:
            try:
                next(planning)
            except StopIteration as end:
                result: Planned = end.value
                return result
            time.sleep(0.001)

    def run(self, goal: str | Sequence[Condition] | Sequence[str] | None = None) -> GoalReport:
        """Pursues a goal to its end, or until :meth:`stop`.

        Args:
            goal: Conditions or goal texts; None for the goal of the scene.

        Raises:
            UsageError: There is no goal.
        """
        wanted = self._conditions(goal)
        self._digest = hashlib.sha256() if self.options.fake else hashlib.sha256(self.simulation.state_bytes())
        started = time.perf_counter(), self.cycle.board.snapshot.time
        task = self.cycle.start(self.tasks.pursue(wanted))
        while not task.done and not self._stop_wanted:
            self.cycle.step()
        if task.done:
            report = task.result
        else:
            self.cycle.stop_all()
            self._stop_wanted = False
            self._watch()
            report = self._stopped_report(wanted, *started)
        report = replace(report, digest=self._digest.hexdigest()[:16])
        return report if self.options.fake else report.with_truth(self._truths(wanted))

    def stop(self) -> None:
        """Asks the run to stop: everything halts in the next cycle; safe to call from a signal handler."""
        self._stop_wanted = True

    def _conditions(self, goal: str | Sequence[Condition] | Sequence[str] | None) -> tuple[Condition, ...]:
        if self._closed:
            raise UsageError("the session is closed")
        given: Sequence[Any] = self.goal if goal is None else (goal,) if isinstance(goal, str) else goal
        if not isinstance(given, Sequence) or not all(isinstance(part, str | Condition) for part in given):
            raise UsageError(f"a goal is a text, or a list of texts or conditions, not {goal!r}")
        texts = [part for part in given if isinstance(part, str)]
        conditions = tuple(part for part in given if isinstance(part, Condition)) + (self.parse(texts) if texts else ())
        if goal is not None and not conditions:
            raise UsageError("the goal is empty: nothing is wanted")
        if not conditions:
            raise UsageError(
                f"scene '{self.scene}' comes without a goal: state one, such as --goal 'InKit(Starter, kit_1)'"
            )
        return conditions

    def _stopped_report(self, goal: Sequence[Condition], wall: float, simulated: float) -> GoalReport:
        conditions = tuple(ConditionReport(str(c), bool(c.evaluate(self.world)), None, 0, "stopped") for c in goal)
        used = self.cycle.board.snapshot.time - simulated, time.perf_counter() - wall
        return GoalReport(conditions, tuple(self.tasks.steps), *used, stopped=True)

    def _truths(self, goal: Sequence[Condition]) -> tuple[bool, ...]:
        from skiros_py.judgement import judge

        return judge(self.simulation, self.spec, self.world, goal)

    @property
    def simulation(self) -> PyBulletCell:
        """The physics simulation, for what only a simulation can do (moving bodies, outside pictures).

        Raises:
            UsageError: The session runs on a fake.
        """
        from skiros_py.simulation.pybullet.cell import PyBulletCell

        if not isinstance(self.cell, PyBulletCell):
            raise UsageError("there is no simulation behind a fake robot: leave out --fake")
        return self.cell

    # ------------------------------------------------------------------ digest and end

    def _digest_change(self, change: Change) -> None:
        self._digest.update(json.dumps(change.as_json(), sort_keys=True).encode())

    def _digest_state(self) -> None:
        if not self.options.fake and self.cycle.board.snapshot.cycle % _HASH_EVERY == 0:
            self._digest.update(self.simulation.state_bytes())

    def close(self) -> None:
        """Ends all processes and the simulation; may be called twice."""
        self._closed = True
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def open_world(scene: str) -> World:
    """Loads the ontology and a scene, with what plug-ins bring of ontologies and reasoners; no robots, no physics.

    A plug-in that does not load is left out, and logged as a warning.

    Raises:
        UnknownName: No such scene.
        FileError: A file cannot be read or understood.
    """
    world, faults = _opened(scene)
    _warn(faults)
    return world


def _opened(scene: str) -> tuple[World, tuple[PluginFault, ...]]:
    path = find_scene(scene)
    ontology, reasoners, faults = _installed()
    return load_scene(ontology, path, ontology_paths(), reasoners=reasoners), faults


def _installed() -> tuple[Ontology, Reasoners, tuple[PluginFault, ...]]:
    """Loads what plug-ins bring to a world, and the faults of those that do not load."""
    ontology, misfits = load_installed(ontology_paths())
    reasoners, unusable = load_reasoners(ontology)
    return ontology, reasoners, (*unusable, *misfits)


def _warn(faults: Sequence[PluginFault]) -> None:
    for fault in faults:
        _log.warning("%s", fault)


def open_data(path: str | Path, scene: str | None = None, *, create: bool = True) -> DataDirectory:
    """Opens a data directory: a world that is still there when the process is gone. Close it, or use it in a ``with``.

    A plug-in that does not load is left out, and logged as a warning.

    Args:
        path: The folder; made where it is missing.
        scene: Name or path of the scene that is the first content of a new one; later it counts no more.
        create: False where a folder without a world is a mistake.

    Raises:
        UnknownName: No such scene.
        FileError: Another process uses the folder, it cannot be read or written, or a file is broken.
    """
    from skiros_py.world.journal import DataDirectory  # most runs keep nothing

    file = None if scene is None else find_scene(scene)
    ontology, reasoners, faults = _installed()
    _warn(faults)
    return DataDirectory.open(Path(path), ontology, reasoners, file, imports=ontology_paths(), create=create)


def scene_title(scene: str) -> str:
    """Returns the name of a scene given by name or path."""
    return find_scene(scene).stem
