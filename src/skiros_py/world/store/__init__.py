"""The same content as RDF triples, for SPARQL."""

from skiros_py.world.store.projection import Projection, TripleStore
from skiros_py.world.store.store import QuadStore

__all__ = ["Projection", "QuadStore", "TripleStore"]
