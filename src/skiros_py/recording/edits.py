"""Edits of the world as people say them."""

from __future__ import annotations

from skiros_py.geometry import Pose
from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Placement, Value


def edit_sentence(edit: Edit) -> str:
    """Returns an edit in a sentence."""
    if isinstance(edit, ElementEdit):
        kind = edit.new or edit.old
        what = f"{edit.element} ({kind.type})" if kind else edit.element
        return f"{what} {'comes' if edit.old is None else 'goes' if edit.new is None else 'becomes another'}"
    if isinstance(edit, PlacementEdit):
        return f"{edit.element}: {_placement(edit.old)} → {_placement(edit.new)}"
    if isinstance(edit, PropertyEdit):
        return f"{edit.element} {edit.property}: {_value(edit.old)} → {_value(edit.new)}"
    if isinstance(edit, GoalsEdit):
        return f"goals: {', '.join(edit.new) or 'none'}"
    return f"{edit.subject} {edit.relation} {edit.object}: {'holds' if edit.new else 'holds no longer'}"


def _placement(placement: Placement | None) -> str:
    return "nowhere" if placement is None else f"{placement.relation} {placement.place}"


def _value(value: Value | None) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, Pose):
        x, y, z = value.position
        return f"({x:.3f}, {y:.3f}, {z:.3f})"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
