"""What a primitive holds in its hands: one handle per device, reading this cycle's snapshot, writing its commands."""

from __future__ import annotations

from skiros_py.errors import DeviceError
from skiros_py.robot.driver import CellDriver
from skiros_py.robot.pending import Pending
from skiros_py.robot.values import (
    ArmState,
    ArmTarget,
    BaseState,
    BaseTwist,
    Commands,
    DepthImage,
    GripperState,
    GripperTarget,
    Snapshot,
)

__all__ = ["Arm", "Base", "Camera", "DeviceBoard", "Gripper"]


class DeviceBoard:
    """The snapshot of the present cycle and the commands collected for the next one."""

    def __init__(self, driver: CellDriver) -> None:
        self._driver = driver
        self.snapshot: Snapshot = driver.read()
        self.arms: dict[str, ArmTarget] = {}
        self.grippers: dict[str, GripperTarget] = {}
        self.bases: dict[str, BaseTwist] = {}

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return self._driver.period

    def exchange(self) -> Snapshot:
        """Sends the collected commands for one period, forgets them, and takes the new snapshot."""
        commands = Commands(self.arms, self.grippers, self.bases)
        self.arms, self.grippers, self.bases = {}, {}, {}
        self.snapshot = self._driver.exchange(commands)
        return self.snapshot

    @property
    def still(self) -> bool:
        """True when nothing moves that could be stopped: every arm and every base stands."""
        snapshot = self.snapshot
        return all(arm.still for arm in snapshot.arms.values()) and all(b.still for b in snapshot.bases.values())

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now."""
        return self._driver.capture(camera)


class Arm:
    """One arm."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.arms, "arm")

    @property
    def state(self) -> ArmState:
        """Its joints in this cycle."""
        return self._board.snapshot.arms[self.id]

    def command(self, target: ArmTarget) -> None:
        """Sets where the joints shall be at the end of the coming cycle."""
        self._board.arms[self.id] = target


class Gripper:
    """One parallel gripper."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.grippers, "gripper")

    @property
    def state(self) -> GripperState:
        """Its fingers in this cycle."""
        return self._board.snapshot.grippers[self.id]

    def command(self, target: GripperTarget) -> None:
        """Moves the fingers; the target stays in force until it is replaced."""
        self._board.grippers[self.id] = target


class Base:
    """One mobile base."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.bases, "base")

    @property
    def state(self) -> BaseState:
        """Its estimated pose and its speeds in this cycle."""
        return self._board.snapshot.bases[self.id]

    def command(self, twist: BaseTwist) -> None:
        """Sets its speeds for the coming cycle; without a command it brakes."""
        self._board.bases[self.id] = twist


class Camera:
    """One depth camera; it is asked for pictures, not read each cycle."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = device

    def capture(self) -> Pending[DepthImage]:
        """Takes a picture now; it arrives after the camera's latency."""
        return self._board.capture(self.id)


def _known(device: str, devices: object, kind: str) -> str:
    names = list(devices) if hasattr(devices, "__iter__") else []
    if device not in names:
        raise DeviceError(f"no {kind} '{device}' answers; there is {', '.join(names) or 'none'}")
    return device
