"""Reads what ontology files declare, and refuses what would be misunderstood later.

OWL says more than a world is checked by. What is read: classes with their superclasses, equivalents and cardinalities;
relations and properties with domains and ranges, also as unions and intersections; characteristics of relations; values
that classes give to their individuals, and what these are related to. What else an ontology states stays in the graph
for queries and OWL reasoners.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import pyoxigraph as ox

from skiros_py.errors import FileError, UnknownName
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, DATATYPES, parse_value
from skiros_py.world.names import LEARNED, SCENE, Names, local_name
from skiros_py.world.ontology.documents import Document
from skiros_py.world.terms import (
    DECLARES,
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

Node = ox.NamedNode | ox.BlankNode | ox.Literal | ox.Triple
"""What a statement may be about."""

_ABOUT_SCENES = (SCENE, LEARNED)
_MOST_MEMBERS = 10_000


class Statements:
    """Statements about everything but individuals of scenes.

    Subjects and predicates are named by CURIE; anonymous subjects by ``_:`` and their label.
    """

    def __init__(self, files: Sequence[Document], names: Names) -> None:
        self._files = files
        self._names = names
        self._about: dict[str, dict[str, list[Node]]] = {}
        predicates: dict[str, str] = {}
        for file in files:
            for triple in file.triples:
                subject = self._subject(triple.subject)
                if subject is not None:
                    iri = triple.predicate.value
                    predicate = predicates.get(iri) or predicates.setdefault(iri, names.name(iri))
                    self._about.setdefault(subject, {}).setdefault(predicate, []).append(triple.object)

    def subjects(self) -> Iterator[tuple[str, Mapping[str, Sequence[Node]]]]:
        """Yields every named subject with what is said of it, by predicate, in file order."""
        return ((name, said) for name, said in self._about.items() if not name.startswith("_:"))

    def about(self, subject: str) -> Mapping[str, Sequence[Node]]:
        """Returns what is said of a subject, by predicate."""
        return self._about.get(subject, {})

    def objects(self, subject: str, predicate: str) -> Sequence[Node]:
        """Returns the objects of a predicate of a subject, in file order."""
        return self.about(subject).get(predicate, ())

    def named(self, subject: str, predicate: str) -> list[str]:
        """Returns the CURIEs of those objects that have names."""
        return [self.key(node) for node in self.objects(subject, predicate) if isinstance(node, ox.NamedNode)]

    def key(self, node: ox.NamedNode | ox.BlankNode) -> str:
        """Returns the name under which a node is a subject here."""
        return self._names.name(node.value) if isinstance(node, ox.NamedNode) else f"_:{node.value}"

    def members(self, list_: Node) -> list[Node]:
        """Returns what an RDF list holds."""
        found: list[Node] = []
        while isinstance(list_, ox.BlankNode) and len(found) < _MOST_MEMBERS:
            cell = self.about(self.key(list_))
            found += cell.get("rdf:first", ())[:1]
            list_ = next(iter(cell.get("rdf:rest", ())), ox.Literal(""))
        return found

    def text(self, subject: str, predicate: str) -> str:
        """Returns a text that is said of a subject: of several languages English, else the first in order; or ""."""
        literals = [node for node in self.objects(subject, predicate) if isinstance(node, ox.Literal)]
        return english(literals).value if literals else ""

    def fault(self, subject: str, reason: str, at: str | None = None) -> FileError:
        """Makes the error for a fault in what is said of a subject, where it speaks of ``at`` (CURIE)."""
        iri, there = self._iri(subject), self._iri(at)
        return self._file(iri, there).fault(reason, iri, there)

    def undeclared(self, subject: str, reason: str, at: str) -> FileError:
        """Makes the error for the word ``at`` that no file declares: it may be in one that is imported but not here."""
        iri, there = self._iri(subject), self._iri(at)
        file = self._file(iri, there)
        absent = [f"<{name}>" for name in file.imports() if all(other.iri != name for other in self._files)]
        likely = f" It may be in {' or '.join(absent)}, imported here, which no file at hand is." if absent else ""
        return file.fault(reason + likely, iri, there)

    def _subject(self, node: ox.NamedNode | ox.BlankNode | ox.Triple) -> str | None:
        if isinstance(node, ox.Triple) or (isinstance(node, ox.NamedNode) and node.value.startswith(_ABOUT_SCENES)):
            return None
        return self.key(node)

    def _iri(self, name: str | None) -> str | None:
        if name is None or name.startswith("_:"):
            return None
        return self._names.iri(name) if name.partition(":")[0] in self._names.prefixes else name

    def _file(self, subject: str | None, term: str | None) -> Document:
        """The file that says it: the first that speaks of both, else the first that speaks of the subject."""

        def words(file: Document) -> Iterator[tuple[str, str | None]]:
            for t in file.triples:
                if isinstance(t.subject, ox.NamedNode) and t.subject.value == subject:
                    yield t.predicate.value, t.object.value if isinstance(t.object, ox.NamedNode) else None

        speaking = [file for file in self._files if next(words(file), None) is not None]
        both = (file for file in speaking if any(term in said for said in words(file)))
        return next(both, speaking[0] if speaking else self._files[0])


def english(literals: Sequence[ox.Literal]) -> ox.Literal:
    """Returns the literal without language or in English, else the first in order."""
    return min(literals, key=lambda literal: (literal.language not in (None, "en"), literal.value))


# ---------------------------------------------------------------- class expressions


_NUMBERS = {
    "owl:cardinality": (True, True),
    "owl:qualifiedCardinality": (True, True),
    "owl:minCardinality": (True, False),
    "owl:minQualifiedCardinality": (True, False),
    "owl:maxCardinality": (False, True),
    "owl:maxQualifiedCardinality": (False, True),
}
"""Whether each says the least, the most."""
_FILLERS = {"owl:someValuesFrom": True, "owl:allValuesFrom": True, "owl:hasValue": False}
"""Whether each names a class."""


def conjuncts(statements: Statements, expression: Node) -> Iterator[Node]:
    """Yields what all members of an expression are: itself, or the parts of an intersection, whatever the nesting."""
    nodes = reached([expression], lambda node: _members(statements, node, "owl:intersectionOf"))
    return (node for node in nodes if not _said(statements, node, "owl:intersectionOf"))


def end(statements: Statements, expressions: list[Node], known: Callable[[str], bool]) -> End:
    """Returns what several expressions together allow at an end of a relation.

    Args:
        statements: All statements.
        expressions: Domains or ranges: all must be met.
        known: Returns whether a name stands for a class that can be checked, or raises.
    """
    parts = (part for expression in expressions for part in conjuncts(statements, expression))
    groups = {_group(statements, part, known) for part in parts}
    return tuple(sorted(group for group in groups if group))


def cardinalities(statements: Statements, expression: Node) -> Iterator[Cardinality]:
    """Yields the numbers that a restriction states of a relation or property that has a name.

    Raises:
        ValueError: A number is none.
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
    """Yields what a restriction states of what its individuals are related to, as far as that has names."""
    if not isinstance(expression, ox.BlankNode):
        return
    node = statements.key(expression)
    for relation in statements.named(node, "owl:onProperty"):
        for predicate, is_class in _FILLERS.items():
            for name in statements.named(node, predicate):
                yield Filler(relation, name, is_class)


