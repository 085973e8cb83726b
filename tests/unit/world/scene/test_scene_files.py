"""Scene files: what is read, what is written, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.geometry import Pose
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene import load_scene, save_scene, scene_goals
from skiros_py.world.world import World

HEADER = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
scene:floor a sk:Floor .
"""


def scene_of(ontology: Ontology, folder: Path, text: str) -> World:
    path = folder / "mine.ttl"
    path.write_text(HEADER + text)
    return load_scene(ontology, path)


@pytest.mark.parametrize("name", ["kitting", "kitting_carried"])
def test_the_shipped_scenes_load_with_their_robot_and_goals(ontology: Ontology, root: Path, name: str) -> None:
    world = load_scene(ontology, root / "scenes" / f"{name}.ttl")

    assert world.instances("sk:Robot") == ("robot_1",)
    assert world.instances("kitting:Compartment") == ("kit_1_a", "kit_1_b", "kit_1_c", "kit_1_d")
    assert world.placement("robot_1") == Placement("sk:at", "unknown_location")
    assert scene_goals(world) == (
        "ObjectAtLocation(Alternator, kit_1_b)",
        "ObjectAtLocation(Compressor, kit_1_c)",
        "ObjectAtLocation(Starter, kit_1_a)",
    )


def test_an_import_is_found_among_other_files_at_hand(root: Path) -> None:
    ontology = Ontology.load([root / "ontologies" / "core.ttl", root / "ontologies" / "kitting.ttl"])

    world = load_scene(ontology, root / "scenes" / "kitting.ttl", [root / "ontologies"])

    assert world.has("gripper_1")


def test_an_import_that_is_not_at_hand_is_refused(root: Path) -> None:
    ontology = Ontology.load([root / "ontologies" / "core.ttl", root / "ontologies" / "kitting.ttl"])

    with pytest.raises(FileError, match=r"kitting\.ttl:12: imports <.*mobile_panda>, which no file at hand declares"):
        load_scene(ontology, root / "scenes" / "kitting.ttl")


def test_a_saved_scene_is_the_same_world_and_the_same_file(world: World, ontology: Ontology, tmp_path: Path) -> None:
    with world.transaction("look", "seen") as tx:
        tx.set("starter_1", "sk:pose", Pose.of(1.5, -0.25, 0.5, yaw=0.3))
        tx.set("starter_1", "sk:missing", False)
        tx.set("starter_1", "rdfs:comment", 'two\nlines "quoted"')
    save_scene(world, tmp_path / "one.ttl")

    again = load_scene(ontology, tmp_path / "one.ttl")
    save_scene(again, tmp_path / "two.ttl")

    assert (tmp_path / "one.ttl").read_text() == (tmp_path / "two.ttl").read_text()
    assert list(again.snapshot().statements()) == list(world.snapshot().statements())
    assert again.goals == world.goals
    assert again.value("starter_1", "rdfs:comment") == 'two\nlines "quoted"'
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.ttl", "two.ttl"]


def test_a_scene_that_cannot_be_written_is_a_file_error(world: World, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        save_scene(world, tmp_path / "nowhere" / "scene.ttl")


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        (
            "scene:a a kitting:Startr ; sk:on scene:floor .",
            6,
            "unknown class 'kitting:Startr'. Did you mean 'kitting:Star",
        ),
        ("scene:a a kitting:Starter ;\n sk:on scene:floo .", 7, "unknown individual 'floo'. Did you mean 'floor'"),
        ("scene:a a kitting:Starter ;\n sk:pose '1 2'^^sk:poseLiteral .", 7, "needs a pose"),
        ("scene:a a kitting:Starter ;\n sk:mass 1e400 .", 7, "needs a finite number"),
        ("scene:a a kitting:Starter ;\n sk:onn scene:floor .", 7, "unknown relation 'sk:onn'"),
        ("scene:a a kitting:Starter ;\n sk:on 3 .", 7, "sk:on needs an individual"),
        ("scene:a a kitting:Starter ;\n sk:mass scene:floor .", 7, "sk:mass needs a literal"),
        ("scene:a a kitting:Starter .", 6, "is nowhere"),
        ("scene:a sk:on scene:floor .", 6, "has no class"),
        ("scene:a a kitting:Starter , kitting:Kit ; sk:on scene:floor .", 6, "has 2 classes"),
        ("scene:a a kitting:Starter ; sk:mass 1 , 2 ; sk:on scene:floor .", 6, "has two values"),
        ("scene:a a kitting:Kit ; sk:on scene:floor ; sk:in scene:floor .", 6, "one of these, not all"),
        ("scene:a a kitting:Starter ; sk:heldBy scene:floor .", 6, "its object must be a sk:Gripper"),
        ("scene:a-b a kitting:Starter ; sk:on scene:floor .", 6, "is no id"),
        ("kitting:Crate a owl:Class .", 6, "belongs into an ontology file"),
        ("[] a kitting:Starter .", None, "nameless"),
        ("scene:this a sk:Scene ; sk:mass 1 .", 6, "scene:this has sk:goal"),
        ("scene:a a kitting:Starter", 6, "not Turtle"),
    ],
)
def test_a_wrong_scene_is_refused_with_its_line(
    ontology: Ontology, tmp_path: Path, text: str, line: int | None, says: str
) -> None:
    with pytest.raises(FileError) as caught:
        scene_of(ontology, tmp_path, text)

    assert says in caught.value.reason
    assert caught.value.line == line


def test_a_scene_needs_no_header_and_no_goal(ontology: Ontology, tmp_path: Path) -> None:
    world = scene_of(ontology, tmp_path, "scene:a a kitting:Starter , owl:NamedIndividual ; sk:on scene:floor .")

    assert (world.instances("sk:Manipulatable"), world.goals) == (("a",), ())
