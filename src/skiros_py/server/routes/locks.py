"""Routes: locks."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.values import ElementId
from skiros_py.api.world import LockList, LockOrder
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import Problem
from skiros_py.server.services import StationDep

router = APIRouter(tags=["locks"])


@router.get("/locks", summary="List locks", dependencies=[needs(Role.VIEWER)])
def list_locks(station: StationDep) -> LockList:
    """Returns who alone may edit which elements, and until when."""
    return station.world.locks()


@router.post("/locks", summary="Lock elements", status_code=201, dependencies=[needs(Role.OPERATOR)])
def lock_elements(order: LockOrder, station: StationDep, caller: CallerDep) -> LockList:
    """Keeps other people and jobs from editing elements, all of them or none; locking again makes it last longer.

    Skills are not kept from saying what they sensed. Locks end with the server, and when another scene is loaded.
    """
    return station.world.lock(order, caller.author)


@router.delete("/locks", summary="End locks", dependencies=[needs(Role.OPERATOR)])
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
    """Ends one's own locks, and answers with those that are left; what is not locked stays as it is."""
    if owner not in (None, caller.name) and caller.role is not Role.ADMIN:
        raise Problem(403, "RoleTooLow", f"locks of {owner} are ended by {owner} or by an admin")
    return station.world.unlock(elements, caller.author, owner)
