"""The port to kinds of device, complete in one class, and the kinds found by the entry-point group ``skiros.devices``.

A *kind* is a subclass of :class:`DeviceSpec`, announced by an entry point of the group ``skiros.devices``; an instance
of it describes one device. Nothing outside a kind's own module, and what is made for it, knows how its states look.
"""

from __future__ import annotations

import dataclasses
import math
import typing
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar, runtime_checkable

import numpy as np

from skiros_py.errors import DescriptionError, DeviceError
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.kinematics import BASE_LINK, Kinematics
from skiros_py.ports.paths import BaseLeg, BasePath, Path
from skiros_py.ports.simulation import SimulatedRobot

_SHORT = 0.002
"""A shorter way counts as none [m]."""
_THERE, _FACING = 0.04, math.radians(3.0)
"""Distance from the end of a path at which a base has arrived, for displays [m, rad]."""


T = TypeVar("T")
StateT = TypeVar("StateT")
TargetT = TypeVar("TargetT")
Follower = Generator[tuple[float, TargetT], None, bool]
"""What drives a base along a path: see :meth:`MobileSpec.follow`."""


class Individual(Protocol):
    """An individual of the world model, as a kind of device reads it.

    Each method raises :class:`~skiros_py.errors.DescriptionError`, which names the individual and the property, where
    the property is missing or of another type.
    """

    @property
    def id(self) -> str:
        """Its element id."""

    def number(self, property_: str, default: float | None = None) -> float:
        """Returns a number; the default where the property is missing."""

    def text(self, property_: str, default: str | None = None) -> str:
        """Returns a text; the default where the property is missing."""

    def vector(
        self, property_: str, length: int | None = None, default: tuple[float, ...] | None = None
    ) -> tuple[float, ...]:
        """Returns numbers, so many where a length is given; the default where the property is missing."""

    def pose(self, property_: str = "sk:pose") -> Pose | None:
        """Returns a pose in the map, or in the frame of the individual's ``sk:poseFrame``; None where it has none."""

    def owner(self, class_: str) -> str | None:
        """Returns the id of the individual of a class that has this one as a piece (``sk:hasA``); None for none."""


@dataclass(frozen=True)  # with slots, DeviceSignal[State](…) fails before Python 3.14
class DeviceSignal(Generic[StateT]):
    """A value that a device offers in each cycle: to conditions, to other signals and to people.

    Attributes:
        name: Its name, unique in the device ("force").
        read: Takes it out of a state: a truth value, a number, or numbers.
        unit: Unit ("N", "m", "rad/s"); empty for truth values and pure numbers.
        help: Its meaning, in a few words.
        frame: Frame in which it is given: "map", "own" for that of the device; empty where that does not matter.
    """

    name: str
    read: Callable[[StateT], bool | float | tuple[float, ...]]
    unit: str = ""
    help: str = ""
    frame: str = ""


@dataclass(frozen=True)
class Contribution(Generic[TargetT]):
    """What one of several runs wants of a device that they share.

    Attributes:
        source: Name of the run's module, for messages.
        target: The target.
        weight: Its weight among the others.
    """

    source: str
    target: TargetT
    weight: float = 1.0


class DeviceModel(Protocol):
    """A device that a computer stands in for: without physics (the fake), or in a simulation."""

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""

    def command(self, target: Any | None) -> None:
        """Sets the target for the coming period; None for the device's default safe behaviour (an arm brakes)."""

    def state(self) -> Any:
        """Returns what its sensors say; called once in each cycle, after the period."""


@runtime_checkable
class WiredModel(Protocol):
    """A model that other devices are connected to, such as the power supply of what moves a robot."""

    def wire(self, models: Mapping[str, Any]) -> None:
        """Connects it, once, before the first cycle.

        Args:
            models: The models of all devices of the cell, by id.
        """


@dataclass(slots=True)
class FakeRobot:
    """A robot without physics, for the models of its devices.

    Attributes:
        period: Length of one control cycle [s].
        pose: Its pose in the map in this cycle, as the device that moves it says.
    """

    period: float = 1.0 / 200.0
    pose: Pose = field(default_factory=Pose)


