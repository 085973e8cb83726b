"""Computed relations in queries: worked out for what a query mentions, and in the store while it runs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager

import pyoxigraph as ox
from rdflib import Literal, URIRef, Variable
from rdflib.paths import AlternativePath, InvPath, MulPath, NegatedPath, SequencePath

from skiros_py.errors import UsageError
from skiros_py.world.index import Index
from skiros_py.world.queries.patterns import End, Group, Known, Predicate, Step, known, query_groups
from skiros_py.world.store.store import COMPUTED_GRAPH, QuadStore, Rows
from skiros_py.world.vocabulary import ELEMENT

MOST_PAIRS = 1_000_000
"""Pairs of elements that one query may have looked at."""

_Ids = Collection[str] | None
"""Elements that come into question at one end; None is all."""


@contextmanager
def worked_out(store: QuadStore, view: Index, sparql: str, relations: frozenset[str]) -> Iterator[None]:
    """Lets the store hold the computed relations that a query asks for, as long as the block lasts.

    Of the relations that the query mentions every pair is there that can matter to its answer. A variable in the place
    of a relation stands for those too.

    Args:
        store: What the query is put to; not shared meanwhile.
        view: The state that it holds.
        sparql: The query, with IRIs in full.
        relations: The computed relations that it mentions, and those below them.

    Raises:
        UsageError: It does not parse, or leaves too many pairs open.
        UnknownName: No reasoner computes a relation.
    """
    pairs = _Pairs(store, view, relations)
    try:
        for group in query_groups(sparql, pairs.is_stored):
            _work_out(group, pairs, store)
        yield
    finally:
        if pairs.looked_at:
            store.clear(COMPUTED_GRAPH)


def _work_out(group: Group, pairs: _Pairs, store: QuadStore) -> None:
    """Computes one step after the other, the most constrained first: each constrains the next."""
    known_here = [*group.around, *(known(step) for step in group.steps if pairs.is_stored(step.predicate))]
    waiting = [step for step in group.steps if not pairs.is_stored(step.predicate)]
    while waiting:
        step = max(waiting, key=lambda step: _ends_known(step, known_here))  # of equals the first
        waiting.remove(step)
        pairs.add(step.predicate, *(_candidates(end, known_here, store, pairs) for end in (step.subject, step.object)))
        if isinstance(step.predicate, URIRef | Variable):
            known_here.append(known(step))


def _ends_known(step: Step, known_here: Sequence[Known]) -> int:
    bound = {variable for one in known_here for variable in one.variables}
    return sum(2 * (not isinstance(end, Variable)) + (end in bound) for end in (step.subject, step.object))


def _candidates(end: End, known_here: Sequence[Known], store: QuadStore, pairs: _Pairs) -> _Ids:
    """The elements that an end can stand for, as far as known."""
    if isinstance(end, URIRef):
        return pairs.elements([ox.NamedNode(str(end))])
    if isinstance(end, Literal):
        return ()
    connected = _connected(end, known_here)
    if not connected:
        return None
    answer = store.query(f"SELECT DISTINCT {end.n3()} {{ {' '.join(one.text for one in connected)} }}")
    assert isinstance(answer, Rows)
    return pairs.elements(row[0] for row in answer.rows)


def _connected(end: Variable, known_here: Sequence[Known]) -> list[Known]:
    """What is known of a variable, of the other variables in that, and so on."""
    variables, left, found = {end}, list(known_here), list[Known]()
    while more := [one for one in left if not variables.isdisjoint(one.variables)]:
        found += more
        left = [one for one in left if one not in more]
        variables = variables.union(*(one.variables for one in more))
    return found


class _Pairs:
    """The computed relations of one query, as far as they are worked out.

    Attributes:
        looked_at: How many pairs of elements were looked at.
    """

    def __init__(self, store: QuadStore, view: Index, relations: frozenset[str]) -> None:
        self.looked_at = 0
        self._store = store
        self._view = view
        self._names = view.ontology.names
        self._relations = {self._names.iri(relation): relation for relation in sorted(relations)}
        self._done: set[tuple[str, tuple[str, ...], tuple[str, ...]]] = set()

    def is_stored(self, predicate: Predicate) -> bool:
        """Returns whether only what is stored can meet a predicate."""
        if isinstance(predicate, URIRef):
            return str(predicate) not in self._relations
        if isinstance(predicate, Variable | NegatedPath):
            return not self._relations
        return all(self.is_stored(part) for part in _parts(predicate))

    def elements(self, terms: Iterable[object]) -> list[str]:
        """Returns those of some terms that are elements, as ids."""
        ids = (self._names.name(term.value) for term in terms if isinstance(term, ox.NamedNode))
        return [name for name in ids if self._view.has(name)]

    def add(self, predicate: Predicate, subjects: _Ids, objects: _Ids) -> None:
        """Puts into the store whatever can meet a predicate between these ends."""
        if isinstance(predicate, URIRef):
            if str(predicate) in self._relations:
                self._add(self._relations[str(predicate)], subjects, objects)
        elif isinstance(predicate, Variable | NegatedPath):
            for relation in filter(self._is_computable, self._relations.values()):
                self._add(relation, subjects, objects)
                if isinstance(predicate, NegatedPath):  # it may have inverses in it
                    self._add(relation, objects, subjects)
        else:
            self._add_path(predicate, subjects, objects)

    def _add_path(self, path: Predicate, subjects: _Ids, objects: _Ids) -> None:
        if isinstance(path, InvPath):
            self.add(path.arg, objects, subjects)
        elif isinstance(path, AlternativePath):
            for choice in path.args:
                self.add(choice, subjects, objects)
        elif isinstance(path, MulPath) and path.mod == "?":
            self.add(path.path, subjects, objects)
        else:  # on the way, anything may come into question
            for part in _parts(path):
                self.add(part, None, None)

    def _add(self, relation: str, subjects: _Ids, objects: _Ids) -> None:
        ontology, reasoners = self._view.ontology, self._view.reasoners
        for below in reasoners.narrowest(ontology, relation):
            declared = ontology.relation(below)
            ends = self._among(declared.domain, subjects), self._among(declared.range, objects)
            if (relation + below, *ends) not in self._done:
                self._done.add((relation + below, *ends))
                self._count(relation, len(ends[0]) * len(ends[1]))
                found = reasoners.pairs(self._view, below, *ends)
                self._store.extend(self._quad(subject, relation, object_) for subject, object_ in found)

    def _is_computable(self, relation: str) -> bool:
        return any(map(self._view.reasoners.computes, self._view.ontology.sub_relations(relation)))

    def _among(self, class_: str | None, ids: _Ids) -> tuple[str, ...]:
        instances = self._view.instances(class_ or ELEMENT)
        if ids is None:
            return instances
        wanted = set(ids)
        return tuple(name for name in instances if name in wanted)

    def _count(self, relation: str, pairs: int) -> None:
        self.looked_at += pairs
        if self.looked_at > MOST_PAIRS:
            asked = f"{relation} would have to be worked out for {self.looked_at:,} pairs of elements"
            raise UsageError(f"{asked}, and {MOST_PAIRS:,} are the most: bind an end, or say more of what is there")

    def _quad(self, subject: str, relation: str, object_: str) -> ox.Quad:
        ends = (ox.NamedNode(self._names.iri(name)) for name in (subject, object_))
        return ox.Quad(next(ends), ox.NamedNode(self._names.iri(relation)), next(ends), COMPUTED_GRAPH)


def _parts(path: Predicate) -> Sequence[Predicate]:
    if isinstance(path, MulPath):
        return (path.path,)
    if isinstance(path, InvPath):
        return (path.arg,)
    assert isinstance(path, SequencePath | AlternativePath)
    return tuple(path.args)
