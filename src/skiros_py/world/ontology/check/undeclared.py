"""Checks that each used term is declared, and as the kind as which it is used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pyoxigraph as ox
import rdflib

from skiros_py.errors import UnknownName
from skiros_py.world.names import split_iri
from skiros_py.world.ontology.check.material import Finding, FindingKind, Material, Severity, finding_of
from skiros_py.world.ontology.imports import where_to_put
from skiros_py.world.ontology.statements import Statement, is_standard, vocabulary
from skiros_py.world.terms import Kind

_STANDARD = {"rdf": rdflib.RDF, "rdfs": rdflib.RDFS, "owl": rdflib.OWL, "xsd": rdflib.XSD}
_CLASSES = (Kind.CLASS,)
_RELATIONS = (Kind.RELATION,)
_PROPERTIES = (Kind.RELATION, Kind.PROPERTY)
_ANY_PROPERTY = (*_PROPERTIES, Kind.ANNOTATION)
_FILLERS = (Kind.CLASS, Kind.DATATYPE)

_SUBJECTS: Mapping[str, tuple[Kind, ...]] = {
    **dict.fromkeys(("rdfs:domain", "rdfs:range", "rdfs:subPropertyOf"), _ANY_PROPERTY),
    "owl:equivalentProperty": _PROPERTIES,
    "owl:propertyDisjointWith": _PROPERTIES,
    "owl:inverseOf": _RELATIONS,
    "owl:propertyChainAxiom": _RELATIONS,
    "rdfs:subClassOf": _CLASSES,
    "owl:equivalentClass": _FILLERS,
    "owl:disjointWith": _CLASSES,
    "owl:disjointUnionOf": _CLASSES,
    "owl:hasKey": _CLASSES,
}
_OBJECTS: Mapping[str, tuple[Kind, ...]] = {
    **{word: kinds for word, kinds in _SUBJECTS.items() if word not in ("rdfs:domain", "rdfs:range")},
    "owl:complementOf": _CLASSES,
    "owl:onClass": _CLASSES,
    "owl:someValuesFrom": _FILLERS,
    "owl:allValuesFrom": _FILLERS,
    "owl:onDataRange": (Kind.DATATYPE,),
    "owl:onDatatype": (Kind.DATATYPE,),
    "owl:onProperty": _PROPERTIES,
    "owl:assertionProperty": _PROPERTIES,
    "owl:unionOf": _FILLERS,
    "owl:intersectionOf": _FILLERS,
}
"""The kinds required of objects, or members of lists, of these predicates; ends of relations are checked elsewhere."""

_MEMBERS: Mapping[str, tuple[Kind, ...]] = {
    "owl:AllDisjointClasses": _CLASSES,
    "owl:AllDisjointProperties": _PROPERTIES,
}


def _is_standard_word(name: str) -> bool:
    """Returns True when the standard of its namespace defines the word."""
    prefix, _, word = name.partition(":")
    return prefix in _STANDARD and (word in _STANDARD[prefix] or (prefix == "rdf" and word.startswith("_")))


def undeclared_terms(material: Material) -> Iterator[Finding]:
    """Finds terms that no file declares, or that are used as another kind."""
    members = {s.triple.subject: kinds for s in material.of("rdf:type") if (kinds := _MEMBERS.get(s.object or ""))}
    for statement in material.all:
        word = statement.predicate
        yield from _predicate(material, statement)
        yield from _literal(material, statement)
        if word == "rdf:type":
            yield from _type(material, statement)
        if word in _SUBJECTS:
            yield from _used(material, statement, statement.subject, _SUBJECTS[word])
        wanted = members.get(statement.triple.subject) if word == "owl:members" else _OBJECTS.get(word)
        if wanted is not None:
            yield from _objects(material, statement, wanted)
    yield from _foreign_words(material)
    yield from _two_kinds(material)


def _predicate(material: Material, statement: Statement) -> Iterator[Finding]:
    word = statement.predicate
    if is_standard(word):
        if not _is_standard_word(word):
            yield _no_such_word(material, statement, word)
    elif not any(word in material.declared[kind] for kind in _ANY_PROPERTY) and not _is_foreign(material, word):
        yield from _used(material, statement, word, _ANY_PROPERTY)


def _literal(material: Material, statement: Statement) -> Iterator[Finding]:
    literal = statement.triple.object
    if isinstance(literal, ox.Literal):
        yield from _used(material, statement, material.key(literal.datatype), (Kind.DATATYPE,))


def _type(material: Material, statement: Statement) -> Iterator[Finding]:
    type_ = statement.object
    if isinstance(statement.triple.object, ox.Literal):
        yield material.finding(statement, FindingKind.WRONG_KIND, statement.subject or "", "a type must be a class")
    elif type_ is not None and not _is_standard_word(type_) and not _is_foreign(material, type_):
        yield from _used(material, statement, type_, _CLASSES)


def _objects(material: Material, statement: Statement, kinds: tuple[Kind, ...]) -> Iterator[Finding]:
    node = statement.triple.object
    if isinstance(node, ox.Literal):
        text = f"{statement.predicate} needs a {kinds[0]}, got the text '{node.value[:60]}'"
        yield material.finding(statement, FindingKind.WRONG_KIND, statement.subject or statement.predicate, text)
    for member in (node, *material.members(node)):
        if isinstance(member, ox.NamedNode):
            yield from _used(material, statement, material.key(member), kinds)


def _used(material: Material, statement: Statement, name: str | None, kinds: tuple[Kind, ...]) -> Iterator[Finding]:
    """Yields a finding unless the term is anonymous or declared as one of the kinds."""
    if name is None or any(name in material.declared[kind] for kind in kinds):
        return
    if is_standard(name):
        if not _is_standard_word(name):
            yield _no_such_word(material, statement, name)
        return
    others = material.kinds(name)
    if others:
        text = f"{name} is a {others[0]}, not a {' or '.join(kinds)}"
        yield material.finding(statement, FindingKind.WRONG_KIND, name, text, name)
        return
    if not material.is_sought(name):
        known = [term for kind in kinds for term in material.declared[kind]]
        text = str(UnknownName(" or ".join(kinds), name, known))
        yield material.finding(statement, FindingKind.UNDECLARED, name, text, name)


def _is_foreign(material: Material, name: str) -> bool:
    """True for a word from a vocabulary of which no file declares anything, such as ``dc:creator``."""
    return not is_standard(name) and vocabulary(name) not in material.vocabularies


def _foreign_words(material: Material) -> Iterator[Finding]:
    """Notes each vocabulary that is used and of which no file declares anything: its prefix may be misspelt."""
    first: dict[str, tuple[Statement, str]] = {}
    for statement in material.all:
        type_ = statement.object if statement.predicate == "rdf:type" else None
        for name in (statement.predicate, type_):
            if name is not None and _is_foreign(material, name):
                first.setdefault(vocabulary(name), (statement, name))
    for statement, name in first.values():
        namespace, _ = split_iri(material.iri(name) or "")
        text = f"no file declares anything of <{namespace}>: words such as {name} are ignored"
        yield material.finding(statement, FindingKind.UNDECLARED, name, text, name, severity=Severity.WARNING)


def _no_such_word(material: Material, statement: Statement, name: str) -> Finding:
    text = f"{name} is no word of the standard its prefix stands for (is it misspelt? capitals count)"
    return material.finding(statement, FindingKind.UNDECLARED, name, text, name)


def absent_imports(material: Material) -> Iterator[Finding]:
    """Says once which imports are missing: an error if terms are, too, else a warning; to be asked last."""
    for iri, document in list(material.absent.items())[:1]:
        terms = sorted(material.sought)
        shown = ", ".join([*terms[:_MOST_SHOWN], "…"][: len(terms)])
        lacks = f"; undeclared without them ({len(terms)}): {shown}" if terms else ""
        fault = document.fault(f"imports are missing: {where_to_put(material.absent)}{lacks}", document.iri, iri)
        severity = Severity.ERROR if terms else Severity.WARNING
        yield finding_of(fault, FindingKind.IMPORT, document.iri, severity=severity)


_MOST_SHOWN = 10


def _two_kinds(material: Material) -> Iterator[Finding]:
    """Finds terms of two kinds; OWL tools declare annotation properties a second time, which does no harm."""
    kinds = [kind for kind in Kind if kind is not Kind.ANNOTATION]
    for term in sorted({term for kind in kinds for term in material.declared[kind]}):
        found = [kind for kind in kinds if term in material.declared[kind]]
        if len(found) > 1:
            text = f"{term} is declared as {' and as '.join(found)}"
            fault = material.declared[found[-1]][term].fault(text, material.iri(term))
            yield finding_of(fault, FindingKind.WRONG_KIND, term)