@dataclass(frozen=True, slots=True)
class DeviceSpec(ABC, Generic[StateT, TargetT]):
    """One device, and what its kind can do.

    Class attributes:
        kind: Name of the kind ("arm"), for people and in recordings.
        device_class: Class of the ontology ("sk:Arm"). Of several kinds the one with the most specific class counts.
        state_type: Type of its states, a frozen dataclass; None for a device that is only asked (a camera).
        target_type: Type of its targets, a frozen dataclass; None for a sensor.
        signals: The values that it offers in each cycle.
        carries: True where bodies may stand on it. Those that name it as their ``sk:poseFrame`` have their ``sk:pose``
            in its frame and move with it; in a simulation they are bolted to :attr:`platform_link`.
        jog: Modules with which a person moves it by a small step, or home; the first is the usual one.
        teach: Modules that learn something from its current state; the first is the usual one.

    Attributes:
        id: Its element id.
    """

    kind: ClassVar[str]
    device_class: ClassVar[str]
    state_type: ClassVar[type | None] = None
    target_type: ClassVar[type | None] = None
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = ()
    carries: ClassVar[bool] = False
    jog: ClassVar[tuple[str, ...]] = ()
    teach: ClassVar[tuple[str, ...]] = ()

    id: str

    @classmethod
    @abstractmethod
    def read(cls, individual: Individual) -> Self:
        """Reads a device from its individual.

        Raises:
            DescriptionError: It lacks something; the message names the property.
        """

    @abstractmethod
    def fake(self, robot: FakeRobot) -> DeviceModel | None:
        """Returns a model of it without physics, which obeys at once; None for a device without a state.

        Args:
            robot: The robot that it belongs to.
        """

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> DeviceModel | None:  # noqa: ARG002
        """Returns its controller in a simulation, in the words of the simulation port; None where it has no state.

        Args:
            robot: The robot that it belongs to, in the engine.
            rng: Source of everything that it draws, its sensor noise for instance.

        Raises:
            DeviceError: Devices of this kind cannot be simulated.
        """
        raise DeviceError(f"{self.id}: devices of kind '{self.kind}' cannot be simulated")

    # ------------------------------------------------------------------ in each cycle

    def still(self, state: StateT) -> bool:  # noqa: ARG002 - for kinds that move
        """Returns True when nothing of it moves that a stop would have to wait for."""
        return True

    def check(self, target: TargetT) -> None:
        """Refuses a malformed target where it is given, so that the fault is its author's and not the cell's.

        Raises:
            DeviceError: It is no target of this kind.
        """
        if self.target_type is None or not isinstance(target, self.target_type):
            wanted = f"is commanded by a {self.target_type.__name__}" if self.target_type else "takes no commands"
            raise DeviceError(f"{self.id}: it {wanted}, not by {target!r:.100}")

    def scaled(self, target: TargetT, rate: float) -> TargetT:  # noqa: ARG002 - for kinds that take speeds
        """Returns the target for a run whose clock goes at a rate between 0 and 1, because it is being paused.

        A target that is sampled from a trajectory by the run's clock stays as it is; a speed slows down.
        """
        return target

    def mixed(self, contributions: Sequence[Contribution[TargetT]]) -> TargetT:
        """Merges what several runs want of it in one cycle: the mix rule of the kind. It runs in the control thread.

        Raises:
            DeviceError: Devices of this kind cannot be shared.
        """
        sources = " and ".join(one.source for one in contributions)
        raise DeviceError(f"{self.id}: {sources} command it in one cycle, and devices of kind '{self.kind}' cannot mix")

    @classmethod
    def mixes(cls) -> bool:
        """Returns True when the kind has a mix rule, so that runs may share its devices."""
        return cls.mixed is not DeviceSpec.mixed

    # ------------------------------------------------------------------ what it offers

    def signal(self, name: str) -> DeviceSignal[StateT] | None:
        """Returns the signal of that name; None where it offers none."""
        return next((signal for signal in self.signals if signal.name == name), None)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints of the robot's model that it moves or measures."""
        return ()

    def joint_positions(self, state: StateT) -> tuple[float, ...]:  # noqa: ARG002 - for kinds with joints
        """Returns the position of each of :attr:`joint_names` [rad or m]."""
        return ()

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Links of the robot's model that others may ask for: its tip, its optical frame."""
        return ()

    @property
    def mounting(self) -> Pose:
        """Pose of its frame in the link that it names first, as it was measured."""
        return Pose()

    @property
    def mounted_on(self) -> str:
        """Id of the device whose frame it shares, where it names no link of its own: a gripper's arm."""
        return ""

    # ------------------------------------------------------------------ what stands on it

    @property
    def platform_link(self) -> str:
        """Link of the robot's model on which bodies stand, where it :attr:`carries` any; a simulation needs it."""
        return ""

    def platform(self, state: StateT) -> Pose | None:  # noqa: ARG002 - for kinds that know it themselves
        """Returns the pose of that link in the frame of the robot; None to have it from the robot's kinematics."""
        return None

    # ------------------------------------------------------------------ planned motions, for displays

    def planned_poses(self, request: Any, plan: Any, kinematics: Kinematics | None) -> Sequence[Pose]:  # noqa: ARG002
        """Returns the poses in the map along a planned motion; none for kinds that plan no motions.

        Args:
            request: The request to its planner, which names this device as ``device``.
            plan: The answer of the planner.
            kinematics: Kinematics of its robot's model; None if there are none.
        """
        return ()

    @classmethod
    def plans_motions(cls) -> bool:
        """Returns True when devices of the kind have planned motions to show."""
        return cls.planned_poses is not DeviceSpec.planned_poses

    def has_arrived(self, state: StateT, robot: Pose, request: Any, plan: Any, cycles: float) -> bool:  # noqa: ARG002
        """Returns whether it stands at the end of a planned motion.

        Args:
            state: Its state.
            robot: Pose of its robot in the map, as localised.
            request: The request to its planner.
            plan: The answer of the planner.
            cycles: Number of control cycles since the request.
        """
        return self.still(state)

    # ------------------------------------------------------------------ plain data, faults

    def encode(self, value: StateT | TargetT) -> dict[str, Any]:
        """Returns a state or target as data that JSON can hold."""
        plain: dict[str, Any] = to_plain(value)
        return plain

    def decode_state(self, data: Mapping[str, Any]) -> StateT:
        """Reads a state that :meth:`encode` wrote."""
        return typing.cast("StateT", from_plain(self.state_type, data))

    def decode_target(self, data: Mapping[str, Any]) -> TargetT:
        """Reads a target that :meth:`encode` wrote.

        Raises:
            DeviceError: It is no such target.
        """
        try:
            target = typing.cast("TargetT", from_plain(self.target_type, data))
        except (KeyError, TypeError, ValueError) as error:
            raise DeviceError(f"{self.id}: no target of kind '{self.kind}': {error}") from error
        self.check(target)
        return target

    def noisy(self, state: StateT, sigma: float, rng: np.random.Generator) -> StateT:  # noqa: ARG002
        """Returns a state with noise of a standard deviation on what it measures, for tests.

        Raises:
            DeviceError: Nothing of it can be noisy.
        """
        raise DeviceError(f"{self.id}: there is no noise for devices of kind '{self.kind}'")


