"""Words and pretended skills of the tiny domain: drive to a box, pick a ball, place it in a slot."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from skiros_py.behaviours import AssertEffects, Behaviour
from skiros_py.skills.conditions import Computed, ConditionType, Has, Nothing, Related, Role, Verdict
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, DRIVING_POSE, HAS_A, HELD_BY, IN


def _fits(view: WorldView, ball: str, slot: str) -> Verdict:
    giant = view.ontology.is_a(view.element(ball).type, "tiny:Giant")
    return Verdict(not giant, f"{ball} {'does not fit' if giant else 'fits'} into {slot}")


HAS_PART = ConditionType(
    "HasPart", (Role("whole", "sk:SpatialThing"), Role("part", "sk:SpatialThing")), Related(HAS_A, "whole", "part"), "-"
)
AT_LOCATION = ConditionType(
    "At",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Related(AT, "robot", "location"),
    "Stands there.",
)
REACHABLE = ConditionType("Reachable", (Role("location", "sk:Location"),), Has(DRIVING_POSE, "location"), "Known way.")
IN_CONTAINER = ConditionType(
    "In", (Role("ball", "tiny:Ball"), Role("place", "sk:Container")), Related(IN, "ball", "place"), "Lies in.", True
)
HOLDING = ConditionType(
    "Holding",
    (Role("gripper", "sk:Gripper"), Role("ball", "tiny:Ball")),
    Related(HELD_BY, "ball", "gripper"),
    "Has it.",
)
EMPTY_HANDED = ConditionType("EmptyHanded", (Role("gripper", "sk:Gripper"),), Nothing(HELD_BY, "gripper"), "Holds nil.")
FREE = ConditionType("Free", (Role("slot", "tiny:Slot"),), Nothing(IN, "slot"), "Nothing lies in the slot.")
FITS = ConditionType(
    "Fits", (Role("ball", "tiny:Ball"), Role("slot", "tiny:Slot")), Computed("tiny:fitsIn", "ball", "slot", _fits), "-"
)
CARRIES = ConditionType(
    "Carries",
    (Role("robot", "sk:Robot"), Role("ball", "tiny:Ball")),
    Related("tiny:carries", "robot", "ball"),
    "Rides.",
)

CONDITIONS: Mapping[str, ConditionType] = MappingProxyType(
    {
        type_.name: type_
        for type_ in (HAS_PART, AT_LOCATION, REACHABLE, IN_CONTAINER, HOLDING, EMPTY_HANDED, FREE, FITS, CARRIES)
    }
)
"""The words of the tiny domain."""

_ARM = (
    Param("Arm", "sk:Arm", "The arm that does it.", Kind.HARDWARE),
    Param("Gripper", "sk:Gripper", "The gripper on the arm.", Kind.HARDWARE),
    Param("Robot", "sk:Robot", "The robot that has the arm.", Kind.PLANNING),
)

DRIVE = SkillDescription(
    name="drive",
    help="Drives to a location.",
    agent="Base",
    target="Location",
    params=(
        Param("Base", "sk:Base", "The base that drives.", Kind.HARDWARE),
        Param("Robot", "sk:Robot", "The robot it carries.", Kind.PLANNING),
        Param("Location", "sk:Location", "Where to go."),
    ),
    pre=(HAS_PART("Robot", "Base"), REACHABLE("Location")),
    post=(AT_LOCATION("Robot", "Location"),),
)
PICK = SkillDescription(
    name="pick",
    help="Takes a ball out of a box.",
    agent="Arm",
    target="Ball",
    params=(*_ARM, Param("Box", "tiny:Box", "Where it lies."), Param("Ball", "tiny:Ball", "The ball.")),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        AT_LOCATION("Robot", "Box"),
        IN_CONTAINER("Ball", "Box"),
        EMPTY_HANDED("Gripper"),
    ),
    post=(HOLDING("Gripper", "Ball"), ~EMPTY_HANDED("Gripper")),
)
PLACE = SkillDescription(
    name="place",
    help="Puts a ball into a free slot.",
    agent="Arm",
    target="Slot",
    params=(*_ARM, Param("Ball", "tiny:Ball", "The ball."), Param("Slot", "tiny:Slot", "Where it goes.")),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        HOLDING("Gripper", "Ball"),
        FREE("Slot"),
        FITS("Ball", "Slot"),
    ),
    post=(IN_CONTAINER("Ball", "Slot"), EMPTY_HANDED("Gripper")),
)


_PRETENDING = AssertEffects(seconds=0.02)


def pretend(description: SkillDescription, body: Behaviour = _PRETENDING) -> Skill:
    """Returns an implementation for the fake driver: by default one that only pretends."""
    return Skill(description, body, driver="fake")


SKILLS: tuple[Skill, ...] = (pretend(DRIVE), pretend(PICK), pretend(PLACE))
"""Pretended drive, pick and place."""
