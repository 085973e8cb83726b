"""The tiny domain with a battery: driving empties it, a charger fills it, thirty at a time, up to a hundred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from skiros_py.planning.problem.task import Capability
from skiros_py.skills.conditions import Compare, ConditionType, Decrease, Increase, Role
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, HAS_PART, PICK, PLACE
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

CHARGE = "tiny:charge"
_ROBOT = Role("robot", "sk:Robot")


def at_least(charge: float) -> ConditionType:
    """Returns the condition that a robot has some charge."""
    return ConditionType("ChargeAtLeast", (_ROBOT,), Compare(CHARGE, ">=", "robot", charge), "-")


def at_most(charge: float) -> ConditionType:
    """Returns the condition that a robot has no more charge."""
    return ConditionType("ChargeAtMost", (_ROBOT,), Compare(CHARGE, "<=", "robot", charge), "-")


def uses(charge: float) -> ConditionType:
    """Returns the effect that a robot uses some charge."""
    return ConditionType("UsesCharge", (_ROBOT,), Decrease(CHARGE, "robot", charge), "-")


def gains(charge: float) -> ConditionType:
    """Returns the effect that a robot gets some charge."""
    return ConditionType("GainsCharge", (_ROBOT,), Increase(CHARGE, "robot", charge), "-")


FULL = ConditionType("Full", (_ROBOT,), Compare(CHARGE, "=", "robot", 100), "-")

_CHARGING = SkillDescription(
    name="recharge",
    help="Charges at a door with a socket.",
    agent="Base",
    target="Socket",
    params=(
        Param("Base", "sk:Base", "The base.", Kind.HARDWARE),
        Param("Robot", "sk:Robot", "Its robot.", Kind.PLANNING),
        Param("Socket", "tiny:Door", "Where the charger is."),
    ),
    pre=(HAS_PART("Robot", "Base"), AT_LOCATION("Robot", "Socket")),
    post=(gains(30)("Robot"),),
)


def charging(gain: ConditionType | None = None, room: float | None = 70) -> SkillDescription:
    """Returns the skill to charge, with another effect, where the battery has no more charge than a limit."""
    pre = _CHARGING.pre if room is None else (*_CHARGING.pre, at_most(room)("Robot"))
    return replace(_CHARGING, pre=pre, post=_CHARGING.post if gain is None else (gain("Robot"),))


def driving(need: float = 25.0, cost: float = 25.0) -> SkillDescription:
    """Returns the skill to drive, which needs some charge and uses some."""
    return replace(DRIVE, pre=(*DRIVE.pre, at_least(need)("Robot")), post=(*DRIVE.post, uses(cost)("Robot")))


SKILLS = (driving(), PICK, PLACE, charging())


def battery_world(charge: float | None, *facts: str, robots: int = 1) -> World:
    """Returns the tiny scene with a charger, at which all robots stand with some charge."""
    names = [f"robot_{number}" for number in range(1, robots + 1)]
    charged = [f"scene:{name} {CHARGE} {charge} ." for name in names if charge is not None]
    socket = 'scene:socket_1 a tiny:Door ; sk:drivingPose "-1 0 0 0 0 0"^^sk:poseLiteral ; sk:on scene:floor .'
    world = tiny_world(socket, *charged, *facts, robots=robots)
    with world.transaction("test", "at the charger") as tx:
        for name in names:
            tx.place(name, "sk:at", "socket_1")
    return world


def able(view: WorldView, skills: Sequence[SkillDescription] = SKILLS) -> list[Capability]:
    """Returns the skills, each with every subsystem that can have it."""
    return [Capability(skill, view.instances(skill.agent_class)) for skill in skills]
