"""All faults that can be found without reasoning."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import pyoxigraph as ox

from skiros_py.errors import UnknownName
from skiros_py.world.literals import DATATYPES, parse_value
from skiros_py.world.names import CORE
from skiros_py.world.ontology.check.material import Finding, FindingKind, Material, Severity, finding_of
from skiros_py.world.ontology.check.undeclared import absent_imports, undeclared_terms
from skiros_py.world.ontology.statements import Statement, is_standard
from skiros_py.world.terms import MOST_ABOVE, Kind, closure, cycle, too_deep

_ENDS = {FindingKind.DOMAIN: "rdfs:domain", FindingKind.RANGE: "rdfs:range"}
_THING = "owl:Thing"


def bad_ends(material: Material) -> Iterator[Finding]:
    """Finds domains and ranges that are no class or data type, or that do not fit those of the super-relation."""
    for kind, word in _ENDS.items():
        for statement in material.of(word):
            yield from _end(material, statement, kind)
        yield from _widened(material, kind, word)


def _end(material: Material, statement: Statement, kind: FindingKind) -> Iterator[Finding]:
    subject, end = statement.subject, statement.object
    if subject is None or subject in material.declared[Kind.ANNOTATION]:
        return
    wanted = Kind.DATATYPE if kind is FindingKind.RANGE and subject in material.declared[Kind.PROPERTY] else Kind.CLASS
    if isinstance(statement.triple.object, ox.Literal):
        text = f"the {kind} of {subject} must be a {wanted}, got the text '{statement.triple.object.value[:60]}'"
        yield material.finding(statement, kind, subject, text)
    elif end is not None and not _is_one(material, end, wanted) and not material.is_sought(end):
        text = f"the {kind} of {subject}: {_why(material, end, wanted)}"
        yield material.finding(statement, kind, subject, text, end)


def _is_one(material: Material, end: str, wanted: Kind) -> bool:
    if wanted is Kind.CLASS:
        return end in material.declared[Kind.CLASS] or end == _THING
    return end in material.declared[Kind.DATATYPE] or end in DATATYPES


def _why(material: Material, end: str, wanted: Kind) -> str:
    kinds = material.kinds(end)
    if kinds or is_standard(end):
        return f"{end} is a {kinds[0] if kinds else 'word of the standard'}, not a {wanted}"
    return str(UnknownName(wanted, end, DATATYPES if wanted is Kind.DATATYPE else material.declared[Kind.CLASS]))


def _widened(material: Material, kind: FindingKind, word: str) -> Iterator[Finding]:
    """Finds relations whose end is not below that of the super-relation: both apply, which is rarely intended."""
    ends = {s.subject: s for s in material.of(word) if s.subject and s.object in material.declared[Kind.CLASS]}
    for below, above in sorted(material.pairs("rdfs:subPropertyOf")):
        if below in ends and above in ends:
            own, upper = ends[below].object, ends[above].object
            if own is not None and upper not in material.ancestors(own):
                of_above = f"that of {above} above it: both must hold"
                text = f"the {kind} of {below}, {own}, is not below {upper}, {of_above}"
                yield material.finding(ends[below], kind, below, text, own, severity=Severity.WARNING)


# ---------------------------------------------------------------- individuals


def misfits(material: Material) -> Iterator[Finding]:
    """Finds statements about individuals, and class-level values, that the domain or range does not allow.

    Individuals without a type are skipped: they may be declared in another file.
    """
    for relation in material.declared[Kind.RELATION]:
        for end in FindingKind.DOMAIN, FindingKind.RANGE:
            yield from _ends(material, relation, end)
    for property_ in material.declared[Kind.PROPERTY]:
        yield from _ends(material, property_, FindingKind.DOMAIN)
        yield from _values(material, property_)


def _ends(material: Material, property_: str, end: FindingKind) -> Iterator[Finding]:
    wanted = _classes(material, property_, _ENDS[end])
    for statement in material.of(property_) if wanted else ():
        one = statement.subject if end is FindingKind.DOMAIN else statement.object
        for class_ in wanted:
            if one is not None and not _is_of(material, one, class_):
                yield _misfit(material, statement, one, class_, end)


def _misfit(material: Material, statement: Statement, one: str, class_: str, end: FindingKind) -> Finding:
    types = f"a {one}" if one in material.declared[Kind.CLASS] else " and ".join(material.types[one])
    text = f"{statement.predicate} has {end} {class_}; {one} is {types}"
    return material.finding(statement, end, one, text)


def _is_of(material: Material, one: str, class_: str) -> bool:
    """True for an individual of the class, a class below it, and what has no type."""
    types = [one] if one in material.declared[Kind.CLASS] else material.types.get(one, ())
    return not types or any(class_ in material.ancestors(type_) for type_ in types)


def _values(material: Material, property_: str) -> Iterator[Finding]:
    ranges = material.named(property_, "rdfs:range")
    range_ = ranges[0] if len(ranges) == 1 else ""
    for statement in material.of(property_):
        problem = _value_problem(material, statement, range_)
        if problem is not None and statement.subject is not None:
            text = f"{property_} of {statement.subject} {problem}"
            yield material.finding(statement, FindingKind.RANGE, statement.subject, text)


def _value_problem(material: Material, statement: Statement, range_: str) -> str | None:
    literal = statement.triple.object
    if not isinstance(literal, ox.Literal):
        return "needs a value, got a thing"
    if range_ not in DATATYPES:
        return None
    try:
        parse_value(literal.value, material.key(literal.datatype), range_)
    except ValueError as error:
        return str(error)
    return None


def _classes(material: Material, property_: str, word: str) -> Sequence[str]:
    """The named classes required at an end; anonymous ones are left to OWL reasoners."""
    return [end for end in material.named(property_, word) if end in material.declared[Kind.CLASS]]


_FAMILIES = ("sk:placement", "sk:structure", "sk:computed")
_CORE_IRI = CORE.removesuffix("#")


def house_rules(material: Material) -> Iterator[Finding]:
    """Finds terms that the world model cannot use, or that people cannot understand."""
    yield from _place_ends(material)
    yield from _two_families(material)
    yield from _primary_parents(material)
    yield from _without_words(material)


def family_relations(material: Material, family: str) -> frozenset[str]:
    """Returns the relations of a family, given by its top relation."""
    below: dict[str, list[str]] = {}
    for one, above in material.pairs("rdfs:subPropertyOf"):
        below.setdefault(above, []).append(one)
    return frozenset(closure(below, family)) & material.declared[Kind.RELATION].keys()


def _place_end(material: Material, relation: str) -> str:
    return material.text(relation, "sk:placeEnd")


def _place_ends(material: Material) -> Iterator[Finding]:
    for relation in sorted(family_relations(material, "sk:placement")):
        end = _place_end(material, relation)
        if end not in ("object", "subject"):
            text = f'{relation} is a placement and needs sk:placeEnd "object" or "subject", got {end or "none"}'
            fault = material.at_declaration(relation, text, "sk:placeEnd" if end else None)
            yield finding_of(fault, FindingKind.PLACEMENT, relation)


def _two_families(material: Material) -> Iterator[Finding]:
    families = {family: family_relations(material, family) for family in _FAMILIES}
    for relation in sorted(frozenset[str]().union(*families.values())):
        found = [family for family, relations in families.items() if relation in relations]
        if len(found) > 1:
            text = f"{relation} is below {' and '.join(found)}: a relation is of one family"
            yield finding_of(material.at_declaration(relation, text), FindingKind.PLACEMENT, relation)


def _primary_parents(material: Material) -> Iterator[Finding]:
    for statement in material.of("sk:primaryParent"):
        class_, parent = statement.subject, statement.object
        if class_ is not None and parent not in material.parents.get(class_, ()):
            text = f"sk:primaryParent of {class_} is {parent or 'no class'}, which is none of its superclasses"
            yield material.finding(statement, FindingKind.PARENT, class_, text, parent)


def _without_words(material: Material) -> Iterator[Finding]:
    """Finds terms without label or comment in files that import the upper ontology: the UI shows them."""
    worded = {word: {s.subject for s in material.of(word)} for word in ("rdfs:label", "rdfs:comment")}
    own = {id(d) for d in material.documents if d.iri == _CORE_IRI or _CORE_IRI in d.imports()}
    for kind in (Kind.CLASS, Kind.RELATION, Kind.PROPERTY):
        for term, document in material.declared[kind].items():
            missing = [word for word, terms in worded.items() if term not in terms]
            if missing and id(document) in own and not term.startswith("owl:"):
                fault = document.fault(f"{term} has no {' and no '.join(missing)}", material.iri(term))
                yield finding_of(fault, FindingKind.UNEXPLAINED, term, severity=Severity.WARNING)


# ---------------------------------------------------------------- cycles


_MANY = 50
"""Maximum number of cycles reported of one kind."""
_SHOWN = 50
"""Maximum number of statements shown of one cycle."""

_Edges = dict[tuple[str, str], Statement]


def cycles(material: Material) -> Iterator[Finding]:
    """Finds cycles of superclasses, of super-relations, of pieces and of placements."""
    for word, says in (("rdfs:subClassOf", "is a subclass of"), ("rdfs:subPropertyOf", "is a sub-property of")):
        yield from _cycles(material, _edges(material, {word: False}), says)
    yield from _cycles(material, _edges(material, _oriented(material, "sk:structure")), "is built of")
    yield from _cycles(material, _edges(material, _oriented(material, "sk:placement")), "is placed at")


def _oriented(material: Material, family: str) -> dict[str, bool]:
    """The relations of a family, and whether each points from the place to the thing."""
    relations = sorted(family_relations(material, family))
    return {relation: _place_end(material, relation) == "subject" for relation in relations}


def _edges(material: Material, words: Mapping[str, bool]) -> _Edges:
    edges: _Edges = {}
    for word, turned in words.items():
        for statement in material.of(word):
            one, other = statement.subject, statement.object
            if one is not None and other is not None:
                edges.setdefault((other, one) if turned else (one, other), statement)
    return edges


def _cycles(material: Material, edges: _Edges, says: str) -> Iterator[Finding]:
    for _ in range(_MANY):
        found = cycle(_adjacent(sorted(edges)))
        if not found:
            return
        start = found.index(min(found))  # the same first name wherever the search began
        ring = [*found[start:-1], *found[: start + 1]]
        yield _finding(material, edges, ring, says)
        del edges[ring[0], ring[1]]


def _adjacent(edges: Iterable[tuple[str, str]]) -> Mapping[str, Sequence[str]]:
    above: dict[str, list[str]] = defaultdict(list)
    for one, other in edges:
        above[one].append(other)
    return above


def _finding(material: Material, edges: _Edges, names: list[str], says: str) -> Finding:
    why = []
    for one, other in pairwise(names[: _SHOWN + 1]):
        statement = edges[one, other]
        fault = material.fault_in(statement, "", statement.object)
        why.append(f"{one} {says} {other} ({str(fault).removesuffix(': ')})")
    fault_at = edges[names[0], names[1]]
    if len(names) > _SHOWN + 1:
        why.append(f"… and so on, {len(names) - 1} statements in all")
        names = [*names[:_SHOWN], "…", names[-1]]
    text = f"{f' {says} '.join(names)}: a cycle"
    return finding_of(material.fault_in(fault_at, text, names[1]), FindingKind.CYCLE, names[0], why=tuple(why))


# ---------------------------------------------------------------- depth


def depths(material: Material) -> Iterator[Finding]:
    """Finds the first class and the first relation or property with too many above it, unless a cycle explains it."""
    for word in "rdfs:subClassOf", "rdfs:subPropertyOf":
        above = _adjacent(material.pairs(word))
        deep = too_deep(above)
        if deep is not None and not cycle(above):
            text = f"{deep} has more than {MOST_ABOVE} terms above it by {word}"
            yield material.finding(material.about(deep)[word][0], FindingKind.DEPTH, deep, text)


# ---------------------------------------------------------------- all structural checks


def structural_findings(material: Material) -> list[Finding]:
    """Returns the faults in the declarations and statements of the files."""
    checks = (undeclared_terms, bad_ends, cycles, depths, house_rules, misfits, absent_imports)
    return [finding for check in checks for finding in check(material)]
