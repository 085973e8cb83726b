"""Domains and ranges: are they classes and data types, and do relations and values of individuals fit them?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pyoxigraph as ox

from skiros_py.errors import UnknownName
from skiros_py.world.literals import DATATYPES, parse_value
from skiros_py.world.ontology.check.findings import Finding, FindingKind, Severity, finding_of
from skiros_py.world.ontology.check.material import Material, Statement, is_standard, owl, rdfs
from skiros_py.world.terms import Kind

_ENDS = {FindingKind.DOMAIN: rdfs("domain"), FindingKind.RANGE: rdfs("range")}
_THING = owl("Thing")


def bad_ends(material: Material) -> Iterator[Finding]:
    """Finds domains and ranges that are no class or data type, or that no sub-relation can meet."""
    for kind, word in _ENDS.items():
        for statement in material.about(word):
            yield from _end(material, statement, kind)
        yield from _widened(material, kind, word)


def _end(material: Material, statement: Statement, kind: FindingKind) -> Iterator[Finding]:
    subject, end = statement.subject, statement.object
    if subject is None or subject in material.declared[Kind.ANNOTATION]:
        return
    name = material.names.name(subject)
    wanted = Kind.DATATYPE if kind is FindingKind.RANGE and subject in material.declared[Kind.PROPERTY] else Kind.CLASS
    if isinstance(statement.triple.object, ox.Literal):
        text = f"the {kind} of {name} must be a {wanted}, got the text '{statement.triple.object.value[:60]}'"
        yield finding_of(statement.fault(text), kind, name)
    elif end is not None and not _is_one(material, end, wanted):
        yield finding_of(statement.fault(f"the {kind} of {name}: {_why(material, end, wanted)}", end), kind, name)


def _is_one(material: Material, end: str, wanted: Kind) -> bool:
    if wanted is Kind.CLASS:
        return end in material.declared[Kind.CLASS] or end == _THING
    return end in material.declared[Kind.DATATYPE] or material.names.name(end) in DATATYPES


def _why(material: Material, end: str, wanted: Kind) -> str:
    name = material.names.name(end)
    kinds = material.kinds_of(end)
    if kinds or is_standard(end):
        return f"{name} is a {kinds[0] if kinds else 'word of the standard'}, not a {wanted}"
    known = DATATYPES if wanted is Kind.DATATYPE else map(material.names.name, material.declared[Kind.CLASS])
    return str(UnknownName(wanted, name, known))


def _widened(material: Material, kind: FindingKind, word: str) -> Iterator[Finding]:
    """Finds relations whose end is apart from that of the relation above: both must hold, which is hardly meant."""
    ends = {s.subject: s for s in material.about(word) if s.subject and s.object in material.declared[Kind.CLASS]}
    for below, above in sorted(material.pairs(rdfs("subPropertyOf"))):
        if below in ends and above in ends:
            own, upper = ends[below].object, ends[above].object
            assert own is not None
            assert upper is not None
            if upper not in material.ancestors(own):
                yield _apart(material, ends[below], kind, above, (own, upper))


def _apart(material: Material, statement: Statement, kind: FindingKind, above: str, ends: tuple[str, str]) -> Finding:
    name = material.names.name
    own, upper = name(ends[0]), name(ends[1])
    below = name(statement.subject or "")
    text = f"the {kind} of {below}, {own}, is not below {upper}, that of {name(above)} above it: both must hold"
    return finding_of(statement.fault(text, ends[0]), kind, below, severity=Severity.WARNING)


# ---------------------------------------------------------------- individuals


def misfits(material: Material) -> Iterator[Finding]:
    """Finds statements about individuals, and class-level values, that the domain or range does not allow.

    An individual without a type is not judged: it may be another file's.
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
    """True for an individual of the class, a class below it, and what has no type."""
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
