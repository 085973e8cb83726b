"""Computed relations in queries: evaluated as far as a query needs them, and in the store while it runs.

The patterns known to hold around a group are true of every solution that can matter, so the relations in the group
are evaluated only for elements that match them. Where that is not certain (a subquery, the far side of another
OPTIONAL) no such patterns are collected.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import Any

import pyoxigraph as ox
from pyparsing import ParseException
from rdflib import BNode, Literal, URIRef, Variable
from rdflib.paths import AlternativePath, InvPath, MulPath, NegatedPath, Path, SequencePath
from rdflib.plugins.sparql.algebra import translateGroupGraphPattern, translateQuery
from rdflib.plugins.sparql.parser import parseQuery
from rdflib.plugins.sparql.parserutils import CompValue

from skiros_py.errors import UsageError
from skiros_py.world.index import Index
from skiros_py.world.store.store import COMPUTED_GRAPH, QuadStore, Rows, for_rdflib
from skiros_py.world.vocabulary import ELEMENT

RDFLIB_SPARQL = threading.RLock()
"""rdflib's parser and its table of functions are for one thread at a time."""

End = URIRef | Literal | Variable
Predicate = URIRef | Variable | Path


@dataclass(frozen=True, slots=True)
class Step:
    """One triple pattern; sequences and inverses are taken apart already, blank nodes are variables."""

    subject: End
    predicate: Predicate
    object: End


@dataclass(frozen=True, slots=True)
class Known:
    """Something that holds: the text of a pattern, and the variables that it binds."""

    text: str
    variables: frozenset[Variable]


@dataclass(frozen=True, slots=True)
class Group:
    """Triple patterns that must hold together, and the patterns certain to hold around them."""

    steps: tuple[Step, ...]
    around: tuple[Known, ...]


Stored = Callable[[Predicate], bool]
"""Whether a predicate can only match stored triples."""


def query_groups(sparql: str, stored: Stored) -> list[Group]:
    """Returns every group of a query.

    Raises:
        UsageError: It does not parse.
    """
    walk = _Walk(stored)
    walk.visit(_algebra(sparql), ())
    return walk.groups


def known(step: Step) -> Known:
    """Returns a step as a pattern known to hold."""
    ends = (step.subject, step.object)
    predicate = step.predicate
    variables = frozenset(term for term in (*ends, predicate) if isinstance(term, Variable))
    middle = predicate.n3() if isinstance(predicate, URIRef | Variable) else f"({predicate.n3()})"
    return Known(f"{step.subject.n3()} {middle} {step.object.n3()} .", variables)


@lru_cache(maxsize=128)
def _algebra(sparql: str) -> CompValue:
    try:
        with RDFLIB_SPARQL:
            root = translateQuery(parseQuery(for_rdflib(sparql))).algebra
    except ParseException as error:
        raise UsageError(f"the query does not parse: line {error.lineno}: {error.msg}") from None
    except RecursionError:
        raise UsageError("the query is nested too deep") from None
    except Exception as error:  # noqa: BLE001  rdflib raises Exception itself
        raise UsageError(f"the query does not parse: {error}") from None
    assert isinstance(root, CompValue)
    return root


class _Walk:
    """Walks the algebra of a query.

    ``around`` are patterns that hold for every solution of a part that can matter. They come from the parts that it is
    joined with, so they are passed down only where dropping a solution drops nothing else: never to an optional side.
    """

    def __init__(self, stored: Stored) -> None:
        self.groups: list[Group] = []
        self._stored = stored

    def visit(self, node: CompValue, around: tuple[Known, ...]) -> None:
        name = node.name
        if name == "BGP":
            self.groups.append(Group(_steps(node), around))
        elif name == "Join":
            self.visit(node.p1, around + self._sure(node.p2))
            self.visit(node.p2, around + self._sure(node.p1))
        elif name == "Union":
            self.visit(node.p1, around)
            self.visit(node.p2, around)
        elif name in ("LeftJoin", "Minus"):
            self.visit(node.p1, around)
            self.visit(node.p2, self._sure(node.p1))
            self._expression(node.get("expr"), self._sure(node.p1))
        elif name in ("Filter", "Extend", "Graph"):
            self.visit(node.p, around + (_said_by(node.expr) if name == "Filter" else ()))
            self._expression(node.get("expr"), self._sure(node.p))
        else:
            self._barrier(node)

    def _barrier(self, node: CompValue) -> None:
        """Grouping, slices, projections: patterns outside do not restrict the solutions counted or cut off inside."""
        for part in node.values():
            if isinstance(part, CompValue) and part.name in _PARTS:
                self.visit(part, ())
            else:
                self._expression(part, ())

    def _expression(self, expression: object, around: tuple[Known, ...]) -> None:
        for exists in _existences(expression):
            graph = exists.graph
            if graph.name == "GroupGraphPatternSub":  # rdflib leaves it as it was parsed within OPTIONAL
                graph = translateGroupGraphPattern(graph)
            self.visit(graph, around)

    def _sure(self, node: CompValue) -> tuple[Known, ...]:
        """Patterns that hold for every solution of a part."""
        name = node.name
        if name == "BGP":
            return tuple(known(step) for step in _steps(node) if self._stored(step.predicate))
        if name == "Join":
            return self._sure(node.p1) + self._sure(node.p2)
        if name in ("LeftJoin", "Minus"):
            return self._sure(node.p1)
        if name == "Filter":
            return self._sure(node.p) + _said_by(node.expr)
        if name == "Extend":
            return self._sure(node.p) + _constant(node.var, [node.expr])
        if name in ("Graph", "Distinct", "Reduced", "OrderBy"):
            return self._sure(node.p)
        return _inline(node.p) if name == "ToMultiSet" and node.p.name == "values" else ()


