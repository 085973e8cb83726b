"""The statements of ontology files, indexed; words are named by CURIE, and each statement knows its file."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.element import is_abstract, is_learned
from skiros_py.world.names import Names
from skiros_py.world.ontology.documents import Document, common_names
from skiros_py.world.ontology.imports import where_to_put
from skiros_py.world.terms import DECLARES, Kind, reached

Node = ox.NamedNode | ox.BlankNode | ox.Literal | ox.Triple
"""What a statement may be about."""

STANDARD = ("rdf", "rdfs", "owl", "xsd")
"""Prefixes of the vocabularies that OWL is written in."""


class Statement(NamedTuple):
    """One triple and its file.

    Attributes:
        document: The file.
        triple: The triple.
        subject: Name of the subject; None if it is anonymous.
        predicate: Name of the predicate.
        object: Name of the object; None if it is anonymous or a literal.
    """

    document: Document
    triple: ox.Triple
    subject: str | None
    predicate: str
    object: str | None


class Statements:
    """All statements of some files, in file order.

    Subjects and predicates are named by CURIE; anonymous subjects by ``_:`` and their label.

    Attributes:
        documents: The files.
        names: Their prefixes.
        all: The statements.
    """

    def __init__(self, documents: Sequence[Document], names: Names) -> None:
        self.documents = documents
        self.names = names
        known: dict[str, str] = {}

        def name(node: Node) -> str | None:
            if not isinstance(node, ox.NamedNode):
                return None
            iri = node.value
            return known.get(iri) or known.setdefault(iri, names.name(iri))

        self.all = tuple(
            Statement(document, t, name(t.subject), name(t.predicate) or "", name(t.object))
            for document in documents
            for t in document.triples
        )

    @cached_property
    def _by_subject(self) -> Mapping[str, Mapping[str, Sequence[Statement]]]:
        found: dict[str, dict[str, list[Statement]]] = {}
        for statement in self.all:
            key = statement.subject or self.key(statement.triple.subject)
            found.setdefault(key, {}).setdefault(statement.predicate, []).append(statement)
        return found

    @cached_property
    def _by_predicate(self) -> Mapping[str, Sequence[Statement]]:
        found: dict[str, list[Statement]] = defaultdict(list)
        for statement in self.all:
            found[statement.predicate].append(statement)
        return found

    @cached_property
    def declared(self) -> Mapping[Kind, Mapping[str, Document]]:
        """The terms of each kind, in file order, with the file that declares each first."""
        found: dict[Kind, dict[str, Document]] = {kind: {} for kind in Kind}
        for statement in self.of("rdf:type"):
            kind = DECLARES.get(statement.object or "")
            if kind is not None and statement.subject is not None and _may_be_term(statement.subject):
                found[kind].setdefault(statement.subject, statement.document)
        return found

    def of(self, predicate: str) -> Sequence[Statement]:
        """Returns the statements with a predicate."""
        return self._by_predicate.get(predicate, ())

    def about(self, subject: str) -> Mapping[str, Sequence[Statement]]:
        """Returns the statements about a subject, by predicate."""
        return self._by_subject.get(subject, {})

    def subjects(self) -> Iterator[tuple[str, Mapping[str, Sequence[Statement]]]]:
        """Yields every named subject, except individuals of scenes, with the statements about it by predicate."""
        return ((name, about) for name, about in self._by_subject.items() if _may_be_term(name))

    def objects(self, subject: str, predicate: str) -> list[Node]:
        """Returns the objects of a predicate of a subject."""
        return [statement.triple.object for statement in self.about(subject).get(predicate, ())]

    def named(self, subject: str, predicate: str) -> list[str]:
        """Returns the names of those objects of a predicate of a subject that have one."""
        return [s.object for s in self.about(subject).get(predicate, ()) if s.object is not None]

    def pairs(self, predicate: str) -> Iterator[tuple[str, str]]:
        """Yields subject and object of the statements with a predicate where both have names."""
        return ((s.subject, s.object) for s in self.of(predicate) if s.subject is not None and s.object is not None)

    def key(self, node: object) -> str:
        """Returns the name under which a node is a subject here."""
        if isinstance(node, ox.NamedNode):
            return self.names.name(node.value)
        return f"_:{node.value}" if isinstance(node, ox.BlankNode) else ""

    def parts(self, node: Node, predicate: str) -> list[Node]:
        """Returns the members of the lists that an anonymous node has by a predicate."""
        lists = self.objects(self.key(node), predicate) if isinstance(node, ox.BlankNode) else ()
        return [member for list_ in lists for member in self.members(list_)]

    def members(self, list_: Node) -> list[Node]:
        """Returns the members of an RDF list."""
        cells = reached([list_], lambda cell: self.objects(self.key(cell), "rdf:rest")[:1])
        return [first for cell in cells for first in self.objects(self.key(cell), "rdf:first")[:1]]

    def conjuncts(self, expression: Node) -> Iterator[Node]:
        """Yields what all members of a class expression are: itself, or the parts of an intersection, also nested."""
        nodes = reached([expression], lambda node: self.parts(node, "owl:intersectionOf"))
        return (node for node in nodes if not self.is_expression(node, "owl:intersectionOf"))

    def is_expression(self, node: Node, predicate: str) -> bool:
        """Returns whether an anonymous node is described by a predicate."""
        return isinstance(node, ox.BlankNode) and predicate in self.about(self.key(node))

    def text(self, subject: str, predicate: str) -> str:
        """Returns the text of a predicate: of several languages English, else the first in order; or ""."""
        literals = self._literals(subject, predicate)
        return english(literals).value if literals else ""

    def translations(self, subject: str, predicate: str) -> dict[str, str]:
        """Returns the texts of a predicate in languages other than English, by language tag in lower case."""
        literals = sorted(self._literals(subject, predicate), key=lambda literal: literal.value, reverse=True)
        return {literal.language: literal.value for literal in literals if literal.language not in (None, "en")}

    def _literals(self, subject: str, predicate: str) -> list[ox.Literal]:
        return [node for node in self.objects(subject, predicate) if isinstance(node, ox.Literal)]

    def kinds(self, term: str) -> list[Kind]:
        """Returns all that a name is declared as."""
        return [kind for kind, terms in self.declared.items() if term in terms]

    @cached_property
    def vocabularies(self) -> frozenset[str]:
        """Prefixes (without one, namespaces) of which some file declares something."""
        return frozenset(vocabulary(term) for terms in self.declared.values() for term in terms)

    @cached_property
    def absent(self) -> Mapping[str, Document]:
        """The imported ontologies that none of the files is, by IRI, each with the first file that imports it."""
        at_hand = {iri for document in self.documents for iri in document.iris()}
        return {iri: one for one in reversed(self.documents) for iri in one.imports() if iri not in at_hand}

    # ------------------------------------------------------------ faults

    def fault(self, subject: str, reason: str, *terms: str) -> FileError:
        """Makes the error for a fault in the statements about a subject.

        Args:
            subject: The subject.
            reason: What is wrong.
            *terms: The predicate or object, or both, of the statement in question; the error is located at the last.
        """
        at = terms[-1] if terms else None
        return self._file(subject, *terms).fault(reason, self.iri(subject), self.iri(at))

    def fault_in(self, statement: Statement, reason: str, at: str | None = None) -> FileError:
        """Makes the error for a fault in a statement, at a name in it (by default, its predicate)."""
        return statement.document.fault(reason, self.iri(statement.subject or at), self.iri(at or statement.predicate))

    def undeclared(self, subject: str, reason: str, at: str) -> FileError:
        """Makes the error for a name that no file declares."""
        likely = f" It may be in an ontology that is imported and missing: {where_to_put(self.absent)}"
        return self.fault(subject, reason + likely * bool(self.absent), at)

    def iri(self, name: str | None) -> str | None:
        """Returns the IRI of a name; None for an anonymous node."""
        if name is None or name.startswith("_:"):
            return None
        prefix, colon, _ = name.partition(":")
        return self.names.iri(name) if not colon or prefix in self.names.prefixes else name

    def _file(self, subject: str, *terms: str) -> Document:
        """The file with a statement about the subject that contains the names, else the one that says what it is."""
        about = [statement for statement in self.all if statement.subject == subject]
        about.sort(key=lambda statement: statement.predicate != "rdf:type")  # other files may only translate it
        exact = [s for s in about if {s.predicate, s.object}.issuperset(terms)]
        return next((statement.document for statement in (*exact, *about)), self.documents[0])


def english(literals: Sequence[ox.Literal]) -> ox.Literal:
    """Returns the literal without language or in English, else one in a variety of English, else the first in order."""

    def rank(literal: ox.Literal) -> tuple[bool, bool, str]:
        language = literal.language or "en"
        return language != "en", not language.startswith("en-"), literal.value

    return min(literals, key=rank)


def vocabulary(name: str) -> str:
    """Returns the prefix of a CURIE; of an IRI without a prefix, its namespace."""
    prefix, _, local = name.partition(":")
    return name[: max(name.rfind("#"), name.rfind("/")) + 1] if local.startswith("//") else prefix


def is_standard(name: str) -> bool:
    """Returns True for anything in a namespace of RDF, RDFS, OWL or XML Schema."""
    return name.partition(":")[0] in STANDARD


def _may_be_term(name: str) -> bool:
    return is_abstract(name) and not is_learned(name) and not name.startswith("_:")


# ---------------------------------------------------------------- inventory


_COUNTED = {"classes": Kind.CLASS, "relations": Kind.RELATION, "properties": Kind.PROPERTY}


@dataclass(frozen=True, slots=True)
class Inventory:
    """The content of one file.

    Attributes:
        path: The file.
        iri: IRI of its ontology.
        counts: Number of terms and individuals that it declares, and of its statements.
    """

    path: Path
    iri: str
    counts: Mapping[str, int]


def inventory(document: Document) -> Inventory:
    """Counts the declarations of a file; individuals are named things of a class that is not of the standard."""
    statements = Statements([document], common_names([document]))
    counts = {name: len(statements.declared[kind]) for name, kind in _COUNTED.items()}
    individuals = {one for one, type_ in statements.pairs("rdf:type") if not is_standard(type_)}
    counts |= {"individuals": len(individuals), "statements": len(statements.all)}
    return Inventory(document.path, document.iri, counts)
