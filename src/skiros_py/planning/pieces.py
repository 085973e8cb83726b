"""Long work in pieces: a generator that yields wherever it may be left for a while, so that others can go on."""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import TypeVar

__all__ = ["T", "Work", "at_once", "in_slices"]

T = TypeVar("T")

Work = Generator[None, None, T]
"""Work that yields between its pieces and returns its result."""

_SLICE = 0.005
"""So long work goes on at a stretch, in a control cycle of a tenth of a second [s]."""


def at_once(work: Work[T]) -> T:
    """Does work without a pause."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def in_slices(work: Work[T], seconds: float = _SLICE) -> Work[T]:
    """Does work of many small pieces; yields only where it went on for a while.

    Args:
        work: The work; what it does does not depend on when it is left.
        seconds: How long it goes on at a stretch; longer where a piece takes longer [s].
    """
    started = time.perf_counter()
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        if time.perf_counter() - started >= seconds:
            yield
            started = time.perf_counter()
