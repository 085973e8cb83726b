"""The same content as RDF triples, for SPARQL."""

from skiros_py.world.store.projection import TripleStore

__all__ = ["TripleStore"]
