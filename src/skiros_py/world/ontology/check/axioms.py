"""Axioms: the statements that a reasoner takes or leaves as one, each with the anonymous nodes that hang on it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyoxigraph as ox

from skiros_py.world.ontology.check.material import Material, Statement
from skiros_py.world.ontology.check.owl import ANNOTATIONS, DECLARES, HEADER, is_standard, owl, rdf
from skiros_py.world.ontology.documents import Document
from skiros_py.world.ontology.kinds import Kind

__all__ = ["Axiom", "Axioms", "axioms_of", "triples_of"]

_TYPE = rdf("type")
_ONLY_DECLARE = frozenset({owl("Class"), owl("ObjectProperty"), owl("DatatypeProperty"), owl("NamedIndividual")}) | {
    type_ for type_, kind in DECLARES.items() if kind in (Kind.ANNOTATION, Kind.DATATYPE)
}


@dataclass(frozen=True, slots=True)
class Axiom:
    """One thing that a file says.

    Attributes:
        document: The file.
        head: The triple that starts it.
        body: What hangs on it by anonymous nodes: lists, restrictions, class expressions.
        is_assertion: True when it is about individuals, False when about classes, relations and properties.
    """

    document: Document
    head: ox.Triple
    body: tuple[ox.Triple, ...]
    is_assertion: bool

    @property
    def triples(self) -> tuple[ox.Triple, ...]:
        """All that it is made of."""
        return (self.head, *self.body)

    @property
    def subject(self) -> str | None:
        """IRI of what it is about, or None where that is anonymous."""
        return self.head.subject.value if isinstance(self.head.subject, ox.NamedNode) else None

    def names(self) -> frozenset[str]:
        """Returns the IRIs of all terms and individuals in it."""
        nodes = {node for triple in self.triples for node in (triple.subject, triple.predicate, triple.object)}
        return frozenset(n.value for n in nodes if isinstance(n, ox.NamedNode) and not is_standard(n.value))


@dataclass(frozen=True, slots=True)
class Axioms:
    """What the files say to a reasoner.

    Attributes:
        declarations: What is a class, relation, property or data type; always given to a reasoner.
        said: All else, in file order.
        classes: IRIs of the classes, sorted.
    """

    declarations: tuple[ox.Triple, ...]
    said: tuple[Axiom, ...]
    classes: tuple[str, ...]


def axioms_of(material: Material) -> Axioms:
    """Sorts the statements of all files into axioms; words for people and class-level values are left out.

    Class-level values are defaults that subclasses may override, which OWL does not know.
    """
    said: list[Axiom] = []
    declarations: dict[ox.Triple, None] = {}
    for number, document in enumerate(material.documents):
        statements = [Statement(document, _renamed(triple, number)) for triple in document.triples]
        logical = [s for s in statements if _is_logical(material, s)]
        declarations.update((s.triple, None) for s in logical if _declares(s))
        said.extend(_grouped(document, [s for s in logical if not _declares(s)]))
    return Axioms(tuple(declarations), tuple(said), tuple(sorted(material.declared[Kind.CLASS])))


def triples_of(axioms: Iterable[Axiom]) -> list[ox.Triple]:
    """Returns the triples of several axioms."""
    return [triple for axiom in axioms for triple in axiom.triples]


def _grouped(document: Document, statements: Sequence[Statement]) -> Iterator[Axiom]:
    about: dict[object, list[ox.Triple]] = defaultdict(list)
    referred = set()
    for statement in statements:
        about[statement.triple.subject].append(statement.triple)
        referred.add(statement.triple.object)
    for subject, triples in about.items():
        if not isinstance(subject, ox.BlankNode):
            for head in triples:
                yield Axiom(document, head, _body(about, head.object), _asserts(head))
        elif subject not in referred:  # nothing leads to it: disjointness of many, a negative assertion
            head = next((t for t in triples if t.predicate.value == _TYPE), triples[0])
            rest = [t for t in triples if t is not head]
            body = (*rest, *(t for r in rest for t in _body(about, r.object)))
            yield Axiom(document, head, body, _asserts(head))


def _body(about: Mapping[object, Sequence[ox.Triple]], node: object) -> tuple[ox.Triple, ...]:
    found: list[ox.Triple] = []
    waiting, seen = [node], set()
    while waiting:
        current = waiting.pop()
        if isinstance(current, ox.BlankNode) and current not in seen:
            seen.add(current)
            found.extend(about.get(current, ()))
            waiting.extend(triple.object for triple in about.get(current, ()))
    return tuple(found)


def _is_logical(material: Material, statement: Statement) -> bool:
    word, subject = statement.predicate, statement.subject
    if word in ANNOTATIONS or word in HEADER or statement.object == owl("Ontology"):
        return False
    if word in material.declared[Kind.ANNOTATION] or not (is_standard(word) or material.is_term(word)):
        return False
    return is_standard(word) or subject is None or not material.is_term(subject)


def _declares(statement: Statement) -> bool:
    return statement.predicate == _TYPE and statement.object in _ONLY_DECLARE and statement.subject is not None


def _asserts(head: ox.Triple) -> bool:
    word = head.predicate.value
    if word == _TYPE and isinstance(head.object, ox.NamedNode):
        return not is_standard(head.object.value) or head.object.value in _ABOUT_INDIVIDUALS
    return word == _TYPE or not is_standard(word) or word in _ABOUT_INDIVIDUALS


_ABOUT_INDIVIDUALS = frozenset(
    owl(w) for w in ("sameAs", "differentFrom", "AllDifferent", "NegativePropertyAssertion", "Thing", "Nothing")
)


def _renamed(triple: ox.Triple, number: int) -> ox.Triple:
    """The triple with anonymous nodes that no other file has."""
    return ox.Triple(_own(triple.subject, number), triple.predicate, _own(triple.object, number))


def _own(node: Any, number: int) -> Any:
    return ox.BlankNode(f"f{number}x{node.value}") if isinstance(node, ox.BlankNode) else node
