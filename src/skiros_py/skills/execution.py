"""What takes time: a generator that is ticked once per control cycle."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

T = TypeVar("T")

Execution = Generator[None, None, T]
"""A generator that yields once per control cycle while it still runs and returns its result."""


def tick(run: Execution[T]) -> T | None:
    """Runs up to the next ``yield``; returns the result, which must not be None, or None while it goes on."""
    try:
        next(run)
    except StopIteration as end:
        result: T = end.value
        return result
    return None
