"""One individual of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from skiros_py.geometry import Pose

__all__ = ["Element", "Placement", "Value"]

Value = str | bool | int | float | Pose | tuple[float, ...]
"""What a property may hold."""


@dataclass(frozen=True, slots=True)
class Placement:
    """Where an element is: the placement relation and the element that is its place."""

    relation: str
    place: str


@dataclass(frozen=True, slots=True)
class Element:
    """One individual: a place, a part, a robot or one of its devices.

    Relations are not kept here but in the world's index: ask a :class:`~skiros_py.world.view.WorldView`.

    Attributes:
        id: Its name in the scene ("starter_1"); never used again after removal.
        type: CURIE of its most specific class ("kitting:Starter").
        label: What people call it.
        properties: Own values by CURIE of the property ("sk:pose"); class-level values are found through the view.
    """

    id: str
    type: str
    label: str
    properties: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))