def _counted(statements: Statements, node: str) -> str | None:
    """The class or data type that is counted; "" for all, None if it has no name."""
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
    """The classes of which one is enough; none if that cannot be said by names, and so nothing is asked."""
    nodes = reached([node], lambda node: _members(statements, node, "owl:unionOf"))
    leaves = [node for node in nodes if not _said(statements, node, "owl:unionOf")]
    names = {statements.key(leaf) for leaf in leaves if isinstance(leaf, ox.NamedNode)}
    return tuple(sorted(names)) if len(names) == len(leaves) and all(map(known, sorted(names))) else ()


def _members(statements: Statements, node: Node, predicate: str) -> list[Node]:
    """What the lists hold that an anonymous node has by a predicate."""
    return [member for list_ in _said(statements, node, predicate) for member in statements.members(list_)]


def _said(statements: Statements, node: Node, predicate: str) -> list[Node]:
    """Objects of a predicate of an anonymous node."""
    return list(statements.objects(statements.key(node), predicate)) if isinstance(node, ox.BlankNode) else []


_FAMILIES = {
    "sk:placement": Family.PLACEMENT,
    "sk:structure": Family.STRUCTURE,
    "sk:computed": Family.COMPUTED,
}
_STANDARD = frozenset({"rdf", "rdfs", "owl", "xsd"})
_COMMENT = Property("rdfs:comment", "comment", "What people note about it.", (), "xsd:string")


