"""Search: the arm looks whether a part lies in the compartment over which it was let go."""

from __future__ import annotations

from skiros_py.behaviours import AssertEffects, Check, Do, Fallback, P, Sequence
from skiros_py.skills.conditions import any_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.vocabulary import ARM, CAMERA, GRIPPER, MANIPULATABLE, ROBOT
from skiros_skills import kitting
from skiros_skills.conditions import (
    CARRYING,
    DOCKED_AT,
    EMPTY_HANDED,
    HAS_DOCKS,
    HAS_PART,
    LOCATION_EMPTY,
    MAY_BE_IN,
    OBJECT_AT_LOCATION,
    REACHES,
)

DESCRIPTION = SkillDescription(
    name="search",
    help="Searches the compartment over which a part was let go.",
    agent="Arm",
    target="Object",
    params=(
        Param("Arm", ARM, "The arm that carries the camera.", Kind.HARDWARE),
        Param("Gripper", GRIPPER, "The gripper on the arm.", Kind.HARDWARE),
        Param("Camera", CAMERA, "The camera on the arm.", Kind.HARDWARE),
        Param("View", CAMERA, "Looks at the place; left open: the camera that sees it best.", Kind.OPTIONAL),
        Param("Robot", ROBOT, "The robot that has the arm.", Kind.PLANNING),
        Param("Object", MANIPULATABLE, "The part."),
        Param("Compartment", kitting.COMPARTMENT, "Where the part may be."),
        Param("Kit", kitting.KIT, "The kit that has the compartment.", Kind.PLANNING),
    ),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        HAS_PART("Arm", "Camera"),
        HAS_PART("Kit", "Compartment"),
        any_of(DOCKED_AT("Robot", "Kit"), CARRYING("Robot", "Kit"), REACHES("Robot", "Kit")),
        MAY_BE_IN("Object", "Compartment"),
        LOCATION_EMPTY("Compartment"),
        EMPTY_HANDED("Gripper"),
    ),
    post=(OBJECT_AT_LOCATION("Object", "Compartment"),),
    duration=3.0,
)

SEARCH = Skill(
    DESCRIPTION,
    Sequence.of(
        Do.of("register_kit", arm=P("Arm"), camera=P("Camera"), kit=P("Kit")),
        Do.of("verify_place", arm=P("Arm"), camera=P("View"), part=P("Object"), compartment=P("Compartment")),
    ),
    finish=Fallback.of(Check.of(~HAS_DOCKS("Kit")), Do.of("move_arm", arm=P("Arm"))),  # others may work there, too
    takes=("Kit",),
)
SEARCH_FAKE = Skill(DESCRIPTION, AssertEffects(seconds=3.0), driver="fake")
