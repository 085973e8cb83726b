"""SPARQL over ontology, scene and what was learned, for people and outside programs; never for the control cycle."""

from skiros_py.world.queries.answering import Constructed, Result, Table
from skiros_py.world.queries.queries import ask, construct, query, select
from skiros_py.world.queries.terms import Binding, Text

__all__ = ["Binding", "Constructed", "Result", "Table", "Text", "ask", "construct", "query", "select"]
