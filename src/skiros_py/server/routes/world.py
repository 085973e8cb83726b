"""Routes: world."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.elements import TreeNode
from skiros_py.api.world import Change, ChangePage, TransactionOrder, UndoOrder, WorldInfo, Written
from skiros_py.errors import Locked, StaleVersion, WorldError
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, expected_version, tagged
from skiros_py.server.problems import Problem, found
from skiros_py.server.routes.parameters import ChangeLimit, Cursor, Limit, also_refused
from skiros_py.server.services import ServicesDep
from skiros_py.server.world.changes import change_page, one_change, told_change, undoable, written
from skiros_py.server.world.cursors import number_cursor
from skiros_py.server.world.editing import operate, writing
from skiros_py.station.scenes.loading import LOADED
from skiros_py.station.world.tree import tree
from skiros_py.world.element import is_learned
from skiros_py.world.undo import last_undoable, undo
from skiros_py.world.vocabulary import ELEMENT

__all__ = ["router"]

router = APIRouter(tags=["world"])

_LATEST = 2**62


# ------------------------------------------------------------------ looking


@router.get("/world", summary="Read what there is, in numbers", dependencies=[needs(Role.VIEWER)], responses=tagged())
def read_world(services: ServicesDep, response: Response) -> WorldInfo:
    """Tells the world's version, how much is in it, and what an undo would take back; its ETag is the version."""
    world = services.session.world
    view = world.snapshot()
    response.headers["ETag"] = etag(view.version)
    abstract = view.abstracts(ELEMENT)
    learned = sum(map(is_learned, abstract))
    return WorldInfo(
        version=view.version,
        time=world.clock(),
        elements=view.count(ELEMENT),
        abstract=len(abstract) - learned,
        learned=learned,
        goals=len(view.goals),
        locks=len(world.locks.held()),
        remembered_from=world.log.first,
        undoable=undoable(world),
    )


@router.get("/tree", summary="Read the world as a tree", dependencies=[needs(Role.VIEWER)])
def read_tree(
    services: ServicesDep,
    root: Annotated[
        str, Query(max_length=300, description="Where to begin; above everything where left out.", examples=["kit_1"])
    ] = "",
    depth: Annotated[int, Query(ge=0, le=20, description="How many levels below it.")] = 3,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many children of each node at most.")] = 100,
    cursor: Cursor = None,
) -> TreeNode:
    """Tells what is placed where and what things are built of: at most 2000 nodes, those next to the root first.

    Where `children_total` is more than the children given, read on with `root=<id>&cursor=<next>`.
    """
    view = services.session.world.snapshot()
    with found():
        return tree(view, root, depth, limit, cursor or "")


_FORGOTTEN = also_refused(410, "The changes are remembered no longer.")


@router.get("/world/changes", summary="List changes", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def list_changes(
    services: ServicesDep,
    since: Annotated[int, Query(ge=0, le=_LATEST, description="Only changes after this number.")] = 0,
    newest_first: Annotated[
        bool, Query(description="Go back in time instead, from the latest; `since` is ignored.")
    ] = False,
    limit: ChangeLimit = 100,
    cursor: Cursor = None,
) -> ChangePage:
    """Tells what changed, by whom and why; of each change the first 100 edits.

    Of a long edit history only the later part may be remembered: 410 where an older one is asked for.
    """
    start = number_cursor(cursor, _LATEST if newest_first else since)
    return change_page(services.session.world, start, limit, newest_first=newest_first)


@router.get("/world/changes/{number}", summary="Read a change", dependencies=[needs(Role.VIEWER)], responses=_FORGOTTEN)
def read_change(
    services: ServicesDep,
    number: Annotated[int, Path(ge=0, le=_LATEST, description="Its number.", examples=[1])],
    limit: Limit = 1000,
    cursor: Cursor = None,
) -> Change:
    """Tells a change with all its edits, as many at a time as wanted."""
    return one_change(services.session.world, number, number_cursor(cursor), limit)


# ------------------------------------------------------------------ writing


@router.post(
    "/world/transactions",
    summary="Write several things at once",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION | tagged(),
)
def write_transaction(
    order: TransactionOrder, services: ServicesDep, caller: CallerDep, seen: VersionDep, response: Response
) -> Written:
    """Does all operations, as one change, or none; a refusal names everything that is wrong.

    What is there already is changed only by who says what they have seen: by `expects`, or by `If-Match` with the
    version of the world (`*` for whatever it is).
    """
    world = services.session.world
    with writing(world, caller, order.reason, _expected(order, seen)) as tx:
        ids = operate(tx, order.operations)
    told = written(world, tx, ids)
    response.headers["ETag"] = etag(told.version)
    return told


def _expected(order: TransactionOrder, given: str | None) -> dict[str, int]:
    seen = expected_version(given)
    if seen is not None:
        return {"": seen, **order.expects}
    adds_only = all(operation.op == "add" for operation in order.operations)
    if not (order.expects or adds_only or given is not None):
        raise Problem(
            428, "VersionMissing", 'say what you have seen: {"expects": {"starter_1": 17}}, or the world\'s If-Match'
        )
    return order.expects


@router.post("/world/undo", summary="Undo the last edit by a person", dependencies=[needs(Role.OPERATOR)])
def undo_edit(services: ServicesDep, caller: CallerDep, order: UndoOrder | None = None) -> Change:
    """Takes back the last edit that a person made and nobody has taken back yet, as a change of its own.

    What skills sensed is never undone; 409 where something was built on the edit since.
    """
    world = services.session.world
    try:
        return told_change(undo(world, caller.name, expects=order.change if order else None, holder=caller.holder))
    except (StaleVersion, Locked):
        raise
    except WorldError as error:
        last = last_undoable(world.log)
        was_loaded = last is not None and last.reason.startswith(LOADED)
        hint = "; load the former scene instead: PUT /scene" if was_loaded else ""
        raise Problem(409, "CannotUndo", f"{error}{hint}") from None
