"""The runtime: a world and a cell's devices under one control cycle, with skill managers and streams for observers."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, Self, TypeVar, cast

import numpy as np

from skiros_py.errors import UnknownName, UsageError, WrongState
from skiros_py.execution.claims import Claims
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.floor import FloorAreas
from skiros_py.execution.loader import read_configuration
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.signals import Signals
from skiros_py.execution.skill_manager import CellModules, SkillManager
from skiros_py.execution.watchdog import Watchdog
from skiros_py.interruptions import WatchedTask
from skiros_py.listeners import Listeners
from skiros_py.ports.adapters import NO_PORTS, Ports
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.frames import Frames
from skiros_py.ports.signals import SignalProvider
from skiros_py.ports.values import Pending
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.context import Questions, RunContext
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.change import Change
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AGENT, HAS_A
from skiros_py.world.world import World


def agents_of(view: WorldView, cell: CellSpec) -> tuple[str, ...]:
    """Returns who may have a skill manager: the subsystems of each robot, and devices that belong to no robot."""
    parts = [part for robot in cell.robots for part in view.objects(robot.id, HAS_A)]
    single = [device.id for group in cell.single for device in group.devices]
    return tuple(e for e in (*parts, *single) if view.ontology.is_a(view.element(e).type, AGENT))


class Managers(Mapping[str, SkillManager]):
    """The skill managers that are there, by the id of their subsystem.

    Args:
        cell: What they share.

    Attributes:
        claims: Who may use which device.
        documents: Documents that every manager runs as modules, by name: what is put here runs from its next start on.
    """

    def __init__(self, cell: CellModules) -> None:
        self.claims = cell.claims
        self.documents = cell.documents
        self._cell = cell
        self._watching = False
        self._managers = cell.managers
        self._seen: set[str] = set()

    def __getitem__(self, agent: str) -> SkillManager:
        return self._managers[agent]

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._managers))

    def __len__(self) -> int:
        return len(self._managers)

    def open_all(self) -> None:
        """Opens one manager for each subsystem of each robot, and for each device without a robot that acts."""
        for agent in agents_of(self._cell.context.world, self._cell.context.cell):
            self.open(agent)

    def open(self, agent: str) -> SkillManager:
        """Opens the skill manager of a subsystem and registers what it can do; in the place of one that was lost.

        Raises:
            UnknownName: There is no such element.
            UsageError: It is there already, or the element is no subsystem that could have one.
        """
        view = self._cell.context.world
        if agent in self._managers and not self._managers[agent].lost:
            raise UsageError("the skill manager of {agent} is there already", agent=agent)
        if not view.ontology.is_a(view.element(agent).type, AGENT):
            raise UsageError(f"{agent} is a {view.element(agent).type}, and only an {AGENT} has a skill manager")
        if agent in self._managers:
            self.close(agent)
        manager = SkillManager(agent, self._cell)
        manager.register(adopt=agent not in self._seen)
        self._seen.add(agent)
        self._managers[agent] = manager
        if self._watching and not self._cell.cycle.halted:
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

    def lose(self, task: WatchedTask) -> None:
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


T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class LibraryCall:
    """One request that a module made to an adapter.

    Attributes:
        request: The request (a ``MotionRequest``, a ``DetectionRequest``, …).
        answer: On its way, or there: what the port says of such a request.
    """

    request: Any
    answer: Pending[Any]


class LibraryMonitor(Ports):
    """Adapters whose requests are published in order; :class:`skiros_py.ports.adapters.Ports` for modules.

    What an adapter answers at once, such as kinematics, is not published.

    Args:
        ports: The adapters.
    """

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        self._listeners = Listeners[[LibraryCall]]("requests to adapters")
        self._observed: dict[int, _Observed] = {}

    def find(self, protocol: Callable[..., T], device: str | None = None) -> T | None:
        """Returns the adapter for a device, or for the cell; None where there is none."""
        adapter = self._ports.find(protocol, device)
        if adapter is None:
            return None
        return cast("T", self._observed.setdefault(id(adapter), _Observed(adapter, self._listeners.notify)))

    def subscribe(self, listener: Callable[[LibraryCall], None]) -> Callable[[], None]:
        """Calls the listener in the control thread with each request; it must be quick.

        Returns:
            How to end that.
        """
        return self._listeners.add(listener)


class _Observed:
    """An adapter; each method that answers later is published."""

    def __init__(self, adapter: object, publish: Callable[[LibraryCall], None]) -> None:
        self._adapter = adapter
        self._publish = publish

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._adapter, name)
        if not callable(found):
            return found

        def method(*args: Any, **options: Any) -> Any:
            answer = found(*args, **options)
            if args and hasattr(answer, "latency"):
                self._publish(LibraryCall(args[0], answer))
            return answer

        self.__dict__[name] = method
        return method


_SHOWN = 16


class RunDigest:
    """Hashes the states and changes of a run; any thread may add to it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._hash = hashlib.sha256()

    def begin(self, state: bytes) -> None:
        """Forgets everything, and begins with a state."""
        with self._lock:
            self._hash = hashlib.sha256(state)

    def add(self, state: bytes) -> None:
        """Takes in a state."""
        with self._lock:
            self._hash.update(state)

    def add_change(self, change: Change) -> None:
        """Takes in a change of the world; any thread may have written it."""
        self.add(json.dumps(change.as_json(), sort_keys=True).encode())

    def __str__(self) -> str:
        with self._lock:
            return self._hash.hexdigest()[:_SHOWN]


