"""The door for machines and people: the REST API of one station (D8 of the design)."""
