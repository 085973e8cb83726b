"""Ports to kinematics libraries: the poses of a robot's links, and joint angles for a pose of an arm's tip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from skiros_py.geometry import Array, Pose


@dataclass(frozen=True, slots=True)
class JointRange:
    """The limits of a joint as its model states them.

    Attributes:
        lower, upper: Range [rad or m]; None for a joint that turns without end.
        velocity: Greatest speed [rad/s or m/s]; None where the model states none.
    """

    lower: float | None
    upper: float | None
    velocity: float | None


class Kinematics(Protocol):
    """The links and joints of one robot, seen from its base link; answers in microseconds, in any thread.

    Joint positions are given by name [rad or m]; a joint that is left out is at zero.
    """

    @property
    def parents(self) -> Mapping[str, str]:
        """The link on which each link below the base link is mounted; parents come before their children."""
        ...

    @property
    def joints(self) -> Mapping[str, JointRange]:
        """The movable joints by name."""
        ...

    def pose(self, link: str, positions: Mapping[str, float]) -> Pose:
        """Returns the pose of a link in the frame of the base link.

        Raises:
            UnknownName: The robot has no such link.
        """
        ...

    def poses(self, positions: Mapping[str, float]) -> dict[str, Pose]:
        """Returns the poses of all links in the frame of the base link."""
        ...

    def jacobian(self, link: str, positions: Mapping[str, float], joints: Sequence[str]) -> Array:
        """Returns the velocity of a link per velocity of some joints.

        Returns:
            Shape (6, joints), linear part first, in the frame of the link.

        Raises:
            UnknownName: The robot has no such link or joint.
        """
        ...


class InverseKinematics(Protocol):
    """Finds joint angles that bring the tip of one arm to a pose.

    Motion planners ask for thousands of targets, so a target is a matrix: the pose of the tip in the frame of the
    robot's base link, shape (4, 4).
    """

    def solve(
        self,
        target: Array,
        seed: Array,
        *,
        towards: Array | None = None,
        pulls: int = 1,
        strength: float = 0.2,
        iterations: int = 40,
    ) -> Array | None:
        """Searches from one seed.

        Args:
            target: Where the tip shall be.
            seed: Joint angles to begin with [rad].
            towards: Joint angles to approach where the pose leaves freedom [rad]; None for none.
            pulls: How many iterations approach them.
            strength: Share of the difference that one of these makes up, 0 to 1.
            iterations: Bound of the effort.

        Returns:
            Joint angles within the limits [rad], the same for the same arguments; None where none were found.
        """
        ...
