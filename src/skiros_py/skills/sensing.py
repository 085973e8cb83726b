"""What conditions may ask of devices: the sensors of the present cycle's snapshot, by name of the quantity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeVar

from skiros_py.ports.devices import DeviceBoard
from skiros_py.ports.values import ArmState, BaseState, GripperState
from skiros_py.world.sensors import Reading

__all__ = ["ARM_QUANTITIES", "BASE_QUANTITIES", "GRIPPER_QUANTITIES", "BoardSensors"]

_State = TypeVar("_State")

ARM_QUANTITIES: Mapping[str, Callable[[ArmState], Reading]] = MappingProxyType({"still": lambda arm: arm.still})
"""What an arm says: ``still``."""

GRIPPER_QUANTITIES: Mapping[str, Callable[[GripperState], Reading]] = MappingProxyType(
    {"gap": lambda fingers: fingers.gap, "force": lambda fingers: fingers.force, "still": lambda fingers: fingers.still}
)
"""What a gripper says: ``gap`` [m], ``force`` per finger [N], ``still``."""

BASE_QUANTITIES: Mapping[str, Callable[[BaseState], Reading]] = MappingProxyType(
    {
        "x": lambda base: base.pose.position[0],
        "y": lambda base: base.pose.position[1],
        "yaw": lambda base: base.pose.yaw,
        "linear": lambda base: base.linear,
        "angular": lambda base: base.angular,
        "still": lambda base: base.still,
    }
)
"""What a base says: estimated ``x``, ``y`` [m], ``yaw`` [rad], ``linear`` [m/s], ``angular`` [rad/s], ``still``."""


class BoardSensors:
    """The :class:`~skiros_py.world.sensors.Sensors` of the devices on a board."""

    def __init__(self, board: DeviceBoard) -> None:
        self._board = board

    def read(self, device: str, quantity: str) -> Reading | None:
        """Returns what a device says of a quantity in this cycle; None where it says nothing of it, or is not there."""
        snapshot = self._board.snapshot
        if device in snapshot.grippers:
            return _read(GRIPPER_QUANTITIES, quantity, snapshot.grippers[device])
        if device in snapshot.bases:
            return _read(BASE_QUANTITIES, quantity, snapshot.bases[device])
        if device in snapshot.arms:
            return _read(ARM_QUANTITIES, quantity, snapshot.arms[device])
        return None


def _read(quantities: Mapping[str, Callable[[_State], Reading]], quantity: str, state: _State) -> Reading | None:
    return quantities[quantity](state) if quantity in quantities else None
