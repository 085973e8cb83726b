"""Reads the declarations of ontology files, and refuses those that would be misunderstood later.

The world model uses a part of OWL: classes with their superclasses, equivalents and cardinalities; relations and
properties with domains and ranges, also as unions and intersections; characteristics of relations; values and relations
that classes give to their individuals. All other statements stay in the graph for queries and OWL reasoners.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyoxigraph as ox

from skiros_py.errors import UnknownName
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, DATATYPES, parse_value
from skiros_py.world.names import Names, local_name
from skiros_py.world.ontology.documents import Document
from skiros_py.world.ontology.statements import Node, Statements, english, is_standard, vocabulary
from skiros_py.world.terms import (
    MOST_ABOVE,
    Cardinality,
    Class,
    End,
    Family,
    Filler,
    Kind,
    PlaceEnd,
    Property,
    Relation,
    closure,
    cycle,
    reached,
    too_deep,
)

# ---------------------------------------------------------------- class expressions


_NUMBERS = {
    "owl:cardinality": (True, True),
    "owl:qualifiedCardinality": (True, True),
    "owl:minCardinality": (True, False),
    "owl:minQualifiedCardinality": (True, False),
    "owl:maxCardinality": (False, True),
    "owl:maxQualifiedCardinality": (False, True),
}
"""Whether each states a minimum, a maximum."""
_FILLERS = {"owl:someValuesFrom": True, "owl:allValuesFrom": True, "owl:hasValue": False}
"""Whether each names a class."""


def end(statements: Statements, expressions: list[Node], known: Callable[[str], bool]) -> End:
    """Returns the classes that several expressions together require at an end of a relation.

    Args:
        statements: All statements.
        expressions: Domains or ranges; all must be satisfied.
        known: Returns whether a name stands for a class that can be checked, or raises.
    """
    parts = (part for expression in expressions for part in statements.conjuncts(expression))
    groups = {_group(statements, part, known) for part in parts}
    return tuple(sorted(group for group in groups if group))


def cardinalities(statements: Statements, expression: Node) -> Iterator[Cardinality]:
    """Yields the cardinalities that a restriction states for a named relation or property.

    Raises:
        ValueError: A number is malformed.
    """
    if not isinstance(expression, ox.BlankNode):
        return
    node = statements.key(expression)
    on, of = statements.named(node, "owl:onProperty"), _counted(statements, node)
    for predicate, (least, most) in _NUMBERS.items():
        for literal in statements.objects(node, predicate):
            if on and of is not None and isinstance(literal, ox.Literal):
                number = _number(literal.value)
                yield Cardinality(on[0], number if least else 0, number if most else None, of or None)


def fillers(statements: Statements, expression: Node) -> Iterator[Filler]:
    """Yields the named classes and individuals that a restriction relates its individuals to."""
    if not isinstance(expression, ox.BlankNode):
        return
    node = statements.key(expression)
    for relation in statements.named(node, "owl:onProperty"):
        for predicate, is_class in _FILLERS.items():
            for name in statements.named(node, predicate):
                yield Filler(relation, name, is_class)


def _counted(statements: Statements, node: str) -> str | None:
    """The class or data type that is counted; "" for all, None if it is anonymous."""
    counted = [*statements.objects(node, "owl:onClass"), *statements.objects(node, "owl:onDataRange")]
    if not counted:
        return ""
    name = statements.key(counted[0]) if isinstance(counted[0], ox.NamedNode) else None
    return "" if name in ("owl:Thing", "rdfs:Literal") else name


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ValueError(f"a number of things must be a whole number from 0, not '{text[:20]}'")
    return int(text)


def _group(statements: Statements, node: Node, known: Callable[[str], bool]) -> tuple[str, ...]:
    """The classes of which one is enough; none if they have no names, so that nothing can be checked."""
    nodes = reached([node], lambda node: statements.parts(node, "owl:unionOf"))
    leaves = [node for node in nodes if not statements.is_expression(node, "owl:unionOf")]
    names = {statements.key(leaf) for leaf in leaves if isinstance(leaf, ox.NamedNode)}
    return tuple(sorted(names)) if len(names) == len(leaves) and all(map(known, sorted(names))) else ()


_FAMILIES = {
    "sk:placement": Family.PLACEMENT,
    "sk:structure": Family.STRUCTURE,
    "sk:computed": Family.COMPUTED,
}
_COMMENT = Property(
    "rdfs:comment", "comment", "What people note about it.", (), "xsd:string",
    labels={"de": "Kommentar"}, comments={"de": "Notiz für Menschen."},
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Declarations:
    """All declarations of the files, by CURIE.

    Attributes:
        classes, relations, properties: The terms.
        class_values: Values that a class itself gives to its individuals: by property, by class.
        individuals: CURIEs of the individuals that the files describe, sorted; those of scenes are not among them.
    """

    classes: Mapping[str, Class]
    relations: Mapping[str, Relation]
    properties: Mapping[str, Property]
    class_values: Mapping[str, Mapping[str, Value]]
    individuals: tuple[str, ...]


def read_declarations(files: Sequence[Document], names: Names) -> Declarations:
    """Reads the terms of all files; a term may use those of any other file.

    A word must be declared by some file, unless it is a predicate or a type from a vocabulary of which no file declares
    anything (as ``dc:creator`` often is): then it is ignored.

    Raises:
        FileError: A term is used that no file declares, or a declaration is incomplete or contradictory.
    """
    reader = _Reader(Statements(files, names), names)
    properties = {term: reader.property(term) for term in reader.declared[Kind.PROPERTY]}
    properties["rdfs:comment"] = _COMMENT
    return Declarations(
        classes=reader.classes(),
        relations=reader.relations(),
        properties=properties,
        class_values={term: reader.class_values(term, properties) for term in reader.declared[Kind.CLASS]},
        individuals=reader.individuals(),
    )


class _Reader:
    """Reads terms from the statements of all files."""

    def __init__(self, statements: Statements, names: Names) -> None:
        self._statements = statements
        self._objects, self._fault, self._undeclared = statements.objects, statements.fault, statements.undeclared
        self._names = names
        self.declared = statements.declared
        for kind, terms in self.declared.items():
            for term in terms:
                if term.partition(":")[0] not in names.prefixes:
                    reason = f"the {kind} <{term}> needs a name after the last '#' or '/' of its IRI"
                    raise statements.fault(term, reason)
        self._terms = {term for terms in self.declared.values() for term in terms}
        self._equivalents = self._both_ways(Kind.CLASS, "owl:equivalentClass")
        self._inverses = self._both_ways(Kind.RELATION, "owl:inverseOf")

    # ------------------------------------------------------------ classes

    def classes(self) -> dict[str, Class]:
        """Returns all classes."""
        found = {term: self._class(term) for term in self.declared[Kind.CLASS]}
        self._check_no_cycle({term: class_.parents for term, class_ in found.items()}, "rdfs:subClassOf")
        self._check_depth({term: (*c.parents, *c.equivalents) for term, c in found.items()}, "rdfs:subClassOf")
        return found

    def _class(self, term: str) -> Class:
        equivalents = (n for n in self._objects(term, "owl:equivalentClass") if isinstance(n, ox.BlankNode))
        stated = (*self._objects(term, "rdfs:subClassOf"), *equivalents)
        above = [part for node in stated for part in self._statements.conjuncts(node)]
        parents = self._references(term, above, Kind.CLASS)
        primary = self._references(term, self._objects(term, "sk:primaryParent"), Kind.CLASS)
        if not set(primary) <= set(parents):
            raise self._fault(term, f"sk:primaryParent of {term} is {primary[0]}, which is none of its superclasses")
        try:
            numbers = {number for part in above for number in cardinalities(self._statements, part)}
        except ValueError as error:
            raise self._fault(term, f"in a restriction of {term}: {error}", "rdfs:subClassOf") from None
        return Class(
            **self._texts(term),
            parents=tuple(primary[:1] + [parent for parent in parents if parent not in primary[:1]]),
            equivalents=tuple(sorted(self._equivalents.get(term, ()))),
            cardinalities=tuple(sorted(numbers, key=repr)),
            fillers=tuple(sorted({f for part in above for f in fillers(self._statements, part)}, key=repr)),
        )

    def class_values(self, class_: str, properties: Mapping[str, Property]) -> dict[str, Value]:
        """Returns the values that a class itself gives, by property."""
        values: dict[str, Value] = {}
        for predicate in self._statements.about(class_):
            if predicate not in self._terms and self._should_be_declared(predicate):
                known = [*self.declared[Kind.PROPERTY], *self.declared[Kind.ANNOTATION]]
                raise self._undeclared(class_, str(UnknownName("property", predicate, known)), predicate)
            if predicate in properties and predicate != "rdfs:comment":
                values[predicate] = self._class_value(class_, properties[predicate])
        return values

    def _class_value(self, class_: str, property_: Property) -> Value:
        literals = {node for node in self._objects(class_, property_.curie) if isinstance(node, ox.Literal)}
        if any(literal.language for literal in literals):
            literals = {english(sorted(literals, key=str))}
        if len(literals) != 1:
            reason = f"{class_} needs one value of {property_.curie}, got {len(literals)}"
            raise self._fault(class_, reason, property_.curie)
        literal = literals.pop()
        try:
            return parse_value(literal.value, self._names.name(literal.datatype.value), property_.range)
        except ValueError as error:
            raise self._fault(class_, f"{property_.curie} of {class_} {error}", property_.curie) from None

    # ------------------------------------------------------------ relations and properties

    def relations(self) -> dict[str, Relation]:
        """Returns all relations."""
        above = {
            term: tuple(self._references(term, self._objects(term, "rdfs:subPropertyOf"), Kind.RELATION))
            for term in self.declared[Kind.RELATION]
        }
        self._check_no_cycle(above, "rdfs:subPropertyOf")
        self._check_depth(above, "rdfs:subPropertyOf")
        return {term: self._relation(term, above) for term in above}

    def _relation(self, term: str, above: Mapping[str, tuple[str, ...]]) -> Relation:
        family = next((_FAMILIES[name] for name in closure(above, term) if name in _FAMILIES), Family.PLAIN)
        types = set(self._statements.named(term, "rdf:type"))
        return Relation(
            **self._texts(term),
            parents=above[term],
            domains=self._end(term, "rdfs:domain"),
            ranges=self._end(term, "rdfs:range"),
            family=family,
            place_end=self._place_end(term) if family is Family.PLACEMENT else None,
            functional="owl:FunctionalProperty" in types,
            inverse=min(self._inverses.get(term, ()), default=None),
            inverse_functional="owl:InverseFunctionalProperty" in types,
            symmetric="owl:SymmetricProperty" in types,
            transitive="owl:TransitiveProperty" in types,
        )

    def property(self, term: str) -> Property:
        """Returns one property."""
        ranges = {self._data_range(term, node) for node in self._objects(term, "rdfs:range")}
        # Several ranges must all be met: too rare to check more than that it is a literal.
        range_ = ranges.pop() if len(ranges) == 1 else ANY_LITERAL
        unit = self._statements.text(term, "sk:unit")
        return Property(**self._texts(term), domains=self._end(term, "rdfs:domain"), range=range_, unit=unit)

    def _data_range(self, term: str, node: Node) -> str:
        """The data type of values; one that a file defines itself stands for any literal."""
        if not isinstance(node, ox.NamedNode):
            return ANY_LITERAL
        name = self._statements.key(node)
        if name in DATATYPES:
            return name
        if name not in self.declared[Kind.DATATYPE]:
            reason = f"rdfs:range of {term}: {UnknownName('data type', name, DATATYPES)}"
            raise self._undeclared(term, reason, name)
        return ANY_LITERAL

    def _end(self, term: str, predicate: str) -> End:
        expressions = self._objects(term, predicate)
        return end(self._statements, expressions, lambda name: self._is_declared(term, name, Kind.CLASS))

    def _place_end(self, term: str) -> PlaceEnd:
        place = self._statements.text(term, "sk:placeEnd")
        if place == "object":
            return "object"
        if place == "subject":
            return "subject"
        raise self._fault(term, f'{term} is a placement and needs sk:placeEnd "object" or "subject", got \'{place}\'')

    # ------------------------------------------------------------ individuals

    def individuals(self) -> tuple[str, ...]:
        """Returns the individuals of declared classes, except terms."""
        found: list[str] = []
        for name, _ in self._statements.subjects():
            types = self._statements.named(name, "rdf:type")
            for type_ in types:
                if type_ not in self._terms and self._should_be_declared(type_):
                    unknown = UnknownName("class", type_, self.declared[Kind.CLASS])
                    raise self._undeclared(name, f"{name} is of an {unknown}", type_)
            if name not in self._terms and any(type_ in self.declared[Kind.CLASS] for type_ in types):
                found.append(name)
        return tuple(sorted(found))

    # ------------------------------------------------------------ pieces

    def _references(self, term: str, nodes: Sequence[Node], kind: Kind) -> list[str]:
        """Named terms among nodes, sorted."""
        names = {self._statements.key(node) for node in nodes if isinstance(node, ox.NamedNode)}
        return [name for name in sorted(names) if self._is_declared(term, name, kind)]

    def _is_declared(self, term: str, name: str, kind: Kind) -> bool:
        """Returns whether a name to which a term refers is of a kind; False for what OWL itself declares."""
        if name in self.declared[kind]:
            return True
        if is_standard(name):
            return False
        raise self._undeclared(term, f"{term} refers to {UnknownName(kind, name, self.declared[kind])}", name)

    def _both_ways(self, kind: Kind, predicate: str) -> dict[str, set[str]]:
        found: dict[str, set[str]] = {}
        for term in self.declared[kind]:
            for other in self._references(term, self._objects(term, predicate), kind):
                if other == term:
                    continue
                found.setdefault(term, set()).add(other)
                found.setdefault(other, set()).add(term)
        return found

    def _should_be_declared(self, name: str) -> bool:
        return not is_standard(name) and vocabulary(name) in self._statements.vocabularies

    def _check_no_cycle(self, above: Mapping[str, tuple[str, ...]], predicate: str) -> None:
        found = cycle(above)
        if found:
            line = " -> ".join(found)
            raise self._fault(found[0], f"{found[0]} is above itself by {predicate}: {line}", found[1])

    def _check_depth(self, above: Mapping[str, tuple[str, ...]], predicate: str) -> None:
        deep = too_deep(above)
        if deep is not None:
            raise self._fault(deep, f"{deep} has more than {MOST_ABOVE} terms above it by {predicate}", predicate)

    def _texts(self, term: str) -> dict[str, Any]:
        """What each kind of term has: its name, and label and comment in all languages."""
        return {
            "curie": term,
            "label": self._statements.text(term, "rdfs:label") or local_name(term),
            "comment": self._statements.text(term, "rdfs:comment"),
            "labels": self._statements.translations(term, "rdfs:label"),
            "comments": self._statements.translations(term, "rdfs:comment"),
        }
