"""The words of the kitting domain (paper §7.1): conditions, each a pattern over the world."""

from __future__ import annotations

from skiros_py.geometry import Solid
from skiros_py.skills.conditions import (
    AllOf,
    Computed,
    ConditionType,
    Exists,
    Has,
    Nothing,
    Related,
    Role,
    Verdict,
)
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, DRIVING_POSE, GRASP_WIDTH, HAS_A, HELD_BY, IN, MAX_GAP, ON, SOLID

__all__ = [
    "CAN_BE_WORKED_AT",
    "CARRYING",
    "EMPTY_HANDED",
    "FITS_IN",
    "GRASPABLE",
    "HAS_PART",
    "HOLDING",
    "IN_KIT",
    "LOCATION_EMPTY",
    "OBJECT_AT_LOCATION",
    "ROBOT_AT_LOCATION",
]

_CLEARANCE = 0.008
"""A part fits when it leaves at least this much room in both directions [m]."""


def _fits(view: WorldView, part: str, container: str) -> Verdict:
    """Compares the part's footprint with the inside of the container."""
    shapes = [view.value(part, SOLID), view.value(container, SOLID)]
    if None in shapes:
        return Verdict(False, f"the size of {part if shapes[0] is None else container} is not known")
    (low, high), (inner_low, inner_high) = (Solid.from_json(str(shape)).bounds() for shape in shapes)
    wanted, room = sorted(high[:2] - low[:2]), sorted(inner_high[:2] - inner_low[:2])
    holds = all(w + _CLEARANCE <= r for w, r in zip(wanted, room, strict=True))
    sizes = f"{wanted[0]:.3f} x {wanted[1]:.3f} m into {room[0]:.3f} x {room[1]:.3f} m"
    return Verdict(holds, f"{part} {'fits' if holds else 'does not fit'} into {container}: {sizes}")


def _graspable(view: WorldView, part: str, gripper: str) -> Verdict:
    """Compares the part's width where it is grasped with the gripper's greatest gap."""
    width, gap = view.value(part, GRASP_WIDTH), view.value(gripper, MAX_GAP)
    if not isinstance(width, float) or not isinstance(gap, float):
        return Verdict(False, f"{part} has no sk:graspWidth, or {gripper} no sk:maxGap")
    return Verdict(width < gap, f"{part} is {width:.3f} m wide, {gripper} opens {gap:.3f} m")


HAS_PART = ConditionType(
    "HasPart",
    (Role("whole", "sk:SpatialThing"), Role("part", "sk:SpatialThing")),
    Related(HAS_A, "whole", "part"),
    "One thing is built of another.",
)
ROBOT_AT_LOCATION = ConditionType(
    "RobotAtLocation",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Related(AT, "robot", "location"),
    "The robot stands where it can work at the location.",
)
CAN_BE_WORKED_AT = ConditionType(
    "CanBeWorkedAt",
    (Role("location", "sk:Location"),),
    Has(DRIVING_POSE, "location"),
    "Somebody taught where to stand at the location.",
)
OBJECT_AT_LOCATION = ConditionType(
    "ObjectAtLocation",
    (Role("object", "sk:Manipulatable"), Role("location", "sk:Container")),
    Related(IN, "object", "location"),
    "The object lies in the container.",
    abstract=True,
)
IN_KIT = ConditionType(
    "InKit",
    (Role("object", "sk:Manipulatable"), Role("kit", "kitting:Kit")),
    Exists(
        "compartment",
        "kitting:Compartment",
        AllOf((Related(HAS_A, "kit", "compartment"), Related(IN, "object", "compartment"))),
    ),
    "The object lies in some compartment of the kit.",
    abstract=True,
)
HOLDING = ConditionType(
    "Holding",
    (Role("gripper", "sk:Gripper"), Role("object", "sk:Manipulatable")),
    Related(HELD_BY, "object", "gripper"),
    "The gripper holds the object.",
    abstract=True,
)
EMPTY_HANDED = ConditionType(
    "EmptyHanded",
    (Role("gripper", "sk:Gripper"),),
    Nothing(HELD_BY, "gripper"),
    "The gripper holds nothing.",
)
LOCATION_EMPTY = ConditionType(
    "LocationEmpty",
    (Role("location", "kitting:Compartment"),),
    Nothing(IN, "location"),
    "Nothing lies in the compartment.",
)
CARRYING = ConditionType(
    "Carrying",
    (Role("robot", "sk:Robot"), Role("object", "sk:SpatialThing")),
    Exists("deck", "sk:Deck", AllOf((Related(HAS_A, "robot", "deck"), Related(ON, "object", "deck")))),
    "The object stands on the robot and rides with it.",
)
GRASPABLE = ConditionType(
    "Graspable",
    (Role("object", "sk:Manipulatable"), Role("gripper", "sk:Gripper")),
    Computed("kitting:graspableBy", "object", "gripper", _graspable),
    "The object is narrow enough for the gripper.",
)
FITS_IN = ConditionType(
    "FitsIn",
    (Role("object", "sk:Manipulatable"), Role("container", "kitting:Compartment")),
    Computed("kitting:fitsIn", "object", "container", _fits),
    "The object is small enough for the compartment.",
)
