"""The ontology: files are read, merged and checked; what they declare is never changed at run time."""

from skiros_py.world.ontology.installed import load_installed
from skiros_py.world.ontology.ontology import Ontology

__all__ = ["Ontology", "load_installed"]
