"""A world in two lines: one robot, two boxes with balls, two slots."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from skiros_py.config import ontology_paths
from skiros_py.testing.worlds import robot_turtle
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner
from skiros_py.world.reasoners.spatial import SpatialReasoner
from skiros_py.world.scene import load_scene
from skiros_py.world.world import World

TINY_ONTOLOGY = Path(__file__).parent / "tiny.ttl"
"""The file of the tiny domain; add it to ``SKIROS_ONTOLOGIES`` to run tiny scenes from the command line."""

_SCENE = """\
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .

<https://w3id.org/skiros-py/scenes/tiny> a owl:Ontology ;
    owl:imports <https://w3id.org/skiros-py/core> , <https://w3id.org/skiros-py/testing/tiny> .

scene:this a sk:Scene ; rdfs:label "tiny" .
scene:floor a sk:Floor ; rdfs:label "floor" .
scene:unknown_location a sk:UnknownLocation ; rdfs:label "unknown location" .
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
    parts = [_SCENE, *(robot_turtle(n) for n in range(1, robots + 1)), *facts, *aims]
    file = folder / "tiny.ttl"
    file.write_text("\n".join(parts) + "\n", encoding="utf-8")
    return file


def tiny_world(*facts: str, robots: int = 1) -> World:
    """Returns the tiny scene as a live world with the built-in reasoners; see :func:`tiny_scene`."""
    reasoners = Reasoners((SizeReasoner(), SpatialReasoner()))
    with tempfile.TemporaryDirectory(prefix="skiros-tiny-") as folder:
        return load_scene(tiny_ontology(), tiny_scene(Path(folder), *facts, robots=robots), reasoners=reasoners)
