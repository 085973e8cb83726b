"""The words of the kitting domain (paper §7.1): conditions, each a pattern over the world."""

from __future__ import annotations

from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    ConditionType,
    Exists,
    Has,
    Nothing,
    Related,
    Role,
)
from skiros_py.world import vocabulary
from skiros_py.world.vocabulary import (
    AT,
    CONTAINER,
    DECK,
    DRIVING_POSE,
    GRASPABLE_BY,
    GRIPPER,
    HAS_A,
    HELD_BY,
    IN,
    LOCATION,
    MANIPULATABLE,
    ON,
    ROBOT,
    SPATIAL_THING,
    STATION,
)
from skiros_skills import kitting

HAS_PART = ConditionType(
    "HasPart",
    (Role("whole", SPATIAL_THING), Role("part", SPATIAL_THING)),
    Related(HAS_A, "whole", "part"),
    "One thing is built of another.",
)
ROBOT_AT_LOCATION = ConditionType(
    "RobotAtLocation",
    (Role("robot", ROBOT), Role("location", LOCATION)),
    Related(AT, "robot", "location"),
    "The robot stands where it can work at the location.",
)
DOCKED_AT = ConditionType(
    "DockedAt",
    (Role("robot", ROBOT), Role("location", LOCATION)),
    AnyOf(
        (
            Related(AT, "robot", "location"),
            Exists("dock", STATION, AllOf((Related(HAS_A, "location", "dock"), Related(AT, "robot", "dock")))),
        )
    ),
    "The robot stands at the location or at one of the docking places that the location has.",
)
LOCATION_FREE = ConditionType(
    "LocationFree",
    (Role("location", LOCATION),),
    Nothing(AT, "location"),
    "No robot stands at the location.",
)
CAN_BE_WORKED_AT = ConditionType(
    "CanBeWorkedAt",
    (Role("location", LOCATION),),
    Has(DRIVING_POSE, "location"),
    "Somebody taught where to stand at the location.",
)
OBJECT_AT_LOCATION = ConditionType(
    "ObjectAtLocation",
    (Role("object", MANIPULATABLE), Role("location", CONTAINER)),
    Related(IN, "object", "location"),
    "The object lies in the container.",
    abstract=True,
)
IN_KIT = ConditionType(
    "InKit",
    (Role("object", MANIPULATABLE), Role("kit", kitting.KIT)),
    Exists(
        "compartment",
        kitting.COMPARTMENT,
        AllOf((Related(HAS_A, "kit", "compartment"), Related(IN, "object", "compartment"))),
    ),
    "The object lies in some compartment of the kit.",
    abstract=True,
)
HOLDING = ConditionType(
    "Holding",
    (Role("gripper", GRIPPER), Role("object", MANIPULATABLE)),
    Related(HELD_BY, "object", "gripper"),
    "The gripper holds the object.",
    abstract=True,
)
EMPTY_HANDED = ConditionType(
    "EmptyHanded",
    (Role("gripper", GRIPPER),),
    Nothing(HELD_BY, "gripper"),
    "The gripper holds nothing.",
)
LOCATION_EMPTY = ConditionType(
    "LocationEmpty",
    (Role("location", kitting.COMPARTMENT),),
    Nothing(IN, "location"),
    "Nothing lies in the compartment.",
)
CARRYING = ConditionType(
    "Carrying",
    (Role("robot", ROBOT), Role("object", SPATIAL_THING)),
    Exists("deck", DECK, AllOf((Related(HAS_A, "robot", "deck"), Related(ON, "object", "deck")))),
    "The object stands on the robot and rides with it.",
)
GRASPABLE = ConditionType(
    "Graspable",
    (Role("object", MANIPULATABLE), Role("gripper", GRIPPER)),
    Computed(GRASPABLE_BY, "object", "gripper"),
    "The object is narrow enough for the gripper.",
)
FITS_IN = ConditionType(
    "FitsIn",
    (Role("object", MANIPULATABLE), Role("container", kitting.COMPARTMENT)),
    Computed(vocabulary.FITS_IN, "object", "container"),
    "The object is small enough for the compartment.",
)
