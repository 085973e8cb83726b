"""A simulation that starts anew in a world that has gone on: what cannot be as it was is believed otherwise.

The bodies of a simulation live as long as its process. A part can start where it lay, but not between fingers, and a
robot starts where its scene puts it. The journal knows where things were before.
"""

from __future__ import annotations

from collections.abc import Callable

from skiros_py.skills.surroundings import set_pose
from skiros_py.world import vocabulary as v
from skiros_py.world.change import PlacementEdit, Writer
from skiros_py.world.element import Placement
from skiros_py.world.journal import Journal
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


def respawn(world: World, journal: Journal, check: Callable[[WorldView], None] = lambda _view: None) -> None:
    """Believes what will be so when the simulation starts: held parts lie where they were taken, robots stand anywhere.

    A part that nobody knows the place of is missing: it comes back when somebody says where it is.

    Args:
        world: The world of a data directory.
        journal: Its changes.
        check: Gets the world as it will be believed; what it raises is raised, and nothing was changed.
    """
    before = {part: _before(journal, part) for part in _held(world)}
    held = {part: place for part, place in before.items() if place is not None}
    robots = [robot for robot in world.instances(v.ROBOT) if _is_somewhere(world, robot)]
    # In a scene that has just been read a part without a place is its author's mistake.
    lost = [*_lost(world), *(before.keys() - held.keys())] if journal.version > 1 else []
    if not (held or robots or lost):
        check(world.snapshot())
        return
    (anywhere, *_) = world.instances(v.UNKNOWN_LOCATION)
    with world.transaction("simulation", "it starts anew", writer=Writer.SYSTEM) as tx:
        for part in lost:
            tx.place(part, v.ON, anywhere)
            set_pose(tx, world, part, None)
            tx.set(part, v.MISSING, True)
        for part, placement in held.items():
            tx.place(part, placement.relation, placement.place)
            set_pose(
                tx, world, part, None
            )  # where in its place nobody knows any more; the gripper carries it no longer
        for robot in robots:
            tx.place(robot, v.AT, anywhere)
        check(tx.view)


def _held(world: World) -> list[str]:
    placed = ((part, world.placement(part)) for part in world.instances(v.MANIPULATABLE))
    return [part for part, placement in placed if placement is not None and placement.relation == v.HELD_BY]


def _lost(world: World) -> list[str]:
    """Returns the parts of which neither a pose nor a thing that they lie in is known, and that do not count so yet."""
    parts = [part for part in world.instances(v.MANIPULATABLE) if world.value(part, v.POSE) is None]
    placed = [(part, world.placement(part)) for part in parts if world.value(part, v.MISSING) is not True]
    return [part for part, placement in placed if placement is None or not _holds_bodies(world, placement)]


def _holds_bodies(world: World, placement: Placement) -> bool:
    return placement.relation == v.HELD_BY or (
        placement.relation == v.IN and world.value(placement.place, v.SOLID) is not None
    )


def _before(journal: Journal, part: str) -> Placement | None:
    """Returns where a part was before it was taken; None where the journal goes back no further."""
    edits = (edit for entry in reversed(journal.history(part)) for edit in entry.change.edits)
    moves = (edit for edit in edits if isinstance(edit, PlacementEdit) and edit.element == part)
    return next((e.old for e in moves if e.old is not None and e.old.relation != v.HELD_BY), None)


def _is_somewhere(world: World, robot: str) -> bool:
    placement = world.placement(robot)
    return placement is not None and not world.ontology.is_a(world.element(placement.place).type, v.UNKNOWN_LOCATION)
