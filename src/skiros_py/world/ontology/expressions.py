"""Class expressions of OWL as far as a world is read by them: unions, intersections, numbers, "some" and "only".

Everything else (complements, enumerations) stays in the graph for OWL reasoners.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pyoxigraph as ox

from skiros_py.world.ontology.statements import Node, Statements
from skiros_py.world.terms import Cardinality, End, Filler

__all__ = ["cardinalities", "conjuncts", "end", "fillers"]

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
    waiting, seen = [expression], set[Node]()
    while waiting:
        node = waiting.pop(0)
        if node in seen:
            continue
        seen.add(node)
        lists = _said(statements, node, "owl:intersectionOf")
        if not lists:
            yield node
        for list_ in lists:
            waiting += statements.members(list_)


def end(statements: Statements, expressions: list[Node], known: Callable[[str], bool]) -> End:
    """Returns what several expressions together allow at an end of a relation.

    Args:
        statements: All statements.
        expressions: Domains or ranges: all must be met.
        known: Tells whether a name stands for a class that can be checked, or raises.
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
    """The class or data type that is counted; "" for all, None where it has no name."""
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
    """The classes of which one is enough; none where that cannot be said by names, and so nothing is asked."""
    waiting, names, seen = [node], set[str](), set[Node]()
    while waiting:
        current = waiting.pop()
        if current in seen:
            continue
        seen.add(current)
        lists = _said(statements, current, "owl:unionOf")
        if lists:
            waiting += [member for list_ in lists for member in statements.members(list_)]
        elif isinstance(current, ox.NamedNode) and known(statements.key(current)):
            names.add(statements.key(current))
        else:
            return ()
    return tuple(sorted(names))


def _said(statements: Statements, node: Node, predicate: str) -> list[Node]:
    """Objects of a predicate of an anonymous node."""
    return list(statements.objects(statements.key(node), predicate)) if isinstance(node, ox.BlankNode) else []
