"""A robot cell as plain data: what a driver (a simulator or real hardware) needs to know to bring it up.

It is read from the world model once, before anything moves; adapters see this and never the world model.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.calibration import MarkerBoard
from skiros_py.ports.device import DeviceSpec, LocalisingSpec, MobileSpec
from skiros_py.ports.device_faults import KindGuard
from skiros_py.ports.values import Snapshot

SpecT = TypeVar("SpecT", bound=DeviceSpec[Any, Any])


@dataclass(frozen=True, slots=True)
class BodySpec:
    """One body of the scene.

    Attributes:
        id: Its element id.
        type: Its class ("kitting:Starter"); bodies of one type have one solid.
        solid: Its shape, standing on its own frame.
        mass: [kg]; 0 for what never moves.
        pose: Pose of its frame in the map (or in ``carrier``'s base frame), or None: the driver of a simulation draws
            it from the run's seed, somewhere on ``place``'s support surface.
        place: Id of the body that it lies on or in, or None for the floor.
        carrier: Id of the robot base it is fixed to, or None.
        support: Half extents (x, y) [m] of the flat surface on which parts lie; None where nothing can lie.
        support_height: Height of that surface above the body's frame [m].
        support_centre: Middle (x, y) of that surface in the body's frame [m].
        compartment: True for a compartment: a region, not a body of its own; ``solid`` is its inner volume.
        board: What is printed on its upper side; None for nothing.
    """

    id: str
    type: str
    solid: Solid
    mass: float = 0.0
    pose: Pose | None = None
    place: str | None = None
    carrier: str | None = None
    support: tuple[float, float] | None = None
    support_height: float = 0.0
    support_centre: tuple[float, float] = (0.0, 0.0)
    compartment: bool = False
    board: MarkerBoard | None = None


@dataclass(frozen=True)  # without slots: it remembers which of its devices are of a kind
class RobotSpec:
    """One robot: its model and its devices. A device that belongs to no robot is a group of its own, of one device.

    Attributes:
        id: Its element id.
        model: Name of the robot model that the adapters know how to build ("mobile_panda"); empty for none.
        devices: Its devices.
        place: Pose in the map where it stands, for a robot that nothing moves.
        footprint: Corners of its outline on the floor [m], counter-clockwise, for a robot that nothing moves.
        driver: Name of its driver; empty for that of the cell.
        address: Where the driver reaches the hardware, as the driver wants it.
        drivers: Id, driver and address of each of its devices that has a driver or an address of its own.
        adapters: Names of the adapters that it or one of its devices prefers where several could serve, by id; what a
            device names counts before what its robot does.
    """

    id: str
    model: str
    devices: tuple[DeviceSpec[Any, Any], ...] = ()
    place: Pose = field(default_factory=Pose)
    footprint: tuple[tuple[float, float], ...] = ()
    driver: str = ""
    address: str = ""
    drivers: tuple[tuple[str, str, str], ...] = ()
    adapters: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def by_driver(self) -> tuple[RobotSpec, ...]:
        """Returns it as its drivers see it: for each driver and address the devices that are reached there.

        A part without the device that moves the robot stands where the robot starts.
        """
        if not self.drivers:
            return (self,)
        at = {device.id: (self.driver, self.address) for device in self.devices}
        at |= {device: (driver, address) for device, driver, address in self.drivers}
        return tuple(
            replace(
                self,
                devices=tuple(device for device in self.devices if at[device.id] == (driver, address)),
                place=self.start,
                footprint=self.outline,
                driver=driver,
                address=address,
                drivers=(),
            )
            for driver, address in dict.fromkeys(at.values())
        )

    def of(self, type_: type[SpecT]) -> tuple[SpecT, ...]:
        """Returns its devices of a kind."""
        if type_ not in self._of_kind:
            self._of_kind[type_] = tuple(device for device in self.devices if isinstance(device, type_))
        return self._of_kind[type_]

    @cached_property
    def _of_kind(self) -> dict[type, tuple[Any, ...]]:
        """Its devices of each kind that was asked for."""
        return {}

    def device(self, id_: str) -> DeviceSpec[Any, Any]:
        """Returns one of its devices.

        Raises:
            UnknownName: It has no such device.
        """
        found = {device.id: device for device in self.devices}
        if id_ not in found:
            raise UnknownName("device", id_, found, where=f"of '{self.id}'")
        return found[id_]

    def has(self, device: str) -> bool:
        """Returns True when a device of that id is one of its own."""
        return any(own.id == device for own in self.devices)

    @cached_property
    def carrier(self) -> MobileSpec[Any, Any] | None:
        """The device that moves it through the map; None for a robot that stands where it is."""
        return next((device for device in self.devices if isinstance(device, MobileSpec)), None)

    @property
    def start(self) -> Pose:
        """Pose in the map where it stands at the start."""
        return self.place if self.carrier is None else self.carrier.start

    @property
    def outline(self) -> tuple[tuple[float, float], ...]:
        """Corners of its outline on the floor in its own frame [m]; none where it touches no floor."""
        return self.footprint if self.carrier is None else self.carrier.footprint

    @cached_property
    def localiser(self) -> LocalisingSpec[Any, Any] | None:
        """The device that knows its pose: its localiser, else the device that moves it; None where it has neither."""
        devices = (device for device in self.devices if isinstance(device, LocalisingSpec))
        return next((device for device in devices if not isinstance(device, MobileSpec)), self.carrier)

    def pose(self, snapshot: Snapshot, guard: KindGuard) -> Pose:
        """Returns its pose in the map, as localised.

        Raises:
            DeviceError: Its localiser was switched off.
        """
        localiser = self.localiser
        return self.place if localiser is None else guard.pose(localiser, snapshot.devices[localiser.id])


@dataclass(frozen=True, slots=True)
class CellSpec:
    """Everything that stands in the cell at the start.

    Attributes:
        bodies: In the order in which they are built.
        robots: The robots.
        single: Devices that belong to no robot, each as a group of its own.
    """

    bodies: tuple[BodySpec, ...]
    robots: tuple[RobotSpec, ...]
    single: tuple[RobotSpec, ...] = ()

    @property
    def groups(self) -> tuple[RobotSpec, ...]:
        """The robots, and the devices that belong to none."""
        return (*self.robots, *self.single)

    def by_driver(self) -> dict[str, CellSpec]:
        """Returns what each driver brings up, by its name; that of the cell, which has the empty name, is the first.

        The driver of the cell has the bodies, without those that devices of another driver carry.
        """
        robots, single = (
            [part for group in groups for part in group.by_driver()] for groups in (self.robots, self.single)
        )
        away = {device.id for part in (*robots, *single) if part.driver for device in part.devices}
        gone = {body.id for body in self.bodies if body.carrier in away}
        while more := {body.id for body in self.bodies if body.place in gone} - gone:
            gone |= more
        bodies = tuple(body for body in self.bodies if body.id not in gone)
        return {
            driver: CellSpec(
                () if driver else bodies,
                tuple(part for part in robots if part.driver == driver),
                tuple(part for part in single if part.driver == driver),
            )
            for driver in dict.fromkeys(("", *(part.driver for part in (*robots, *single))))
        }

    @property
    def devices(self) -> dict[str, DeviceSpec[Any, Any]]:
        """All devices by id."""
        return {device.id: device for group in self.groups for device in group.devices}

    def of(self, type_: type[SpecT]) -> tuple[SpecT, ...]:
        """Returns all devices of a kind."""
        return tuple(device for group in self.groups for device in group.of(type_))

    def device(self, id_: str, type_: type[SpecT]) -> SpecT:
        """Returns a device of a kind.

        Raises:
            UnknownName: The cell has no such device.
        """
        found = {device.id: device for device in self.of(type_)}
        if id_ not in found:
            raise UnknownName(getattr(type_, "kind", "device"), id_, found, where="in this cell")
        return found[id_]

    def group_of(self, device: str) -> RobotSpec:
        """Returns the robot that a device belongs to, or the group of a device that stands by itself.

        Raises:
            UnknownName: The cell has no such device.
        """
        for group in self.groups:
            if group.has(device):
                return group
        raise UnknownName("device", device, self.devices, where="in this cell")

    def body(self, body_id: str) -> BodySpec:
        """Returns the body with that id.

        Raises:
            KeyError: There is none.
        """
        for body in self.bodies:
            if body.id == body_id:
                return body
        raise KeyError(body_id)
