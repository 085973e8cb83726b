"""What all ontology files together say, by subject and predicate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import LEARNED, SCENE, Names
from skiros_py.world.ontology.documents import Document
from skiros_py.world.terms import Cardinality, End, Filler, reached

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
