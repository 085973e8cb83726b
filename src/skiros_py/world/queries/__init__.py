"""SPARQL over ontology and scene, for people and outside programs; never for the control cycle."""

from skiros_py.world.queries.queries import Text, ask, select

__all__ = ["Text", "ask", "select"]
