"""The visible world: believed poses and shapes of its elements, for any kind of display."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping
from functools import cache, partial
from types import MappingProxyType
from typing import Literal

from skiros_py.api.view import Block, ViewElement, WorldView
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Element, Value, is_abstract
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.poses import pose_on

_AT = Pose()

_SHEET = 0.01
"""Drawn thickness, below the frame, of elements with only length and width [m]: floors, decks."""
_DIMENSIONS = (2, 3)


class Shapes:
    """Finds the shapes of elements: ``sk:solid``, otherwise a box of ``sk:size``; own values before those of the class.

    Args:
        view: The state.

    Attributes:
        used: The requested shapes, by key.
    """

    def __init__(self, view: Index) -> None:
        self.used: dict[str, tuple[Block, ...]] = {}
        self._ontology = view.ontology
        self._keys: dict[tuple[Value | None, Value | None, str], str | None] = {}

    def of(self, element: Element) -> str | None:
        """Returns the key of an element's shape; None if it has none, or one that cannot be parsed."""
        own = element.properties
        key = f"{element.type}#" if v.SOLID in own or v.SIZE in own else element.type
        what = self._value(element, v.SOLID), self._value(element, v.SIZE), key
        if what not in self._keys:
            self._keys[what] = self._take(*what)
        return self._keys[what]

    def hollow(self, element: Element) -> bool:
        """Returns whether an element's shape is empty space, not solid."""
        return self._value(element, v.HOLLOW) is True

    def _value(self, element: Element, property_: str) -> Value | None:
        return element.properties.get(property_, self._ontology.class_value(element.type, property_))

    def _take(self, solid: Value | None, size: Value | None, key: str) -> str | None:
        blocks = _blocks(solid, size)
        if blocks is None:
            return None
        if key.endswith("#"):
            key += hashlib.sha256(f"{solid}|{size}".encode("utf-8", "surrogatepass")).hexdigest()[:16]
        self.used[key] = blocks
        return key


def _blocks(solid: Value | None, size: Value | None) -> tuple[Block, ...] | None:
    if isinstance(solid, str):
        try:
            return tuple(map(Block.view_of, Solid.from_json(solid).primitives))
        except ValueError:
            return None  # a class may have a shape that cannot be parsed
    if isinstance(size, tuple) and len(size) in _DIMENSIONS and all(length > 0.0 for length in size):
        return (Block.view_of(_box(size)),)
    return None


def _box(size: tuple[float, ...]) -> Primitive:
    if len(size) == len(("x", "y", "z")):
        return Primitive("box", size)
    return Primitive("box", (*size, _SHEET), Pose((0.0, 0.0, -_SHEET / 2.0)))


Kind = Literal["part", "place", "furniture", "floor", "robot", "device", "other"]

_UNSEEN: Mapping[str, Pose] = MappingProxyType({})
_KINDS: tuple[tuple[str, Kind], ...] = (
    (v.FLOOR, "floor"),
    (v.ROBOT, "robot"),
    (v.DEVICE, "device"),
    (v.MANIPULATABLE, "part"),
    (v.LOCATION, "place"),
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
            waiting += view.objects(name, v.STRUCTURE)
            waiting += view.subjects(v.POSE_FRAME, name)
            waiting += view.owners(name) if view.ontology.is_a(view.element(name).type, v.BASE) else ()
    return found


class _Observer:
    """Describes elements one by one, caching the data that they have in common."""

    def __init__(self, view: Index, platforms: Mapping[str, Pose]) -> None:
        self.shapes = Shapes(view)
        self._view = view
        self._platforms = platforms
        self._kind = cache(partial(_kind, view.ontology))
        self._found: dict[str, tuple[str | None, Pose | None]] = {}

    def told(self, name: str) -> ViewElement | None:
        """Describes an element; None if it is not visible: abstract, or without shape, pose and placement."""
        if is_abstract(name):
            return None
        view, element = self._view, self._view.element(name)
        placement, shape = view.placement(name), self.shapes.of(element)
        if shape is None and placement is None and view.value(name, v.POSE) is None:
            return None
        held = placement is not None and placement.relation == v.HELD_BY
        carrier, pose = self._where(name)
        return ViewElement.view_of(
            element,
            id=name,
            class_=element.type,
            pose=pose,
            carrier=carrier,
            place=placement.place if placement is not None else None,
            owner=next(iter(view.owners(name)), None),
            held_by=placement.place if placement is not None and held else None,
            in_hand=self._in_hand(name, placement.place) if placement is not None and held else None,
            shape=shape,
            hollow=shape is not None and self.shapes.hollow(element),
            kind=self._kind(element.type) or ("other" if shape is None else "furniture"),
            version=view.stamp(name).change,
        )

    def _where(self, name: str) -> tuple[str | None, Pose | None]:
        """Returns the device that carries an element, if any, and the element's pose in its frame, else in the map."""
        if self._carries(name):
            return None, self._platforms.get(name)
        if self._kind(self._view.element(name).type) == "robot":
            pieces = self._view.objects(name, v.STRUCTURE)
            moved = next((self._platforms[piece] for piece in pieces if piece in self._platforms), None)
            if moved is not None:
                return None, moved
        frame, pose = pose_on(self._view, name, self._known) or (None, None)
        carrier = self._found[frame][0] if frame in self._found else frame
        self._found[name] = carrier, pose
        return carrier, pose

    def _known(self, frame: str) -> Pose | None:
        return _AT if self._carries(frame) else self._found.get(frame, (None, None))[1]

    def _in_hand(self, name: str, gripper: str) -> Pose | None:
        pose = self._view.value(name, v.POSE)
        return pose if isinstance(pose, Pose) and gripper in self._view.objects(name, v.POSE_FRAME) else None

    def _carries(self, name: str) -> bool:
        return name in self._platforms or self._view.ontology.is_a(self._view.element(name).type, v.BASE)


def _kind(ontology: Ontology, class_: str) -> Kind | None:
    return next((kind for above, kind in _KINDS if ontology.is_a(class_, above)), None)
