"""An OWL 2 RL reasoner without Java: the ``reasonable`` library draws conclusions, we look for contradictions in them.

The rules never invent individuals, so a class that nothing can be of shows only once something is of it: each class
gets one. What a restriction says there is ("has some …") is invented too, to a small depth,
and what is known of one class is used for the next. Sound, but not complete:
it sees no contradiction that takes a choice between several ways ("or", counting beyond one), nor chains and keys.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count, islice

import pyoxigraph as ox
import rdflib
from reasonable import PyReasoner

from skiros_py.world.ontology.check.material import is_standard, owl, rdf, rdfs
from skiros_py.world.ontology.check.reasoner import NoAnswer, Verdict, one_of, some
from skiros_py.world.store.store import Node, to_rdflib
from skiros_py.world.terms import reached

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
        """Returns the object of a predicate, or None if there is none; of several the first in order."""
        return min(self.about.get(predicate, {}).get(subject, ()), default=None)

    def has(self, subject: str, predicate: str, object_: str) -> bool:
        """Returns True when the statement is among these."""
        return object_ in self.about.get(predicate, {}).get(subject, ())

    def members(self, node: str | None) -> tuple[str, ...]:
        """Returns what a list holds."""
        cells = reached(filter(None, [node]), lambda cell: filter(None, [self.one(cell, rdf("rest"))]))
        firsts = (self.one(cell, rdf("first")) for cell in cells)
        return tuple(first for first in firsts if first is not None)


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


# ---------------------------------------------------------------- the reasoner


_Triple = tuple[Node, Node, Node]

_DEPTH = 8
"""How far things that must exist are invented from things invented before."""
_MERGING = 2
"""How often things that must be one are looked for after the last is invented."""
_MANY = 500
"""Statements about invented things that are added at each step, unless things are invented only once."""
_WITNESS = "urn:skiros-check:something:"
_AT_LEAST = (owl("minCardinality"), owl("cardinality"), owl("minQualifiedCardinality"), owl("qualifiedCardinality"))
_AT_MOST = (owl("maxCardinality"), owl("cardinality"), owl("maxQualifiedCardinality"), owl("qualifiedCardinality"))


class OwlRl:
    """Asks the OWL 2 RL reasoner.

    Args:
        deadline: Time of :func:`time.monotonic` after which nothing more is begun [s].
    """

    name = "OWL-RL"
    is_complete = False

    def __init__(self, deadline: float) -> None:
        self._deadline = deadline

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str]) -> Verdict:
        """Looks for contradictions, and for classes (IRIs) that nothing can be of.

        Raises:
            NoAnswer: It takes too long.
        """
        base = _plain(triples)
        _, found = self._saturated(base)
        if found:
            known = sorted(iri for iri in found if not iri.startswith(_WITNESS) and ":" in iri)
            return Verdict(consistent=False, near=tuple(known))
        return Verdict(consistent=True, unsatisfiable=tuple(sorted(self._impossible(base, sorted(classes)))))

    def consistent(self, triples: Sequence[ox.Triple]) -> bool:
        """Returns False when the statements contradict each other.

        Raises:
            NoAnswer: It takes too long.
        """
        return not self._saturated(_plain(triples))[1]

    def _impossible(self, base: list[_Triple], classes: list[str]) -> set[str]:
        """Makes up one thing of each class at once, again without those that cannot be, until no more are found."""
        impossible: set[str] = set()
        while True:
            left = [class_ for class_ in classes if class_ not in impossible]
            known = [(_iri(class_), _iri(rdfs("subClassOf")), _iri(owl("Nothing"))) for class_ in impossible]
            facts, found = self._saturated([*base, *known, *_plain(map(one_of, left))], inventing=1)
            alone, entangled = _blamed(facts, found, left)
            new = alone | set(self._among([*base, *known], entangled))
            if not new:
                return impossible
            impossible |= new

    def _among(self, base: list[_Triple], classes: list[str]) -> Iterator[str]:
        """Halves the classes until each that makes a contradiction on its own is found.

        Things of several classes at once might clash where each alone does not.
        """
        if not classes or not self._saturated(base + _plain(map(one_of, classes)))[1]:
            return
        if len(classes) == 1:
            yield classes[0]
            return
        half = len(classes) // 2
        yield from self._among(base, classes[:half])
        yield from self._among(base, classes[half:])

    def _saturated(self, triples: list[_Triple], inventing: int = _DEPTH) -> tuple[Facts, set[str]]:
        """All that follows, and the individuals at which it contradicts itself; things are invented so many times."""
        reasoner = PyReasoner()
        added = [*triples, *_unions(triples)]
        for step in range(inventing + _MERGING + 1):
            if time.monotonic() > self._deadline:
                raise NoAnswer("the OWL-RL reasoner found no answer in the time given")
            reasoner.from_graph(added)
            facts = Facts((str(s), str(p), str(o)) for s, p, o in reasoner.reason())
            found = clashes(facts)
            if found:
                break
            added = list(_merged(facts))
            if step < inventing:
                added += islice(_witnesses(facts, step), None if inventing == 1 else _MANY)
            if not added:
                break
        return facts, found


def _blamed(facts: Facts, found: set[str], classes: list[str]) -> tuple[set[str], list[str]]:
    """The classes whose made-up things clash: those that nothing else can have to do with, and the others."""
    made_up = {some(class_): class_ for class_ in classes}
    alone: set[str] = set()
    entangled: set[str] = set()
    for group in connected(facts):
        if not group.isdisjoint(found):
            members = [made_up[one] for one in group if one in made_up]
            others = [one for one in group if one not in made_up and not one.startswith(_WITNESS)]
            (alone if len(members) == 1 and not others else entangled).update(members)
    return alone, sorted(entangled)


def _plain(triples: Iterable[ox.Triple]) -> list[_Triple]:
    return [(to_rdflib(t.subject), to_rdflib(t.predicate), to_rdflib(t.object)) for t in triples]


def _unions(triples: list[_Triple]) -> Iterator[_Triple]:
    """The members of a disjoint union are subclasses of it, which the library does not know."""
    if not any(str(p) == owl("disjointUnionOf") for _, p, _ in triples):
        return
    facts = Facts((str(s), str(p), str(o)) for s, p, o in triples)
    for union, node in facts.pairs(owl("disjointUnionOf")):
        for member in facts.members(node):
            yield _iri(member), _iri(rdfs("subClassOf")), _iri(union)


def _witnesses(facts: Facts, depth: int) -> Iterator[_Triple]:
    """What must exist by a restriction and is not known yet: one new thing for each."""
    number = count()
    for restriction, property_, filler in _existing(facts):
        for one in sorted(facts.of_type(restriction)):
            if not _has_some(facts, one, property_, filler):
                witness = _iri(f"{_WITNESS}{depth}-{next(number)}")
                yield _node(one), _iri(property_), witness
                if filler is not None:
                    yield witness, _iri(rdf("type")), _node(filler)


def _existing(facts: Facts) -> Iterator[tuple[str, str, str | None]]:
    """Restrictions that say that something exists: (restriction, property, class of what exists)."""
    for restriction, filler in sorted(facts.pairs(owl("someValuesFrom"))):
        property_ = facts.one(restriction, owl("onProperty"))
        if property_ is not None:
            yield restriction, property_, filler
    for word in _AT_LEAST:
        for restriction, number in sorted(facts.pairs(word)):
            property_ = facts.one(restriction, owl("onProperty"))
            if property_ is not None and number != "0":
                yield restriction, property_, facts.one(restriction, owl("onClass"))


def _has_some(facts: Facts, one: str, property_: str, filler: str | None) -> bool:
    others = facts.about.get(property_, {}).get(one, ())
    return any(filler is None or filler in facts.types.get(other, ()) for other in others)


def _merged(facts: Facts) -> Iterator[_Triple]:
    """Where at most one is allowed, all there are are the same."""
    for word in _AT_MOST:
        for restriction, number in sorted(facts.pairs(word)):
            property_ = facts.one(restriction, owl("onProperty"))
            if number == "1" and property_ is not None:
                filler = facts.one(restriction, owl("onClass"))
                for one in sorted(facts.of_type(restriction)):
                    yield from _all_same(facts, one, property_, filler)


def _all_same(facts: Facts, one: str, property_: str, filler: str | None) -> Iterator[_Triple]:
    others = sorted(facts.about.get(property_, {}).get(one, ()))
    fitting = [o for o in others if filler is None or filler in facts.types.get(o, ())]
    for other in fitting[1:]:
        if not facts.has(fitting[0], owl("sameAs"), other):
            yield _node(fitting[0]), _iri(owl("sameAs")), _node(other)


def _iri(iri: str) -> rdflib.URIRef:
    return rdflib.URIRef(iri)


def _node(name: str) -> rdflib.URIRef | rdflib.BNode:
    return rdflib.URIRef(name) if ":" in name else rdflib.BNode(name)
