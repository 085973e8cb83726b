"""The individuals that the ontology itself describes, as elements."""

from __future__ import annotations

from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Reasoners

__all__ = ["abstract_individuals"]


def abstract_individuals(ontology: Ontology, reasoners: Reasoners) -> Index:
    """Returns the state of a world in which nothing is but what the ontology's files describe."""
    return Index(ontology, reasoners)
