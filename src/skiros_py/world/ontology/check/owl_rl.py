"""An OWL 2 RL reasoner without Java: the ``reasonable`` library draws conclusions, SPARQL finds contradictions in them.

The rules never invent individuals, so a class that nothing can be of shows only once something is of it: each class
gets one. What a restriction requires to exist ("has some …") is invented too, to a small depth,
and what is known of one class is used for the next. Sound, but not complete:
it finds no contradiction that takes a choice between several ways ("or", counting beyond one), nor chains and keys.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import chain, count, groupby, islice
from typing import Any

import pyoxigraph as ox
from reasonable import PyReasoner

from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology.check.owl_reasoner import NoAnswer, Verdict, one_of, some
from skiros_py.world.store.store import Term, from_rdflib, to_rdflib

_MEMBER = "rdf:rest*/rdf:first"
_MANY_DISJOINT = f"?group a owl:AllDisjoint{{}} ; owl:members/{_MEMBER} ?one, ?other . FILTER(?one != ?other)"
_SAME_BUT_OTHER = "?at owl:sameAs ?other FILTER(?at != ?other)"
_TARGET = "owl:targetIndividual|owl:targetValue"
_MOST = """
?restriction owl:maxCardinality|owl:cardinality|owl:maxQualifiedCardinality|owl:qualifiedCardinality ?number ;
    owl:onProperty ?property . FILTER(STR(?number) = "{}") OPTIONAL {{ ?restriction owl:onClass ?class }}
