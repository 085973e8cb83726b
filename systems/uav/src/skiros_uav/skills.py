"""Skills by air: those of any robot, refined by data, and those that only robots that fly have."""

from __future__ import annotations

from dataclasses import replace

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Start
from skiros_py.skills.conditions import any_of
from skiros_py.skills.parameters import Access, Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world import vocabulary as v
from skiros_skills.conditions import HAS_PART, LOCATION_FREE, ROBOT_AT_LOCATION
from skiros_skills.drive import DRIVE, DRIVE_FAKE
from skiros_skills.hand_over import HAND_OVER, HAND_OVER_FAKE
from skiros_skills.pick import PICK, PICK_FAKE
from skiros_skills.place import PLACE, PLACE_FAKE
from skiros_skills.search import SEARCH, SEARCH_FAKE
from skiros_uav import names
from skiros_uav.conditions import LANDED, LIFTABLE, LOW_BATTERY

_FLYING, _CHARGED = ~LANDED("Robot"), ~LOW_BATTERY("Robot")
_MONITOR = Start.of("monitor_battery", battery=P("Battery"), robot=P("Robot"))

# ---------------------------------------------------------------- the skills of any robot, by air

_DRIVE = DRIVE.description.refined(
    "drive_by_air", names.AERIAL_BASE, help="Flies the robot to a location.", pre=(_FLYING, _CHARGED), hold=(_CHARGED,)
)
DRIVE_BY_AIR = replace(
    DRIVE, description=_DRIVE, body=Do.of("fly_to_place", base=P("Base"), robot=P("Robot"), location=P("Location"))
)
DRIVE_BY_AIR_FAKE = replace(DRIVE_FAKE, description=_DRIVE)

_PICK = PICK.description.refined(
    "pick_by_air",
    names.AERIAL_ARM,
    help="Picks a part that it can carry in flight.",
    pre=(_FLYING, _CHARGED, LIFTABLE("Object", "Arm")),
)
PICK_BY_AIR = replace(PICK, description=_PICK)
PICK_BY_AIR_FAKE = replace(PICK_FAKE, description=_PICK)

_PLACE = PLACE.description.refined(
    "place_by_air",
    names.AERIAL_ARM,
    help="Places a held part in flight.",
    pre=(_FLYING, _CHARGED),
)
PLACE_BY_AIR = replace(PLACE, description=_PLACE)
PLACE_BY_AIR_FAKE = replace(PLACE_FAKE, description=_PLACE)

_HAND_OVER = HAND_OVER.description.refined(
    "hand_over_by_air",
    names.AERIAL_ARM,
    help="Puts a held part onto a shelf, in flight.",
    pre=(_FLYING, _CHARGED),
)
HAND_OVER_BY_AIR = replace(HAND_OVER, description=_HAND_OVER)
HAND_OVER_BY_AIR_FAKE = replace(HAND_OVER_FAKE, description=_HAND_OVER)

_SEARCH = SEARCH.description.refined(
    "search_by_air",
    names.AERIAL_ARM,
    help="Searches the compartment over which a part was let go, in flight.",
    pre=(_FLYING, _CHARGED),
)
SEARCH_BY_AIR = replace(SEARCH, description=_SEARCH)
SEARCH_BY_AIR_FAKE = replace(SEARCH_FAKE, description=_SEARCH)

# ---------------------------------------------------------------- taking off, landing, charging

_BASE = Param("Base", names.AERIAL_BASE, "The base that flies.", Kind.HARDWARE)
_BATTERY = Param("Battery", names.BATTERY, "Its battery.", Kind.HARDWARE, access=Access.READ)
_ROBOT = Param("Robot", v.ROBOT, "The robot it carries.", Kind.PLANNING)
_OWN = (HAS_PART("Robot", "Base"), HAS_PART("Base", "Battery"))

_TAKE_OFF = SkillDescription(
    name="fly_to_altitude",
    help="Takes off and climbs to an altitude.",
    agent="Base",
    target="Robot",
    params=(
        _BASE,
        _BATTERY,
        _ROBOT,
        Param("Altitude", "number", "Height of the skids above the ground.", Kind.OFFLINE, 1.0, "m", limits=(0.3, 5.0)),
    ),
    pre=(*_OWN, _CHARGED),
    post=(_FLYING,),
    duration=4.0,
)
FLY_TO_ALTITUDE = Skill(
    _TAKE_OFF,
    Do.of("take_off", base=P("Base"), robot=P("Robot"), altitude=P("Altitude")),
    pre_sense=_MONITOR,
    takes=("Robot",),
)
FLY_TO_ALTITUDE_FAKE = Skill(_TAKE_OFF, AssertEffects(seconds=2.0), driver="fake")

_LAND = SkillDescription(
    name="land",
    help="Lands at a landing place.",
    agent="Base",
    target="Place",
    params=(_BASE, _ROBOT, Param("Place", names.LANDING_PLACE, "Where to land.")),
    pre=(HAS_PART("Robot", "Base"), _FLYING, any_of(ROBOT_AT_LOCATION("Robot", "Place"), LOCATION_FREE("Place"))),
    post=(LANDED("Robot"), ROBOT_AT_LOCATION("Robot", "Place")),
    duration=15.0,
)
_DOWN = Sequence.of(
    Do.of("fly_to_place", base=P("Base"), robot=P("Robot"), location=P("Place")),
    Do.of("land_at", base=P("Base"), robot=P("Robot"), location=P("Place")),
)
LAND = Skill(_LAND, _DOWN, takes=("Robot",))
LAND_FAKE = Skill(_LAND, AssertEffects(seconds=5.0), driver="fake")

_CHARGE = SkillDescription(
    name="charge",
    help="Lands at a charging place and charges the battery there.",
    agent="Base",
    target="Place",
    params=(_BASE, _BATTERY, _ROBOT, Param("Place", names.CHARGING_PLACE, "Where to charge.")),
    pre=(*_OWN, any_of(ROBOT_AT_LOCATION("Robot", "Place"), LOCATION_FREE("Place"))),
    post=(LANDED("Robot"), ROBOT_AT_LOCATION("Robot", "Place"), _CHARGED),
    duration=120.0,
    limit=3600.0,
)
CHARGE = Skill(
    _CHARGE,
    Sequence.of(_DOWN, Do.of("recharge", battery=P("Battery"), robot=P("Robot"))),
    takes=("Robot",),
)
CHARGE_FAKE = Skill(_CHARGE, AssertEffects(seconds=30.0), driver="fake")
