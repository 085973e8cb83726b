"""Contradictions in statements from which an OWL RL reasoner has drawn its conclusions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping

from skiros_py.world.ontology.check.owl import is_standard, owl, rdf

__all__ = ["Facts", "clashes", "connected"]

_ZERO = (owl("maxCardinality"), owl("cardinality"), owl("maxQualifiedCardinality"), owl("qualifiedCardinality"))


class Facts:
    """Statements as plain text, by predicate and by subject.

    Attributes:
        types: Classes by individual (or term).
        about: Objects by subject, by predicate.
    """

    def __init__(self, triples: Iterable[tuple[str, str, str]]) -> None:
        self.about: Mapping[str, Mapping[str, set[str]]] = defaultdict(lambda: defaultdict(set))
        for subject, predicate, object_ in triples:
            self.about[predicate][subject].add(object_)
        self.types: Mapping[str, set[str]] = self.about[rdf("type")]

    def pairs(self, predicate: str) -> Iterator[tuple[str, str]]:
        """Yields subject and object of a predicate."""
        for subject, objects in self.about.get(predicate, {}).items():
            for object_ in objects:
                yield subject, object_

    def of_type(self, type_: str) -> Iterator[str]:
        """Yields all that are of a class."""
        return (subject for subject, types in self.types.items() if type_ in types)

    def one(self, subject: str, predicate: str) -> str | None:
        """Returns the object of a predicate, or None where there is none; of several the first in order."""
        return min(self.about.get(predicate, {}).get(subject, ()), default=None)

    def has(self, subject: str, predicate: str, object_: str) -> bool:
        """Returns True when the statement is among these."""
        return object_ in self.about.get(predicate, {}).get(subject, ())

    def members(self, node: str | None) -> tuple[str, ...]:
        """Returns what a list holds."""
        found: list[str] = []
        seen = set()
        while node is not None and node != rdf("nil") and node not in seen:
            seen.add(node)
            first = self.one(node, rdf("first"))
            found.extend(() if first is None else [first])
            node = self.one(node, rdf("rest"))
        return tuple(found)


def clashes(facts: Facts) -> set[str]:
    """Returns the individuals at which a contradiction shows."""
    checks = (_impossible, _disjoint_classes, _different, _properties, _disjoint_properties, _denied, _none_allowed)
    return {individual for check in checks for individual in check(facts)}


def connected(facts: Facts) -> list[set[str]]:
    """Returns the individuals in groups between which no relation holds; what is in none is a group of its own."""
    group = {one: {one} for one in facts.types}
    for word, objects in facts.about.items():
        if not is_standard(word) or word in (owl("sameAs"), owl("differentFrom")):
            for subject, others in objects.items():
                for other in others & group.keys():
                    _join(group, subject, other)
    return list({id(members): members for members in group.values()}.values())


def _join(group: dict[str, set[str]], one: str, other: str) -> None:
    small, large = sorted((group.setdefault(one, {one}), group[other]), key=len)
    if small is not large:
        large |= small
        group.update(dict.fromkeys(small, large))


def _impossible(facts: Facts) -> Iterator[str]:
    yield from facts.of_type(owl("Nothing"))


def _disjoint_classes(facts: Facts) -> Iterator[str]:
    apart: dict[str, set[str]] = defaultdict(set)
    for word in owl("disjointWith"), owl("complementOf"):
        for one, other in facts.pairs(word):
            apart[one].add(other)
            apart[other].add(one)
    groups = [set(g) for g in _groups(facts, "AllDisjointClasses", "members")]
    groups += [set(facts.members(node)) for _, node in facts.pairs(owl("disjointUnionOf"))]
    for individual, types in facts.types.items():
        pairwise = any(not types.isdisjoint(apart[type_]) for type_ in types & apart.keys())
        if pairwise or any(len(types & group) > 1 for group in groups):
            yield individual


def _different(facts: Facts) -> Iterator[str]:
    same = facts.about.get(owl("sameAs"), {})
    for one, other in facts.pairs(owl("differentFrom")):
        if one == other or other in same.get(one, ()):
            yield one
    for group in (*_groups(facts, "AllDifferent", "members"), *_groups(facts, "AllDifferent", "distinctMembers")):
        yield from (one for one in group if any(other != one and other in same.get(one, ()) for other in group))


def _properties(facts: Facts) -> Iterator[str]:
    for property_ in facts.of_type(owl("AsymmetricProperty")):
        yield from (one for one, other in facts.pairs(property_) if facts.has(other, property_, one))
    for property_ in facts.of_type(owl("IrreflexiveProperty")):
        yield from (one for one, other in facts.pairs(property_) if one == other)


def _disjoint_properties(facts: Facts) -> Iterator[str]:
    pairs = set(facts.pairs(owl("propertyDisjointWith")))
    for group in _groups(facts, "AllDisjointProperties", "members"):
        pairs |= {(one, other) for one in group for other in group if one != other}
    for one, other in pairs:
        yield from (subject for subject, object_ in facts.pairs(one) if facts.has(subject, other, object_))


def _denied(facts: Facts) -> Iterator[str]:
    for node, subject in facts.pairs(owl("sourceIndividual")):
        property_ = facts.one(node, owl("assertionProperty"))
        for word in owl("targetIndividual"), owl("targetValue"):
            target = facts.one(node, word)
            if property_ is not None and target is not None and facts.has(subject, property_, target):
                yield subject


def _none_allowed(facts: Facts) -> Iterator[str]:
    for word in _ZERO:
        for restriction, number in facts.pairs(word):
            property_ = facts.one(restriction, owl("onProperty"))
            if number == "0" and property_ is not None:
                filler = facts.one(restriction, owl("onClass"))
                yield from (one for one in facts.of_type(restriction) if _some(facts, one, property_, filler))


def _some(facts: Facts, one: str, property_: str, filler: str | None) -> bool:
    others = facts.about.get(property_, {}).get(one, ())
    return any(filler in (None, owl("Thing")) or filler in facts.types.get(other, ()) for other in others)


def _groups(facts: Facts, type_: str, word: str) -> Iterator[tuple[str, ...]]:
    for node in sorted(facts.of_type(owl(type_))):
        yield facts.members(facts.one(node, owl(word)))
