"""Cycles: terms above themselves, things that are parts of themselves or placed in themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

from skiros_py.world.ontology.check.families import family_relations, place_is_subject
from skiros_py.world.ontology.check.findings import Finding, FindingKind, finding_of
from skiros_py.world.ontology.check.material import Material, Statement
from skiros_py.world.ontology.check.owl import rdfs, sk

__all__ = ["cycles"]

_MANY = 50
"""Cycles reported of one kind: more of them help nobody."""
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
