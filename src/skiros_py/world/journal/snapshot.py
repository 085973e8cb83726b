"""The state that a journal leads to: snapshots in pieces, the changes after them, and whether all fits the ontology."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, TypeVar

from skiros_py.errors import UnknownName
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    RelationEdit,
    SceneSource,
    SourceEdit,
)
from skiros_py.world.element import Element, Placement, Stamp, Value, is_abstract, is_learned
from skiros_py.world.index import Index, with_value
from skiros_py.world.journal.records import decode_edits, encode_edits
from skiros_py.world.literals import DATATYPES, shown
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ELEMENT

if TYPE_CHECKING:
    from skiros_py.world.ontology import Ontology

_Key = TypeVar("_Key")
_Entry = TypeVar("_Entry")


class Content:
    """A state in plain tables, to which edits are applied one by one.

    Only the final state must fit the ontology: elements removed long ago may have had classes that no longer exist.
    """

    def __init__(self) -> None:
        self._elements: dict[str, Element] = {}
        self._placements: dict[str, Placement] = {}
        self._relations: dict[tuple[str, str, str], bool] = {}
        self._stamps: dict[str, Stamp] = {}
        self._goals: tuple[str, ...] = ()
        self._source = SceneSource()

    def apply(self, edits: Iterable[Edit]) -> None:
        """Applies edits in order.

        Raises:
            KeyError: One is about an element that does not exist.
        """
        for edit in edits:
            self._apply(edit)

    def take(self, change: Change) -> None:
        """Applies a change, and stamps the elements that it touched.

        Raises:
            KeyError: It is about an element that does not exist.
        """
        self.apply(change.edits)
        stamp = Stamp(change.number, change.time)
        self.stamp(dict.fromkeys(change.marks(), stamp))

    def stamp(self, stamps: Mapping[str, Stamp]) -> None:
        """Sets the last changes of elements."""
        self._stamps.update(stamps)

    def problems(self, ontology: Ontology) -> tuple[str, ...]:
        """Returns a sentence for each name that the ontology does not declare, or declares as another kind."""
        found = (
            *_class_problems(ontology, {element.type for element in self._elements.values()}),
            *_placement_problems(ontology, {placement.relation for placement in self._placements.values()}),
            *_relation_problems(ontology, {relation for _, relation, _ in self._relations}),
            *_value_problems(ontology, self._elements.values()),
        )
        return tuple(found)

    def index(self, beginning: Index) -> Index:
        """Returns the state, added to an initial one."""
        index = beginning.copy()
        for element in self._elements.values():
            index.put_element(element)
        for name, placement in self._placements.items():
            index.put_placement(name, placement)
        for subject, relation, object_ in self._relations:
            index.put_relation(subject, relation, object_, holds=True)
        index.goals, index.source = self._goals, self._source
        together: dict[Stamp, list[str]] = {}
        for name, stamp in self._stamps.items():
            together.setdefault(stamp, []).append(name)
        for stamp, names in together.items():
            index.mark(names, stamp)
        return index

    def _apply(self, edit: Edit) -> None:
        if isinstance(edit, ElementEdit):
            _put(self._elements, edit.element, edit.new)
        elif isinstance(edit, PlacementEdit):
            _put(self._placements, edit.element, edit.new)
        elif isinstance(edit, RelationEdit):
            _put(self._relations, (edit.subject, edit.relation, edit.object), edit.new or None)
        elif isinstance(edit, GoalsEdit):
            self._goals = edit.new
        elif isinstance(edit, SourceEdit):
            self._source = edit.new
        else:
            self._elements[edit.element] = with_value(self._elements[edit.element], edit.property, edit.new)


def _put(table: dict[_Key, _Entry], key: _Key, entry: _Entry | None) -> None:
    if entry is None:
        table.pop(key, None)
    else:
        table[key] = entry


def _class_problems(ontology: Ontology, classes: Iterable[str]) -> Iterator[str]:
    elements = set(ontology.subclasses(ELEMENT))
    for name in sorted(set(classes) - elements):
        yield f"{name} is no {ELEMENT}" if name in ontology.classes else str(UnknownName("class", name, elements))


def _placement_problems(ontology: Ontology, relations: Iterable[str]) -> Iterator[str]:
    for name in sorted(relations):
        if name not in ontology.relations:
            yield str(UnknownName("relation", name, ontology.relations))
        elif not ontology.is_placement(name):
            yield f"{name} says where things are, and is no placement any more"


def _relation_problems(ontology: Ontology, relations: Iterable[str]) -> Iterator[str]:
    for name in sorted(relations):
        if name not in ontology.relations:
            yield str(UnknownName("relation", name, ontology.relations))
        elif ontology.family(name) in (Family.PLACEMENT, Family.COMPUTED):
            yield f"{name} is stored as a plain relation, and is a {ontology.family(name).value} relation now"


def _value_problems(ontology: Ontology, elements: Iterable[Element]) -> Iterator[str]:
    """Checks one value of each Python type: enough to find properties that have another type now."""
    samples: dict[tuple[str, type], tuple[str, Value]] = {}
    for element in elements:
        for name, value in element.properties.items():
            samples.setdefault((name, type(value)), (element.id, value))
    missing = {name for name, _ in samples} - set(ontology.properties)
    yield from (str(UnknownName("property", name, ontology.properties)) for name in sorted(missing))
    for (name, _), (element_id, value) in samples.items():
        if name not in missing and not DATATYPES[ontology.properties[name].range].fits(value):
            yield f"{name} is a {ontology.properties[name].range} now, and {element_id} has {shown(value)}"


# ---------------------------------------------------------------- pieces of a snapshot


_ELEMENTS_IN_PIECE = 1000


def snapshot_pieces(index: Index) -> Iterator[tuple[str, str]]:
    """Yields the texts of edits that lead from nothing to the state, with the stamps of their elements.

    The individuals of the ontology are left out: they come from the ontology's files.
    """
    yield encode_edits([GoalsEdit((), index.goals), SourceEdit(SceneSource(), index.source)]), "{}"
    relations = _relations(index)
    names = sorted(name for name in index.ids() if is_learned(name) or not is_abstract(name))
    for first in range(0, len(names), _ELEMENTS_IN_PIECE):
        piece = names[first : first + _ELEMENTS_IN_PIECE]
        edits = [edit for name in piece for edit in _edits(index, name, relations.get(name, ()))]
        yield encode_edits(edits), _stamps(index, piece)


def read_piece(content: Content, edits: str, stamps: str) -> None:
    """Adds the content of a piece.

    Raises:
        ValueError: It was not written by :func:`snapshot_pieces`.
    """
    try:
        content.apply(decode_edits(edits))
        content.stamp({name: Stamp(int(change), float(time)) for name, (change, time) in json.loads(stamps).items()})
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no snapshot: {error}") from None


def _edits(index: Index, name: str, relations: Iterable[RelationEdit]) -> Iterator[Edit]:
    yield ElementEdit(name, None, index.element(name))
    placement = index.placement(name)
    if placement is not None:
        yield PlacementEdit(name, None, placement)
    yield from relations


def _relations(index: Index) -> dict[str, list[RelationEdit]]:
    """Returns every relation except placements, by its subject."""
    found: dict[str, list[RelationEdit]] = {}
    for subject, relation, object_ in index.statements():
        if not index.ontology.is_placement(relation) and (is_learned(subject) or not is_abstract(subject)):
            edit = RelationEdit(subject, relation, object_, old=False, new=True)
            found.setdefault(subject, []).append(edit)
    return found


def _stamps(index: Index, names: Iterable[str]) -> str:
    stamps = {name: index.stamp(name) for name in names}
    return json.dumps({name: [stamp.change, stamp.time] for name, stamp in stamps.items() if stamp.change})