@dataclass(frozen=True, slots=True)
class Declarations:
    """Everything that the files declare, by CURIE.

    Attributes:
        classes, relations, properties: The terms.
        class_values: What a class itself gives to its individuals: value by property, by class.
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
    anything (as ``dc:creator`` often is): it then says nothing to a world and is passed over.

    Raises:
        FileError: A term is used that no file declares, or a declaration says too little or too much.
    """
    reader = _Reader(Statements(files, names), names)
    properties = {term: reader.property(term) for term in reader.declared(Kind.PROPERTY)}
    properties["rdfs:comment"] = _COMMENT
    return Declarations(
        classes=reader.classes(),
        relations=reader.relations(),
        properties=properties,
        class_values={term: reader.class_values(term, properties) for term in reader.declared(Kind.CLASS)},
        individuals=reader.individuals(),
    )


class _Reader:
    """Statements of all files, and what can be made of them."""

    def __init__(self, statements: Statements, names: Names) -> None:
        self._statements = statements
        self._names = names
        self._declared: dict[Kind, dict[str, None]] = {kind: {} for kind in Kind}
        for term, said in statements.subjects():
            for type_ in self._types(said):
                if type_ in DECLARES:
                    self._declare(term, DECLARES[type_])
        self._terms = {term for terms in self._declared.values() for term in terms}
        self._vocabularies = {term.partition(":")[0] for term in self._terms} - _STANDARD
        self._equivalents = self._both_ways(Kind.CLASS, "owl:equivalentClass")
        self._inverses = self._both_ways(Kind.RELATION, "owl:inverseOf")

    def _declare(self, term: str, kind: Kind) -> None:
        if term.partition(":")[0] not in self._names.prefixes:
            raise self._statements.fault(term, f"the {kind} <{term}> needs a name after the last '#' or '/' of its IRI")
        self._declared[kind][term] = None

    def declared(self, kind: Kind) -> Mapping[str, None]:
        """Returns the terms of a kind, in file order."""
        return self._declared[kind]

    # ------------------------------------------------------------ classes

    def classes(self) -> dict[str, Class]:
        """Returns all classes."""
        found = {term: self._class(term) for term in self.declared(Kind.CLASS)}
        self._check_no_cycle({term: class_.parents for term, class_ in found.items()}, "rdfs:subClassOf")
        self._check_depth({term: (*c.parents, *c.equivalents) for term, c in found.items()}, "rdfs:subClassOf")
        return found

    def _class(self, term: str) -> Class:
        above = [
            part
            for node in (*self._objects(term, "rdfs:subClassOf"), *self._anonymous_equivalents(term))
            for part in conjuncts(self._statements, node)
        ]
        parents = self._references(term, above, Kind.CLASS)
        primary = self._references(term, self._objects(term, "sk:primaryParent"), Kind.CLASS)
        if not set(primary) <= set(parents):
            raise self._fault(term, f"sk:primaryParent of {term} is {primary[0]}, which is none of its superclasses")
        try:
            numbers = {number for part in above for number in cardinalities(self._statements, part)}
        except ValueError as error:
            raise self._fault(term, f"in a restriction of {term}: {error}", "rdfs:subClassOf") from None
        return Class(
            curie=term,
            label=self._label(term),
            comment=self._comment(term),
            parents=tuple(primary[:1] + [parent for parent in parents if parent not in primary[:1]]),
            equivalents=tuple(sorted(self._equivalents.get(term, ()))),
            cardinalities=tuple(sorted(numbers, key=repr)),
            fillers=tuple(sorted({f for part in above for f in fillers(self._statements, part)}, key=repr)),
        )

    def _anonymous_equivalents(self, term: str) -> list[Node]:
        return [node for node in self._objects(term, "owl:equivalentClass") if isinstance(node, ox.BlankNode)]

    def class_values(self, class_: str, properties: Mapping[str, Property]) -> dict[str, Value]:
        """Returns the values that a class itself gives, by property."""
        values: dict[str, Value] = {}
        for predicate, objects in self._statements.about(class_).items():
            if predicate not in self._terms and self._should_be_declared(predicate):
                known = [*self.declared(Kind.PROPERTY), *self.declared(Kind.ANNOTATION)]
                raise self._undeclared(class_, str(UnknownName("property", predicate, known)), predicate)
            if predicate in properties and predicate != "rdfs:comment":
                values[predicate] = self._class_value(class_, properties[predicate], objects)
        return values

    def _class_value(self, class_: str, property_: Property, objects: Sequence[Node]) -> Value:
        literals = {node for node in objects if isinstance(node, ox.Literal)}
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
            for term in self.declared(Kind.RELATION)
        }
        self._check_no_cycle(above, "rdfs:subPropertyOf")
        self._check_depth(above, "rdfs:subPropertyOf")
        return {term: self._relation(term, above) for term in above}

    def _relation(self, term: str, above: Mapping[str, tuple[str, ...]]) -> Relation:
        family = next((_FAMILIES[name] for name in closure(above, term) if name in _FAMILIES), Family.PLAIN)
        types = set(self._types(self._statements.about(term)))
        return Relation(
            curie=term,
            label=self._label(term),
            comment=self._comment(term),
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
        return Property(term, self._label(term), self._comment(term), self._end(term, "rdfs:domain"), range_, unit)

    def _data_range(self, term: str, node: Node) -> str:
        """A data type that values can be checked by; one that files define themselves stands for any literal."""
        if not isinstance(node, ox.NamedNode):
            return ANY_LITERAL
        name = self._statements.key(node)
        if name in DATATYPES:
            return name
        if name not in self.declared(Kind.DATATYPE):
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
        """Returns what is of a class and no term itself."""
        found: list[str] = []
        for name, said in self._statements.subjects():
            types = self._types(said)
            for type_ in types:
                if type_ not in self._terms and self._should_be_declared(type_):
                    unknown = UnknownName("class", type_, self.declared(Kind.CLASS))
                    raise self._undeclared(name, f"{name} is of an {unknown}", type_)
            if name not in self._terms and any(type_ in self.declared(Kind.CLASS) for type_ in types):
                found.append(name)
        return tuple(sorted(found))

    # ------------------------------------------------------------ pieces

    def _references(self, term: str, nodes: Sequence[Node], kind: Kind) -> list[str]:
        """Named terms among nodes, sorted."""
        names = {self._statements.key(node) for node in nodes if isinstance(node, ox.NamedNode)}
        return [name for name in sorted(names) if self._is_declared(term, name, kind)]

    def _is_declared(self, term: str, name: str, kind: Kind) -> bool:
        """Returns whether a name to which a term refers is of a kind; False for what OWL itself declares."""
        if name in self.declared(kind):
            return True
        if name.partition(":")[0] in _STANDARD:
            return False
        raise self._undeclared(term, f"{term} refers to {UnknownName(kind, name, self.declared(kind))}", name)

    def _both_ways(self, kind: Kind, predicate: str) -> dict[str, set[str]]:
        found: dict[str, set[str]] = {}
        for term in self.declared(kind):
            for other in self._references(term, self._objects(term, predicate), kind):
                if other == term:
                    continue
                found.setdefault(term, set()).add(other)
                found.setdefault(other, set()).add(term)
        return found

    def _should_be_declared(self, name: str) -> bool:
        return name.partition(":")[0] in self._vocabularies

    def _check_no_cycle(self, above: Mapping[str, tuple[str, ...]], predicate: str) -> None:
        found = cycle(above)
        if found:
            line = " -> ".join(found)
            raise self._fault(found[0], f"{found[0]} is above itself by {predicate}: {line}", found[1])

    def _check_depth(self, above: Mapping[str, tuple[str, ...]], predicate: str) -> None:
        deep = too_deep(above)
        if deep is not None:
            raise self._fault(deep, f"{deep} has more than {MOST_ABOVE} terms above it by {predicate}", predicate)

    def _types(self, said: Mapping[str, Sequence[Node]]) -> list[str]:
        return [self._names.name(node.value) for node in said.get("rdf:type", ()) if isinstance(node, ox.NamedNode)]

    def _objects(self, term: str, predicate: str) -> list[Node]:
        return list(self._statements.objects(term, predicate))

    def _label(self, term: str) -> str:
        return self._statements.text(term, "rdfs:label") or local_name(term)

    def _comment(self, term: str) -> str:
        return self._statements.text(term, "rdfs:comment")

    def _undeclared(self, term: str, reason: str, at: str) -> FileError:
        return self._statements.undeclared(term, reason, at)

    def _fault(self, term: str, reason: str, at: str | None = None) -> FileError:
        return self._statements.fault(term, reason, at)
