"""Where things are: poses in the map and in the frames of elements, read and written.

The frame of an element is where its ``sk:pose`` puts it; that pose is given in the map, or in the frame of another
element (``sk:poseFrame``), and so on: frames are trees.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from skiros_py.errors import WorldError
from skiros_py.geometry import Pose
from skiros_py.world.vocabulary import POSE, POSE_FRAME

if TYPE_CHECKING:
    from skiros_py.world.transaction import Transaction
    from skiros_py.world.view import WorldView


def map_pose(view: WorldView, element: str) -> Pose | None:
    """Returns an element's pose in the map, or None if its pose, or that of a parent frame, is unknown.

    Raises:
        UnknownName: There is no such element.
    """
    return _way_up(view, element).get(None)


def pose_in(view: WorldView, element: str, frame: str | None) -> Pose | None:
    """Returns an element's pose in the frame of another (None: in the map), or None if it is not known.

    It is known where both hang on a common frame, even if the pose of that frame is not known (a gripper that moves).

    Raises:
        UnknownName: There is no such element or frame.
    """
    if frame is None:
        return map_pose(view, element)
    own, other = _way_up(view, element), _way_up(view, frame)
    common = next(((other[name], pose) for name, pose in own.items() if name in other), None)
    return None if common is None else common[0].inverse() @ common[1]


def write_pose(tx: Transaction, element: str, pose: Pose | None, frame: str | None = None) -> None:
    """Writes where an element is: in the map, or in the frame of another, with which it moves; None removes it."""
    if frame is not None:
        tx.relate(element, POSE_FRAME, frame)
    else:
        for old in tx.view.objects(element, POSE_FRAME):
            tx.unrelate(element, POSE_FRAME, old)
    tx.set(element, POSE, pose)


def attach(tx: Transaction, element: str, frame: str | None) -> None:
    """Keeps an element's pose, but makes it move with another from now on (None: with none, fixed in the map).

    Raises:
        WorldError: Its pose in that frame is not known.
    """
    pose = pose_in(tx.view, element, frame)
    if pose is None:
        raise WorldError(f"{element} cannot be attached to {frame or 'the map'}: its pose there is not known")
    write_pose(tx, element, pose, frame)


def _way_up(view: WorldView, element: str) -> dict[str | None, Pose]:
    """The element's pose in its own frame, in the one that is given in, and so on; under None that in the map."""
    poses: dict[str | None, Pose] = {element: Pose()}
    current = element
    while True:
        step = view.value(current, POSE)
        if not isinstance(step, Pose):
            return poses
        pose = step @ poses[current]
        above = next(iter(view.objects(current, POSE_FRAME)), None)
        if above in poses:  # frames that hang on each other: a world refuses them, an overlay may suppose them
            return poses
        poses[above] = pose
        if above is None:
            return poses
        current = above
