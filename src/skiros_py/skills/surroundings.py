"""Where things are for a robot that acts: poses through moving frames, obstacles, what it holds.

The bodies of a simulation live as long as its process. A part can start where it lay, but not between fingers, and a
robot starts where its scene puts it. The journal knows where things were before.
"""

from __future__ import annotations

from collections.abc import Callable

from skiros_py.errors import WorldError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Held, Obstacle
from skiros_py.skills.context import RunContext
from skiros_py.world import vocabulary as v
from skiros_py.world.change import PlacementEdit, Writer
from skiros_py.world.element import Placement, Value
from skiros_py.world.journal import Journal
from skiros_py.world.poses import pose_on, write_pose
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


def map_pose(context: RunContext, element: str) -> Pose | None:
    """Returns the believed pose of an element in the map, or None when it has none.

    A pose may be given in the frame of another element; where a device is, its sensors say.
    """
    tree = context.frames.at(context.board.snapshot)
    if (device := tree.device(element)) is not None:
        return device
    found = pose_on(context.world, element, tree.device)
    return None if found is None else found[1]


def solid_of(view: WorldView, element: str) -> Solid | None:
    """Returns the shape of an element or of its class, or None.

    Raises:
        WorldError: The shape cannot be read.
    """
    value: Value | None = view.value(element, v.SOLID)
    if value is None:
        return None
    try:
        return Solid.from_json(str(value))
    except ValueError as error:
        raise WorldError(f"{element}: its sk:solid is {error}") from error


def owner(view: WorldView, element: str, class_: str = v.ROBOT) -> str | None:
    """Returns the nearest element of a class that has this one in its structure (the robot of a gripper)."""
    current: tuple[str, ...] = (element,)
    while current:
        for candidate in current:
            if view.ontology.is_a(view.element(candidate).type, class_):
                return candidate
        current = tuple(o for c in current for o in view.subjects(v.HAS_A, c))
    return None


def held_by(context: RunContext, gripper: str) -> tuple[str, Held] | None:
    """Returns what a gripper holds, by belief: its id, and its shape at its pose in the arm's tip frame."""
    for element in context.world.subjects(v.HELD_BY, gripper):
        solid = solid_of(context.world, element)
        pose = context.world.value(element, v.POSE)
        if solid is not None and isinstance(pose, Pose) and gripper in context.world.objects(element, v.POSE_FRAME):
            return element, Held(solid, pose)
    return None


def obstacles(context: RunContext, *, parts: bool, without: frozenset[str] = frozenset()) -> tuple[Obstacle, ...]:
    """Returns everything believed to stand around, with shape and map pose.

    Args:
        context: The run.
        parts: Whether parts that were seen count too.
        without: Ids to leave out.
    """
    view = context.world
    found = []
    for element in view.instances(v.SPATIAL_THING):
        type_ = view.element(element).type
        if element in without or (not parts and view.ontology.is_a(type_, v.MANIPULATABLE)):
            continue
        if view.value(element, v.HOLLOW) is True or any(view.ontology.is_a(type_, c) for c in (v.DEVICE, v.ROBOT)):
            continue
        solid, pose = solid_of(view, element), map_pose(context, element)
        if solid is not None and pose is not None and not _in_hand(view, element):
            found.append(Obstacle(element, solid, pose))
    return tuple(found)


def _in_hand(view: WorldView, element: str) -> bool:
    placement = view.placement(element)
    return placement is not None and placement.relation == v.HELD_BY


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
            write_pose(tx, part, None)
            tx.set(part, v.MISSING, True)
        for part, placement in held.items():
            tx.place(part, placement.relation, placement.place)
            write_pose(tx, part, None)  # where in its place nobody knows any more; the gripper carries it no longer
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
