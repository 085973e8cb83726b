"""A world in two lines: one robot, two boxes with balls, two slots; with pretended skills."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType

from skiros_py.behaviours import AssertEffects, Behaviour
from skiros_py.config import find_scene, ontology_paths
from skiros_py.skills.conditions import (
    Computed,
    ConditionType,
    Has,
    Nothing,
    Pattern,
    Related,
    Role,
    Verdict,
)
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.registry import Reasoners, load_reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner
from skiros_py.world.reasoners.spatial import SpatialReasoner
from skiros_py.world.scene.files import load_scene
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, DRIVING_POSE, HAS_A, HELD_BY, IN
from skiros_py.world.world import World

_CORE = "https://w3id.org/skiros-py/core"
_TINY = "https://w3id.org/skiros-py/testing/tiny"
_SCENES = "https://w3id.org/skiros-py/scenes"
_IRI = f"{_SCENES}/in_memory"
_ROOTS = {
    "sk:Scene": 'scene:this a sk:Scene ; rdfs:label "test" .',
    "sk:Floor": 'scene:floor a sk:Floor ; rdfs:label "floor" .',
    "sk:UnknownLocation": 'scene:unknown_location a sk:UnknownLocation ; rdfs:label "unknown location" .',
}
"""Elements of every scene; added if the text does not define them."""

_ROBOT = """
scene:robot_{n} a sk:Robot ; rdfs:label "robot {n}" ; sk:model "tiny" ; sk:at scene:unknown_location ;
    sk:hasA scene:base_{n} , scene:arm_{n} .
scene:base_{n} a sk:Base ; rdfs:label "base {n}" ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ;
    sk:maxLinear 1.0 ; sk:maxAngular 1.0 ; sk:maxLinearAcceleration 1.0 ; sk:maxAngularAcceleration 1.0 ;
    sk:footprint "-0.3 -0.3 0.3 -0.3 0.3 0.3 -0.3 0.3"^^sk:vectorLiteral .
scene:arm_{n} a sk:Arm ; rdfs:label "arm {n}" ; sk:joints "shoulder elbow" ; sk:tip "tip" ;
    sk:home "0 0"^^sk:vectorLiteral ; sk:hasA scene:gripper_{n} .
