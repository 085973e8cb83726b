"""The REST API of one station, for machines and people (D8 of the design)."""
