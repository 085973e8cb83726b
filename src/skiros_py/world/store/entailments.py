"""What OWL 2 RL entails from ontology and scene: inverses, symmetry, transitivity, equivalence, sub-terms."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import pyoxigraph as ox

from skiros_py.world.store.store import INFERRED_GRAPH, QuadStore

__all__ = ["entailed_store"]


def entailed_store(stated: QuadStore, new: Callable[[], QuadStore]) -> QuadStore:
    """Returns a new store with all that is stated, and in the graph of what is inferred all that follows.

    Args:
        stated: What is stated.
        new: Makes an empty store.
    """
    quads = stated.quads()
    store = new()
    store.bulk_load(quads)
    store.bulk_load(_entailed(quads))
    return store


def _entailed(quads: Sequence[ox.Quad]) -> Iterator[ox.Quad]:
    from reasonable import PyReasoner  # with rdflib, which most queries do without

    from skiros_py.world.store.rdflib_memory import to_rdflib, triple_of

    stated = {(to_rdflib(q.subject), to_rdflib(q.predicate), to_rdflib(q.object)) for q in quads}
    reasoner = PyReasoner()
    reasoner.from_graph(list(stated))
    for triple in reasoner.reason():
        if triple not in stated and triple[0] != triple[2]:  # that everything is the same as itself helps nobody
            found = triple_of(triple)
            yield ox.Quad(found.subject, found.predicate, found.object, INFERRED_GRAPH)
