"""What a restart of the simulation changes in the beliefs.

The bodies of a simulation live as long as its process. A part can start where it lay, but not between fingers, and a
base starts where its scene puts it. The journal has the earlier places.
"""

from __future__ import annotations

from collections.abc import Callable

from skiros_py.messages import Message
from skiros_py.skills.cell_reader import has_base
from skiros_py.skills.surroundings import is_held
from skiros_py.world import vocabulary as v
from skiros_py.world.change import PlacementEdit, Writer
from skiros_py.world.element import Placement
from skiros_py.world.journal.journal import Journal
from skiros_py.world.poses import write_pose
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


def respawn(world: World, journal: Journal, check: Callable[[WorldView], None] = lambda _view: None) -> None:
    """Updates the beliefs to the state in which a simulation starts.

    Held parts lie where they were taken from. A robot with a base is at its ``sk:startLocation``, or anywhere when it
    has none; a robot without a base stays where it is. A part without a known place is missing until its place is
    stated again.

    Args:
        world: The world of a data directory.
        journal: Its changes.
        check: Gets the world as it will be believed; what it raises is raised, and nothing was changed.
    """
    before = {part: last_place(world, part) for part in world.instances(v.MANIPULATABLE) if is_held(world, part)}
    held = {part: place for part, place in before.items() if place is not None}
    robots = _moved(world)
    # In a scene that has just been read a part without a place is its author's mistake.
    lost = [*_lost(world), *(before.keys() - held.keys())] if journal.version > 1 else []
    if not (held or robots or lost):
        check(world.snapshot())
        return
    with world.transaction("simulation", Message("restarts"), writer=Writer.SYSTEM) as tx:
        for part in lost:
            tx.place(part, v.ON, _anywhere(world))
            write_pose(tx, part, None)
            tx.set(part, v.MISSING, True)
        for part, placement in held.items():
            tx.place(part, placement.relation, placement.place)
            write_pose(tx, part, None)  # where in its place is unknown; the gripper carries it no longer
        for robot, start in robots.items():
            tx.place(robot, v.AT, start)
        check(tx.view)


def _lost(world: World) -> list[str]:
    """Returns the parts of which neither a pose nor a thing that they lie in is known, and that do not count so yet."""
    parts = [part for part in world.instances(v.MANIPULATABLE) if world.value(part, v.POSE) is None]
    placed = [(part, world.placement(part)) for part in parts if world.value(part, v.MISSING) is not True]
    return [part for part, at in placed if at is None or not (at.relation == v.HELD_BY or _holds_bodies(world, at))]


def _holds_bodies(world: World, placement: Placement) -> bool:
    return placement.relation in (v.IN, v.MAY_BE_IN) and world.value(placement.place, v.SOLID) is not None


def last_place(world: World, part: str) -> Placement | None:
    """Returns where a part was before it was taken or got lost; None where the log goes back no further."""
    edits = (edit for change in reversed(world.log.about((part,), 0)) for edit in change.edits)
    before = (edit.old for edit in edits if isinstance(edit, PlacementEdit) and edit.element == part)
    return next((at for at in before if at and at.relation != v.HELD_BY and at.place != _anywhere(world)), None)


def _moved(world: World) -> dict[str, str]:
    """Returns the robots that are not where their bases start, each with the place where it starts."""
    starts = {
        robot: next(iter(world.objects(robot, v.START_LOCATION)), None) or _anywhere(world)
        for robot in world.instances(v.ROBOT)
        if has_base(world, robot)
    }
    placed = {robot: world.placement(robot) for robot in starts}
    return {robot: starts[robot] for robot, at in placed.items() if at is not None and at.place != starts[robot]}


def _anywhere(world: World) -> str:
    (anywhere, *_) = world.instances(v.UNKNOWN_LOCATION)
    return anywhere