@dataclass(frozen=True, slots=True)
class LocalisingSpec(DeviceSpec[StateT, TargetT]):
    """A device that knows the pose of its robot: a localiser, or what moves the robot, by odometry.

    The localiser of a robot takes precedence over the device that moves it.
    """

    @abstractmethod
    def pose(self, state: StateT) -> Pose:
        """Returns the pose of the robot's base frame in the map."""


@dataclass(frozen=True, slots=True)
class MobileSpec(LocalisingSpec[StateT, TargetT]):
    """A device that carries its robot through the map: wheels, legs, rotors. Its frame is that of the robot.

    Attributes:
        start: Pose in the map where it stands at the start.
        footprint: Corners of its outline on the floor in its own frame [m], counter-clockwise.
    """

    carries: ClassVar[bool] = True

    start: Pose
    footprint: tuple[tuple[float, float], ...]

    @property
    def platform_link(self) -> str:
        """Its own link: bodies stand on it as on the robot."""
        return BASE_LINK

    @property
    def drives_sideways(self) -> bool:
        """Whether it is omnidirectional: paths may lead in any direction from its heading."""
        return False

    def direct_path(self, start: Pose, goal: Pose) -> Path:
        """Returns the path on which it drives a short way where nothing obstructs it: a turn, a straight leg, a turn.

        The leg is driven forwards or backwards, whichever needs the smaller turn.
        """
        x, y, _ = (start.inverse() @ goal).position
        if math.hypot(x, y) < _SHORT:
            return BasePath((), goal.yaw)
        return BasePath((BaseLeg(goal.position[0], goal.position[1], backwards=x < 0.0),), goal.yaw)

    def planned_poses(self, request: Any, plan: Any, kinematics: Kinematics | None) -> Sequence[Pose]:  # noqa: ARG002
        """Returns the start of a path, the end of each leg, and the pose at the end."""
        ends: dict[float, Pose] = {}
        for driven, pose in plan.poses(request.start):
            ends.setdefault(driven, pose)
        return [*(end for driven, end in ends.items() if driven.is_integer()), pose]

    def has_arrived(self, state: StateT, robot: Pose, request: Any, plan: Any, cycles: float) -> bool:  # noqa: ARG002
        """Returns whether it stands near the goal of a path."""
        away = math.dist(request.goal.position[:2], robot.position[:2])
        return self.still(state) and away < _THERE and abs(wrap_angle(request.goal.yaw - robot.yaw)) < _FACING

    def follow(  # kinds that drive define it
        self,
        path: Path,  # noqa: ARG002
        pose: Callable[[], Pose],  # noqa: ARG002
        *,
        max_linear: float = math.inf,  # noqa: ARG002
        max_angular: float = math.inf,  # noqa: ARG002
    ) -> Follower[TargetT]:
        """Yields for each cycle how many legs of a path were driven (1.5: half of the second), and the next target.

        Args:
            path: The path.
            pose: Returns the pose of the robot in the map in this cycle, as localised.
            max_linear: Greatest speed [m/s], besides its own limit.
            max_angular: Greatest turning speed [rad/s], besides its own limit.

        Returns:
            True at the end of the path; False where it got too far away from it.

        Raises:
            DeviceError: Devices of this kind follow no paths, or not such a one.
        """
        raise DeviceError(f"{self.id}: devices of kind '{self.kind}' follow no paths")


