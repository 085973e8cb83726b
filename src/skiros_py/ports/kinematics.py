"""Robot models as their distributions bring them, and ports to kinematics: poses of links, joint angles for a pose.

A robot comes by the entry-point group ``skiros.robots``. The simulation, the kinematics, the collision checker and the
pages load the same file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from skiros_py.errors import UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.plugins.loading import find_plugin

GROUP = "skiros.robots"
"""Entry points of this group name robots: a :class:`RobotModel`, or files with individuals alone."""

BASE_LINK = "base_link"
"""Footprint frame of a mobile base: on the floor, x forward, in the middle between the wheels."""

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
"""Joints of a mobile base: where it is in the map [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A robot: what its geometry is and which individuals a scene imports.

    Attributes:
        name: Its name, as ``sk:model`` and its entry point have it ("mobile_panda").
        urdf: Its URDF file, or what composes the URDF text. Where a base moves it, its root link is "map".
        individuals: Turtle file with its individuals; None for a robot whose individuals others describe.
    """

    name: str
    urdf: Path | Callable[[], str]
    individuals: Path | None = None

    def write(self, directory: Path) -> Path:
        """Returns its URDF file; one that is composed is written to a directory.

        Raises:
            DeviceError: A package that it is composed from is not installed.
            FileError: A file that it is composed from is missing.
        """
        if isinstance(self.urdf, Path):
            return self.urdf
        path = directory / f"{self.name}.urdf"
        path.write_text(self.urdf(), encoding="utf-8")
        return path


def write_robot_urdf(model: str, directory: Path) -> Path:
    """Returns the URDF file of a robot model, which is written to a directory where it is composed.

    Args:
        model: Name of the model ("mobile_panda").
        directory: Where to write; it must exist and should belong to the run alone.

    Raises:
        UnknownName: No distribution brings that model.
        UsageError: It cannot be loaded, has no URDF, or is composed from a package that is not installed.
        FileError: A file that it is composed from is missing.
    """
    robot = find_plugin(GROUP, model, kind="robot model")
    if not isinstance(robot, RobotModel):
        raise UsageError(f"robot model '{model}' has no URDF: its entry point names files with individuals alone")
    return robot.write(directory)


@dataclass(frozen=True, slots=True)
class JointRange:
    """The limits of a joint as its model states them.

    Attributes:
        lower, upper: Range [rad or m]; None for a joint that turns without end.
        velocity: Greatest speed [rad/s or m/s]; None where the model states none.
        effort: What it can exert at most [N m or N]; None where the model states none.
    """

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None = None


class Kinematics(Protocol):
    """The links and joints of one robot, seen from its base link; answers in microseconds, in any thread.

    Joint positions are given by name [rad or m]; a joint that is left out is at zero.
    """

    @property
    def parents(self) -> Mapping[str, str]:
        """The link on which each link below the base link is mounted; parents come before their children."""

    @property
    def joints(self) -> Mapping[str, JointRange]:
        """The movable joints by name."""

    def pose(self, link: str, positions: Mapping[str, float]) -> Pose:
        """Returns the pose of a link in the frame of the base link.

        Raises:
            UnknownName: The robot has no such link.
        """

    def poses(self, positions: Mapping[str, float]) -> dict[str, Pose]:
        """Returns the poses of all links in the frame of the base link."""

    def jacobian(self, link: str, positions: Mapping[str, float], joints: Sequence[str]) -> Array:
        """Returns the velocity of a link per velocity of some joints.

        Returns:
            Shape (6, joints), linear part first, in the frame of the link.

        Raises:
            UnknownName: The robot has no such link or joint.
        """


@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """How some joints move, in the order of their names; all of shape (n,).

    Attributes:
        joints: Their names.
        positions: [rad or m].
        velocities: [rad/s or m/s].
        accelerations: [rad/s² or m/s²].
    """

    joints: tuple[str, ...]
    positions: Array
    velocities: Array
    accelerations: Array


class Dynamics(Protocol):
    """What the joints of one robot have to exert; answers in tens of microseconds, in any thread."""

    @property
    def mass(self) -> float:
        """Mass of the robot without loads [kg]."""

    def efforts(self, motion: JointMotion) -> Array:
        """Returns what joints exert for a motion, without loads and contacts [N m or N]; all other joints rest at zero.

        Raises:
            UnknownName: The robot has no such joint.
        """


_SETTLING = 15
"""Iterations that move a solution towards the reference."""
_DISTINCT = 0.3
"""Two solutions that are closer than this in every joint are one [rad]."""


class InverseKinematics(Protocol):
    """Finds joint angles that bring the tip of one arm to a pose.

    Implementations inherit from it: one that knows all branches of an arm, as an analytic one does, overrides
    ``branches``.

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

    def branches(
        self,
        target: Array,
        reference: Array,
        limits: tuple[Array, Array],
        rng: np.random.Generator,
        *,
        count: int = 6,
        restarts: int = 50,
    ) -> list[Array]:
        """Returns distinct solutions, the one nearest to a reference first; by default from random seeds.

        Each is also moved, elbow by elbow, as near to the reference as its pose allows; both are returned. Joints that
        turn more than once come by whole turns as near to the reference as their limits allow.

        Args:
            target: Where the tip shall be.
            reference: Joint angles from where the arm comes [rad]; also the first seed.
            limits: Lowest and highest joint angles [rad].
            rng: Source of the other seeds.
            count: Stop after as many solutions.
            restarts: Bound of the effort: number of seeds.
        """
        found: list[Array] = []
        for attempt in range(restarts):
            raw = self.solve(target, reference if attempt == 0 else rng.uniform(*limits))
            if raw is None:
                continue
            for q in (self.solve(target, raw, towards=reference, pulls=_SETTLING), raw):
                q = None if q is None else self.unwound(q, reference)
                if q is not None and all(np.abs(q - other).max() > _DISTINCT for other in found):
                    found.append(q)
            if len(found) >= count:
                break
        return sorted(found, key=lambda q: float(np.linalg.norm(q - reference)))

    def unwound(self, q: Array, reference: Array) -> Array:  # noqa: ARG002 - by default, joints turn no more than once
        """Returns the posture with each joint, by whole turns, as near to a reference as its limits allow [rad]."""
        return q
