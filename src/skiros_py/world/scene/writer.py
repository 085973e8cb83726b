"""A world's state as the text of a Turtle file: one statement a line, in an order that depends on content alone."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import pyoxigraph as ox

from skiros_py.world.element import Element, Value, is_abstract, is_learned
from skiros_py.world.index import Index
from skiros_py.world.literals import format_value, literal_type
from skiros_py.world.names import LEARNED_GRAPH, SCENE, SCENE_GRAPH, STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import ELEMENT, GOAL, LABEL, POSE, POSE_FRAME
from skiros_py.world.vocabulary import SCENE as SCENE_CLASS

_SAFE = re.compile(r"[A-Za-z][A-Za-z0-9_-]*:[A-Za-z0-9_][A-Za-z0-9_-]*")
_BARE = {
    "xsd:boolean": re.compile("true|false"),
    "xsd:integer": re.compile(r"[+-]?[0-9]+"),
    "xsd:decimal": re.compile(r"[+-]?[0-9]*\.[0-9]+"),
}
_FIRST = {LABEL: 0, POSE: 3, POSE_FRAME: 4}
_FAMILIES = {Family.PLACEMENT: 1, Family.STRUCTURE: 2}
_OTHERS = 5


def scene_turtle(index: Index) -> str:
    """Returns the scene of a state as a file, with its goals."""
    writer = TurtleWriter(index)
    goals = [(GOAL, writer.literal(GOAL, goal)) for goal in index.goals]
    this = writer.paragraph("this", SCENE_CLASS, goals)
    return writer.file(SCENE_GRAPH, [this, *writer.elements(index.instances(ELEMENT))])


_MANY = 1000
"""Number of elements above which iterating over all statements is faster than looking up those of each."""


class TurtleWriter:
    """Writes elements of a state as paragraphs of Turtle, and collects the words that they use."""

    def __init__(self, index: Index) -> None:
        self._index = index
        self._ontology = index.ontology
        self._names = index.ontology.names
        self._tokens: dict[str, str] = {}

    def file(self, graph: str, paragraphs: Iterable[str]) -> str:
        """Returns the whole file.

        Args:
            graph: IRI of its graph and of the file.
            paragraphs: The paragraphs about individuals, whose IRIs begin with that.
        """
        body = list(paragraphs)
        imports = [("owl:imports", f"<{other}>") for other in _declaring(self._ontology, self._used())]
        header = self._block(f"<{graph}>", self._token("owl:Ontology"), imports)
        used = {token.partition(":")[0] for token in self._tokens.values() if not token.startswith("<")}
        used.add("learned" if graph == LEARNED_GRAPH else "scene")
        prefixes = [f"@prefix {name}: <{self._names.prefixes[name]}> .\n" for name in sorted(used)]
        return "\n".join(["".join(prefixes), header, *body])

    def elements(self, ids: Iterable[str]) -> Iterator[str]:
        """Yields a paragraph for each element."""
        names = list(ids)
        related: dict[str, list[tuple[str, str]]] = {}
        for subject, relation, object_ in self._statements(names):
            related.setdefault(subject, []).append((relation, self._token(object_)))
        for name in names:
            element = self._index.element(name)
            yield self.paragraph(name, element.type, [*self._values(element), *related.get(name, ())])

    def paragraph(self, name: str, class_: str, statements: Iterable[tuple[str, str]]) -> str:
        """Returns the paragraph of one individual, given (predicate, object as written)."""
        return self._block(self._token(name), self._token(class_), statements)

    def literal(self, property_: str, value: Value) -> str:
        """Returns the text of a value."""
        range_ = "xsd:string" if property_ == LABEL else self._ontology.properties[property_].range
        text, type_ = format_value(value), literal_type(value, range_)
        if type_ in _BARE and _BARE[type_].fullmatch(text):
            return text
        # JSON is easier to read without a backslash before each quote.
        plain = '"' in text and "'" not in text and "\\" not in text and text.isprintable()
        quoted = f"'{text}'" if plain else str(ox.Literal(text))
        return quoted if type_ == "xsd:string" else f"{quoted}^^{self._token(type_)}"

    def _statements(self, names: list[str]) -> Iterable[tuple[str, str, str]]:
        """The statements about the elements, possibly also about others: for many, iterating over all is faster."""
        if len(names) > _MANY:
            return self._index.statements()
        return (said for name in names for said in self._index.statements_about(name) if said[0] == name)

    def _values(self, element: Element) -> Iterator[tuple[str, str]]:
        yield LABEL, self.literal(LABEL, element.label)
        for property_, value in element.properties.items():
            yield property_, self.literal(property_, value)

    def _block(self, subject: str, class_: str, statements: Iterable[tuple[str, str]]) -> str:
        """Ends every line alike, so that adding or removing a line changes no other."""
        lines = [f"    {self._token(p)} {said} ;\n" for p, said in sorted(statements, key=self._key)]
        return f"{subject} a {class_} ;\n{''.join(lines)}    .\n"

    def _key(self, statement: tuple[str, str]) -> tuple[int, str, str]:
        """The most important first: label, placement, parts."""
        predicate, said = statement
        relation = self._ontology.relations.get(predicate)
        family = _OTHERS if relation is None else _FAMILIES.get(relation.family, _OTHERS)
        return _FIRST.get(predicate, family), predicate, said

    def _token(self, name: str) -> str:
        if not is_abstract(name):
            return f"scene:{name}"
        if is_learned(name):
            return name
        return self._tokens.get(name) or self._tokens.setdefault(name, self._spelt(name))

    def _spelt(self, name: str) -> str:
        return name if _SAFE.fullmatch(name) else f"<{self._names.iri(name)}>"

    def _used(self) -> set[str]:
        return {self._names.iri(name) for name in self._tokens}


def _declaring(ontology: Ontology, terms: set[str]) -> list[str]:
    """The IRIs of the files that declare any of the terms, sorted.

    Files with scene individuals (robots) are left out: their individuals are part of the written scene.
    """
    return sorted(
        file.iri
        for file in ontology.sources
        if any(_declares(triple, terms) for triple in file.triples)
        and not any(isinstance(t.subject, ox.NamedNode) and t.subject.value.startswith(SCENE) for t in file.triples)
    )


def _declares(triple: ox.Triple, terms: set[str]) -> bool:
    return triple.predicate == _TYPE and isinstance(triple.subject, ox.NamedNode) and triple.subject.value in terms


_TYPE = ox.NamedNode(STANDARD_PREFIXES["rdf"] + "type")
