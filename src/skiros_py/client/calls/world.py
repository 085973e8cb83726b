"""The world as a whole."""

from __future__ import annotations

from skiros_py.api.elements import TreeNode
from skiros_py.api.world import Change, ChangePage, TransactionOrder, UndoOrder, WorldInfo, Written
from skiros_py.client.call import Call


def read_world() -> Call[WorldInfo]:
    """Tells the world's version and what is in it, in numbers."""
    return Call("GET", "/world", WorldInfo)


def read_tree(
    root: str | None = None, *, depth: int | None = None, limit: int | None = None, cursor: str | None = None
) -> Call[TreeNode]:
    """Tells what is placed where and what things are built of.

    Args:
        root: Where to begin; above everything where left out.
        depth: How many levels below it.
        limit: How many children of each node at most.
        cursor: ``next`` of the root as told before.
    """
    query = {"root": root, "depth": depth, "limit": limit, "cursor": cursor}
    return Call("GET", "/tree", TreeNode, query=query)


def list_changes(
    since: int | None = None,
    *,
    newest_first: bool | None = None,
    limit: int | None = None,
    cursor: str | None = None,
) -> Call[ChangePage]:
    """Tells what changed, by whom and why.

    Args:
        since: Only changes after this number.
        newest_first: True to go back in time from the latest.
        limit: How many at most.
        cursor: ``next`` of the page before.
    """
    query = {"since": since, "newest_first": newest_first, "limit": limit, "cursor": cursor}
    return Call("GET", "/world/changes", ChangePage, query=query)


def read_change(number: int, *, limit: int | None = None, cursor: str | None = None) -> Call[Change]:
    """Tells a change with its edits.

    Args:
        number: Its number.
        limit: How many edits at most.
        cursor: ``next`` of what was told before.
    """
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", f"/world/changes/{number:d}", Change, query=query)


def write_transaction(order: TransactionOrder, *, version: int | None = None) -> Call[Written]:
    """Does several writes as one change, or none.

    Args:
        order: What is written, and which versions of elements were seen.
        version: The version of the world that was seen; None for whatever it is now.
    """
    body = order.model_dump(mode="json", by_alias=True, exclude_unset=True)
    seen = "*" if version is None else f'"{version}"'
    return Call(
        "POST",
        "/world/transactions",
        Written,
        json=body,
        headers={"If-Match": seen},
        repeatable=False,
    )


def undo_edit(change: int | None = None) -> Call[Change]:
    """Takes back the last edit that a person made.

    Args:
        change: Only if it is this one.
    """
    body = UndoOrder(change=change).model_dump(mode="json")
    return Call("POST", "/world/undo", Change, json=body, repeatable=False)