_LIMITING = ("Project", "Distinct", "Reduced", "OrderBy", "Slice", "Group", "AggregateJoin")
_PARTS = frozenset(("BGP", "Join", "Union", "LeftJoin", "Minus", "Filter", "Extend", "Graph", "ToMultiSet", *_LIMITING))


def _existences(part: object) -> Iterator[CompValue]:
    if isinstance(part, CompValue):
        if part.name in ("Builtin_EXISTS", "Builtin_NOTEXISTS"):
            yield part
            return
        part = list(part.values())
    if isinstance(part, list | tuple):
        for inner in part:
            yield from _existences(inner)


# ---------------------------------------------------------------- variables restricted by expressions and tables


def _said_by(expression: object) -> tuple[Known, ...]:
    """Restrictions in a filter: ``?x = <iri>`` and ``?x IN (<iri>, …)``, also joined by "and"."""
    if not isinstance(expression, CompValue):
        return ()
    if expression.name == "ConditionalAndExpression":
        return tuple(said for part in (expression.expr, *expression.other) for said in _said_by(part))
    if expression.name != "RelationalExpression":
        return ()
    left, right = expression.expr, expression.other
    if expression.op == "IN":
        return _constant(left, right if isinstance(right, list) else [right])
    if expression.op == "=":
        return _constant(left, [right]) or _constant(right, [left])
    return ()


def _constant(variable: object, values: Iterable[object]) -> tuple[Known, ...]:
    terms = list(values)
    if not isinstance(variable, Variable) or not all(isinstance(term, URIRef) for term in terms):
        return ()
    text = f"VALUES {variable.n3()} {{ {' '.join(t.n3() for t in terms if isinstance(t, URIRef))} }}"
    return (Known(text, frozenset([variable])),)


def _inline(values: CompValue) -> tuple[Known, ...]:
    """Restrictions of a VALUES on each variable that it always binds to a name."""
    rows: list[Mapping[object, object]] = list(values.res or ())
    variables = {variable for row in rows for variable in row}
    return tuple(k for v in sorted(variables, key=str) for k in _constant(v, dict.fromkeys(r.get(v) for r in rows)))


# ---------------------------------------------------------------- taking patterns apart


def _steps(group: CompValue) -> tuple[Step, ...]:
    fresh = (Variable(f"_between_{id(group)}_{number}") for number in count())
    return tuple(step for s, p, o in group.triples for step in _taken_apart(_named(s), _named(p), _named(o), fresh))


def _taken_apart(subject: End, predicate: Predicate, object_: End, fresh: Iterator[Variable]) -> Iterator[Step]:
    if isinstance(predicate, InvPath):
        yield from _taken_apart(object_, predicate.arg, subject, fresh)
    elif isinstance(predicate, SequencePath):
        stations = [subject, *(next(fresh) for _ in predicate.args[1:]), object_]
        for at, part in enumerate(predicate.args):
            yield from _taken_apart(stations[at], part, stations[at + 1], fresh)
    else:
        yield Step(subject, predicate, object_)


def _named(term: Any) -> Any:
    """The term; for a blank node, a variable."""
    return Variable("_blank_" + re.sub(r"\W", "_", str(term))) if isinstance(term, BNode) else term


MOST_PAIRS = 1_000_000
"""Maximum number of pairs of elements that are evaluated for one query."""

_Ids = Collection[str] | None
"""Candidate elements at one end; None stands for all."""


@contextmanager
def worked_out(store: QuadStore, view: Index, sparql: str, relations: frozenset[str]) -> Iterator[None]:
    """Adds the computed relations that a query needs to a store, for the duration of the block.

    Every pair that can matter to the answer is added. A variable in the place of a relation stands for computed
    relations, too.

    Args:
        store: The store that the query runs on; not shared meanwhile.
        view: The state that it contains.
        sparql: The query, with IRIs in full.
        relations: The computed relations that it mentions, and those below them.

    Raises:
        UsageError: It does not parse, or needs too many pairs.
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
    """Evaluates the steps one by one, the most constrained first: each constrains the next."""
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
    """The elements that an end can stand for; None if any."""
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
    """The known patterns with a variable, with the other variables in those, and so on."""
    variables, left, found = {end}, list(known_here), list[Known]()
    while more := [one for one in left if not variables.isdisjoint(one.variables)]:
        found += more
        left = [one for one in left if one not in more]
        variables = variables.union(*(one.variables for one in more))
    return found


class _Pairs:
    """The computed relations of one query evaluated so far.

    Attributes:
        looked_at: Number of evaluated pairs of elements.
    """

    def __init__(self, store: QuadStore, view: Index, relations: frozenset[str]) -> None:
        self.looked_at = 0
        self._store = store
        self._view = view
        self._names = view.ontology.names
        self._relations = {self._names.iri(relation): relation for relation in sorted(relations)}
        self._done: set[tuple[str, tuple[str, ...], tuple[str, ...]]] = set()

    def is_stored(self, predicate: Predicate) -> bool:
        """Returns whether a predicate can only match stored triples."""
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
        """Adds to the store every pair that can match a predicate between these ends."""
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
        else:  # on the way, any element is a candidate
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
