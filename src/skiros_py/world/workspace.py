"""A state in the making: a copy of the world that keeps account of what was changed in it."""

from __future__ import annotations

from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit, RelationEdit
from skiros_py.world.element import Element, Placement
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import LABEL

__all__ = ["Workspace"]


class Workspace:
    """What a transaction works on. Nothing is checked here.

    Attributes:
        base: The state it started from.
        view: The state as it is now.
        touched: Elements that were written to, there or not.
        places: Elements that something was placed at or taken from, there or not.
        pairs: Statements of relations, no placements, that were written, holding or not.
    """

    def __init__(self, base: Index) -> None:
        self.base = base
        self.view = base.copy()
        self.touched: set[str] = set()
        self.places: set[str] = set()
        self.pairs: set[tuple[str, str, str]] = set()

    def put(self, element: Element) -> None:
        """Adds an element, or replaces the one of its id, which has the same type."""
        self.touched.add(element.id)
        self.view.put_element(element)

    def place(self, element: str, placement: Placement | None) -> None:
        """Moves an element across the whole placement family."""
        self.touched.add(element)
        self.places.update(where.place for where in (self.view.placement(element), placement) if where is not None)
        self.view.put_placement(element, placement)

    def relate(self, subject: str, relation: str, object_: str, *, holds: bool) -> None:
        """Lets a relation, no placement, hold or not."""
        self.touched |= {subject, object_}
        self.pairs.add((subject, relation, object_))
        self.view.put_relation(subject, relation, object_, holds=holds)

    def erase(self, element: str) -> None:
        """Takes an element out, with everything that is stated of it."""
        self.place(element, None)
        for subject, relation, object_ in self.view.statements_about(element):
            if self.view.ontology.is_placement(relation):
                self.place(self.view.ontology.placed(subject, relation, object_)[0], None)
            else:
                self.relate(subject, relation, object_, holds=False)
        self.view.remove_element(element)

    def set_goals(self, goals: tuple[str, ...]) -> None:
        """Replaces the goals that go with the scene."""
        self.view.goals = goals

    def edits(self) -> tuple[Edit, ...]:
        """Returns the net difference, in an order in which it can be done again on the base.

        What became something of another class goes as what it was, and comes anew.
        """
        retyped = [name for name in sorted(self.touched) if _is_retyped(self.base, self.view, name)]
        if not retyped:
            return _edits(self.base, self.view, self.touched, self.pairs)
        without = Workspace(self.base)
        for name in retyped:
            without.erase(name)
        return (
            *_edits(self.base, without.view, without.touched, without.pairs),
            *_edits(without.view, self.view, self.touched | without.touched, self.pairs | without.pairs),
        )


def _edits(was: Index, is_: Index, touched: set[str], pairs: set[tuple[str, str, str]]) -> tuple[Edit, ...]:
    names = sorted(touched)
    kept = [name for name in names if was.has(name) and is_.has(name)]
    added = [ElementEdit(n, None, is_.element(n)) for n in names if not was.has(n) and is_.has(n)]
    removed = [ElementEdit(n, was.element(n), None) for n in names if was.has(n) and not is_.has(n)]
    changed = [edit for n in kept for edit in _property_edits(was.element(n), is_.element(n))]
    moved = [PlacementEdit(n, *places) for n in names if (places := _moved(was, is_, n))]
    related = [
        RelationEdit(*pair, old=old, new=new)
        for pair in sorted(pairs)
        if (old := was.stated(*pair)) != (new := is_.stated(*pair))
    ]
    goals = [GoalsEdit(was.goals, is_.goals)] if was.goals != is_.goals else []
    return (*added, *changed, *moved, *related, *removed, *goals)


def _is_retyped(was: Index, is_: Index, name: str) -> bool:
    return was.has(name) and is_.has(name) and was.element(name).type != is_.element(name).type


def _moved(was: Index, is_: Index, name: str) -> tuple[Placement | None, Placement | None] | None:
    old = was.placement(name) if was.has(name) else None
    new = is_.placement(name) if is_.has(name) else None
    return None if old == new else (old, new)


def _property_edits(old: Element, new: Element) -> list[Edit]:
    edits: list[Edit] = [PropertyEdit(old.id, LABEL, old.label, new.label)] if old.label != new.label else []
    if old.properties is new.properties:
        return edits
    for name in sorted({*old.properties, *new.properties}):
        before, after = old.properties.get(name), new.properties.get(name)
        if before != after or type(before) is not type(after):
            edits.append(PropertyEdit(old.id, name, before, after))
    return edits
