"""Alternative places for unreachable placements: free places of the same whole first, such as the same kit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from skiros_py.planning.explanation.found import Found
from skiros_py.planning.explanation.room import Room
from skiros_py.planning.reasons import CauseKind, Exchange
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A

_CHOICES = 4
"""How many alternative places are considered per condition."""
_CONDITIONS = 3
"""For how many conditions alternatives are considered."""


def exchanges(found: Found, goal: Sequence[Condition], view: WorldView, room: Room) -> Iterator[Exchange]:
    """Yields conditions with another place instead; whether they are reachable has not been tested yet.

    Args:
        found: Why there is no plan.
        goal: The whole goal; places that it names are not used.
        view: The world.
        room: Tells which places are free.
    """
    named = {name for condition in goal for name in condition.names}
    for condition in found.cause.conditions[:_CONDITIONS]:
        if type(condition) is not Condition or condition.negated:
            continue  # conditions on several things, or on none, do not name one place
        for place in condition.arguments:
            others = (other for other in _instead_of(place, found, view, room) if other not in named)
            for other in list(others)[:_CHOICES]:
                yield Exchange(condition, condition.bind({place: other}))


def _instead_of(place: str, found: Found, view: WorldView, room: Room) -> list[str]:
    """Returns free places that could replace one that is the problem; none if it is not."""
    if not view.has(place):
        return []
    obstacle = found.obstacle
    if obstacle is None:
        is_short = found.shortage is not None and place in found.shortage.there
        return _like(place, view.element(place).type, view, room) if is_short else []
    if obstacle.skill is None or place not in obstacle.elements:
        return []
    if obstacle.kind is CauseKind.NO_SKILL:
        classes = [name for name in obstacle.elements if name in view.ontology.classes]
        return _like(place, classes[0], view, room) if classes else []
    if obstacle.kind in (CauseKind.FULL, CauseKind.DOES_NOT_FIT):
        return _like(place, view.element(place).type, view, room)
    return []


def _like(place: str, class_: str, view: WorldView, room: Room) -> list[str]:
    """Returns the free single-thing places of a class, those of the same whole first."""
    wholes = set(view.subjects(HAS_A, place))
    free = [other for other in view.instances(class_) if other != place and room.is_free(other, view)]
    return sorted(free, key=lambda other: wholes.isdisjoint(view.subjects(HAS_A, other)))
