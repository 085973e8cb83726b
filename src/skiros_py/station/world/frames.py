"""Poses of many elements: in the map, or on the robot base that carries them."""

from __future__ import annotations

from collections.abc import Callable

from skiros_py.geometry import Pose
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import POSE, POSE_FRAME

_Place = tuple[str | None, Pose]
"""A base (None for the map), and the pose in its frame."""


class Frames:
    """Computes poses through chains of frames, each frame only once.

    The world model does not track bases while they drive, so poses of elements on a base are in the frame of the base.

    Args:
        view: The state.
        is_base: Returns whether an element is a robot base.
    """

    def __init__(self, view: Index, is_base: Callable[[str], bool]) -> None:
        self._view = view
        self._is_base = is_base
        self._known: dict[str, _Place | None] = {}

    def of(self, name: str) -> _Place | None:
        """Returns the pose of an element; None if it or that of a frame in its chain is unknown.

        Raises:
            UnknownName: There is no such element.
        """
        way: list[str] = []
        current: str | None = name
        while current is not None and current not in self._known:
            self._known[current] = None  # terminates cycles of frames
            way.append(current)
            current = self._above(current)
        for one in reversed(way):  # from the top down, without recursion
            self._known[one] = self._below(one)
        return self._known[name]

    def _frame(self, name: str) -> str | None:
        return next(iter(self._view.objects(name, POSE_FRAME)), None)

    def _above(self, name: str) -> str | None:
        frame = self._frame(name)
        return None if frame is None or self._is_base(frame) else frame

    def _below(self, name: str) -> _Place | None:
        pose, frame = self._view.value(name, POSE), self._frame(name)
        if not isinstance(pose, Pose):
            return None
        if frame is None or self._is_base(frame):
            return frame, pose
        above = self._known[frame]
        return None if above is None else (above[0], above[1] @ pose)