def read_mobile(individual: Individual) -> tuple[Pose, tuple[tuple[float, float], ...]]:
    """Reads where a device that carries its robot starts, and its outline on the floor.

    Raises:
        DescriptionError: The individual lacks one of them.
    """
    start = individual.pose()
    if start is None:
        raise DescriptionError(f"{individual.id} has no sk:pose: the scene must say where it starts")
    return start, read_footprint(individual)


def read_footprint(individual: Individual) -> tuple[tuple[float, float], ...]:
    """Reads the corners of an outline on the floor [m].

    Raises:
        DescriptionError: There are fewer than three.
    """
    corners = individual.vector("sk:footprint")
    if len(corners) < 6 or len(corners) % 2:
        raise DescriptionError(f"{individual.id}: sk:footprint takes x and y of at least three corners")
    return tuple(zip(corners[0::2], corners[1::2], strict=True))


def require_numbers(device: str, command: object, *numbers: Iterable[float]) -> None:
    """Refuses numbers that are infinite, NaN or none.

    Raises:
        DeviceError: One of them is.
    """
    try:
        good = all(math.isfinite(number) for some in numbers for number in some)
    except TypeError:
        good = False
    if not good:
        raise DeviceError(f"{device}: a command is made of finite numbers: {command}")


# ---------------------------------------------------------------------- plain data


def to_plain(value: Any) -> Any:
    """Returns dataclasses, poses, tuples and mappings of them as data that JSON can hold."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | frozenset):
        return [to_plain(one) for one in value]
    return value.item() if isinstance(value, np.generic) else value


def from_plain(type_: Any, data: Any) -> Any:
    """Reads what :func:`to_plain` wrote.

    Args:
        type_: What is wanted: a dataclass, a tuple of one type of value, a number, a text.
        data: Plain data.

    Raises:
        KeyError, TypeError, ValueError: It is no such thing.
    """
    if dataclasses.is_dataclass(type_) and isinstance(type_, type):
        hints = _hints(type_)
        unknown = sorted(set(data) - hints.keys())
        if unknown:
            raise ValueError(f"unknown: {', '.join(unknown)}; there is {', '.join(hints)}")
        fields = dataclasses.fields(type_)
        wanted = [f for f in fields if f.name in data or (f.default, f.default_factory) == (dataclasses.MISSING,) * 2]
        return type_(**{field.name: from_plain(hints[field.name], data[field.name]) for field in wanted})
    if typing.get_origin(type_) is tuple:
        arguments = typing.get_args(type_)
        each = (arguments[0],) * len(data) if arguments[1:] == (...,) else arguments
        return tuple(from_plain(one, item) for one, item in zip(each, data, strict=True))
    if type_ is float and not isinstance(data, bool):
        return float(data)
    if type_ in (int, bool, str) and type(data) is not type_:
        raise TypeError(f"a {type_.__name__}, not {data!r}")
    return data


@lru_cache(maxsize=256)
def _hints(type_: type) -> dict[str, Any]:
    return typing.get_type_hints(type_)
