"""Scene files: what is read, what is written, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.geometry import Pose
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene, save_scene
from skiros_py.world.world import World

HEADER = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> . @prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
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
    assert world.goals == (
        "ObjectAtLocation(Alternator, kit_1_b)",
        "ObjectAtLocation(Compressor, kit_1_c)",
        "ObjectAtLocation(Starter, kit_1_a)",
    )


CRANE = """@prefix owl: <http://www.w3.org/2002/07/owl#> . @prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix scene: <https://w3id.org/skiros-py/scene#> .
<http://example.org/robots/crane> a owl:Ontology .
scene:crane_1 a sk:Robot ; sk:at scene:floor ; sk:startLocation scene:floor .
"""
WITH_CRANE = """<> a owl:Ontology ; owl:imports <http://example.org/robots/crane> .
"""


def test_an_import_is_found_among_the_given_files(ontology: Ontology, tmp_path: Path) -> None:
    folder = tmp_path / "robots"
    folder.mkdir()
    (folder / "crane.ttl").write_text(CRANE)
    (tmp_path / "mine.ttl").write_text(HEADER + WITH_CRANE)

    world = load_scene(ontology, tmp_path / "mine.ttl", [folder])

    assert world.has("crane_1")


def test_the_individuals_of_a_robot_are_found_by_its_entry_point(ontology: Ontology, root: Path) -> None:
    world = load_scene(ontology, root / "scenes" / "kitting.ttl")

    assert world.has("gripper_1")


def test_an_import_without_a_file_is_refused(ontology: Ontology, tmp_path: Path) -> None:
    (tmp_path / "mine.ttl").write_text(HEADER + WITH_CRANE)

    with pytest.raises(FileError, match=r"mine\.ttl:\d+: imports <.*robots/crane>, which no file at hand declares"):
        load_scene(ontology, tmp_path / "mine.ttl")


def test_where_a_robot_is_misspelt_the_robots_that_exist_are_named(ontology: Ontology, tmp_path: Path) -> None:
    (tmp_path / "mine.ttl").write_text(HEADER + WITH_CRANE)

    with pytest.raises(FileError) as caught:
        load_scene(ontology, tmp_path / "mine.ttl")

    robots = caught.value.reason.partition("; robots: ")[2]
    assert "<https://w3id.org/skiros-py/robots/mobile_panda>" in robots
    assert "<https://w3id.org/skiros-py/robots/ur10e_cell>" in robots


def test_all_missing_imports_of_a_scene_are_named_at_once(ontology: Ontology, tmp_path: Path) -> None:
    more = " <> owl:imports <http://example.org/one>, <http://example.org/two> .\n"
    (tmp_path / "mine.ttl").write_text(HEADER + WITH_CRANE + more)

    with pytest.raises(FileError) as caught:
        load_scene(ontology, tmp_path / "mine.ttl")

    assert (
        "imports <http://example.org/one>, <http://example.org/robots/crane>, <http://example.org/two>, which no"
        in (caught.value.reason)
    )
    assert "put an ontology into a folder of SKIROS_ONTOLOGIES" in caught.value.reason


def test_a_saved_scene_loads_as_the_same_world_and_saves_as_the_same_file(
    world: World, ontology: Ontology, tmp_path: Path
) -> None:
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
        ("scene:a a kitting:Starter ;\n sk:mass 1e400 .", 7, "a: sk:mass needs a finite number"),
        ("scene:a a kitting:Starter ;\n sk:onn scene:floor .", 7, "unknown relation 'sk:onn'"),
        ("scene:a a kitting:Starter ;\n sk:on 3 .", 7, "sk:on needs an individual"),
        ("scene:a a kitting:Starter ;\n sk:mass scene:floor .", 7, "sk:mass needs a literal"),
        ("scene:a a kitting:Starter .", 6, "is nowhere"),
        ("scene:a sk:on scene:floor .", 6, "has no class"),
        ("scene:a a kitting:Starter , kitting:Kit ; sk:on scene:floor .", 6, "has 2 classes"),
        ("scene:a a kitting:Starter ; sk:mass 1 , 2 ; sk:on scene:floor .", 6, "a: sk:mass has two values"),
        ("scene:a a kitting:Kit ; sk:on scene:floor ; sk:in scene:floor .", 6, "one of these, not all"),
        ("scene:a a kitting:Starter ; sk:heldBy scene:floor .", 6, "its object must be a sk:Gripper"),
        ("scene:a-b a kitting:Starter ; sk:on scene:floor .", 6, "is no id"),
        ("scene:a a kitting:Kit ; sk:in scene:floor .\nscene:a sk:on scene:floor .", 7, "one of these, not all"),
        ("scene:a a kitting:Starter ;\n sk:on scene:floor ;\n sk:maxGap 0.1 .", 8, "belongs to a sk:Gripper"),
        ("scene:a a kitting:Starter ;\n sk:on scene:floor ;\n sk:hasSkill scene:a .", 8, "its subject must be"),
        ("scene:a a kitting:Starter ;\n sk:on scene:floor ;\n sk:near scene:floor .", 8, "computed by a reasoner"),
        ("scene:a a kitting:Kit ;\n sk:placement scene:floor .", 6, "does not place a"),
        ("scene:a a kitting:Kit ; sk:on scene:b .\nscene:b a kitting:Kit ; sk:on scene:a .", 6, "is inside itself"),
        ("scene:a a kitting:Kit ; sk:on scene:floor ;\n sk:poseFrame scene:floor , scene:a .", 7, "one of these"),
        ("scene:a a kitting:Starter ;\n sk:mass 'NaN'^^xsd:double .", 7, "needs a finite number"),
        ("scene:a a kitting:Starter ;\n sk:pose 'inf 0 0 0 0 0'^^sk:poseLiteral .", 7, "finite numbers"),
        ("scene:a a kitting:Starter ;\n sk:size '1 nan'^^sk:vectorLiteral .", 7, "finite numbers"),
        ("scene:a a kitting:Starter ;\n sk:missing 'yes' .", 7, "needs true or false"),
        ("scene:a a kitting:Starter ; sk:on kitting:Kit .", 6, "unknown individual 'kitting:Kit'"),
        ("scene:this a kitting:Kit .", 6, "stands for the scene itself"),
        ("scene:a a sk:Scene .", 6, "is no sk:Element"),
        ("scene:a a owl:Class .", 6, "makes a term of the ontology"),
        ("scene:a a [] ; sk:on scene:floor .", 6, "must have a name"),
        ("scene:a a kitting:Starter ; sk:on [] .", 6, "has a name"),
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


def test_all_faults_are_reported_at_once_with_their_lines(ontology: Ontology, tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught:
        scene_of(ontology, tmp_path, "scene:a a kitting:Starter .\nscene:b a kitting:Kit ; sk:heldBy scene:floor .")

    assert caught.value.line == 6
    assert "mine.ttl:6: a (kitting:Starter) is nowhere" in caught.value.reason
    assert "mine.ttl:7: b sk:heldBy floor: its subject must be" in caught.value.reason


def test_a_long_list_of_faults_is_cut_off_with_the_number_of_the_rest(ontology: Ontology, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="and 190 more") as caught:
        scene_of(ontology, tmp_path, "\n".join(f"scene:a_{n} a kitting:Starter ." for n in range(200)))

    assert len(caught.value.reason) < 3000


def test_a_fault_of_an_imported_file_names_that_file(ontology: Ontology, tmp_path: Path) -> None:
    robot = tmp_path / "robot.ttl"
    robot.write_text(
        f"{HEADER}<https://example.org/robot> a owl:Ontology .\n"
        "scene:robot_1 a sk:Robot ; sk:at scene:floor ;\n sk:hasA scene:arm_9 .",
        encoding="utf-8",
    )
    path = tmp_path / "mine.ttl"
    path.write_text(f"{HEADER}<https://example.org/mine> a owl:Ontology ; owl:imports <https://example.org/robot> .\n")

    with pytest.raises(FileError, match=r"robot\.ttl:8: unknown individual 'arm_9'"):
        load_scene(ontology, path, [tmp_path])


LABELS = [
    """'both" kinds of quotes""",
    '"} ; DROP ALL ; INSERT DATA { ?s ?p ?o . #',
    "?x sk:on ?y . FILTER(?x)",
    "\\",
    "a\tb\r\nc",
    "\u2028\x85\x0c",
]


