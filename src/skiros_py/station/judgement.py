"""Belief against truth: the final report asks the simulator what is really the case. Nothing else may."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.cell import CellSpec
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.truth import Truth
from skiros_py.skills.conditions import AllOf, AnyOf, Condition, Exists, Not, Nothing, Pattern, Related
from skiros_py.world.element import Element
from skiros_py.world.overlay import ExtendedView
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import (
    AT,
    CONTAINER,
    DRIVING_POSE,
    FLOOR,
    GRIPPER,
    HELD_BY,
    IN,
    LOCATION,
    MANIPULATABLE,
    ON,
    POSE,
    POSE_FRAME,
    STATION,
)

Whereabouts = tuple[Mapping[str, Pose], Mapping[str, str]]
"""Poses in the map, and places of what can be moved; by the ids of bodies."""

_THERE = (0.06, 0.06)
"""A robot is at a location when it stands this close to where it should [m, rad]."""


def judge(cell: SimulatedCell, spec: CellSpec, view: WorldView, goal: Sequence[Condition]) -> tuple[bool | None, ...]:
    """Evaluates conditions on the world as it really is; None for those that a simulator knows nothing of.

    Args:
        cell: The simulation.
        spec: The cell as brought up.
        view: The world as believed: gives classes, structure and what is not physical.
        goal: Conditions over elements and classes.
    """
    truth = Truth(cell)
    real = ExtendedView(view)
    placements = truth.placements()
    types = {body.id: body.type for body in spec.bodies}
    for body in placements.keys() & types.keys():
        if not view.has(body):  # in stock, or taken from there: its individual is unknown
            real.extend(Element(body, types[body], body))
    for part in real.instances(MANIPULATABLE):
        place = placements.get(part)
        if place is None:
            real.unplace(part)
        else:
            real.place(part, _relation(view, place), place if view.has(place) else _floor(view))
    for robot in spec.robots:
        if robot.carrier is not None and robot.carrier.id in cell.devices:  # others are not simulated
            real.place(robot.id, AT, _location(view, truth, robot.carrier.id))
    unknown = {part for part in view.instances(MANIPULATABLE) if part not in types}
    can_tell = (_is_physical(c.pattern, view) and unknown.isdisjoint(c.arguments) for c in goal)
    return tuple(bool(c.evaluate(real)) if can else None for c, can in zip(goal, can_tell, strict=True))


def true_whereabouts(cell: SimulatedCell) -> Callable[[], Whereabouts]:
    """Looks where everything really is, for people who look on; quick.

    Args:
        cell: The simulation.

    Returns:
        What works that out, in any thread.
    """
    glance = Truth(cell).glance()
    return lambda: (glance.poses, glance.placements())


def _is_physical(pattern: Pattern, view: WorldView) -> bool:
    """Returns whether a pattern is about where things are, and nothing else."""
    match pattern:
        case Related(relation, _, _) | Nothing(relation, _):
            return view.ontology.family(relation) in (Family.PLACEMENT, Family.STRUCTURE)
        case Not(inner) | Exists(_, _, inner):
            return _is_physical(inner, view)
        case AllOf(patterns) | AnyOf(patterns):
            return all(_is_physical(part, view) for part in patterns)
        case _:
            return False


def _relation(view: WorldView, place: str) -> str:
    if place == "floor" or not view.has(place):  # or on something that the robot was not told of
        return ON
    type_ = view.element(place).type
    if view.ontology.is_a(type_, GRIPPER):
        return HELD_BY
    return IN if view.ontology.is_a(type_, CONTAINER) else ON


def _floor(view: WorldView) -> str:
    return view.instances(FLOOR)[0]


def _location(view: WorldView, truth: Truth, base: str) -> str:
    """Returns where a robot really stands: the location whose driving pose it is at, or the floor."""
    bodies = truth.poses()
    at = truth.base_pose(base)
    for location in view.instances(LOCATION):
        driving, place = view.value(location, DRIVING_POSE), _pose(view, bodies, location)
        if isinstance(driving, Pose) and place is not None:
            wanted = place @ driving
            off = ((at.position[0] - wanted.position[0]) ** 2 + (at.position[1] - wanted.position[1]) ** 2) ** 0.5
            if off <= _THERE[0] and abs(wrap_angle(at.yaw - wanted.yaw)) <= _THERE[1]:
                return location
    return _floor(view)


def _pose(view: WorldView, bodies: Mapping[str, Pose], element: str) -> Pose | None:
    """Returns where something really is: a body, or a spot that is fixed to one or to the map."""
    if element in bodies or not view.ontology.is_a(view.element(element).type, STATION):
        return bodies.get(element)
    pose, frames = view.value(element, POSE), view.objects(element, POSE_FRAME)
    frame = _pose(view, bodies, frames[0]) if frames else Pose()
    return frame @ pose if frame is not None and isinstance(pose, Pose) else None
