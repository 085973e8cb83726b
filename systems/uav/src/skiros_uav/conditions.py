"""The words of robots that fly: conditions on properties of the robot, and what its arm can carry."""

from __future__ import annotations

from skiros_py.messages import Message
from skiros_py.skills.conditions import Compare, Computed, ConditionType, Role, Verdict
from skiros_py.skills.conditions.pattern import number_of
from skiros_py.world import vocabulary as v
from skiros_py.world.view import WorldView
from skiros_uav import names

LANDED = ConditionType(
    "Landed", (Role("robot", v.ROBOT),), Compare(names.LANDED, "=", "robot", True), "The robot stands on the ground."
)
FLY = ConditionType("Fly", (Role("robot", v.ROBOT),), Compare(names.LANDED, "=", "robot", False), "The robot flies.")
LOW_BATTERY = ConditionType(
    "LowBattery",
    (Role("robot", v.ROBOT),),
    Compare(names.BATTERY_LOW, "=", "robot", True),
    "The battery of the robot has to be charged.",
)


def _can_lift(view: WorldView, thing: str, arm: str) -> Verdict:
    mass, most = number_of(view, thing, v.MASS), number_of(view, arm, names.MAX_LOAD)
    said = {"thing": thing, "arm": arm}
    if mass is None or most is None:
        return Verdict(False, Message("it is not known whether {arm} can carry {thing} in flight", **said))
    said |= {"most": f"{most:g}", "mass": f"{mass:g}"}
    if mass > most:
        return Verdict(False, Message("{thing} has {mass} kg, and {arm} carries {most} kg at most in flight", **said))
    return Verdict(True, Message("{arm} carries {thing} in flight", **said))


LIFTABLE = ConditionType(
    "Liftable",
    (Role("object", v.MANIPULATABLE), Role("arm", names.AERIAL_ARM)),
    Computed("uav:liftableBy", "object", "arm", _can_lift),
    "The object is light enough for the arm in flight.",
)
