"""What a primitive may reach besides its parameters, and the effects that it may write."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np

from skiros_py.ports.adapters import Ports
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.frames import Frames
from skiros_py.ports.signals import NO_SIGNALS, SignalReader
from skiros_py.skills.floor import Floor, OpenFloor
from skiros_py.skills.questions import Questions
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.skills.outcome import Outcome
    from skiros_py.skills.primitive import Execution
from collections.abc import Iterable

from skiros_py.errors import UnknownName
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.effects import effects_of, write_effects

T = TypeVar("T")


class Clock(Protocol):
    """The time of one run of a module: it stands still while the run is paused."""

    @property
    def now(self) -> float:
        """Time [s]; only differences mean anything."""
        ...


class Caller(Protocol):
    """How a module calls another one, whose parameters may be left to inference."""

    def __call__(self, module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:
        """Returns the run of another module; tick it to its end, or close it."""
        ...


def _no_manager(module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:  # noqa: ARG001 - the port's signature
    raise RuntimeError(f"{module} cannot be called from here: no skill manager runs this")


@dataclass(frozen=True, slots=True)
class RunContext:
    """One run: its world, devices, adapters, random numbers.

    Attributes:
        world: The live world model.
        board: Snapshot and commands of the present cycle.
        ports: The adapters; see :meth:`port`.
        cell: The cell's description (limits, joints, footprint) as brought up.
        frames: Where robots, links and devices are in a cycle.
        rng: Random numbers of this run; every random choice comes from here.
        lockstep: True when simulated time waits for workers.
        report: Takes (module, progress code, text).
        clock: The time of this module's run.
        questions: Where a person is asked.
        call: Runs another module.
        emit: Takes (name of an event, value as plain data).
        effects: The effects of the skill that this module is part of; None for a module that runs on its own.
        floor: Who may drive where.
        signals: The signals of the present cycle.
        waiting: Says, for as long as it is entered, that a long wait for a worker is no fault.
    """

    world: World
    board: DeviceBoard
    ports: Ports
    cell: CellSpec
    frames: Frames
    rng: np.random.Generator
    lockstep: bool
    report: Callable[[str, int, str], None]
    clock: Clock
    questions: Questions = field(default_factory=Questions)
    call: Caller = _no_manager
    emit: Callable[[str, Any], None] = lambda _event, _value: None
    effects: Effects | None = None
    floor: Floor = field(default_factory=OpenFloor)
    signals: SignalReader = NO_SIGNALS
    waiting: Callable[[], AbstractContextManager[None]] = nullcontext

    @property
    def now(self) -> float:
        """Time of this run [s]: it stands still while the run is paused, so that a trajectory waits, too."""
        return self.clock.now

    def port(self, protocol: Callable[..., T], device: str | None = None) -> T:
        """Returns the adapter for a device: ``context.port(ArmPlanner, "panda_1")``.

        Args:
            protocol: The port's protocol.
            device: Id of the device; None for an adapter that needs none.

        Raises:
            DeviceError: None of the installed adapters serves it, or the cell is without physics and has none.
        """
        return self.ports.port(protocol, device)


class Effects:
    """The effects of one run of a skill.

    Args:
        world: The live world.
        post: The postconditions, over the skill's parameters.
        arguments: The skill's parameters in this run; filled in as they become known.
    """

    def __init__(self, world: World, post: Iterable[Condition], arguments: Mapping[str, Any]) -> None:
        self._world = world
        self._post = {condition.key: condition for condition in post}
        self._arguments = arguments

    def write(self, *keys: str, author: str, reason: str) -> None:
        """Writes some postconditions into the world, after they were sensed.

        Args:
            *keys: Their keys (:attr:`Condition.key`); none at all means every postcondition.
            author: Who sensed it.
            reason: What was sensed ("gap 44 mm, force 30 N").

        Raises:
            UnknownName: The skill has no postcondition of such a key.
            WorldError: The world refused it.
        """
        for key in keys:
            if key not in self._post:
                raise UnknownName("postcondition", key, self._post)
        wanted = [self._post[key] for key in keys] if keys else list(self._post.values())
        with self._world.transaction(author=author, reason=reason) as tx:
            for condition in wanted:
                write_effects(tx, self._world.ontology, effects_of(condition.bind(self._arguments)))
