"""Removing an element: its pieces go with it, what was placed in any of them moves to where it was."""

from __future__ import annotations

from skiros_py.world.checks import relation_problem
from skiros_py.world.element import Placement, is_abstract
from skiros_py.world.index import Index, with_value
from skiros_py.world.vocabulary import HELD_BY, PLACEMENT, POSE, POSE_FRAME, STRUCTURE
from skiros_py.world.workspace import Workspace

__all__ = ["remove"]


def remove(work: Workspace, element: str) -> list[tuple[str, str]]:
    """Removes an element and everything that hangs on it, or nothing.

    Returns:
        (element, why it stands in the way), for each that does; empty when the element is gone.
    """
    view = work.view
    doomed = _with_pieces(view, element)
    held = [(n, place) for n in doomed if (place := _held_by(view, n))]
    if held:
        return [(n, f"{n} is held by {gripper}: have it put down before it is removed") for n, gripper in held]
    refuge = _refuge(view, element)
    guests = [guest for name in doomed for guest in view.contents(name) if guest not in doomed]
    moves = [(guest, *_new_place(view, guest, refuge)) for guest in guests]
    stuck = [(guest, problem) for guest, _, problem in moves if problem]
    if stuck:
        return stuck
    for guest, placement, _ in moves:
        work.place(guest, placement)
    for name in doomed:
        _erase(work, name)
    return []


def _with_pieces(view: Index, element: str) -> dict[str, None]:
    pieces = {element: None}
    waiting = [element]
    while waiting:
        found = [piece for piece in view.objects(waiting.pop(), STRUCTURE) if piece not in pieces]
        pieces.update(dict.fromkeys(found))
        waiting += found
    return pieces


def _held_by(view: Index, element: str) -> str | None:
    placement = view.placement(element)
    return placement.place if placement and placement.relation in view.ontology.sub_relations(HELD_BY) else None


def _refuge(view: Index, element: str) -> Placement | None:
    """Where the element is, or for a piece, where what it is a piece of is."""
    owners = [element]
    for name in owners:
        placement = view.placement(name)
        if placement is not None:
            return placement
        owners.extend(owner for owner in view.owners(name) if owner not in owners)
    return None


def _new_place(view: Index, guest: str, refuge: Placement | None) -> tuple[Placement | None, str]:
    """Where a guest goes, by the first relation that fits: the refuge's own, its old one, any; or why nowhere."""
    if is_abstract(guest):  # need not be anywhere
        return None, ""
    if refuge is None:
        return None, f"{guest} would be nowhere: place it elsewhere first"
    old = view.placement(guest)
    relations = [refuge.relation, *([old.relation] if old else []), *view.ontology.sub_relations(PLACEMENT)[1:]]
    for relation in relations:
        placement = Placement(relation, refuge.place)
        subject, object_ = view.ontology.placement_pair(guest, placement)
        if relation_problem(view, subject, relation, object_) is None:
            return placement, ""
    return None, f"{guest} cannot be placed at {refuge.place}: place it elsewhere first"


def _erase(work: Workspace, element: str) -> None:
    for hanging in work.view.subjects(POSE_FRAME, element):  # without its frame the pose would mean another place
        work.put(with_value(work.view.element(hanging), POSE, None))
    work.erase(element)
