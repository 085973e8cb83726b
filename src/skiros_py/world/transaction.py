"""One write in the making: what it says is collected and checked, and shows nowhere before it takes effect."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.errors import WorldError
from skiros_py.world.change import Edit, ElementEdit, PlacementEdit, PropertyEdit, RelationEdit
from skiros_py.world.checks import checked_value, class_problem, element_problem, relation_problem, state_problems
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.ids import Ids, is_valid_id
from skiros_py.world.index import Index, with_value
from skiros_py.world.names import local_name
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import COMPUTED, LABEL, PLACEMENT, POSE, POSE_FRAME, STRUCTURE

__all__ = ["Transaction"]


class Transaction:
    """Made by :meth:`World.transaction`; its methods never raise for a wrong write, the end of the block does."""

    def __init__(self, base: Index, ids: Ids) -> None:
        self._base = base
        self._work = base.copy()
        self._ids = Ids(ids)
        self._touched: set[str] = set()
        self._pairs: set[tuple[str, str, str]] = set()
        self._problems: list[tuple[str, str]] = []
        self._refused: set[str] = set()
        self._open = True

    @property
    def view(self) -> WorldView:
        """The world as this transaction would leave it."""
        return self._work

    def add(
        self,
        class_: str,
        label: str | None = None,
        id: str | None = None,  # noqa: A002  the word that everybody uses for it
        properties: Mapping[str, Value] | None = None,
        placement: Placement | None = None,
    ) -> str:
        """Adds an element and returns its id: the one given, else the next for its class ("relay_box_3")."""
        self._check_open()
        element_id = id if id is not None else self._ids.next(class_)
        problem = class_problem(self._work.ontology, class_) or (self._id_problem(id) if id is not None else None)
        if problem:
            self._refuse(element_id, problem)
            self._refused.add(element_id)
            return element_id
        self._ids.claim(element_id)
        self._touched.add(element_id)
        self._work.put_element(Element(element_id, class_, label or local_name(class_)))
        for name, value in (properties or {}).items():
            self.set(element_id, name, value)
        if placement is not None:
            self.place(element_id, placement.relation, placement.place)
        return element_id

    def place(self, element: str, relation: str, place: str) -> None:
        """Moves an element: its one placement, of whatever relation, becomes this one."""
        self._check_open()
        ontology = self._work.ontology
        if relation not in ontology.relations or not ontology.is_placement(relation) or relation == PLACEMENT:
            leaves = ", ".join(ontology.sub_relations(PLACEMENT)[1:])
            self._refuse(element, f"'{relation}' does not place {element}: use one of {leaves}")
            return
        subject, object_ = ontology.placement_pair(element, Placement(relation, place))
        if self._may_relate(subject, relation, object_):
            self._touched.add(element)
            self._work.put_placement(element, Placement(relation, place))

    def relate(self, subject: str, relation: str, object_: str) -> None:
        """States a relation; a placement moves its element, a functional relation replaces its object."""
        self._check_open()
        ontology = self._work.ontology
        if relation in ontology.relations and ontology.is_placement(relation):
            element, placement = ontology.placed(subject, relation, object_)
            self.place(element, relation, placement.place)
        elif relation in (STRUCTURE, COMPUTED):
            self._refuse(subject, f"{relation} is a whole family: use one of {_below(self._work, relation)}")
        elif self._may_relate(subject, relation, object_):
            if ontology.relation(relation).functional:
                for old in self._work.objects(subject, relation):
                    self._put_relation(subject, relation, old, holds=False)
            self._put_relation(subject, relation, object_, holds=True)

    def unrelate(self, subject: str, relation: str, object_: str) -> None:
        """Takes back a stated relation; not a placement, for everything is somewhere."""
        self._check_open()
        if not self._may_relate(subject, relation, object_):
            return
        if self._work.ontology.family(relation) is Family.PLACEMENT:
            self._refuse(subject, f"{subject} {relation} {object_} cannot be taken away: place it elsewhere instead")
        elif not self._work.stated(subject, relation, object_):
            self._refuse(subject, f"{subject} {relation} {object_} is not stated, so it cannot be taken back")
        else:
            self._put_relation(subject, relation, object_, holds=False)

    def set(self, element: str, property_: str, value: Value | None) -> None:
        """Sets an element's own value of a property, or its ``rdfs:label``; None takes the own value away."""
        self._check_open()
        if not self._exists(element):
            return
        try:
            checked = checked_value(self._work, element, property_, value)
        except ValueError as error:
            self._refuse(element, str(error))
            return
        self._touched.add(element)
        self._work.put_element(with_value(self._work.element(element), property_, checked))

    def remove(self, element: str) -> None:
        """Removes an element with its pieces; what was placed in any of them moves to where the element was."""
        self._check_open()
        if not self._exists(element):
            return
        refuge = self._refuge(element)
        doomed = self._with_pieces(element)
        guests = [guest for name in doomed for guest in self._work.contents(name) if guest not in doomed]
        moved = [self._move_out(guest, refuge) for guest in guests]
        if all(moved):
            for name in doomed:
                self._erase(name)

    # ------------------------------------------------------------ the end of the block

    def problems(self) -> list[tuple[str, str]]:
        """Returns everything wrong with the transaction so far, as (element, sentence)."""
        return [*self._problems, *state_problems(self._work, self._touched)]

    def finish(self) -> tuple[Index, Ids, tuple[Edit, ...]]:
        """Ends the transaction and returns the new state, the ids given and the net edits.

        Raises:
            WorldError: Something is wrong; the text names all of it.
        """
        self.close()
        problems = dict.fromkeys(sentence for _, sentence in self.problems())
        if problems:
            raise WorldError(
                "\n  - ".join(["refused:", *problems]) if len(problems) > 1 else f"refused: {next(iter(problems))}"
            )
        return self._work, self._ids, tuple(self._edits())

    def close(self) -> None:
        """Lets nothing more be written."""
        self._open = False

    def _edits(self) -> list[Edit]:
        """The net difference, in an order in which it can be done again on the old state."""
        was, is_ = self._base, self._work
        names = sorted(self._touched)
        added = [ElementEdit(n, None, is_.element(n)) for n in names if not was.has(n) and is_.has(n)]
        removed = [ElementEdit(n, was.element(n), None) for n in names if was.has(n) and not is_.has(n)]
        changed = [
            edit for n in names if was.has(n) and is_.has(n) for edit in _property_edits(was.element(n), is_.element(n))
        ]
        moved = [PlacementEdit(n, *places) for n in names if (places := _moved(was, is_, n))]
        related = [
            RelationEdit(*pair, old=old, new=new)
            for pair in sorted(self._pairs)
            if (old := was.stated(*pair)) != (new := is_.stated(*pair))
        ]
        return [*added, *changed, *moved, *related, *removed]

    # ------------------------------------------------------------ pieces

    def _id_problem(self, element_id: str) -> str | None:
        if element_id == "this":
            return "'this' stands for the scene itself and is no id of an element"
        if not is_valid_id(element_id):
            return f"'{element_id}' is no id: use letters, digits and underscores, and no digit first"
        if self._ids.used(element_id):
            return f"id '{element_id}' was given before, and ids are never used again"
        return None

    def _may_relate(self, subject: str, relation: str, object_: str) -> bool:
        if not all([self._exists(subject), self._exists(object_)]):
            return False
        problem = relation_problem(self._work, subject, relation, object_)
        if problem:
            self._refuse(subject, problem)
        return problem is None

    def _exists(self, element_id: str) -> bool:
        if element_id in self._refused:
            return False  # what is wrong with it was said when it was added
        problem = element_problem(self._work, element_id)
        if problem:
            self._refuse(element_id, problem)
        return problem is None

    def _put_relation(self, subject: str, relation: str, object_: str, *, holds: bool) -> None:
        self._touched |= {subject, object_}
        self._pairs.add((subject, relation, object_))
        self._work.put_relation(subject, relation, object_, holds=holds)

    def _with_pieces(self, element: str) -> list[str]:
        pieces = [element]
        for name in pieces:
            pieces.extend(piece for piece in self._work.objects(name, STRUCTURE) if piece not in pieces)
        return pieces

    def _refuge(self, element: str) -> Placement | None:
        """Where the element is, or for a piece, where what it is a piece of is."""
        for name in self._with_owners(element):
            placement = self._work.placement(name)
            if placement is not None:
                return placement
        return None

    def _with_owners(self, element: str) -> list[str]:
        owners = [element]
        for name in owners:
            owners.extend(owner for owner in self._work.owners(name) if owner not in owners)
        return owners

    def _move_out(self, guest: str, refuge: Placement | None) -> bool:
        """Places a guest in the refuge, by the first relation that fits: the refuge's own, its old one, any."""
        if refuge is None:
            self._refuse(guest, f"{guest} would be nowhere: place it elsewhere first")
            return False
        old = self._work.placement(guest)
        candidates = [
            refuge.relation,
            *([old.relation] if old else []),
            *self._work.ontology.sub_relations(PLACEMENT)[1:],
        ]
        for relation in candidates:
            pair = self._work.ontology.placement_pair(guest, Placement(relation, refuge.place))
            if relation_problem(self._work, pair[0], relation, pair[1]) is None:
                self.place(guest, relation, refuge.place)
                return True
        self._refuse(guest, f"{guest} cannot be placed at {refuge.place}: place it elsewhere first")
        return False

    def _erase(self, element: str) -> None:
        self._touched.add(element)
        self._work.put_placement(element, None)
        for subject, relation, object_ in self._work.statements_about(element):
            if relation == POSE_FRAME and self._work.has(subject):
                self.set(subject, POSE, None)  # without its frame the pose would mean another place
            self._put_relation(subject, relation, object_, holds=False)
        self._work.remove_element(element)

    def _refuse(self, element: str, sentence: str) -> None:
        self._problems.append((element, sentence))

    def _check_open(self) -> None:
        if not self._open:
            raise WorldError("the transaction is over: write inside its 'with' block")


def _below(view: Index, relation: str) -> str:
    return ", ".join(view.ontology.sub_relations(relation)[1:])


def _moved(was: Index, is_: Index, name: str) -> tuple[Placement | None, Placement | None] | None:
    old = was.placement(name) if was.has(name) else None
    new = is_.placement(name) if is_.has(name) else None
    return None if old == new else (old, new)


def _property_edits(old: Element, new: Element) -> list[Edit]:
    edits: list[Edit] = [PropertyEdit(old.id, LABEL, old.label, new.label)] if old.label != new.label else []
    for name in sorted({*old.properties, *new.properties}):
        before, after = old.properties.get(name), new.properties.get(name)
        if before != after or type(before) is not type(after):
            edits.append(PropertyEdit(old.id, name, before, after))
    return edits
