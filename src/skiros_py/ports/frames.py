"""The frame tree: where robots, their links and their devices are in one cycle, as their sensors say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Any

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.adapters import Ports
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.ports.device_faults import KindGuard
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.values import Snapshot

MAP = "map"
"""Name of the frame in which everything is."""


class FrameTree:
    """Where robots, links and devices are in one cycle; each pose is computed when it is first asked for.

    The frame of a device is the platform on which bodies stand, the link that it names first (the tip of an arm, the
    optical frame of a camera), the frame of the device on which it is mounted, or the place of one without a robot.

    Args:
        cell: The cell.
        snapshot: What the devices said in that cycle.
        ports: Where the kinematics of robots are found.
        guard: Calls the functions of kinds of device.
        mountings: Poses of frames of devices in the links that they name, by id, where they were measured.

    Attributes:
        snapshot: What the devices said in that cycle.
    """

    def __init__(
        self,
        cell: CellSpec,
        snapshot: Snapshot,
        ports: Ports,
        guard: KindGuard,
        mountings: Mapping[str, Pose] = MappingProxyType({}),
    ) -> None:
        self.snapshot = snapshot
        self._cell = cell
        self._ports = ports
        self._guard = guard
        self._mountings = mountings
        self._groups = {device.id: group for group in cell.groups for device in group.devices}
        self._links: dict[tuple[str, str], Pose | None] = {}
        self._devices: dict[str, Pose | None] = {}

    def robot(self, device: str) -> Pose:
        """Returns the pose in the map of the robot that has a device, as localised."""
        return self._groups[device].pose(self.snapshot, self._guard)

    def link(self, device: str, link: str) -> Pose | None:
        """Returns the pose in the map of a link of the robot that has a device; None without kinematics of that robot.

        Raises:
            UnknownName: The robot has no such link.
        """
        group = self._groups[device]
        if (group.id, link) not in self._links:
            kinematics = self._ports.find(Kinematics, device)
            own = None if kinematics is None else kinematics.pose(link, self.joints(group))
            self._links[group.id, link] = None if own is None else group.pose(self.snapshot, self._guard) @ own
        return self._links[group.id, link]

    def device(self, id_: str) -> Pose | None:
        """Returns the pose of a device's frame in the map; None for what is no device, or has no frame of its own."""
        if id_ not in self._devices:
            group = self._groups.get(id_)
            try:
                self._devices[id_] = None if group is None else self._frame(group, group.device(id_))
            except DeviceError:  # of a device that was switched off
                self._devices[id_] = None
        return self._devices[id_]

    def located(self, id_: str) -> Pose:
        """Returns the pose of a device's frame in the map.

        Raises:
            DeviceError: It is unknown.
        """
        pose = self.device(id_)
        if pose is None:
            reasons = [
                why for device, why in self._guard.off.items() if self._groups.get(device) is self._groups.get(id_)
            ]
            why = "; ".join(reasons) or "there are no kinematics of its robot"
            raise DeviceError(f"the place of {id_} is unknown: {why}")
        return pose

    def devices(self) -> dict[str, Pose]:
        """Returns the poses in the map of the frames of all devices, by id, as far as they are known."""
        return {id_: pose for id_ in self._groups if (pose := self.device(id_)) is not None}

    def platforms(self) -> dict[str, Pose]:
        """Returns the poses in the map of all devices on which bodies may stand, by id, as far as they are known."""
        carriers = [device.id for group in self._cell.groups for device in group.devices if device.carries]
        return {id_: pose for id_ in carriers if (pose := self.device(id_)) is not None}

    def joint_positions(self) -> dict[str, float]:
        """Returns the positions of all joints by "robot/joint", as the devices say [rad or m].

        Those of a robot are left out while the kind of one of its devices fails.
        """
        found: dict[str, float] = {}
        for group in self._cell.groups:
            with suppress(DeviceError):
                found |= {f"{group.id}/{name}": at for name, at in self.joints(group).items()}
        return found

    def joints(self, group: RobotSpec) -> dict[str, float]:
        """Returns the positions of a robot's joints, as its devices say [rad or m]."""
        found: dict[str, float] = {}
        for device in group.devices:
            if device.joint_names and device.id in self.snapshot.devices:
                state = self.snapshot.devices[device.id]
                found |= zip(device.joint_names, self._guard.call(device, "joint_positions", state), strict=True)
        return found

    def transforms(self) -> Iterator[tuple[str, str, Pose]]:
        """Yields all frames: the parent, the frame, and its pose in the parent.

        Robots are named by the id of what moves them, else by their own; links "robot/link"; devices by their ids. The
        place of a device without a robot is "device/root".
        """
        for group in self._cell.groups:
            yield from self.transforms_of(group)

    def transforms_of(self, group: RobotSpec) -> Iterator[tuple[str, str, Pose]]:
        """Yields the frames of one robot, or of a device without a robot, as :meth:`transforms` does."""
        root = _root(group)
        yield MAP, root, group.pose(self.snapshot, self._guard)
        kinematics = self._ports.find(Kinematics, group.devices[0].id) if group.devices else None
        links = {} if kinematics is None else kinematics.poses(self.joints(group))
        for link, pose in links.items():
            yield root, f"{group.id}/{link}", pose
        for device in group.devices:
            if device.id != root:
                yield from self._mount(group, device, links)

    def _mount(
        self, group: RobotSpec, device: DeviceSpec[Any, Any], links: Mapping[str, Pose]
    ) -> Iterator[tuple[str, str, Pose]]:
        if device.frame_names and device.frame_names[0] in links:
            yield f"{group.id}/{device.frame_names[0]}", device.id, self._mountings.get(device.id, Pose())
        elif (pose := self.device(device.id)) is not None:
            yield (device.mounted_on, device.id, Pose()) if device.mounted_on else (MAP, device.id, pose)

    def _frame(self, group: RobotSpec, device: DeviceSpec[Any, Any]) -> Pose | None:
        if isinstance(device, MobileSpec):
            return group.pose(self.snapshot, self._guard)
        if device.carries:
            platform: Pose | None = self._guard.call(device, "platform", self.snapshot.devices[device.id])
            if platform is not None:
                return group.pose(self.snapshot, self._guard) @ platform
            return self.link(device.id, device.platform_link) if device.platform_link else self.robot(device.id)
        if device.frame_names:
            link = self.link(device.id, device.frame_names[0])
            return None if link is None else link @ self._mountings.get(device.id, Pose())
        if device.mounted_on:
            return self.device(device.mounted_on)
        return None if group in self._cell.robots else self.robot(device.id) @ self._mountings.get(device.id, Pose())


