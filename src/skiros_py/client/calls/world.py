"""The world as a whole, what robots were taught, locks, and questions in SPARQL."""

from __future__ import annotations

from collections.abc import Sequence

from httpx2 import Response
from pydantic import TypeAdapter

from skiros_py.api.elements import TreeNode
from skiros_py.api.queries import AskAnswer, ConstructAnswer, Query, QueryAnswer, SelectAnswer
from skiros_py.api.view import WorldView
from skiros_py.api.world import (
    Change,
    ChangePage,
    LearnedPage,
    LockList,
    LockOrder,
    TransactionOrder,
    UndoOrder,
    WorldInfo,
    Written,
)
from skiros_py.client.call import Call, if_match, path_of


def read_world() -> Call[WorldInfo]:
    """Tells the world's version and what is in it, in numbers."""
    return Call("GET", "/world", WorldInfo)


def read_tree(
    root: str | None = None, *, depth: int | None = None, limit: int | None = None, cursor: str | None = None
) -> Call[TreeNode]:
    """Returns what is placed where and what things are built of.

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
    """Returns what changed, by whom and why.

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
    return Call(
        "POST",
        "/world/transactions",
        Written,
        json=body,
        headers=if_match(version, "*"),
        repeatable=False,
    )


def undo_edit(change: int | None = None) -> Call[Change]:
    """Takes back the last edit that a person made.

    Args:
        change: Only if it is this one.
    """
    body = UndoOrder(change=change).model_dump(mode="json")
    return Call("POST", "/world/undo", Change, json=body, repeatable=False)


def read_view(elements: Sequence[str] | None = None) -> Call[WorldView]:
    """Returns where everything is believed to be, and what it looks like.

    Args:
        elements: Only these, with what moves or is gone with them, at most 100; everything where left out.
    """
    query = {"element": None if elements is None else list(elements)}
    return Call("GET", "/view", WorldView, query=query)


def list_learned(*, limit: int | None = None, cursor: str | None = None) -> Call[LearnedPage]:
    """Lists what robots were taught."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/learned", LearnedPage, query=query)


def forget_learned(element: str, *, version: int | None = None, reason: str | None = None) -> Call[Written]:
    """Forgets something with its pieces; an undo brings it back.

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
    """Returns everything that was learned as the text of a Turtle file."""
    return Call("GET", "/learned.ttl", lambda r: r.text)


def list_locks() -> Call[LockList]:
    """Returns who alone may edit which elements."""
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


_ANSWER: TypeAdapter[SelectAnswer | AskAnswer | ConstructAnswer] = TypeAdapter(QueryAnswer)


def ask_question(question: Query) -> Call[SelectAnswer | AskAnswer | ConstructAnswer]:
    """Answers SELECT, ASK or CONSTRUCT."""
    return Call("POST", "/queries", _answer, json=question.model_dump(mode="json"))


def _answer(response: Response) -> SelectAnswer | AskAnswer | ConstructAnswer:
    return _ANSWER.validate_python(response.json())
