"""One individual: of the scene, learned, or of the ontology."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from skiros_py.geometry import Pose

Value = str | bool | int | float | Pose | tuple[float, ...]
"""The values a property may have."""


@dataclass(frozen=True, slots=True)
class Placement:
    """Where an element is: the placement relation and the element that is its place."""

    relation: str
    place: str


@dataclass(frozen=True, slots=True)
class Stamp:
    """The last change that touched an element: its properties, its placement or its relations.

    Attributes:
        change: Number of the change: the element's version, for editors that must not overwrite each other.
        time: When [s, simulated].
    """

    change: int
    time: float


@dataclass(frozen=True, slots=True)
class Element:
    """One individual: a place, a part, a robot or one of its devices.

    Relations are not kept here but in the world's index: ask a :class:`~skiros_py.world.view.WorldView`.

    Attributes:
        id: Its name: bare in the scene ("starter_1"), a CURIE for what is abstract ("learned:mug_1"); never used again
            after removal.
        type: CURIE of its most specific class ("kitting:Starter").
        label: Its display name.
        properties: Own values by CURIE of the property ("sk:pose"); class-level values are found through the view.
    """

    id: str
    type: str
    label: str
    properties: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))


def is_abstract(element_id: str) -> bool:
    """Returns whether it is an element of the ontology or a learned one, not one physically in the scene."""
    return ":" in element_id


def is_learned(element_id: str) -> bool:
    """Returns whether an element is something that a robot was taught."""
    return element_id.startswith("learned:")
