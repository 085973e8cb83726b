"""Parts of primitives outside a control cycle."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any


def run(steps: Generator[None, None, Any]) -> Any:
    """Runs steps to their end, as if no time passed between them; returns what they return."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value
