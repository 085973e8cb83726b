"""Changes as JSON text and back: what is read is exactly what was written."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    PropertyEdit,
    RelationEdit,
    Writer,
)
from skiros_py.world.element import Element, Placement, Value

__all__ = ["LONGEST_PART", "decode_change", "decode_edits", "encode_change", "encode_edits", "parts"]

LONGEST_PART = 1000
"""Edits in one text: a scene of 100,000 elements is read and written piece by piece.

Files count on it: of the texts of a change all but the last have so many.
"""

_Json = Mapping[str, Any]


def parts(edits: Sequence[Edit]) -> Iterator[Sequence[Edit]]:
    """Yields the edits in pieces of bearable length; an empty one where there are none."""
    for first in range(0, max(len(edits), 1), LONGEST_PART):
        yield edits[first : first + LONGEST_PART]


def encode_change(change: Change) -> list[str]:
    """Returns the texts that say a change: the first all but the edits that are too many for one text."""
    first, *others = parts(change.edits)
    return [_dump(replace(change, edits=tuple(first)).as_json()), *(encode_edits(part) for part in others)]


def encode_edits(edits: Sequence[Edit]) -> str:
    """Returns the text of some edits."""
    return _dump([edit.as_json() for edit in edits])


def decode_change(text: str, others: Sequence[str] = ()) -> Change:
    """Reads a change from the texts that say it.

    Raises:
        ValueError: They say none.
    """
    data = _load(text)
    with_rest = [*_edits(data), *(edit for other in others for edit in decode_edits(other))]
    try:
        return Change(
            data["number"],
            data["author"],
            data["reason"],
            data["time"],
            tuple(with_rest),
            Writer(data["writer"]),
            data["undoes"],
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"no change: {error}") from None


def decode_edits(text: str) -> list[Edit]:
    """Reads edits.

    Raises:
        ValueError: The text says none.
    """
    return _edits({"edits": _load(text)})


def _edits(data: _Json) -> list[Edit]:
    try:
        return [_EDITS[edit["edit"]](edit) for edit in data["edits"]]
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no edits: {error}") from None


def _dump(data: object) -> str:
    return json.dumps(data, separators=(",", ":"))


def _load(text: object) -> Any:
    if not isinstance(text, str):  # what a damaged file holds
        raise ValueError(f"no text, but {type(text).__name__}")
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None


def _element_edit(data: _Json) -> Edit:
    return ElementEdit(data["element"], _element(data["old"]), _element(data["new"]))


def _placement_edit(data: _Json) -> Edit:
    return PlacementEdit(data["element"], _placement(data["old"]), _placement(data["new"]))


def _relation_edit(data: _Json) -> Edit:
    return RelationEdit(data["subject"], data["relation"], data["object"], data["old"], data["new"])


def _property_edit(data: _Json) -> Edit:
    return PropertyEdit(data["element"], data["property"], _value(data["old"]), _value(data["new"]))


def _goals_edit(data: _Json) -> Edit:
    return GoalsEdit(tuple(data["old"]), tuple(data["new"]))


def _element(data: _Json | None) -> Element | None:
    if data is None:
        return None
    properties = {name: _own_value(value) for name, value in data["properties"].items()}
    return Element(data["id"], data["type"], data["label"], MappingProxyType(properties))


def _placement(data: _Json | None) -> Placement | None:
    return None if data is None else Placement(data["relation"], data["place"])


def _value(data: Any) -> Value | None:
    return None if data is None else _own_value(data)


def _own_value(data: Any) -> Value:
    if isinstance(data, dict):
        return Pose(tuple(data["position"]), tuple(data["orientation"]))
    if isinstance(data, list):
        return tuple(data)
    if isinstance(data, str | bool | int | float):
        return data
    raise TypeError(f"no value: {data!r}")


_EDITS: Mapping[str, Callable[[_Json], Edit]] = {
    "element": _element_edit,
    "placement": _placement_edit,
    "relation": _relation_edit,
    "property": _property_edit,
    "goals": _goals_edit,
}