"""
_IS_COUNTED = "!BOUND(?class) || EXISTS { ?object a ?class }"
_CONTRADICTIONS = (
    "?at a owl:Nothing",
    "?one owl:disjointWith|owl:complementOf ?other . ?at a ?one, ?other",
    f"{_MANY_DISJOINT.format('Classes')} ?at a ?one, ?other",
    f"?union owl:disjointUnionOf/{_MEMBER} ?one, ?other . FILTER(?one != ?other) ?at a ?one, ?other",
    "?at owl:differentFrom ?at",
    "?at owl:differentFrom ?other . ?at owl:sameAs ?other",
    f"?all a owl:AllDifferent ; (owl:members|owl:distinctMembers)/{_MEMBER} ?at, ?other . {_SAME_BUT_OTHER}",
    "?property a owl:AsymmetricProperty . ?at ?property ?other . ?other ?property ?at",
    "?property a owl:IrreflexiveProperty . ?at ?property ?at",
    "?one owl:propertyDisjointWith ?other . ?at ?one ?object . ?at ?other ?object",
    f"{_MANY_DISJOINT.format('Properties')} ?at ?one ?object . ?at ?other ?object",
    f"?denied owl:sourceIndividual ?at ; owl:assertionProperty ?property ; {_TARGET} ?object . ?at ?property ?object",
    f"{_MOST.format(0)} ?at a ?restriction ; ?property ?object FILTER(?class = owl:Thing || {_IS_COUNTED})",
)
"""Patterns that hold at an individual (``?at``) only if the statements contradict each other."""

_REQUIRED = """
{ ?restriction owl:someValuesFrom ?class }
UNION {
    ?restriction owl:minCardinality|owl:cardinality|owl:minQualifiedCardinality|owl:qualifiedCardinality ?number
    FILTER(STR(?number) != "0") OPTIONAL { ?restriction owl:onClass ?class }
}
?restriction owl:onProperty ?property . ?individual a ?restriction
"""
_MISSING = (
    f"{_REQUIRED} FILTER(BOUND(?class)) FILTER NOT EXISTS {{ ?individual ?property ?known . ?known a ?class }}",
    f"{_REQUIRED} FILTER(!BOUND(?class)) FILTER NOT EXISTS {{ ?individual ?property ?known }}",
)
"""Individuals that a restriction requires to be related to something that is not known."""

_AT_MOST_ONE = (
    f"{_MOST.format(1)} ?individual a ?restriction ; ?property ?object FILTER(!ISLITERAL(?object) && ({_IS_COUNTED}))"
)
_PREFIXES = "".join(f"PREFIX {name}: <{STANDARD_PREFIXES[name]}> " for name in ("rdf", "owl"))

_DEPTH = 8
"""Maximum depth of invented individuals that follow from invented ones."""
_MERGING = 2
"""Number of steps that merge individuals after the last one was invented."""
_MANY = 500
"""Maximum number of statements about invented individuals in a step, unless they are invented only once."""
_WITNESS = "urn:skiros-check:something:"

_RDF, _RDFS, _OWL = (STANDARD_PREFIXES[name] for name in ("rdf", "rdfs", "owl"))
_TYPE, _SAME = ox.NamedNode(f"{_RDF}type"), ox.NamedNode(f"{_OWL}sameAs")
_BELOW, _NOTHING = ox.NamedNode(f"{_RDFS}subClassOf"), ox.NamedNode(f"{_OWL}Nothing")
_TIES = (_SAME, ox.NamedNode(f"{_OWL}differentFrom"))
_UNION_OF = ox.NamedNode(f"{_OWL}disjointUnionOf")


class OwlRl:
    """Asks the OWL 2 RL reasoner.

    Args:
        deadline: Time of :func:`time.monotonic` after which no step is started [s].
    """

    name = "OWL-RL"
    is_complete = False

    def __init__(self, deadline: float) -> None:
        self._deadline = deadline

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str] = ()) -> Verdict:
        """Finds contradictions, and which of some classes (IRIs) are unsatisfiable.

        Raises:
            NoAnswer: It takes too long.
        """
        _, found = self._saturated(triples)
        if found:
            known = (str(n.value) for n in found if isinstance(n, ox.NamedNode) and not n.value.startswith(_WITNESS))
            return Verdict(consistent=False, near=tuple(sorted(known)))
        return Verdict(consistent=True, unsatisfiable=tuple(sorted(self._impossible(triples, sorted(classes)))))

    def _impossible(self, base: Sequence[ox.Triple], classes: list[str]) -> set[str]:
        """Invents one individual of each class, repeatedly without the unsatisfiable ones, until no more are found."""
        impossible: set[str] = set()
        while left := [class_ for class_ in classes if class_ not in impossible]:
            known = [*base, *(ox.Triple(ox.NamedNode(class_), _BELOW, _NOTHING) for class_ in impossible)]
            facts, found = self._saturated([*known, *map(one_of, left)], inventing=1)
            alone, entangled = _blamed(facts, found, left)
            new = alone | set(self._among(known, entangled))
            if not new:
                break
            impossible |= new
        return impossible

    def _among(self, base: Sequence[ox.Triple], classes: list[str]) -> Iterator[str]:
        """Halves the classes until each that causes a contradiction on its own is found.

        Individuals of several classes together might clash although each alone does not.
        """
        if not classes or not self._saturated([*base, *map(one_of, classes)])[1]:
            return
        if len(classes) == 1:
            yield classes[0]
            return
        half = len(classes) // 2
        yield from self._among(base, classes[:half])
        yield from self._among(base, classes[half:])

    def _saturated(self, triples: Sequence[ox.Triple], inventing: int = _DEPTH) -> tuple[ox.Store, set[Term]]:
        """Returns all entailed statements, and the individuals with contradictions."""
        reasoner, as_term = PyReasoner(), cache(from_rdflib)
        added = [*triples, *_unions(triples)]
        for step in range(inventing + _MERGING + 1):
            if time.monotonic() > self._deadline:
                raise NoAnswer("the OWL-RL reasoner found no answer in the time given")
            reasoner.from_graph([(to_rdflib(t.subject), to_rdflib(t.predicate), to_rdflib(t.object)) for t in added])
            facts = _stored(tuple(map(as_term, nodes)) for nodes in reasoner.reason())
            found = {at for pattern in _CONTRADICTIONS for (at,) in _rows(facts, "DISTINCT ?at", pattern)}
            if found:
                break
            added = list(_merged(facts))
            if step < inventing:
                added += islice(_witnesses(facts, step), None if inventing == 1 else _MANY)
            if not added:
                break
        return facts, found


def _stored(triples: Iterable[Sequence[Any]]) -> ox.Store:
    store = ox.Store()
    store.bulk_extend(ox.Quad(*triple) for triple in triples if not isinstance(triple[0], ox.Literal))
    return store


def _rows(facts: ox.Store, wanted: str, pattern: str, then: str = "") -> list[tuple[Term, ...]]:
    solutions = facts.query(f"{_PREFIXES} SELECT {wanted} WHERE {{ {pattern} }} {then}")
    assert isinstance(solutions, ox.QuerySolutions)
    return [tuple(solution) for solution in solutions]


def _value(node: Term) -> str:
    return str(node.value)


def _blamed(facts: ox.Store, found: set[Term], classes: list[str]) -> tuple[set[str], list[str]]:
    """The classes whose invented individuals clash: those unconnected to others, and the rest."""
    made_up: dict[Term, str] = {ox.NamedNode(some(class_)): class_ for class_ in classes}
    alone: set[str] = set()
    entangled: set[str] = set()
    for group in _connected(facts):
        if not group.isdisjoint(found):
            members = [made_up[one] for one in group if one in made_up]
            others = [one for one in group if one not in made_up and not _value(one).startswith(_WITNESS)]
            (alone if len(members) == 1 and not others else entangled).update(members)
    return alone, sorted(entangled)


def _connected(facts: ox.Store) -> list[set[Term]]:
    """Returns the individuals in groups that no relation connects."""
    group: dict[Term, set[Term]] = defaultdict(set)
    for (one,) in _rows(facts, "DISTINCT ?one", "?one a ?class"):
        group[one] = {one}
    for one, word, other in _rows(facts, "?one ?word ?other", "?one ?word ?other . ?other a ?class"):
        if word in _TIES or not _value(word).startswith((_RDF, _RDFS, _OWL)):
            group[one].add(one)
            small, large = sorted((group[one], group[other]), key=len)
            if small is not large:
                large |= small
                group.update(dict.fromkeys(small, large))
    return list({id(members): members for members in group.values()}.values())


def _unions(triples: Sequence[ox.Triple]) -> Iterator[ox.Triple]:
    """The members of a disjoint union are subclasses of it; the library has no rule for that."""
    if any(triple.predicate == _UNION_OF for triple in triples):
        facts = _stored((t.subject, t.predicate, t.object) for t in triples)
        for member, union in _rows(facts, "?member ?union", f"?union owl:disjointUnionOf/{_MEMBER} ?member"):
            yield _triple(member, _BELOW, union)


def _witnesses(facts: ox.Store, depth: int) -> Iterator[ox.Triple]:
    """Statements about a new individual for each that a restriction requires and that is not known."""
    variables, number = "DISTINCT ?individual ?property ?class", count()
    found = (_rows(facts, variables, pattern, "ORDER BY ?class ?property ?individual") for pattern in _MISSING)
    for individual, property_, class_ in chain.from_iterable(found):
        witness = ox.NamedNode(f"{_WITNESS}{depth}-{next(number)}")
        yield _triple(individual, property_, witness)
        if class_ is not None:
            yield _triple(witness, _TYPE, class_)


def _merged(facts: ox.Store) -> Iterator[ox.Triple]:
    """Statements that individuals are the same where at most one is allowed."""
    variables = "?restriction ?individual ?object"
    rows = _rows(facts, variables, _AT_MOST_ONE, f"ORDER BY {variables}")
    for _, fitting in groupby(rows, key=lambda row: row[:2]):
        (_, _, first), *others = fitting
        for _, _, other in others:
            same = _triple(first, _SAME, other)
            if other != first and ox.Quad(same.subject, same.predicate, same.object) not in facts:
                yield same


def _triple(subject: Term, predicate: Term, object_: Term) -> ox.Triple:
    assert not isinstance(subject, ox.Literal)
    assert isinstance(predicate, ox.NamedNode)
    return ox.Triple(subject, predicate, object_)
