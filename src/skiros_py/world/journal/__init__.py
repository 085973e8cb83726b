"""The journal: a world in a data directory, from which nothing that was acknowledged is lost."""
