"""Does everyone get one of their own? A matching of demands to resources, and which of them fall short (Hall 1935)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def short(wanted: Sequence[Iterable[str]]) -> tuple[int, ...]:
    """Returns demands that together could use fewer resources than they are, by index; empty when all can be served.

    Args:
        wanted: For each demand the resources of which it needs one.
    """
    options = [sorted(each) for each in wanted]
    taken: dict[str, int] = {}
    for demand in range(len(options)):
        seen: set[int] = set()
        if not _served(demand, options, taken, seen):
            return tuple(sorted(seen))
    return ()


def _served(demand: int, options: Sequence[Sequence[str]], taken: dict[str, int], seen: set[int]) -> bool:
    """Gives a demand a resource, moving others to different ones where need be."""
    seen.add(demand)
    for resource in options[demand]:
        holder = taken.get(resource)
        if holder is None or (holder not in seen and _served(holder, options, taken, seen)):
            taken[resource] = demand
            return True
    return False
