"""SPARQL over ontology, scene and what was learned, for people and outside programs; never for the control cycle."""

from skiros_py.world.queries.answering import (
    Binding,
    Constructed,
    Result,
    Table,
    Text,
    ask,
    construct,
    query,
    select,
)

__all__ = ["Binding", "Constructed", "Result", "Table", "Text", "ask", "construct", "query", "select"]
