"""The individuals that the ontology itself describes, as elements: templates, such as a kit with its compartments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from types import MappingProxyType
from weakref import WeakKeyDictionary

import pyoxigraph as ox

from skiros_py.world.change import Edit, ElementEdit, PlacementEdit, RelationEdit
from skiros_py.world.checks import checked_value, relation_problem, state_problems
from skiros_py.world.element import Element
from skiros_py.world.index import Index, with_value
from skiros_py.world.literals import parse_value
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.statements import Node, Statements, english
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners
from skiros_py.world.vocabulary import ELEMENT, LABEL

_READ: WeakKeyDictionary[Ontology, tuple[Edit, ...]] = WeakKeyDictionary()
_NO_CLASSES = ("owl:NamedIndividual", "owl:Thing")


def abstract_individuals(ontology: Ontology, reasoners: Reasoners) -> Index:
    """Returns the state of a world with only the individuals described in the ontology's files.

    An individual becomes an element of the most specific of its classes that are classes of elements. Ontologies of
    others say more than elements can bear: individuals of no such class, words that are not declared, several values of
    a property, and what fits another class of an individual that has several; these stay in the graph for queries.

    Raises:
        FileError: The statements about an individual do not fit its class.
    """
    if ontology not in _READ:
        _READ[ontology] = tuple(_Reader(ontology).edits()) if ontology.individuals else ()
    index = Index(ontology, reasoners)
    for edit in _READ[ontology]:
        index.apply(edit)
    return index


class _Reader:
    """Creates elements from individuals, and checks them."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._statements = Statements(ontology.sources, ontology.names)
        self._index = Index(ontology, NO_REASONERS)
        self._lenient: set[str] = set()

    def edits(self) -> Iterator[Edit]:
        """Yields the edits that create the elements; they are validated."""
        elements = [name for name in self._ontology.individuals if self._add(name)]
        for name in elements:
            self._set_values(name)
        edits = [edit for name in elements for edit in self._relate(name)]
        for name, problem in state_problems(self._index, elements):
            raise self._statements.fault(name, problem)
        yield from (ElementEdit(name, None, self._index.element(name)) for name in elements)
        yield from edits

    def _add(self, name: str) -> bool:
        types = set(self._statements.named(name, "rdf:type")).difference(_NO_CLASSES)
        fitting = [t for t in sorted(types) if t in self._ontology.classes and self._ontology.is_a(t, ELEMENT)]
        if not fitting:
            return False
        class_ = max(fitting, key=lambda type_: len(self._ontology.ancestors(type_)))
        if any(type_ not in self._ontology.classes or not self._ontology.is_a(class_, type_) for type_ in types):
            self._lenient.add(name)
        label = self._statements.text(name, LABEL) or local_name(name)
        self._index.put_element(Element(name, class_, label, MappingProxyType({})))
        return True

    def _set_values(self, name: str) -> None:
        for predicate in sorted(self._statements.about(name).keys() & self._ontology.properties.keys()):
            literal = _literal(self._statements.objects(name, predicate))
            if literal is None:
                continue
            element, type_ = self._index.element(name), self._ontology.names.name(literal.datatype.value)
            try:
                value = parse_value(literal.value, type_, self._ontology.properties[predicate].range)
                checked = checked_value(self._ontology, name, element.type, predicate, value)
            except ValueError as error:
                self._refuse(name, f"{predicate} of {name}: {error}", predicate)
            else:
                self._index.put_element(with_value(element, predicate, checked))

    def _relate(self, name: str) -> Iterator[Edit]:
        for relation in sorted(self._statements.about(name).keys() & self._ontology.relations.keys()):
            for object_ in sorted(set(self._statements.named(name, relation))):
                if self._index.has(object_):
                    problem = relation_problem(self._index, name, relation, object_)
                    if problem:
                        self._refuse(name, problem, relation)
                    else:
                        yield self._related(name, relation, object_)

    def _related(self, name: str, relation: str, object_: str) -> Edit:
        edit: Edit = RelationEdit(name, relation, object_, old=False, new=True)
        if self._ontology.is_placement(relation):
            element, placement = self._ontology.placed(name, relation, object_)
            old = self._index.placement(element)
            if old is not None and old != placement:
                said = f"{old.relation} {old.place}, {placement.relation} {placement.place}"
                raise self._statements.fault(name, f"{element} may have one of these, not all: {said}", relation)
            edit = PlacementEdit(element, None, placement)
        self._index.apply(edit)
        return edit

    def _refuse(self, name: str, problem: str, at: str) -> None:
        if name not in self._lenient:
            raise self._statements.fault(name, problem, at)


def _literal(nodes: Sequence[Node]) -> ox.Literal | None:
    """The single value stated, or the one in the display language."""
    literals = list(dict.fromkeys(node for node in nodes if isinstance(node, ox.Literal)))
    if len(literals) > 1 and any(literal.language for literal in literals):
        return english(literals)
    return literals[0] if len(literals) == 1 else None
