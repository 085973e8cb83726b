"""Locks: being the only one who edits."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.locks import LockList, LockOrder
from skiros_py.client.call import Call


def list_locks() -> Call[LockList]:
    """Tells who alone may edit which elements."""
    return Call("GET", "/locks", LockList)


def lock_elements(order: LockOrder) -> Call[LockList]:
    """Keeps other people and jobs from editing elements for a while; again, it lasts longer."""
    return Call("POST", "/locks", LockList, json=order.model_dump(mode="json"))


def end_locks(elements: Sequence[str] | None = None, *, owner: str | None = None) -> Call[LockList]:
    """Ends one's own locks, and answers with those that are left.

    Args:
        elements: On which elements; all where left out.
        owner: Whose; those of others only an admin ends.
    """
    query = {"elements": None if elements is None else list(elements), "owner": owner}
    return Call("DELETE", "/locks", LockList, query=query)
