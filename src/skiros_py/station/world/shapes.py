"""Shapes of elements as the API shows them: each once, under a key that always means the same shape."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from skiros_py.api.state import PoseInfo
from skiros_py.api.view import Block
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.world.element import Element, Value
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import HOLLOW, SIZE, SOLID

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
        self._of_class: dict[str, dict[str, Value | None]] = {}
        self._keys: dict[tuple[Value | None, Value | None, str], str | None] = {}

    def of(self, element: Element) -> str | None:
        """Returns the key of an element's shape; None if it has none, or one that cannot be parsed."""
        own, given = element.properties, self._given(element.type)
        key = f"{element.type}#" if SOLID in own or SIZE in own else element.type
        what = own.get(SOLID, given[SOLID]), own.get(SIZE, given[SIZE]), key
        if what not in self._keys:
            self._keys[what] = self._take(*what)
        return self._keys[what]

    def hollow(self, element: Element) -> bool:
        """Returns whether an element's shape is empty space, not solid."""
        return element.properties.get(HOLLOW, self._given(element.type)[HOLLOW]) is True

    def _given(self, class_: str) -> dict[str, Value | None]:
        given = self._of_class.get(class_)
        if given is None:
            read = self._ontology.class_value
            given = self._of_class[class_] = {name: read(class_, name) for name in (SOLID, SIZE, HOLLOW)}
        return given

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
            return _told(Solid.from_json(solid).primitives)
        except ValueError:
            return None  # a class may have a shape that cannot be parsed
    return _told((_box(size),)) if isinstance(size, tuple) and _is_size(size) else None


def _is_size(size: tuple[float, ...]) -> bool:
    return len(size) in _DIMENSIONS and all(length > 0.0 for length in size)


def _box(size: tuple[float, ...]) -> Primitive:
    if len(size) == len(("x", "y", "z")):
        return Primitive("box", size)
    return Primitive("box", (*size, _SHEET), Pose((0.0, 0.0, -_SHEET / 2.0)))


def _told(primitives: Iterable[Primitive]) -> tuple[Block, ...]:
    return tuple(
        Block(
            kind=block.kind,
            size=block.size,
            pose=PoseInfo(position=block.pose.position, orientation=block.pose.orientation),
        )
        for block in primitives
    )
