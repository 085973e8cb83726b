"""Hand over: the arm puts the part it holds onto a shelf, from which other robots take it."""

from __future__ import annotations

from skiros_py.behaviours import AssertEffects, Do, P, Sequence
from skiros_py.skills.conditions import any_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.vocabulary import ARM, CAMERA, GRIPPER, MANIPULATABLE, ROBOT
from skiros_skills import kitting
from skiros_skills.conditions import EMPTY_HANDED, HANDED_OVER, HAS_PART, HOLDING, REACHES, ROBOT_AT_LOCATION

DESCRIPTION = SkillDescription(
    name="hand_over",
    help="Puts a held part onto a shelf, for other robots to take.",
    agent="Arm",
    target="Shelf",
    params=(
        Param("Arm", ARM, "The arm that holds the part.", Kind.HARDWARE),
        Param("Gripper", GRIPPER, "The gripper on the arm.", Kind.HARDWARE),
        Param("Camera", CAMERA, "The camera on the arm.", Kind.HARDWARE),
        Param("View", CAMERA, "Looks at the place; left open: the camera that sees it best.", Kind.OPTIONAL),
        Param("Robot", ROBOT, "The robot that has the arm.", Kind.PLANNING),
        Param("Object", MANIPULATABLE, "The part."),
        Param("Shelf", kitting.HANDOVER_SHELF, "Where the part goes."),
    ),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        HAS_PART("Arm", "Camera"),
        any_of(ROBOT_AT_LOCATION("Robot", "Shelf"), REACHES("Robot", "Shelf")),
        HOLDING("Gripper", "Object"),
    ),
    post=(HANDED_OVER("Object", "Shelf"), EMPTY_HANDED("Gripper")),
    duration=7.5,
)

HAND_OVER = Skill(
    DESCRIPTION,
    Sequence.of(
        Do.of("put_back", arm=P("Arm"), gripper=P("Gripper"), part=P("Object"), place=P("Shelf")),
        Do.of("locate", arm=P("Arm"), camera=P("View"), place=P("Shelf"), part=P("Object")),
    ),
    finish=Do.of("move_arm", arm=P("Arm")),  # others work there, too
    takes=("Shelf",),
)
HAND_OVER_FAKE = Skill(DESCRIPTION, AssertEffects(seconds=5.0), driver="fake")
