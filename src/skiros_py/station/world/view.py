"""The visible world: believed poses and shapes of its elements, for any kind of display."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from skiros_py.api.state import PoseInfo
from skiros_py.api.view import ViewElement, WorldView
from skiros_py.geometry import Pose
from skiros_py.station.world.frames import Frames
from skiros_py.station.world.shapes import Shapes
from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import (
    BASE,
    DEVICE,
    FLOOR,
    HELD_BY,
    LOCATION,
    MANIPULATABLE,
    POSE,
    POSE_FRAME,
    ROBOT,
    STRUCTURE,
)

Kind = Literal["part", "place", "furniture", "floor", "robot", "device", "other"]

_UNSEEN: Mapping[str, Pose] = MappingProxyType({})
_KINDS: tuple[tuple[str, Kind], ...] = (
    (FLOOR, "floor"),
    (ROBOT, "robot"),
    (DEVICE, "device"),
    (MANIPULATABLE, "part"),
    (LOCATION, "place"),
)
"""The first match counts; all other elements with a shape are furniture."""


def view_of(view: Index, ids: Collection[str] | None = None, platforms: Mapping[str, Pose] = _UNSEEN) -> WorldView:
    """Returns the believed view of the world; does not block; callable from any thread.

    Args:
        view: The state.
        ids: Only these elements and those whose view changes with them: pieces, elements in their frames, a robot with
            its base. None for everything.
        platforms: The poses in the map of the devices that carry bodies, by id; those of other bases are unknown.
    """
    observer = _Observer(view, platforms)
    wanted = sorted(view.ids() if ids is None else _dependents(view, ids))
    elements = tuple(told for name in wanted if (told := observer.told(name)) is not None)
    seen = {element.id for element in elements}
    return WorldView(
        version=view.version,
        elements=elements,
        shapes=observer.shapes.used,
        gone=() if ids is None else tuple(sorted(set(ids) - seen)),
    )


def _dependents(view: Index, ids: Iterable[str]) -> set[str]:
    found: set[str] = set()
    waiting = [name for name in ids if view.has(name)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += view.objects(name, STRUCTURE)
            waiting += view.subjects(POSE_FRAME, name)
            waiting += view.owners(name) if view.ontology.is_a(view.element(name).type, BASE) else ()
    return found


@dataclass(frozen=True, slots=True)
class _Sort:
    """Data common to all elements of a class."""

    kind: Kind | None
    base: bool


class _Observer:
    """Describes elements one by one, caching the data that they have in common."""

    def __init__(self, view: Index, platforms: Mapping[str, Pose]) -> None:
        self.shapes = Shapes(view)
        self._view = view
        self._platforms = platforms
        self._sorts: dict[str, _Sort] = {}
        self._frames = Frames(view, self._carries)

    def told(self, name: str) -> ViewElement | None:
        """Describes an element; None if it is not visible: abstract, or without shape, pose and placement."""
        if is_abstract(name):
            return None
        view, element = self._view, self._view.element(name)
        placement, shape = view.placement(name), self.shapes.of(element)
        if shape is None and placement is None and view.value(name, POSE) is None:
            return None
        held = placement is not None and placement.relation == HELD_BY
        carrier, pose = self._where(name)
        return ViewElement(
            id=name,
            class_=element.type,
            label=element.label,
            pose=_told(pose),
            carrier=carrier,
            place=placement.place if placement is not None else None,
            owner=next(iter(view.owners(name)), None),
            held_by=placement.place if placement is not None and held else None,
            in_hand=self._in_hand(name, placement.place) if placement is not None and held else None,
            shape=shape,
            hollow=shape is not None and self.shapes.hollow(element),
            kind=self._sort(element.type).kind or ("other" if shape is None else "furniture"),
            version=view.stamp(name).change,
        )

    def _where(self, name: str) -> tuple[str | None, Pose | None]:
        """Returns the device that carries an element, if any, and the element's pose in its frame, else in the map."""
        if self._carries(name):
            return None, self._platforms.get(name)
        if self._sort(self._view.element(name).type).kind == "robot":
            pieces = self._view.objects(name, STRUCTURE)
            moved = next((self._platforms[piece] for piece in pieces if piece in self._platforms), None)
            return self._frames.of(name) or (None, None) if moved is None else (None, moved)
        return self._frames.of(name) or (None, None)

    def _in_hand(self, name: str, gripper: str) -> PoseInfo | None:
        pose = self._view.value(name, POSE)
        hangs = gripper in self._view.objects(name, POSE_FRAME)
        return _told(pose) if hangs and isinstance(pose, Pose) else None

    def _carries(self, name: str) -> bool:
        return name in self._platforms or self._sort(self._view.element(name).type).base

    def _sort(self, class_: str) -> _Sort:
        known = self._sorts.get(class_)
        if known is None:
            is_a = self._view.ontology.is_a
            kind = next((kind for above, kind in _KINDS if is_a(class_, above)), None)
            known = self._sorts[class_] = _Sort(kind, is_a(class_, BASE))
        return known


def _told(pose: Pose | None) -> PoseInfo | None:
    return None if pose is None else PoseInfo(position=pose.position, orientation=pose.orientation)
