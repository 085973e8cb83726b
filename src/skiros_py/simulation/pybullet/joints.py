"""The joints and links of one loaded robot, by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skiros_py.errors import UnknownName
from skiros_py.geometry import Array
from skiros_py.simulation.pybullet.client import Client

__all__ = ["Joints"]


class Joints:
    """Names, numbers and limits of a robot's joints and links.

    Args:
        client: The physics client.
        body: PyBullet's id of the robot.

    Attributes:
        body: PyBullet's id of the robot.
        movable: Numbers of all joints that are not fixed.
    """

    def __init__(self, client: Client, body: int) -> None:
        self.body = body
        self._infos = [client.getJointInfo(body, index) for index in range(client.getNumJoints(body))]
        self._joints: dict[str, int] = {info[1].decode(): info[0] for info in self._infos}
        self._links: dict[str, int] = {info[12].decode(): info[0] for info in self._infos}
        self.movable = [info[0] for info in self._infos if info[2] != client.JOINT_FIXED]

    def indices(self, names: Sequence[str]) -> list[int]:
        """Returns the numbers of joints.

        Raises:
            UnknownName: The robot has no such joint.
        """
        for name in names:
            if name not in self._joints:
                raise UnknownName("joint", name, self._joints)
        return [self._joints[name] for name in names]

    def link(self, name: str) -> int:
        """Returns the number of a link.

        Raises:
            UnknownName: The robot has no such link.
        """
        if name not in self._links:
            raise UnknownName("link", name, self._links)
        return self._links[name]

    def link_name(self, index: int) -> str:
        """Returns the name of a link."""
        return str(self._infos[index][12].decode())

    def limits(self, names: Sequence[str]) -> tuple[Array, Array, Array, Array]:
        """Returns lower and upper positions, greatest efforts and speeds of joints [rad or m, N m or N, per s]."""
        rows = [self._infos[index] for index in self.indices(names)]
        lower, upper, effort, speed = (np.array([row[column] for row in rows]) for column in (8, 9, 10, 11))
        return lower, upper, effort, speed
