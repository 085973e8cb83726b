"""All that can be found without reasoning: every finding, not only the first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from itertools import chain, pairwise

import pyoxigraph as ox

from skiros_py.errors import UnknownName
from skiros_py.world.literals import DATATYPES, parse_value
from skiros_py.world.names import CORE
from skiros_py.world.ontology.check.material import (
    Finding,
    FindingKind,
    Material,
    Severity,
    Statement,
    finding_of,
    is_standard,
    owl,
    rdfs,
    sk,
)
from skiros_py.world.ontology.check.undeclared import undeclared_terms
from skiros_py.world.terms import MOST_ABOVE, Kind, closure, cycle, too_deep

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


_FAMILIES = (sk("placement"), sk("structure"), sk("computed"))
_CORE_IRI = CORE.removesuffix("#")


def house_rules(material: Material) -> Iterator[Finding]:
    """Finds what the world model could not use, and what people could not read."""
    yield from _place_ends(material)
    yield from _two_families(material)
    yield from _primary_parents(material)
    yield from _without_words(material)


def family_relations(material: Material, family: str) -> frozenset[str]:
    """Returns the relations of a family, given by its top relation (IRI)."""
    below: dict[str, list[str]] = {}
    for one, above in material.pairs(rdfs("subPropertyOf")):
        below.setdefault(above, []).append(one)
    return frozenset(closure(below, family)) & material.declared[Kind.RELATION].keys()


def place_is_subject(material: Material, relation: str) -> bool:
    """Returns True when the subject of a placement relation is the place."""
    return _place_end(material, relation) == "subject"


def _place_end(material: Material, relation: str) -> str | None:
    for statement in material.said(relation, sk("placeEnd")):
        if isinstance(statement.triple.object, ox.Literal):
            return str(statement.triple.object.value)
    return None


def _place_ends(material: Material) -> Iterator[Finding]:
    for relation in sorted(family_relations(material, sk("placement"))):
        end = _place_end(material, relation)
        if end not in ("object", "subject"):
            name = material.names.name(relation)
            text = f'{name} is a placement and needs sk:placeEnd "object" or "subject", got {end or "none"}'
            fault = material.declared[Kind.RELATION][relation].fault(text, relation, sk("placeEnd") if end else None)
            yield finding_of(fault, FindingKind.PLACEMENT, name)


def _two_families(material: Material) -> Iterator[Finding]:
    families = {family: family_relations(material, family) for family in _FAMILIES}
    for relation in sorted(frozenset[str]().union(*families.values())):
        found = [material.names.name(family) for family, relations in families.items() if relation in relations]
        if len(found) > 1:
            name = material.names.name(relation)
            text = f"{name} is below {' and '.join(found)}: a relation is of one family"
            fault = material.declared[Kind.RELATION][relation].fault(text, relation)
            yield finding_of(fault, FindingKind.PLACEMENT, name)


def _primary_parents(material: Material) -> Iterator[Finding]:
    for statement in material.about(sk("primaryParent")):
        class_, parent = statement.subject, statement.object
        if class_ is None or parent in material.parents.get(class_, ()):
            continue
        name = material.names.name(class_)
        shown = material.names.name(parent) if parent else "no class"
        text = f"sk:primaryParent of {name} is {shown}, which is none of its superclasses"
        yield finding_of(statement.fault(text, parent), FindingKind.PARENT, name)


def _without_words(material: Material) -> Iterator[Finding]:
    """Finds terms without label or comment, in files that build on the upper ontology: people meet these in the UI."""
    worded = {word: {s.subject for s in material.about(word)} for word in (rdfs("label"), rdfs("comment"))}
    own = {id(d) for d in material.documents if d.iri == _CORE_IRI or _CORE_IRI in d.imports()}
    for kind in (Kind.CLASS, Kind.RELATION, Kind.PROPERTY):
        for term, document in material.declared[kind].items():
            missing = [material.names.name(word) for word, terms in worded.items() if term not in terms]
            if missing and id(document) in own and not term.startswith(owl("")):
                name = material.names.name(term)
                fault = document.fault(f"{name} has no {' and no '.join(missing)}", term)
                yield finding_of(fault, FindingKind.UNEXPLAINED, name, severity=Severity.WARNING)


# ---------------------------------------------------------------- cycles


_MANY = 50
"""Cycles reported of one kind."""
_SHOWN = 50
"""Statements of one cycle that are shown."""

_Edges = dict[tuple[str, str], Statement]


def cycles(material: Material) -> Iterator[Finding]:
    """Finds cycles of superclasses, of super-relations, of pieces and of placements."""
    for word, says in ((rdfs("subClassOf"), "is a subclass of"), (rdfs("subPropertyOf"), "is a sub-property of")):
        yield from _cycles(material, _edges(material, {word: False}), says)
    yield from _cycles(material, _edges(material, _oriented(material, sk("structure"))), "is built of")
    yield from _cycles(material, _edges(material, _oriented(material, sk("placement"))), "is placed at")


def _oriented(material: Material, family: str) -> dict[str, bool]:
    """The relations of a family, and whether each points from the place to the thing."""
    return {relation: place_is_subject(material, relation) for relation in sorted(family_relations(material, family))}


def _edges(material: Material, words: Mapping[str, bool]) -> _Edges:
    edges: _Edges = {}
    for word, turned in words.items():
        for statement in material.about(word):
            one, other = statement.subject, statement.object
            if one is not None and other is not None:
                edges.setdefault((other, one) if turned else (one, other), statement)
    return edges


def _cycles(material: Material, edges: _Edges, says: str) -> Iterator[Finding]:
    for _ in range(_MANY):
        cycle = _one_cycle(edges)
        if cycle is None:
            return
        yield _finding(material, edges, cycle, says)
        del edges[cycle[0], cycle[1]]


def _one_cycle(edges: _Edges) -> list[str] | None:
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for above, below in sorted(edges):
        sorter.add(below, above)
    try:
        sorter.prepare()
    except CycleError as error:
        found: list[str] = error.args[1]
        # It always starts at its first name in order, however it was come upon.
        start = found.index(min(found[:-1]))
        ring = found[start:-1] + found[:start]
        return [*ring, ring[0]]
    return None


def _finding(material: Material, edges: _Edges, cycle: list[str], says: str) -> Finding:
    names = [material.names.name(term) for term in cycle]
    why = []
    for one, other in pairwise(cycle[: _SHOWN + 1]):
        statement = edges[one, other]
        fault = statement.fault("", statement.object)
        why.append(f"{material.names.name(one)} {says} {material.names.name(other)} ({str(fault).removesuffix(': ')})")
    if len(names) > _SHOWN + 1:
        why.append(f"… and so on, {len(names) - 1} statements in all")
        names = [*names[:_SHOWN], "…", names[-1]]
    fault = edges[cycle[0], cycle[1]].fault(f"{f' {says} '.join(names)}: a cycle", cycle[1])
    return finding_of(fault, FindingKind.CYCLE, names[0], why=tuple(why))


# ---------------------------------------------------------------- depth


def depths(material: Material) -> Iterator[Finding]:
    """Finds the first class and the first relation or property with too many above it, unless a cycle explains it."""
    for word in rdfs("subClassOf"), rdfs("subPropertyOf"):
        above = _above(material, word)
        deep = too_deep(above)
        if deep is not None and not cycle(above):
            name = material.names.name(deep)
            text = f"{name} has more than {MOST_ABOVE} terms above it by {material.names.name(word)}"
            yield finding_of(material.said(deep, word)[0].fault(text), FindingKind.DEPTH, name)


def _above(material: Material, word: str) -> Mapping[str, Sequence[str]]:
    above: dict[str, list[str]] = defaultdict(list)
    for one, other in material.pairs(word):
        above[one].append(other)
    return above


# ---------------------------------------------------------------- all structural checks


_CHECKS: tuple[Callable[[Material], Iterator[Finding]], ...] = (
    undeclared_terms,
    bad_ends,
    cycles,
    depths,
    house_rules,
    misfits,
)


def structural_findings(material: Material) -> list[Finding]:
    """Returns what is wrong with the declarations and statements of the files as they stand."""
    return list(chain.from_iterable(check(material) for check in _CHECKS))
