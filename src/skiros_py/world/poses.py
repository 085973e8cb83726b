"""Where things are: poses in the map and in the frames of elements, read and written.

The frame of an element is where its ``sk:pose`` puts it; that pose is given in the map, or in the frame of another
element (``sk:poseFrame``), and so on: frames are trees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import reduce
from operator import matmul
from typing import Final

from skiros_py.errors import WorldError
from skiros_py.geometry import Pose
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DRIVING_POSE, MISSED_LOOKS, MISSING, PLACEMENT, POSE, POSE_FRAME

_AT: Final = Pose()


def pose_on(
    view: WorldView, element: str, known: Callable[[str], Pose | None] = lambda _frame: None
) -> tuple[str | None, Pose] | None:
    """Returns the first frame above an element whose pose is known otherwise, and the element's pose by way of it.

    Args:
        view: The world.
        element: Id of the element.
        known: Returns the pose of a frame where it is known otherwise, as that of a device; None to go on upwards.

    Returns:
        The frame (None: the map), and the known pose of that frame times the element's pose in it; None if the
        element's pose, or that of a frame on the way, is unknown.

    Raises:
        UnknownName: There is no such element.
    """
    steps: list[Pose] = []
    for current in frames(view, element):
        start = known(current) if steps else None
        if start is not None:
            return current, reduce(matmul, reversed(steps), start)
        step = view.value(current, POSE)
        if not isinstance(step, Pose):
            return None
        steps.append(step)
    above = view.objects(current, POSE_FRAME)
    return None if above else (None, reduce(matmul, reversed(steps)))  # frames may hang on each other in an overlay


def map_pose(view: WorldView, element: str) -> Pose | None:
    """Returns an element's pose in the map, or None if its pose, or that of a parent frame, is unknown.

    Raises:
        UnknownName: There is no such element.
    """
    found = pose_on(view, element)
    return None if found is None else found[1]


def driving_pose(view: WorldView, place: str) -> Pose | None:
    """Returns the pose in the map from which robots work at a place; None where it has none, or none is known.

    Raises:
        UnknownName: There is no such element.
    """
    pose, driving = map_pose(view, place), view.value(place, DRIVING_POSE)
    return pose @ driving if pose is not None and isinstance(driving, Pose) else None


def pose_in(view: WorldView, element: str, frame: str | None) -> Pose | None:
    """Returns an element's pose in the frame of another (None: in the map), or None if it is not known.

    It is known where both hang on a common frame, even if the pose of that frame is not known (a gripper that moves).

    Raises:
        UnknownName: There is no such element or frame.
    """
    if frame is None:
        return map_pose(view, element)
    others = set(frames(view, frame))
    own = (element, Pose()) if element in others else pose_on(view, element, lambda one: _AT if one in others else None)
    if own is None:
        return None
    common, pose = own
    if common == frame:
        return pose
    other = pose_on(view, frame, lambda one: _AT if one == common else None)
    return None if other is None else other[1].inverse() @ pose


def write_pose(tx: Transaction, element: str, pose: Pose | None, frame: str | None = None) -> None:
    """Writes where an element is: in the map, or in the frame of another, with which it moves; None removes it."""
    if frame is not None:
        tx.relate(element, POSE_FRAME, frame)
    else:
        for old in tx.view.objects(element, POSE_FRAME):
            tx.unrelate(element, POSE_FRAME, old)
    tx.set(element, POSE, pose)


def move(tx: Transaction, element: str, pose: Pose) -> None:
    """Writes where an element is in the map; what is placed on it or in it, and so on, comes along.

    Raises:
        WorldError: Where it was is not known.
    """
    view = tx.view
    before = map_pose(view, element)
    if before is None:
        raise WorldError(f"{element} cannot be moved with what is on it: where it was is not known")
    by, waiting, moved = pose @ before.inverse(), [element], dict[str, Pose]()
    for one in waiting:
        waiting += (guest for guest in view.subjects(PLACEMENT, one) if guest not in waiting)
        there = map_pose(view, one)
        if there is not None and moved.keys().isdisjoint(frames(view, one)):
            moved[one] = by @ there
    for one, there in moved.items():
        frame = next(iter(view.objects(one, POSE_FRAME)), None)
        above = None if frame is None else map_pose(view, frame)
        write_pose(tx, one, there if above is None else above.inverse() @ there, frame)


def attach(tx: Transaction, element: str, frame: str | None) -> None:
    """Keeps an element's pose, but makes it move with another from now on (None: with none, fixed in the map).

    Raises:
        WorldError: Its pose in that frame is not known.
    """
    pose = pose_in(tx.view, element, frame)
    if pose is None:
        raise WorldError(f"{element} cannot be attached to {frame or 'the map'}: its pose there is not known")
    write_pose(tx, element, pose, frame)


def frames(view: WorldView, element: str) -> Iterator[str]:
    """Yields an element, the frame in which its pose is given, and so on; each once."""
    seen: set[str] = set()
    current: str | None = element
    while current is not None and current not in seen:
        seen.add(current)
        yield current
        current = next(iter(view.objects(current, POSE_FRAME)), None)


def forget_looks(tx: Transaction, thing: str) -> None:
    """Removes what looks have said about a thing: its pose, and that it was not seen. The next look finds it."""
    tx.set(thing, MISSING, None)
    tx.set(thing, MISSED_LOOKS, None)
    write_pose(tx, thing, None)
