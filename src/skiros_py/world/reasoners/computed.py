"""Computed relations, as answers of a world view: worked out on demand for the elements that come into question."""

from __future__ import annotations

from typing import TYPE_CHECKING

from skiros_py.world.vocabulary import ELEMENT

if TYPE_CHECKING:
    from skiros_py.world.view import WorldView

__all__ = ["computed_objects", "computed_subjects"]


def computed_objects(view: WorldView, subject: str, relation: str) -> tuple[str, ...]:
    """Returns ids of the scene's elements to which a computed relation holds, sorted.

    Raises:
        UnknownName: There is no such element, or no reasoner computes the relation.
    """
    view.element(subject)
    found: set[str] = set()
    for below in view.reasoners.narrowest(view.ontology, relation):
        candidates = view.instances(view.ontology.relation(below).range or ELEMENT)
        found.update(o for _, o in view.reasoners.pairs(view, below, (subject,), candidates))
    return tuple(sorted(found))


def computed_subjects(view: WorldView, relation: str, object_: str) -> tuple[str, ...]:
    """Returns ids of the scene's elements from which a computed relation holds, sorted.

    Raises:
        UnknownName: There is no such element, or no reasoner computes the relation.
    """
    view.element(object_)
    found: set[str] = set()
    for below in view.reasoners.narrowest(view.ontology, relation):
        candidates = view.instances(view.ontology.relation(below).domain or ELEMENT)
        found.update(s for s, _ in view.reasoners.pairs(view, below, candidates, (object_,)))
    return tuple(sorted(found))
