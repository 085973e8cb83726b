"""Domains and ranges: are they classes and data types, and do those of a sub-relation fit its super-relation?"""

from __future__ import annotations

from collections.abc import Iterator

import pyoxigraph as ox

from skiros_py.errors import UnknownName
from skiros_py.world.literals import DATATYPES
from skiros_py.world.ontology.check.findings import Finding, FindingKind, Severity, finding_of
from skiros_py.world.ontology.check.material import Material, Statement
from skiros_py.world.ontology.check.owl import is_standard, owl, rdfs
from skiros_py.world.ontology.kinds import Kind

__all__ = ["bad_ends"]

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
