"""Individuals in the files: do their relations and values fit domains and ranges?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pyoxigraph as ox

from skiros_py.world.literals import DATATYPES, parse_value
from skiros_py.world.ontology.check.findings import Finding, FindingKind, finding_of
from skiros_py.world.ontology.check.material import Material, Statement
from skiros_py.world.ontology.check.owl import rdfs
from skiros_py.world.ontology.kinds import Kind

__all__ = ["misfits"]


def misfits(material: Material) -> Iterator[Finding]:
    """Finds statements about individuals, and class-level values, that the domain or range does not allow.

    An individual that nobody gives a type is not judged: it may be another file's.
    """
    for relation in material.declared[Kind.RELATION]:
        for end in FindingKind.DOMAIN, FindingKind.RANGE:
            yield from _ends(material, relation, end)
    for property_ in material.declared[Kind.PROPERTY]:
        yield from _ends(material, property_, FindingKind.DOMAIN)
        yield from _values(material, property_)


def _ends(material: Material, property_: str, end: FindingKind) -> Iterator[Finding]:
    wanted = _classes(material, property_, rdfs(end))
    for statement in material.about(property_) if wanted else ():
        one = statement.subject if end is FindingKind.DOMAIN else statement.object
        for class_ in wanted:
            if one is not None and not _is_of(material, one, class_):
                yield _misfit(material, statement, one, class_, end)


def _misfit(material: Material, statement: Statement, one: str, class_: str, end: FindingKind) -> Finding:
    name = material.names.name
    types = f"a {name(one)}" if one in material.declared[Kind.CLASS] else " and ".join(map(name, material.types[one]))
    text = f"{name(statement.predicate)} has {end} {name(class_)}; {name(one)} is {types}"
    return finding_of(statement.fault(text), end, name(one))


def _is_of(material: Material, one: str, class_: str) -> bool:
    """True for an individual of the class, a class below it, and what nobody says anything of."""
    types = [one] if one in material.declared[Kind.CLASS] else material.types.get(one, ())
    return not types or any(class_ in material.ancestors(type_) for type_ in types)


def _values(material: Material, property_: str) -> Iterator[Finding]:
    ranges = [s.object for s in material.said(property_, rdfs("range")) if s.object]
    range_ = material.names.name(ranges[0]) if len(ranges) == 1 else ""
    for statement in material.about(property_):
        problem = _value_problem(material, statement, range_)
        if problem is not None and statement.subject is not None:
            about = material.names.name(statement.subject)
            text = f"{material.names.name(property_)} of {about} {problem}"
            yield finding_of(statement.fault(text), FindingKind.RANGE, about)


def _value_problem(material: Material, statement: Statement, range_: str) -> str | None:
    literal = statement.triple.object
    if not isinstance(literal, ox.Literal):
        return "needs a value, got a thing"
    if range_ not in DATATYPES:
        return None
    try:
        parse_value(literal.value, material.names.name(literal.datatype.value), range_)
    except ValueError as error:
        return str(error)
    return None


def _classes(material: Material, property_: str, word: str) -> Sequence[str]:
    """The named classes that an end must be of; anonymous ones are for OWL reasoners."""
    ends = (statement.object for statement in material.said(property_, word))
    return tuple(end for end in ends if end is not None and end in material.declared[Kind.CLASS])
