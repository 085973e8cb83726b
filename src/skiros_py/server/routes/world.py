"""Routes: world."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.elements import TreeNode
from skiros_py.api.world import Change, ChangePage, TransactionOrder, UndoOrder, WorldInfo, Written
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep, etag, tagged
from skiros_py.server.routes.parameters import ChangeLimit, Cursor, Limit, also_refused, number_cursor
from skiros_py.server.services import StationDep

router = APIRouter(tags=["world"])

_LATEST = 2**62


# ------------------------------------------------------------------ looking


@router.get("/world", summary="Read what there is, in numbers", dependencies=[needs(Role.VIEWER)], responses=tagged())
def read_world(station: StationDep, response: Response) -> WorldInfo:
    """Tells the world's version, how much is in it, and what an undo would take back; its ETag is the version."""
    info = station.world.info()
    response.headers["ETag"] = etag(info.version)
    return info


@router.get("/tree", summary="Read the world as a tree", dependencies=[needs(Role.VIEWER)])
def read_tree(
    station: StationDep,
    root: Annotated[
        str, Query(max_length=300, description="Where to begin; above everything where left out.", examples=["kit_1"])
    ] = "",
    depth: Annotated[int, Query(ge=0, le=20, description="How many levels below it.")] = 3,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many children of each node at most.")] = 100,
    cursor: Cursor = None,
) -> TreeNode:
    """Returns what is placed where and what things are built of: at most 2000 nodes, those next to the root first.

    Where `children_total` is more than the children given, read on with `root=<id>&cursor=<next>`.
    """
    return station.world.tree(root, depth, limit, cursor or "")


_FORGOTTEN = also_refused(410, "The changes are remembered no longer.")


@router.get("/world/changes", summary="List changes", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def list_changes(
    station: StationDep,
    since: Annotated[int, Query(ge=0, le=_LATEST, description="Only changes after this number.")] = 0,
    newest_first: Annotated[
        bool, Query(description="Go back in time instead, from the latest; `since` is ignored.")
    ] = False,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> ChangePage:
    """Returns what changed, by whom and why; of each change the first 100 edits.

    Of a long edit history only the later part may be remembered: 410 where an older one is asked for.
    """
    start = number_cursor(cursor, _LATEST if newest_first else since)
    return station.world.changes(start, limit, newest_first=newest_first)


@router.get("/world/changes/{number}", summary="Read a change", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def read_change(
    station: StationDep,
    number: Annotated[int, Path(ge=0, le=_LATEST, description="Its number.", examples=[1])],
    limit: Limit = 1000,
    cursor: Cursor = None,
) -> Change:
    """Tells a change with all its edits, as many at a time as wanted."""
    return station.world.change(number, number_cursor(cursor), limit)


# ------------------------------------------------------------------ writing


@router.post(
    "/world/transactions",
    summary="Write several things at once",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION | tagged(),
)
def write_transaction(
    order: TransactionOrder, station: StationDep, caller: CallerDep, seen: SeenDep, response: Response
) -> Written:
    """Does all operations, as one change, or none; a refusal names everything that is wrong.

    What is there already is changed only by who says what they have seen: by `expects`, or by `If-Match` with the
    version of the world (`*` for whatever it is).
    """
    written = station.world.write(order, seen, caller.author)
    response.headers["ETag"] = etag(written.version)
    return written


@router.post("/world/undo", summary="Undo the last edit by a person", dependencies=[needs(Role.OPERATOR)])
def undo_edit(station: StationDep, caller: CallerDep, order: UndoOrder | None = None) -> Change:
    """Takes back the last edit that a person made and that was not undone yet, as a change of its own.

    What skills sensed is never undone; 409 where something was built on the edit since.
    """
    return station.world.undo(order, caller.author)