class Work(Protocol):
    """What runs in the control cycle and comes to an end."""

    @property
    def done(self) -> bool:
        """True when it is over."""


@dataclass(frozen=True, slots=True)
class RuntimeOptions:
    """How to set up a runtime.

    Attributes:
        kind: Kind of cell driver whose implementations of skills are used; the driver's own where left out.
        seed: Seed of every random choice.
        pace: Simulated seconds per wall second; None for lockstep, as fast as possible.
        ports: The adapters for motion and perception.
        config: Values of configuration parameters by "module.key".
        signals: What computes signals from those of the devices.
        sources: Distribution of each of them, in the same order; none where they are not from plug-ins.
        signals_missing: Why plug-ins bring no signals that others may read; empty where all do.
        overrun: Wall time for which one module may hold the control cycle [s]; None for the watchdog's own limit.
    """

    kind: str | None = None
    seed: int | Sequence[int] = 0
    pace: float | None = None
    ports: Ports = NO_PORTS
    config: Mapping[str, Any] = field(default_factory=dict)
    signals: Sequence[SignalProvider] = ()
    sources: Sequence[str] = ()
    signals_missing: str = ""
    overrun: float | None = None


class Runtime:
    """Everything that runs modules on a cell. It is watched while it is used in a ``with``.

    Args:
        world: The live world model.
        spec: The cell as described in it.
        driver: The cell's driver; the caller closes it.
        skills: All skills found.
        primitives: All primitives found, by name.
        options: How to set it up.

    Attributes:
        world: The live world model.
        cycle: The control cycle.
        signals: The signals of the current cycle.
        context: What modules may reach.
        managers: The skill managers by the id of their subsystem.
        monitor: Module events.
        asked: What modules ask of adapters.
        questions: What the robots ask a person.
        watchdog: Interrupts what holds the control cycle.

    Raises:
        UsageError: The configuration is for modules or parameters that do not exist, or cannot be read.
    """

    def __init__(
        self,
        world: World,
        spec: CellSpec,
        driver: CellDriver,
        skills: Sequence[Skill],
        primitives: Mapping[str, type[Primitive[Any]]],
        options: RuntimeOptions = RuntimeOptions(),
    ) -> None:
        config = read_configuration(options.config, primitives, world)
        board = DeviceBoard(driver)
        world.clock = lambda: board.snapshot.time
        self.world = world
        self.monitor = Monitor()
        self.asked = LibraryMonitor(options.ports)
        self.questions = Questions()
        self.cycle = ControlCycle(board, options.pace)
        self.signals = self.cycle.signals = Signals(board, options.signals, options.sources, options.signals_missing)
        world.sensors = self.signals
        claims = Claims()
        self.context = RunContext(
            world=world,
            board=board,
            ports=self.asked,
            cell=spec,
            frames=Frames(spec, options.ports, board.guard),
            rng=np.random.default_rng(options.seed),
            lockstep=options.pace is None,
            clock=board,
            questions=self.questions,
            floor=FloorAreas(board, spec.robots, claims),
            signals=self.signals,
            waiting=self.cycle.activity.waiting,
        )
        kind = driver.kind if options.kind is None else options.kind
        watches = Watches(world)
        cell = CellModules(skills, primitives, self.context, self.cycle, self.monitor, watches, kind, config, claims)
        self.managers = Managers(cell)
        self.managers.open_all()
        self.watchdog = Watchdog(self.cycle, options.overrun)
        self.watchdog.on_lost(self.managers.lose)

    def finish(self, work: Work, leave: Callable[[], bool] = lambda: False) -> bool:
        """Runs cycles until a task or module is done.

        When everything is halted meanwhile, it waits for standstill as well; nothing starts again before a reset.

        Args:
            work: A module, a task of the cycle or of the task manager.
            leave: Asked in each cycle whether to wait no longer.

        Returns:
            True when the work ended by itself.
        """
        while not (work.done or leave() or self.cycle.halted):
            self.cycle.step()
        if self.cycle.halted:
            self.cycle.stop_all(self.cycle.halted)
        return work.done and not self.cycle.halted

    def require_ready(self) -> None:
        """Requires that modules may be started.

        Raises:
            WrongState: Everything was halted and has not been reset since.
        """
        if self.cycle.halted:
            raise WrongState(
                "nothing can start: everything was halted ({halted}); look, then reset()", halted=self.cycle.halted
            )

    def __enter__(self) -> Self:
        self.watchdog.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.watchdog.close()
