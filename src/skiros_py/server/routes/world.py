"""Routes: the world as a whole, locks, and the visible world."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import Header, Path, Query, Response

from skiros_py.api import world as api
from skiros_py.api.transactions import TransactionOrder
from skiros_py.api.view import WorldView
from skiros_py.errors import UsageError
from skiros_py.server.access.roles import Operator, Role, Viewer
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, also_refused, tagged, topic_router

Limit = Annotated[int, Query(ge=1, le=1000)]
ChangeLimit = Annotated[int, Query(ge=1, le=200)]
Cursor = Annotated[str | None, Query(max_length=300)]
ElementPath = Annotated[
    str, Path(max_length=300, description="Id of the element.", examples=["starter_1", "learned:taught_grasp_1"])
]
NamePath = Annotated[str, Path(max_length=300, description="A name of the ontology.", examples=["kitting:Starter"])]
WhyQuery = Annotated[
    str, Query(max_length=1000, description="Reason, for people.", examples=["delivered this morning"])
]


_NUMBER = re.compile(r"\d{1,18}", re.ASCII)


def number_cursor(cursor: str | None, first: int = 0) -> int:
    """Parses a cursor that is a number.

    Args:
        cursor: The cursor.
        first: Its value for the first page.

    Raises:
        UsageError: It is not a cursor of this list.
    """
    if cursor is None:
        return first
    if not _NUMBER.fullmatch(cursor):
        raise UsageError(f"'{cursor[:50]}' is not a cursor of this list: pass 'next' of the previous page unchanged")
    return int(cursor)


router = topic_router("world")

_LATEST = 2**62


# ------------------------------------------------------------------ looking


@router.get("/world", responses=tagged())
def read_world(act: Viewer) -> api.WorldInfo:
    """Get the state of the world.

    Returns the version of the world, its number of elements, and what an undo would revert; the ETag is the version.
    """
    return act.tagged(act.station.world.info())


@router.get("/tree")
def read_tree(
    act: Viewer,
    root: Annotated[str, Query(max_length=300, examples=["kit_1"])] = "",
    depth: Annotated[int, Query(ge=0, le=20)] = 3,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    cursor: Cursor = None,
) -> api.TreeNode:
    """Read the world as a tree.

    Returns the tree of placements and parts: at most 2000 nodes, those nearest to the root first.

    If `children_total` is greater than the number of children returned, read on with `root=<id>&cursor=<next>`.

    Parameters:
        root: The element at the root; the root of the world if omitted.
        depth: Number of levels below it.
        limit: Maximum number of children per node.
    """
    return act.station.world.tree(root, depth, limit, cursor or "")


_FORGOTTEN = also_refused(410, "The changes are no longer stored.")


@router.get("/world/changes", responses=_FORGOTTEN)
def list_changes(
    act: Viewer,
    since: Annotated[int, Query(ge=0, le=_LATEST)] = 0,
    newest_first: bool = False,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> api.ChangePage:
    """List changes.

    Lists changes with their authors and reasons, each with its first 100 edits.

    Old changes may have been removed: 410 if one of these is requested.

    Parameters:
        since: Only changes after this number.
        newest_first: From the newest change backwards; `since` is ignored.
    """
    start = number_cursor(cursor, _LATEST if newest_first else since)
    return act.station.world.changes(start, limit, newest_first=newest_first)


@router.get("/world/changes/{number}", responses=_FORGOTTEN)
def read_change(
    act: Viewer,
    number: Annotated[int, Path(ge=0, le=_LATEST, examples=[1])],
    limit: Limit = 1000,
    cursor: Cursor = None,
) -> api.Change:
    """Get a change.

    Returns a change with its edits, in pages.

    Parameters:
        number: Its number.
    """
    return act.station.world.change(number, number_cursor(cursor), limit)


# ------------------------------------------------------------------ writing


@router.post("/world/transactions", responses=NEEDS_VERSION | tagged())
def write_transaction(act: Operator, order: TransactionOrder, seen: SeenDep) -> api.Written:
    """Execute a transaction.

    Executes all operations as one change, or none; a refusal lists all problems.

    Existing elements are changed only if the caller names the versions seen: in `expects`, or in `If-Match` with the
    version of the world (`*` for any).
    """
    return act.tagged(act.station.world.write(order, seen, act.author))


@router.post("/world/undo")
def undo_edit(act: Operator, order: api.UndoOrder | None = None) -> api.Change:
    """Undo the last edit of a person.

    Reverts the last edit of a person that was not reverted yet, as a new change.

    Changes by skills are never reverted; 409 if later changes depend on the edit.
    """
    return act.station.world.undo(order, act.author)


@router.post("/world/redo")
def redo_edit(act: Operator, order: api.UndoOrder | None = None) -> api.Change:
    """Redo the last undone edit.

    Reverts the last undo, as a new change, as long as no person has made another edit since.
    """
    return act.station.world.redo(order, act.author)


locks_router = topic_router("locks")


@locks_router.get("/locks")
def list_locks(act: Viewer) -> api.LockList:
    """List locks.

    Lists the locks of elements, with their owners and expiry times.
    """
    return act.station.world.locks()


@locks_router.post("/locks", status_code=201)
def lock_elements(act: Operator, order: api.LockOrder) -> api.LockList:
    """Lock elements.

    Prevents other people and jobs from editing elements, all of them or none; locking again extends the lock.

    Skills can still report what they sense. Locks end with the server, and when another scene is loaded.
    """
    return act.station.world.lock(order, act.author)


@locks_router.delete("/locks")
def end_locks(
    act: Operator,
    elements: Annotated[list[api.ElementId] | None, Query(max_length=100)] = None,
    owner: Annotated[str | None, Query(max_length=300)] = None,
) -> api.LockList:
    """Release locks.

    Releases the caller's locks, and returns the remaining ones; elements that are not locked are ignored.

    Parameters:
        elements: The elements; all those of the owner if omitted.
        owner: Owner of the locks; only an admin releases the locks of others.
    """
    if owner not in (None, act.caller.name) and act.caller.role is not Role.ADMIN:
        raise Problem(403, "RoleTooLow", f"locks of {owner} are ended by {owner} or by an admin")
    return act.station.world.unlock(elements, act.author, owner)


_TAG = {"description": "Version of the view, for If-None-Match.", "schema": {"type": "string"}}
_ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"headers": {"ETag": _TAG}},
    304: {"description": "Nothing changed since the view of If-None-Match.", "headers": {"ETag": _TAG}},
}
_Id = Annotated[str, Query(max_length=300)]


@router.get("/view", response_model=WorldView, responses=_ANSWERS)
def read_view(
    act: Viewer,
    element: Annotated[list[_Id] | None, Query(max_length=100, examples=[["kit_1"]])] = None,
    if_none_match: Annotated[str | None, Header(max_length=1000)] = None,
) -> Response:
    """Get the shapes and poses of all elements.

    Returns the believed poses of all elements and their shapes: boxes and cylinders.

    Read everything once, then follow the events of the world and read the named elements again. Poses of elements on a
    robot's base are relative to that base, those of held elements to the tool: `/state` and its stream contain the
    current poses of these.

    Parameters:
        element: Only these elements, with those that move or disappear with them; everything if omitted.
        if-none-match: ETag of the view already known.
    """
    tag = f'"{act.station.world.view_tag()}"'
    if tag in {one.strip().removeprefix("W/") for one in (if_none_match or "").split(",")}:
        return Response(status_code=304, headers={"ETag": tag})
    # Made into text at once: what was checked when it was made is not checked again.
    text = act.station.world.view(element).model_dump_json(by_alias=True)
    return Response(text, media_type="application/json", headers={"ETag": tag})