@pytest.mark.parametrize("label", LABELS)
def test_a_label_that_looks_like_a_query_is_just_a_label(world: World, tmp_path: Path, label: str) -> None:
    with world.transaction("test", "an odd label") as tx:
        tx.set("starter_1", "rdfs:label", label)
    save_scene(world, tmp_path / "odd.ttl")

    assert load_scene(world.ontology, tmp_path / "odd.ttl").element("starter_1").label == label


BROKEN = {
    "a literal of a megabyte": ("scene:a a kitting:Starter ; rdfs:label '" + "x" * 2**20 + "' .").encode(),
    "UTF-16": "scene:a a kitting:Starter .".encode("utf-16"),
    "rubbish": bytes(range(256)) * 10,
    "nested deep": b"scene:a a kitting:Starter ; sk:on " + b"[ sk:on " * 10_000 + b"]" * 10_000 + b" .",
    "lists in lists": b"scene:a a kitting:Starter ; sk:on " + b"( " * 10_000 + b") " * 10_000 + b" .",
    "truncated": b"scene:a a kitting:Starter ; sk:on scene:fl",
    "an id of 300 letters": b"scene:" + b"a" * 300 + b" a kitting:Starter ; sk:on scene:floor .",
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_file_that_is_not_a_scene_is_refused_with_a_short_message(
    ontology: Ontology, tmp_path: Path, what: str
) -> None:
    path = tmp_path / "broken.ttl"
    path.write_bytes(
        HEADER.replace("@prefix", "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> . @prefix", 1).encode()
        + BROKEN[what]
    )

    with pytest.raises(FileError) as caught:
        load_scene(ontology, path)

    assert len(str(caught.value)) < 1000


XML = """<?xml version="1.0"?>
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" xmlns:sk="https://w3id.org/skiros-py/core#"
  xmlns:kitting="https://w3id.org/skiros-py/kitting#" xmlns:owl="http://www.w3.org/2002/07/owl#"
  xmlns:scene="https://w3id.org/skiros-py/scene#">
  <owl:Ontology rdf:about="https://example.org/scenes/mine"/>
  <owl:AnnotationProperty rdf:about="https://w3id.org/skiros-py/core#placeEnd"/>
  <owl:Class rdf:about="https://w3id.org/skiros-py/kitting#Starter"/>
  <sk:Floor rdf:about="https://w3id.org/skiros-py/scene#floor"/>
  <owl:NamedIndividual rdf:about="https://w3id.org/skiros-py/scene#a">
    <rdf:type rdf:resource="https://w3id.org/skiros-py/kitting#Starter"/>
    <sk:on rdf:resource="https://w3id.org/skiros-py/scene#FLOOR"/>
  </owl:NamedIndividual>
</rdf:RDF>
"""


def test_a_scene_may_be_written_by_an_editor_as_rdf_xml(ontology: Ontology, tmp_path: Path) -> None:
    path = tmp_path / "mine.owl"
    path.write_text(XML.replace("FLOOR", "floor"), encoding="utf-8")

    assert load_scene(ontology, path).placement("a") == Placement("sk:on", "floor")


def test_a_fault_in_rdf_xml_has_a_line_too(ontology: Ontology, tmp_path: Path) -> None:
    path = tmp_path / "mine.owl"
    path.write_text(XML, encoding="utf-8")

    with pytest.raises(FileError, match=r"mine\.owl:11: unknown individual 'FLOOR'. Did you mean 'floor'"):
        load_scene(ontology, path)


def test_a_saved_scene_does_not_import_the_robot_that_is_in_it_a_second_time(root: Path, tmp_path: Path) -> None:
    robot = tmp_path / "robot.ttl"
    robot.write_text(
        f"{HEADER}@prefix my: <https://example.org/my#> .\n"
        "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
        "<https://example.org/my> a owl:Ontology . my:Rover a owl:Class ; rdfs:subClassOf sk:Robot .\n"
        "scene:rover_1 a my:Rover ; sk:on scene:floor .",
        encoding="utf-8",
    )
    scene = tmp_path / "mine.ttl"
    scene.write_text(
        f"{HEADER}<https://example.org/mine> a owl:Ontology ; owl:imports <https://example.org/my> ."
        " scene:pallet_a a kitting:Pallet ; sk:on scene:floor .",
        encoding="utf-8",
    )
    ontology = Ontology.load([root / "ontologies", robot])
    world = load_scene(ontology, scene)
    with world.transaction("drive", "arrived") as tx:
        tx.place("rover_1", "sk:at", "pallet_a")

    save_scene(world, tmp_path / "saved.ttl")

    assert load_scene(ontology, tmp_path / "saved.ttl").placement("rover_1") == Placement("sk:at", "pallet_a")
