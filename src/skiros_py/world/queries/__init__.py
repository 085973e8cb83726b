"""SPARQL over ontology, scene and what was learned, for people and outside programs; never for the control cycle."""
