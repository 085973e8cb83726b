"""A person's wish that a task ends, on its way through what the task is doing."""

from __future__ import annotations


class StopWanted(Exception):
    """Somebody wants the task to end; its text says why."""
