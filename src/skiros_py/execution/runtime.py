"""The runtime: a world and a cell's devices under one control cycle, with skill managers and a watchdog."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Protocol, Self

import numpy as np

from skiros_py.errors import WrongState
from skiros_py.execution.configuration import check_configuration
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.floor import FloorAreas
from skiros_py.execution.library_monitor import LibraryMonitor
from skiros_py.execution.managers import Managers
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.signals import Signals
from skiros_py.execution.watchdog import Watchdog
from skiros_py.ports.adapters import NO_PORTS, Ports
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.frames import Frames
from skiros_py.ports.signals import SignalProvider
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.questions import Questions
from skiros_py.skills.skill import Skill
from skiros_py.world.world import World


class Work(Protocol):
    """What runs in the control cycle and comes to an end."""

    @property
    def done(self) -> bool:
        """True when it is over."""
        ...


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
        overrun: Wall time for which one module may hold the control cycle [s]; None for the watchdog's own limit.
    """

    kind: str | None = None
    seed: int | Sequence[int] = 0
    pace: float | None = None
    ports: Ports = NO_PORTS
    config: Mapping[str, Any] = field(default_factory=dict)
    signals: Sequence[SignalProvider] = ()
    sources: Sequence[str] = ()
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
        signals: The signals of the present cycle.
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
        check_configuration(options.config, primitives, world)
        board = DeviceBoard(driver)
        world.clock = lambda: board.snapshot.time
        self.world = world
        self.monitor = Monitor()
        self.asked = LibraryMonitor(options.ports)
        self.questions = Questions()
        self.cycle = ControlCycle(board, options.pace)
        self.signals = self.cycle.signals = Signals(board, options.signals, self.cycle.pulse, options.sources)
        world.sensors = self.signals
        self.context = RunContext(
            world=world,
            board=board,
            ports=self.asked,
            cell=spec,
            frames=Frames(spec, options.ports),
            rng=np.random.default_rng(options.seed),
            lockstep=options.pace is None,
            report=lambda _module, _code, _text: None,
            clock=board,
            questions=self.questions,
            floor=FloorAreas(board, spec.robots),
            signals=self.signals,
            waiting=self.cycle.pulse.waiting,
        )
        kind = driver.kind if options.kind is None else options.kind
        self.managers = Managers(
            skills, primitives, self.context, self.cycle, self.monitor, driver=kind, config=options.config
        )
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
            raise WrongState(f"nothing can start: everything was halted ({self.cycle.halted}); look, then reset()")

    def __enter__(self) -> Self:
        self.watchdog.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.watchdog.close()
