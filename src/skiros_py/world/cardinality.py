"""How many things an element has by a relation or property, held against what the ontology says."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Cardinality, Family

__all__ = ["guest_problems", "number_problems"]


def number_problems(view: Index, element_id: str) -> Iterator[str]:
    """Yields a sentence for each relation or property by which an element has too much or too little.

    What is abstract may leave things open, so it never has too little.
    """
    for number in _numbers(view.ontology, view.element(element_id).type):
        yield from _number_problem(view, element_id, number)
    for relation in _one_subject(view.ontology):
        subjects = view.subjects(relation, element_id)
        if len(subjects) > 1:
            yield f"{element_id} is the {relation} of {' and '.join(subjects)}: it can be so of one only"


def guest_problems(view: Index, place: str) -> Iterator[str]:
    """Yields a sentence for each relation by which too much or too little is placed at an element."""
    for number in _guest_numbers(view.ontology, view.element(place).type):
        yield from _number_problem(view, place, number)


def _number_problem(view: Index, element_id: str, number: Cardinality) -> Iterator[str]:
    found = _counted(view, element_id, number)
    if number.most is not None and len(found) > number.most:
        names = f" ({', '.join(found[:10])})" if found[0] else ""
        yield f"{_said(view, element_id, number)} at most {number.most}, and there are {len(found)}{names}"
    elif len(found) < number.least and not is_abstract(element_id):
        there_are = f"there are {len(found)}" if found else "there is none"
        yield f"{_said(view, element_id, number)} at least {number.least}, and {there_are}"


def _said(view: Index, element_id: str, number: Cardinality) -> str:
    what = f" a {number.of}" if number.of else ""
    return f"{element_id} ({view.element(element_id).type}) must have by {number.relation}{what}"


def _counted(view: Index, element_id: str, number: Cardinality) -> tuple[str, ...]:
    """What the element has; of a property, whose values have no name, "" for each."""
    ontology = view.ontology
    if number.relation in ontology.properties:
        return () if view.value(element_id, number.relation) is None else ("",)
    found = view.objects(element_id, number.relation)
    if number.of is None or number.of not in ontology.classes:
        return found
    return tuple(name for name in found if ontology.is_a(view.element(name).type, number.of))


@lru_cache(maxsize=4096)
def _numbers(ontology: Ontology, class_: str) -> tuple[Cardinality, ...]:
    """What is held against individuals of a class; computed relations are not stored and so not counted."""
    said = {number for number in ontology.cardinalities(class_) if _is_counted(ontology, number.relation)}
    one = {
        Cardinality(relation.curie, 0, 1, None)
        for relation in ontology.relations.values()
        if relation.functional
        and _is_counted(ontology, relation.curie)
        and not ontology.missed_end(class_, relation.domains)
    }
    return tuple(sorted(said | one, key=lambda number: (number.relation, number.least, repr(number))))


@lru_cache(maxsize=4096)
def _guest_numbers(ontology: Ontology, class_: str) -> tuple[Cardinality, ...]:
    """Those of placements whose subject is the place: what comes and goes there is counted."""
    relations = ontology.relations
    return tuple(
        number
        for number in _numbers(ontology, class_)
        if number.relation in relations and relations[number.relation].place_end == "subject"
    )


def _is_counted(ontology: Ontology, name: str) -> bool:
    if name in ontology.relations:
        return ontology.family(name) is not Family.COMPUTED
    return name in ontology.properties


@lru_cache(maxsize=64)
def _one_subject(ontology: Ontology) -> tuple[str, ...]:
    return tuple(
        sorted(r.curie for r in ontology.relations.values() if r.inverse_functional and r.family is not Family.COMPUTED)
    )
