"""Checks ontology files: their declarations, and whether they are consistent."""
