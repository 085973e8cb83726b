"""Whether a camera is where it is believed to be: what two of its pictures say of the same thing, from two sides.

Where a camera is off by the same on its carrier in both, it sees a thing off in its own frame, so in two places when it
is turned in between. From one side only, nothing tells.
"""

from __future__ import annotations

import math

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.skills.context import RunContext
from skiros_py.skills.pictures import Sighting
from skiros_py.world import vocabulary as v

_EVERY = 600.0
"""Time after which a camera is compared again [s]."""
_TURNED = math.radians(80.0)
"""Least angle between two pictures that are compared."""
_MOST = 0.007
"""A camera may see things off by so much [m]: half of it is the error of telling where a part lies."""
_SAME = 0.04
"""What is seen farther apart is not the same thing [m]."""
_STOOD, _STOOD_TURN = 0.02, math.radians(1.0)
"""A robot that is localised no farther off has not moved between two pictures [m, rad]."""


def error_between(first: Sighting, second: Sighting) -> float | None:
    """Returns by how much a camera sees things off, across its axis, by two sightings [m]; None where nothing tells.

    Args:
        first: Where something was seen.
        second: Where the same thing was seen from elsewhere.
    """
    moved = first.robot.inverse() @ second.robot
    if math.hypot(*moved.position) > _STOOD or abs(moved.yaw) > _STOOD_TURN:
        return None
    apart = np.subtract(first.pose.position, second.pose.position)
    turns = first.camera.matrix()[:3, :3] - second.camera.matrix()[:3, :3]
    left, sizes, right = np.linalg.svd(turns)
    seen = sizes >= 2.0 * math.sin(_TURNED / 2.0)
    if seen.sum() < 2 or np.linalg.norm(apart) > _SAME:
        return None
    # along the axis about which the camera turned nothing tells: there the error is taken to be none
    return float(np.linalg.norm(right[seen].T @ ((left.T @ apart)[seen] / sizes[seen])))


def is_due(context: RunContext, camera: str) -> bool:
    """Returns whether it is time to compare pictures of a camera."""
    last = context.pictures.compared.get(camera)
    return last is None or context.board.snapshot.time - last > _EVERY


def is_turned(first: Sighting, camera: Pose) -> bool:
    """Returns whether a camera would be turned enough against a sighting.

    Args:
        first: The sighting.
        camera: Where the camera would be in the map.
    """
    between = (first.robot @ first.camera).inverse() @ camera
    return 2.0 * math.acos(min(1.0, abs(between.orientation[3]))) > _TURNED


def compare(context: RunContext, camera: str, first: Sighting, second: Sighting, author: str) -> Message | None:
    """Compares two sightings of one thing; writes by how much the camera is off, and announces it where that is much.

    Args:
        context: The run.
        camera: Id of the camera.
        first: Where something was seen.
        second: Where the same thing was seen from elsewhere.
        author: Who looks.

    Returns:
        What to tell a person; None where nothing is wrong, or nothing tells.
    """
    error = error_between(first, second)
    if error is None:
        return None
    context.pictures.compared[camera] = context.board.snapshot.time
    known = {"camera": camera, "error": 1e3 * error}
    if error <= _MOST:
        if context.world.value(camera, v.SIGHT_ERROR) is not None:
            with context.world.transaction(author=author, reason=Message("{camera} sees well again", **known)) as tx:
                tx.set(camera, v.SIGHT_ERROR, None)
        return None
    reason = Message("{camera} sees things {error:.0f} mm off: it has to be calibrated", **known)
    with context.world.transaction(author=author, reason=reason) as tx:
        tx.set(camera, v.SIGHT_ERROR, round(error, 4))
    context.emit("camera_off", {"camera": camera, "error": error, "text": str(reason)})
    return reason
