"""Orders of terms: what is above what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from graphlib import CycleError, TopologicalSorter

__all__ = ["closure", "cycle", "inverse"]


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


def inverse(lines: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Returns for each name itself and all below it, sorted after the first, given each with all above it."""
    below: dict[str, list[str]] = {name: [name] for name in lines}
    for name in sorted(lines):
        for above in lines[name][1:]:
            below[above].append(name)
    return {name: tuple(names) for name, names in below.items()}
