"""What an author can order from ``skiros new``: a class for each command, with a field for each of its options.

The docstring of a class is the help of its command. Nothing heavy is imported, so that help is fast.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

_Sets = tuple[tuple[str, ...], ...]


def _option(flag: str, metavar: str, help_: str, such_as: str = "", default: Any = "", **asked: Any) -> Any:
    """Returns a field that is an option of the command.

    Args:
        flag: The option ("--param").
        metavar: Its value ("KEY:CLASS"); empty for a switch.
        help_: Its help, without the full stop.
        such_as: An example of a value: people on a terminal are asked for one.
        default: The default; a tuple for a repeatable option.
        **asked: ``needed``: True if people must answer; ``unless``: the field that makes the question superfluous.
    """
    question = f"{help_} (such as {such_as})" if such_as else ""
    text = f"{help_}; may be repeated." if default == () else f"{help_}."
    if isinstance(default, str):
        text += f"  [default: {default}]" if default else ""
    return field(default=default, metadata={"flag": flag, "metavar": metavar, "help": text, "ask": question, **asked})


def _options(flag: str, metavar: str, help_: str, such_as: str = "") -> Any:
    return _option(flag, metavar, help_, such_as, ())


def is_urdf(name: str) -> bool:
    """Returns whether a robot is named by a URDF file, or by one in a package ("pybullet_data:husky/husky.urdf")."""
    return name.lower().endswith(".urdf") or ":" in name


def _robot() -> Any:
    return _option("--robot", "NAME", "The robot there", default="mobile_panda")


@dataclass(frozen=True, slots=True)
class Order:
    """What all commands take.

    Attributes:
        name: Its name.
        help: One sentence; derived from the name if omitted.
    """

    example: ClassVar[str]
    enough: ClassVar[_Sets] = ((),)
    """Sets of options; if all of one are given, nothing is asked."""

    name: str
    help: str = _option("--help-text", "TEXT", "Description in one sentence")


@dataclass(frozen=True, slots=True)
class NewPackage(Order):
    """Writes an ordinary Python distribution NAME with one of everything."""

    example = "package my_scanning"

    skill: str = _option("--skill", "NAME", "Its first skill; by default NAME_inspect")
    primitive: str = _option("--primitive", "NAME", "Its first primitive; by default NAME_look_at")
    condition: str = _option("--condition", "NAME", "Its first condition; by default NameInspected")


@dataclass(frozen=True, slots=True)
class NewSkill(Order):
    """Writes a skill NAME, with a test that plans and executes it.

    With the agent come a parameter for it, one for its robot, and the condition that the robot has it.
    """

    example = (
        "skill scan --agent sk:Arm --param part:sk:Manipulatable --param station:sk:Station"
        " --pre 'RobotAtLocation(robot, station)' --post 'Scanned(part)'"
    )
    enough: ClassVar[_Sets] = (("agent", "post"),)

    agent: str = _option("--agent", "CLASS", "Class of the subsystem that does it", "sk:Arm", needed=True)
    params: tuple[str, ...] = _options(
        "--param", "KEY:CLASS", "A parameter, perhaps with ' -- HELP'", "part:sk:Manipulatable"
    )
    pre: tuple[str, ...] = _options("--pre", "CONDITION", "What must hold before", "RobotAtLocation(robot, station)")
    post: tuple[str, ...] = _options("--post", "CONDITION", "What holds after it", "Inspected(part)")
    do: tuple[str, ...] = _options(
        "--do", "PRIMITIVE", "What it does, in order; by default, what you write into it", "look_at"
    )
    target: str = _option("--target", "KEY", "The parameter it is done to")
    robot: str = _robot()


@dataclass(frozen=True, slots=True)
class NewPrimitive(Order):
    """Writes a primitive NAME that runs on a fake robot, ready for what the device does."""

    example = "primitive read_code --param camera:sk:Camera --param 'seconds:number=1 [s]'"
    enough: ClassVar[_Sets] = (("params",),)

    params: tuple[str, ...] = _options(
        "--param",
        "KEY:TYPE",
        "A parameter of a class, or 'KEY:number=DEFAULT [UNIT]', perhaps with ' -- HELP'",
        "camera:sk:Camera",
    )
    robot: str = _robot()


@dataclass(frozen=True, slots=True)
class NewCondition(Order):
    """Writes a condition NAME: a word for goals and skills, made of a relation or a property."""

    example = "condition Scanned --role part:sk:Manipulatable --property scanning:scanned"
    enough: ClassVar[_Sets] = (("property",), ("relation",))

    roles: tuple[str, ...] = _options("--role", "KEY:CLASS", "An argument; without, those of the relation or property")
    property: str = _option("--property", "PROPERTY", "The property it is about", "my_scanning:inspected")
    value: str = _option("--value", "VALUE", "What the property must be; by default true, or anything")
    relation: str = _option(
        "--relation", "RELATION", "The relation it is about", "sk:in", needed=True, unless="property"
    )
    abstract: bool = _option("--abstract", "", "A goal may give a class: any thing of it", default=False)


@dataclass(frozen=True, slots=True)
class NewOntology(Order):
    """Writes an ontology NAME, whose words have the prefix NAME."""

    example = "ontology scanning --class Scanner:sk:Device --property scanned:sk:Object:boolean"
    enough: ClassVar[_Sets] = (("classes",), ("relations",), ("properties",))

    classes: tuple[str, ...] = _options(
        "--class", "NAME:PARENT", "A class, perhaps with ' -- HELP'", "Scanner:sk:Device"
    )
    relations: tuple[str, ...] = _options(
        "--relation", "NAME:DOMAIN:RANGE", "A relation", "scannedAt:sk:Manipulatable:sk:Station"
    )
    properties: tuple[str, ...] = _options(
        "--property",
        "NAME:DOMAIN:TYPE",
        "A property: boolean, number, integer, text, pose, vector or class",
        "scanned:sk:Manipulatable:boolean",
    )


@dataclass(frozen=True, slots=True)
class NewRobot(Order):
    """Writes a robot NAME: the individuals of a mobile manipulator, for scenes to import.

    With a URDF file, or PACKAGE:PATH of an installed package, as NAME: a whole robot on a pedestal, with a scene in
    which it picks and places; outside of a package, as a distribution of its own. What the file lacks is asked for.
    """

    example = "robot loader --start dock --limit max-linear=0.5"

    start: str = _option("--start", "ID", "Where it is", default="unknown_location")
    limits: tuple[str, ...] = _options(
        "--limit", "NAME=VALUE", "max-linear, max-angular, max-gap, max-force, max-linear-acceleration, …"
    )
    model: str = _option("--model", "MODEL", "What drivers build", default="mobile_panda")
    called: str = _option("--name", "NAME", "Name of a robot from a URDF; derived from it if omitted")
    arm: str = _option("--arm", "'BASE_LINK TIP_LINK'", "First and last link of its arm; found if omitted")
    gripper: str = _option(
        "--gripper", "'LINK LINK'", "Links of its two fingers, or 'parallel' to mount a plain gripper; found if omitted"
    )
    base: str = _option(
        "--base", "KIND", "A base under its arm, 'differential' or 'omnidirectional'; a pedestal if omitted"
    )
    srdf: str = _option("--srdf", "FILE", "Its SRDF; one beside the URDF is found")


@dataclass(frozen=True, slots=True)
class NewScene(Order):
    """Writes a scene NAME with a robot, things and a goal."""

    example = "scene scan_cell --thing part:sk:Manipulatable --goal 'Inspected(part)'"
    enough: ClassVar[_Sets] = (("things",),)

    robot: str = _robot()
    things: tuple[str, ...] = _options("--thing", "KEY:CLASS", "Something that is there", "part:sk:Manipulatable")
    goals: tuple[str, ...] = _options("--goal", "CONDITION", "What is wanted, over the things", "Inspected(part)")