scene:gripper_{n} a sk:Gripper ; rdfs:label "gripper {n}" ; sk:joints "finger" ; sk:maxGap 0.1 ; sk:maxForce 10.0 .
"""


def world_of(
    scene: str | Path, *, ontologies: Sequence[Path] = (), imports: Sequence[str] = (), robots: int = 1
) -> World:
    """Creates a live world, with the installed ontologies and reasoners; nothing is stored on disk.

    >>> world = world_of("scene:box_1 a sk:Container ; sk:on scene:floor .")
    >>> world.objects("box_1", "sk:on")
    ('floor',)

    Args:
        scene: Turtle statements, or the name or path of a scene. Turtle needs no prefixes of the ontologies at hand, no
            floor, no unknown_location and no robot.
        ontologies: Files or folders of further ontologies.
        imports: IRIs of files whose individuals become part of a world given as Turtle, such as
            ``https://w3id.org/skiros-py/robots/mobile_panda``; then omit ``robots``.
        robots: How many small robots a world given as Turtle gets: robot_1 with base_1, arm_1, gripper_1, and so on
            (:func:`robot_turtle`).

    Raises:
        UnknownName: There is no scene of that name.
        FileError: A file or the text cannot be understood, or says what the ontology does not allow; lines of a text
            are counted from its own first line.
    """
    paths = (*ontology_paths(), *ontologies)
    ontology, _ = load_installed(paths)
    reasoners, _ = load_reasoners(ontology)
    if isinstance(scene, Path) or not _is_turtle(scene):
        return load_scene(ontology, find_scene(str(scene)), paths, reasoners=reasoners)
    text = _completed(scene, ontology, imports, 0 if imports else robots)
    with tempfile.TemporaryDirectory(prefix="skiros-world-") as folder:
        file = Path(folder) / "scene.ttl"
        file.write_text(text, encoding="utf-8")
        return load_scene(ontology, file, paths, reasoners=reasoners)


def robot_turtle(number: int = 1) -> str:
    """Returns a small robot as Turtle: robot_N at unknown_location, with base_N, arm_N (two joints) and gripper_N."""
    return _ROBOT.format(n=number)


def _is_turtle(scene: str) -> bool:
    return any(character.isspace() for character in scene.strip()) or not scene.strip()


def _completed(text: str, ontology: Ontology, imports: Sequence[str], robots: int, iri: str = _IRI) -> str:
    """Returns a whole scene file; its first lines all are one, so that the lines of the text keep their numbers."""
    own = set(re.findall(r"@prefix\s+([\w-]*):", text))
    prefixes = [f"@prefix {p}: <{space}> ." for p, space in ontology.names.prefixes.items() if p not in own]
    imported = " , ".join(f"<{file}>" for file in (_CORE, *imports))
    roots = [statement for class_, statement in _ROOTS.items() if not re.search(rf"\ba\s+{class_}\b", text)]
    head = [*prefixes, f"<{iri}> a owl:Ontology ; owl:imports {imported} ."]
    tail = [*roots, *(robot_turtle(n) for n in range(1, robots + 1))]
    return " ".join(head) + " " + "\n".join([text, *tail]) + "\n"


def _fits(view: WorldView, ball: str, slot: str) -> Verdict:
    giant = view.ontology.is_a(view.element(ball).type, "tiny:Giant")
    return Verdict(not giant, f"{ball} {'does not fit' if giant else 'fits'} into {slot}")


def _word(name: str, pattern: Pattern, help_: str, /, *, abstract: bool = False, **roles: str) -> ConditionType:
    return ConditionType(name, tuple(Role(role, class_) for role, class_ in roles.items()), pattern, help_, abstract)


HAS_PART = _word("HasPart", Related(HAS_A, "whole", "part"), "-", whole="sk:SpatialThing", part="sk:SpatialThing")
AT_LOCATION = _word("At", Related(AT, "robot", "location"), "Stands.", robot="sk:Robot", location="sk:Location")
REACHABLE = _word("Reachable", Has(DRIVING_POSE, "location"), "Known way.", location="sk:Location")
IN_CONTAINER = _word(
    "In", Related(IN, "ball", "place"), "Lies in.", abstract=True, ball="tiny:Ball", place="sk:Container"
)
HOLDING = _word("Holding", Related(HELD_BY, "ball", "gripper"), "Has it.", gripper="sk:Gripper", ball="tiny:Ball")
EMPTY_HANDED = _word("EmptyHanded", Nothing(HELD_BY, "gripper"), "Holds nil.", gripper="sk:Gripper")
FREE = _word("Free", Nothing(IN, "slot"), "Nothing lies in the slot.", slot="tiny:Slot")
FITS = _word("Fits", Computed("tiny:fitsIn", "ball", "slot", _fits), "-", ball="tiny:Ball", slot="tiny:Slot")
CARRIES = _word("Carries", Related("tiny:carries", "robot", "ball"), "Rides.", robot="sk:Robot", ball="tiny:Ball")

CONDITIONS: Mapping[str, ConditionType] = MappingProxyType(
    {
        word.name: word
        for word in (HAS_PART, AT_LOCATION, REACHABLE, IN_CONTAINER, HOLDING, EMPTY_HANDED, FREE, FITS, CARRIES)
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


TINY_ONTOLOGY = Path(__file__).parent / "tiny.ttl"
"""The file of the tiny domain; add it to ``SKIROS_ONTOLOGIES`` to run tiny scenes from the command line."""

_SCENE = """\
scene:this a sk:Scene ; rdfs:label "tiny" .
scene:box_a a tiny:Box ; rdfs:label "box A" ; sk:on scene:floor .
scene:box_b a tiny:Box ; rdfs:label "box B" ; sk:on scene:floor .
scene:slot_1 a tiny:Slot ; rdfs:label "slot 1" ; sk:on scene:floor .
scene:slot_2 a tiny:Slot ; rdfs:label "slot 2" ; sk:on scene:floor .
scene:ball_1 a tiny:Ball ; rdfs:label "ball one" ; sk:in scene:box_a .
scene:red_ball_1 a tiny:RedBall ; rdfs:label "red ball one" ; sk:in scene:box_b .
"""


@cache
def tiny_ontology() -> Ontology:
    """Returns the upper ontology with the tiny domain."""
    return Ontology.load((ontology_paths()[0] / "core.ttl", TINY_ONTOLOGY))


def tiny_scene(folder: Path, *facts: str, robots: int = 1, goals: tuple[str, ...] = ()) -> Path:
    """Writes the tiny scene as ``tiny.ttl`` and returns the file.

    Args:
        folder: Where to write it.
        *facts: More Turtle statements ("scene:ball_2 a tiny:Ball ; sk:in scene:box_a .").
        robots: How many robots there are: robot_1 with base_1, arm_1, gripper_1, and so on.
        goals: Goals that go with the scene.
    """
    aims = [f'scene:this sk:goal "{goal}" .' for goal in goals]
    text = _completed("\n".join([_SCENE, *facts, *aims]), tiny_ontology(), [_TINY], robots, f"{_SCENES}/tiny")
    file = folder / "tiny.ttl"
    file.write_text(text, encoding="utf-8")
    return file


def tiny_world(*facts: str, robots: int = 1) -> World:
    """Returns the tiny scene as a live world with the built-in reasoners; see :func:`tiny_scene`."""
    reasoners = Reasoners((SizeReasoner(), SpatialReasoner()))
    with tempfile.TemporaryDirectory(prefix="skiros-tiny-") as folder:
        return load_scene(tiny_ontology(), tiny_scene(Path(folder), *facts, robots=robots), reasoners=reasoners)
