"""The ontology: files are read, merged and checked; what they declare is never changed at run time."""

from skiros_py.world.ontology.ontology import Ontology, load_installed

__all__ = ["Ontology", "load_installed"]
