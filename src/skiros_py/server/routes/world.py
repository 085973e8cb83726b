"""Routes: the world as a whole, taught data, locks, and the visible world."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import APIRouter, Header, Path, Query, Response

from skiros_py.api.view import WorldView
from skiros_py.api.wire import ProblemDetails
from skiros_py.api.world import (
    Change,
    ChangePage,
    ElementId,
    LearnedPage,
    LockList,
    LockOrder,
    TransactionOrder,
    TreeNode,
    UndoOrder,
    WorldInfo,
    Written,
)
from skiros_py.errors import UsageError
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, Problem, SeenDep, etag, tagged
from skiros_py.server.services import StationDep

Limit = Annotated[int, Query(ge=1, le=1000, description="How many at most.")]
ChangeLimit = Annotated[int, Query(ge=1, le=200, description="How many at most.")]
Cursor = Annotated[str | None, Query(max_length=300, description="Where to read on: `next` of the page before.")]
ElementPath = Annotated[
    str, Path(max_length=300, description="Id of the element.", examples=["starter_1", "learned:taught_grasp_1"])
]
NamePath = Annotated[str, Path(max_length=300, description="A name of the ontology.", examples=["kitting:Starter"])]
WhyQuery = Annotated[str, Query(max_length=1000, description="Why, for people.", examples=["delivered this morning"])]


def also_refused(status: int, why: str) -> dict[int | str, dict[str, Any]]:
    """Documents a refusal that only some routes know; for ``responses=``."""
    return {status: {"model": ProblemDetails, "description": why, "content": {"application/problem+json": {}}}}


_NUMBER = re.compile(r"\d{1,18}", re.ASCII)


def number_cursor(cursor: str | None, first: int = 0) -> int:
    """Reads a cursor that is a number.

    Args:
        cursor: The cursor.
        first: What it is for the first page.

    Raises:
        UsageError: It is none of ours.
    """
    if cursor is None:
        return first
    if not _NUMBER.fullmatch(cursor):
        raise UsageError(f"'{cursor[:50]}' is no cursor of this list: give 'next' of the page before, as it is")
    return int(cursor)


router = APIRouter(tags=["world"])

_LATEST = 2**62


# ------------------------------------------------------------------ looking


@router.get("/world", dependencies=[needs(Role.VIEWER)], responses=tagged())
def read_world(station: StationDep, response: Response) -> WorldInfo:
    """Read what there is, in numbers.

    Tells the world's version, how much is in it, and what an undo would take back; its ETag is the version.
    """
    info = station.world.info()
    response.headers["ETag"] = etag(info.version)
    return info


@router.get("/tree", dependencies=[needs(Role.VIEWER)])
def read_tree(
    station: StationDep,
    root: Annotated[
        str, Query(max_length=300, description="Where to begin; above everything where left out.", examples=["kit_1"])
    ] = "",
    depth: Annotated[int, Query(ge=0, le=20, description="How many levels below it.")] = 3,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many children of each node at most.")] = 100,
    cursor: Cursor = None,
) -> TreeNode:
    """Read the world as a tree.

    Returns what is placed where and what things are built of: at most 2000 nodes, those next to the root first.

    Where `children_total` is more than the children given, read on with `root=<id>&cursor=<next>`.
    """
    return station.world.tree(root, depth, limit, cursor or "")


_FORGOTTEN = also_refused(410, "The changes are remembered no longer.")


@router.get("/world/changes", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def list_changes(
    station: StationDep,
    since: Annotated[int, Query(ge=0, le=_LATEST, description="Only changes after this number.")] = 0,
    newest_first: Annotated[
        bool, Query(description="Go back in time instead, from the latest; `since` is ignored.")
    ] = False,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> ChangePage:
    """List changes.

    Returns what changed, by whom and why; of each change the first 100 edits.

    Of a long edit history only the later part may be remembered: 410 where an older one is asked for.
    """
    start = number_cursor(cursor, _LATEST if newest_first else since)
    return station.world.changes(start, limit, newest_first=newest_first)


@router.get("/world/changes/{number}", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def read_change(
    station: StationDep,
    number: Annotated[int, Path(ge=0, le=_LATEST, description="Its number.", examples=[1])],
    limit: Limit = 1000,
    cursor: Cursor = None,
) -> Change:
    """Read a change.

    Tells a change with all its edits, as many at a time as wanted.
    """
    return station.world.change(number, number_cursor(cursor), limit)


# ------------------------------------------------------------------ writing


@router.post("/world/transactions", dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION | tagged())
def write_transaction(
    order: TransactionOrder, station: StationDep, caller: CallerDep, seen: SeenDep, response: Response
) -> Written:
    """Write several things at once.

    Does all operations, as one change, or none; a refusal names everything that is wrong.

    What is there already is changed only by who says what they have seen: by `expects`, or by `If-Match` with the
    version of the world (`*` for whatever it is).
    """
    written = station.world.write(order, seen, caller.author)
    response.headers["ETag"] = etag(written.version)
    return written


@router.post("/world/undo", dependencies=[needs(Role.OPERATOR)])
def undo_edit(station: StationDep, caller: CallerDep, order: UndoOrder | None = None) -> Change:
    """Undo the last edit by a person.

    Takes back the last edit that a person made and that was not undone yet, as a change of its own.

    What skills sensed is never undone; 409 where something was built on the edit since.
    """
    return station.world.undo(order, caller.author)


learned_router = APIRouter(tags=["learned"])


@learned_router.get("/learned", dependencies=[needs(Role.VIEWER)])
def list_learned(station: StationDep, limit: Limit = 100, cursor: Cursor = None) -> LearnedPage:
    """List what robots were taught.

    Lists what robots were taught and keep beyond this scene, in the order of ids.
    """
    return station.world.learned(limit, cursor or "")


@learned_router.delete("/learned/{element}", dependencies=[needs(Role.ENGINEER)], responses=NEEDS_VERSION)
def forget_learned(
    element: ElementPath, station: StationDep, caller: CallerDep, seen: SeenDep, reason: WhyQuery = ""
) -> Written:
    """Forget something.

    Forgets something with its pieces; an undo brings it back.
    """
    return station.world.forget(element, seen, caller.author, reason)


@learned_router.get(
    "/learned.ttl",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"content": {"text/turtle": {"schema": {"type": "string"}}}}},
)
def export_learned(station: StationDep) -> Response:
    """Read what robots were taught as Turtle.

    Writes everything that was learned as the text of a file.

    Another robot knows it from the start when the file lies in its new data directory as learned.ttl.
    """
    return Response(station.world.learned_turtle(), media_type="text/turtle; charset=utf-8")


locks_router = APIRouter(tags=["locks"])


@locks_router.get("/locks", dependencies=[needs(Role.VIEWER)])
def list_locks(station: StationDep) -> LockList:
    """List locks.

    Returns who alone may edit which elements, and until when.
    """
    return station.world.locks()


@locks_router.post("/locks", status_code=201, dependencies=[needs(Role.OPERATOR)])
def lock_elements(order: LockOrder, station: StationDep, caller: CallerDep) -> LockList:
    """Lock elements.

    Keeps other people and jobs from editing elements, all of them or none; locking again makes it last longer.

    Skills are not kept from saying what they sensed. Locks end with the server, and when another scene is loaded.
    """
    return station.world.lock(order, caller.author)


@locks_router.delete("/locks", dependencies=[needs(Role.OPERATOR)])
def end_locks(
    station: StationDep,
    caller: CallerDep,
    elements: Annotated[
        list[ElementId] | None, Query(max_length=100, description="Which; all of the owner where left out.")
    ] = None,
    owner: Annotated[
        str | None, Query(max_length=300, description="Whose locks; those of others only an admin ends.")
    ] = None,
) -> LockList:
    """End locks.

    Ends one's own locks, and answers with those that are left; what is not locked stays as it is.
    """
    if owner not in (None, caller.name) and caller.role is not Role.ADMIN:
        raise Problem(403, "RoleTooLow", f"locks of {owner} are ended by {owner} or by an admin")
    return station.world.unlock(elements, caller.author, owner)


_TAG = {"description": "Version of the view, for If-None-Match.", "schema": {"type": "string"}}
_ANSWERS: dict[int | str, dict[str, Any]] = {
    200: {"headers": {"ETag": _TAG}},
    304: {"description": "Nothing changed since the view of If-None-Match.", "headers": {"ETag": _TAG}},
}
_Id = Annotated[str, Query(max_length=300)]


@router.get("/view", dependencies=[needs(Role.VIEWER)], response_model=WorldView, responses=_ANSWERS)
def read_view(
    station: StationDep,
    element: Annotated[
        list[_Id] | None,
        Query(
            max_length=100,
            description="Only these elements, with what moves or is gone with them; everything where left out.",
            examples=[["kit_1"]],
        ),
    ] = None,
    if_none_match: Annotated[str | None, Header(max_length=1000, description="ETag of the view that is known.")] = None,
) -> Response:
    """Read what there is to be seen.

    Tells where everything is believed to be, and what it looks like: boxes and cylinders.

    Read everything once; then follow the events of the world, and read anew the elements that they name. What is on a
    robot's base is told in the frame of that base, and what a gripper holds in that of the tool: where these are is
    told by `/state` and its stream from moment to moment.
    """
    tag = f'"{station.world.view_tag()}"'
    if _knows(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": tag})
    # Made into text at once: what was checked when it was made is not checked again.
    text = station.world.view(element).model_dump_json(by_alias=True)
    return Response(text, media_type="application/json", headers={"ETag": tag})


def _knows(given: str | None, tag: str) -> bool:
    return given is not None and tag in {one.strip().removeprefix("W/") for one in given.split(",")}
