"""Depth pictures on their way to what plans the motions of arms, and what they showed there that is unknown."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from skiros_py.geometry import Array, Pose
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.values import DepthImage

_KEPT = 8
"""Number of pictures that wait for one robot at most; older ones are dropped."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """Where something was seen.

    Attributes:
        robot: Pose of the robot in the map, as localised.
        camera: Pose of the camera in the frame of the robot.
        pose: Pose of what was seen in the frame of the robot.
        carrier: Id of the robot that carries the camera, or of the camera itself where none does.
        time: When it was seen [s].
    """

    robot: Pose
    camera: Pose
    pose: Pose
    carrier: str = ""
    time: float = 0.0


class Pictures:
    """The pictures that the robots of a cell took, for each of them; for the control thread only.

    A picture waits until its robot plans the next motion: what it shows is written into the world model by then. Other
    robots do not get it, as they may plan before that, or long after that; they get what was found to be unknown.

    Attributes:
        unknown: Blocks around what pictures have shown that nothing explains, by the robot whose planner knows it.
        sightings: Where things were last seen, by the ids of camera and thing.
        compared: When what two pictures say was last compared, by camera [s].
        apart: How far apart two cameras saw things, and where the robot stood, by the ids of the cameras.
        agree: Whether two cameras agreed when they were last compared, by their ids.
    """

    def __init__(self) -> None:
        self._waiting: dict[str, deque[tuple[DepthImage, str]]] = {}
        self.unknown: dict[str, tuple[Obstacle, ...]] = {}
        self.sightings: dict[tuple[str, str], Sighting] = {}
        self.compared: dict[str, float] = {}
        self.apart: dict[tuple[str, str], deque[tuple[Pose, Array]]] = {}
        self.agree: dict[tuple[str, str], bool] = {}

    def add(self, image: DepthImage, camera: str, robot: str) -> None:
        """Takes a picture.

        Args:
            image: The picture.
            camera: Id of the camera.
            robot: Id of the robot that took it.
        """
        self._waiting.setdefault(robot, deque(maxlen=_KEPT)).append((image, camera))

    def unknown_to(self, robot: str) -> tuple[Obstacle, ...]:
        """Returns blocks around what other robots have seen, and a robot's planner does not know."""
        return tuple(one for other, seen in self.unknown.items() if other != robot for one in seen)

    def take(self, robot: str) -> list[tuple[DepthImage, str]]:
        """Returns the pictures of a robot that its planner has not got yet, each with the id of its camera."""
        return list(self._waiting.pop(robot, ()))
