"""A working copy of the world that tracks its changes."""

from __future__ import annotations

from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit, RelationEdit, SourceEdit
from skiros_py.world.checks import relation_problem
from skiros_py.world.element import Element, Placement, is_abstract
from skiros_py.world.index import Index, with_value
from skiros_py.world.terms import reached
from skiros_py.world.vocabulary import HELD_BY, LABEL, PLACEMENT, POSE, POSE_FRAME, STRUCTURE


class Workspace:
    """The working copy of a transaction. Nothing is checked here.

    Attributes:
        base: The state it started from.
        view: The state as it is now.
        touched: Elements that were written to, existing or not.
        places: Elements that something was placed at or removed from, existing or not.
        pairs: Relation statements, except placements, that were written, holding or not.
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
        """Adds or removes a relation other than a placement."""
        self.touched |= {subject, object_}
        self.pairs.add((subject, relation, object_))
        self.view.put_relation(subject, relation, object_, holds=holds)

    def erase(self, element: str) -> None:
        """Removes an element with all statements about it."""
        self.place(element, None)
        for subject, relation, object_ in self.view.statements_about(element):
            if self.view.ontology.is_placement(relation):
                self.place(self.view.ontology.placed(subject, relation, object_)[0], None)
            else:
                self.relate(subject, relation, object_, holds=False)
        self.view.remove_element(element)

    def edits(self) -> tuple[Edit, ...]:
        """Returns the net difference, in an order in which it can be applied to the base.

        An element that got another class is removed and added.
        """
        sources = self.base.source, self.view.source
        first = (SourceEdit(*sources),) if sources[0] != sources[1] else ()
        kept = (name for name in sorted(self.touched) if self.base.has(name) and self.view.has(name))
        retyped = [name for name in kept if self.base.element(name).type != self.view.element(name).type]
        if not retyped:
            return *first, *_edits(self.base, self.view, self.touched, self.pairs)
        without = Workspace(self.base)
        for name in retyped:
            without.erase(name)
        return (
            *first,
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


# ---------------------------------------------------------------- removing an element


def remove(work: Workspace, element: str) -> list[tuple[str, str]]:
    """Removes an element and everything attached to it, or nothing.

    Returns:
        (element, why it cannot be removed), for each such element; empty when the element is gone.
    """
    view = work.view
    doomed = reached([element], lambda name: view.objects(name, STRUCTURE))
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
        for hanging in view.subjects(POSE_FRAME, name):  # without its frame the pose would mean another place
            work.put(with_value(view.element(hanging), POSE, None))
        work.erase(name)
    return []


def _held_by(view: Index, element: str) -> str | None:
    placement = view.placement(element)
    return placement.place if placement and placement.relation in view.ontology.sub_relations(HELD_BY) else None


def _refuge(view: Index, element: str) -> Placement | None:
    """The place of the element, or for a part, that of its whole."""
    placements = map(view.placement, reached([element], view.owners))
    return next((placement for placement in placements if placement is not None), None)


def _new_place(view: Index, guest: str, refuge: Placement | None) -> tuple[Placement | None, str]:
    """Where a guest goes, by the first relation that fits: the refuge's own, its old one, any; or why nowhere."""
    if is_abstract(guest):  # needs no place
        return None, ""
    if refuge is None:
        return None, f"{guest} would be nowhere: place it elsewhere first"
    old = view.placement(guest)
    relations = [refuge.relation, *([old.relation] if old else []), *view.ontology.sub_relations(PLACEMENT)[1:]]
    for relation in relations:
        placement = Placement(relation, refuge.place)
        if relation_problem(view, *view.ontology.placement_statement(guest, placement)) is None:
            return placement, ""
    return None, f"{guest} cannot be placed at {refuge.place}: place it elsewhere first"
