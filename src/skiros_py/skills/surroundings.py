"""Where things are for a robot that acts: poses through moving frames, obstacles, what it holds."""

from __future__ import annotations

from skiros_py.errors import WorldError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Held, Obstacle
from skiros_py.skills.context import RunContext
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Value
from skiros_py.world.poses import pose_on, write_pose
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView, wholes


def map_pose(context: RunContext, element: str) -> Pose | None:
    """Returns the believed pose of an element in the map, or None when it has none.

    A pose may be given in the frame of another element; where a device is, its sensors say.
    """
    tree = context.frames.at(context.board.snapshot)
    if (device := tree.device(element)) is not None:
        return device
    found = pose_on(context.world, element, tree.device)
    return None if found is None else found[1]


def write_seen(context: RunContext, tx: Transaction, element: str, pose: Pose, place: str | None) -> None:
    """Writes where in the map something is seen in or on a place: of one that a device carries, in its frame."""
    tree = context.frames.at(context.board.snapshot)
    carrier, frame = place, None if place is None else tree.device(place)
    if place is not None and frame is None:
        carrier, frame = pose_on(context.world, place, tree.device) or (None, None)
    if carrier is None or frame is None:
        write_pose(tx, element, pose)
    else:
        write_pose(tx, element, frame.inverse() @ pose, place)


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
    is_a = view.ontology.is_a
    return next((whole for whole in wholes(view, element) if is_a(view.element(whole).type, class_)), None)


def robot_of(view: WorldView, agent: str) -> str:
    """Returns the robot of a subsystem; the subsystem itself if it belongs to none or is gone."""
    return (owner(view, agent) if view.has(agent) else None) or agent


def held_by(context: RunContext, gripper: str) -> tuple[str, Held] | None:
    """Returns what a gripper holds, by belief: its id, and its shape at its pose in the arm's tip frame."""
    for element in context.world.subjects(v.HELD_BY, gripper):
        solid = solid_of(context.world, element)
        pose = context.world.value(element, v.POSE)
        if solid is not None and isinstance(pose, Pose) and gripper in context.world.objects(element, v.POSE_FRAME):
            return element, Held(solid, pose)
    return None


def obstacles(context: RunContext, *, parts: bool, without: frozenset[str] = frozenset()) -> tuple[Obstacle, ...]:
    """Returns everything believed to stand around, with shape and map pose; also devices that belong to no robot.

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
        if view.value(element, v.HOLLOW) is True or view.ontology.is_a(type_, v.ROBOT):
            continue
        if view.ontology.is_a(type_, v.DEVICE) and owner(view, element) is not None:
            continue
        solid, pose = solid_of(view, element), map_pose(context, element)
        if solid is not None and pose is not None and not is_held(view, element):
            found.append(Obstacle(element, solid, pose))
    return tuple(found)


def is_held(view: WorldView, element: str) -> bool:
    """Returns True when an element is believed to be in a gripper."""
    placement = view.placement(element)
    return placement is not None and placement.relation == v.HELD_BY
