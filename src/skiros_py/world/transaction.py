"""A pending write: its edits are collected and checked, and invisible until it takes effect."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from skiros_py.errors import WorldError
from skiros_py.messages import Message, joined
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    PropertyEdit,
    SceneSource,
    SourceEdit,
)
from skiros_py.world.checks import (
    checked_value,
    class_problem,
    element_problem,
    goal_problem,
    id_problem,
    relation_problem,
    state_problems,
)
from skiros_py.world.element import Element, Placement, Value, is_abstract
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index, with_value
from skiros_py.world.names import local_name
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import COMPUTED, LABEL, PLACEMENT, STRUCTURE
from skiros_py.world.workspace import Workspace, remove


class Transaction:
    """Made by :meth:`World.transaction`; its methods never raise for a wrong write, the end of the block does.

    Attributes:
        change: The resulting change, once it has taken effect; None before, and if nothing changed.
    """

    def __init__(self, base: Index, ids: Ids) -> None:
        self.change: Change | None = None
        self._work = Workspace(base)
        self._view = self._work.view
        self._ids = Ids(ids)
        self._problems: list[tuple[str, str]] = []
        self._refused: set[str] = set()
        self._open = True

    @property
    def view(self) -> WorldView:
        """The world as this transaction would leave it."""
        return self._view

    def add(
        self,
        class_: str,
        label: str | None = None,
        id: str | None = None,  # noqa: A002  the customary word
        properties: Mapping[str, Value] | None = None,
        placement: Placement | None = None,
        *,
        learned: bool = False,
    ) -> str:
        """Adds an element and returns its id: the one given, else the next for its class ("relay_box_3").

        Args:
            class_: CURIE of its class.
            label: Its display name; by default, the class's name.
            id: Its id.
            properties: Own values by CURIE of the property.
            placement: Where it is.
            learned: True for something taught to the robot that persists beyond this scene ("learned:mug_1").
        """
        self._check_open()
        element_id = id if id is not None else self._ids.next(class_, learned=learned)
        problem = class_problem(self._view.ontology, class_)
        if problem is None and id is not None:
            problem = id_problem(id)
            if problem is None and self._ids.used(id):
                problem = f"id '{id}' was given before, and ids are never used again"
        if problem:
            self._refuse(element_id, problem)
            self._refused.add(element_id)
            return element_id
        self._put_new(element_id, class_, label or local_name(class_), properties or {})
        if placement is not None:
            self.place(element_id, placement.relation, placement.place)
        return element_id

    def place(self, element: str, relation: str, place: str) -> None:
        """Moves an element: replaces its single placement, of any relation."""
        self._check_open()
        ontology = self._view.ontology
        if relation not in ontology.relations or not ontology.is_placement(relation) or relation == PLACEMENT:
            leaves = ", ".join(ontology.sub_relations(PLACEMENT)[1:])
            self._refuse(
                element,
                Message(
                    "'{relation}' does not place {thing}: use one of {relations}",
                    relation=relation,
                    thing=element,
                    relations=leaves,
                ),
            )
            return
        placement = Placement(relation, place)
        if self._may_relate(*ontology.placement_statement(element, placement)):
            self._work.place(element, placement)

    def relate(self, subject: str, relation: str, object_: str) -> None:
        """States a relation; a placement moves its element, a functional relation replaces its object."""
        self._check_open()
        ontology = self._view.ontology
        if relation in ontology.relations and ontology.is_placement(relation):
            element, placement = ontology.placed(subject, relation, object_)
            self.place(element, relation, placement.place)
        elif relation in (STRUCTURE, COMPUTED):
            below = ", ".join(ontology.sub_relations(relation)[1:])
            self._refuse(subject, f"{relation} is a whole family: use one of {below}")
        elif self._may_relate(subject, relation, object_):
            if ontology.relation(relation).functional:
                for old in self._view.objects(subject, relation):
                    self._work.relate(subject, relation, old, holds=False)
            self._work.relate(subject, relation, object_, holds=True)

    def unrelate(self, subject: str, relation: str, object_: str) -> None:
        """Removes a stated relation; not a placement, since everything that is not abstract has a place."""
        self._check_open()
        if not self._may_relate(subject, relation, object_):
            return
        placement = self._view.ontology.family(relation) is Family.PLACEMENT
        if placement and not is_abstract(subject):
            self._refuse(
                subject,
                Message(
                    "{subject} {relation} {object} cannot be taken away: place it elsewhere instead",
                    subject=subject,
                    relation=relation,
                    object=object_,
                ),
            )
        elif not self._view.stated(subject, relation, object_):
            self._refuse(
                subject,
                Message(
                    "{subject} {relation} {object} is not stated, so it cannot be taken back",
                    subject=subject,
                    relation=relation,
                    object=object_,
                ),
            )
        elif placement:
            self._work.place(self._view.ontology.placed(subject, relation, object_)[0], None)
        else:
            self._work.relate(subject, relation, object_, holds=False)

    def set(self, element: str, property_: str, value: Value | None) -> None:
        """Sets an element's own value of a property, or its ``rdfs:label``; None removes the own value."""
        self._check_open()
        if not self._writable(element):
            return
        old = self._view.element(element)
        try:
            checked = checked_value(self._view.ontology, element, old.type, property_, value)
        except ValueError as error:
            self._refuse(element, str(error))
            return
        self._work.put(with_value(old, property_, checked))

    def remove(self, element: str) -> None:
        """Removes an element with its parts; things placed in any of them move to where the element was."""
        self._check_open()
        if self._writable(element):
            self._problems += remove(self._work, element)

    def set_goals(self, goals: Iterable[str]) -> None:
        """Replaces the texts of the goals stored with the scene."""
        self._check_open()
        texts = [goals] if isinstance(goals, str) else list(goals)
        problems = [problem for text in texts if (problem := goal_problem(text))]
        self._problems += [("", problem) for problem in problems]
        if not problems:
            self._view.goals = tuple(sorted(set(texts)))

    def set_source(self, source: SceneSource) -> None:
        """Replaces the file that the scene was last loaded from or saved to."""
        self._check_open()
        self._view.source = source

    def apply(self, edits: Iterable[Edit]) -> None:
        """Applies edits that were made elsewhere (to undo, to load a scene over another); they may reuse an id.

        Each is checked like any other write; if the world no longer matches an edit's ``old``, ``new`` is applied
        anyway.
        """
        self._check_open()
        for edit in edits:
            self._apply(edit)

    # ------------------------------------------------------------ the end of the block

    def problems(self) -> list[tuple[str, str]]:
        """Returns all problems of the transaction so far, as (element, sentence)."""
        return [*self._problems, *state_problems(self._view, self._work.touched, self._work.places)]

    def finish(self) -> tuple[Index, tuple[Edit, ...]]:
        """Ends the transaction and returns the new state and the net edits.

        Raises:
            WorldError: There are problems; the text names all of them.
        """
        self.close()
        problems = list(dict.fromkeys(sentence for _, sentence in self.problems()))
        if problems:
            raise WorldError(_refusal(problems))
        return self._view, self._work.edits()

    def close(self) -> None:
        """Rejects further writes."""
        self._open = False

    # ------------------------------------------------------------ pieces

    def _apply(self, edit: Edit) -> None:
        if isinstance(edit, ElementEdit):
            self._apply_element(edit)
        elif isinstance(edit, PlacementEdit):
            if edit.new is not None:
                self.place(edit.element, edit.new.relation, edit.new.place)
            elif self._writable(edit.element):
                self._work.place(edit.element, None)
        elif isinstance(edit, PropertyEdit):
            self.set(edit.element, edit.property, edit.new)
        elif isinstance(edit, GoalsEdit):
            self.set_goals(edit.new)
        elif isinstance(edit, SourceEdit):
            self.set_source(edit.new)
        elif edit.new:
            self.relate(edit.subject, edit.relation, edit.object)
        elif self._view.stated(edit.subject, edit.relation, edit.object):
            self.unrelate(edit.subject, edit.relation, edit.object)

    def _apply_element(self, edit: ElementEdit) -> None:
        if edit.new is None:
            if self._writable(edit.element) and not self._holds_guests(edit.element):
                self._work.erase(edit.element)
            return
        problem = class_problem(self._view.ontology, edit.new.type) or id_problem(edit.element)
        if problem is None and self._view.has(edit.element):
            problem = f"id '{edit.element}' is in use"
        if problem:
            self._refuse(edit.element, problem)
            self._refused.add(edit.element)
            return
        self._put_new(edit.element, edit.new.type, edit.new.label, edit.new.properties)

    def _holds_guests(self, element_id: str) -> bool:
        """Learned elements need no placement, so no later check reports that one lost it."""
        learned = [guest for guest in self._view.contents(element_id) if is_abstract(guest)]
        self._problems += [
            (guest, Message("{guest} is placed in {thing}, which would be gone", guest=guest, thing=element_id))
            for guest in learned
        ]
        return bool(learned)

    def _put_new(self, element_id: str, class_: str, label: str, values: Mapping[str, Value]) -> None:
        self._ids.claim(element_id)
        checked = {}
        for name, value in {**values, LABEL: label}.items():
            try:
                checked[name] = checked_value(self._view.ontology, element_id, class_, name, value)
            except ValueError as error:
                self._refuse(element_id, str(error))
        label = str(checked.pop(LABEL, element_id))
        own = {name: value for name, value in checked.items() if value is not None}
        self._work.put(Element(element_id, class_, label, MappingProxyType(own)))

    def _may_relate(self, subject: str, relation: str, object_: str) -> bool:
        if not all([self._writable(subject), self._writable(object_)]):
            return False
        problem = relation_problem(self._view, subject, relation, object_)
        if problem:
            self._refuse(subject, problem)
        return problem is None

    def _writable(self, element_id: str) -> bool:
        if element_id in self._refused or len(self._problems) >= _ENOUGH:
            return False  # already reported
        problem = element_problem(self._view, element_id)
        if problem:
            self._refuse(element_id, problem)
        return problem is None

    def _refuse(self, element: str, sentence: str) -> None:
        self._problems.append((element, sentence))

    def _check_open(self) -> None:
        if not self._open:
            raise WorldError("the transaction is over: write inside its 'with' block")


_ENOUGH = 1000
"""After how many problems the rest of a write is not checked: it is refused anyway."""
_MOST_SHOWN = 20
_LONGEST_SHOWN = 1000


def _refusal(problems: list[str]) -> str:
    """All problems as one text, truncated if very long."""
    shown = [text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…" for text in problems[:_MOST_SHOWN]]
    if len(problems) > _MOST_SHOWN:
        shown.append(Message("and {count} more", count=len(problems) - _MOST_SHOWN))
    if len(shown) == 1:
        return Message("refused: {why}", why=shown[0])
    return joined("\n  - ", [Message("refused:"), *shown])
