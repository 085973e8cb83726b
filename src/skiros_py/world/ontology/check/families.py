"""What the upper ontology asks of terms: place ends, one family, primary parents, words for people."""

from __future__ import annotations

from collections.abc import Iterator

import pyoxigraph as ox

from skiros_py.world.names import CORE
from skiros_py.world.ontology.check.findings import Finding, FindingKind, Severity, finding_of
from skiros_py.world.ontology.check.material import Material, closure
from skiros_py.world.ontology.check.owl import owl, rdfs, sk
from skiros_py.world.ontology.kinds import Kind

__all__ = ["family_relations", "house_rules", "place_is_subject"]

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
    return closure([family], below) & material.declared[Kind.RELATION].keys()


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
