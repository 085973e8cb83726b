"""Compares beliefs with the ground truth of the simulator; only the final report may do so."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.cell import CellSpec
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.truth import Truth
from skiros_py.skills.conditions import Condition, Exists, Nothing, Pattern, Related
from skiros_py.skills.conditions.pattern import leaves
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Element
from skiros_py.world.overlay import Overlay
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView

Whereabouts = tuple[Mapping[str, Pose], Mapping[str, str]]
"""Poses in the map, and placements of movable bodies; by the ids of bodies."""

_THERE = (0.06, 0.06)
"""Maximum distance of a robot from the pose of a location at which it counts as being there [m, rad]."""


def judge(cell: SimulatedCell, spec: CellSpec, view: WorldView, goal: Sequence[Condition]) -> tuple[bool | None, ...]:
    """Evaluates conditions on the ground truth; None for conditions that the simulator does not cover.

    Args:
        cell: The simulation.
        spec: The cell as brought up.
        view: The believed world, for classes, structure and everything that is not physical.
        goal: Conditions over elements and classes.
    """
    truth = Truth(cell)
    real = Overlay(view)
    placements = truth.placements()
    types = {body.id: body.type for body in spec.bodies}
    for body in placements.keys() & types.keys():
        if not view.has(body):  # in stock, or taken from stock: the individual is unknown
            real.extend(Element(body, types[body], body))
    for part in real.instances(v.MANIPULATABLE):
        place = placements.get(part)
        if place is None:
            real.unplace(part)
        else:
            real.place(part, _relation(view, place), place if view.has(place) else _floor(view))
    for robot in spec.robots:
        if robot.carrier is not None and robot.carrier.id in cell.devices:  # others are not simulated
            real.place(robot.id, v.AT, _location(view, truth, robot.carrier.id))
    unknown = {part for part in view.instances(v.MANIPULATABLE) if part not in types}
    can_tell = (_is_physical(c.pattern, view) and unknown.isdisjoint(c.arguments) for c in goal)
    return tuple(bool(c.evaluate(real)) if can else None for c, can in zip(goal, can_tell, strict=True))


def true_whereabouts(cell: SimulatedCell) -> Callable[[], Whereabouts]:
    """Takes the true state of all bodies, for display; quick.

    Args:
        cell: The simulation.

    Returns:
        A function that computes the whereabouts, callable in any thread.
    """
    glance = Truth(cell).glance()
    return lambda: (glance.poses, glance.placements())


def _is_physical(pattern: Pattern, view: WorldView) -> bool:
    """Returns whether a pattern concerns only where elements are."""
    atoms = (leaf for leaf, _ in leaves(pattern) if not isinstance(leaf, Exists))
    physical = (Family.PLACEMENT, Family.STRUCTURE)
    return all(isinstance(one, Related | Nothing) and view.ontology.family(one.relation) in physical for one in atoms)


def _relation(view: WorldView, place: str) -> str:
    if place == "floor" or not view.has(place):  # or on a body unknown to the robot
        return v.ON
    type_ = view.element(place).type
    if view.ontology.is_a(type_, v.GRIPPER):
        return v.HELD_BY
    return v.IN if view.ontology.is_a(type_, v.CONTAINER) else v.ON


def _floor(view: WorldView) -> str:
    return view.instances(v.FLOOR)[0]


def _location(view: WorldView, truth: Truth, base: str) -> str:
    """Returns the true location of a robot: the location at whose driving pose it stands, or the floor."""
    bodies = truth.poses()
    at = truth.base_pose(base)
    for location in view.instances(v.LOCATION):
        driving, place = view.value(location, v.DRIVING_POSE), _pose(view, bodies, location)
        if isinstance(driving, Pose) and place is not None:
            wanted = place @ driving
            off = ((at.position[0] - wanted.position[0]) ** 2 + (at.position[1] - wanted.position[1]) ** 2) ** 0.5
            if off <= _THERE[0] and abs(wrap_angle(at.yaw - wanted.yaw)) <= _THERE[1]:
                return location
    return _floor(view)


def _pose(view: WorldView, bodies: Mapping[str, Pose], element: str) -> Pose | None:
    """Returns the true pose of an element: a body, or a spot fixed to a body or to the map."""
    if element in bodies or not view.ontology.is_a(view.element(element).type, v.STATION):
        return bodies.get(element)
    pose, frames = view.value(element, v.POSE), view.objects(element, v.POSE_FRAME)
    frame = _pose(view, bodies, frames[0]) if frames else Pose()
    return frame @ pose if frame is not None and isinstance(pose, Pose) else None
