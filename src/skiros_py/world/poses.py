"""Where things are in the map, following the frames that poses are given in."""

from __future__ import annotations

from skiros_py.geometry import Pose
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import POSE, POSE_FRAME

__all__ = ["map_pose"]


def map_pose(view: WorldView, element: str) -> Pose | None:
    """Returns an element's pose in the map, or None where its pose, or that of a frame it hangs on, is not known.

    Raises:
        UnknownName: There is no such element.
    """
    pose = Pose()
    seen: set[str] = set()
    current = element
    while current not in seen:
        seen.add(current)
        step = view.value(current, POSE)
        if not isinstance(step, Pose):
            return None
        pose = step @ pose
        frames = view.objects(current, POSE_FRAME)
        if not frames:
            return pose
        current = frames[0]
    return None  # frames that hang on each other: a world refuses them, an overlay may suppose them