def _root(group: RobotSpec) -> str:
    if group.carrier is not None:
        return group.carrier.id
    return f"{group.id}/root" if group.has(group.id) else group.id


class Frames:
    """The frame trees of a cell; the last one is kept, so that all behaviours of a cycle share it.

    Args:
        cell: The cell.
        ports: Where the kinematics of robots are found.
        guard: Calls the functions of kinds of device.
    """

    def __init__(self, cell: CellSpec, ports: Ports, guard: KindGuard) -> None:
        self._cell = cell
        self._ports = ports
        self._guard = guard
        self._last: FrameTree | None = None
        devices = [device for group in cell.groups for device in group.devices]
        self._mountings = {device.id: device.mounting for device in devices if device.mounting != Pose()}

    def mounting(self, device: str) -> Pose:
        """Returns the pose of a device's frame in the link that it names."""
        return self._mountings.get(device, Pose())

    def mount(self, device: str, pose: Pose) -> None:
        """Takes over where a device's frame was found, in the link that it names."""
        self._mountings = {**self._mountings, device: pose}
        self._last = None

    def kinematics(self, group: RobotSpec) -> Kinematics | None:
        """Returns the kinematics of a robot; None where there are none."""
        return self._ports.find(Kinematics, group.devices[0].id) if group.devices else None

    def at(self, snapshot: Snapshot) -> FrameTree:
        """Returns the frame tree of the cycle of a snapshot; for any thread."""
        tree = self._last
        if tree is None or tree.snapshot is not snapshot:
            tree = self._last = FrameTree(self._cell, snapshot, self._ports, self._guard, self._mountings)
        return tree
