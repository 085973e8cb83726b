"""Snapshots of a world in a journal, in pieces; and whether a state that was read fits the ontology."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from skiros_py.errors import UnknownName
from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, RelationEdit, SceneSource, SourceEdit
from skiros_py.world.element import Element, Stamp, Value, is_abstract, is_learned
from skiros_py.world.index import Index
from skiros_py.world.journal.records import decode_edits, encode_edits
from skiros_py.world.literals import DATATYPES, shown
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ELEMENT


def unfit(index: Index) -> Iterator[str]:
    """Yields a sentence for each name in a state that the ontology does not declare, or declares as another kind.

    Only the final state must fit: elements removed long ago may have had classes that no longer exist.
    """
    ontology, elements = index.ontology, [index.element(name) for name in index.ids()]
    classes = ontology.subclasses(ELEMENT)
    for name in sorted({element.type for element in elements}.difference(classes)):
        yield f"{name} is no {ELEMENT}" if name in ontology.classes else str(UnknownName("class", name, classes))
    placements, others = index.used_relations()
    for name in sorted(placements | others):
        family = ontology.relations[name].family if name in ontology.relations else None
        if family is None:
            yield str(UnknownName("relation", name, ontology.relations))
        elif name in placements and family is not Family.PLACEMENT:
            yield f"{name} says where things are, and is no placement any more"
        elif name in others and family in (Family.PLACEMENT, Family.COMPUTED):
            yield f"{name} is stored as a plain relation, and is a {family.value} relation now"
    yield from _value_problems(ontology, elements)


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


def read_piece(index: Index, edits: str, stamps: str) -> None:
    """Adds the content of a piece to a state.

    Raises:
        ValueError: It was not written by :func:`snapshot_pieces`.
    """
    try:
        for edit in decode_edits(edits):
            index.apply(edit)
        for name, (change, time) in json.loads(stamps).items():
            index.mark([name], Stamp(int(change), float(time)))
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
