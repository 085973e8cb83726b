"""Orders of terms: what is above what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from graphlib import CycleError, TopologicalSorter

__all__ = ["MOST_ABOVE", "closure", "cycle", "inverse", "too_deep"]

MOST_ABOVE = 500
"""Terms that may be above another: a chain of so many levels was made by no person, and costs its square."""


def closure(above: Mapping[str, Sequence[str]], name: str) -> tuple[str, ...]:
    """Returns a name and all above it, depth first, each once."""
    line: dict[str, None] = {}
    waiting = [name]
    while waiting:
        current = waiting.pop()
        if current not in line:
            line[current] = None
            waiting.extend(reversed(above[current]))
    return tuple(line)


def cycle(above: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Returns names each of which is below the next, the last being the first again; nothing where there is none."""
    try:
        TopologicalSorter(above).prepare()
    except CycleError as error:
        return tuple(reversed(error.args[1]))
    return ()


def too_deep(above: Mapping[str, Sequence[str]]) -> str | None:
    """Returns the first name with more than :data:`MOST_ABOVE` above it, or None where there is none."""
    return next((name for name in above if _has_many(above, name)), None)


def _has_many(above: Mapping[str, Sequence[str]], name: str) -> bool:
    reached = {name}
    waiting = [name]
    while waiting and len(reached) <= MOST_ABOVE + 1:
        new = [upper for upper in above.get(waiting.pop(), ()) if upper not in reached]
        reached.update(new)
        waiting.extend(new)
    return len(reached) > MOST_ABOVE + 1


def inverse(lines: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Returns for each name itself and all below it, sorted after the first, given each with all above it."""
    below: dict[str, list[str]] = {name: [name] for name in lines}
    for name in sorted(lines):
        for above in lines[name][1:]:
            below[above].append(name)
    return {name: tuple(names) for name, names in below.items()}
