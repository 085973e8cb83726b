"""Routes: locks."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.locks import Lock, LockList, LockOrder
from skiros_py.api.values import ElementId
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import Problem
from skiros_py.server.services import ServicesDep
from skiros_py.server.world.editing import told_lock, writing_locks
from skiros_py.world.locks import Lock as WorldLock
from skiros_py.world.world import World

__all__ = ["router"]

router = APIRouter(tags=["locks"])


@router.get("/locks", summary="List locks", dependencies=[needs(Role.VIEWER)])
def list_locks(services: ServicesDep) -> LockList:
    """Tells who alone may edit which elements, and until when."""
    world = services.session.world
    return LockList(items=[_told(world, lock) for lock in world.locks.held()])


@router.post("/locks", summary="Lock elements", status_code=201, dependencies=[needs(Role.OPERATOR)])
def lock_elements(order: LockOrder, services: ServicesDep, caller: CallerDep) -> LockList:
    """Keeps other people and jobs from editing elements, all of them or none; locking again makes it last longer.

    Skills are not kept from saying what they sensed. Locks end with the server, and when another scene is loaded.
    """
    world = services.session.world
    with writing_locks(world):
        locks = world.locks.acquire(order.elements, caller.holder, order.seconds, caller.name)
    return LockList(items=[_told(world, lock) for lock in locks])


@router.delete("/locks", summary="End locks", dependencies=[needs(Role.OPERATOR)])
def end_locks(
    services: ServicesDep,
    caller: CallerDep,
    elements: Annotated[
        list[ElementId] | None, Query(max_length=100, description="Which; all of the owner where left out.")
    ] = None,
    owner: Annotated[
        str | None, Query(max_length=300, description="Whose locks; those of others only an admin ends.")
    ] = None,
) -> LockList:
    """Ends one's own locks, and answers with those that are left; what is not locked stays as it is."""
    others = owner not in (None, caller.name)
    if others and caller.role is not Role.ADMIN:
        raise Problem(403, "RoleTooLow", f"locks of {owner} are ended by {owner} or by an admin")
    world = services.session.world
    for holder in _called(world, owner) if others else (caller.holder,):
        world.locks.release(holder, elements)
    return LockList(items=[_told(world, lock) for lock in world.locks.held()])


def _called(world: World, name: str | None) -> set[str]:
    """Returns all owners of locks who are called so."""
    return {lock.owner for lock in world.locks.held() if lock.shown == name}


def _told(world: World, lock: WorldLock) -> Lock:
    element, owner, until, seconds = told_lock(world, lock)
    return Lock(element=element, owner=owner, until=until, seconds=seconds)
