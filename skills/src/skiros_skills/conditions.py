"""The words of the kitting domain (paper §7.1): conditions, each a pattern over the world."""

from __future__ import annotations

from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    ConditionType,
    Exists,
    Has,
    IsA,
    Nothing,
    Pattern,
    Related,
    Role,
)
from skiros_py.world import vocabulary as v
from skiros_skills import kitting

HAS_PART = ConditionType(
    "HasPart",
    (Role("whole", v.SPATIAL_THING), Role("part", v.SPATIAL_THING)),
    Related(v.HAS_A, "whole", "part"),
    "One thing is built of another.",
)
ROBOT_AT_LOCATION = ConditionType(
    "RobotAtLocation",
    (Role("robot", v.ROBOT), Role("location", v.LOCATION)),
    Related(v.AT, "robot", "location"),
    "The robot stands where it can work at the location.",
)
_DOCKED = AnyOf(
    (
        Related(v.AT, "robot", "location"),
        Exists("dock", v.STATION, AllOf((Related(v.HAS_A, "location", "dock"), Related(v.AT, "robot", "dock")))),
    )
)
DOCKED_AT = ConditionType(
    "DockedAt",
    (Role("robot", v.ROBOT), Role("location", v.LOCATION)),
    _DOCKED,
    "The robot stands at the location or at one of the docking places that the location has.",
)


def _below(pattern: Pattern) -> Pattern:
    """Returns that a pattern holds for something that stands on the location."""
    upper = pattern.rename({"location": "upper"})
    return Exists("upper", v.LOCATION, AllOf((Related(v.ON, "upper", "location"), upper)))


STANDS_BY = ConditionType(
    "StandsBy",
    (Role("robot", v.ROBOT), Role("location", v.LOCATION)),
    AnyOf((_DOCKED, _below(_DOCKED), _below(_below(_DOCKED)))),
    "The robot is docked at the location, or at something that stands on it or on what stands on it.",
)
REACHES = ConditionType(
    "Reaches",
    (Role("robot", v.ROBOT), Role("location", v.LOCATION)),
    Computed(v.REACHES, "robot", "location"),
    "The robot works at the location from where it stands, without a base.",
)
HAS_DOCKS = ConditionType(
    "HasDocks",
    (Role("location", v.LOCATION),),
    Exists("dock", v.STATION, Related(v.HAS_A, "location", "dock")),
    "The location has docking places: several robots can work there.",
)
LOCATION_FREE = ConditionType(
    "LocationFree",
    (Role("location", v.LOCATION),),
    Nothing(v.AT, "location"),
    "No robot stands at the location.",
)
CAN_BE_WORKED_AT = ConditionType(
    "CanBeWorkedAt",
    (Role("location", v.LOCATION),),
    Has(v.DRIVING_POSE, "location"),
    "Somebody taught where to stand at the location.",
)
OBJECT_AT_LOCATION = ConditionType(
    "ObjectAtLocation",
    (Role("object", v.MANIPULATABLE), Role("location", v.CONTAINER)),
    Related(v.IN, "object", "location"),
    "The object lies in the container.",
    abstract=True,
)
IN_STORAGE = ConditionType(
    "InStorage",
    (Role("object", v.MANIPULATABLE), Role("location", v.LOCATION)),
    AllOf((IsA("location", kitting.STORAGE_PLACE), Related(v.IN, "object", "location"))),
    "The object lies in the storage place.",
)
LIES_ON = ConditionType(
    "LiesOn",
    (Role("object", v.MANIPULATABLE), Role("location", v.LOCATION)),
    AllOf((Related(v.ON, "object", "location"), Has(v.POSE, "object"))),
    "The object lies on the location, and it is known where.",
)
MAY_BE_IN = ConditionType(
    "MayBeIn",
    (Role("object", v.MANIPULATABLE), Role("location", v.CONTAINER)),
    Related(v.MAY_BE_IN, "object", "location"),
    "The object was let go over the container, and has not been seen there yet.",
)
HANDED_OVER = ConditionType(
    "HandedOver",
    (Role("object", v.MANIPULATABLE), Role("shelf", kitting.HANDOVER_SHELF)),
    Related(v.IN, "object", "shelf"),
    "The object lies on the shelf, for other robots to take.",
    abstract=True,
)
IN_KIT = ConditionType(
    "InKit",
    (Role("object", v.MANIPULATABLE), Role("kit", kitting.KIT)),
    Exists(
        "compartment",
        kitting.COMPARTMENT,
        AllOf((Related(v.HAS_A, "kit", "compartment"), Related(v.IN, "object", "compartment"))),
    ),
    "The object lies in some compartment of the kit.",
    abstract=True,
)
HOLDING = ConditionType(
    "Holding",
    (Role("gripper", v.GRIPPER), Role("object", v.MANIPULATABLE)),
    Related(v.HELD_BY, "object", "gripper"),
    "The gripper holds the object.",
    abstract=True,
)
EMPTY_HANDED = ConditionType(
    "EmptyHanded",
    (Role("gripper", v.GRIPPER),),
    Nothing(v.HELD_BY, "gripper"),
    "The gripper holds nothing.",
)
LOCATION_EMPTY = ConditionType(
    "LocationEmpty",
    (Role("location", kitting.COMPARTMENT),),
    Nothing(v.IN, "location"),
    "Nothing lies in the compartment.",
)
CARRYING = ConditionType(
    "Carrying",
    (Role("robot", v.ROBOT), Role("object", v.SPATIAL_THING)),
    Exists("deck", v.DECK, AllOf((Related(v.HAS_A, "robot", "deck"), Related(v.ON, "object", "deck")))),
    "The object stands on the robot and rides with it.",
)
GRASPABLE = ConditionType(
    "Graspable",
    (Role("object", v.MANIPULATABLE), Role("gripper", v.GRIPPER)),
    Computed(v.GRASPABLE_BY, "object", "gripper"),
    "The object is narrow enough for the gripper.",
)
FITS_IN = ConditionType(
    "FitsIn",
    (Role("object", v.MANIPULATABLE), Role("container", kitting.COMPARTMENT)),
    Computed(v.FITS_IN, "object", "container"),
    "The object is small enough for the compartment.",
)
