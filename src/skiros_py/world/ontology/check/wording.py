"""Axioms in words that people read, each with where it stands."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping

import pyoxigraph as ox

from skiros_py.world.names import Names
from skiros_py.world.ontology.check.axioms import Axiom
from skiros_py.world.ontology.check.owl import owl, rdf, rdfs

__all__ = ["in_words", "line_of"]

_SENTENCES: Mapping[str, str] = {
    rdfs("subClassOf"): "every {s} is {o}",
    owl("equivalentClass"): "{s} means the same as {o}",
    owl("disjointWith"): "nothing is both {s} and {o}",
    owl("complementOf"): "{s} is all that is not {o}",
    owl("disjointUnionOf"): "{s} is exactly one of {o}",
    owl("unionOf"): "{s} is any of {o}",
    owl("intersectionOf"): "{s} is all of {o} at once",
    owl("oneOf"): "{s} is one of {o}",
    owl("hasKey"): "{s} is identified by {o}",
    rdfs("domain"): "whatever has {s} is {o}",
    rdfs("range"): "whatever {s} leads to is {o}",
    rdfs("subPropertyOf"): "{s} implies {o}",
    owl("equivalentProperty"): "{s} means the same as {o}",
    owl("inverseOf"): "{s} is {o} read backwards",
    owl("propertyDisjointWith"): "{s} and {o} never hold between the same two",
    owl("propertyChainAxiom"): "{o} one after the other imply {s}",
    owl("sameAs"): "{s} is the same thing as {o}",
    owl("differentFrom"): "{s} is another thing than {o}",
    rdf("type"): "{s} is {o}",
}
_TYPES: Mapping[str, str] = {
    owl("FunctionalProperty"): "{s} leads to one thing at most",
    owl("InverseFunctionalProperty"): "one thing at most has {s} to the same",
    owl("TransitiveProperty"): "{s} is transitive",
    owl("SymmetricProperty"): "{s} holds both ways",
    owl("AsymmetricProperty"): "{s} never holds both ways",
    owl("ReflexiveProperty"): "everything has {s} to itself",
    owl("IrreflexiveProperty"): "nothing has {s} to itself",
}
_MANY: Mapping[str, str] = {
    owl("AllDisjointClasses"): "nothing is two of {o}",
    owl("AllDisjointProperties"): "no two of {o} hold between the same two",
    owl("AllDifferent"): "{o} are all different things",
}
_COUNTS: Mapping[str, str] = {
    **{owl(w): "at least" for w in ("minCardinality", "minQualifiedCardinality")},
    **{owl(w): "at most" for w in ("maxCardinality", "maxQualifiedCardinality")},
    **{owl(w): "exactly" for w in ("cardinality", "qualifiedCardinality")},
}
_FILLERS: Mapping[str, str] = {
    owl("someValuesFrom"): "something with {p} to some {o}",
    owl("allValuesFrom"): "something with {p} to nothing but {o}",
    owl("hasValue"): "something with {p} {o}",
    owl("hasSelf"): "something with {p} to itself",
}
_JOINED: Mapping[str, str] = {owl("unionOf"): " or ", owl("intersectionOf"): " and ", owl("oneOf"): " or "}
_DEEP = 6
"""Class expressions within each other that are spelt out."""


def in_words(axiom: Axiom, names: Names) -> str:
    """Returns what an axiom says, and where: "every kitting:Kit is sk:Container (kitting.ttl:51)"."""
    line = line_of(axiom)
    where = f"{axiom.document.path}:{line}" if line else f"{axiom.document.path}"
    return f"{_Words(axiom, names).sentence()} ({where})"


def line_of(axiom: Axiom) -> int | None:
    """Returns the line at which an axiom stands, where it is known."""
    at = axiom.head.object.value if isinstance(axiom.head.object, ox.NamedNode) else axiom.head.predicate.value
    return axiom.document.fault("", axiom.subject or at, at).line


class _Words:
    def __init__(self, axiom: Axiom, names: Names) -> None:
        self._head = axiom.head
        self._name: Callable[[str], str] = names.name
        self._about: dict[object, dict[str, object]] = defaultdict(dict)
        for triple in axiom.triples:
            self._about[triple.subject].setdefault(triple.predicate.value, triple.object)

    def sentence(self) -> str:
        subject, word, object_ = self._head.subject, self._head.predicate.value, self._head.object
        type_ = object_.value if word == rdf("type") and isinstance(object_, ox.NamedNode) else ""
        if type_ in _MANY:
            about = self._about[subject]
            members = about.get(owl("members"), about.get(owl("distinctMembers")))
            return _MANY[type_].format(o=self._list(members, ", "))
        if type_ == owl("NegativePropertyAssertion"):
            return self._negative(self._about[subject])
        pattern = _TYPES.get(type_) or _SENTENCES.get(word, "{s} " + self._name(word) + " {o}")
        return pattern.format(s=self._node(subject), o=self._node(object_))

    def _negative(self, about: Mapping[str, object]) -> str:
        target = about.get(owl("targetIndividual"), about.get(owl("targetValue")))
        said = (about.get(owl("sourceIndividual")), about.get(owl("assertionProperty")), target)
        return f"it is not so that {' '.join(map(self._node, said))}"

    def _node(self, node: object, depth: int = 0) -> str:
        if isinstance(node, ox.NamedNode):
            return self._name(node.value)
        if isinstance(node, ox.Literal):
            return node.value if len(node.value) <= 40 else f"{node.value[:40]}…"
        if depth > _DEEP:
            return "…"
        return self._expression(self._about.get(node, {}), node, depth + 1)

    def _expression(self, about: Mapping[str, object], node: object, depth: int) -> str:
        if rdf("first") in about:
            return self._list(node, ", ", depth)
        for word, joint in _JOINED.items():
            if word in about:
                return f"({self._list(about[word], joint, depth)})"
        if owl("complementOf") in about:
            return f"not {self._node(about[owl('complementOf')], depth)}"
        if owl("inverseOf") in about:
            return f"{self._node(about[owl('inverseOf')], depth)} read backwards"
        return self._restriction(about, depth)

    def _restriction(self, about: Mapping[str, object], depth: int) -> str:
        property_ = self._node(about.get(owl("onProperty")), depth)
        for word, pattern in _FILLERS.items():
            if word in about:
                return pattern.format(p=property_, o=self._node(about[word], depth))
        for word, says in _COUNTS.items():
            if word in about:
                of = about.get(owl("onClass"), about.get(owl("onDataRange")))
                what = f" {self._node(of, depth)}" if of is not None else ""
                return f"something with {property_} to {says} {self._node(about[word])}{what}"
        return "something unnamed"

    def _list(self, node: object, joint: str, depth: int = 0) -> str:
        return joint.join(self._node(member, depth) for member in self._members(node))

    def _members(self, node: object) -> Iterator[object]:
        seen = set()
        while node in self._about and node not in seen:
            seen.add(node)
            cell = self._about[node]
            if rdf("first") not in cell:
                return
            yield cell[rdf("first")]
            node = cell.get(rdf("rest"))
