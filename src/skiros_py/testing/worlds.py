"""Worlds in memory: from a few lines of Turtle, or from a scene by name or path."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

from skiros_py.config import find_scene, ontology_paths
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.plugins import load_reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.world import World

_CORE = "https://w3id.org/skiros-py/core"
_IRI = "https://w3id.org/skiros-py/scenes/in_memory"
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


def _completed(text: str, ontology: Ontology, imports: Sequence[str], robots: int) -> str:
    """Returns a whole scene file; its first lines all are one, so that the lines of the text keep their numbers."""
    own = set(re.findall(r"@prefix\s+([\w-]*):", text))
    prefixes = [f"@prefix {p}: <{iri}> ." for p, iri in ontology.names.prefixes.items() if p not in own]
    imported = " , ".join(f"<{iri}>" for iri in (_CORE, *imports))
    roots = [statement for class_, statement in _ROOTS.items() if not re.search(rf"\ba\s+{class_}\b", text)]
    head = [*prefixes, f"<{_IRI}> a owl:Ontology ; owl:imports {imported} ."]
    tail = [*roots, *(robot_turtle(n) for n in range(1, robots + 1))]
    return " ".join(head) + " " + "\n".join([text, *tail]) + "\n"
