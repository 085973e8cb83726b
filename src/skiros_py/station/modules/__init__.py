"""Skills and primitives that are run singly, outside of tasks."""
