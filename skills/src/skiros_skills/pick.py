"""Pick: the arm takes a part out of a storage place, or from where it was seen to lie."""

from __future__ import annotations

from skiros_py.behaviours import AssertEffects, Do, Fallback, P, Parallel, Sequence
from skiros_py.skills.conditions import all_of, any_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.vocabulary import ARM, CAMERA, GRIPPER, LOCATION, MANIPULATABLE, ROBOT
from skiros_skills.conditions import (
    CARRYING,
    EMPTY_HANDED,
    GRASPABLE,
    HAS_PART,
    HOLDING,
    IN_STORAGE,
    LIES_ON,
    REACHES,
    ROBOT_AT_LOCATION,
    STANDS_BY,
)

DESCRIPTION = SkillDescription(
    name="pick",
    help="Picks a part from a storage place, or from where it lies.",
    agent="Arm",
    target="Object",
    params=(
        Param("Arm", ARM, "The arm that picks.", Kind.HARDWARE),
        Param("Gripper", GRIPPER, "The gripper on the arm.", Kind.HARDWARE),
        Param("Camera", CAMERA, "The camera on the arm.", Kind.HARDWARE),
        Param("View", CAMERA, "Looks at the place; left open: the camera that sees it best.", Kind.OPTIONAL),
        Param("Robot", ROBOT, "The robot that has the arm.", Kind.PLANNING),
        Param("Container", LOCATION, "Where the part lies."),
        Param("Object", MANIPULATABLE, "The part."),
    ),
    pre=(
        HAS_PART("Robot", "Arm"),
        HAS_PART("Arm", "Gripper"),
        HAS_PART("Arm", "Camera"),
        any_of(IN_STORAGE("Object", "Container"), LIES_ON("Object", "Container")),
        any_of(
            ROBOT_AT_LOCATION("Robot", "Container"),
            REACHES("Robot", "Container"),
            all_of(
                LIES_ON("Object", "Container"),
                any_of(STANDS_BY("Robot", "Container"), CARRYING("Robot", "Container"), HAS_PART("Robot", "Container")),
            ),
        ),
        GRASPABLE("Object", "Gripper"),
        EMPTY_HANDED("Gripper"),
    ),
    post=(HOLDING("Gripper", "Object"), ~EMPTY_HANDED("Gripper")),
    duration=5.0,
)

PICK = Skill(
    DESCRIPTION,
    Sequence.of(
        Parallel.of(
            Do.of("gripper_control", gripper=P("Gripper"), part=P("Object")),
            Do.of("locate", arm=P("Arm"), camera=P("View"), place=P("Container"), part=P("Object")),
        ),
        Do.of("register_part", arm=P("Arm"), camera=P("Camera"), part=P("Object")),
        Do.of("grasp", arm=P("Arm"), gripper=P("Gripper"), camera=P("Camera"), part=P("Object")),
    ),
    finish=Fallback.of(  # what cannot be carried on goes back where it came from; the drive stows the arm
        Do.of("move_arm", arm=P("Arm"), rehearse=True),
        Sequence.of(
            Do.of("put_back", arm=P("Arm"), gripper=P("Gripper"), part=P("Object"), place=P("Container")),
            Do.of("move_arm", arm=P("Arm")),
        ),
    ),
    takes=("Container",),  # several robots may reach it
    # fingers that have lost the part meanwhile close, which is seen by what watches them
    post_sense=Do.of("gripper_control", gripper=P("Gripper"), gap=0.0),
)
PICK_FAKE = Skill(DESCRIPTION, AssertEffects(seconds=5.0), driver="fake")
