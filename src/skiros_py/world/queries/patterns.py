"""The groups of triple patterns of a query, where computed relations are asked for, and what surely holds around each.

What is said to hold around a group is true of every solution that can matter, so that whatever the group asks for has
to be worked out only for what agrees with it. Where that is not certain (a subquery, the far side of another OPTIONAL)
nothing is said.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import count

from pyparsing import ParseException
from rdflib import BNode, Literal, URIRef, Variable
from rdflib.paths import InvPath, Path, SequencePath
from rdflib.plugins.sparql.algebra import translateGroupGraphPattern, translateQuery
from rdflib.plugins.sparql.parser import parseQuery
from rdflib.plugins.sparql.parserutils import CompValue

from skiros_py.errors import UsageError
from skiros_py.world.store.rdflib_terms import for_rdflib

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
    """Triple patterns that must hold together, and what surely holds around them."""

    steps: tuple[Step, ...]
    around: tuple[Known, ...]


Stored = Callable[[Predicate], bool]
"""Whether a predicate can only be met by what is stored."""


def query_groups(sparql: str, stored: Stored) -> list[Group]:
    """Returns every group of a query.

    Raises:
        UsageError: It does not parse.
    """
    walk = _Walk(stored)
    walk.visit(_algebra(sparql), ())
    return walk.groups


def known(step: Step) -> Known:
    """Returns a step as something that holds."""
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
    """Goes through the algebra of a query.

    ``around`` is what holds of every solution of a part that can matter. It comes from what the part is joined with, so
    it may go down only to where dropping a solution drops no more than that: never to the optional side of something.
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
        """Grouping, slices, projections: what holds outside says nothing of what is counted or cut off inside."""
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
        """What holds of every solution of a part."""
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


# ---------------------------------------------------------------- what expressions and tables say of variables


def _said_by(expression: object) -> tuple[Known, ...]:
    """What a filter says: ``?x = <iri>`` and ``?x IN (<iri>, …)``, also joined by "and"."""
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
    """What a VALUES says of each variable that it always binds to a name."""
    rows: list[Mapping[object, object]] = list(values.res or ())
    variables = {variable for row in rows for variable in row}
    return tuple(k for v in sorted(variables, key=str) for k in _constant(v, dict.fromkeys(r.get(v) for r in rows)))


# ---------------------------------------------------------------- taking patterns apart


def _steps(group: CompValue) -> tuple[Step, ...]:
    fresh = (Variable(f"_between_{id(group)}_{number}") for number in count())
    return tuple(step for s, p, o in group.triples for step in _taken_apart(_end(s), _predicate(p), _end(o), fresh))


def _taken_apart(subject: End, predicate: Predicate, object_: End, fresh: Iterator[Variable]) -> Iterator[Step]:
    if isinstance(predicate, InvPath):
        yield from _taken_apart(object_, predicate.arg, subject, fresh)
    elif isinstance(predicate, SequencePath):
        stations = [subject, *(next(fresh) for _ in predicate.args[1:]), object_]
        for at, part in enumerate(predicate.args):
            yield from _taken_apart(stations[at], part, stations[at + 1], fresh)
    else:
        yield Step(subject, predicate, object_)


def _end(term: object) -> End:
    if isinstance(term, BNode):
        return Variable("_blank_" + re.sub(r"\W", "_", str(term)))
    assert isinstance(term, URIRef | Literal | Variable)
    return term


def _predicate(term: object) -> Predicate:
    if isinstance(term, BNode):
        return Variable("_blank_" + re.sub(r"\W", "_", str(term)))
    assert isinstance(term, URIRef | Variable | Path)
    return term
