"""Place: the arm puts the part it holds into a compartment of a kit, on a table or carried along."""

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
    FITS_IN,
    HAS_DOCKS,
    HAS_PART,
    HOLDING,
    LOCATION_EMPTY,
    OBJECT_AT_LOCATION,
    REACHES,
)

DESCRIPTION = SkillDescription(
    name="place",
    help="Places a held part into a compartment of a kit.",
    agent="Arm",
    target="Compartment",
    params=(
        Param("Arm", ARM, "The arm that places.", Kind.HARDWARE),
        Param("Gripper", GRIPPER, "The gripper on the arm.", Kind.HARDWARE),
        Param("Camera", CAMERA, "The camera on the arm.", Kind.HARDWARE),
        Param("View", CAMERA, "Looks at the place; left open: the camera that sees it best.", Kind.OPTIONAL),
        Param("Robot", ROBOT, "The robot that has the arm.", Kind.PLANNING),
        Param("Object", MANIPULATABLE, "The part."),
        Param("Compartment", kitting.COMPARTMENT, "Where the part goes."),
        Param("Kit", kitting.KIT, "The kit that has the compartment.", Kind.PLANNING),
    ),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        HAS_PART("Arm", "Camera"),
        HAS_PART("Kit", "Compartment"),
        any_of(DOCKED_AT("Robot", "Kit"), CARRYING("Robot", "Kit"), REACHES("Robot", "Kit")),
        HOLDING("Gripper", "Object"),
        LOCATION_EMPTY("Compartment"),
        FITS_IN("Object", "Compartment"),
    ),
    post=(OBJECT_AT_LOCATION("Object", "Compartment"), EMPTY_HANDED("Gripper")),
    duration=7.5,
)

PLACE = Skill(
    DESCRIPTION,
    Sequence.of(
        Do.of("register_kit", arm=P("Arm"), camera=P("Camera"), kit=P("Kit"), compartment=P("Compartment")),
        Do.of(
            "put_down",
            arm=P("Arm"),
            gripper=P("Gripper"),
            camera=P("Camera"),
            part=P("Object"),
            compartment=P("Compartment"),
        ),
        Do.of("verify_place", arm=P("Arm"), camera=P("View"), part=P("Object"), compartment=P("Compartment")),
    ),
    finish=Fallback.of(Check.of(~HAS_DOCKS("Kit")), Do.of("move_arm", arm=P("Arm"))),  # others may work there, too
    takes=("Kit",),  # only one arm at a time over a kit, from whichever side
)
PLACE_FAKE = Skill(DESCRIPTION, AssertEffects(seconds=5.0), driver="fake")
