"""Reads what ontology files declare, and refuses what would be misunderstood later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pyoxigraph as ox

from skiros_py.errors import FileError, UnknownName
from skiros_py.world.element import Value
from skiros_py.world.literals import DATATYPES, parse_value
from skiros_py.world.names import SCENE, STANDARD_PREFIXES, Names, local_name
from skiros_py.world.ontology.documents import Document
from skiros_py.world.terms import Class, Family, PlaceEnd, Property, Relation

__all__ = ["Declarations", "common_names", "read_declarations"]

_CLASS, _RELATION, _PROPERTY, _ANNOTATION = (
    "owl:Class",
    "owl:ObjectProperty",
    "owl:DatatypeProperty",
    "owl:AnnotationProperty",
)
_FAMILIES = {
    "sk:placement": Family.PLACEMENT,
    "sk:structure": Family.STRUCTURE,
    "sk:computed": Family.COMPUTED,
}
_STANDARD = frozenset(STANDARD_PREFIXES) - {"sk", "scene"}
_THING = "owl:Thing"


@dataclass(frozen=True, slots=True)
class Declarations:
    """Everything that the files declare, by CURIE.

    Attributes:
        classes, relations, properties: The terms.
        class_values: What a class gives to its individuals: value by property, by class.
    """

    classes: Mapping[str, Class]
    relations: Mapping[str, Relation]
    properties: Mapping[str, Property]
    class_values: Mapping[str, Mapping[str, Value]]


def common_names(files: Sequence[Document]) -> Names:
    """Returns the prefix table of all files together; the empty prefix stays private to its file.

    Raises:
        FileError: A prefix stands for two IRIs.
    """
    prefixes = dict(STANDARD_PREFIXES)
    for file in files:
        for prefix, iri in file.prefixes.items():
            if prefix and prefixes.setdefault(prefix, iri) != iri:
                raise FileError(
                    file.path, f"prefix '{prefix}:' stands for <{iri}> here and for <{prefixes[prefix]}> elsewhere"
                )
    return Names(prefixes)


def read_declarations(files: Sequence[Document], names: Names) -> Declarations:
    """Reads the terms of all files; a term may use those of any other file.

    Raises:
        FileError: A term is used that no file declares, or a declaration says too little or too much.
    """
    reader = _Reader(names)
    for file in files:
        reader.take(file)
    return reader.declarations()


def _group(name: str | None) -> tuple[tuple[str, ...], ...]:
    return () if name is None else ((name,),)


class _Reader:
    """Statements grouped by subject, and what can be made of them."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._about: dict[str, dict[str, list[ox.Triple]]] = {}
        self._file: dict[str, Document] = {}
        self._known: dict[str, dict[str, None]] = {kind: {} for kind in (_CLASS, _RELATION, _PROPERTY, _ANNOTATION)}

    def take(self, file: Document) -> None:
        for triple in file.triples:
            if isinstance(triple.subject, ox.NamedNode) and not triple.subject.value.startswith(SCENE):
                self._take_triple(file, triple, triple.subject.value)

    def _take_triple(self, file: Document, triple: ox.Triple, subject: str) -> None:
        term = self._names.name(subject)
        predicate = self._names.name(triple.predicate.value)
        self._about.setdefault(term, {}).setdefault(predicate, []).append(triple)
        if predicate == "rdf:type" and isinstance(triple.object, ox.NamedNode):
            kind = self._names.name(triple.object.value)
            if kind in self._known:
                if term == subject:
                    raise file.fault(f"declare an @prefix for the namespace of <{subject}>", subject)
                self._known[kind][term] = None
                self._file[term] = file
        self._file.setdefault(term, file)

    def declarations(self) -> Declarations:
        properties = {term: self._property(term) for term in self._known[_PROPERTY]}
        properties["rdfs:comment"] = Property(
            "rdfs:comment", "comment", "What people note about it.", (), "xsd:string"
        )
        return Declarations(
            classes={term: self._class(term) for term in self._known[_CLASS]},
            relations={term: self._relation(term) for term in self._known[_RELATION]},
            properties=properties,
            class_values={term: self._class_values(term, properties) for term in self._known[_CLASS]},
        )

    # ------------------------------------------------------------ the three kinds of terms

    def _class(self, term: str) -> Class:
        self._line_to_top(term, "rdfs:subClassOf", _CLASS)
        parents = self._references(term, "rdfs:subClassOf", _CLASS)
        primary = self._references(term, "sk:primaryParent", _CLASS)
        if not set(primary) <= set(parents):
            raise self._fault(term, f"sk:primaryParent of {term} is {primary[0]}, which is none of its superclasses")
        ordered = primary[:1] + [parent for parent in parents if parent not in primary[:1]]
        return Class(term, self._label(term), self._text(term, "rdfs:comment"), tuple(ordered))

    def _relation(self, term: str) -> Relation:
        line = self._line_to_top(term, "rdfs:subPropertyOf", _RELATION)
        family = next((_FAMILIES[above] for above in line if above in _FAMILIES), Family.PLAIN)
        types = set(self._iris(term, "rdf:type"))
        return Relation(
            curie=term,
            label=self._label(term),
            comment=self._text(term, "rdfs:comment"),
            parents=tuple(self._references(term, "rdfs:subPropertyOf", _RELATION)),
            domains=_group(self._end(term, "rdfs:domain")),
            ranges=_group(self._end(term, "rdfs:range")),
            family=family,
            place_end=self._place_end(term) if family is Family.PLACEMENT else None,
            functional="owl:FunctionalProperty" in types,
        )

    def _property(self, term: str) -> Property:
        ranges = self._iris(term, "rdfs:range")
        if len(ranges) != 1 or ranges[0] not in DATATYPES:
            raise self._fault(
                term, f"{term} needs one rdfs:range, one of {', '.join(DATATYPES)}; got {', '.join(ranges) or 'none'}"
            )
        comment = self._text(term, "rdfs:comment")
        return Property(term, self._label(term), comment, _group(self._end(term, "rdfs:domain")), ranges[0])

    def _class_values(self, class_: str, properties: Mapping[str, Property]) -> dict[str, Value]:
        values: dict[str, Value] = {}
        for predicate, triples in self._about[class_].items():
            self._check_predicate(class_, predicate)
            if predicate in properties and predicate != "rdfs:comment":
                values[predicate] = self._class_value(class_, properties[predicate], triples)
        return values

    def _class_value(self, class_: str, property_: Property, triples: list[ox.Triple]) -> Value:
        predicate = triples[0].predicate.value
        literals = {t.object for t in triples if isinstance(t.object, ox.Literal)}
        if len(literals) != 1:
            raise self._fault(class_, f"{class_} needs one value of {property_.curie}, got {len(literals)}", predicate)
        literal = literals.pop()
        try:
            return parse_value(literal.value, self._names.name(literal.datatype.value), property_.range)
        except ValueError as error:
            raise self._fault(class_, f"{property_.curie} of {class_} {error}", predicate) from None

    # ------------------------------------------------------------ pieces

    def _references(self, term: str, predicate: str, kind: str) -> list[str]:
        """Named terms referred to, sorted; anonymous OWL classes are for OWL reasoners and passed over."""
        found = sorted(set(self._iris(term, predicate)) - {_THING, "owl:topObjectProperty"})
        for name in found:
            if name not in self._known[kind]:
                raise self._undeclared(term, name, kind, predicate)
        return found

    def _end(self, term: str, predicate: str) -> str | None:
        triples = self._statements(term, predicate)
        if len(triples) > 1 or any(not isinstance(t.object, ox.NamedNode) for t in triples):
            raise self._fault(term, f"{predicate} of {term} must be one named class (take a common superclass)")
        if predicate == "rdfs:range" and term in self._known[_PROPERTY]:
            return None
        named = self._references(term, predicate, _CLASS)
        return named[0] if named else None

    def _place_end(self, term: str) -> PlaceEnd:
        end = self._text(term, "sk:placeEnd")
        if end == "object":
            return "object"
        if end == "subject":
            return "subject"
        raise self._fault(term, f'{term} is a placement and needs sk:placeEnd "object" or "subject", got \'{end}\'')

    def _line_to_top(self, term: str, predicate: str, kind: str) -> list[str]:
        """The term and all above it; refuses a term that is above itself."""
        line = [term]
        for above in line:
            for parent in self._references(above, predicate, kind):
                if parent == term:
                    raise self._fault(term, f"{term} is above itself by {predicate}")
                if parent not in line:
                    line.append(parent)
        return line

    def _check_predicate(self, class_: str, predicate: str) -> None:
        declared = {term: None for terms in self._known.values() for term in terms}
        if predicate.partition(":")[0] not in _STANDARD and predicate not in declared:
            unknown = UnknownName("property", predicate, [*self._known[_PROPERTY], *self._known[_ANNOTATION]])
            raise self._fault(class_, str(unknown), self._about[class_][predicate][0].predicate.value)

    def _statements(self, term: str, predicate: str) -> list[ox.Triple]:
        return self._about[term].get(predicate, [])

    def _iris(self, term: str, predicate: str) -> list[str]:
        triples = self._statements(term, predicate)
        return [self._names.name(t.object.value) for t in triples if isinstance(t.object, ox.NamedNode)]

    def _text(self, term: str, predicate: str) -> str:
        literals = [t.object for t in self._statements(term, predicate) if isinstance(t.object, ox.Literal)]
        # Of several languages English is shown, else the first in order.
        chosen = sorted(literals, key=lambda literal: (literal.language not in (None, "en"), literal.value))
        return chosen[0].value if chosen else ""

    def _label(self, term: str) -> str:
        return self._text(term, "rdfs:label") or local_name(term)

    def _undeclared(self, term: str, name: str, kind: str, predicate: str) -> FileError:
        unknown = UnknownName("class" if kind == _CLASS else "relation", name, self._known[kind])
        return self._fault(term, f"{term} {predicate}: {unknown}", self._names.iri(name) if ":" in name else name)

    def _fault(self, term: str, reason: str, at: str | None = None) -> FileError:
        return self._file[term].fault(reason, self._names.iri(term), at)
