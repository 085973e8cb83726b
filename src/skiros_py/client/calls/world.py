"""The world as a whole, taught data, locks, and SPARQL queries."""

from __future__ import annotations

from collections.abc import Sequence

from httpx2 import Response
from pydantic import TypeAdapter

from skiros_py.api.queries import AskAnswer, ConstructAnswer, Query, QueryAnswer, SelectAnswer
from skiros_py.api.view import WorldView
from skiros_py.api.world import (
    Change,
    ChangePage,
    LearnedPage,
    LockList,
    LockOrder,
    TransactionOrder,
    TreeNode,
    UndoOrder,
    WorldInfo,
    Written,
)
from skiros_py.client.request import Call, if_match, path_of


def read_world() -> Call[WorldInfo]:
    """Returns the world's version and element counts."""
    return Call("GET", "/world", WorldInfo)


def read_tree(
    root: str | None = None, *, depth: int | None = None, limit: int | None = None, cursor: str | None = None
) -> Call[TreeNode]:
    """Returns the tree of placements and parts.

    Args:
        root: The root element; by default, the root of the world.
        depth: How many levels below it.
        limit: Maximum number of children per node.
        cursor: ``next`` of the root from an earlier call.
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
    """Returns changes with their authors and reasons.

    Args:
        since: Only changes after this number.
        newest_first: True to go back in time from the latest.
        limit: How many at most.
        cursor: ``next`` of the previous page.
    """
    query = {"since": since, "newest_first": newest_first, "limit": limit, "cursor": cursor}
    return Call("GET", "/world/changes", ChangePage, query=query)


def read_change(number: int, *, limit: int | None = None, cursor: str | None = None) -> Call[Change]:
    """Returns a change with its edits.

    Args:
        number: Its number.
        limit: How many edits at most.
        cursor: ``next`` of an earlier call.
    """
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", f"/world/changes/{number:d}", Change, query=query)


def write_transaction(order: TransactionOrder, *, version: int | None = None) -> Call[Written]:
    """Applies several writes as one change, all or none.

    Args:
        order: The writes, and the expected versions of elements.
        version: The version of the world that was seen; None for whatever it is now.
    """
    body = order.model_dump(mode="json", by_alias=True, exclude_unset=True)
    return Call(
        "POST",
        "/world/transactions",
        Written,
        json=body,
        headers=if_match(version, "*"),
        repeatable=False,
    )


def undo_edit(change: int | None = None) -> Call[Change]:
    """Undoes the last edit made by a user.

    Args:
        change: Only if it is this one.
    """
    body = UndoOrder(change=change).model_dump(mode="json")
    return Call("POST", "/world/undo", Change, json=body, repeatable=False)


def read_view(elements: Sequence[str] | None = None) -> Call[WorldView]:
    """Returns the believed poses and the shapes of all elements.

    Args:
        elements: Only these, with what moves or disappears with them, at most 100; by default everything.
    """
    query = {"element": None if elements is None else list(elements)}
    return Call("GET", "/view", WorldView, query=query)


def list_learned(*, limit: int | None = None, cursor: str | None = None) -> Call[LearnedPage]:
    """Lists the data taught to robots."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/learned", LearnedPage, query=query)


def forget_learned(element: str, *, version: int | None = None, reason: str | None = None) -> Call[Written]:
    """Deletes a taught element with its parts; an undo restores it.

    Args:
        element: Its id.
        version: The version that was seen; None for whatever it is now.
        reason: Why.
    """
    return Call(
        "DELETE",
        path_of("learned", element),
        Written,
        query={"reason": reason},
        headers=if_match(version, "*"),
        repeatable=False,
    )


def export_learned() -> Call[str]:
    """Returns all learned data as Turtle text."""
    return Call("GET", "/learned.ttl", lambda r: r.text)


def list_locks() -> Call[LockList]:
    """Returns the edit locks."""
    return Call("GET", "/locks", LockList)


def lock_elements(order: LockOrder) -> Call[LockList]:
    """Locks elements against edits by other users and jobs for a while; calling it again extends the lock."""
    return Call("POST", "/locks", LockList, json=order.model_dump(mode="json"))


def end_locks(elements: Sequence[str] | None = None, *, owner: str | None = None) -> Call[LockList]:
    """Releases the caller's locks and returns the remaining ones.

    Args:
        elements: The elements; by default all.
        owner: Owner of the locks; only an admin may release those of others.
    """
    query = {"elements": None if elements is None else list(elements), "owner": owner}
    return Call("DELETE", "/locks", LockList, query=query)


_ANSWER: TypeAdapter[SelectAnswer | AskAnswer | ConstructAnswer] = TypeAdapter(QueryAnswer)


def ask_question(question: Query) -> Call[SelectAnswer | AskAnswer | ConstructAnswer]:
    """Runs a SELECT, ASK or CONSTRUCT query."""
    return Call("POST", "/queries", _answer, json=question.model_dump(mode="json"))


def _answer(response: Response) -> SelectAnswer | AskAnswer | ConstructAnswer:
    return _ANSWER.validate_python(response.json())
