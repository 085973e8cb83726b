"""Pictures of the moments that tell: taken when something that took a while ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.geometry import Pose
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import Snapshot

__all__ = ["Camera", "KeyMoments", "over_the_shoulder"]

_Point = tuple[float, float, float]
Camera = Callable[[Snapshot, str], Pending[Any]]
"""Takes a picture, RGB, of what the robot with some device does: over its shoulder."""

WIDTH, HEIGHT = 480, 360
"""Size of a picture [px]."""
_WHILE = 1.0
"""A primitive that took at least so long is worth a picture when it ends [s]."""
_WORDS = {Status.TERMINATED: "done", Status.ERROR: "failed"}


class KeyMoments:
    """Tells when a picture is worth taking: a skill ends, or a primitive that took a while.

    Args:
        monitor: Where modules tell how they are doing.
        tell: Called then with a caption and the device that did it.

    Attributes:
        leave: Ends it.
    """

    def __init__(self, monitor: Monitor, tell: Callable[[str, str], None]) -> None:
        self._tell = tell
        self._started: dict[tuple[str, str], float] = {}
        self.leave = monitor.subscribe(self._on_event)

    def _on_event(self, event: ModuleEvent) -> None:
        module = event.agent, event.module
        if event.status is Status.STARTED:
            self._started[module] = event.time
        telling = event.kind == "skill" or event.time - self._started.get(module, event.time) >= _WHILE
        if telling and event.status in _WORDS:
            self._tell(" ".join(filter(None, (event.module, event.target, _WORDS[event.status]))), event.agent)


def over_the_shoulder(robot: Pose) -> tuple[_Point, _Point]:
    """Returns where an observer behind a robot is, and where they look [m]: at where it works."""
    x, y, _ = robot.position
    eye = robot.apply(np.array([-0.9, -1.5, 1.7]))
    yaw = robot.yaw
    return (float(eye[0]), float(eye[1]), float(eye[2])), (x + 0.5 * math.cos(yaw), y + 0.5 * math.sin(yaw), 0.5)
