"""The difference between two scenes: edits that turn one into the other, and a readable description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from skiros_py.geometry import Pose
from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.index import Index
from skiros_py.world.literals import ANY_LITERAL, format_value, shown
from skiros_py.world.ontology import Ontology
from skiros_py.world.workspace import Workspace

_Statement = tuple[str, str, str]


def diff(old: Index, new: Index) -> tuple[Edit, ...]:
    """Returns the edits that turn the scene of one state into that of another, in an applicable order.

    Abstract elements (the ontology's individuals and learned data) are not part of a scene. An element with another
    class in the new state counts as a different one: it is removed and added. Poses that are written identically count
    as equal.
    """
    work = Workspace(old)
    work.view = new
    work.touched = {name for name in _scene(old) | _scene(new) if _known(old, name) != _known(new, name)}
    work.pairs = _relations(old) ^ _relations(new)
    return tuple(edit for edit in work.edits() if not _is_within_rounding(edit))


def describe(ontology: Ontology | None, edits: Iterable[Edit]) -> Iterator[str]:
    """Yields a line for each edit: what was added (``+``), removed (``-``) or changed (``~``).

    Args:
        ontology: Gives the type of each property; None if not available.
        edits: The edits.
    """
    for edit in edits:
        if isinstance(edit, ElementEdit):
            yield _element(edit)
        elif isinstance(edit, PlacementEdit):
            yield _change(edit.element, _placed(edit.old), _placed(edit.new))
        elif isinstance(edit, PropertyEdit):
            texts = (_value(ontology, edit.property, value) for value in (edit.old, edit.new))
            yield _change(f"{edit.element} {edit.property}", *texts)
        elif isinstance(edit, GoalsEdit):
            yield from (f"- goal {goal}" for goal in edit.old if goal not in edit.new)
            yield from (f"+ goal {goal}" for goal in edit.new if goal not in edit.old)
        else:
            yield f"{'+' if edit.new else '-'} {edit.subject} {edit.relation} {edit.object}"


def _scene(index: Index) -> set[str]:
    return {name for name in index.ids() if not is_abstract(name)}


def _known(index: Index, name: str) -> tuple[Element, Placement | None] | None:
    return (index.element(name), index.placement(name)) if index.has(name) else None


def _relations(index: Index) -> set[_Statement]:
    ontology = index.ontology
    return {said for said in index.statements() if not is_abstract(said[0]) and not ontology.is_placement(said[1])}


def _is_within_rounding(edit: Edit) -> bool:
    if not isinstance(edit, PropertyEdit) or not isinstance(edit.old, Pose) or not isinstance(edit.new, Pose):
        return False
    return format_value(edit.old, "sk:poseLiteral") == format_value(edit.new, "sk:poseLiteral")


def _element(edit: ElementEdit) -> str:
    element = edit.new or edit.old
    assert element is not None
    return f"{'-' if edit.new is None else '+'} {element.id} ({element.type}) {shown(element.label)}"


def _placed(placement: Placement | None) -> str:
    return "" if placement is None else f"{placement.relation} {placement.place}"


def _value(ontology: Ontology | None, property_: str, value: Value | None) -> str:
    if value is None:
        return ""
    declared = ontology.properties.get(property_) if ontology else None  # an old change's property may no longer exist
    text = format_value(value, ANY_LITERAL if declared is None else declared.range)
    return shown(text) if isinstance(value, str) else text


def _change(what: str, old: str, new: str) -> str:
    if not old or not new:
        return f"{'+' if new else '-'} {what} {new or old}"
    return f"~ {what} {old} -> {new}"
