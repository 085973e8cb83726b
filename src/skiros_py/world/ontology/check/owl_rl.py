"""An OWL 2 RL reasoner without Java: the ``reasonable`` library draws conclusions, we look for contradictions in them.

The rules never invent individuals, so a class that nothing can be of shows only once something is of it: each class
gets one. What a restriction says there is ("has some …") is invented too, to a small depth,
and what is known of one class is used for the next. Sound, but not complete:
it sees no contradiction that takes a choice between several ways ("or", counting beyond one), nor chains and keys.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from itertools import count, islice

import pyoxigraph as ox
import rdflib
from reasonable import PyReasoner

from skiros_py.world.ontology.check.clashes import Facts, clashes, connected
from skiros_py.world.ontology.check.logic import NoAnswer, Verdict, one_of, some
from skiros_py.world.ontology.check.owl import owl, rdf, rdfs

__all__ = ["OwlRl"]

_Term = rdflib.URIRef | rdflib.BNode | rdflib.Literal
_Triple = tuple[_Term, _Term, _Term]

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
    return [(_term(t.subject), _term(t.predicate), _term(t.object)) for t in triples]


def _term(term: object) -> _Term:
    if isinstance(term, ox.NamedNode):
        return rdflib.URIRef(term.value)
    if isinstance(term, ox.BlankNode):
        return rdflib.BNode(term.value)
    assert isinstance(term, ox.Literal)
    if term.language:
        return rdflib.Literal(term.value, lang=term.language)
    return rdflib.Literal(term.value, datatype=rdflib.URIRef(term.datatype.value), normalize=False)


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
