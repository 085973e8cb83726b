"""Depth: hierarchies that are too deep to be meant, and to be read."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from skiros_py.world.ontology.check.findings import Finding, FindingKind, finding_of
from skiros_py.world.ontology.check.material import Material
from skiros_py.world.ontology.check.owl import rdfs
from skiros_py.world.ontology.hierarchy import MOST_ABOVE, cycle, too_deep

__all__ = ["depths"]


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
