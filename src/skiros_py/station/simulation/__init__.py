"""Bodies of a running simulation."""
