"""Skills and primitives that are run by themselves."""
