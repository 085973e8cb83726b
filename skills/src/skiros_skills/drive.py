"""Drive: the base takes its robot to where a location can be worked at."""

from __future__ import annotations

from skiros_py.behaviours import AssertEffects, Do, P
from skiros_py.skills.conditions import any_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.vocabulary import BASE, LOCATION, ROBOT
from skiros_skills.conditions import CAN_BE_WORKED_AT, HAS_PART, LOCATION_FREE, ROBOT_AT_LOCATION

DESCRIPTION = SkillDescription(
    name="drive",
    help="Drives the robot to a location.",
    agent="Base",
    target="Location",
    params=(
        Param("Base", BASE, "The base that drives.", Kind.HARDWARE),
        Param("Robot", ROBOT, "The robot it carries.", Kind.PLANNING),
        Param("Location", LOCATION, "Where to go."),
    ),
    pre=(
        HAS_PART("Robot", "Base"),
        CAN_BE_WORKED_AT("Location"),
        any_of(ROBOT_AT_LOCATION("Robot", "Location"), LOCATION_FREE("Location")),  # one place takes one robot
    ),
    post=(ROBOT_AT_LOCATION("Robot", "Location"),),
    duration=12.0,
)

DRIVE = Skill(
    DESCRIPTION,
    Do.of("drive_base", base=P("Base"), robot=P("Robot"), location=P("Location")),
    takes=("Robot",),  # its arms are stowed and reach out while the base drives
)
DRIVE_FAKE = Skill(DESCRIPTION, AssertEffects(seconds=5.0), driver="fake")
